//! Sums over slices of numbers.

use crate::scalar::Scalar;

/// Σ xᵢ yᵢ.
#[inline]
pub fn dot<T: Scalar>(x: &[T], y: &[T]) -> T {
    let n = x.len().min(y.len());
    let (x, y) = (&x[..n], &y[..n]);
    let [sum] = sums(n, |i| [x[i] * y[i]]);
    sum
}

/// Σ_i of several terms, each in four sums that do not wait for one another.
#[inline]
pub(crate) fn sums<T: Scalar, const K: usize>(count: usize, terms: impl Fn(usize) -> [T; K]) -> [T; K] {
    let fours = count - count % 4;
    let mut sums = [T::zero(); K];
    if fours > 0 {
        let mut lanes = [[T::zero(); K]; 4];
        for i in (0..fours).step_by(4) {
            for (lane, sums) in lanes.iter_mut().enumerate() {
                let terms = terms(i + lane);
                (0..K).for_each(|k| sums[k] += terms[k]);
            }
        }
        sums = std::array::from_fn(|k| (lanes[0][k] + lanes[1][k]) + (lanes[2][k] + lanes[3][k]));
    }
    for i in fours..count {
        let terms = terms(i);
        (0..K).for_each(|k| sums[k] += terms[k]);
    }
    sums
}

/// y ← y + a x.
#[inline]
pub fn axpy<T: Scalar>(y: &mut [T], a: T, x: &[T]) {
    y.iter_mut().zip(x).for_each(|(y, &x)| *y += a * x);
}

/// max |xᵢ|; 0 for an empty slice.
pub fn max_abs<T: Scalar>(x: &[T]) -> T {
    x.iter().fold(T::zero(), |max, &x| nalgebra::RealField::max(max, nalgebra::ComplexField::abs(x)))
}
