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
//! percussions and their works are those of the θ of the scene; what the displacement does against the forces is position
//! work, see [`Balance::position_work`](crate::energy::Balance).

use super::ThetaScheme;
use super::lasting::Lasting;
use super::record::{Next, State};
use crate::contact::{Candidate, ContactId};
use crate::laws::ContactLaw;
use crate::linalg::{axpy, dot};
use crate::scalar::Scalar;
use crate::solver::ConeSolver;
use crate::system::MechanicalSystem;

/// The contacts of a step that are met within it.
#[derive(Debug)]
pub(super) struct Crossed<T> {
    /// Contacts, with τ.
    times: Vec<(ContactId, T)>,
    /// 1 − τ of every degree of freedom, negative where it has nothing to do with a crossing.
    after: Vec<T>,
}

impl<T: Scalar> Crossed<T> {
    pub(super) fn new(dofs: usize) -> Self {
        Self { times: Vec::new(), after: vec![-T::one(); dofs] }
    }

    /// Adds what the step would cross to the candidates.
    pub(super) fn find<const D: usize, S: MechanicalSystem<T, D>>(
        &mut self,
        system: &mut S,
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
        (h, state): (T, &'a State<T>),
        point: &'a mut [T],
    ) -> &'a [T] {
        if self.times.is_empty() {
            return &state.q;
        }
        let Some(time) = self.time(id) else { return &state.q };
        point.copy_from_slice(&state.q);
        axpy(point, time * h, &state.v);
        point
    }
}

impl<T, const D: usize, S, L, V> ThetaScheme<T, D, S, L, V>
where
    T: Scalar,
    S: MechanicalSystem<T, D>,
    L: ContactLaw<T, D>,
    V: ConeSolver<T, D>,
{
    /// Lets bodies that met within the step move on from where they met; the position work, −F·Δq.
    pub(super) fn place_after_crossings(&mut self) -> T {
        if self.crossed.times.is_empty() {
            return T::zero();
        }
        let Self { system, settings, state, next, lasting, jacobian, joints, factor, crossed, free, .. } =
            self;
        let Next { q, v, force, scratch, impulse, contacts, .. } = next;
        let Crossed { times, after } = crossed;
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
        if joints.is_empty() {
            axpy(q, T::one(), scratch);
            return -dot(force, scratch);
        }
        impulse.copy_from_slice(q);
        axpy(q, T::one(), scratch);
        joints.close(system, factor, impulse, q);
        axpy(impulse, -T::one(), q);
        dot(force, impulse)
    }
}
