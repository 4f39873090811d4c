//! The sliding block and the impacting bar, as systems and schemes.
#![allow(dead_code, reason = "each test uses a part of it")]

use std::path::PathBuf;

use nonsmooth::laws;
use nonsmooth::mesh::{Mesh, Pattern, rectangle};
use nonsmooth::scheme::{Activation, ActivationRule, Settings, ThetaScheme};
use nonsmooth::solver::{self, Stopping};
use nonsmooth::system::{Axis, Dynamics, ElasticBody, Hypothesis, MassForm, Material, Signal, Support};

pub(crate) type Scheme<const D: usize> = ThetaScheme<f64, D>;

/// Names of the groups of the authors' mesh.
pub(crate) const CONTACT: &str = "Contact BC";
pub(crate) const TOP: &str = "Confining displacement";
pub(crate) const LEFT: &str = "Applied force";

/// The authors' mesh, read where it is; `None`, with a line, where it is not.
pub(crate) fn authors_mesh() -> Option<Mesh> {
    let folder =
        std::env::var_os("NONSMOOTH_DATA").map_or_else(|| PathBuf::from("../shared/data"), PathBuf::from);
    let path = folder.join("sliding_block_mesh.msh");
    if !path.exists() {
        println!("skipped: {} is not there (set NONSMOOTH_DATA)", path.display());
        return None;
    }
    Some(Mesh::read(&path).expect("the authors' mesh is sound"))
}

/// The block meshed here, under the names of the authors' groups.
pub(crate) fn built_in_mesh(size: f64, pattern: Pattern) -> Mesh {
    let mut mesh = rectangle(40.0, 25.0, size, pattern).expect("a rectangle");
    mesh.rename_groups([("bottom", CONTACT), ("top", TOP), ("left", LEFT)]).expect("groups of a rectangle");
    mesh
}

/// Section 5.2: 40 mm × 25 mm × 15 mm of PMMA; mm, ms, g, so MPa, N, mJ.
pub(crate) fn block(mesh: Mesh, hypothesis: Hypothesis) -> ElasticBody<f64> {
    let material = Material { young: 5750.0, poisson: 0.358, density: 1.17e-3, section: 15.0, hypothesis };
    let mut builder = ElasticBody::builder("block", mesh, material).expect("a material");
    builder.gravity([0.0, -1e-3]).expect("gravity");
    builder.prescribe(TOP, Axis::Y, -0.005, Signal::Constant).expect("the top");
    let square = Signal::Square { frequency: 2.0, phase: 0.0 };
    builder.traction(LEFT, [2.0, 0.0], square).expect("the left edge");
    let interface = builder.interface();
    builder.contact(CONTACT, "ground", [0.0, 0.0], [0.0, 1.0], interface).expect("the contact edge");
    builder.build().expect("a block")
}

/// The block at rest in its preload, stepped by a registered law and solver, e = 0, μ = ½.
pub(crate) fn block_scheme(
    mesh: Mesh,
    hypothesis: Hypothesis,
    law: &str,
    solver: &str,
    rule: ActivationRule,
) -> Scheme<2> {
    let block = block(mesh, hypothesis);
    let q = block.preload(0.0, Support::Fixed, false).expect("an equilibrium");
    let v = vec![0.0; q.len()];
    let law = laws::build(law, &[0.0, 0.5]).expect("a law");
    let solver = solver::build(solver, Stopping::to(1e-10)).expect("a solver");
    let activation = Activation::new(rule);
    let settings = Settings { activation, allow_unproved_theta: true, ..Settings::new(0.5, 1e-4) };
    ThetaScheme::new(Box::new(block), vec![law], solver, settings, 0.0, q, v).expect("a scheme")
}

/// A bar of `elements` elements from x = 0 to 10 with E = 900, ρ = 1, A = 1 at velocity `speed`, above a wall whose
/// face is at `wall` ≤ 0, under gravity −`gravity`.
pub(crate) fn bar(elements: usize, wall: f64, gravity: f64, mass: MassForm) -> ElasticBody<f64> {
    let mesh = Mesh::interval(10.0, elements).expect("a line");
    let hypothesis = Hypothesis::PlaneStress;
    let material = Material { young: 900.0, poisson: 0.0, density: 1.0, section: 1.0, hypothesis };
    let mut builder = ElasticBody::builder("bar", mesh, material).expect("a material");
    builder.mass(mass);
    builder.gravity([-gravity, 0.0]).expect("gravity");
    let interface = builder.interface();
    builder.contact("left", "wall", [wall, 0.0], [1.0, 0.0], interface).expect("the end");
    builder.build().expect("a bar")
}

/// What is measured on a bar that hits the wall at 10 at t = 0.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Impact {
    /// End of the last step with a percussion.
    pub contact_time: f64,
    /// Impulse over the contact time, against the exact mean force.
    pub mean_force: f64,
    /// Largest |p/h − exact force| over the middle of the contact, 0.1 < t < 0.55, in parts of 300.
    pub oscillation: f64,
    /// Mean velocity after the contact.
    pub rebound: f64,
    /// Mechanical energy with the potential of gravity after the contact, less that before, in parts of 500.
    pub energy_change: f64,
}

/// The exact contact force s seconds after the impact: ρcA (v₀ + g s), until 2L/c.
pub(crate) fn exact_force(s: f64, gravity: f64) -> f64 {
    30.0 * (10.0 + gravity * s)
}

/// Runs the bar from the moment of impact to t = 0.9.
pub(crate) fn impact(
    (elements, mass): (usize, MassForm),
    step: f64,
    theta: f64,
    (law, restitution): (&str, f64),
    gravity: f64,
) -> Impact {
    let bar = bar(elements, 0.0, gravity, mass);
    let (n, total) = (elements + 1, bar.total_mass());
    let law = laws::build(law, &[restitution, 0.0]).expect("a law");
    let solver = solver::build("nsgs", Stopping::to(1e-12)).expect("a solver");
    let settings = Settings { allow_unproved_theta: true, ..Settings::new(theta, step) };
    let (q, v) = (vec![0.0; n], vec![-10.0; n]);
    let mut scheme =
        ThetaScheme::<f64, 1>::new(Box::new(bar), vec![law], solver, settings, 0.0, q, v).expect("a scheme");
    let before = scheme.last_step().energies.total();
    let (mut impulse, mut last, mut oscillation): (f64, f64, f64) = (0.0, 0.0, 0.0);
    while scheme.state().time < 0.9 - 0.5 * step {
        let made = scheme.step().expect("the bar's step succeeds");
        let p = made.contacts.first().map_or(0.0, |contact| contact.percussion[0]);
        let end = scheme.state().time;
        if p > 0.0 {
            impulse += p;
            last = end;
        }
        let middle = end - 0.5 * step;
        if middle > 0.1 && middle < 0.55 {
            oscillation = oscillation.max((p / step - exact_force(middle, gravity)).abs() / 300.0);
        }
    }
    let (state, system) = (scheme.state(), scheme.system());
    let mut momentum = state.v.clone();
    Dynamics::mass(system).multiply(&state.v, &mut momentum);
    Impact {
        contact_time: last,
        mean_force: impulse / last,
        oscillation,
        // Gravity has slowed the flight since the contact ended.
        rebound: momentum.iter().sum::<f64>() / total + gravity * (state.time - 2.0 / 3.0),
        energy_change: (scheme.last_step().energies.total() - before) / 500.0,
    }
}
