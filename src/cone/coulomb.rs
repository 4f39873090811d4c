//! The Coulomb cone K = {‖r_T‖ ≤ μ r_N}: projection, De Saxcé's change of variable, contact status.

use nalgebra::{SMatrix, SVector};

use crate::scalar::{Scalar, lit};

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
pub fn de_saxce<T: Scalar, const D: usize>(w: &SVector<T, D>, friction: T) -> SVector<T, D> {
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
pub fn project<T: Scalar, const D: usize>(x: &SVector<T, D>, friction: T) -> SVector<T, D> {
    match place(x, friction) {
        Place::Cone => *x,
        Place::Polar => SVector::zeros(),
        Place::Between(tangential) => on_boundary(x, friction, tangential),
    }
}

/// The natural map r − proj_K(r − x): x itself where r − x lies in K and r where it lies in the polar cone, so that
/// a residual is not lost in the digits of a large r.
#[inline]
pub fn natural_map<T: Scalar, const D: usize>(
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
        _ => largest_of_three(block),
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

/// What a contact does in a solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Status {
    /// No percussion.
    TakeOff,
    /// Percussion strictly inside the cone.
    Stick,
    /// Percussion on the boundary of the cone.
    Slide,
}

/// Status of a contact with percussion `r`: on the boundary of K to the relative accuracy `tolerance` it slides.
/// A frictionless contact (μ = 0 or D = 1) that carries a percussion slides.
pub fn status<T: Scalar, const D: usize>(r: &SVector<T, D>, friction: T, tolerance: T) -> Status {
    if r[0] <= T::zero() {
        Status::TakeOff
    } else if tangential_norm(r) < friction * r[0] * (T::one() - tolerance) {
        if D == 1 { Status::Slide } else { Status::Stick }
    } else {
        Status::Slide
    }
}

/// Number of contacts in each status.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StatusCount {
    /// Contacts without percussion.
    pub take_off: usize,
    /// Contacts strictly inside their cone.
    pub stick: usize,
    /// Contacts on the boundary of their cone.
    pub slide: usize,
}

impl StatusCount {
    /// Adds one contact.
    pub fn add(&mut self, status: Status) {
        match status {
            Status::TakeOff => self.take_off += 1,
            Status::Stick => self.stick += 1,
            Status::Slide => self.slide += 1,
        }
    }
}
