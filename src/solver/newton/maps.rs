//! The maps of one contact whose zeros are the solutions, and their derivatives, ρ = 1.

use nalgebra::{SMatrix, SVector};

use crate::cone::{de_saxce, project};
use crate::scalar::Scalar;

/// The equation a semismooth Newton solves.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(in crate::solver) enum Map {
    /// Alart–Curnier (doi:10.1016/0045-7825(91)90022-X), default: f_N = r_N − max(0, r_N − w_N), f_T = r_T − the projection of r_T − w_T
    /// on the disc of radius μ max(0, r_N − w_N).
    #[default]
    AlartCurnier,
    /// Natural map: f = r − proj_K(r − Φ(w)).
    Natural,
}

/// State of a contact at a point of the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    /// f = r: A = I and C = 0.
    Open,
    /// f = w: A = 0 and C = I.
    Stick,
    /// Anything else.
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
fn alart_curnier<T: Scalar, const D: usize>(r: &SVector<T, D>, w: &SVector<T, D>, mu: T) -> SVector<T, D> {
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
fn linearise_alart_curnier<T: Scalar, const D: usize>(
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

/// f = r − proj_K(r − Φ(w)); with y = r − Φ(w) and p = proj_K(y): A = I − p′(y), C = p′(y) Φ′(w).
#[inline]
fn linearise_natural<T: Scalar, const D: usize>(r: &SVector<T, D>, w: &SVector<T, D>, mu: T) -> Linear<T, D> {
    let y = r - de_saxce(w, mu);
    let p = project(&y, mu);
    let f = r - p;
    let identity = SMatrix::identity();
    if p[0] <= T::zero() {
        return Linear { state: State::Open, f, a: identity, c: SMatrix::zeros() };
    }
    let (tau_w, _) = direction(w);
    let mut phi = identity;
    (1..D).for_each(|j| phi[(0, j)] = mu * tau_w[j]);
    let (tau, norm) = direction(&y);
    if D == 1 || norm <= mu * y[0] {
        return Linear { state: State::Slide, f, a: SMatrix::zeros(), c: phi };
    }
    // p_N = (y_N + μ‖y_T‖)/(1 + μ²), p_T = μ p_N τ.
    let mut along = tau * mu;
    along[0] = T::one();
    let mut across = identity - tau * tau.transpose();
    across.row_mut(0).fill(T::zero());
    across.column_mut(0).fill(T::zero());
    let slope = along * along.transpose() / (T::one() + mu * mu) + across * (mu * p[0] / norm);
    Linear { state: State::Slide, f, a: identity - slope, c: slope * phi }
}

impl Map {
    /// The map that is not this one.
    pub(in crate::solver) fn other(self) -> Self {
        match self {
            Self::AlartCurnier => Self::Natural,
            Self::Natural => Self::AlartCurnier,
        }
    }

    /// f.
    #[inline]
    pub(super) fn value<T: Scalar, const D: usize>(
        self,
        r: &SVector<T, D>,
        w: &SVector<T, D>,
        mu: T,
    ) -> SVector<T, D> {
        match self {
            Self::AlartCurnier => alart_curnier(r, w, mu),
            Self::Natural => r - project(&(r - de_saxce(w, mu)), mu),
        }
    }

    /// f, A, C.
    #[inline]
    pub(super) fn linearise<T: Scalar, const D: usize>(
        self,
        r: &SVector<T, D>,
        w: &SVector<T, D>,
        mu: T,
    ) -> Linear<T, D> {
        match self {
            Self::AlartCurnier => linearise_alart_curnier(r, w, mu),
            Self::Natural => linearise_natural(r, w, mu),
        }
    }
}
