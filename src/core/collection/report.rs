//! What came of a problem.

use serde::Serialize;

/// Number of contacts in each status.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Statuses {
    /// Contacts without percussion.
    pub take_off: usize,
    /// Contacts strictly inside their cone.
    pub stick: usize,
    /// Contacts on the boundary of their cone, to [`STATUS_TOLERANCE`](super::STATUS_TOLERANCE).
    pub slide: usize,
}

/// Whether a problem that was not solved had a solution to find.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Verdict {
    /// Some r brings W r + b into the interior of K*: a solution exists.
    Feasible,
    /// A direction separates: no r brings W r + b into K*.
    Infeasible,
    /// The second-order cone program did not decide.
    Undecided,
}

/// The feasibility certificate of a problem that was not solved.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Certificate {
    /// What the certificate says.
    pub verdict: Verdict,
    /// The largest t with W r + b − t b̄ e_N ∈ K* (dimensionless); not a number where there is none.
    pub margin: f64,
    /// The separating direction d ∈ K, Wᵀ d = 0, d·b < 0, of an infeasible problem.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<Vec<f64>>,
}

/// What came of one problem.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SolveReport {
    /// Name of the file without its ending.
    pub problem: String,
    /// Number of contacts.
    pub contacts: usize,
    /// Dimension of a contact.
    pub dimension: usize,
    /// Name of the solver.
    pub solver: String,
    /// Whether the scaled residual is within the tolerance.
    pub converged: bool,
    /// Iterations, in the unit of the solver.
    pub iterations: usize,
    /// Natural-map residual of the percussions, measured on the problem.
    pub residual: f64,
    /// Scaled residual of the percussions, measured on the problem.
    pub scaled_residual: f64,
    /// CPU time of the solve (s), reading the file not included.
    pub cpu_seconds: f64,
    /// What the contacts do.
    pub status: Statuses,
    /// The solver that found the percussions after the chosen one had failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rescued_by: Option<String>,
    /// Why the solver stopped, where it did not converge and it was not the budget.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Whether there was a solution to find, where the solver did not converge.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certificate: Option<Certificate>,
}
