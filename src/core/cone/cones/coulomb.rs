//! Coulomb's cone K = {‖r_T‖ ≤ μ r_N}, one disc for all tangential components.

use nalgebra::SVector;

use crate::scalar::Scalar;

/// Norm of the tangential part (components 1..D) of a local vector.
#[inline(always)]
pub(crate) fn tangential_norm<T: Scalar, const D: usize>(x: &SVector<T, D>) -> T {
    match D {
        1 => T::zero(),
        2 => nalgebra::ComplexField::abs(x[1]),
        _ => nalgebra::ComplexField::sqrt(x.iter().skip(1).fold(T::zero(), |sum, &t| sum + t * t)),
    }
}

/// De Saxcé's change of variable Φ(w) = w + μ‖w_T‖ e_N.
#[inline(always)]
pub(super) fn de_saxce<T: Scalar, const D: usize>(w: &SVector<T, D>, friction: T) -> SVector<T, D> {
    let mut phi = *w;
    phi[0] += friction * tangential_norm(w);
    phi
}

/// Where a vector lies, seen from the Coulomb cone.
enum Place<T> {
    /// In K.
    Cone,
    /// In the polar cone −K*, which projects on the apex.
    Polar,
    /// Between the two, with the tangential norm.
    Between(T),
}

#[inline(always)]
fn place<T: Scalar, const D: usize>(x: &SVector<T, D>, friction: T) -> Place<T> {
    let tangential = tangential_norm(x);
    // The sign is a test of its own: with μ = 0 and x_T = 0 the second holds on the negative half-line too.
    if x[0] >= T::zero() && tangential <= friction * x[0] {
        Place::Cone
    } else if x[0] + friction * tangential <= T::zero() {
        Place::Polar
    } else {
        Place::Between(tangential)
    }
}

/// The projection of a vector that lies between the cones, on the boundary of K.
#[inline(always)]
fn on_boundary<T: Scalar, const D: usize>(x: &SVector<T, D>, friction: T, tangential: T) -> SVector<T, D> {
    let normal = (x[0] + friction * tangential) / (T::one() + friction * friction);
    let mut p = if tangential > T::zero() { x * (friction * normal / tangential) } else { SVector::zeros() };
    p[0] = normal;
    p
}

/// Orthogonal projection on the Coulomb cone K of aperture μ; with μ = 0 the half-line r_N ≥ 0, r_T = 0.
#[inline]
pub(super) fn project<T: Scalar, const D: usize>(x: &SVector<T, D>, friction: T) -> SVector<T, D> {
    match place(x, friction) {
        Place::Cone => *x,
        Place::Polar => SVector::zeros(),
        Place::Between(tangential) => on_boundary(x, friction, tangential),
    }
}

/// The natural map r − proj_K(r − x): x itself where r − x lies in K and r where it lies in the polar cone, so that
/// a residual is not lost in the digits of a large r.
#[inline]
pub(super) fn natural_map<T: Scalar, const D: usize>(
    r: &SVector<T, D>,
    x: &SVector<T, D>,
    friction: T,
) -> SVector<T, D> {
    let z = r - x;
    match place(&z, friction) {
        Place::Cone => *x,
        Place::Polar => *r,
        Place::Between(tangential) => r - on_boundary(&z, friction, tangential),
    }
}

/// Whether a percussion lies inside the cone, to the relative distance `tolerance` from its boundary.
#[inline]
pub(in crate::cone) fn holds<T: Scalar, const D: usize>(
    x: &SVector<T, D>,
    friction: T,
    tolerance: T,
) -> bool {
    D > 1 && tangential_norm(x) < friction * x[0] * (T::one() - tolerance)
}
