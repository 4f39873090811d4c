//! The cones of contacts, one file each, and the geometry every solver asks of them.
//!
//! Every cone here is K = {r : ‖r_B‖ ≤ c_B r_N for every block B of components beside the normal one}, so that
//!
//! ```text
//!   K* = {u : Σ_B c_B ‖u_B‖ ≤ u_N},      Φ(w) = w + Σ_B c_B ‖w_B‖ e_N
//! ```
//!
//! Coulomb's has one block, all tangents; rolling resistance adds the moments. All blocks are in the same units: moments are
//! impulses at a lever arm ([`Cone::at_arm`]).

pub(crate) mod blocks;
pub(super) mod coulomb;

use nalgebra::SVector;

use crate::laws::Cone;
use crate::scalar::Scalar;

/// The cone as its geometry sees it: what a branch decides once.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Shape<T> {
    /// One disc of radius μ r_N for all tangents: D = 1, 2 and 3.
    Disc(T),
    /// A ball of radius c_B r_N per block: D = 3 in the plane, D = 6.
    Blocks([T; 3]),
}

impl<T: Scalar> Shape<T> {
    /// The shape of a cone in dimension D.
    #[inline(always)]
    pub(crate) fn of<const D: usize>(cone: Cone<T>) -> Self {
        match (D, cone) {
            (1 | 2, cone) => Self::Disc(cone.friction()),
            (3, Cone::Coulomb { friction }) => Self::Disc(friction),
            (_, cone) => Self::Blocks(cone.coefficients()),
        }
    }
}

/// De Saxcé's change of variable Φ(w) = w + Σ_B c_B ‖w_B‖ e_N, w + μ‖w_T‖ e_N for Coulomb's cone.
#[inline(always)]
pub fn de_saxce<T: Scalar, const D: usize>(w: &SVector<T, D>, cone: impl Into<Cone<T>>) -> SVector<T, D> {
    match Shape::of::<D>(cone.into()) {
        Shape::Disc(friction) => coulomb::de_saxce(w, friction),
        Shape::Blocks(coefficients) => blocks::de_saxce(w, coefficients),
    }
}

/// Orthogonal projection on the cone K; with μ = 0 the half-line r_N ≥ 0, r_T = 0.
#[inline]
pub fn project<T: Scalar, const D: usize>(x: &SVector<T, D>, cone: impl Into<Cone<T>>) -> SVector<T, D> {
    match Shape::of::<D>(cone.into()) {
        Shape::Disc(friction) => coulomb::project(x, friction),
        Shape::Blocks(coefficients) => blocks::project(x, coefficients),
    }
}

/// The natural map r − proj_K(r − x): x itself where r − x lies in K and r where it lies in the polar cone, so that
/// a residual is not lost in the digits of a large r.
#[inline]
pub fn natural_map<T: Scalar, const D: usize>(
    r: &SVector<T, D>,
    x: &SVector<T, D>,
    cone: impl Into<Cone<T>>,
) -> SVector<T, D> {
    match Shape::of::<D>(cone.into()) {
        Shape::Disc(friction) => coulomb::natural_map(r, x, friction),
        Shape::Blocks(coefficients) => blocks::natural_map(r, x, coefficients),
    }
}

/// Σ_B c_B ‖x_B‖, what x_N must reach for x to lie in K*.
#[inline]
pub fn dual_gauge<T: Scalar, const D: usize>(x: &SVector<T, D>, cone: impl Into<Cone<T>>) -> T {
    match Shape::of::<D>(cone.into()) {
        Shape::Disc(friction) => friction * coulomb::tangential_norm(x),
        Shape::Blocks(coefficients) => blocks::gauge(x, coefficients),
    }
}

/// c of the block that component `row` > 0 belongs to.
#[inline]
pub(crate) fn coefficient<T: Scalar, const D: usize>(cone: Cone<T>, row: usize) -> T {
    match Shape::of::<D>(cone) {
        Shape::Disc(friction) => friction,
        Shape::Blocks(coefficients) => blocks::of::<T, D>(coefficients)
            .find(|block| block.components().contains(&row))
            .map_or(T::zero(), |block| block.coefficient),
    }
}

/// Whether `x` lies in K, with each ‖x_B‖ ≤ c_B x_N + `slack`.
pub fn contains<T: Scalar, const D: usize>(x: &SVector<T, D>, cone: impl Into<Cone<T>>, slack: T) -> bool {
    let inside = match Shape::of::<D>(cone.into()) {
        Shape::Disc(friction) => coulomb::tangential_norm(x) <= friction * x[0] + slack,
        Shape::Blocks(coefficients) => {
            blocks::of::<T, D>(coefficients).all(|block| block.norm(x) <= block.coefficient * x[0] + slack)
        }
    };
    inside && x[0] >= -slack
}
