//! Where bodies are that met within a step: they move on from where they met, and stop where they would cross again.

use super::ThetaScheme;
use super::active_set::ActiveSet;
use super::crossed::Crossed;
use super::equations::Equations;
use super::lasting::Lasting;
use super::matrix::Matrix;
use super::record::Next;
use crate::linalg::dot;
use crate::scalar::Scalar;

/// Most times that bodies are stopped in one step: who stops may be in the way of others.
const MOST_STOPS: usize = 8;

impl<T: Scalar, const D: usize> ThetaScheme<T, D> {
    /// Lets bodies that met within the step move on from where they met, up to where they meet again; the position work, −F·Δq.
    pub(super) fn place_after_crossings(&mut self) -> T {
        self.active.crossed.displaced = false;
        if self.system.body_dofs().is_none() {
            return T::zero();
        }
        if self.system.stiffness().is_some() || !self.equations.joints.is_empty() {
            self.active.crossed.made.copy_from_slice(&self.next.q);
        }
        self.move_on() + self.stop_at_crossings()
    }

    fn move_on(&mut self) -> T {
        if self.active.crossed.times.is_empty() {
            return T::zero();
        }
        let Self {
            settings,
            state,
            next,
            lasting,
            active: ActiveSet { jacobian, crossed, .. },
            equations: Equations { joints, .. },
            matrix: Matrix { free, .. },
            ..
        } = self;
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
        self.active.crossed.displaced = true;
        let Self { system, next, equations: Equations { joints, .. }, matrix: Matrix { factor, .. }, .. } =
            self;
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
            let Self {
                system,
                state,
                next,
                equations: Equations { joints, .. },
                active: ActiveSet { crossed, .. },
                rest,
                ..
            } = self;
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
