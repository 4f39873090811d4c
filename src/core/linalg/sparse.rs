//! Sparse symmetric operators in compressed columns.

use faer::Side;
use faer::sparse::{SparseColMat, Triplet};
use nalgebra::DMatrix;

use super::error::OperatorError;
use super::slices::max_abs;
use crate::scalar::{Scalar, all_finite, epsilon, lit, to_f64};

/// A sparse symmetric operator in compressed columns, both triangles stored.
#[derive(Clone, Debug)]
pub struct SparseSymmetric<T: Scalar> {
    /// First entry of each column, and one past the last.
    starts: Vec<usize>,
    /// Half the memory of `usize`: a product is as fast as its operator is read.
    rows: Vec<u32>,
    values: Vec<T>,
    /// Whether the next column has the same rows, and is taken with this one.
    twins: Vec<bool>,
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
            if row >= size || column >= size || u32::try_from(size).is_err() {
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
        let matrix = columns(size, triplets);
        // Fits: every way in checks the size, or starts from an operator.
        let rows: Vec<u32> = matrix.row_idx().iter().map(|&row| row as u32).collect();
        let starts = matrix.col_ptr().to_vec();
        let mut twins = vec![false; size];
        for j in 1..size {
            let alike = rows[starts[j - 1]..starts[j]] == rows[starts[j]..starts[j + 1]];
            twins[j - 1] = alike && (j < 2 || !twins[j - 2]);
        }
        Self { starts, rows, values: matrix.val().to_vec(), twins }
    }

    /// One triangle of the operator with unknown i at `place[i]`.
    pub(super) fn triangle(&self, place: &[usize], side: Side) -> SparseColMat<usize, T> {
        let moved = self.entries().map(|(i, j, x)| (place[i], place[j], x));
        let inside = move |&(i, j, _): &(usize, usize, T)| if side == Side::Lower { i >= j } else { i <= j };
        columns(self.size(), moved.filter(inside))
    }

    /// The operator with an entry between any two of the unknowns `tied`, of which the pattern alone counts.
    pub(super) fn tied(&self, tied: &[usize]) -> SparseColMat<usize, T> {
        let pairs = tied.iter().flat_map(|&i| tied.iter().map(move |&j| (i, j, T::zero())));
        columns(self.size(), self.entries().chain(pairs))
    }

    /// The operator over the first `count` unknowns.
    pub(super) fn leading(&self, count: usize) -> Self {
        Self::assemble(count, self.entries().filter(|&(i, j, _)| i < count && j < count))
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
        let range = self.starts[j]..self.starts[j + 1];
        self.rows[range.clone()].iter().map(|&i| i as usize).zip(self.values[range].iter().copied())
    }

    fn check_symmetric(&self) -> Result<(), OperatorError> {
        let bound = lit::<T>(64.0) * epsilon::<T>() * max_abs(&self.values);
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
        self.starts.len() - 1
    }

    /// y ← A x; a column of A is a row of A, so every entry of y is one gather. Two rows with the same columns, as
    /// the components of a node have, share it.
    pub fn multiply(&self, x: &[T], y: &mut [T]) {
        let mut j = 0;
        while j < y.len() {
            let (start, end) = (self.starts[j], self.starts[j + 1]);
            if self.twins[j] {
                let count = end - start;
                let (first, second) = self.values[start..end + count].split_at(count);
                let (mut a, mut b) = (T::zero(), T::zero());
                for ((&i, &p), &q) in self.rows[start..end].iter().zip(first).zip(second) {
                    let x = x[i as usize];
                    a += p * x;
                    b += q * x;
                }
                (y[j], y[j + 1]) = (a, b);
                j += 2;
            } else {
                let entries = self.rows[start..end].iter().zip(&self.values[start..end]);
                y[j] = entries.fold(T::zero(), |sum, (&i, &a)| sum + a * x[i as usize]);
                j += 1;
            }
        }
    }
}

/// Compressed columns of triplets whose indices are in range; repeated entries add up.
fn columns<T: Scalar>(
    size: usize,
    triplets: impl Iterator<Item = (usize, usize, T)>,
) -> SparseColMat<usize, T> {
    let triplets: Vec<_> = triplets.map(|(i, j, x)| Triplet::new(i, j, x)).collect();
    SparseColMat::try_new_from_triplets(size, size, &triplets)
        .expect("the indices were checked, and running out of memory is fatal everywhere")
}
