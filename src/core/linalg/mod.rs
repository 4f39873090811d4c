//! Symmetric operators with one face over their storages, their factorisations, block rows, and the LU of block matrices.
//!
//! Sparse factors are faer's but for [`Multifrontal`], which factors the Newton systems of the cone solvers. It stays
//! because it leaves out open contacts without a new ordering, works on whole blocks and pivots within fronts only:
//! `cargo bench --bench sparse_lu` factors and solves W + 10⁻⁴ I of walls and packings by both, one thread. faer's sparse
//! LU takes 2.7 to 3.9 times as long with every contact closed (368 to 2,563 contacts), 12 to 35 times as long where
//! half of them are open.

mod block_rows;
mod cholesky;
mod compensated;
mod error;
mod factor;
pub(crate) mod forest;
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
