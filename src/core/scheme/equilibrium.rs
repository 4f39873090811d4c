//! Static equilibrium with contacts: the preload that the cone solver resolves.

use nalgebra::SVector;

use super::SetupError;
use super::kept::{ConstantRows, constant_rows};
use crate::cone::{Cone, ConeProblem};
use crate::contact::Candidate;
use crate::linalg::{Factor, FactorError, Symmetric, axpy, max_abs};
use crate::scalar::{Scalar, epsilon, lit, to_f64};
use crate::solver::anderson::{Anderson, MAX_DEPTH};
use crate::solver::{ConeSolver, SolveError, solve_or_rescue};
use crate::system::{Contacts, Dynamics, ElasticBody, System};

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
        "no static equilibrium after {iterations} iterations: {free}, and {residual:e} of the loads is left; hold more of it"
    )]
    NotHeld {
        /// Iterations made.
        iterations: usize,
        /// What still moves, in words.
        free: String,
        /// What is left of K q = F + Hᵀ r, against the loads (dimensionless).
        residual: f64,
    },
}

/// Most iterations; those after which an iteration that has not halved what is left will not do so any more.
const ITERATIONS: usize = 500;
const STAGNATION: usize = 40;

/// What may be left of K q = F + Hᵀ r against the loads: in tolerances of the solver, in ε, and where rounding leaves no
/// less.
const TOLERANCES: f64 = 10.0;
const ROUNDINGS: f64 = 256.0;
const ENOUGH: f64 = 1e-8;

/// σ is raised where b, the gaps without contact forces, exceeds the displacements by more than this: the solver solves to
/// a share of b. And how often.
const LARGE: f64 = 16.0;
const RAISED: usize = 6;

/// The equilibrium K q = F + Hᵀ r at `time`, with the contact forces r of
///
/// ```text
///   w = (g(q), s(q)),     K* ∋ Φ(w) ⟂ r ∈ K
/// ```
///
/// where g is the gap and s the slip from the undeformed place, `friction[i]` that of interface i. The constant
/// forces act where `with_constant_forces`. A body that contacts alone hold has a singular K; the iteration
///
/// ```text
///   (K + σM) q_{j+1} = F + σM q_j + Hᵀ r
/// ```
///
/// proximal in the norm of M, needs no more, with Anderson acceleration of q_j. It ends where σM (q_{j+1} − q_j), which is
/// what is left of K q = F + Hᵀ r, is within the tolerance of the solver, a few times, of the loads. σ starts small against
/// the elastic modes and is raised until the gaps that the body would have without contact, F/σ, are of the size of its
/// displacements: the contacts are solved to a share of those.
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
    let n = body.dofs();
    let mut q = vec![T::zero(); n];
    let mut force = vec![T::zero(); n];
    let forces = body.forces();
    forces.at(time, &mut force);
    if !with_constant_forces {
        axpy(&mut force, -T::one(), forces.constant_part());
    }
    let mut candidates: Vec<Candidate<T>> = Vec::new();
    Contacts::<T, D>::candidates(body, &q, T::infinity_impl(), &mut candidates);
    candidates.sort_unstable_by_key(|candidate| candidate.id);
    let mut free = n;
    if let Some(prescribed) = body.prescribed() {
        free = prescribed.first();
        (0..prescribed.count()).for_each(|i| q[free + i] = prescribed.displacement(i, time));
    }
    let rows = constant_rows::<T, D>(body, &q)?.ok_or(EquilibriumError::TooLarge)?;
    let system: &dyn System<T, D> = body;
    let (mass, stiffness) = (system.mass(), system.stiffness().expect("an elastic body"));
    let jacobian = rows.rows().clone();
    let mut problem = ConeProblem::<T, D>::default();
    let (_, _, cones) = problem.parts_mut();
    cones.extend(
        candidates
            .iter()
            .map(|candidate| Cone::from(friction.get(candidate.interface).copied().unwrap_or(T::zero()))),
    );
    let mut sigma = proximal_weight(mass, stiffness);
    let mut factor = regularised((mass, stiffness), sigma, &rows, free, &mut problem)?;

    let mut r = vec![SVector::zeros(); candidates.len()];
    let mut start = r.clone();
    let [mut fixed, mut right, mut left] = std::array::from_fn(|_| vec![T::zero(); n]);
    stiffness.multiply(&q, &mut fixed);
    let mut anderson = Anderson::new(MAX_DEPTH);
    anderson.prepare(free);
    let tolerance = nalgebra::RealField::max(
        lit::<T>(TOLERANCES) * solver.stopping().tolerance,
        lit::<T>(ROUNDINGS) * epsilon::<T>(),
    );
    let (mut best, mut least, mut mark, mut since, mut raised) =
        (q.clone(), T::infinity_impl(), T::infinity_impl(), 0, 0);
    let mut made = 0;
    while made < ITERATIONS && since < STAGNATION {
        made += 1;
        let mut held = q.clone();
        held[free..].fill(T::zero());
        mass.multiply(&held, &mut right);
        for i in 0..n {
            right[i] = sigma * right[i] + force[i] - fixed[i];
        }
        let mut next = q.clone();
        next[..free].copy_from_slice(&right[..free]);
        factor.solve_in_place(&mut next[..free]);
        let mut load = T::zero();
        (0..free).for_each(|i| load += (force[i] - fixed[i]) * (force[i] - fixed[i]));
        let mut gaps = T::zero();
        if !candidates.is_empty() {
            let (_, b, _) = problem.parts_mut();
            b.clear();
            for (row, candidate) in candidates.iter().enumerate() {
                let mut shifted = jacobian.velocity(row, &next);
                shifted[0] += candidate.gap;
                gaps = nalgebra::RealField::max(gaps, shifted.amax());
                b.push(shifted);
            }
            start.copy_from_slice(&r);
            solve_or_rescue(solver, &problem, (&start, &[]), &mut r)?;
            left.fill(T::zero());
            for (row, r) in r.iter().enumerate() {
                jacobian.add_transpose(row, r, &mut left);
            }
            left[..free].iter().for_each(|&x| load += x * x);
            axpy(&mut right, T::one(), &left);
            next[..free].copy_from_slice(&right[..free]);
            factor.solve_in_place(&mut next[..free]);
        }
        let mut moved: Vec<T> = next.iter().zip(&q).map(|(&a, &b)| a - b).collect();
        moved[free..].fill(T::zero());
        mass.multiply(&moved, &mut left);
        let square = left[..free].iter().fold(T::zero(), |sum, &x| sum + x * x);
        let sizes = [square, load].map(nalgebra::ComplexField::sqrt);
        let residual = if square == T::zero() { T::zero() } else { sigma * sizes[0] / sizes[1] };
        let size = max_abs(&next);
        let large = lit::<T>(LARGE) * size;
        if gaps > large && size > T::zero() && raised < RAISED {
            sigma *= lit::<T>(0.25) * gaps / size;
            factor = regularised((mass, stiffness), sigma, &rows, free, &mut problem)?;
            raised += 1;
            q = next;
            r.fill(SVector::zeros());
            anderson.forget();
            (least, mark, since) = (T::infinity_impl(), T::infinity_impl(), 0);
            continue;
        }
        if residual < least {
            least = residual;
            best.copy_from_slice(&next);
        }
        if residual <= tolerance {
            return Ok(next);
        }
        if residual < mark * lit::<T>(0.5) {
            (mark, since) = (residual, 0);
        } else {
            since += 1;
        }
        let from = q;
        q = next;
        anderson.accelerate(&from[..free], &mut q[..free], std::iter::repeat(T::one()));
        if !crate::scalar::all_finite(&q) {
            break;
        }
        if since == STAGNATION && least > lit(ENOUGH) {
            let free = free_motion::<T, D>(body, &moved);
            return Err(EquilibriumError::NotHeld { iterations: made, free, residual: to_f64(least) });
        }
    }
    if least <= lit(ENOUGH) {
        return Ok(best);
    }
    let free = "the body still moves".into();
    Err(EquilibriumError::NotHeld { iterations: made, free, residual: to_f64(least) })
}

/// The factors of K + σM over what is free, with W formed of them.
fn regularised<T: Scalar, const D: usize>(
    (mass, stiffness): (&Symmetric<T>, &Symmetric<T>),
    sigma: T,
    rows: &ConstantRows<T, D>,
    free: usize,
    problem: &mut ConeProblem<T, D>,
) -> Result<Factor<T>, EquilibriumError> {
    let matrix = stiffness.clone().plus(sigma, mass).leading(free);
    let mut factor = Factor::with_last(&matrix, &rows.dofs(free)).map_err(EquilibriumError::Stiffness)?;
    rows.clone().delassus(&mut factor, free).all(problem.parts_mut().0);
    Ok(factor)
}

/// What the displacements `moved` do to the body, in words.
fn free_motion<T: Scalar, const D: usize>(body: &ElasticBody<T>, moved: &[T]) -> String {
    let geometry = body.geometry();
    let nodes = geometry.mesh().nodes().len();
    let largest = max_abs(moved);
    let along = (0..geometry.mesh().dimension()).filter(|&axis| {
        let sum = (0..nodes).fold(T::zero(), |sum, node| sum + moved[geometry.dof(node, axis)]);
        nalgebra::ComplexField::abs(sum) > lit::<T>(0.3 * nodes as f64) * largest
    });
    let along: Vec<&str> = along.map(|axis| ["x", "y", "z"][axis]).collect();
    if along.is_empty() {
        "the body turns or slips".into()
    } else {
        format!("nothing holds the body along {}", along.join(" and "))
    }
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
