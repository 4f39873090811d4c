//! What stands, stands: random scenes at rest, with every setting at its default.
//!
//! Stacks, walls, ramps, arches, pyramids of discs and hanging chains that are in equilibrium stay where they are, for any
//! law, restitution and step; discs that are dropped come to rest. `NONSMOOTH_SCENES` sets how many scenes are drawn and
//! `NONSMOOTH_STEPS` how many steps each makes.

use nonsmooth::laws;
use nonsmooth::scheme::{Settings, ThetaScheme};
use nonsmooth::solver::{self, Stopping};
use nonsmooth::system::{Body, RigidBodies, RigidBodiesBuilder, polygon_body};

const G: f64 = 9.81;

type Scheme = ThetaScheme<f64, 2>;

/// Numbers that are the same in every run (splitmix64).
struct Draw(u64);

impl Draw {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn count(&mut self, low: usize, high: usize) -> usize {
        low + (self.unit() * (high - low + 1) as f64) as usize
    }

    fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.count(0, from.len() - 1)]
    }
}

/// What is built: bodies with their initial configuration.
struct Built {
    builder: RigidBodiesBuilder<f64>,
    q: Vec<f64>,
    /// Whether it is in equilibrium from the start.
    at_rest: bool,
}

/// Groups of a scene: what moves, and the ground.
fn groups(builder: &mut RigidBodiesBuilder<f64>) -> [nonsmooth::system::GroupId; 2] {
    let [things, ground] = [builder.group(), builder.group()];
    builder.interface(things, things).expect("a group");
    builder.interface(things, ground).expect("two groups");
    [things, ground]
}

fn block(
    built: (&mut RigidBodiesBuilder<f64>, &mut Vec<f64>),
    corners: &[[f64; 2]],
    density: f64,
    group: nonsmooth::system::GroupId,
) {
    let (builder, q) = built;
    let (body, vertices, centre) = polygon_body(density, corners).expect("convex");
    let name = format!("block {}", q.len() / 3);
    let id = builder.body(&name, body).expect("positive");
    builder.polygon(&name, id, &vertices, group).expect("convex");
    q.extend([centre[0], centre[1], 0.0]);
}

/// Boxes on one another, each well inside the one below, on a ramp that friction holds.
fn stack(draw: &mut Draw, friction: f64) -> Built {
    let mut builder = RigidBodies::builder();
    let [things, ground] = groups(&mut builder);
    // Steep enough to lean, never so steep that it slides or tips.
    let lean = draw.between(0.0, 0.4) * friction.min(0.2) * *draw.pick(&[0.0, 1.0, -1.0]);
    let (sin, cos) = lean.atan().sin_cos();
    let turned = |x: f64, y: f64| [cos * x - sin * y, sin * x + cos * y];
    let mut q = Vec::new();
    let (mut base, ratio) = (0.0, draw.between(0.3, 3.0));
    for i in 0..draw.count(1, 6) {
        let (half, height, shift) =
            (draw.between(0.4, 0.6), draw.between(0.2, 0.5), draw.between(-0.04, 0.04));
        let corners = [[-half, 0.0], [half, 0.0], [half, height], [-half, height]];
        let corners = corners.map(|[x, y]| turned(x + shift, base + y));
        block((&mut builder, &mut q), &corners, 1000.0 * f64::powi(ratio, i as i32), things);
        base += height;
    }
    builder.half_plane("ground", [0.0; 2], [-sin, cos], ground).expect("a plane");
    Built { builder, q, at_rest: true }
}

/// Bricks in staggered rows, each a brick shorter than the one below.
fn wall(draw: &mut Draw, _: f64) -> Built {
    let mut builder = RigidBodies::builder();
    let [things, ground] = groups(&mut builder);
    let mut q = Vec::new();
    let (rows, wide) = (draw.count(2, 4), draw.count(2, 3));
    for row in 0..rows {
        // Each brick on two.
        for column in 0..wide + rows - row {
            let x = column as f64 + 0.5 * row as f64;
            let y = 0.4 * row as f64;
            // A joint open by a hundredth: neighbours in a row do not press.
            let corners = [[x, y], [x + 0.99, y], [x + 0.99, y + 0.4], [x, y + 0.4]];
            block((&mut builder, &mut q), &corners, 2000.0, things);
        }
    }
    builder.half_plane("ground", [0.0; 2], [0.0, 1.0], ground).expect("a plane");
    Built { builder, q, at_rest: true }
}

/// A semicircular arch thick enough to stand (the limit is 0.1075 of its radius).
fn arch(draw: &mut Draw, _: f64) -> Built {
    let mut builder = RigidBodies::builder();
    let [things, ground] = groups(&mut builder);
    let (stones, thick) = (2 * draw.count(2, 6) + 1, draw.between(0.2, 0.35));
    let mut q = Vec::new();
    for i in 0..stones {
        let at = |radius: f64, k: usize| {
            let angle = std::f64::consts::PI * k as f64 / stones as f64;
            // The springings on the ground to the last digit.
            [radius * angle.cos(), if k == 0 || k == stones { 0.0 } else { radius * angle.sin() }]
        };
        let (inner, outer) = (1.0 - 0.5 * thick, 1.0 + 0.5 * thick);
        let corners = [at(inner, i), at(outer, i), at(outer, i + 1), at(inner, i + 1)];
        block((&mut builder, &mut q), &corners, 2000.0, things);
    }
    builder.half_plane("ground", [0.0; 2], [0.0, 1.0], ground).expect("a plane");
    Built { builder, q, at_rest: true }
}

fn disc(
    (builder, q): (&mut RigidBodiesBuilder<f64>, &mut Vec<f64>),
    (centre, radius): ([f64; 2], f64),
    group: nonsmooth::system::GroupId,
) {
    let name = format!("disc {}", q.len() / 3);
    let mass = 1000.0 * std::f64::consts::PI * radius * radius;
    let id = builder.body(&name, Body { mass, inertia: 0.5 * mass * radius * radius }).expect("positive");
    builder.disc(&name, id, [0.0; 2], radius, group).expect("positive");
    q.extend([centre[0], centre[1], 0.0]);
}

/// A pyramid of equal discs between walls.
fn pyramid(draw: &mut Draw, _: f64) -> Built {
    let mut builder = RigidBodies::builder();
    let [things, ground] = groups(&mut builder);
    let (base, radius) = (draw.count(2, 4), draw.between(0.05, 0.2));
    let mut q = Vec::new();
    for row in 0..base {
        for column in 0..base - row {
            let x = radius * (1 + 2 * column + row) as f64;
            let y = radius * (1.0 + 3.0_f64.sqrt() * row as f64);
            disc((&mut builder, &mut q), ([x, y], radius), things);
        }
    }
    let width = 2.0 * radius * base as f64;
    for (name, x, normal) in
        [("floor", 0.0, [0.0, 1.0]), ("left", 0.0, [1.0, 0.0]), ("right", width, [-1.0, 0.0])]
    {
        builder.half_plane(name, [x, 0.0], normal, ground).expect("a plane");
    }
    Built { builder, q, at_rest: true }
}

/// Links that hang straight down from a pin.
fn chain(draw: &mut Draw, _: f64) -> Built {
    let mut builder = RigidBodies::builder();
    let [things, _] = groups(&mut builder);
    let mut q = Vec::new();
    let mut above = None;
    for i in 0..draw.count(2, 12) {
        let name = format!("link {i}");
        let mass = draw.between(0.5, 2.0);
        let id = builder.body(&name, Body { mass, inertia: mass / 12.0 }).expect("positive");
        builder.disc(&name, id, [0.0; 2], 0.1, things).expect("positive");
        let on = if above.is_some() { [0.0, -0.5] } else { [0.0, 0.0] };
        builder.pin(&name, id, [0.0, 0.5], above, on).expect("a pin");
        above = Some(id);
        q.extend([0.0, -0.5 - i as f64, 0.0]);
    }
    Built { builder, q, at_rest: true }
}

/// Discs dropped into a bin.
fn dropped(draw: &mut Draw, _: f64) -> Built {
    let mut builder = RigidBodies::builder();
    let [things, ground] = groups(&mut builder);
    let mut q = Vec::new();
    for row in 0..draw.count(2, 4) {
        for column in 0..3 {
            let radius = draw.between(0.07, 0.1);
            let centre = [0.15 + 0.25 * column as f64 + draw.between(-0.02, 0.02), 0.2 + 0.3 * row as f64];
            disc((&mut builder, &mut q), (centre, radius), things);
        }
    }
    for (name, x, normal) in
        [("floor", 0.0, [0.0, 1.0]), ("left", 0.0, [1.0, 0.0]), ("right", 0.8, [-1.0, 0.0])]
    {
        builder.half_plane(name, [x, 0.0], normal, ground).expect("a plane");
    }
    Built { builder, q, at_rest: false }
}

type Kind = (&'static str, fn(&mut Draw, f64) -> Built);

const KINDS: &[Kind] = &[
    ("stack", stack),
    ("wall", wall),
    ("arch", arch),
    ("pyramid", pyramid),
    ("chain", chain),
    ("dropped discs", dropped),
];

fn number(name: &str, otherwise: usize) -> usize {
    std::env::var(name).ok().and_then(|x| x.parse().ok()).unwrap_or(otherwise)
}

/// The scheme of scene `case`, with all settings but θ, which the law may fix, at their defaults.
fn scheme(case: usize) -> (String, bool, Scheme) {
    let mut draw = Draw(case as u64);
    let (kind, build) = KINDS[case % KINDS.len()];
    let friction = *draw.pick(&[0.3, 0.5, 0.8]);
    // An arch of few stones slides on a smooth ground.
    let friction = if kind == "arch" || kind == "pyramid" { 0.8 } else { friction };
    let e = *draw.pick(&[0.0, 0.5, 1.0]);
    let law = *draw.pick(&["newton", "fremond", "moreau"]);
    let h = *draw.pick(&[1e-3, 5e-3, 1.0 / 60.0]);
    // What is dropped with e = 1 never rests.
    let (e, h) = if kind == "dropped discs" { (0.5 * e, 1e-3) } else { (e, h) };
    let built = build(&mut draw, friction);
    let Built { mut builder, q, at_rest } = built;
    builder.gravity([0.0, -G]).expect("finite");
    let laws = (0..2).map(|_| laws::build(law, &[e, friction]).expect("registered")).collect();
    let solver = solver::build(solver::DEFAULT, Stopping::default()).expect("registered");
    let theta = if law == "moreau" { 1.0 / (1.0 + e) } else { 0.5 };
    let settings = Settings { allow_unproved_theta: true, ..Settings::new(theta, h) };
    let system = builder.build().expect("a scene");
    let v = vec![0.0; q.len()];
    let name = format!("{kind} {case}, {law}, e = {e}, μ = {friction}, h = {h:.1e}, {} bodies", q.len() / 3);
    (
        name,
        at_rest,
        ThetaScheme::new(Box::new(system), laws, solver, settings, 0.0, q, v).expect("a valid setup"),
    )
}

#[test]
fn what_stands_stands_with_every_setting_at_its_default() {
    let (scenes, steps) = (number("NONSMOOTH_SCENES", 24), number("NONSMOOTH_STEPS", 400));
    let (mut wrong, mut largest, mut failures) = (Vec::new(), 0.0_f64, 0);
    for case in 0..scenes {
        let (name, at_rest, mut scheme) = scheme(case);
        let start = scheme.state().q.clone();
        let failed = (0..steps).find_map(|_| scheme.step().err());
        if let Some(error) = failed {
            failures += 1;
            wrong.push(format!("{name}: {error}"));
            continue;
        }
        let moved = scheme.state().q.iter().zip(&start).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        if at_rest {
            // The scenes are of the size of a metre: what solvers leave, h tol ‖b‖ per step, adds up to no more.
            largest = largest.max(moved);
            if !(moved <= 1e-9) {
                wrong.push(format!("{name}: moved by {moved:e} m"));
            }
        } else if steps >= 5000 {
            let speed = scheme.state().v.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            println!("{name}: fastest at the end {speed:e}");
        }
    }
    println!(
        "{scenes} scenes of {steps} steps: {failures} failed, largest motion of what stands {largest:e} m"
    );
    assert!(wrong.is_empty(), "{} of {scenes}:\n{}", wrong.len(), wrong.join("\n"));
}
