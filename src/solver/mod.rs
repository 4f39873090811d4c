//! Solvers of the cone problem behind one door.
//!
//! A solver is one file here and one line in the `register!` call of this page. It implements
//! [`ConeSolver::iterate`] and may assume a checked problem with contacts that do not all take off; callers use
//! [`ConeSolver::solve`], which checks the data, measures the residual of the result on the problem and calls a
//! missed tolerance an error.

mod admm;
pub(crate) mod anderson;
mod complementarity;
#[cfg(feature = "clarabel")]
mod conic_program;
mod control;
#[cfg(feature = "clarabel")]
mod convex_fixed_point;
mod entry;
mod extragradient;
#[cfg(feature = "clarabel")]
mod feasibility;
mod gauss_seidel;
mod hybrid;
mod newton;
mod newton_matrix;
mod nsgs;
mod pivoting;
mod proximal_newton;
mod registry;
mod rescue;
mod scaling;
mod semismooth_newton;
mod watchdog;

use std::fmt::Debug;

use nalgebra::SVector;

use crate::cone::{ConeProblem, ProblemError, Residual};
use crate::scalar::{Scalar, all_finite, epsilon, lit, to_f64};

pub use admm::{Admm, AdmmSettings};
pub(crate) use anderson::Anderson;
pub use complementarity::Formulation;
pub use control::{Control, Progress, Stopping, StoppingError};
#[cfg(feature = "clarabel")]
pub use convex_fixed_point::{ConvexFixedPoint, ConvexFixedPointSettings, Polish};
pub use entry::{SolverEntry, family};
pub use extragradient::{Extragradient, ExtragradientSettings, Projections};
#[cfg(feature = "clarabel")]
pub use feasibility::{Feasibility, feasibility};
pub use hybrid::{Hybrid, HybridSettings};
pub use nsgs::{Nsgs, NsgsSettings, Sweep};
pub use proximal_newton::{ProximalNewton, ProximalNewtonSettings};
pub use registry::{Description, Family, SOLVERS, UnknownSolver, build, describe, families};
pub use rescue::{Attempt, Attempts, Origin, RESCUE_TIME, rescue, solve_or_rescue};
pub use semismooth_newton::{SemismoothNewton, SemismoothNewtonSettings};

/// What a successful solve reports; the residual is measured on the problem, never estimated by the solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solution<T> {
    /// Iterations of the solver, in its own unit (sweeps, Newton steps, convex programs).
    pub iterations: usize,
    /// Residual of the percussions returned, [`ConeProblem::residual`]; where rounding decides, that of
    /// [`ConeProblem::precise_residual`].
    pub residual: Residual<T>,
    /// Whether that is the tolerance asked for, or all that percussions of this precision can reach.
    pub accuracy: Accuracy<T>,
    /// The solver that found it after the chosen one had failed ([`rescue`]); `None` in the ordinary case.
    pub rescued_by: Option<&'static str>,
}

/// What a solution was accepted by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Accuracy<T> {
    /// The scaled residual is within the tolerance.
    Tolerance,
    /// The tolerance lies below what rounding leaves in working precision: the scaled residual, evaluated precisely, is
    /// within [`ConeProblem::floor`], or within the tolerance after all. Large percussions that nearly cancel make it so:
    /// light bodies between heavy ones. It excuses no tolerance below the ε of the arithmetic.
    Rounding {
        /// The floor (dimensionless).
        floor: T,
    },
}

/// Why a cone problem was not solved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// The data are not a cone problem.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// `start` or `r` has the wrong length.
    #[error("the problem has {contacts} contacts, {given} percussions were given")]
    Shape {
        /// Number of contacts.
        contacts: usize,
        /// Number of percussions given.
        given: usize,
    },
    /// The tolerance was not reached; `r` holds the best iterate.
    #[error(
        "{solver} stopped after {iterations} iterations at residual {residual:e} (natural {natural:e}), \
         tolerance {tolerance:e}{}", reason.as_deref().map(|r| format!(": {r}")).unwrap_or_default()
    )]
    NotConverged {
        /// Name of the solver.
        solver: &'static str,
        /// Iterations spent.
        iterations: usize,
        /// Scaled residual of the best iterate, measured on the problem.
        residual: f64,
        /// Natural-map residual of the best iterate.
        natural: f64,
        /// The tolerance asked for, on the scaled residual.
        tolerance: f64,
        /// What stopped the solver, where it was not the budget.
        reason: Option<String>,
    },
    /// Neither the chosen solver nor anything that was tried after it reached the tolerance.
    #[error("{0}")]
    Unsolved(Box<Attempts>),
}

/// A numerical breakdown inside a solver, in words; the best iterate is kept and measured all the same.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{message} (after {iterations} iterations)")]
pub struct Breakdown {
    /// Iterations spent before it.
    pub iterations: usize,
    /// What failed.
    pub message: String,
}

/// A solver of the cone problem w = W r + b, K* ∋ Φ(w) ⟂ r ∈ K.
pub trait ConeSolver<T: Scalar, const D: usize>: Debug + Send {
    /// Name in scene files and reports.
    fn name(&self) -> &'static str;

    /// Tolerance and budget.
    fn stopping(&self) -> &Stopping<T>;

    /// The hook a solver implements: improves `r` from where it stands until `control` says stop, and returns the
    /// number of iterations. `r` is left at the best iterate, whatever the outcome.
    ///
    /// The problem is checked, has at least one contact, and `r` has the right length and is finite.
    ///
    /// # Errors
    /// [`Breakdown`] where the arithmetic fails before the budget ends.
    fn iterate(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        control: &mut Control<'_, T>,
    ) -> Result<usize, Breakdown>;

    /// Solves `problem` from the percussions `start` (N s, one block (N, T1, T2) per contact; zeros are a cold
    /// start) and writes the solution to `r`.
    ///
    /// # Errors
    /// [`SolveError`]; where the tolerance was missed `r` holds the best iterate and the error its residual.
    fn solve(
        &mut self,
        problem: &ConeProblem<T, D>,
        start: &[SVector<T, D>],
        r: &mut [SVector<T, D>],
    ) -> Result<Solution<T>, SolveError> {
        self.solve_observed(problem, start, r, None)
    }

    /// [`solve`](Self::solve) with an observer that is told of every iteration.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    fn solve_observed(
        &mut self,
        problem: &ConeProblem<T, D>,
        start: &[SVector<T, D>],
        r: &mut [SVector<T, D>],
        observer: Option<&mut dyn FnMut(Progress<T>)>,
    ) -> Result<Solution<T>, SolveError> {
        problem.check()?;
        let contacts = problem.contacts();
        for given in [start.len(), r.len()] {
            if given != contacts {
                return Err(SolveError::Shape { contacts, given });
            }
        }
        // A start that is not finite is a cold start.
        if start.iter().all(|p| all_finite(p.iter())) {
            r.copy_from_slice(start);
        } else {
            r.fill(SVector::zeros());
        }
        let stopping = self.stopping().clone();
        let (iterations, reason) = if problem.takes_off() {
            r.fill(SVector::zeros());
            (0, None)
        } else {
            let mut control = Control::new(&stopping, observer);
            match self.iterate(problem, r, &mut control) {
                Ok(iterations) => (iterations, None),
                Err(Breakdown { iterations, message }) => (iterations, Some(message)),
            }
        };
        let residual = problem.residual(r);
        // Both tests are written so that a NaN residual fails.
        if residual.scaled <= stopping.tolerance {
            return Ok(Solution { iterations, residual, accuracy: Accuracy::Tolerance, rescued_by: None });
        }
        let floor = problem.floor(r);
        // Who asks for less than ε asks for an exact solution, which rounding is no excuse for.
        let excused = stopping.tolerance >= epsilon::<T>();
        if excused && ConeProblem::<T, D>::is_near_floor(residual.scaled, floor) {
            // Not to be confused with the rounding of its own evaluation.
            let precise = problem.precise_residual(r);
            if precise.scaled <= stopping.tolerance.max(floor) {
                let accuracy = Accuracy::Rounding { floor };
                return Ok(Solution { iterations, residual: precise, accuracy, rescued_by: None });
            }
        }
        Err(SolveError::NotConverged {
            solver: self.name(),
            iterations,
            residual: to_f64(residual.scaled),
            natural: to_f64(residual.natural),
            tolerance: to_f64(stopping.tolerance),
            reason,
        })
    }
}

/// Name of the solver taken where none is chosen.
pub const DEFAULT: &str = "hybrid";

/// The default tolerance on the scaled residual: 1e-10, or 64 ε where the scalar cannot resolve that.
pub fn default_tolerance<T: Scalar>() -> T {
    let floor = lit::<T>(64.0) * epsilon::<T>();
    let wanted = lit::<T>(1e-10);
    if wanted > floor { wanted } else { floor }
}
