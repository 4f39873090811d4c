//! Symmetric operators: diagonal, dense and sparse behind one face.

use nalgebra::DMatrix;

use super::error::OperatorError;
use super::slices::{axpy, max_abs};
use super::sparse::SparseSymmetric;
use crate::scalar::{Scalar, all_finite, epsilon, lit, to_f64};

/// A symmetric n×n operator: mass M, damping C or stiffness K. A diagonal one stays diagonal.
#[derive(Debug, Clone)]
pub enum Symmetric<T: Scalar> {
    /// The diagonal entries.
    Diagonal(Vec<T>),
    /// All entries.
    Dense(DMatrix<T>),
    /// Compressed columns, both triangles.
    Sparse(SparseSymmetric<T>),
}

impl<T: Scalar> Symmetric<T> {
    /// A diagonal operator.
    ///
    /// # Errors
    /// [`OperatorError::NotFinite`].
    pub fn diagonal(entries: Vec<T>) -> Result<Self, OperatorError> {
        match entries.iter().position(|x| !all_finite([x])) {
            Some(row) => Err(OperatorError::NotFinite { row, column: row }),
            None => Ok(Self::Diagonal(entries)),
        }
    }

    /// A dense operator, symmetric to 64 ε of its largest entry; the symmetric part is kept.
    ///
    /// # Errors
    /// [`OperatorError::NotSquare`], [`NotFinite`](OperatorError::NotFinite),
    /// [`NotSymmetric`](OperatorError::NotSymmetric).
    pub fn dense(matrix: DMatrix<T>) -> Result<Self, OperatorError> {
        let (rows, columns) = matrix.shape();
        if rows != columns {
            return Err(OperatorError::NotSquare { rows, columns });
        }
        let pairs = || (0..columns).flat_map(|j| (0..=j).map(move |i| (i, j)));
        let bad = |&(i, j): &(usize, usize)| !all_finite([&matrix[(i, j)], &matrix[(j, i)]]);
        if let Some((row, column)) = pairs().find(bad) {
            return Err(OperatorError::NotFinite { row, column });
        }
        let bound = lit::<T>(64.0) * epsilon::<T>() * max_abs(matrix.as_slice());
        let difference = |(i, j): (usize, usize)| matrix[(i, j)] - matrix[(j, i)];
        if let Some(at) = pairs().find(|&at| nalgebra::ComplexField::abs(difference(at)) > bound) {
            let difference = to_f64(difference(at));
            return Err(OperatorError::NotSymmetric { row: at.0, column: at.1, difference });
        }
        let symmetric = (&matrix + matrix.transpose()) * lit::<T>(0.5);
        Ok(Self::Dense(symmetric))
    }

    /// A sparse operator from (row, column, value) triplets of both triangles; repeated entries add up.
    ///
    /// # Errors
    /// [`OperatorError::OutOfBounds`], [`NotFinite`](OperatorError::NotFinite),
    /// [`NotSymmetric`](OperatorError::NotSymmetric).
    pub fn sparse(size: usize, triplets: &[(usize, usize, T)]) -> Result<Self, OperatorError> {
        SparseSymmetric::from_triplets(size, triplets).map(Self::Sparse)
    }

    /// Blocks one after another on the diagonal, each an operator or none of the given size; `None` where all are absent.
    pub(crate) fn block_diagonal<'a>(
        blocks: impl Iterator<Item = (Option<&'a Self>, usize)> + Clone,
    ) -> Option<Self>
    where
        T: 'a,
    {
        if blocks.clone().all(|(block, _)| block.is_none()) {
            return None;
        }
        if blocks.clone().all(|(block, _)| matches!(block, None | Some(Self::Diagonal(_)))) {
            let mut diagonal = Vec::new();
            for (block, size) in blocks {
                match block {
                    Some(Self::Diagonal(entries)) => diagonal.extend(entries),
                    _ => diagonal.resize(diagonal.len() + size, T::zero()),
                }
            }
            return Some(Self::Diagonal(diagonal));
        }
        let (mut first, mut entries) = (0, Vec::new());
        for (block, size) in blocks {
            let block = block.into_iter().flat_map(Self::entries);
            entries.extend(block.map(|(i, j, x)| (first + i, first + j, x)));
            first += size;
        }
        // The entries are those of symmetric operators.
        Self::sparse(first, &entries).ok()
    }

    /// Size n.
    pub fn size(&self) -> usize {
        match self {
            Self::Diagonal(d) => d.len(),
            Self::Dense(a) => a.nrows(),
            Self::Sparse(a) => a.size(),
        }
    }

    /// y ← A x.
    pub fn multiply(&self, x: &[T], y: &mut [T]) {
        match self {
            Self::Diagonal(d) => y.iter_mut().zip(d).zip(x).for_each(|((y, &d), &x)| *y = d * x),
            Self::Dense(a) => {
                y.fill(T::zero());
                // Column by column: contiguous, and A = Aᵀ.
                for (j, &x_j) in x.iter().enumerate() {
                    axpy(y, x_j, a.column(j).as_slice());
                }
            }
            Self::Sparse(a) => a.multiply(x, y),
        }
    }

    /// The operator over the first `count` unknowns.
    pub fn leading(&self, count: usize) -> Self {
        match self {
            Self::Diagonal(d) => Self::Diagonal(d[..count].to_vec()),
            Self::Dense(a) => Self::Dense(a.view((0, 0), (count, count)).into_owned()),
            Self::Sparse(a) => Self::Sparse(a.leading(count)),
        }
    }

    /// The stored entries (row, column, value) of both triangles, column by column.
    pub fn entries(&self) -> Box<dyn Iterator<Item = (usize, usize, T)> + '_> {
        match self {
            Self::Diagonal(d) => Box::new(d.iter().enumerate().map(|(i, &x)| (i, i, x))),
            Self::Dense(a) => {
                let n = a.nrows();
                Box::new((0..n).flat_map(move |j| (0..n).map(move |i| (i, j, a[(i, j)]))))
            }
            Self::Sparse(a) => Box::new(a.entries()),
        }
    }

    /// The sum `self + factor·other`, in the sparsest storage that holds it.
    pub fn plus(self, factor: T, other: &Self) -> Self {
        match (self, other) {
            (Self::Diagonal(mut a), Self::Diagonal(b)) => {
                axpy(&mut a, factor, b);
                Self::Diagonal(a)
            }
            (Self::Dense(a), b) => Self::Dense(a + b.to_dense() * factor),
            (a, Self::Dense(b)) => Self::Dense(a.to_dense() + b * factor),
            (a, b) => Self::Sparse(a.to_sparse().plus(factor, &b.to_sparse())),
        }
    }

    fn to_dense(&self) -> DMatrix<T> {
        match self {
            Self::Diagonal(d) => {
                let n = d.len();
                DMatrix::from_fn(n, n, |i, j| if i == j { d[i] } else { T::zero() })
            }
            Self::Dense(a) => a.clone(),
            Self::Sparse(a) => a.to_dense(),
        }
    }

    fn to_sparse(&self) -> SparseSymmetric<T> {
        match self {
            Self::Diagonal(d) => SparseSymmetric::from_diagonal(d),
            Self::Dense(a) => SparseSymmetric::from_dense(a),
            Self::Sparse(a) => a.clone(),
        }
    }
}
