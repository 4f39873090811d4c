//! Bodies that move as told: belts, shakers, pistons.

use nalgebra::Vector2;

use super::shape::{GROUND, Pose};
use super::{RigidBodies, push_body};
use crate::linalg::BlockRows;
use crate::scalar::Scalar;
use crate::system::{Prescribed, Signal, SystemError};

/// Where a body that moves as told is displaced from, and by what times which signal, in x, y and angle.
#[derive(Debug, Clone)]
pub(super) struct Moved<T> {
    pub(super) origin: [T; 3],
    pub(super) motion: [(T, Signal<T>); 3],
}

impl<T: Scalar> Moved<T> {
    /// The motions of all, from the degree of freedom `first` on.
    pub(super) fn prescribed(first: usize, all: Vec<Self>) -> Result<Option<Prescribed<T>>, SystemError> {
        if all.is_empty() {
            return Ok(None);
        }
        let (mut origins, mut motions, mut signals) = (Vec::new(), Vec::new(), Vec::new());
        for Self { origin, motion } in all {
            origins.extend(origin);
            for (displacement, signal) in motion {
                motions.push((displacement, signals.len()));
                signals.push(signal);
            }
        }
        Prescribed::new(first, motions, signals)?.with_origins(origins).map(Some)
    }
}

impl<T: Scalar> RigidBodies<T> {
    /// Whether a body moves under forces, and not as told or not at all.
    #[inline]
    pub(super) fn is_free(&self, body: usize) -> bool {
        body < self.free
    }

    /// The columns of the body of a half-plane that meets another at `arm` from its centre of mass.
    #[inline]
    pub(super) fn push_plane<const D: usize>(
        &self,
        out: &mut BlockRows<T, D>,
        plane: usize,
        normal: &Vector2<T>,
        (body, arm): (usize, &Vector2<T>),
        q: &[T],
    ) {
        if plane != GROUND {
            let between = Pose::of(body, q).origin - Pose::of(plane, q).origin;
            push_body(out, plane, -T::one(), normal, &(arm + between));
        }
    }
}
