//! The largest eigenvalue of a block, which sizes a contact.

use nalgebra::SMatrix;

use crate::scalar::{Scalar, epsilon, lit};

/// Largest eigenvalue of the symmetric part of a D×D block.
#[inline]
pub fn largest_eigenvalue<T: Scalar, const D: usize>(block: &SMatrix<T, D, D>) -> T {
    let half = lit::<T>(0.5);
    match D {
        1 => block[(0, 0)],
        2 => {
            let mean = half * (block[(0, 0)] + block[(1, 1)]);
            let difference = half * (block[(0, 0)] - block[(1, 1)]);
            let off = half * (block[(0, 1)] + block[(1, 0)]);
            mean + nalgebra::ComplexField::sqrt(difference * difference + off * off)
        }
        3 => largest_of_three(block),
        _ => largest_by_rotations(block),
    }
}

/// Largest root of the characteristic cubic by its trigonometric form (Smith 1961, doi:10.1145/355578.366316).
fn largest_of_three<T: Scalar, const D: usize>(block: &SMatrix<T, D, D>) -> T {
    let half = lit::<T>(0.5);
    let off = |i: usize, j: usize| half * (block[(i, j)] + block[(j, i)]);
    let (a, b, c) = (block[(0, 0)], block[(1, 1)], block[(2, 2)]);
    let (d, e, f) = (off(0, 1), off(1, 2), off(0, 2));
    let mean = (a + b + c) / lit::<T>(3.0);
    let (a, b, c) = (a - mean, b - mean, c - mean);
    let square = (a * a + b * b + c * c) / lit::<T>(6.0) + (d * d + e * e + f * f) / lit::<T>(3.0);
    if square <= T::zero() {
        return mean;
    }
    let p = nalgebra::ComplexField::sqrt(square);
    let determinant = a * (b * c - e * e) - d * (d * c - e * f) + f * (d * e - b * f);
    let cosine: T = nalgebra::clamp(half * determinant / (p * square), -T::one(), T::one());
    let angle = nalgebra::ComplexField::acos(cosine) / lit::<T>(3.0);
    mean + lit::<T>(2.0) * p * nalgebra::ComplexField::cos(angle)
}

/// Sweeps of rotations: each squares what is left off the diagonal, once that is small.
const SWEEPS: usize = 12;

/// Jacobi's rotations, for blocks with moments among their rows.
fn largest_by_rotations<T: Scalar, const D: usize>(block: &SMatrix<T, D, D>) -> T {
    let half = lit::<T>(0.5);
    let mut a = (block + block.transpose()) * half;
    for _ in 0..SWEEPS {
        let (mut off, mut size) = (T::zero(), T::zero());
        for i in 0..D {
            size += a[(i, i)] * a[(i, i)];
            (0..i).for_each(|j| off += a[(i, j)] * a[(i, j)]);
        }
        if !(off > epsilon::<T>() * epsilon::<T>() * size) {
            break;
        }
        for p in 0..D {
            for q in p + 1..D {
                if a[(p, q)] == T::zero() {
                    continue;
                }
                let theta = half * (a[(q, q)] - a[(p, p)]) / a[(p, q)];
                let root = nalgebra::ComplexField::sqrt(theta * theta + T::one());
                let sign = if theta < T::zero() { -T::one() } else { T::one() };
                let t = sign / (nalgebra::ComplexField::abs(theta) + root);
                let c = T::one() / nalgebra::ComplexField::sqrt(t * t + T::one());
                let s = t * c;
                for k in 0..D {
                    let (x, y) = (a[(k, p)], a[(k, q)]);
                    (a[(k, p)], a[(k, q)]) = (c * x - s * y, s * x + c * y);
                }
                for k in 0..D {
                    let (x, y) = (a[(p, k)], a[(q, k)]);
                    (a[(p, k)], a[(q, k)]) = (c * x - s * y, s * x + c * y);
                }
            }
        }
    }
    (1..D).fold(a[(0, 0)], |largest, i| if a[(i, i)] > largest { a[(i, i)] } else { largest })
}
