//! What the Newton solvers share: the Alart–Curnier map, the linear system in contact space, the inner iteration.

mod contact_space;
mod inner;
mod maps;
mod scaled;

pub(super) use inner::{Inner, Outcome};
pub use maps::Map;
pub(super) use scaled::Scaled;
