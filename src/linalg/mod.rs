//! Symmetric operators with one face over their storages, their factorisations, and block rows.

mod block_rows;
mod cholesky;
mod compensated;
mod error;
mod factor;
mod front;
mod multifrontal;
mod panel;
mod slices;
mod sparse;
mod symbolic;
mod symmetric;

pub use block_rows::BlockRows;
pub use cholesky::SparseCholesky;
pub(crate) use compensated::Compensated;
pub use error::{FactorError, NoPivot, OperatorError, PatternError};
pub use factor::Factor;
pub use multifrontal::{Multifrontal, SolveBuffers};
pub(crate) use slices::sums;
pub use slices::{axpy, dot, max_abs};
pub use sparse::SparseSymmetric;
pub use symmetric::Symmetric;
