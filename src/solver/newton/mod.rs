//! What the Newton solvers share: the Alart–Curnier map, the linear system in contact space, the inner iteration.

mod alart_curnier;
mod contact_space;
mod inner;
mod scaled;

pub(super) use inner::{Inner, Outcome};
pub(super) use scaled::Scaled;
