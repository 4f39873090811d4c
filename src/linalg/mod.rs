//! Symmetric operators with one face over their storages, their factorisations, and block rows.

mod block_rows;
mod cholesky;
mod compensated;
mod factor;
mod front;
mod multifrontal;
mod sparse;
mod symbolic;
mod symmetric;

pub use block_rows::BlockRows;
pub use cholesky::SparseCholesky;
pub(crate) use compensated::Compensated;
pub use factor::{Factor, FactorError};
pub(crate) use multifrontal::{Multifrontal, SolveBuffers};
pub use sparse::SparseSymmetric;
pub use symmetric::{OperatorError, Symmetric};

use crate::scalar::Scalar;

/// Σ xᵢ yᵢ.
#[inline]
pub fn dot<T: Scalar>(x: &[T], y: &[T]) -> T {
    x.iter().zip(y).fold(T::zero(), |sum, (&a, &b)| sum + a * b)
}

/// y ← y + a x.
#[inline]
pub fn axpy<T: Scalar>(y: &mut [T], a: T, x: &[T]) {
    y.iter_mut().zip(x).for_each(|(y, &x)| *y += a * x);
}

/// max |xᵢ|; 0 for an empty slice.
pub fn max_abs<T: Scalar>(x: &[T]) -> T {
    x.iter().fold(T::zero(), |max, &x| nalgebra::RealField::max(max, nalgebra::ComplexField::abs(x)))
}
