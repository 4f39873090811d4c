//! The exact solution of one contact: w = W r + b, K* ∋ Φ(w) ⟂ r ∈ K with W a D×D block.

use nalgebra::{ComplexField, SMatrix, SVector};

use super::coulomb::tangential_norm;
use crate::scalar::{Scalar, epsilon, lit};

/// The percussion of one contact with Delassus block `w` (W_NN > 0), velocity `b` without it, friction μ ≥ 0.
///
/// Where several solutions exist (Painlevé: b_N ≥ 0 and W_NN ≤ μ|W_NT|) the contact takes off; where none exists
/// (never for W ≻ 0) the result is the sliding or sticking candidate that comes nearest, and the caller's
/// residual shows it.
#[inline]
pub fn solve_one_contact<T: Scalar, const D: usize>(
    w: &SMatrix<T, D, D>,
    b: &SVector<T, D>,
    friction: T,
) -> SVector<T, D> {
    if b[0] >= T::zero() {
        return SVector::zeros();
    }
    if D == 1 || friction == T::zero() {
        let mut r = SVector::zeros();
        r[0] = -b[0] / w[(0, 0)];
        return r;
    }
    match D {
        2 => planar(w, b, friction),
        _ => spatial(w, b, friction),
    }
}

/// Stick, else the two slides r_T = ±μ r_N.
#[inline]
fn planar<T: Scalar, const D: usize>(w: &SMatrix<T, D, D>, b: &SVector<T, D>, friction: T) -> SVector<T, D> {
    let (nn, nt, tn, tt) = (w[(0, 0)], w[(0, 1)], w[(1, 0)], w[(1, 1)]);
    let mut r = SVector::zeros();
    let determinant = nn * tt - nt * tn;
    // A block of rank one sticks without resistance: one of the slides then carries w_T = 0.
    if determinant > lit::<T>(4.0) * epsilon::<T>() * nn * tt {
        r[0] = (nt * b[1] - tt * b[0]) / determinant;
        r[1] = (tn * b[0] - nn * b[1]) / determinant;
        if tangential_norm(&r) <= friction * r[0] {
            return r;
        }
    }
    // Slide with r_T = σ μ r_N: w_N = 0 gives r_N, and the slip must oppose the percussion, σ w_T ≤ 0.
    let mut best = (T::infinity_impl(), SVector::zeros());
    for side in [friction, -friction] {
        let stiffness = nn + side * nt;
        if stiffness > T::zero() {
            let normal = -b[0] / stiffness;
            let slip = (tn + side * tt) * normal + b[1];
            let violation = if side > T::zero() { slip } else { -slip };
            if violation < best.0 {
                let mut r = SVector::zeros();
                r[0] = normal;
                r[1] = side * normal;
                best = (violation, r);
            }
        }
    }
    best.1
}

/// Stick, else the slide w_N = 0, w_T = −α r_T, α ≥ 0: with r_N eliminated, (S + αI) r_T = −β and the scalar
/// equation h(α) = μ r_N(α)/‖r_T(α)‖ − 1 = 0, negative at 0 and positive at infinity.
fn spatial<T: Scalar, const D: usize>(w: &SMatrix<T, D, D>, b: &SVector<T, D>, friction: T) -> SVector<T, D> {
    let nn = w[(0, 0)];
    let (nt1, nt2, t1n, t2n) = (w[(0, 1)], w[(0, 2)], w[(1, 0)], w[(2, 0)]);
    // Schur complement of W_NN; not symmetrised, for W may be slightly asymmetric.
    let (a, c1) = (w[(1, 1)] - t1n * nt1 / nn, w[(1, 2)] - t1n * nt2 / nn);
    let (c2, d) = (w[(2, 1)] - t2n * nt1 / nn, w[(2, 2)] - t2n * nt2 / nn);
    let (beta1, beta2) = (b[1] - t1n * b[0] / nn, b[2] - t2n * b[0] / nn);
    let trace = a + d;

    let percussion = |alpha: T| {
        let (p, q) = (a + alpha, d + alpha);
        let determinant = p * q - c1 * c2;
        let t1 = (c1 * beta2 - q * beta1) / determinant;
        let t2 = (c2 * beta1 - p * beta2) / determinant;
        let n = -(b[0] + nt1 * t1 + nt2 * t2) / nn;
        (n, t1, t2, determinant)
    };
    let vector = |n: T, t1: T, t2: T| {
        let mut r = SVector::zeros();
        (r[0], r[1], r[2]) = (n, t1, t2);
        r
    };

    let (n, t1, t2, determinant) = percussion(T::zero());
    let regular = determinant > lit::<T>(4.0) * epsilon::<T>() * trace * trace;
    if regular && t1 * t1 + t2 * t2 <= friction * friction * n * n && n >= T::zero() {
        return vector(n, t1, t2);
    }

    // Newton on h inside a bracket [low, high], h(low) < 0 < h(high), with doubling or bisection as a guard.
    let beta = ComplexField::sqrt(beta1 * beta1 + beta2 * beta2);
    let coupling = ComplexField::sqrt(nt1 * nt1 + nt2 * nt2) / nn;
    let normal = -b[0] / nn;
    let guess = beta * (T::one() + friction * coupling) / (friction * normal) - trace * lit::<T>(0.5);
    let mut alpha = if guess > T::zero() { guess } else { trace * lit::<T>(0.5e-3) };
    let (mut low, mut high) = (T::zero(), None::<T>);
    let mut r = vector(normal, T::zero(), T::zero());
    let tolerance = lit::<T>(4.0) * epsilon::<T>();
    for _ in 0..200 {
        let (n, t1, t2, determinant) = percussion(alpha);
        let norm = ComplexField::sqrt(t1 * t1 + t2 * t2);
        if norm == T::zero() {
            // β = 0: no tangential percussion is called for.
            return vector(n, T::zero(), T::zero());
        }
        r = vector(n, t1, t2);
        let h = friction * n / norm - T::one();
        if ComplexField::abs(h) <= tolerance {
            break;
        }
        if h < T::zero() {
            low = alpha;
        } else {
            high = Some(alpha);
        }
        // r_T' = −(S + αI)⁻¹ r_T, r_N' = −W_NT r_T'/W_NN.
        let (p, q) = (a + alpha, d + alpha);
        let d1 = (c1 * t2 - q * t1) / determinant;
        let d2 = (c2 * t1 - p * t2) / determinant;
        let dn = -(nt1 * d1 + nt2 * d2) / nn;
        let slope = friction * (dn / norm - n * (t1 * d1 + t2 * d2) / (norm * norm * norm));
        let newton = alpha - h / slope;
        let inside = slope > T::zero() && newton > low && high.is_none_or(|high| newton < high);
        let next = match (inside, high) {
            (true, _) => newton,
            (false, Some(high)) => (low + high) * lit::<T>(0.5),
            (false, None) => alpha * lit::<T>(4.0),
        };
        if next == alpha {
            break;
        }
        alpha = next;
    }
    // On the cone to the last digit, so that the projection of the residual does not see the root-finder.
    let norm = ComplexField::sqrt(r[1] * r[1] + r[2] * r[2]);
    let scale = if norm > T::zero() { friction * r[0] / norm } else { T::zero() };
    vector(r[0], r[1] * scale, r[2] * scale)
}
