//! Static equilibrium with contacts: the preload that the cone solver resolves.

use nalgebra::SVector;

use super::SetupError;
use super::kept::constant_rows;
use crate::cone::ConeProblem;
use crate::contact::Candidate;
use crate::linalg::{Factor, FactorError, Symmetric, axpy, max_abs};
use crate::scalar::{Scalar, lit, to_f64};
use crate::solver::{ConeSolver, SolveError};
use crate::system::{ElasticBody, MechanicalSystem};

/// Why no equilibrium with contacts was found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EquilibriumError {
    /// The contacts cannot be set up.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// More candidates than an equilibrium is sought for.
    #[error("too many candidate contacts for an equilibrium: fix them instead")]
    TooLarge,
    /// K + σM is not positive definite.
    #[error("the stiffness of the preload: {0}")]
    Stiffness(FactorError),
    /// The cone solver failed.
    #[error("the contacts of the preload: {0}")]
    Solve(#[from] SolveError),
    /// The body does not come to rest: the loads move it, and nothing holds it.
    #[error(
        "no static equilibrium after {iterations} iterations: the body still moves by {change:e}; hold more of it"
    )]
    NotHeld {
        /// Iterations made.
        iterations: usize,
        /// Largest displacement of the last one (m).
        change: f64,
    },
}

/// Most iterations, and the change at which they end against the largest displacement.
const ITERATIONS: usize = 500;
const CHANGE: f64 = 1e-12;

/// The equilibrium K q = F + Hᵀ r at `time`, with the contact forces r of
///
/// ```text
///   w = (g(q), s(q)),     K* ∋ Φ(w) ⟂ r ∈ K
/// ```
///
/// where g is the gap and s the slip from the undeformed place, `friction[i]` that of interface i. The constant
/// forces act where `with_constant_forces`. A body that contacts alone hold has a singular K; the iteration
/// (K + σM) q_{j+1} = F + σM q_j + Hᵀ r, proximal in the norm of M, needs no more.
///
/// # Errors
/// [`EquilibriumError`].
pub fn equilibrium<T: Scalar, const D: usize>(
    body: &mut ElasticBody<T>,
    friction: &[T],
    solver: &mut dyn ConeSolver<T, D>,
    time: T,
    with_constant_forces: bool,
) -> Result<Vec<T>, EquilibriumError> {
    let n = MechanicalSystem::<T, D>::dofs(body);
    let mut q = vec![T::zero(); n];
    let mut force = vec![T::zero(); n];
    let forces = MechanicalSystem::<T, D>::forces(body);
    forces.at(time, &mut force);
    if !with_constant_forces {
        axpy(&mut force, -T::one(), forces.constant_part());
    }
    let mut candidates: Vec<Candidate<T>> = Vec::new();
    MechanicalSystem::<T, D>::candidates(body, &q, T::infinity_impl(), &mut candidates);
    candidates.sort_unstable_by_key(|candidate| candidate.id);
    let mut free = n;
    if let Some(prescribed) = MechanicalSystem::<T, D>::prescribed(body) {
        free = prescribed.first();
        (0..prescribed.count()).for_each(|i| q[free + i] = prescribed.displacement(i, time));
    }
    let rows = constant_rows::<T, D, _>(body, &q)?.ok_or(EquilibriumError::TooLarge)?;
    let system: &dyn MechanicalSystem<T, D> = body;
    let (mass, stiffness) = (system.mass(), system.stiffness().expect("an elastic body"));
    let sigma = proximal_weight(mass, stiffness);
    let matrix = stiffness.clone().plus(sigma, mass).leading(free);
    let mut factor = Factor::with_last(&matrix, &rows.dofs(free)).map_err(EquilibriumError::Stiffness)?;
    let jacobian = rows.rows().clone();
    let kept = rows.delassus(&mut factor, free);

    let mut problem = ConeProblem::<T, D>::default();
    let (w, _, mu) = problem.parts_mut();
    kept.all(w);
    mu.extend(
        candidates.iter().map(|candidate| friction.get(candidate.interface).copied().unwrap_or(T::zero())),
    );
    let mut r = vec![SVector::zeros(); candidates.len()];
    let mut start = r.clone();
    let (mut fixed, mut right) = (vec![T::zero(); n], vec![T::zero(); n]);
    stiffness.multiply(&q, &mut fixed);
    let mut change = T::infinity_impl();
    for _ in 0..ITERATIONS {
        let mut held = q.clone();
        held[free..].fill(T::zero());
        mass.multiply(&held, &mut right);
        for i in 0..n {
            right[i] = sigma * right[i] + force[i] - fixed[i];
        }
        let mut next = q.clone();
        next[..free].copy_from_slice(&right[..free]);
        factor.solve_in_place(&mut next[..free]);
        if !candidates.is_empty() {
            let (_, b, _) = problem.parts_mut();
            b.clear();
            for (row, candidate) in candidates.iter().enumerate() {
                let mut shifted = jacobian.velocity(row, &next);
                shifted[0] += candidate.gap;
                b.push(shifted);
            }
            start.copy_from_slice(&r);
            solver.solve(&problem, &start, &mut r)?;
            for (row, r) in r.iter().enumerate() {
                jacobian.add_transpose(row, r, &mut right);
            }
            next[..free].copy_from_slice(&right[..free]);
            factor.solve_in_place(&mut next[..free]);
        }
        let moved: Vec<T> = next.iter().zip(&q).map(|(&a, &b)| a - b).collect();
        change = max_abs(&moved);
        q = next;
        let floor = lit::<T>(CHANGE.max(64.0 * to_f64(crate::scalar::epsilon::<T>())));
        if change <= floor * max_abs(&q) {
            return Ok(q);
        }
    }
    Err(EquilibriumError::NotHeld { iterations: ITERATIONS, change: to_f64(change) })
}

/// σ small against the elastic modes, and large enough to keep K + σM regular.
fn proximal_weight<T: Scalar>(mass: &Symmetric<T>, stiffness: &Symmetric<T>) -> T {
    let trace = |operator: &Symmetric<T>| {
        operator.entries().filter(|&(i, j, _)| i == j).fold(T::zero(), |sum, (_, _, x)| sum + x)
    };
    let n = lit::<T>(mass.size() as f64);
    // The largest frequency squared is of the order of the quotient, the smallest of the quotient over n² at least.
    let weight = nalgebra::RealField::max(lit::<T>(1e-2) / (n * n), lit(1e-10));
    weight * trace(stiffness) / trace(mass)
}
