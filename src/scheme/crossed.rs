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

use super::ThetaScheme;
use super::lasting::Lasting;
use super::record::{Next, State};
use crate::contact::{Candidate, ContactId};
use crate::linalg::{BlockRows, dot};
use crate::scalar::Scalar;
use crate::system::System;

/// Most times that bodies are stopped in one step: who stops may be in the way of others.
const MOST_STOPS: usize = 8;

/// The contacts of a step that are met within it.
#[derive(Debug)]
pub(super) struct Crossed<T: Scalar, const D: usize> {
    /// Contacts, with τ.
    times: Vec<(ContactId, T)>,
    /// 1 − τ of every degree of freedom, negative where it has nothing to do with a crossing.
    after: Vec<T>,
    /// What is met on the path that was made: contacts, with the part of the path up to there, and their rows.
    stops: Vec<(ContactId, T)>,
    found: Vec<Candidate<T>>,
    rows: BlockRows<T, D>,
    /// Whether q_{k+1} is not that of the θ-step, which is kept where there are springs.
    displaced: bool,
    made: Vec<T>,
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

impl<T: Scalar, const D: usize> ThetaScheme<T, D> {
    /// Lets bodies that met within the step move on from where they met, up to where they meet again; the position work, −F·Δq.
    pub(super) fn place_after_crossings(&mut self) -> T {
        self.crossed.displaced = false;
        if self.system.body_dofs().is_none() {
            return T::zero();
        }
        if self.system.stiffness().is_some() || !self.joints.is_empty() {
            self.crossed.made.copy_from_slice(&self.next.q);
        }
        self.move_on() + self.stop_at_crossings()
    }

    fn move_on(&mut self) -> T {
        if self.crossed.times.is_empty() {
            return T::zero();
        }
        let Self { settings, state, next, lasting, jacobian, joints, crossed, free, .. } = self;
        let Next { v, scratch, contacts, .. } = next;
        let Crossed { times, after, .. } = crossed;
        after.fill(-T::one());
        let larger = nalgebra::RealField::max;
        for (row, contact) in contacts.iter().enumerate() {
            let Some(&(_, time)) = times.iter().find(|time| time.0 == contact.id) else { continue };
            jacobian.row(row).for_each(|(dof, _)| after[dof] = larger(after[dof], T::one() - time));
        }
        if joints.is_empty() {
            // Through the active contacts, until nothing changes: every pass reaches further, or is the last.
            loop {
                let mut changed = false;
                for row in 0..contacts.len() {
                    let most = jacobian.row(row).fold(-T::one(), |most, (dof, _)| larger(most, after[dof]));
                    for (dof, _) in jacobian.row(row) {
                        changed |= after[dof] < most;
                        after[dof] = most;
                    }
                }
                if !changed {
                    break;
                }
            }
        } else {
            let most = after.iter().fold(-T::one(), |most, &after| larger(most, after));
            after.fill(most);
        }
        let thetas = lasting.as_ref().and_then(Lasting::theta);
        scratch.fill(T::zero());
        for dof in 0..*free {
            if after[dof] >= T::zero() {
                let theta = thetas.map_or(settings.theta, |thetas| thetas[dof]);
                scratch[dof] = (after[dof] - theta) * settings.step * (v[dof] - state.v[dof]);
            }
        }
        self.displace_along_joints()
    }

    /// q_{k+1} ← q_{k+1} + Δq, with Δq in the scratch and the joints kept closed; −F·Δq.
    fn displace_along_joints(&mut self) -> T {
        self.crossed.displaced = true;
        let Self { system, next, joints, factor, .. } = self;
        let Next { q, place, force, scratch, .. } = next;
        place.copy_from_slice(q);
        system.advance(place, scratch, q);
        if joints.is_empty() {
            return -dot(force, scratch);
        }
        joints.close(&**system, factor, place, q);
        system.difference(place, q, scratch);
        -dot(force, scratch)
    }

    /// Stops bodies that would cross on the path from q_k to q_{k+1} where they meet; the position work, −F·Δq.
    fn stop_at_crossings(&mut self) -> T {
        let mut work = T::zero();
        for _ in 0..MOST_STOPS {
            let Self { system, state, next, joints, crossed, rest, .. } = self;
            let Next { q, scratch, .. } = next;
            let Crossed { after, stops, found, rows, .. } = crossed;
            system.difference(&state.q, q, scratch);
            let asleep = rest.as_ref().map_or(&[][..], |rest| rest.asleep());
            stops.clear();
            system.swept_candidates(&state.q, (T::one(), scratch), asleep, found, stops);
            found.clear();
            if stops.is_empty() {
                break;
            }
            after.fill(T::one());
            for &(id, time) in &*stops {
                rows.clear();
                system.jacobian(id, &state.q, rows);
                rows.row(0).for_each(|(dof, _)| after[dof] = nalgebra::RealField::min(after[dof], time));
            }
            if !joints.is_empty() {
                let least =
                    after.iter().fold(T::one(), |least, &after| nalgebra::RealField::min(least, after));
                after.fill(least);
            }
            for (change, &part) in scratch.iter_mut().zip(&*after) {
                *change *= part - T::one();
            }
            work += self.displace_along_joints();
        }
        work
    }
}
