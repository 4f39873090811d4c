//! Ten million steps.

use nonsmooth::system::{Body, RigidBodies, polygon_body};

use super::support::{Case, Choice, Law, Outcome, drive, law, scheme_of, solver};

pub(crate) const CASES: &[Case] = &[Case {
    name: "10⁷ steps, bouncing, sliding, resting",
    number: "imbalance stays round-off per step; no positive contact work; no drift in memory",
    about: "a disc bouncing with e = 1, a block dragged along the floor by 1.001 μ m g, a block at rest on two points; \
            D = 2, θ = ½, h = 1e-4 s. 10⁷ steps with the default solver and `nsgs`, 10⁵ with the others.",
    peer: "",
    runs: &[("f64", long)],
}];

/// Resident memory of the process (bytes), where the system says.
fn resident() -> Option<f64> {
    let statm = std::fs::read_to_string("/proc/self/statm").ok()?;
    statm.split_whitespace().nth(1)?.parse::<f64>().ok().map(|pages| pages * 4096.0)
}

fn long(choice: &Choice<'_>) -> Result<Outcome, String> {
    let mut outcome = Outcome { budget: 600.0, ..Outcome::default() };
    let quick = ["hybrid", "nsgs"].contains(&choice.solver);
    let steps: usize = match (choice.full, quick) {
        (true, true) => 10_000_000,
        (true, false) => 100_000,
        (false, true) => 50_000,
        (false, false) => 2_000,
    };
    let (g, mu, h) = (10.0, 0.3, 1e-4);
    let mut builder = RigidBodies::<f64>::builder();
    let (ball, block, floor) = (builder.group(), builder.group(), builder.group());
    builder.half_plane("floor", [0.0; 2], [0.0, 1.0], floor).expect("a plane");
    let disc = builder.body("disc", Body { mass: 1.0, inertia: 0.005 }).expect("positive");
    builder.disc("disc", disc, [0.0; 2], 0.1, ball).expect("a disc");
    let corners = [[-0.2, -0.1], [0.2, -0.1], [0.2, 0.1], [-0.2, 0.1]];
    let (shape, corners, _) = polygon_body(1.0 / 0.08, &corners).expect("a rectangle");
    for name in ["dragged", "resting"] {
        let body = builder.body(name, shape).expect("positive");
        builder.polygon(name, body, &corners, block).expect("convex");
        if name == "dragged" {
            // At the height of the base, so that friction and drag make no moment.
            let pull = 1.001 * mu * g;
            builder.force(body, [pull, 0.0], 0.1 * pull).expect("finite");
        }
    }
    builder.interface(ball, floor).expect("two groups");
    builder.interface(block, floor).expect("two groups");
    builder.gravity([0.0, -g]).expect("finite");
    let q = vec![0.0, 0.5, 0.0, 2.0, 0.1, 0.0, -2.0, 0.1, 0.0];
    let mut v = vec![0.0; 9];
    (v[0], v[3]) = (0.1, 0.5);
    // One θ for both interfaces: Moreau's law then takes e = 1 for both, and Newton's, which claims θ = 1 for e = 0, ½.
    let resting = match choice.law {
        "moreau" => 1.0,
        "newton" => 0.5,
        _ => 0.0,
    };
    let laws: Vec<Law<f64, 2>> = vec![law(choice, 1.0, mu), law(choice, resting, mu)];
    let system = builder.build().expect("bodies");
    let mut scheme = scheme_of(system, laws, solver(choice, 1e-12), (0.5, h), (None, false), (q, v))?;
    let (mut imbalance, mut work) = (0.0_f64, f64::MIN);
    let mut scale = 0.0_f64;
    let mut watch = |scheme: &super::support::Scheme<f64, 2>| {
        let step = scheme.last_step();
        let energy = step.energies.kinetic;
        scale = energy.max(5.0);
        imbalance = imbalance.max(step.balance.imbalance.abs() / scale);
        for contact in &step.contacts {
            work = work.max((contact.normal_work + contact.tangential_work) / scale);
        }
    };
    drive(&mut scheme, steps / 10, &mut outcome, &mut watch)?;
    let before = resident();
    drive(&mut scheme, steps - steps / 10, &mut outcome, &mut watch)?;
    let after = resident();
    outcome.small("largest imbalance of a step / E", imbalance, 1e-14);
    if choice.law == "newton" {
        outcome.note(format!("largest contact work / E = {work:.2e}"));
    } else {
        outcome.small("largest contact work / E", work.max(0.0), 1e-13);
    }
    if let (Some(before), Some(after)) = (before, after) {
        // A page or two for whatever else the process does.
        let bound = if choice.full { 65_536.0 } else { f64::INFINITY };
        outcome.near("growth of memory over the last 9/10 (bytes)", (after - before).max(0.0), 0.0, bound);
    }
    outcome.note(format!("{steps} steps, {:.3} µs each", outcome.seconds / steps as f64 * 1e6));
    Ok(outcome)
}
