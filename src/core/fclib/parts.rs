//! A sparse matrix taken apart into the blocks that do not touch each other, each factored alone.

use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{MatMut, MatRef};
use nalgebra::DMatrix;

/// Parts up to this size are factored densely.
const DENSE_PART: usize = 48;

/// The connected parts of the graph of a matrix.
pub(super) struct Parts {
    rows: Vec<usize>,
    row_starts: Vec<usize>,
    entries: Vec<usize>,
    entry_starts: Vec<usize>,
}

/// Rows and places of the entries of one part.
pub(super) struct Part<'a> {
    pub(super) rows: &'a [usize],
    pub(super) entries: &'a [usize],
}

impl Parts {
    pub(super) fn of(matrix: &[(usize, usize, f64)], n: usize) -> Self {
        let mut parent: Vec<usize> = (0..n).collect();
        fn root(parent: &mut [usize], mut i: usize) -> usize {
            while parent[i] != i {
                parent[i] = parent[parent[i]];
                i = parent[i];
            }
            i
        }
        for &(i, j, _) in matrix {
            let (a, b) = (root(&mut parent, i), root(&mut parent, j));
            // The smaller index leads, so that parts come in the order of their first rows.
            if a < b { parent[b] = a } else { parent[a] = b }
        }
        let mut number = vec![0_usize; n];
        let mut count = 0;
        for i in 0..n {
            match root(&mut parent, i) {
                leader if leader == i => {
                    number[i] = count;
                    count += 1;
                }
                leader => number[i] = number[leader],
            }
        }
        let (rows, row_starts) = bucket(count, n, |i| number[i]);
        let (entries, entry_starts) = bucket(count, matrix.len(), |e| number[matrix[e].0]);
        Self { rows, row_starts, entries, entry_starts }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Part<'_>> {
        self.row_starts.windows(2).zip(self.entry_starts.windows(2)).map(|(rows, entries)| Part {
            rows: &self.rows[rows[0]..rows[1]],
            entries: &self.entries[entries[0]..entries[1]],
        })
    }
}

/// The items 0..n sorted by bucket, with the starts of the buckets.
fn bucket(buckets: usize, n: usize, of: impl Fn(usize) -> usize) -> (Vec<usize>, Vec<usize>) {
    let mut starts = vec![0_usize; buckets + 1];
    (0..n).for_each(|i| starts[of(i) + 1] += 1);
    (0..buckets).for_each(|k| starts[k + 1] += starts[k]);
    let mut next = starts.clone();
    let mut items = vec![0_usize; n];
    for i in 0..n {
        items[next[of(i)]] = i;
        next[of(i)] += 1;
    }
    (items, starts)
}

enum Inverse {
    Dense(nalgebra::LU<f64, nalgebra::Dyn, nalgebra::Dyn>),
    Sparse(Box<faer::sparse::linalg::solvers::Lu<usize, f64>>),
}

/// A factored part, with the size of its largest entry.
pub(super) struct Factor {
    inverse: Inverse,
    norm: f64,
}

impl Factor {
    pub(super) fn new(n: usize, entries: impl Iterator<Item = (usize, usize, f64)>) -> Option<Self> {
        let entries: Vec<_> = entries.collect();
        let norm = entries.iter().fold(0.0_f64, |norm, &(_, _, x)| norm.max(x.abs()));
        let inverse = if n <= DENSE_PART {
            let mut dense = DMatrix::zeros(n, n);
            entries.iter().for_each(|&(i, j, x)| dense[(i, j)] += x);
            Inverse::Dense(dense.lu())
        } else {
            let entries: Vec<_> = entries.iter().map(|&(row, col, val)| Triplet { row, col, val }).collect();
            let sparse = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &entries).ok()?;
            Inverse::Sparse(Box::new(sparse.sp_lu().ok()?))
        };
        Some(Self { inverse, norm })
    }

    /// Solves in place; false where the matrix is singular to working precision, seen by a solution as large as
    /// 1/ε times the right-hand side over the largest entry.
    pub(super) fn solve(&self, mut x: MatMut<'_, f64>) -> bool {
        let before = largest(x.as_ref());
        match &self.inverse {
            Inverse::Dense(lu) => {
                for column in 0..x.ncols() {
                    let mut rhs = DMatrix::from_fn(x.nrows(), 1, |i, _| x[(i, column)]);
                    if !lu.solve_mut(&mut rhs) {
                        return false;
                    }
                    (0..x.nrows()).for_each(|i| x[(i, column)] = rhs[i]);
                }
            }
            Inverse::Sparse(lu) => lu.solve_in_place(x.as_mut()),
        }
        let after = largest(x.as_ref());
        after.is_finite() && after * self.norm * f64::EPSILON <= before
    }
}

/// The largest entry in size, infinite where one is not a number.
fn largest(x: MatRef<'_, f64>) -> f64 {
    let size = |x: &f64| if x.is_nan() { f64::INFINITY } else { x.abs() };
    x.col_iter().flat_map(|column| column.iter()).map(size).fold(0.0, f64::max)
}
