//! Products with a panel, a dense block of few columns, and their transposes, as the triangular solves need them.
//!
//! The loops are written for the vectoriser: columns are padded to whole lanes, sums are kept lane by lane and stored
//! before they are added up, which keeps the order of every sum the same on every machine.

use crate::scalar::Scalar;

/// Numbers that are computed with together; columns are padded to a multiple of it.
pub(super) const LANES: usize = 4;

/// Numbers that are computed with together.
pub(super) type Lanes<T> = [T; LANES];

/// Runs `work` with the widest vector instructions of this machine.
#[inline]
pub(super) fn vectorised<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}

/// y ← B x, with the columns of B below one another; column j is zero in its first j rows.
#[inline(always)]
pub(super) fn multiply<T: Scalar>(block: &[Lanes<T>], x: &[T], y: &mut [Lanes<T>]) {
    let (block, y) = (block.as_flattened(), y.as_flattened_mut());
    y.fill(T::zero());
    let height = y.len();
    let (fours, rest) = x.as_chunks::<4>();
    for (k, x) in fours.iter().enumerate() {
        add_columns(&block[4 * k * height..][..4 * height], 4 * k, x, y);
    }
    let first = 4 * fours.len();
    let block = &block[first * height..];
    let (twos, one) = rest.as_chunks::<2>();
    for x in twos {
        add_columns(&block[..2 * height], first, x, y);
    }
    for x in one {
        add_columns(&block[2 * twos.len() * height..], first, &[*x], y);
    }
}

/// y ← y + Σ_k x_k b_k over the rows from `first` on.
#[inline(always)]
fn add_columns<T: Scalar, const K: usize>(block: &[T], first: usize, x: &[T; K], y: &mut [T]) {
    let height = y.len();
    let y = &mut y[first..];
    let n = y.len();
    let columns: [&[T]; K] = std::array::from_fn(|k| &block[k * height + first..][..n]);
    for i in 0..n {
        let mut sum = y[i];
        for k in 0..K {
            sum += columns[k][i] * x[k];
        }
        y[i] = sum;
    }
}

/// x ← Bᵀ y, with the columns of B below one another; column j is zero in its first j rows. `sums` has a place for
/// every column.
#[inline(always)]
pub(super) fn multiply_transpose<T: Scalar>(
    block: &[Lanes<T>],
    y: &[Lanes<T>],
    x: &mut [T],
    sums: &mut [Lanes<T>],
) {
    let height = y.len();
    let sums = &mut sums[..x.len()];
    let (fours, rest) = sums.as_chunks_mut::<4>();
    let count = fours.len();
    for (k, sums) in fours.iter_mut().enumerate() {
        add_products(&block[4 * k * height..][..4 * height], k, y, sums);
    }
    let block = &block[4 * count * height..];
    let (twos, one) = rest.as_chunks_mut::<2>();
    let paired = 2 * twos.len();
    for sums in twos {
        add_products(&block[..2 * height], count, y, sums);
    }
    for sums in one {
        add_products(&block[paired * height..], count, y, std::array::from_mut(sums));
    }
    for (x, [a, b, c, d]) in x.iter_mut().zip(&*sums) {
        *x = (*a + *b) + (*c + *d);
    }
}

/// The lanes of b_k·y for several columns, over the rows from lane `first` on.
#[inline(always)]
fn add_products<T: Scalar, const K: usize>(
    block: &[Lanes<T>],
    first: usize,
    y: &[Lanes<T>],
    sums: &mut [Lanes<T>; K],
) {
    let height = y.len();
    let y = &y[first..];
    let columns: [&[Lanes<T>]; K] = std::array::from_fn(|k| &block[k * height + first..][..y.len()]);
    let mut gathered = [[T::zero(); LANES]; K];
    for (i, y) in y.iter().enumerate() {
        for k in 0..K {
            for lane in 0..LANES {
                gathered[k][lane] += columns[k][i][lane] * y[lane];
            }
        }
    }
    *sums = gathered;
}
