//! Problems in files: the FCLIB layout in HDF5 (Acary, Brémond, Kempner, *FCLIB: a collection of discrete 3D
//! frictional contact problems*, Inria RT-444, 2014, <https://hal.inria.fr/hal-00945820>).
//!
//! A file holds a local problem, already condensed to the contacts,
//!
//! ```text
//!   /fclib_local:   u = W r + V λ + q,   0 = Vᵀ r + R λ + s
//! ```
//!
//! or a global one, with the velocities v of the bodies,
//!
//! ```text
//!   /fclib_global:  M v = H r + G λ + f,   u = Hᵀ v + w,   0 = Gᵀ v + b
//! ```
//!
//! each with μ per contact, K* ∋ Φ(u) ⟂ r ∈ K, components in the order (N, T1, T2) or (N, T), and `spacedim` 2 or 3.
//! V, R, s and G, b (bilateral constraints) are optional. Matrices are in compressed rows (`nz = -2`), compressed
//! columns (`-1`) or triplets (`≥ 0`), 0-based. Guesses and a solution may follow.
//!
//! [`read`] returns the content as it is stored; [`Problem::cone`] makes the [`ConeProblem`](crate::cone::ConeProblem)
//! of it, and eliminates what is not a contact:
//!
//! ```text
//!   local:   W ← W − V R⁻¹ Vᵀ,     b = q − V R⁻¹ s
//!   global:  W = Hᵀ M⁻¹ H,         b = w + Hᵀ M⁻¹ f       (with G: M and G together)
//! ```
//!
//! A file is never trusted: sizes are compared before anything is allocated, a file of n bytes may unfold to at most
//! [`allowance`]`(n)` bytes, and what does not fit is an [`FclibError`] that names the dataset.

mod bodies;
mod condense;
mod error;
mod parts;
mod posed;
mod problem;
mod read;
mod sparse;
mod store;
mod write;

pub use condense::CONDENSED_LIMIT;
pub use error::FclibError;
pub use problem::{Cone, Data, Global, GlobalBilateral, Info, Local, LocalBilateral, Problem, Solution};
pub use read::{read, read_bytes};
pub use sparse::SparseMatrix;
pub use store::allowance;
pub use write::{WriteOptions, write, write_bytes, write_solution};
