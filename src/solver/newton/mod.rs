//! What the Newton solvers share: the maps, the linear systems in contact and body space, the inner iteration.

mod body_space;
mod contact_space;
mod inner;
mod maps;
mod refine;
mod scaled;

pub(super) use inner::{Inner, Outcome, spread};
pub(super) use maps::Map;
pub(super) use refine::Refinement;
pub(super) use scaled::Scaled;
