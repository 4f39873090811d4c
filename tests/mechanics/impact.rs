//! One planar contact at an impact, through a law, the cone problem and a solver.

use nalgebra::{Matrix2, Vector2};
use nonsmooth::cone::{BlockMatrix, ConeProblem};
use nonsmooth::contact::pose;
use nonsmooth::laws::{self, Approach, ContactLaw};
use nonsmooth::solver::{self, ConeSolver, SolveError, Stopping};

/// What the contact does: percussion p (N s), velocity u⁺ (m/s), works u_{k+θ}·p (J), all in the order (N, T).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Impact {
    pub(crate) percussion: Vector2<f64>,
    pub(crate) after: Vector2<f64>,
    pub(crate) work: Vector2<f64>,
    /// Contact work with the numerical dissipation (½−θ) p·Wp: the change of the energy.
    pub(crate) energy_change: f64,
}

/// A registered law with restitution e and friction μ.
pub(crate) fn law(name: &str, restitution: f64, friction: f64) -> Box<dyn ContactLaw<f64, 2>> {
    laws::build(name, &[restitution, friction]).expect("a registered law with restitution and friction")
}

/// A registered solver at the accuracy of the arithmetic: 2e-14 of the velocities.
pub(crate) fn solver(name: &str) -> Box<dyn ConeSolver<f64, 2>> {
    solver::build(name, Stopping::to(2e-14)).expect("a registered solver")
}

/// The impact of a contact with Delassus operator `w`, velocity `before` (u_k) and velocity `free` without
/// percussion, the two being equal where nothing but the impact acts.
pub(crate) fn try_impact(
    w: &Matrix2<f64>,
    before: &Vector2<f64>,
    free: &Vector2<f64>,
    law: &dyn ContactLaw<f64, 2>,
    theta: f64,
    solver: &mut dyn ConeSolver<f64, 2>,
) -> Result<Impact, SolveError> {
    let (b, cone) = pose(law, &Approach::impact(*before, theta), free).expect("a law with a problem");
    let blocks = BlockMatrix::from_fn(1, |_, _| *w);
    let problem = ConeProblem::new(blocks, vec![b], vec![cone.friction()])?;
    let mut p = [Vector2::zeros()];
    solver.solve(&problem, &[Vector2::zeros()], &mut p)?;
    let [percussion] = p;
    let after = w * percussion + free;
    let work = (before * (1.0 - theta) + after * theta).component_mul(&percussion);
    let energy_change = work.sum() + (0.5 - theta) * percussion.dot(&(w * percussion));
    Ok(Impact { percussion, after, work, energy_change })
}

/// [`try_impact`] of a contact on which nothing acts but the impact.
pub(crate) fn impact(
    w: &Matrix2<f64>,
    before: &Vector2<f64>,
    law: &dyn ContactLaw<f64, 2>,
    theta: f64,
    solver: &mut dyn ConeSolver<f64, 2>,
) -> Impact {
    try_impact(w, before, before, law, theta, solver)
        .unwrap_or_else(|error| panic!("W = {w:?}, u⁻ = {before:?}, {law:?}: {error}"))
}
