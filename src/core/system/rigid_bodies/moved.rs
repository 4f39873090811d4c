//! Bodies that move as told: belts, shakers, pistons.

use nalgebra::Vector2;

use super::builder::{Body, BodyId, RigidBodiesBuilder, check};
use super::shape::{GROUND, Pose};
use super::{RigidBodies, push_body};
use crate::linalg::BlockRows;
use crate::scalar::Scalar;
use crate::system::{Prescribed, Signal, SystemError};

/// Where a body that moves as told is displaced from, and by what times which signal, in x, y and angle.
#[derive(Debug, Clone)]
pub(super) struct Moved<T> {
    origin: [T; 3],
    motion: [(T, Signal<T>); 3],
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

impl<T: Scalar> RigidBodiesBuilder<T> {
    /// Adds a body that moves as told, after all that move under forces: x, y (m) and the angle (rad) are those of `origin`
    /// and the displacements, each times its signal. It has no mass; the work of what moves it is booked as that of prescribed
    /// motion.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`].
    pub fn moved_body(
        &mut self,
        name: &str,
        origin: [T; 3],
        motion: [(T, Signal<T>); 3],
    ) -> Result<BodyId, SystemError> {
        check(|| format!("position or angle of `{name}`"), &origin, |_| true, "finite")?;
        for (displacement, signal) in &motion {
            check(|| format!("displacement of `{name}`"), &[*displacement], |_| true, "finite")?;
            signal.check()?;
        }
        self.bodies.push((name.into(), Body { mass: T::zero(), inertia: T::zero() }));
        self.force.extend([T::zero(); 3]);
        self.moved.push(Moved { origin, motion });
        Ok(BodyId(self.bodies.len() - 1))
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
