//! The root of a smooth function in a bracket, for gaps along a path.

use crate::scalar::{Scalar, lit};

/// Evaluations at most; bisection alone ends a bracket of doubles in 60.
const MOST: usize = 90;

/// A place in [a, b] where |f| ≤ `close`, or the closest to the left of the root that the bracket came to; f(a) > 0 > f(b).
///
/// The parabola through the ends and a point between them is exact for a parabola; where it does not halve the bracket,
/// the middle does.
pub(super) fn falling_root<T: Scalar>(
    (mut a, mut f_a): (T, T),
    (mut b, mut f_b): (T, T),
    close: T,
    mut f: impl FnMut(T) -> T,
) -> T {
    let half = lit::<T>(0.5);
    let mut x = (a + b) * half;
    for _ in 0..MOST {
        if !(x > a && x < b) {
            break;
        }
        let f_x = f(x);
        if nalgebra::ComplexField::abs(f_x) <= close {
            return x;
        }
        let guess = parabola_root([a, x, b], [f_a, f_x, f_b]);
        let width = b - a;
        if f_x > T::zero() {
            (a, f_a) = (x, f_x);
        } else {
            (b, f_b) = (x, f_x);
        }
        let halved = b - a <= (half + half * half * half) * width;
        let middle = (a + b) * half;
        x = guess.filter(|&guess| halved && guess > a && guess < b).unwrap_or(middle);
    }
    a
}

/// The root between the outer two of three points of the parabola through them; the function falls from the first to the
/// last.
fn parabola_root<T: Scalar>([a, x, b]: [T; 3], [f_a, f_x, f_b]: [T; 3]) -> Option<T> {
    let zero = T::zero();
    let first = (f_x - f_a) / (x - a);
    let second = ((f_b - f_x) / (b - x) - first) / (b - a);
    // f(t) = f_a + first (t − a) + second (t − a)(t − x), in powers of s = t − a.
    let linear = first - second * (x - a);
    let discriminant = linear * linear - lit::<T>(4.0) * second * f_a;
    if !(discriminant >= zero) {
        return None;
    }
    let root = nalgebra::ComplexField::sqrt(discriminant);
    // Both roots without cancellation.
    let q = if linear < zero { linear - root } else { linear + root } * lit::<T>(-0.5);
    let candidates = [q / second, f_a / q];
    let inside = |s: &&T| **s > zero && **s < b - a;
    candidates.iter().find(inside).map(|&s| a + s)
}

/// Time and value of the minimum of the parabola through (0, f₀), (1, f₁), (2, f₂), if it has one.
pub(super) fn parabola_minimum<T: Scalar>([f0, f1, f2]: [T; 3]) -> Option<(T, T)> {
    let half = lit::<T>(0.5);
    let (slope, bend) = ((f2 - f0) * half, f0 - f1 - f1 + f2);
    if !(bend > T::zero()) {
        return None;
    }
    Some((T::one() - slope / bend, f1 - slope * slope / (bend + bend)))
}
