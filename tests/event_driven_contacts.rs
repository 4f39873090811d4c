//! Event-driven motions of several contacts at once: redundant ones, discs in a box, random systems.

#[path = "mechanics/motion.rs"]
mod motion;
#[path = "mechanics/random_lagrangian.rs"]
mod random_lagrangian;
#[path = "mechanics/regression.rs"]
mod regression;
#[path = "mechanics/stream.rs"]
mod stream;

use motion::{balances, close, hybrid, law, motion, rounding, state};
use nonsmooth::event_driven::{Settings, integrate};
use nonsmooth::scheme::ThetaScheme;
use nonsmooth::solver::Stopping;
use nonsmooth::system::{Body, Contacts, RigidBodies, Signal, polygon_body};
use random_lagrangian::{RandomLagrangian, Storage};
use regression::{log_spaced, order};
use stream::Stream;

#[test]
fn a_disc_in_a_groove_holds_until_both_sides_slip() {
    // A groove of two sides at 45°, a torque that grows by 1 N m/s. Sticking, the forces of the two contacts are not
    // determined: one can wedge the disc. Both slide from the torque √2 μ m g r/(1 + μ²) on, the most that any forces in
    // the cones balance.
    let (mu, radius, weight) = (0.3, 0.1, 20.0);
    let mut builder = RigidBodies::builder();
    let (discs, sides) = (builder.group(), builder.group());
    let body = builder.body("disc", Body { mass: 2.0, inertia: 0.01 }).expect("positive");
    builder.disc("disc", body, [0.0; 2], radius, discs).expect("a disc");
    builder.half_plane("left", [0.0; 2], [1.0, 1.0], sides).expect("a side");
    builder.half_plane("right", [0.0; 2], [-1.0, 1.0], sides).expect("a side");
    builder.interface(discs, sides).expect("groups");
    builder.gravity([0.0, -10.0]).expect("finite");
    builder.load(body, [0.0; 2], 2.0, Signal::Ramp { start: 0.0, end: 2.0 }).expect("a load");
    let system = builder.build().expect("a body");
    let q = [0.0, radius * std::f64::consts::SQRT_2, 0.0];
    let motion = motion::<2>(system, law("newton", 0.0, mu), (&q, &[0.0; 3]), 1.0);
    let slips = std::f64::consts::SQRT_2 * mu * weight * radius / (1.0 + mu * mu);
    let spin = |t: f64| if t > slips { 0.5 * (t - slips).powi(2) / 0.01 } else { 0.0 };
    for i in 0..=100 {
        let t = 0.01 * f64::from(i);
        let (_, v) = state(&motion, t);
        close("spin", v[2], spin(t), 1e-12);
    }
    balances(&motion);
}

/// Discs of random size, mass and velocity in a box, side by side.
fn discs(stream: &mut Stream, count: usize) -> (RigidBodies<f64>, Vec<f64>, Vec<f64>) {
    boxed(stream, count, 0.9, |i| [0.15 + 0.3 * i as f64, 0.2 + 0.1 * i as f64])
}

/// Discs of random size, mass and velocity in a narrow box, one pair above the other.
fn pile(stream: &mut Stream, count: usize) -> (RigidBodies<f64>, Vec<f64>, Vec<f64>) {
    boxed(stream, count, 0.52, |i| {
        let (column, row) = ((i % 2) as f64, (i / 2) as f64);
        [0.13 + 0.26 * column, 0.15 + 0.26 * row + 0.05 * column]
    })
}

fn boxed(
    stream: &mut Stream,
    count: usize,
    width: f64,
    place: impl Fn(usize) -> [f64; 2],
) -> (RigidBodies<f64>, Vec<f64>, Vec<f64>) {
    let mut builder = RigidBodies::builder();
    let (discs, walls) = (builder.group(), builder.group());
    let (mut q, mut v) = (Vec::new(), Vec::new());
    for i in 0..count {
        let (radius, mass) = (stream.uniform(0.05, 0.12), stream.uniform(0.5, 2.0));
        let body = Body { mass, inertia: 0.5 * mass * radius * radius };
        let body = builder.body(&format!("disc {i}"), body).expect("positive");
        builder.disc(&format!("disc {i}"), body, [0.0; 2], radius, discs).expect("a disc");
        let [x, y] = place(i);
        q.extend([x, y, 0.0]);
        v.extend([stream.uniform(-1.0, 1.0), stream.uniform(-1.0, 1.0), stream.uniform(-5.0, 5.0)]);
    }
    for (name, point, normal) in
        [("floor", 0.0, [0.0, 1.0]), ("left", 0.0, [1.0, 0.0]), ("right", width, [-1.0, 0.0])]
    {
        builder.half_plane(name, [point, 0.0], normal, walls).expect("a wall");
    }
    builder.interface(discs, discs).expect("groups");
    builder.interface(discs, walls).expect("groups");
    builder.gravity([0.0, -10.0]).expect("finite");
    (builder.build().expect("bodies"), q, v)
}

#[test]
fn discs_in_a_box_stay_apart_and_lose_energy_until_they_rest_or_roll() {
    for seed in 0..4 {
        let mut stream = Stream(seed);
        let (system, q, v) = discs(&mut stream, 3);
        let laws = vec![law::<2>("fremond", 0.5, 0.3), law("fremond", 0.5, 0.3)];
        let motion = integrate(Box::new(system), laws, hybrid(), 0.0, q, v, 2.0, &Settings::default())
            .unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        assert!(motion.impacts().len() > 100 && motion.mode_changes().len() > 5, "seed {seed}: {motion:?}");
        balances(&motion);
        let (mut system, ..) = discs(&mut Stream(seed), 3);
        let (mut energy, mut percussion, mut last) = (f64::INFINITY, 0.0, f64::NEG_INFINITY);
        for i in 0..=2000 {
            let time = 1e-3 * f64::from(i);
            let (q, _) = state(&motion, time);
            let mut candidates = Vec::new();
            Contacts::<f64, 2>::candidates(&mut system, &q, f64::INFINITY, &mut candidates);
            let least = candidates.iter().map(|candidate| candidate.gap).fold(f64::INFINITY, f64::min);
            // Contacts close to the rounding of q, and what rests is brought back to its surface by it.
            assert!(least > -1e-13, "seed {seed}: a gap of {least:e} at {time}");
            let now = motion.energy(time).total();
            assert!(now <= energy + rounding(20.0), "seed {seed}: the energy grows to {now} at {time}");
            let [normal, tangential] = motion.percussion(time);
            assert!(normal >= percussion - rounding(20.0), "seed {seed}: contacts pull at {time}");
            (energy, percussion, last) = (now, normal, tangential.max(last));
        }
        for impact in motion.impacts() {
            for contact in &impact.contacts {
                let ([normal, tangential], [w_n, w_t]) = (contact.percussion, contact.work);
                assert!(
                    normal >= -1e-15 && tangential.abs() <= 0.3 * normal + 1e-14,
                    "seed {seed}: {contact:?}"
                );
                assert!(w_n <= 1e-14 && w_t <= 1e-14, "seed {seed}: {contact:?}");
            }
        }
    }
}

#[test]
fn the_scheme_converges_to_the_motion_of_random_systems_with_three_contacts() {
    for seed in 0..6 {
        let mut stream = Stream(seed);
        let drawn = RandomLagrangian::<2>::draw(&mut stream, 4, 3, seed % 2 == 0);
        let laws = || (0..3).map(|_| law::<2>("fremond", 0.4, 0.3)).collect::<Vec<_>>();
        let end = 0.4;
        let settings = Settings::default();
        let system = drawn.system(Storage::Dense);
        let motion = integrate(
            Box::new(system),
            laws(),
            hybrid(),
            0.0,
            drawn.q.clone(),
            drawn.v.clone(),
            end,
            &settings,
        )
        .unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        balances(&motion);
        // First order in h, with a constant that grows with every impact in a row: the slope over the decades tells.
        let steps = log_spaced(1e-5, 1e-3, 7);
        let error = |&h: &f64| {
            let storage = [Storage::Sparse, if seed % 2 == 0 { Storage::Diagonal } else { Storage::Dense }];
            let system = drawn.system(storage[usize::from(h > 1e-4)]);
            let settings = nonsmooth::scheme::Settings::new(0.5, h);
            let mut scheme = ThetaScheme::new(
                Box::new(system),
                laws(),
                hybrid(),
                settings,
                0.0,
                drawn.q.clone(),
                drawn.v.clone(),
            )
            .expect("a scheme");
            let mut worst = 0.0_f64;
            while scheme.state().time < end - h {
                scheme.step().expect("three contacts");
                let (q, _) = state(&motion, scheme.state().time);
                worst = q.iter().zip(&scheme.state().q).fold(worst, |worst, (a, b)| worst.max((a - b).abs()));
            }
            worst
        };
        let errors: Vec<f64> = steps.iter().map(error).collect();
        let order = order(&steps, &errors);
        // Errors of single steps spread by a factor of ten, which over two decades changes the slope by half.
        assert!((0.5..1.5).contains(&order), "seed {seed}: order {order}, errors {errors:?}");
        assert!(errors[0] < 1e-3, "seed {seed}: errors {errors:?}");
    }
}

/// Seed, law, friction and time by which the pile rests (s).
const PILES: [(u64, &str, f64, f64); 2] = [(1, "fremond", 0.5, 3.0), (2, "fremond", 0.3, 3.0)];

#[test]
fn piles_of_six_discs_come_to_rest_where_forces_in_the_cones_carry_their_weight() {
    for (seed, name, friction, end) in PILES {
        let laws = || vec![law::<2>(name, 0.0, friction), law(name, 0.0, friction)];
        let (system, q, v) = pile(&mut Stream(seed), 6);
        let motion = integrate(Box::new(system), laws(), hybrid(), 0.0, q, v, end, &Settings::default())
            .unwrap_or_else(|error| panic!("{name}, μ = {friction}: {error}"));
        balances(&motion);
        let mut energy = f64::INFINITY;
        for i in 0..=1000 {
            let now = motion.energy(1e-3 * f64::from(i) * end).total();
            assert!(now <= energy + rounding(50.0), "{name}: the energy grows to {now}");
            energy = now;
        }
        // At rest, and for the last tenth of a second already.
        let ((q, v), (earlier, _)) = (state(&motion, end), state(&motion, end - 0.1));
        for i in 0..q.len() {
            close("a velocity at rest", v[i], 0.0, rounding(1.0));
            // The angles are some radians.
            close("a place at rest", q[i], earlier[i], rounding(10.0));
        }
        // One step of the time-stepping scheme finds percussions in the cones that keep every momentum at zero.
        let (system, ..) = pile(&mut Stream(seed), 6);
        let (h, gravity, tolerance) = (1e-3, 10.0, Stopping::<f64>::default().tolerance);
        let settings = nonsmooth::scheme::Settings::new(0.5, h);
        let mut scheme =
            ThetaScheme::new(Box::new(system), laws(), hybrid(), settings, 0.0, q, v).expect("a scheme");
        scheme.step().expect("an equilibrium");
        let speed = scheme.state().v.iter().fold(0.0_f64, |speed, v| speed.max(v.abs()));
        // The lightest disc turns ten times as fast as it moves.
        assert!(speed <= 1e3 * tolerance * gravity * h, "{name}, μ = {friction}: {speed:e} after a step");
    }
}

/// The first t > 0 with f(t) < 0, f being resolved by steps of 1e-5.
fn first_negative(f: impl Fn(f64) -> f64) -> f64 {
    let mut high = 1e-5;
    while f(high) >= 0.0 {
        high += 1e-5;
    }
    let mut low = high - 1e-5;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if f(middle) >= 0.0 { low = middle } else { high = middle }
    }
    low
}

/// A square of side 0.2 m.
fn square() -> (Body<f64>, Vec<[f64; 2]>) {
    let (body, vertices, _) =
        polygon_body(50.0, &[[0.0, 0.0], [0.2, 0.0], [0.2, 0.2], [0.0, 0.2]]).expect("a square");
    (body, vertices)
}

/// How far the corners of a square of side 0.2 m at `angle` reach beyond its centre in one direction along an axis.
fn reach(angle: f64) -> f64 {
    0.1 * (angle.sin().abs() + angle.cos().abs())
}

#[test]
fn a_tumbling_square_lands_on_the_corner_that_is_lowest_then() {
    let gravity = 10.0;
    for (spin, height, rise) in [(3.0, 1.0, 0.0), (-11.0, 0.7, 2.0), (40.0, 0.5, 1.0), (0.3, 0.2, 0.0)] {
        let mut builder = RigidBodies::builder();
        let (squares, floors) = (builder.group(), builder.group());
        let (body, vertices) = square();
        let body = builder.body("square", body).expect("positive");
        builder.polygon("square", body, &vertices, squares).expect("a square");
        builder.half_plane("floor", [0.0; 2], [0.0, 1.0], floors).expect("a floor");
        builder.interface(squares, floors).expect("groups");
        builder.gravity([0.0, -gravity]).expect("finite");
        let system = builder.build().expect("a body");
        let fall = |t: f64| height + rise * t - 0.5 * gravity * t * t;
        let lands = first_negative(|t| fall(t) - reach(0.2 + spin * t));
        let motion = motion::<2>(
            system,
            law("newton", 0.5, 0.3),
            (&[0.0, height, 0.2], &[0.5, rise, spin]),
            lands + 1e-6,
        );
        let impact = &motion.impacts()[0];
        // The height is rounded, and found again over the speed of the fall.
        close("the first contact", impact.time, lands, rounding(1.0));
        let (q, _) = state(&motion, impact.time);
        close("the height then", q[1], reach(q[2]), rounding(1.0));
        balances(&motion);
    }
}

#[test]
fn a_tumbling_square_hits_the_side_of_another_with_the_corner_that_is_foremost_then() {
    for (spin, start, speed) in [(3.0, 1.0, -1.0), (-11.0, 0.7, -0.5), (40.0, 0.9, -2.0), (20.0, 0.3, -0.05)]
    {
        let mut builder = RigidBodies::builder();
        let group = builder.group();
        for name in ["still", "tumbling"] {
            let (body, vertices) = square();
            let body = builder.body(name, body).expect("positive");
            builder.polygon(name, body, &vertices, group).expect("a square");
        }
        builder.interface(group, group).expect("groups");
        let system = builder.build().expect("bodies");
        let hits = first_negative(|t| start + speed * t - 0.1 - reach(0.2 + spin * t));
        let motion = motion::<2>(
            system,
            law("fremond", 0.5, 0.3),
            (&[0.0, 0.0, 0.0, start, 0.0, 0.2], &[0.0, 0.0, 0.0, speed, 0.0, spin]),
            hits + 1e-6,
        );
        let impact = &motion.impacts()[0];
        close("the first contact", impact.time, hits, rounding(1.0) / speed.abs());
        let (q, _) = state(&motion, impact.time);
        close("the distance then", q[3] - 0.1, reach(q[5]), rounding(1.0));
        balances(&motion);
    }
}
