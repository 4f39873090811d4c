//! Factorisations of positive definite operators: factor once, solve often, allocate nothing.

use nalgebra::{Cholesky, DMatrix, DVectorViewMut, Dyn};

use super::cholesky::SparseCholesky;
use super::error::FactorError;
use super::symmetric::Symmetric;
use crate::scalar::{Scalar, all_finite};

/// The factors of a positive definite operator, in the storage of the operator.
#[derive(Debug)]
pub enum Factor<T: Scalar> {
    /// Reciprocals of the diagonal.
    Diagonal(Vec<T>),
    /// Dense Cholesky factors.
    Dense(Cholesky<T, Dyn>),
    /// Sparse Cholesky factors.
    Sparse(Box<SparseCholesky<T>>),
}

impl<T: Scalar> Factor<T> {
    /// Factors a positive definite operator.
    ///
    /// # Errors
    /// [`FactorError::NotPositiveDefinite`] with the pivot that failed.
    pub fn new(operator: &Symmetric<T>) -> Result<Self, FactorError> {
        Self::with_last(operator, &[])
    }

    /// Factors a positive definite operator; where it is sparse, the unknowns `last` come last in the order of
    /// elimination, so that a solve can pause before them ([`SparseCholesky::last_unknowns`]).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_last(operator: &Symmetric<T>, last: &[usize]) -> Result<Self, FactorError> {
        match operator {
            // An infinite entry has no inverse, and neither has one so small that its reciprocal overflows.
            Symmetric::Diagonal(d) => match d.iter().position(|&x| !(x > T::zero() && invertible(x))) {
                Some(pivot) => Err(FactorError::NotPositiveDefinite { pivot }),
                None => Ok(Self::Diagonal(d.iter().map(|&x| T::one() / x).collect())),
            },
            Symmetric::Dense(a) => Cholesky::new(a.clone())
                .map(Self::Dense)
                .ok_or_else(|| FactorError::NotPositiveDefinite { pivot: first_bad_minor(a) }),
            Symmetric::Sparse(a) => {
                SparseCholesky::new(a, last).map(|factors| Self::Sparse(Box::new(factors)))
            }
        }
    }

    /// Size n.
    pub fn size(&self) -> usize {
        match self {
            Self::Diagonal(d) => d.len(),
            Self::Dense(c) => c.l_dirty().nrows(),
            Self::Sparse(c) => c.size(),
        }
    }

    /// x ← A⁻¹ x.
    pub fn solve_in_place(&mut self, x: &mut [T]) {
        match self {
            Self::Diagonal(d) => x.iter_mut().zip(&*d).for_each(|(x, &d)| *x *= d),
            Self::Dense(c) => {
                let n = x.len();
                c.solve_mut(&mut DVectorViewMut::from_slice(x, n));
            }
            Self::Sparse(c) => c.solve_in_place(x),
        }
    }
}

fn invertible<T: Scalar>(x: T) -> bool {
    all_finite(&[x, T::one() / x])
}

/// Size less one of the smallest leading minor that is not positive definite.
fn first_bad_minor<T: Scalar>(a: &DMatrix<T>) -> usize {
    let fails = |n: &usize| Cholesky::new(a.view((0, 0), (n + 1, n + 1)).into_owned()).is_none();
    (0..a.nrows()).find(fails).unwrap_or(a.nrows())
}
