//! Dense kernel: the first p pivots of an n×n front eliminated, pivoting among the pivot rows.

use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, Par};
use nalgebra::ComplexField;

use super::panel::vectorised;
use crate::scalar::{Scalar, lit};

/// Columns eliminated together before the rest of the front is updated, and before the rest of those is.
const PANEL: usize = 32;
const INNER: usize = 4;
/// Below this many multiplications an update is not worth a call of the blocked product.
const SMALL_PRODUCT: usize = 16384;

/// Eliminates the first `pivots` columns of the column-major `n`×`n` matrix `front`: L (unit diagonal) and U
/// overwrite them, the rest becomes the Schur complement. Row `k` was exchanged with row `swaps[k]`, both pivots.
///
/// # Errors
/// The column whose pivots are all zero or not finite.
pub(super) fn eliminate<T: Scalar>(
    front: &mut [T],
    n: usize,
    pivots: usize,
    swaps: &mut [usize],
) -> Result<(), usize> {
    let mut start = 0;
    while start < pivots {
        let end = (start + PANEL).min(pivots);
        vectorised(|| eliminate_panel(front, (n, pivots), start..end, swaps))?;
        if (n - end) * (n - end) * (end - start) <= SMALL_PRODUCT {
            vectorised(|| apply(front, n, start..end, end..n, n));
        } else {
            vectorised(|| apply(front, n, start..end, end..n, end));
            let whole = MatMut::from_column_major_slice_mut(front, n, n);
            let (_, upper, lower, rest) = whole.split_at_mut(end, end);
            let upper = upper.as_ref().subrows(start, end - start);
            let lower = lower.as_ref().subcols(start, end - start);
            matmul(rest, Accum::Add, lower, upper, -T::one(), Par::Seq);
        }
        start = end;
    }
    Ok(())
}

/// L and U of the columns `panel`, the pivots taken from all rows before `pivots`.
#[inline(always)]
fn eliminate_panel<T: Scalar>(
    front: &mut [T],
    (n, pivots): (usize, usize),
    panel: Range<usize>,
    swaps: &mut [usize],
) -> Result<(), usize> {
    for start in panel.clone().step_by(INNER) {
        let end = (start + INNER).min(panel.end);
        for k in start..end {
            let row = pivot_row(&front[k * n..k * n + pivots], k).ok_or(k)?;
            swaps[k] = row;
            if row != k {
                front.chunks_exact_mut(n).for_each(|column| column.swap(k, row));
            }
            let pivot_column = &mut front[k * n..(k + 1) * n];
            let inverse = T::one() / pivot_column[k];
            pivot_column[k + 1..].iter_mut().for_each(|x| *x *= inverse);
            apply(front, n, k..k + 1, k + 1..end, n);
        }
        apply(front, n, start..end, end..panel.end, n);
    }
    Ok(())
}

/// The row of the largest entry of `column` from row `from`, `None` where there is nothing to divide by.
#[inline(always)]
fn pivot_row<T: Scalar>(column: &[T], from: usize) -> Option<usize> {
    let (mut best, mut size) = (from, ComplexField::abs(column[from]));
    // The diagonal is kept unless it is ten times smaller: Newton blocks are nearly diagonally dominant.
    size *= lit::<T>(10.0);
    for (i, &x) in column.iter().enumerate().skip(from + 1) {
        let x = ComplexField::abs(x);
        if x > size {
            (best, size) = (i, x);
        }
    }
    (size > T::zero() && size < T::infinity_impl()).then_some(best)
}

/// Applies the eliminated columns `from` to the columns `to` right of them: U by substitution, then the rows up to `last`.
#[inline(always)]
fn apply<T: Scalar>(front: &mut [T], n: usize, from: Range<usize>, to: Range<usize>, last: usize) {
    let (left, right) = front[..to.end * n].split_at_mut(to.start * n);
    let pivots = &left[from.start * n..from.end * n];
    for column in right.chunks_exact_mut(n) {
        for (k, pivot) in from.clone().zip(pivots.chunks_exact(n)) {
            let (head, below) = column[k..from.end].split_at_mut(1);
            subtract_columns(below, &pivot[k + 1..from.end], n, &[head[0]]);
        }
        let (heads, rest) = column.split_at_mut(from.end);
        let rest = &mut rest[..last.max(from.end) - from.end];
        let (fours, ones) = heads[from.start..].as_chunks::<4>();
        for (heads, pivots) in fours.iter().zip(pivots.chunks_exact(4 * n)) {
            subtract_columns(rest, &pivots[from.end..], n, heads);
        }
        for (&head, pivot) in ones.iter().zip(pivots[4 * fours.len() * n..].chunks_exact(n)) {
            subtract_columns(rest, &pivot[from.end..], n, &[head]);
        }
    }
}

/// y ← y − Σ_k c_k x_k, with column x_k from place `n` k of `x` on.
#[inline(always)]
fn subtract_columns<T: Scalar, const K: usize>(y: &mut [T], x: &[T], n: usize, c: &[T; K]) {
    let rows = y.len();
    let columns: [&[T]; K] = std::array::from_fn(|k| &x[k * n..][..rows]);
    for i in 0..rows {
        let mut sum = y[i];
        for k in 0..K {
            sum -= columns[k][i] * c[k];
        }
        y[i] = sum;
    }
}
