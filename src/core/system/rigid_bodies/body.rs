//! A body, its name in the builder, and the check of numbers that enter.

use super::shape::GROUND;
use crate::scalar::{Scalar, all_finite, to_f64};
use crate::system::SystemError;

/// Mass (kg) and moment of inertia about the centre of mass (kg m²) of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body<T> {
    /// Mass m > 0.
    pub mass: T,
    /// Moment of inertia I > 0.
    pub inertia: T,
}

/// A body of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BodyId(pub(in crate::system) usize);

impl BodyId {
    /// What is fixed: its frame is the fixed one, and its shapes move nowhere.
    pub const GROUND: Self = Self(GROUND);

    /// Index i of the body, in the order they were added, but for the [ground](Self::GROUND). In the plane it owns
    /// q[3i..3i+3], in space q[7i..7i+7] and v[6i..6i+6].
    pub fn index(self) -> usize {
        self.0
    }
}

/// Checks numbers, all finite and `ok`.
pub(in crate::system) fn check<T: Scalar>(
    what: impl FnOnce() -> String,
    values: &[T],
    ok: impl Fn(T) -> bool,
    range: &'static str,
) -> Result<(), SystemError> {
    match values.iter().find(|&&x| !all_finite([&x]) || !ok(x)) {
        Some(&x) => Err(SystemError::OutOfRange { what: what(), value: to_f64(x), range }),
        None => Ok(()),
    }
}
