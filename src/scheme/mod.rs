//! The Moreau–Jean θ-scheme, for any contact law: active-set rules, cone problem, step.

mod activation;
mod delassus;
mod error;
mod theta_scheme;

pub use activation::{Activation, ActivationRule};
pub use error::{SetupError, StepError};
pub use theta_scheme::{ContactStep, Settings, State, Step, ThetaScheme};
