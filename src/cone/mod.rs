//! The cone problem: Delassus operator, Coulomb cone and its projections, residuals, one contact exactly.
//!
//! Given W, b, μ find the percussions r with
//!
//! ```text
//!   w = W r + b,    K* ∋ Φ(w) ⟂ r ∈ K,    Φ(w) = w + μ‖w_T‖ e_N     (81)
//!   K = {‖r_T‖ ≤ μ r_N},   K* = {μ‖u_T‖ ≤ u_N}
//! ```
//!
//! Every problem has w = u_{k+1} + δ, the shifted velocity, which is not the velocity u_{k+1}.

mod block_matrix;
mod coulomb;
mod factored;
mod from_arrays;
mod one_contact;
mod precise;
mod problem;
mod product;

pub use block_matrix::BlockMatrix;
pub(crate) use coulomb::tangential_norm;
pub use coulomb::{Status, StatusCount};
pub use coulomb::{de_saxce, largest_eigenvalue, natural_map, project, status};
pub use factored::{FactoredDelassus, FactoredError};
pub use from_arrays::ArraysError;
pub(crate) use one_contact::OneContactSolvers;
pub use one_contact::{solve_one_contact, solve_one_contact_from};
pub use problem::{
    ConeProblem, DEFINITENESS_TOLERANCE, Form, ProblemError, Residual, SPECTRUM_LIMIT, SYMMETRY_TOLERANCE,
};
pub(crate) use product::Product;
