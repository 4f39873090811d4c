//! What a contact law is: the door every law comes through, those of the crate `laws` and those of one's own.
//!
//! A [`ContactLaw`] is a few numbers in and a few numbers out: from the local velocity at the start of the
//! step and the scheme parameter θ it gives the velocity at which the Coulomb inclusion is written,
//!
//! ```text
//!   û = γ u_{k+1} + (1 − γ) u_k + s,        −Φ(û) ∈ N_K(p),        Φ(w) = w + μ‖w_T‖ e_N
//! ```
//!
//! A contact that lasts is no impact; a law says what it answers to one, and most say [`Response::lasting`].
//!
//! It sees neither the Delassus operator, nor the solver, nor the state.

mod cone;
mod entry;
mod law;
mod parameter;
mod scalar;

pub use cone::{Cone, Rows};
pub use entry::{LawEntry, family};
pub use law::{Approach, ContactLaw, Passage, Response};
pub use parameter::{Description, FRICTION, LawError, LawFamily, Parameter, RESTITUTION};
pub use scalar::Scalar;
