//! The loop over steps, with observers and an orderly end.
//!
//! [`Stepper`] makes the steps of a scheme, of one length or under error control, in its own arithmetic and contact
//! dimension. [`Simulation`] is the same behind one object-safe face for every arithmetic and dimension, with its numbers
//! as `f64`.

mod simulation;
mod sink;
mod stepper;

pub use simulation::{Simulated, Simulation};
pub use sink::{Compiled, Sink};
pub use stepper::Stepper;

use crate::adaptive::AdaptiveError;
use crate::observe::ObserveError;
use crate::scheme::{SetupError, StepError};

/// How a run ended that nothing went wrong in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// Every step was made.
    Completed,
    /// The interrupt flag was raised; what was done is recorded.
    Interrupted,
}

/// Why a run ended early. The observers were told of the end, so that nothing computed is lost.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum SimulateError {
    /// A step could not be made.
    #[error(transparent)]
    Step(#[from] StepError),
    /// A step under error control could not be made.
    #[error(transparent)]
    Adaptive(#[from] AdaptiveError),
    /// The last step, shorter than the others, could not be set up.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// An output could not be written.
    #[error(transparent)]
    Observe(#[from] ObserveError),
}
