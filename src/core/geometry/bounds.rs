//! Boxes along the fixed axes.

use nalgebra::Vector3;

use super::real::infinity;
use crate::scalar::Scalar;

/// A box along the fixed axes (m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds<T: Scalar> {
    /// Least coordinates.
    pub low: Vector3<T>,
    /// Largest coordinates.
    pub high: Vector3<T>,
}

impl<T: Scalar> Bounds<T> {
    /// From `centre` − `half` to `centre` + `half`.
    #[inline]
    pub fn around(centre: Vector3<T>, half: Vector3<T>) -> Self {
        Self { low: centre - half, high: centre + half }
    }

    /// All of space.
    pub fn everywhere() -> Self {
        Self { low: Vector3::repeat(-infinity::<T>()), high: Vector3::repeat(infinity()) }
    }

    /// Around `origin` + x for all x of `points`, grown by `reach`.
    pub(super) fn of(points: impl Iterator<Item = Vector3<T>>, origin: Vector3<T>, reach: T) -> Self {
        let none = (Vector3::repeat(infinity::<T>()), Vector3::repeat(-infinity::<T>()));
        let (low, high) = points.fold(none, |(low, high), x| (low.inf(&x), high.sup(&x)));
        Self { low: origin + low.add_scalar(-reach), high: origin + high.add_scalar(reach) }
    }

    /// The smallest box that holds both.
    #[must_use]
    #[inline]
    pub fn union(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// Whether they share a point.
    #[inline(always)]
    pub fn meets(&self, other: &Self) -> bool {
        self.low.x <= other.high.x
            && other.low.x <= self.high.x
            && self.low.y <= other.high.y
            && other.low.y <= self.high.y
            && self.low.z <= other.high.z
            && other.low.z <= self.high.z
    }

    /// Whether all six numbers are finite.
    #[inline]
    pub(super) fn is_finite(&self) -> bool {
        crate::scalar::all_finite(self.low.iter().chain(self.high.iter()))
    }
}
