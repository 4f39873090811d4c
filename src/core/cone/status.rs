//! What contacts do in a solution.

use nalgebra::SVector;

use super::cones::{Shape, blocks, coulomb};
use crate::laws::Cone;
use crate::scalar::Scalar;

/// What a contact does in a solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Status {
    /// No percussion.
    TakeOff,
    /// Percussion strictly inside the cone.
    Stick,
    /// The tangential part inside its disc, a moment on its boundary.
    Roll,
    /// The tangential part on the boundary of its disc.
    Slide,
}

/// Status of a contact with percussion `r`: on the boundary of K to the relative accuracy `tolerance` it slides.
/// A frictionless contact (μ = 0 or D = 1) that carries a percussion slides.
pub fn status<T: Scalar, const D: usize>(
    r: &SVector<T, D>,
    cone: impl Into<Cone<T>>,
    tolerance: T,
) -> Status {
    if r[0] <= T::zero() {
        return Status::TakeOff;
    }
    match Shape::of::<D>(cone.into()) {
        Shape::Disc(friction) if coulomb::holds(r, friction, tolerance) => Status::Stick,
        Shape::Disc(_) => Status::Slide,
        Shape::Blocks(coefficients) => {
            let holds =
                |block: &blocks::Block<T>| block.norm(r) < block.coefficient * r[0] * (T::one() - tolerance);
            let mut blocks = blocks::of::<T, D>(coefficients);
            if !blocks.next().is_some_and(|tangent| holds(&tangent)) {
                Status::Slide
            } else if blocks.all(|moment| holds(&moment)) {
                Status::Stick
            } else {
                Status::Roll
            }
        }
    }
}
/// Number of contacts in each status.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StatusCount {
    /// Contacts without percussion.
    pub take_off: usize,
    /// Contacts strictly inside their cone.
    pub stick: usize,
    /// Contacts whose tangential part is inside its disc, a moment on its boundary.
    pub roll: usize,
    /// Contacts whose tangential part is on the boundary of its disc.
    pub slide: usize,
}

impl StatusCount {
    /// Adds one contact.
    pub fn add(&mut self, status: Status) {
        match status {
            Status::TakeOff => self.take_off += 1,
            Status::Stick => self.stick += 1,
            Status::Roll => self.roll += 1,
            Status::Slide => self.slide += 1,
        }
    }
}
