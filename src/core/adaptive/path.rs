//! The path of a trial step, as a parabola.

use crate::scalar::{Scalar, lit};
use crate::system::Dynamics;

/// q(τ) = q_k ⊕ (τ v_k + ½ τ² a) over a step, through its end: exact in flight under constant forces, of third order else.
#[derive(Debug)]
pub(super) struct Path<T> {
    acceleration: Vec<T>,
    motion: Vec<T>,
    /// Length of the step (s); 0 where there is no path.
    pub(super) size: T,
}

impl<T: Scalar> Path<T> {
    pub(super) fn new(dofs: usize) -> Self {
        Self { acceleration: vec![T::zero(); dofs], motion: vec![T::zero(); dofs], size: T::zero() }
    }

    pub(super) fn forget(&mut self) {
        self.size = T::zero();
    }

    /// The path from (q, v) to `end` in the time `size`.
    pub(super) fn set(&mut self, system: &dyn Dynamics<T>, (q, v): (&[T], &[T]), end: &[T], size: T) {
        let scale = lit::<T>(2.0) / (size * size);
        system.difference(q, end, &mut self.motion);
        for (i, a) in self.acceleration.iter_mut().enumerate() {
            *a = (self.motion[i] - size * v[i]) * scale;
        }
        self.size = size;
    }

    /// point ← q(τ).
    pub(super) fn at(&mut self, system: &dyn Dynamics<T>, (q, v): (&[T], &[T]), time: T, point: &mut [T]) {
        let half = lit::<T>(0.5) * time;
        for (i, s) in self.motion.iter_mut().enumerate() {
            *s = time * (v[i] + half * self.acceleration[i]);
        }
        system.advance(q, &self.motion, point);
    }

    /// The acceleration, component by component.
    pub(super) fn acceleration(&self) -> &[T] {
        &self.acceleration
    }
}
