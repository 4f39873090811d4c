//! Statics by dynamics: top-heavy stacks, the hyperstatic block, the hanging chain.

use nonsmooth::scalar::{Scalar, lit, to_f64};
use nonsmooth::system::{Body, Describe, RigidBodies};

use super::support::{
    Case, Choice, Law, Outcome, Scheme, drive, fastest, law, numbers, scheme, scheme_of, solver,
};

pub(crate) const CASES: &[Case] = &[
    Case {
        name: "top-heavy stack, 1 : 10⁶",
        number: "each contact force = weight above to 1e-8; creep ≤ 1e-12; penetration ≤ 1e-10",
        about: "two unit squares, the light one below, and five in geometric progression upwards; two contact points per \
                face; D = 2, μ = ½, e = 0, h = 1e-3 s, θ = 0.9 where the law lets choose, `predicted-gap` with a gap \
                tolerance of 1 µm; tolerance 1e-10. The percussion under the heavy block, rounded, moves the light one by \
                ½ε·ratio·g h, so that solutions end at the floor of the residual and are told apart from those within \
                the tolerance. Creep is counted in m per step.",
        peer: "closed form",
        runs: &[("f64", |choice| top_heavy(choice, 1e6))],
    },
    Case {
        name: "top-heavy stack, 1 : 10⁸",
        number: "each contact force = weight above to 1e-8; creep ≤ 1e-12; penetration ≤ 1e-10",
        about: "as above. The floor of the residual is 1e-7 of b; the heavy block's velocity, and with it the forces, are \
                resolved far below it, as W p is summed body by body. Frémond's law hands e* = (1−θ)/θ of what rounding leaves \
                in the light block's velocity on to the heavy one: at θ = ½ nothing decays, and after 2,000 steps 8e-9 m/s and \
                3e-8 of the forces are missed.",
        peer: "closed form",
        runs: &[("f64", |choice| top_heavy(choice, 1e8))],
    },
    Case {
        name: "hyperstatic block, 2, 20, 200 points",
        number: "resultants exact, w unique, independent of duplicates and order",
        about: "block on n points, pushed sideways at half its friction; each point once, each twice, and in reverse \
                order. Solver tolerance 1e-12.",
        peer: "closed form",
        runs: &[("f64", hyperstatic::<f64>), ("f32", hyperstatic::<f32>)],
    },
    Case {
        name: "1,000-link hanging chain",
        number: "tension = weight below to 1e-8",
        about: "each link hangs by a disc on the bar (a polygon) of the link above, the first on a fixed point; D = 1, \
                e = 0, h = 1e-3 s, warm-started; tolerance 1e-11. One chain of 1,000 contacts: cond W ~ 10⁶.",
        peer: "closed form",
        runs: &[("f64", chain)],
    },
];

const G: f64 = 9.81;

/// The stack of squares of the case, with masses from 1 kg to `ratio` kg; the nearest θ to the one given that the law
/// claims.
pub(crate) fn stack<T: Scalar>(
    choice: &Choice<'_>,
    blocks: usize,
    ratio: f64,
    (theta, h): (f64, f64),
    tolerance: f64,
) -> Result<Scheme<T, 2>, String> {
    let mut builder = RigidBodies::<T>::builder();
    let (block, floor) = (builder.group(), builder.group());
    let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|x| x.map(lit::<T>));
    let mut q = Vec::new();
    for i in 0..blocks {
        let mass = ratio.powf(i as f64 / (blocks - 1) as f64);
        let body = Body { mass: lit(mass), inertia: lit(mass / 6.0) };
        let name = format!("block {i}");
        let body = builder.body(&name, body).expect("positive");
        builder.polygon(&name, body, &corners, block).expect("convex");
        q.extend([0.0, 0.5 + i as f64, 0.0].map(lit::<T>));
    }
    builder.half_plane("floor", [lit(0.0); 2], [lit(0.0), lit(1.0)], floor).expect("a plane");
    builder.interface(block, block).expect("a group");
    builder.interface(block, floor).expect("two groups");
    builder.gravity([lit(0.0), lit(-G)]).expect("finite");
    let v = vec![lit(0.0); 3 * blocks];
    let system = builder.build().expect("bodies");
    let laws: Vec<Law<T, 2>> = (0..2).map(|_| law(choice, 0.0, 0.5)).collect();
    let claim = laws[0].dissipative_theta().map(|claim| (to_f64(*claim.start()), to_f64(*claim.end())));
    let theta = claim.map_or(theta, |(least, most)| theta.clamp(least, most));
    // As for the arch: a face that opened by rounding is not to be without force for a step.
    scheme_of(system, laws, solver(choice, tolerance), (theta, h), (Some(1e-6), false), (q, v))
}

fn top_heavy(choice: &Choice<'_>, ratio: f64) -> Result<Outcome, String> {
    let h = 1e-3;
    let mut outcome = Outcome::default();
    for blocks in [2, 5] {
        let mut scheme = stack::<f64>(choice, blocks, ratio, (0.9, h), 1e-10)?;
        let mass = |i: usize| ratio.powf(i as f64 / (blocks - 1) as f64);
        let (mut creep, mut force_error) = (0.0_f64, 0.0_f64);
        let steps = if choice.full { 2000 } else { 100 };
        drive(&mut scheme, steps, &mut outcome, |scheme| {
            creep = creep.max(fastest(&scheme.state().v));
            let mut carried = vec![0.0; blocks];
            for contact in &scheme.last_step().contacts {
                carried[scheme.face(contact.id)] += contact.percussion[0] / h;
            }
            for (i, carried) in carried.iter().enumerate() {
                let above: f64 = (i..blocks).map(|j| mass(j) * G).sum();
                force_error = force_error.max((carried / above - 1.0).abs());
            }
        })
        .map_err(|error| format!("{blocks} blocks: {error}"))?;
        let deepest = scheme.candidates(1.0).iter().map(|c| c.gap).fold(0.0, f64::min);
        outcome.small(format!("force error, {blocks} blocks"), force_error, 1e-8);
        outcome.small(format!("creep per step, {blocks} blocks (m)"), creep * h, 1e-12);
        outcome.small(format!("penetration, {blocks} blocks (m)"), deepest, 1e-10);
    }
    Ok(outcome)
}

/// A disc that bounces and `squares` squares that stand beside each other on the floor, apart: an island each.
pub(crate) fn disc_among_squares<T: Scalar>(
    choice: &Choice<'_>,
    squares: usize,
    sleep: bool,
    h: f64,
) -> Result<Scheme<T, 2>, String> {
    let mut builder = RigidBodies::<T>::builder();
    let (ball, block, floor) = (builder.group(), builder.group(), builder.group());
    let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|x| x.map(lit::<T>));
    let mut q = [-2.0, 1.0, 0.0].map(lit::<T>).to_vec();
    let disc = builder.body("disc", Body { mass: lit(1.0), inertia: lit(0.02) }).expect("positive");
    builder.disc("disc", disc, [lit(0.0); 2], lit(0.2), ball).expect("a disc");
    for i in 0..squares {
        let name = format!("square {i}");
        let body = builder.body(&name, Body { mass: lit(1.0), inertia: lit(1.0 / 6.0) }).expect("positive");
        builder.polygon(&name, body, &corners, block).expect("convex");
        q.extend([1.5 * i as f64, 0.5, 0.0].map(lit::<T>));
    }
    builder.half_plane("floor", [lit(0.0); 2], [lit(0.0), lit(1.0)], floor).expect("a plane");
    builder.interface(ball, floor).expect("two groups");
    builder.interface(block, floor).expect("two groups");
    builder.interface(block, block).expect("a group");
    builder.interface(block, ball).expect("two groups");
    builder.gravity([lit(0.0), lit(-G)]).expect("finite");
    let v = vec![lit(0.0); q.len()];
    let restitution = [1.0, 0.0, 0.0, 0.0];
    let laws: Vec<Law<T, 2>> = restitution.into_iter().map(|e| law(choice, e, 0.5)).collect();
    let system = builder.build().expect("bodies");
    scheme_of(system, laws, solver(choice, 1e-10), (0.5, h), (Some(1e-6), sleep), (q, v))
}

/// Which face of the stack a contact belongs to, from the labels of its sides.
trait Face {
    fn face(&self, id: nonsmooth::contact::ContactId) -> usize;
}

impl Face for Scheme<f64, 2> {
    fn face(&self, id: nonsmooth::contact::ContactId) -> usize {
        let label = Describe::contact_label(self.system(), id);
        let number = |side: &str| {
            let name = side.split('/').next().unwrap_or_default();
            name.strip_prefix("block ").and_then(|n| n.parse::<usize>().ok())
        };
        // The upper of the two blocks, or the only one.
        label.split('|').filter_map(number).max().unwrap_or(0)
    }
}

/// A block of 2 m × 1 m and 1 kg on contact points, pushed by half of μ m g at its base; v after the steps, and the
/// sums of the percussions: N, T, moment about the centre.
fn pushed<T: Scalar>(
    choice: &Choice<'_>,
    points: &[f64],
    outcome: &mut Outcome,
) -> Result<(Vec<f64>, [f64; 3]), String> {
    let (mu, h) = (0.5, 1e-3);
    let mut builder = RigidBodies::<T>::builder();
    let (foot, floor) = (builder.group(), builder.group());
    let body = builder.body("block", Body { mass: lit(1.0), inertia: lit(5.0 / 12.0) }).expect("positive");
    for (i, &x) in points.iter().enumerate() {
        builder.disc(&format!("{i}"), body, [lit(x), lit(-0.5)], lit(0.0), foot).expect("a point");
    }
    builder.half_plane("floor", [lit(0.0); 2], [lit(0.0), lit(1.0)], floor).expect("a plane");
    builder.interface(foot, floor).expect("two groups");
    builder.gravity([lit(0.0), lit(-G)]).expect("finite");
    let push = 0.5 * mu * G;
    builder.force(body, [lit(push), lit(0.0)], lit(0.5 * push)).expect("finite");
    let (q, v) = ([0.0, 0.5, 0.0].map(lit::<T>).to_vec(), vec![lit(0.0); 3]);
    let tolerance = if T::NAME == "f32" { 1e-5 } else { 1e-12 };
    let system = builder.build().expect("a body");
    let mut scheme = scheme::<T, 2, _>(choice, system, (0.0, mu), h, tolerance, q, v)?;
    drive(&mut scheme, 20, outcome, |_| ())?;
    let mut sums = [0.0; 3];
    for contact in &scheme.last_step().contacts {
        let x = points[(contact.id.number() >> 31) as usize];
        let [n, t] = [contact.percussion[0], contact.percussion[1]].map(to_f64);
        sums[0] += n / h;
        sums[1] += t / h;
        sums[2] += (x * n + 0.5 * t) / h;
    }
    Ok((numbers(&scheme.state().v), sums))
}

fn hyperstatic<T: Scalar>(choice: &Choice<'_>) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    let single = T::NAME == "f32";
    let (force_bound, speed_bound) = if single { (1e-3, 1e-5) } else { (1e-8, 1e-12) };
    let push = 0.25 * G;
    for n in [2, 20, 200] {
        let once: Vec<f64> = (0..n).map(|i| 2.0 * f64::from(i) / f64::from(n - 1) - 1.0).collect();
        let twice: Vec<f64> = once.iter().flat_map(|&x| [x, x]).collect();
        let reversed: Vec<f64> = once.iter().rev().copied().collect();
        let (mut worst, mut speed) = (0.0_f64, 0.0_f64);
        for points in [&once, &twice, &reversed] {
            let (v, [normal, tangential, moment]) = pushed::<T>(choice, points, &mut outcome)?;
            // N = mg, T = −push, and no moment about the centre: x N + ½ T + ½ push = 0.
            let errors = [normal - G, tangential + push, moment + 0.5 * push];
            worst = errors.iter().fold(worst, |worst, e| worst.max(e.abs()));
            speed = v.iter().fold(speed, |speed, v| speed.max(v.abs()));
        }
        outcome.small(format!("resultants, {n} points, worst of three (N, N m)"), worst, force_bound);
        outcome.small(format!("w − 0, {n} points, worst of three (m/s)"), speed, speed_bound);
    }
    Ok(outcome)
}

/// The hanging chain of `links` links of 1 kg.
pub(crate) fn hanging<T: Scalar>(
    choice: &Choice<'_>,
    links: usize,
    h: f64,
    tolerance: f64,
) -> Result<Scheme<T, 1>, String> {
    let mut builder = RigidBodies::<T>::builder();
    let (hook, bar, first, peg) = (builder.group(), builder.group(), builder.group(), builder.group());
    builder.interface(hook, bar).expect("two groups");
    builder.interface(first, peg).expect("two groups");
    builder.half_plane("peg", [lit(0.0); 2], [lit(0.0), lit(1.0)], peg).expect("a plane");
    let length = 0.1;
    let (radius, half, thick) = (0.01, 0.02, 0.005);
    // The disc stands on the bar of the link above: its centre is `radius` above the top face of that bar.
    let corners = [[-half, -thick], [half, -thick], [half, 0.0], [-half, 0.0]];
    let mut q = Vec::new();
    for i in 0..links {
        let name = format!("link {i}");
        let body = builder.body(&name, Body { mass: lit(1.0), inertia: lit(1e-3) }).expect("positive");
        let group = if i == 0 { first } else { hook };
        builder.disc(&name, body, [lit(0.0), lit(0.5 * length)], lit(radius), group).expect("a disc");
        let low = corners.map(|[x, y]| [lit(x), lit(y - 0.5 * length)]);
        builder.polygon(&name, body, &low, bar).expect("convex");
        // Top faces at −i (length − radius)…: each disc touches the face above it.
        let top_face = -(i as f64) * (length - radius);
        q.extend([0.0, top_face + radius - 0.5 * length, 0.0].map(lit::<T>));
    }
    builder.gravity([lit(0.0), lit(-G)]).expect("finite");
    let v = vec![lit(0.0); 3 * links];
    scheme::<T, 1, _>(choice, builder.build().expect("bodies"), (0.0, 0.0), h, tolerance, q, v)
}

fn chain(choice: &Choice<'_>) -> Result<Outcome, String> {
    let (links, steps) = if choice.full { (1000, 100) } else { (100, 10) };
    let h = 1e-3;
    let mut outcome = Outcome::default();
    let mut scheme = hanging::<f64>(choice, links, h, 1e-11)?;
    let (mut worst, mut contacts) = (0.0_f64, usize::MAX);
    drive(&mut scheme, steps, &mut outcome, |scheme| {
        let step = scheme.last_step();
        contacts = contacts.min(step.contacts.len());
        let mut forces: Vec<f64> = step.contacts.iter().map(|c| c.percussion[0] / h).collect();
        // The link nearest the peg carries most.
        forces.sort_by(|a, b| b.total_cmp(a));
        for (i, force) in forces.iter().enumerate() {
            worst = worst.max((force / ((links - i) as f64 * G) - 1.0).abs());
        }
    })?;
    outcome.near("contacts at every step", contacts as f64, links as f64, 0.0);
    outcome.small(format!("tension error, {links} links"), worst, 1e-8);
    Ok(outcome)
}
