//! The joints of systems that have none.

use crate::linalg::BlockRows;
use crate::scalar::Scalar;
use crate::system::{Dynamics, Joints};

/// No rows.
#[derive(Debug)]
struct NoJoints;

impl<T: Scalar> Joints<T> for NoJoints {
    fn rows(&self) -> usize {
        0
    }
    fn residual(&self, _q: &[T], _out: &mut [T]) {}
    fn jacobian(&self, _q: &[T], _s: &[T], _out: &mut BlockRows<T, 1>) {}
}

/// The joints of a system, a list without rows where it has none.
pub(super) fn joints_of<T: Scalar>(system: &dyn Dynamics<T>) -> &dyn Joints<T> {
    system.joints().unwrap_or(&NoJoints)
}
