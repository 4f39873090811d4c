//! Sparse Cholesky factors: faer's supernodal factorisation, solved in one or two stages without allocation.

use std::fmt;
use std::ops::Range;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
use faer::linalg::triangular_inverse::invert_lower_triangular;
use faer::linalg::triangular_solve::solve_upper_triangular_in_place;
use faer::perm::PermRef;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::supernodal::{
    SymbolicSupernodalCholesky, factorize_supernodal_numeric_llt, factorize_supernodal_numeric_llt_scratch,
};
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{FaerError, SparseColMat, linalg::SupernodalThreshold};
use faer::{Mat, MatMut, Par, Side};

use super::error::FactorError;
use super::panel::{LANES, Lanes, multiply, multiply_transpose, vectorised};
use super::sparse::SparseSymmetric;
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
    /// Rows below the diagonal blocks.
    runs: Vec<Run>,
    /// The blocks [L₁₁⁻¹; L₂₁ L₁₁⁻¹] of the supernodes, column by column, each padded to whole lanes.
    values: Vec<Lanes<T>>,
    pivot_ratio: T,
    /// The supernodes from this one on hold the unknowns that come last, those from `last_place` on.
    last_supernode: usize,
    last_place: usize,
    x: Vec<T>,
    ahead: Vec<T>,
    /// What the rows of one supernode lose or hold, and the sums over its columns.
    product: Vec<Lanes<T>>,
    sums: Vec<Lanes<T>>,
}

/// Columns that have the rows below them in common.
struct Supernode {
    start: usize,
    columns: usize,
    /// Lanes of a column, its padding included.
    height: usize,
    /// Its places in `runs` and in `values`.
    runs: Range<usize>,
    values: Range<usize>,
}

/// Rows that follow one another.
#[derive(Clone, Copy)]
struct Run {
    start: u32,
    end: u32,
}

impl Run {
    #[inline]
    fn range(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }

    #[inline]
    fn len(self) -> usize {
        (self.end - self.start) as usize
    }
}

impl<T: Scalar> SparseCholesky<T> {
    /// Factors `a`, with the unknowns `last` at the end of the order (repeated ones count once).
    ///
    /// # Errors
    /// [`FactorError`]: the pivot that failed, or what the sparse backend reports.
    pub fn new(a: &SparseSymmetric<T>, last: &[usize]) -> Result<Self, FactorError> {
        let n = a.size();
        if u32::try_from(n).is_err() {
            return Err(FactorError::TooLarge { unknowns: n });
        }
        if n == 0 {
            return Ok(Self::empty());
        }
        let (order, first_last) = elimination_order(a, last).map_err(FactorError::Backend)?;
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
                .map_err(FactorError::Backend)?;
        let SymbolicCholeskyRaw::Supernodal(symbolic) = symbolic.raw() else {
            return Err(FactorError::NotSupernodal);
        };
        let mut values = vec![T::zero(); symbolic.len_val()];
        numeric(&lower, symbolic, &mut values)?;
        Ok(Self::from_parts(order, place, symbolic, values, first_last))
    }

    /// The factors of the operator over no unknown.
    fn empty() -> Self {
        Self {
            order: Vec::new(),
            place: Vec::new(),
            supernodes: Vec::new(),
            runs: Vec::new(),
            values: Vec::new(),
            pivot_ratio: T::one(),
            last_supernode: 0,
            last_place: 0,
            x: Vec::new(),
            ahead: Vec::new(),
            product: Vec::new(),
            sums: Vec::new(),
        }
    }

    fn from_parts(
        order: Vec<usize>,
        place: Vec<usize>,
        symbolic: &SymbolicSupernodalCholesky<usize>,
        mut values: Vec<T>,
        last_place: usize,
    ) -> Self {
        let n = order.len();
        let (mut supernodes, mut runs, mut blocks) = (Vec::new(), Vec::<Run>::new(), Vec::new());
        let (mut smallest, mut largest) = (T::infinity_impl(), T::zero());
        for s in 0..symbolic.n_supernodes() {
            let (start, end) = (symbolic.supernode_begin()[s], symbolic.supernode_end()[s]);
            let pattern = symbolic.supernode(s).pattern();
            let (columns, count) = (end - start, end - start + pattern.len());
            let block = &mut values[symbolic.col_ptr_for_val()[s]..][..columns * count];
            for j in 0..columns {
                smallest = nalgebra::RealField::min(smallest, block[j * count + j]);
                largest = nalgebra::RealField::max(largest, block[j * count + j]);
            }
            let block = inverted(MatMut::from_column_major_slice_mut(block, count, columns));
            let height = count.div_ceil(LANES);
            let first_run = runs.len();
            // Fits: sizes were checked against u32.
            for row in pattern.iter().map(|&row| row as u32) {
                match runs[first_run..].last_mut() {
                    Some(run) if run.end == row => run.end += 1,
                    _ => runs.push(Run { start: row, end: row + 1 }),
                }
            }
            let values = blocks.len()..blocks.len() + columns * height;
            supernodes.push(Supernode { start, columns, height, runs: first_run..runs.len(), values });
            for j in 0..columns {
                let entry = |i| if i < count { block[(i, j)] } else { T::zero() };
                blocks
                    .extend((0..height).map(|lanes| std::array::from_fn(|lane| entry(LANES * lanes + lane))));
            }
        }
        let last_supernode = supernodes.partition_point(|s: &Supernode| s.start + s.columns <= last_place);
        let highest = supernodes.iter().map(|s| s.height).max().unwrap_or(0);
        let widest = supernodes.iter().map(|s| s.columns).max().unwrap_or(0);
        let ratio = if largest > T::zero() { smallest / largest } else { T::one() };
        Self {
            order,
            place,
            supernodes,
            runs,
            values: blocks,
            pivot_ratio: ratio * ratio,
            last_supernode,
            last_place,
            x: vec![T::zero(); n],
            ahead: vec![T::zero(); n],
            product: vec![[T::zero(); LANES]; highest],
            sums: vec![[T::zero(); LANES]; widest],
        }
    }

    /// Size n.
    pub fn size(&self) -> usize {
        self.order.len()
    }

    /// Stored entries of the blocks, zeros included.
    pub fn entries(&self) -> usize {
        self.values.len() * LANES
    }

    /// The smallest pivot over the largest: near round-off where A is singular but for rounding.
    pub fn pivot_ratio(&self) -> T {
        self.pivot_ratio
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

    fn forward(&mut self, supernodes: Range<usize>, ahead: bool) {
        let Self { supernodes: all, runs, values, product, .. } = self;
        let x = if ahead { &mut self.ahead[..] } else { &mut self.x[..] };
        vectorised(
            #[inline(always)]
            || {
                for s in &all[supernodes] {
                    let product = &mut product[..s.height];
                    multiply(&values[s.values.clone()], &x[s.start..s.start + s.columns], product);
                    let (head, mut below) = product.as_flattened().split_at(s.columns);
                    x[s.start..s.start + s.columns].copy_from_slice(head);
                    for run in &runs[s.runs.clone()] {
                        let (lost, rest) = below.split_at(run.len());
                        x[run.range()].iter_mut().zip(lost).for_each(|(x, &lost)| *x -= lost);
                        below = rest;
                    }
                }
            },
        );
    }

    fn backward(&mut self, supernodes: Range<usize>, ahead: bool) {
        let Self { supernodes: all, runs, values, product, sums, .. } = self;
        let x = if ahead { &mut self.ahead[..] } else { &mut self.x[..] };
        vectorised(
            #[inline(always)]
            || {
                for s in all[supernodes].iter().rev() {
                    let product = &mut product[..s.height];
                    let (head, mut below) = product.as_flattened_mut().split_at_mut(s.columns);
                    head.copy_from_slice(&x[s.start..s.start + s.columns]);
                    for run in &runs[s.runs.clone()] {
                        let (known, rest) = below.split_at_mut(run.len());
                        known.iter_mut().zip(&x[run.range()]).for_each(|(known, &x)| *known = -x);
                        below = rest;
                    }
                    below.fill(T::zero());
                    let head = &mut x[s.start..s.start + s.columns];
                    multiply_transpose(&values[s.values.clone()], product, head, sums);
                }
            },
        );
    }
}

/// An AMD order in which the unknowns `last` come last, and where those begin.
///
/// They are tied together for AMD, as their elimination will tie them: it then leaves them late by itself, and takes
/// account of them while it orders the others.
fn elimination_order<T: Scalar>(
    a: &SparseSymmetric<T>,
    last: &[usize],
) -> Result<(Vec<usize>, usize), FaerError> {
    let n = a.size();
    let mut is_last = vec![false; n];
    last.iter().for_each(|&unknown| is_last[unknown] = true);
    let tied: Vec<usize> = (0..n).filter(|&unknown| is_last[unknown]).take(MOST_TIED).collect();
    let pattern = a.tied(&tied);
    let (mut forward, mut inverse) = (vec![0; n], vec![0; n]);
    let scratch = amd::order_maybe_unsorted_scratch::<usize>(n, pattern.compute_nnz());
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    let control = amd::Control::default();
    amd::order_maybe_unsorted(&mut forward, &mut inverse, pattern.symbolic(), control, stack)?;
    // Checked by faer: a permutation and its inverse.
    let (forward, _) = PermRef::new_checked(&forward, &inverse, n).arrays();
    let (late, mut order): (Vec<usize>, Vec<usize>) = forward.iter().partition(|&&unknown| is_last[unknown]);
    let first_last = order.len();
    order.extend(late);
    Ok((order, first_last))
}

/// Unknowns that are tied together at most; the ties are its square.
const MOST_TIED: usize = 2000;

/// [L₁₁; L₂₁] → [L₁₁⁻¹; L₂₁ L₁₁⁻¹]: both substitutions become products, which no entry has to wait for in (partitioned
/// inverses, Alvarado, Pothen & Schreiber 1993).
fn inverted<T: Scalar>(block: MatMut<'_, T>) -> Mat<T> {
    let (count, columns) = (block.nrows(), block.ncols());
    let (head, below) = block.split_at_row_mut(columns);
    let mut inverted = Mat::zeros(count, columns);
    let (mut inverse_head, mut inverse_below) = inverted.as_mut().split_at_row_mut(columns);
    invert_lower_triangular(inverse_head.rb_mut(), head.rb(), Par::Seq);
    inverse_below.copy_from(below.rb());
    // X L₁₁ = L₂₁
    solve_upper_triangular_in_place(head.rb().transpose(), inverse_below.transpose_mut(), Par::Seq);
    inverted
}

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
