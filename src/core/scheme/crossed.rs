//! Impacts of bodies that would pass through others within a step.
//!
//! Such a contact is met at the time t_k + τ h, 0 ≤ τ ≤ 1, on the path q_k + τ h v_k. Its H is that of the configuration it is
//! met in, so that the impact has the direction it has there; and the bodies move on from there with the velocity after the
//! impact,
//!
//! ```text
//!   q_{k+1} = q_k + τ h v_k + (1−τ) h v_{k+1}
//! ```
//!
//! which keeps them on the side they came from: q_{k+1} = q_k + h v_{k+θ} would leave a body with a rebound slower than its
//! approach beyond the obstacle. Bodies that active contacts couple move with the τ of the first meeting among them. Velocities,
//! percussions and their works are those of the θ of the scene.
//!
//! What a step makes of the velocities is not known before it is made: a body that was hit, that rebounds or that is pulled hard
//! may come to another one within the same step. So the path from q_k to q_{k+1} is swept too, and bodies that would cross on it
//! stop where they meet, with the velocity they have: the next step finds them there, and makes the impact.
//!
//! What these displacements do against the forces is position work, see [`Balance::position_work`](crate::energy::Balance).

use super::record::State;
use crate::contact::{Candidate, ContactId};
use crate::linalg::BlockRows;
use crate::scalar::Scalar;
use crate::system::System;

/// The contacts of a step that are met within it.
#[derive(Debug)]
pub(super) struct Crossed<T: Scalar, const D: usize> {
    /// Contacts, with τ.
    pub(super) times: Vec<(ContactId, T)>,
    /// 1 − τ of every degree of freedom, negative where it has nothing to do with a crossing.
    pub(super) after: Vec<T>,
    /// What is met on the path that was made: contacts, with the part of the path up to there, and their rows.
    pub(super) stops: Vec<(ContactId, T)>,
    pub(super) found: Vec<Candidate<T>>,
    pub(super) rows: BlockRows<T, D>,
    /// Whether q_{k+1} is not that of the θ-step, which is kept where there are springs.
    pub(super) displaced: bool,
    pub(super) made: Vec<T>,
}

impl<T: Scalar, const D: usize> Crossed<T, D> {
    pub(super) fn new(coordinates: usize, dofs: usize) -> Self {
        Self {
            times: Vec::new(),
            after: vec![-T::one(); dofs],
            stops: Vec::new(),
            found: Vec::new(),
            rows: BlockRows::new(),
            displaced: false,
            made: vec![T::zero(); coordinates],
        }
    }

    /// q_{k+1} of the θ-step, in a step that has displaced it, of a system with springs.
    pub(super) fn made(&self) -> Option<&[T]> {
        self.displaced.then_some(&self.made)
    }

    /// Adds what the step would cross to the candidates.
    pub(super) fn find(
        &mut self,
        system: &mut dyn System<T, D>,
        q: &[T],
        path: (T, &[T]),
        asleep: &[bool],
        candidates: &mut Vec<Candidate<T>>,
    ) {
        self.times.clear();
        system.swept_candidates(q, path, asleep, candidates, &mut self.times);
    }

    fn time(&self, id: ContactId) -> Option<T> {
        self.times.iter().find(|time| time.0 == id).map(|time| time.1)
    }

    /// The configuration in which a contact has its H.
    #[inline]
    pub(super) fn place<'a>(
        &self,
        id: ContactId,
        system: &dyn System<T, D>,
        (h, state): (T, &'a State<T>),
        (motion, point): (&mut [T], &'a mut [T]),
    ) -> &'a [T] {
        if self.times.is_empty() {
            return &state.q;
        }
        let Some(time) = self.time(id) else { return &state.q };
        motion.iter_mut().zip(&state.v).for_each(|(s, &v)| *s = time * h * v);
        system.advance(&state.q, motion, point);
        point
    }
}
