//! Why a cone problem was not solved, in types that carry their numbers.

use std::fmt;

use super::newton::Formulation;
use super::{SettingsError, StoppingError};
use crate::cone::ProblemError;
use crate::linalg::NoPivot;

/// Why a cone problem was not solved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
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
         tolerance {tolerance:e}{}", reason.as_ref().map(|r| format!(": {r}")).unwrap_or_default()
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
        reason: Option<BreakdownCause>,
    },
    /// Neither the chosen solver nor anything that was tried after it reached the tolerance.
    #[error("{0}")]
    Unsolved(Box<RescueFailure>),
}

/// A numerical breakdown inside a solver; the best iterate is kept and measured all the same.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{cause} (after {iterations} iterations)")]
pub struct Breakdown {
    /// Iterations spent before it.
    pub iterations: usize,
    /// What failed.
    pub cause: BreakdownCause,
}

impl Breakdown {
    /// A breakdown after so many iterations.
    pub fn new(iterations: usize, cause: BreakdownCause) -> Self {
        Self { iterations, cause }
    }
}

/// What failed inside a solver.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BreakdownCause {
    /// Entries of W or b are so large or so small that the scaled problem is not finite.
    #[error("the scaled problem is not finite")]
    NotFinite,
    /// A linear system has no solution; the node is a contact, or a block of velocities.
    #[error("the matrix is singular")]
    Singular(#[source] NoPivot),
    /// Newton's method made no progress, and no fallback was allowed.
    #[error("stagnation of the {formulation:?} equation")]
    Stagnation {
        /// The equation it was solving.
        formulation: Formulation,
    },
    /// No start led to a solution.
    #[error("{starts} starts did not lead to a solution")]
    Starts {
        /// How many were tried.
        starts: usize,
    },
    /// No percussions bring every velocity into K*, by [`feasibility`](super::feasibility); a convex program had no
    /// solution.
    #[cfg(feature = "clarabel")]
    #[error("no percussion brings every velocity into K* (scaled margin {margin:.3e}): clarabel {status:?}")]
    Separated {
        /// The scaled margin, negative.
        margin: f64,
        /// How clarabel ended.
        status: clarabel::solver::SolverStatus,
    },
    /// A convex program was not solved.
    #[cfg(feature = "clarabel")]
    #[error("clarabel stopped with {status:?}")]
    Program {
        /// How clarabel ended.
        status: clarabel::solver::SolverStatus,
    },
    /// A convex program was refused.
    #[cfg(feature = "clarabel")]
    #[error("the convex program was refused")]
    Refused(#[source] ProgramError),
}

/// An error of the convex solver, shared so that errors can be copied; equal to its copies alone.
#[cfg(feature = "clarabel")]
#[derive(Debug, Clone, thiserror::Error)]
#[error("{0}")]
pub struct ProgramError(#[source] std::sync::Arc<dyn std::error::Error + Send + Sync>);

#[cfg(feature = "clarabel")]
impl ProgramError {
    pub(super) fn new(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self(std::sync::Arc::new(error))
    }
}

#[cfg(feature = "clarabel")]
impl PartialEq for ProgramError {
    fn eq(&self, other: &Self) -> bool {
        std::sync::Arc::ptr_eq(&self.0, &other.0)
    }
}

/// Where an attempt of a rescue started.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Origin {
    /// r = 0.
    Zero,
    /// The percussions of the step before the last.
    Older,
    /// The best percussions so far.
    Best,
    /// Lemke's complementary pivoting.
    Pivoting,
    /// A solution with b and μ changed by this much, relative.
    Perturbed(f64),
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Zero => f.write_str("from zero"),
            Self::Older => f.write_str("from older percussions"),
            Self::Best => f.write_str("from the best percussions"),
            Self::Pivoting => f.write_str("after complementary pivoting"),
            Self::Perturbed(by) => write!(f, "from data changed by {by:e}"),
        }
    }
}

/// An attempt of a rescue that failed.
#[derive(Debug, Clone, PartialEq)]
pub struct RescueAttempt {
    /// The solver.
    pub solver: &'static str,
    /// Where it started.
    pub origin: Origin,
    /// Scaled residual it reached, measured on the problem.
    pub residual: f64,
}

/// The attempts of a rescue that failed, in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct RescueFailure {
    /// The failure of the chosen solver.
    pub first: SolveError,
    /// What else was tried.
    pub others: Vec<RescueAttempt>,
    /// The scaled margin by which no percussions of moderate size bring every velocity into K*: negative, where certain.
    pub margin: Option<f64>,
}

impl fmt::Display for RescueFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.first)?;
        let best = self.others.iter().min_by(|a, b| a.residual.total_cmp(&b.residual));
        if let Some(RescueAttempt { solver, origin, residual }) = best {
            let count = self.others.len();
            write!(f, "; of {count} further attempts the best, {solver} {origin}, reached {residual:e}")?;
        }
        if let Some(margin) = self.margin {
            write!(
                f,
                "; the bodies are wedged: no percussions of moderate size bring every velocity into K* (scaled margin {margin:.1e})"
            )?;
        }
        Ok(())
    }
}

/// No solver of this name is registered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum UnknownSolver {
    /// The name is not in the registry.
    #[error("no solver is called `{name}` (known: {known})")]
    Name {
        /// The name given.
        name: String,
        /// The registered names.
        known: String,
    },
    /// The solver is not there in this arithmetic and contact dimension.
    #[error("solver `{solver}` cannot be had in {scalar} with contacts of dimension {dimension}")]
    Unsupported {
        /// Name of the solver.
        solver: &'static str,
        /// The arithmetic.
        scalar: &'static str,
        /// Contact dimension.
        dimension: usize,
    },
    /// The stopping rule is out of range.
    #[error(transparent)]
    Stopping(#[from] StoppingError),
    /// The method refuses its own defaults.
    #[error(transparent)]
    Settings(#[from] SettingsError),
}
