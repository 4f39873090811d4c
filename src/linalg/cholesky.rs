//! Sparse Cholesky factors: faer's supernodal factorisation, solved in one or two stages without allocation.

use std::fmt;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
use faer::perm::PermRef;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::supernodal::{
    SymbolicSupernodalCholesky, factorize_supernodal_numeric_llt, factorize_supernodal_numeric_llt_scratch,
};
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMat, linalg::SupernodalThreshold};
use faer::{Par, Side};

use super::{FactorError, SparseSymmetric};
use crate::scalar::Scalar;

/// The Cholesky factors L Lᵀ of a sparse operator under a fill-reducing (AMD) order in which chosen unknowns come
/// last.
///
/// With y = L⁻¹ b, the last unknowns of x = L⁻ᵀ y follow from the last of y alone. So a solve can pause between its
/// two halves: [`load`](Self::load) eliminates the others, [`last_unknowns`](Self::last_unknowns) shows what the
/// solution would be there, [`add`](Self::add) changes the right side there, and [`finish`](Self::finish) goes back
/// through all. The whole costs one pair of triangular solves.
pub struct SparseCholesky<T: Scalar> {
    /// Unknown at each place of the order, and place of each unknown.
    order: Vec<usize>,
    place: Vec<usize>,
    supernodes: Vec<Supernode>,
    /// Rows below the diagonal blocks, and the blocks, column by column.
    rows: Vec<u32>,
    values: Vec<T>,
    inverse_diagonal: Vec<T>,
    /// The supernodes from this one on hold the unknowns that come last, those from `last_place` on.
    last_supernode: usize,
    last_place: usize,
    x: Vec<T>,
    ahead: Vec<T>,
    below: Vec<T>,
}

#[derive(Clone, Copy)]
struct Supernode {
    start: usize,
    columns: usize,
    rows: usize,
    below: usize,
    values: usize,
}

impl<T: Scalar> SparseCholesky<T> {
    /// Factors `a`, with the unknowns `last` at the end of the order (repeated ones count once).
    ///
    /// # Errors
    /// [`FactorError::NotPositiveDefinite`] with the pivot that failed, [`FactorError::Backend`].
    pub fn new(a: &SparseSymmetric<T>, last: &[usize]) -> Result<Self, FactorError> {
        let backend = |message: String| FactorError::Backend { message };
        let n = a.size();
        if u32::try_from(n).is_err() {
            return Err(backend(format!("{n} unknowns are more than 2³²")));
        }
        let (order, first_last) = elimination_order(a, last).map_err(backend)?;
        let mut place = vec![0; n];
        order.iter().enumerate().for_each(|(at, &unknown)| place[unknown] = at);
        // Permuted here, so that the factors come in the order of the places.
        let (upper, lower) = (a.triangle(&place, Side::Upper), a.triangle(&place, Side::Lower));
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..CholeskySymbolicParams::default()
        };
        let symbolic =
            factorize_symbolic_cholesky(upper.symbolic(), Side::Upper, SymmetricOrdering::Identity, params)
                .map_err(|error| backend(error.to_string()))?;
        let SymbolicCholeskyRaw::Supernodal(symbolic) = symbolic.raw() else {
            return Err(backend("no supernodal factors although they were asked for".into()));
        };
        let mut values = vec![T::zero(); symbolic.len_val()];
        numeric(&lower, symbolic, &mut values)?;
        Ok(Self::from_parts(order, place, symbolic, values, first_last))
    }

    fn from_parts(
        order: Vec<usize>,
        place: Vec<usize>,
        symbolic: &SymbolicSupernodalCholesky<usize>,
        values: Vec<T>,
        last_place: usize,
    ) -> Self {
        let n = order.len();
        let (mut supernodes, mut rows) = (Vec::new(), Vec::new());
        let mut inverse_diagonal = Vec::with_capacity(n);
        for s in 0..symbolic.n_supernodes() {
            let (start, end) = (symbolic.supernode_begin()[s], symbolic.supernode_end()[s]);
            let pattern = symbolic.supernode(s).pattern();
            let columns = end - start;
            let first = symbolic.col_ptr_for_val()[s];
            supernodes.push(Supernode {
                start,
                columns,
                rows: columns + pattern.len(),
                below: rows.len(),
                values: first,
            });
            // Fits: sizes were checked against u32.
            rows.extend(pattern.iter().map(|&row| row as u32));
            let height = columns + pattern.len();
            inverse_diagonal.extend((0..columns).map(|j| T::one() / values[first + j * height + j]));
        }
        let last_supernode = supernodes.partition_point(|s| s.start + s.columns <= last_place);
        let widest = supernodes.iter().map(|s| s.rows - s.columns).max().unwrap_or(0);
        let zeros = |n| vec![T::zero(); n];
        let (x, ahead, below) = (zeros(n), zeros(n), zeros(widest));
        Self {
            order,
            place,
            supernodes,
            rows,
            values,
            inverse_diagonal,
            last_supernode,
            last_place,
            x,
            ahead,
            below,
        }
    }

    /// Size n.
    pub fn size(&self) -> usize {
        self.order.len()
    }

    /// Stored entries of L, zeros of the supernodes included.
    pub fn entries(&self) -> usize {
        self.values.len()
    }

    /// The smallest pivot over the largest: near round-off where A is singular but for rounding.
    pub fn pivot_ratio(&self) -> T {
        let larger = nalgebra::RealField::max;
        let smaller = nalgebra::RealField::min;
        let largest = self.inverse_diagonal.iter().fold(T::zero(), |a, &b| larger(a, b));
        let smallest = self.inverse_diagonal.iter().fold(T::infinity_impl(), |a, &b| smaller(a, b));
        if largest > T::zero() { (smallest / largest) * (smallest / largest) } else { T::one() }
    }

    /// x ← A⁻¹ x, without allocation.
    pub fn solve_in_place(&mut self, x: &mut [T]) {
        self.load(x);
        self.finish(x);
    }

    /// Takes the right side b and eliminates all but the last unknowns from it.
    pub fn load(&mut self, b: &[T]) {
        self.x.iter_mut().zip(&self.order).for_each(|(x, &unknown)| *x = b[unknown]);
        self.forward(0..self.last_supernode, false);
    }

    /// Takes the right side 0.
    pub fn clear(&mut self) {
        self.x.fill(T::zero());
    }

    /// Writes the last unknowns of the solution, as the right side stands, to their places in `x`.
    pub fn last_unknowns(&mut self, x: &mut [T]) {
        let start = self.supernodes.get(self.last_supernode).map_or(self.x.len(), |s| s.start);
        self.ahead[start..].copy_from_slice(&self.x[start..]);
        let all = self.last_supernode..self.supernodes.len();
        self.forward(all.clone(), true);
        self.backward(all, true);
        for place in self.last_place..self.x.len() {
            x[self.order[place]] = self.ahead[place];
        }
    }

    /// Adds `value` to the right side at one of the last unknowns.
    ///
    /// # Panics
    /// In debug builds, at an unknown that is not one of them.
    pub fn add(&mut self, unknown: usize, value: T) {
        debug_assert!(self.place[unknown] >= self.last_place, "unknown {unknown} is eliminated already");
        self.x[self.place[unknown]] += value;
    }

    /// Writes the solution to `x`.
    pub fn finish(&mut self, x: &mut [T]) {
        self.forward(self.last_supernode..self.supernodes.len(), false);
        self.backward(0..self.supernodes.len(), false);
        self.x.iter().zip(&self.order).for_each(|(&value, &unknown)| x[unknown] = value);
    }

    fn forward(&mut self, supernodes: std::ops::Range<usize>, ahead: bool) {
        let Self { supernodes: all, rows, values, inverse_diagonal, below, .. } = self;
        let x = if ahead { &mut self.ahead } else { &mut self.x };
        for s in &all[supernodes] {
            let (c, h) = (s.columns, s.rows);
            let block = &values[s.values..s.values + c * h];
            let diagonal = &inverse_diagonal[s.start..s.start + c];
            let below = &mut below[..h - c];
            below.fill(T::zero());
            let head = &mut x[s.start..s.start + c];
            let mut j = 0;
            while j + 4 <= c {
                eliminate::<T, 4>(block, h, j, diagonal, head, below);
                j += 4;
            }
            if j + 2 <= c {
                eliminate::<T, 2>(block, h, j, diagonal, head, below);
                j += 2;
            }
            if j < c {
                eliminate::<T, 1>(block, h, j, diagonal, head, below);
            }
            for (&row, &sum) in rows[s.below..s.below + h - c].iter().zip(&*below) {
                x[row as usize] += sum;
            }
        }
    }

    fn backward(&mut self, supernodes: std::ops::Range<usize>, ahead: bool) {
        let Self { supernodes: all, rows, values, inverse_diagonal, below, .. } = self;
        let x = if ahead { &mut self.ahead } else { &mut self.x };
        for s in all[supernodes].iter().rev() {
            let (c, h) = (s.columns, s.rows);
            let block = &values[s.values..s.values + c * h];
            let diagonal = &inverse_diagonal[s.start..s.start + c];
            let below = &mut below[..h - c];
            for (sum, &row) in below.iter_mut().zip(&rows[s.below..s.below + h - c]) {
                *sum = x[row as usize];
            }
            let head = &mut x[s.start..s.start + c];
            let mut j = c;
            if j % 2 == 1 {
                j -= 1;
                substitute::<T, 1>(block, h, j, diagonal, head, below);
            }
            if j % 4 == 2 {
                j -= 2;
                substitute::<T, 2>(block, h, j, diagonal, head, below);
            }
            while j > 0 {
                j -= 4;
                substitute::<T, 4>(block, h, j, diagonal, head, below);
            }
        }
    }
}

/// Columns j..j+K of a supernode of height h in the forward substitution, taken together so that what they share is
/// read once; `below` gathers what the rows below lose.
#[inline]
fn eliminate<T: Scalar, const K: usize>(
    block: &[T],
    h: usize,
    j: usize,
    inverse_diagonal: &[T],
    head: &mut [T],
    below: &mut [T],
) {
    let c = head.len();
    let columns: [&[T]; K] = std::array::from_fn(|k| &block[(j + k) * h..(j + k + 1) * h]);
    let mut factors = [T::zero(); K];
    for k in 0..K {
        let known = (0..k).fold(head[j + k], |sum, i| sum - columns[i][j + k] * factors[i]);
        factors[k] = known * inverse_diagonal[j + k];
        head[j + k] = factors[k];
    }
    subtract(&mut head[j + K..], columns.map(|column| &column[j + K..c]), factors);
    subtract(below, columns.map(|column| &column[c..]), factors);
}

/// Columns j..j+K of a supernode of height h in the backward substitution; `below` holds the unknowns below.
#[inline]
fn substitute<T: Scalar, const K: usize>(
    block: &[T],
    h: usize,
    j: usize,
    inverse_diagonal: &[T],
    head: &mut [T],
    below: &[T],
) {
    let c = head.len();
    let columns: [&[T]; K] = std::array::from_fn(|k| &block[(j + k) * h..(j + k + 1) * h]);
    let outer = dots(columns.map(|column| &column[c..]), below);
    let inner = dots(columns.map(|column| &column[j + K..c]), &head[j + K..]);
    for k in (0..K).rev() {
        let right = head[j + k] - outer[k] - inner[k];
        let right = (k + 1..K).fold(right, |sum, i| sum - columns[k][j + i] * head[j + i]);
        head[j + k] = right * inverse_diagonal[j + k];
    }
}

/// y ← y − Σ_k f_k x_k.
#[inline]
fn subtract<T: Scalar, const K: usize>(y: &mut [T], columns: [&[T]; K], factors: [T; K]) {
    let n = y.len();
    let columns = columns.map(|column| &column[..n]);
    for i in 0..n {
        let mut sum = columns[0][i] * factors[0];
        for k in 1..K {
            sum += columns[k][i] * factors[k];
        }
        y[i] -= sum;
    }
}

/// x_k·y for several x, each in four partial sums, so that they vectorise.
#[inline]
fn dots<T: Scalar, const K: usize>(columns: [&[T]; K], y: &[T]) -> [T; K] {
    let n = y.len();
    let (y4, y_rest) = y.as_chunks::<4>();
    let fours: [&[[T; 4]]; K] = columns.map(|column| &column[..n].as_chunks::<4>().0[..y4.len()]);
    let mut sums = [[T::zero(); 4]; K];
    for (i, y) in y4.iter().enumerate() {
        for k in 0..K {
            let x = fours[k][i];
            for lane in 0..4 {
                sums[k][lane] += x[lane] * y[lane];
            }
        }
    }
    std::array::from_fn(|k| {
        let [a, b, c, d] = sums[k];
        (a + b) + (c + d) + super::dot(&columns[k][n - y_rest.len()..], y_rest)
    })
}

/// An AMD order in which the unknowns `last` come last, and where those begin.
///
/// They are tied together for AMD, as their elimination will tie them: it then leaves them late by itself, and takes
/// account of them while it orders the others.
fn elimination_order<T: Scalar>(
    a: &SparseSymmetric<T>,
    last: &[usize],
) -> Result<(Vec<usize>, usize), String> {
    let n = a.size();
    if n == 0 {
        return Ok((Vec::new(), 0));
    }
    let mut is_last = vec![false; n];
    last.iter().for_each(|&unknown| is_last[unknown] = true);
    let tied: Vec<usize> = (0..n).filter(|&unknown| is_last[unknown]).take(MOST_TIED).collect();
    let pattern = a.tied(&tied);
    let (mut forward, mut inverse) = (vec![0; n], vec![0; n]);
    let scratch = amd::order_maybe_unsorted_scratch::<usize>(n, pattern.compute_nnz());
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    let control = amd::Control::default();
    amd::order_maybe_unsorted(&mut forward, &mut inverse, pattern.symbolic(), control, stack)
        .map_err(|error| error.to_string())?;
    // Checked by faer: a permutation and its inverse.
    let (forward, _) = PermRef::new_checked(&forward, &inverse, n).arrays();
    let (late, mut order): (Vec<usize>, Vec<usize>) = forward.iter().partition(|&&unknown| is_last[unknown]);
    let first_last = order.len();
    order.extend(late);
    Ok((order, first_last))
}

/// Unknowns that are tied together at most; the ties are its square.
const MOST_TIED: usize = 2000;

fn numeric<T: Scalar>(
    lower: &SparseColMat<usize, T>,
    symbolic: &SymbolicSupernodalCholesky<usize>,
    values: &mut [T],
) -> Result<(), FactorError> {
    let scratch =
        factorize_supernodal_numeric_llt_scratch::<usize, T>(symbolic, Par::Seq, Default::default());
    let mut memory = MemBuffer::new(scratch);
    factorize_supernodal_numeric_llt(
        values,
        lower.as_ref(),
        LltRegularization::default(),
        symbolic,
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map(drop)
    .map_err(|LltError::NonPositivePivot { index }| FactorError::NotPositiveDefinite { pivot: index })
}

impl<T: Scalar> fmt::Debug for SparseCholesky<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (size, entries, supernodes) = (self.size(), self.entries(), self.supernodes.len());
        write!(f, "SparseCholesky {{ size: {size}, entries: {entries}, supernodes: {supernodes} }}")
    }
}
