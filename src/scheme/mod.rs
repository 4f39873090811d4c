//! The Moreau–Jean θ-scheme, for any contact law: active-set rules, cone problem, step.

mod activation;
mod delassus;
mod equilibrium;
mod error;
mod kept;
mod record;
mod setup;
mod snapshot;
mod step;
mod theta_scheme;
mod velocity;

pub use activation::{Activation, ActivationRule};
pub use equilibrium::{EquilibriumError, equilibrium};
pub use error::{SetupError, StepError};
pub use record::{ContactStep, Part, State, Step};
pub use setup::Settings;
pub use snapshot::{RestoreError, Snapshot};
pub use theta_scheme::ThetaScheme;
