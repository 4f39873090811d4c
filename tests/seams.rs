//! Seams: what slides over flush outlines feels none.

use nonsmooth::laws;
use nonsmooth::scheme::{Settings, ThetaScheme};
use nonsmooth::solver::{self, Stopping};
use nonsmooth::system::{Body, BodyId, GroupId, RigidBodies, RigidBodiesBuilder};

const G: f64 = 9.81;
const H: f64 = 1e-3;

type Scheme = ThetaScheme<f64, 2>;

/// What slides.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Slider {
    Disc,
    Point,
    Box,
}

/// What carries it: the right ends and the heights of tiles that begin at x = −1.
#[derive(Debug, Clone, Copy)]
enum Ground {
    /// Welded to the ground.
    Fixed(&'static [(f64, f64)]),
    /// Standing on a floor.
    Standing(&'static [(f64, f64)]),
}

fn rectangle(builder: &mut RigidBodiesBuilder<f64>, name: &str, [x, y]: [f64; 2], group: GroupId) -> BodyId {
    let mass = 1000.0 * 4.0 * x * y;
    let body = builder.body(name, Body { mass, inertia: mass * (x * x + y * y) / 3.0 }).expect("positive");
    let corners = [[-x, -y], [x, -y], [x, y], [-x, y]];
    builder.polygon(name, body, &corners, group).expect("convex");
    body
}

/// The slider at x = 0 above tops at y = 0, at `speed`.
fn scene(slider: Slider, ground: Ground, law: &str, (e, mu): (f64, f64), speed: f64) -> Scheme {
    let mut builder = RigidBodies::builder();
    let (sliding, tiles, floor) = (builder.group(), builder.group(), builder.group());
    let (mut q, mut v) = (Vec::new(), Vec::new());
    let half = match slider {
        Slider::Disc => 0.1,
        Slider::Point => 0.0,
        Slider::Box => 0.05,
    };
    if slider == Slider::Box {
        rectangle(&mut builder, "slider", [0.2, half], sliding);
    } else {
        let body = builder.body("slider", Body { mass: 1.0, inertia: 0.005 }).expect("positive");
        builder.disc("slider", body, [0.0; 2], half, sliding).expect("a radius");
    }
    q.extend([0.0, half, 0.0]);
    v.extend([speed, 0.0, 0.0]);
    let (Ground::Fixed(list) | Ground::Standing(list)) = ground;
    let mut left = -1.0;
    for (i, &(right, top)) in list.iter().enumerate() {
        let sides = [0.5 * (right - left), 0.5 * (top + 1.0)];
        let name = format!("tile {i}");
        let body = rectangle(&mut builder, &name, sides, tiles);
        let centre = [0.5 * (left + right), top - sides[1]];
        if let Ground::Fixed(_) = ground {
            builder.weld(&name, body, [0.0; 2], None, centre, 0.0).expect("a weld");
        }
        q.extend([centre[0], centre[1], 0.0]);
        v.extend([0.0; 3]);
        left = right;
    }
    builder.half_plane("floor", [0.0, -1.0], [0.0, 1.0], floor).expect("a plane");
    builder.interface(sliding, tiles).expect("two groups");
    if let Ground::Standing(_) = ground {
        builder.interface(tiles, floor).expect("two groups");
    }
    builder.gravity([0.0, -G]).expect("finite");
    let count = if matches!(ground, Ground::Standing(_)) { 2 } else { 1 };
    let law = |i: usize| laws::build(law, &[e, if i == 0 { mu } else { 0.5 }]).expect("registered");
    let solver = solver::build(solver::DEFAULT, Stopping::default()).expect("registered");
    let settings = Settings { allow_unproved_theta: true, ..Settings::new(0.5, H) };
    let system = builder.build().expect("a scene");
    ThetaScheme::new(Box::new(system), (0..count).map(law).collect(), solver, settings, 0.0, q, v)
        .expect("a setup")
}

/// Steps until x = 2.5 or the time is up: largest |y − y₀|, |v_y| and turn of the slider.
fn slide(scheme: &mut Scheme, steps: usize) -> [f64; 3] {
    let start = scheme.state().q[1];
    let mut largest = [0.0_f64; 3];
    for _ in 0..steps {
        scheme.step().expect("a slide");
        let state = scheme.state();
        for (most, x) in largest.iter_mut().zip([state.q[1] - start, state.v[1], state.q[2]]) {
            *most = most.max(x.abs());
        }
        if state.q[0] > 2.5 {
            break;
        }
    }
    largest
}

const CUBES: &[(f64, f64)] = &[(1.0, 0.0), (3.0, 0.0)];
const TILES: &[(f64, f64)] = &[(0.3, 0.0), (0.45, 0.0), (1.1, 0.0), (1.2, 0.0), (3.0, 0.0)];

#[test]
fn a_slider_feels_no_seam() {
    for ground in [Ground::Fixed(CUBES), Ground::Fixed(TILES), Ground::Standing(CUBES)] {
        for slider in [Slider::Disc, Slider::Point, Slider::Box] {
            for law in ["newton", "fremond"] {
                for e in [0.0, 0.5, 1.0] {
                    for speed in [5.0, 1.234_567] {
                        let mut scheme = scene(slider, ground, law, (e, 0.0), speed);
                        let [y, v, turn] = slide(&mut scheme, 2100);
                        let what = format!("{slider:?}, {ground:?}, {law}, e = {e}, {speed} m/s");
                        assert!(scheme.state().q[0] > 2.0, "{what}: it got to {}", scheme.state().q[0]);
                        // Solvers leave 1e-10 of b, and with it of the speed at which the slider passes.
                        assert!(
                            y <= 1e-9 && v <= 4e-9 * speed && turn <= 1e-9,
                            "{what}: {y:e}, {v:e}, {turn:e}"
                        );
                        let change = (scheme.state().v[0] - speed).abs();
                        assert!(change <= 1e-9 * speed, "{what}: speed off by {change:e}");
                    }
                }
            }
        }
    }
}

#[test]
fn friction_slows_what_slides_over_seams_as_over_one_face() {
    for slider in [Slider::Point, Slider::Box] {
        for law in ["newton", "fremond"] {
            let mut seams = scene(slider, Ground::Fixed(TILES), law, (0.0, 0.5), 3.0);
            let mut whole = scene(slider, Ground::Fixed(&[(3.0, 0.0)]), law, (0.0, 0.5), 3.0);
            // The first step on a tile is one of a contact that does not last yet: θ = ½ for 1, of the change of speed μ g h.
            let bound = TILES.len() as f64 * 0.5 * (0.5 * G * H) * H;
            for step in 0..500 {
                seams.step().expect("a slide");
                whole.step().expect("a slide");
                let apart = (seams.state().q[0] - whole.state().q[0]).abs();
                assert!(apart <= bound, "{slider:?}, {law}, step {step}: {apart:e} m");
            }
        }
    }
}

/// A centimetre is no seam: the side of the higher tile stops what is lower, its corner what is round and has less than the
/// energy to climb it.
#[test]
fn a_step_is_a_step() {
    const STEP: &[(f64, f64)] = &[(1.0, 0.0), (3.0, 0.01)];
    for slider in [Slider::Disc, Slider::Box, Slider::Point] {
        for law in ["newton", "fremond"] {
            let mut scheme = scene(slider, Ground::Fixed(STEP), law, (0.0, 0.0), 0.3);
            for _ in 0..4000 {
                scheme.step().expect("a slide");
            }
            let (x, u) = (scheme.state().q[0], scheme.state().v[0]);
            assert!(x <= 1.0 + 1e-9 && u.abs() < 0.3, "{slider:?}, {law}: at {x}, {u} m/s");
        }
    }
}
