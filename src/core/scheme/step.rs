//! The θ-step of Moreau–Jean (52) and Moreau–Jean–Frémond (63) in the one form every law shares.

use super::active_set::ActiveSet;
use super::cones::WarmStart;
use super::{Part, Step, StepError, ThetaScheme};
use crate::contact::ContactId;
use crate::energy::{Balance, Energies};
use crate::scalar::{Scalar, all_finite, to_f64};
use crate::solver::Solution;

impl<T: Scalar, const D: usize> ThetaScheme<T, D> {
    /// Makes one step of (52)/(63).
    ///
    /// # Errors
    /// [`StepError`] with the time and the numbers; the state is then that of before the step.
    pub fn step(&mut self) -> Result<&Step<T, D>, StepError> {
        self.step_with(|_| ())
    }

    /// [`step`](Self::step) that tells when each part of it is done, for measurements.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn step_with(&mut self, done: impl FnMut(Part)) -> Result<&Step<T, D>, StepError> {
        // (q_m, v) of what turns by itself
        self.take_off();
        match self.make_step(done) {
            Ok(()) => Ok(&self.last),
            Err(error) => {
                self.fall_back();
                Err(error)
            }
        }
    }

    fn make_step(&mut self, mut done: impl FnMut(Part)) -> Result<(), StepError> {
        // α is active iff g^α(q_k + h v_k) ≤ 0 and u^α_{N,k} ≤ 0                                 (55)
        self.find_active_contacts()?;
        done(Part::ActiveSet);
        self.start_passes()?;
        let solution = loop {
            // M̂ (v_free − v_k) = h (F_{k+θ} − C v_k − K (q_k + hθ v_k))
            self.set_free_velocity()?;
            done(Part::FreeVelocity);
            // w = W p + b,  W = H M̂⁻¹ Hᵀ,  b = H v_free + δ,  δ = ((1−γ) u_k + s)/γ
            self.set_cone_problem()?;
            done(Part::ConeProblem);
            // K* ∋ Φ(w) ⟂ p ∈ K                                                                  (81)
            let solution = self.solve_cone_problem()?;
            done(Part::ConeSolution);
            // v_{k+1} = v_free + M̂⁻¹ Hᵀ p,  q_{k+1} = q_k + h v_{k+θ}
            self.set_next_state()?;
            done(Part::NextState);
            // Joints and nonlinear terms depend on q_{k+1}; without them the first pass is the last.
            if self.is_last_pass()? {
                break solution;
            }
        };
        // q_{k+1} ← q_{k+1} + Δq, which opens the overlaps of contacts that last
        let position_work = self.correct_positions() + self.place_after_crossings();
        // E_{k+1} − E_k = W_ext + W_damp + (½−θ)(…) + Σ u_{k+θ}·p                                (56)
        let (energies, balance) = self.balance(position_work)?;
        self.set_work_bounds(solution.as_ref());
        self.accept(solution, energies, balance);
        done(Part::Ledger);
        Ok(())
    }

    fn accept(&mut self, solution: Option<Solution<T>>, energies: Energies<T>, balance: Balance<T>) {
        let Self {
            system,
            state,
            next,
            last,
            warm: WarmStart { contacts: older, .. },
            rest,
            flight,
            active: ActiveSet { jacobian, .. },
            ..
        } = self;
        if let Some(nonlinear) = &mut self.equations.nonlinear {
            nonlinear.accept();
        }
        if let Some(flight) = flight {
            std::mem::swap(&mut next.v, &mut flight.after);
        }
        std::mem::swap(&mut state.q, &mut next.q);
        std::mem::swap(&mut state.v, &mut next.v);
        next.momentum.swap(0, 1);
        next.elastic_force.swap(0, 1);
        if let Some(lasting) = &mut self.lasting {
            if self.equations.joints.drives() {
                // What motors do is known behind the step.
                next.scratch.copy_from_slice(&next.force);
                self.equations.joints.add_forces(self.settings.step, &mut next.scratch);
                lasting.set_pull(&mut self.matrix.factor, &mut next.scratch);
            }
            lasting.accept(&next.contacts, self.settings.step, self.active.tolerances.1);
        }
        self.memories.accept(&self.laws, &next.contacts, self.settings.step);
        self.warm.length = self.settings.step;
        state.index += 1;
        state.time = self.clock.at(state.index, self.settings.step);
        (last.energies, last.balance, last.solution) = (energies, balance, solution);
        std::mem::swap(older, &mut last.contacts);
        if let Some(rest) = rest {
            rest.merge(&next.contacts, &mut last.contacts);
            let moving = (&mut *state.v, &mut *next.momentum[0]);
            rest.settle(system.mass(), moving, &next.contacts, jacobian, state.index);
            return;
        }
        std::mem::swap(&mut last.contacts, &mut next.contacts);
        // The lists take turns: they grow now, or the next contact would find a smaller one.
        next.contacts.clear();
        next.contacts.reserve(last.contacts.len());
        older.reserve(last.contacts.len().saturating_sub(older.len()));
    }

    /// Number of the step being made, and the time at its end.
    pub(super) fn place(&self) -> (usize, f64) {
        (self.state.index + 1, to_f64(self.state.time + self.settings.step))
    }

    #[cold]
    pub(super) fn state_error(&self, what: &'static str, x: &[T]) -> StepError {
        let component = x.iter().position(|x| !all_finite([x])).unwrap_or_default();
        let (step, time) = self.place();
        StepError::State { step, time, what, component, value: to_f64(x[component]) }
    }

    #[cold]
    pub(super) fn contact_error(&self, contact: ContactId, what: &'static str) -> StepError {
        let (step, time) = self.place();
        StepError::Contact { step, time, contact: self.system.contact_label(contact), what }
    }

    #[cold]
    pub(super) fn unknown(
        &self,
        contact: ContactId,
        what: &'static str,
        index: usize,
        count: usize,
    ) -> StepError {
        let (step, time) = self.place();
        StepError::Unknown { step, time, contact: self.system.contact_label(contact), what, index, count }
    }
}
