//! The cone problem: Delassus operator, Coulomb cone and its projections, residuals, one contact exactly.
//!
//! Given W, b, μ find the percussions r with
//!
//! ```text
//!   w = W r + b,    K* ∋ Φ(w) ⟂ r ∈ K,    Φ(w) = w + μ‖w_T‖ e_N     (81)
//!   K = {‖r_T‖ ≤ μ r_N},   K* = {μ‖u_T‖ ≤ u_N}
//! ```
//!
//! and with rolling resistance the same with a ball for the moments beside that of the tangents ([`Cone`]).
//!
//! Every problem has w = u_{k+1} + δ, the shifted velocity, which is not the velocity u_{k+1}.

mod block_matrix;
mod check;
pub(crate) mod cones;
mod delassus;
mod factored;
mod from_arrays;
mod one_contact;
mod precise;
mod problem;
mod spectrum;
mod status;
mod workspace;

pub use crate::laws::Cone;
pub use block_matrix::BlockMatrix;
pub use check::{DEFINITENESS_TOLERANCE, ProblemError, SPECTRUM_LIMIT, SYMMETRY_TOLERANCE};
pub use cones::{contains, de_saxce, dual_gauge, natural_map, project};
pub use delassus::{Delassus, Form, factored_pays};
pub use factored::{FactoredDelassus, FactoredError};
pub use from_arrays::ArraysError;
pub(crate) use one_contact::OneContactSolvers;
pub use one_contact::{solve_one_contact, solve_one_contact_from};
pub use problem::{ConeProblem, Residual};
pub use spectrum::largest_eigenvalue;
pub use status::{Status, StatusCount, status};
pub use workspace::Workspace;
