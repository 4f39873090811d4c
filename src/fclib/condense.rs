//! From bodies to contacts: W = Hᵀ K⁻¹ H, part by part of K.
//!
//! K is split into the parts that do not touch each other (bodies, or structures held together by stiffness or
//! joints); each is factored alone, and only the contacts it touches meet in W. So W has the sparsity of the contact
//! graph, and a thousand bodies cost a thousand small factorisations.

use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, MatMut, MatRef};
use nalgebra::DMatrix;

use super::problem::{Global, Local};
use super::{FclibError, SparseMatrix};

/// Largest number of scalar entries of a condensed W (2²⁶, 1 GiB while it is assembled): beyond, every contact meets
/// thousands of others through one body, and a solver that keeps M and H is the right one.
pub const CONDENSED_LIMIT: u64 = 1 << 26;

/// Parts up to this size are factored densely.
const DENSE_PART: usize = 48;

/// Right-hand sides solved at a time.
const BATCH: usize = 64;

/// W and b of a global problem.
///
/// With G, K = [M, G; Gᵀ, 0] acts on (v, −λ) and H, f are padded with 0 and −b.
pub(super) fn condense_global(global: &Global) -> Result<(SparseMatrix, Vec<f64>), FclibError> {
    let n = global.force.len();
    let mut matrix: Vec<_> = global.mass.entries().collect();
    let mut force = global.force.clone();
    let mut name = "M";
    if let Some(bilateral) = &global.bilateral {
        name = "[M G; Gᵀ 0]";
        for (i, j, x) in bilateral.directions.entries() {
            matrix.push((i, n + j, x));
            matrix.push((n + j, i, x));
        }
        force.extend(bilateral.velocity.iter().map(|b| -b));
    }
    let mut b = global.velocity.clone();
    let w = schur(&matrix, &global.directions, &force, name, &mut b)?;
    Ok((SparseMatrix::from_entries(b.len(), b.len(), &w), b))
}

/// W − V R⁻¹ Vᵀ and q − V R⁻¹ s.
pub(super) fn condense_local(local: &Local) -> Result<(SparseMatrix, Vec<f64>), FclibError> {
    let mut b = local.velocity.clone();
    let mut entries: Vec<_> = local.delassus.entries().map(|(i, j, x)| (i as u32, j as u32, x)).collect();
    if let Some(bilateral) = &local.bilateral {
        // Hᵀ K⁻¹ H with H = Vᵀ and K = −R, on the right-hand side s.
        let matrix: Vec<_> = bilateral.compliance.entries().map(|(i, j, x)| (i, j, -x)).collect();
        let transposed: Vec<_> =
            bilateral.directions.entries().map(|(i, j, x)| (j as u32, i as u32, x)).collect();
        let directions = SparseMatrix::from_entries(bilateral.velocity.len(), b.len(), &transposed);
        entries.extend(schur(&matrix, &directions, &bilateral.velocity, "R", &mut b)?);
    }
    Ok((SparseMatrix::from_entries(b.len(), b.len(), &entries), b))
}

/// The entries of Hᵀ K⁻¹ H, and b ← b + Hᵀ K⁻¹ f; K has as many rows as `force`, H may have fewer (zeros follow).
fn schur(
    matrix: &[(usize, usize, f64)],
    directions: &SparseMatrix,
    force: &[f64],
    name: &'static str,
    b: &mut [f64],
) -> Result<Vec<(u32, u32, f64)>, FclibError> {
    let parts = Parts::of(matrix, force.len());
    let row_of = |i: usize| (i < directions.rows()).then(|| directions.row(i)).into_iter().flatten();
    let mut result = Vec::new();
    let mut booked = 0_u64;
    // Place of a column of H among those its part touches.
    let mut place = vec![usize::MAX; directions.columns()];
    let mut local = vec![0_usize; force.len()];
    for part in parts.iter() {
        let mut columns: Vec<usize> = Vec::new();
        for (k, &i) in part.rows.iter().enumerate() {
            local[i] = k;
            for (j, _) in row_of(i) {
                if place[j] == usize::MAX {
                    place[j] = columns.len();
                    columns.push(j);
                }
            }
        }
        if columns.is_empty() {
            continue;
        }
        booked += (columns.len() as u64).pow(2);
        if booked > CONDENSED_LIMIT {
            return Err(FclibError::Dense { entries: booked, limit: CONDENSED_LIMIT });
        }
        let entries = part.entries.iter().map(|&e| matrix[e]).map(|(i, j, x)| (local[i], local[j], x));
        let singular = || FclibError::Singular { matrix: name, row: part.rows[0] };
        let factor = Factor::new(part.rows.len(), entries).ok_or_else(singular)?;

        // K⁻¹ of the right-hand sides [H f], a batch at a time; f is the last column.
        let mut begin = 0;
        while begin <= columns.len() {
            let end = (begin + BATCH).min(columns.len() + 1);
            let mut x = Mat::<f64>::zeros(part.rows.len(), end - begin);
            for (k, &i) in part.rows.iter().enumerate() {
                for (j, value) in row_of(i) {
                    if (begin..end).contains(&place[j]) {
                        x[(k, place[j] - begin)] = value;
                    }
                }
                if end == columns.len() + 1 {
                    x[(k, end - 1 - begin)] = force[i];
                }
            }
            if !factor.solve(x.as_mut()) {
                return Err(singular());
            }
            for c in begin..end {
                let solved = x.col(c - begin);
                let mut image = vec![0.0; columns.len()];
                for (k, &i) in part.rows.iter().enumerate() {
                    row_of(i).for_each(|(j, value)| image[place[j]] += value * solved[k]);
                }
                match columns.get(c) {
                    Some(&column) => {
                        let line = columns.iter().zip(&image).filter(|&(_, &value)| value != 0.0);
                        result.extend(line.map(|(&row, &value)| (row as u32, column as u32, value)));
                    }
                    None => columns.iter().zip(&image).for_each(|(&row, &value)| b[row] += value),
                }
            }
            begin = end;
        }
        columns.iter().for_each(|&j| place[j] = usize::MAX);
    }
    Ok(result)
}

/// The connected parts of the graph of a matrix.
struct Parts {
    rows: Vec<usize>,
    row_starts: Vec<usize>,
    entries: Vec<usize>,
    entry_starts: Vec<usize>,
}

struct Part<'a> {
    rows: &'a [usize],
    entries: &'a [usize],
}

impl Parts {
    fn of(matrix: &[(usize, usize, f64)], n: usize) -> Self {
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

    fn iter(&self) -> impl Iterator<Item = Part<'_>> {
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

/// The factored part with its size.
struct Factor {
    inverse: Inverse,
    norm: f64,
}

impl Factor {
    fn new(n: usize, entries: impl Iterator<Item = (usize, usize, f64)>) -> Option<Self> {
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
    fn solve(&self, mut x: MatMut<'_, f64>) -> bool {
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
