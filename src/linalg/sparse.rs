//! Sparse symmetric operators on faer's compressed columns, and their Cholesky factorisation.

use std::fmt;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Conj, MatMut, Par, Side};
use nalgebra::DMatrix;

use super::{FactorError, OperatorError};
use crate::scalar::{Scalar, all_finite, epsilon, lit, to_f64};

/// A sparse symmetric operator in compressed columns, both triangles stored.
#[derive(Clone, Debug)]
pub struct SparseSymmetric<T: Scalar> {
    matrix: SparseColMat<usize, T>,
}

impl<T: Scalar> SparseSymmetric<T> {
    /// From (row, column, value) triplets of both triangles; repeated entries add up. Symmetric to 64 ε of the
    /// largest entry.
    ///
    /// # Errors
    /// [`OperatorError::OutOfBounds`], [`NotFinite`](OperatorError::NotFinite),
    /// [`NotSymmetric`](OperatorError::NotSymmetric).
    pub fn from_triplets(size: usize, triplets: &[(usize, usize, T)]) -> Result<Self, OperatorError> {
        for &(row, column, value) in triplets {
            if row >= size || column >= size {
                return Err(OperatorError::OutOfBounds { row, column, size });
            }
            if !all_finite([&value]) {
                return Err(OperatorError::NotFinite { row, column });
            }
        }
        let operator = Self::assemble(size, triplets.iter().copied());
        operator.check_symmetric()?;
        Ok(operator)
    }

    /// Sums triplets whose indices are in range.
    fn assemble(size: usize, triplets: impl Iterator<Item = (usize, usize, T)>) -> Self {
        let triplets: Vec<_> = triplets.map(|(i, j, x)| Triplet::new(i, j, x)).collect();
        let matrix = SparseColMat::try_new_from_triplets(size, size, &triplets)
            .expect("the indices were checked, and running out of memory is fatal everywhere");
        Self { matrix }
    }

    pub(super) fn from_diagonal(diagonal: &[T]) -> Self {
        Self::assemble(diagonal.len(), diagonal.iter().enumerate().map(|(i, &x)| (i, i, x)))
    }

    pub(super) fn from_dense(matrix: &DMatrix<T>) -> Self {
        let n = matrix.nrows();
        let entries = (0..n).flat_map(|j| (0..n).map(move |i| (i, j, matrix[(i, j)])));
        Self::assemble(n, entries.filter(|&(i, j, x)| i == j || x != T::zero()))
    }

    pub(super) fn to_dense(&self) -> DMatrix<T> {
        let mut dense = DMatrix::zeros(self.size(), self.size());
        self.entries().for_each(|(i, j, x)| dense[(i, j)] = x);
        dense
    }

    /// self + factor·other.
    pub(super) fn plus(&self, factor: T, other: &Self) -> Self {
        let scaled = other.entries().map(|(i, j, x)| (i, j, factor * x));
        Self::assemble(self.size(), self.entries().chain(scaled))
    }

    /// The stored entries (row, column, value), column by column.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, T)> + '_ {
        (0..self.size()).flat_map(move |j| self.column(j).map(move |(i, x)| (i, j, x)))
    }

    #[inline]
    fn column(&self, j: usize) -> impl Iterator<Item = (usize, T)> + '_ {
        let range = self.matrix.col_range(j);
        self.matrix.row_idx()[range.clone()].iter().copied().zip(self.matrix.val()[range].iter().copied())
    }

    fn check_symmetric(&self) -> Result<(), OperatorError> {
        let bound = lit::<T>(64.0) * epsilon::<T>() * super::max_abs(self.matrix.val());
        for (row, column, value) in self.entries() {
            let mirror = self.column(row).find(|&(i, _)| i == column).map_or(T::zero(), |(_, x)| x);
            if nalgebra::ComplexField::abs(value - mirror) > bound {
                return Err(OperatorError::NotSymmetric { row, column, difference: to_f64(value - mirror) });
            }
        }
        Ok(())
    }

    /// Size n.
    pub fn size(&self) -> usize {
        self.matrix.ncols()
    }

    /// y ← A x; a column of A is a row of A, so every entry of y is one gather.
    pub fn multiply(&self, x: &[T], y: &mut [T]) {
        for (j, y_j) in y.iter_mut().enumerate() {
            *y_j = self.column(j).fold(T::zero(), |sum, (i, a)| sum + a * x[i]);
        }
    }
}

/// The Cholesky factors L Lᵀ of a sparse operator under a fill-reducing (AMD) order, with the scratch memory of
/// its solves.
pub struct SparseCholesky<T: Scalar> {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<T>,
    scratch: MemBuffer,
}

impl<T: Scalar> SparseCholesky<T> {
    /// Factors `a`.
    ///
    /// # Errors
    /// [`FactorError::NotPositiveDefinite`] with the pivot that failed.
    pub fn new(a: &SparseSymmetric<T>) -> Result<Self, FactorError> {
        let matrix = a.matrix.as_ref();
        let symbolic = factorize_symbolic_cholesky(
            matrix.symbolic(),
            Side::Lower,
            SymmetricOrdering::Amd,
            CholeskySymbolicParams::default(),
        )
        .map_err(|error| FactorError::Backend { message: error.to_string() })?;
        let mut values = vec![T::zero(); symbolic.len_val()];
        let mut work =
            MemBuffer::new(symbolic.factorize_numeric_llt_scratch::<T>(Par::Seq, Default::default()));
        symbolic
            .factorize_numeric_llt(
                &mut values,
                matrix,
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut work),
                Default::default(),
            )
            .map_err(|LltError::NonPositivePivot { index }| FactorError::NotPositiveDefinite {
                pivot: index,
            })?;
        let scratch = MemBuffer::new(symbolic.solve_in_place_scratch::<T>(1, Par::Seq));
        Ok(Self { symbolic, values, scratch })
    }

    /// Size n.
    pub fn size(&self) -> usize {
        self.symbolic.nrows()
    }

    /// x ← A⁻¹ x, without allocation.
    pub fn solve_in_place(&mut self, x: &mut [T]) {
        let n = self.size();
        LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(x, n, 1),
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
    }
}

impl<T: Scalar> fmt::Debug for SparseCholesky<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SparseCholesky {{ size: {}, entries: {} }}", self.size(), self.values.len())
    }
}
