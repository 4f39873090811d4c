//! Why a motion could not be integrated.

use super::Motion;
use crate::contact::ImproperResponse;
use crate::linalg::FactorError;
use crate::solver::{SolveError, StoppingError};

/// Why the integration ended early, when, and what was found up to there.
#[derive(Debug, Clone, thiserror::Error)]
#[error("at t = {time} s: {failure}")]
pub struct EventError {
    /// When (s).
    pub time: f64,
    /// Why.
    pub failure: EventFailure,
    /// The motion up to `time`; `None` where the input was refused.
    pub motion: Option<Box<Motion>>,
}

/// Why a motion could not be integrated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EventFailure {
    /// The system is of a kind the integrator does not know.
    #[error("event-driven integration is not made for {what}")]
    Unsupported {
        /// Joints, nonlinear terms, prescribed degrees of freedom, contacts of dimension 3.
        what: &'static str,
    },
    /// A vector or the list of laws has the wrong length.
    #[error("{what} has {given} entries, it must have {expected}")]
    Size {
        /// `q`, `v` or `laws`.
        what: &'static str,
        /// Its length.
        given: usize,
        /// The length it should have.
        expected: usize,
    },
    /// A number is outside its range.
    #[error("{what} is {value}, it must be {range}")]
    OutOfRange {
        /// What it is.
        what: String,
        /// The value refused.
        value: f64,
        /// The range in words.
        range: &'static str,
    },
    /// The mass is not positive definite.
    #[error("mass: {0}")]
    Mass(FactorError),
    /// The stopping rule of the solver is out of range.
    #[error(transparent)]
    Stopping(#[from] StoppingError),
    /// Bodies overlap at the start.
    #[error("contact {contact} overlaps at the start: its gap is {gap} m")]
    Overlap {
        /// The contact.
        contact: String,
        /// Its gap (m).
        gap: f64,
    },
    /// A gap or a Jacobian is not a number, or names a degree of freedom that does not exist.
    #[error("the {what} of contact {contact} is not finite or out of bounds")]
    NotFinite {
        /// `gap` or `Jacobian`.
        what: &'static str,
        /// The contact.
        contact: String,
    },
    /// Positions or velocities are so large that their energy is not finite.
    #[error("the energy is {energy} J")]
    Energy {
        /// The energy (J).
        energy: f64,
    },
    /// A law gives no cone problem.
    #[error(transparent)]
    Law(#[from] ImproperResponse),
    /// A cone problem was not solved.
    #[error("cone problem: {0}")]
    Solver(SolveError),
    /// The closed contacts have no forces and no percussions consistent with their modes: Painlevé's paradox, or an impact
    /// of contacts that wedge one another, whose law no velocity satisfies.
    #[error(
        "no forces and no percussions of the {contacts} closed contacts satisfy their laws (Painlevé, or a wedge)"
    )]
    Inconsistent {
        /// Number of closed contacts.
        contacts: usize,
    },
    /// The step became too small.
    #[error("the motion is not resolved by steps of {step} s")]
    StepTooSmall {
        /// The step refused (s).
        step: f64,
    },
    /// The function that would tell an event varies too fast.
    #[error("the next event is not resolved, {after} s after the last one")]
    Unresolved {
        /// Time since the start of the piece (s).
        after: f64,
    },
    /// Events follow each other without the time moving on: the modes of redundant contacts do not settle.
    #[error("{count} events without progress in time")]
    Stalled {
        /// How many.
        count: usize,
    },
    /// More steps than allowed: the span is long for what moves in it.
    #[error("more than {limit} steps, the last of {step} s")]
    TooManySteps {
        /// The limit set.
        limit: usize,
        /// The last step (s).
        step: f64,
    },
    /// More events than allowed.
    #[error("more than {limit} events")]
    TooMany {
        /// The limit set.
        limit: usize,
    },
}
