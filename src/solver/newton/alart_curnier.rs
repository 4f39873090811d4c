//! The Alart–Curnier map of one contact and its derivatives, ρ = 1 (doi:10.1016/0045-7825(91)90022-X).

use nalgebra::{SMatrix, SVector};

use crate::scalar::Scalar;

/// State of a contact at a point of the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    /// z_N ≤ 0: f = r.
    Open,
    /// ‖z_T‖ ≤ μ z_N: f = w, so that A = 0 and C = I.
    Stick,
    Slide,
}

/// f and its derivatives A in r and C in w, at z = r − w.
#[derive(Debug, Clone, Copy)]
pub(super) struct Linear<T: Scalar, const D: usize> {
    pub(super) state: State,
    pub(super) f: SVector<T, D>,
    pub(super) a: SMatrix<T, D, D>,
    pub(super) c: SMatrix<T, D, D>,
}

/// τ and the norm of z_T; τ = 0 where the norm is.
fn direction<T: Scalar, const D: usize>(z: &SVector<T, D>) -> (SVector<T, D>, T) {
    let mut tangent = *z;
    tangent[0] = T::zero();
    let norm = tangent.norm();
    if norm > T::zero() { (tangent / norm, norm) } else { (SVector::zeros(), norm) }
}

/// f alone: z_N ≤ 0: f = r; else f_N = w_N and, with R = μ z_N, τ = z_T/‖z_T‖, f_T = w_T where ‖z_T‖ ≤ R,
/// r_T − R τ beyond.
#[inline]
pub(super) fn value<T: Scalar, const D: usize>(r: &SVector<T, D>, w: &SVector<T, D>, mu: T) -> SVector<T, D> {
    let z = r - w;
    if z[0] <= T::zero() {
        return *r;
    }
    let (tau, norm) = direction(&z);
    let radius = mu * z[0];
    if D == 1 || norm <= radius {
        return *w;
    }
    let mut f = r - tau * radius;
    f[0] = w[0];
    f
}

/// f, A, C. Slide: A_TT = I − P, A_TN = −μτ, C_TT = P, C_TN = μτ, C_N = e_N, P = (R/‖z_T‖)(I − ττᵀ).
#[inline]
pub(super) fn linearise<T: Scalar, const D: usize>(
    r: &SVector<T, D>,
    w: &SVector<T, D>,
    mu: T,
) -> Linear<T, D> {
    let z = r - w;
    let identity = SMatrix::identity();
    if z[0] <= T::zero() {
        return Linear { state: State::Open, f: *r, a: identity, c: SMatrix::zeros() };
    }
    let (tau, norm) = direction(&z);
    let radius = mu * z[0];
    if D == 1 || norm <= radius {
        return Linear { state: State::Stick, f: *w, a: SMatrix::zeros(), c: identity };
    }
    let mut f = r - tau * radius;
    f[0] = w[0];
    let mut p = (identity - tau * tau.transpose()) * (radius / norm);
    // Rows and columns of N: P has none.
    p.row_mut(0).fill(T::zero());
    p.column_mut(0).fill(T::zero());
    let mut a = identity - p;
    let mut c = p;
    for i in 0..D {
        (a[(i, 0)], c[(i, 0)]) = (-mu * tau[i], mu * tau[i]);
    }
    (a[(0, 0)], c[(0, 0)]) = (T::zero(), T::one());
    Linear { state: State::Slide, f, a, c }
}
