//! Dense kernel: the first p pivots of an n×n front eliminated, pivoting among the pivot rows.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, Par};
use nalgebra::ComplexField;

use crate::scalar::{Scalar, lit};

/// Columns eliminated together before the rest of the front is updated.
const PANEL: usize = 32;
/// Below this many multiplications an update is not worth a call of the blocked product.
const SMALL_PRODUCT: usize = 4096;

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
        for k in start..end {
            let row = pivot_row(&front[k * n..k * n + pivots], k).ok_or(k)?;
            swaps[k] = row;
            if row != k {
                front.chunks_exact_mut(n).for_each(|column| column.swap(k, row));
            }
            let (left, right) = front.split_at_mut((k + 1) * n);
            let pivot_column = &mut left[k * n..];
            let inverse = T::one() / pivot_column[k];
            pivot_column[k + 1..].iter_mut().for_each(|x| *x *= inverse);
            for column in right.chunks_exact_mut(n).take(end - k - 1) {
                let head = column[k];
                subtract_multiple(&mut column[k + 1..], &pivot_column[k + 1..], head);
            }
        }
        update(front, n, start, end);
        start = end;
    }
    Ok(())
}

/// The row of the largest entry of `column` from row `from`, `None` where there is nothing to divide by.
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

/// y ← y − c x.
#[inline(always)]
fn subtract_multiple<T: Scalar>(y: &mut [T], x: &[T], c: T) {
    y.iter_mut().zip(x).for_each(|(y, &x)| *y -= x * c);
}

/// Applies the panel `start..end` to the columns right of it: U by substitution, then the Schur complement.
fn update<T: Scalar>(front: &mut [T], n: usize, start: usize, end: usize) {
    let (panel, right) = front.split_at_mut(end * n);
    let panel = &panel[start * n..];
    let small = (n - end) * (n - end) * (end - start) <= SMALL_PRODUCT;
    for column in right.chunks_exact_mut(n) {
        for (k, pivot_column) in (start..end).zip(panel.chunks_exact(n)) {
            let head = column[k];
            let last = if small { n } else { end };
            subtract_multiple(&mut column[k + 1..last], &pivot_column[k + 1..last], head);
        }
    }
    if !small {
        let whole = MatMut::from_column_major_slice_mut(front, n, n);
        let (_, upper, lower, rest) = whole.split_at_mut(end, end);
        let upper = upper.as_ref().subrows(start, end - start);
        let lower = lower.as_ref().subcols(start, end - start);
        matmul(rest, Accum::Add, lower, upper, -T::one(), Par::Seq);
    }
}
