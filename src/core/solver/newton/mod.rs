//! The one Newton core: equation and derivatives of a contact, scaling, linear systems over contacts or bodies, search,
//! schedule of the proximal point method, refinement of the last digits.

mod body_space;
mod contact_space;
mod inner;
mod maps;
mod proximal_point;
mod refine;
mod scaled;
mod scaling;
mod schedule;
mod watchdog;

pub use maps::Formulation;
pub(super) use proximal_point::{Plan, ProximalPoint};
pub(super) use scaled::ScaledProblem;
pub(super) use scaling::Scaling;
