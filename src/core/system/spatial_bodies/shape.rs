//! Shapes on bodies, and where these are.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::geometry::{Pose, Shape};
use crate::scalar::Scalar;
use crate::system::BodyId;

/// Components of q and of v of a body.
pub(super) const COORDINATES: usize = 7;
pub(super) const DOFS: usize = 6;

/// A shape of a body, or a fixed one.
#[derive(Debug, Clone)]
pub(super) struct Contactor<T: Scalar> {
    pub(super) label: String,
    pub(super) body: Option<usize>,
    pub(super) shape: Shape<T>,
    /// Its frame in that of the body.
    pub(super) local: Pose<T>,
    pub(super) group: usize,
}

impl<T: Scalar> Contactor<T> {
    pub(super) fn pose(&self, q: &[T]) -> Pose<T> {
        body_pose(self.body, q).part(&self.local)
    }
}

/// Pose of a body, or of the ground.
#[inline]
pub(super) fn body_pose<T: Scalar>(body: Option<usize>, q: &[T]) -> Pose<T> {
    body.map_or_else(Pose::identity, |body| {
        let (position, orientation) = parts(&q[COORDINATES * body..]);
        Pose::new(position, orientation)
    })
}

/// Position and orientation, from the 7 numbers (x, y, z, w, i, j, k).
#[inline]
pub(super) fn parts<T: Scalar>(q: &[T]) -> (Vector3<T>, UnitQuaternion<T>) {
    let quaternion = Quaternion::new(q[3], q[4], q[5], q[6]);
    (Vector3::new(q[0], q[1], q[2]), UnitQuaternion::new_unchecked(quaternion))
}

/// The 7 numbers of an orientation's place.
#[inline]
pub(super) fn set_orientation<T: Scalar>(q: &mut [T], orientation: &UnitQuaternion<T>) {
    (q[3], q[4], q[5], q[6]) = (orientation.w, orientation.i, orientation.j, orientation.k);
}

/// The index of a body, `None` for the ground.
pub(super) fn index(body: BodyId) -> Option<usize> {
    (body != BodyId::GROUND).then_some(body.index())
}
