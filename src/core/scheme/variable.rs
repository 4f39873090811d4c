//! Steps of changing length, and the way back from a step that is not kept.

use super::clock::Clock;
use super::memory::Memories;
use super::setup::check_settings;
use super::{ContactStep, SetupError, ThetaScheme};
use crate::contact::Candidate;
use crate::energy::{Balance, Energies};
use crate::scalar::Scalar;
use crate::solver::Solution;
use crate::system::{Prescribed, Scales};

/// A state with all that the next step depends on.
#[derive(Debug)]
pub(crate) struct Saved<T: Scalar, const D: usize> {
    pub(crate) q: Vec<T>,
    pub(crate) v: Vec<T>,
    momentum: Vec<T>,
    elastic_force: Vec<T>,
    pub(crate) contacts: Vec<ContactStep<T, D>>,
    older: Vec<ContactStep<T, D>>,
    energies: Energies<T>,
    balance: Balance<T>,
    solution: Option<Solution<T>>,
    memories: Memories<T>,
    length: T,
    clock: Clock<T>,
}

impl<T: Scalar, const D: usize> Saved<T, D> {
    /// Time (s).
    pub(crate) fn time(&self) -> T {
        self.clock.origin
    }
}

impl<T: Scalar, const D: usize> ThetaScheme<T, D> {
    /// Gives the steps from here on the length `step` (s). Nothing else changes: θ, laws, active set and state stay.
    ///
    /// M̂ is factored where it depends on h and `step` is not one of the lengths used last, 64 of them at most.
    ///
    /// # Errors
    /// [`SetupError`]: h not finite or ≤ 0, M̂ not positive definite; displacements that move, whose states q_k depend
    /// on h; bodies that may sleep. The length is then as it was.
    pub fn set_step(&mut self, step: T) -> Result<(), SetupError> {
        if self.system.prescribed().is_some_and(Prescribed::moves) {
            return Err(SetupError::MovingStep);
        }
        if self.rest.is_some() {
            return Err(SetupError::SleepingStep);
        }
        if step == self.settings.step {
            return Ok(());
        }
        let settings = super::Settings { step, ..self.settings };
        check_settings(&settings)?;
        if self.system.stiffness().is_some() || self.system.damping().is_some() {
            self.matrix.refactor(&mut *self.system, &settings, &self.state.q, self.settings.step)?;
        }
        self.clock = self.clock.moved(self.state.index, self.settings.step);
        self.settings.step = step;
        Ok(())
    }

    /// Factorisations that changes of the step have cost so far.
    pub fn factorisations(&self) -> usize {
        self.matrix.factorisations()
    }

    /// Whether a new length costs a factorisation.
    pub(crate) fn factors_lengths(&self) -> bool {
        let varies = self.system.stiffness().is_some() || self.system.damping().is_some();
        varies && !self.matrix.is_cheap()
    }

    /// t − t_k, without the rounding of t_k.
    pub(crate) fn until(&self, time: T) -> T {
        self.clock.until(time, self.state.index, self.settings.step)
    }

    /// The length and the speed that the scene had at its start.
    pub(crate) fn scales(&self) -> Scales<T> {
        self.equations.scales
    }

    /// Tolerances (gap, velocity) of the active set.
    pub(crate) fn tolerances(&self) -> (T, T) {
        self.active.tolerances
    }

    pub(crate) fn set_tolerances(&mut self, tolerances: (T, T)) {
        self.active.tolerances = tolerances;
    }

    /// A place to save states in.
    pub(crate) fn saved(&self) -> Saved<T, D> {
        Saved {
            q: self.state.q.clone(),
            v: self.state.v.clone(),
            momentum: self.next.momentum[0].clone(),
            elastic_force: self.next.elastic_force[0].clone(),
            contacts: self.last.contacts.clone(),
            older: self.warm.contacts.clone(),
            energies: self.last.energies,
            balance: self.last.balance,
            solution: self.last.solution,
            memories: self.memories.clone(),
            length: self.warm.length,
            clock: self.clock.moved(self.state.index, self.settings.step),
        }
    }

    pub(crate) fn save(&self, saved: &mut Saved<T, D>) {
        saved.q.copy_from_slice(&self.state.q);
        saved.v.copy_from_slice(&self.state.v);
        saved.momentum.copy_from_slice(&self.next.momentum[0]);
        if self.system.stiffness().is_some() {
            saved.elastic_force.copy_from_slice(&self.next.elastic_force[0]);
        }
        saved.contacts.clone_from(&self.last.contacts);
        saved.older.clone_from(&self.warm.contacts);
        (saved.energies, saved.balance, saved.solution) =
            (self.last.energies, self.last.balance, self.last.solution);
        saved.memories.copy_from(&self.memories);
        saved.length = self.warm.length;
        saved.clock = self.clock.moved(self.state.index, self.settings.step);
    }

    /// Goes back to a state saved; the length of the steps stays.
    pub(crate) fn recall(&mut self, saved: &Saved<T, D>) {
        self.state.q.copy_from_slice(&saved.q);
        self.state.v.copy_from_slice(&saved.v);
        self.next.momentum[0].copy_from_slice(&saved.momentum);
        if self.system.stiffness().is_some() {
            self.next.elastic_force[0].copy_from_slice(&saved.elastic_force);
        }
        if let (Some(nonlinear), Some(dynamics)) = (&mut self.equations.nonlinear, self.system.nonlinear()) {
            nonlinear.start_from(dynamics, &saved.q);
        }
        self.last.contacts.clone_from(&saved.contacts);
        self.warm.contacts.clone_from(&saved.older);
        (self.last.energies, self.last.balance, self.last.solution) =
            (saved.energies, saved.balance, saved.solution);
        self.memories.copy_from(&saved.memories);
        self.warm.length = saved.length;
        self.clock = saved.clock;
        (self.state.index, self.state.time) = (saved.clock.index, saved.clock.origin);
    }

    /// forces ← M̂⁻¹ forces: accelerations, but for h.
    pub(crate) fn accelerate(&mut self, forces: &mut [T]) {
        self.matrix.factor.solve_in_place(&mut forces[..self.matrix.free]);
        forces[self.matrix.free..].fill(T::zero());
    }

    /// Candidates with gap ≤ `reach` in configuration q.
    pub(crate) fn candidates_at(&mut self, q: &[T], reach: T, out: &mut Vec<Candidate<T>>) {
        out.clear();
        self.system.candidates(q, reach, out);
    }

    /// u_N = H_N(q) v of a contact.
    pub(crate) fn gap_rate(&mut self, contact: crate::contact::ContactId, q: &[T], v: &[T]) -> T {
        self.active.jacobian.clear();
        self.system.jacobian(contact, q, &mut self.active.jacobian);
        self.active.jacobian.velocity(0, v)[0]
    }

    /// No contact lasts from here on: the rule of the active set and the θ of the scene hold everywhere.
    pub(crate) fn without_lasting_contacts(&mut self) {
        self.lasting = None;
    }
}
