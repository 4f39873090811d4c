//! The θ-step of Moreau–Jean (52) and Moreau–Jean–Frémond (63) in the one form every law shares.

use nalgebra::SVector;

use super::islands::WORTH_SPLITTING;
use super::nonlinear::Start;
use super::record::Next;
use super::{ActivationRule, ContactStep, Part, Settings, Step, StepError, ThetaScheme};
use crate::contact::{Candidate, ContactId};
use crate::energy::{Balance, Energies};
use crate::laws::ContactLaw;
use crate::linalg::{axpy, dot, sums};
use crate::scalar::{Scalar, all_finite, lit, to_f64};
use crate::solver::{ConeSolver, Solution};
use crate::system::{MechanicalSystem, Prescribed};

impl<T, const D: usize, S, L, V> ThetaScheme<T, D, S, L, V>
where
    T: Scalar,
    S: MechanicalSystem<T, D>,
    L: ContactLaw<T, D>,
    V: ConeSolver<T, D>,
{
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
    pub fn step_with(&mut self, mut done: impl FnMut(Part)) -> Result<&Step<T, D>, StepError> {
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
        // E_{k+1} − E_k = W_ext + W_damp + (½−θ)(…) + Σ u_{k+θ}·p                                (56)
        let (energies, balance) = self.balance()?;
        self.accept(solution, energies, balance);
        done(Part::Ledger);
        Ok(&self.last)
    }

    fn find_active_contacts(&mut self) -> Result<(), StepError> {
        let h = self.settings.step;
        let (gap_tolerance, velocity_tolerance) = self.tolerances;
        let rule = self.settings.activation.rule;
        self.candidates.clear();
        if rule == ActivationRule::CurrentGap {
            self.system.candidates(&self.state.q, gap_tolerance, &mut self.candidates);
        } else {
            let Next { scratch, .. } = &mut self.next;
            scratch.copy_from_slice(&self.state.q);
            axpy(scratch, h, &self.state.v);
            self.system.candidates(scratch, gap_tolerance, &mut self.candidates);
        }
        self.candidates.sort_unstable_by_key(|candidate| candidate.id);
        self.jacobian.clear();
        self.next.contacts.clear();
        for i in 0..self.candidates.len() {
            let Candidate { id, interface, gap } = self.candidates[i];
            if !all_finite([&gap]) {
                return Err(self.contact_error(id, "gap"));
            }
            if interface >= self.laws.len() {
                return Err(self.unknown(id, "interface", interface, self.laws.len()));
            }
            let row = self.jacobian.rows();
            self.system.jacobian(id, &self.state.q, &mut self.jacobian);
            let dofs = self.state.v.len();
            if let Some(column) = self.jacobian.largest_column(row).filter(|&column| column >= dofs) {
                return Err(self.unknown(id, "degree of freedom", column, dofs));
            }
            let before = self.jacobian.velocity(row, &self.state.v);
            if !all_finite(before.iter()) {
                return Err(self.contact_error(id, "Jacobian"));
            }
            if rule == ActivationRule::MoreauJean && before[0] > velocity_tolerance {
                self.jacobian.truncate(row);
                continue;
            }
            let zero = SVector::zeros();
            let (normal_work, tangential_work) = (T::zero(), T::zero());
            let (after, percussion) = (zero, zero);
            self.next.contacts.push(ContactStep {
                id,
                interface,
                gap,
                before,
                after,
                percussion,
                normal_work,
                tangential_work,
            });
        }
        Ok(())
    }

    fn set_cone_problem(&mut self) -> Result<(), StepError> {
        let (w, b, friction) = self.problem.parts_mut();
        let Self { jacobian, factor, joints, .. } = self;
        match &mut self.kept {
            Some(kept) => {
                if let Err(contact) = kept.select(&self.next.contacts, w) {
                    return Err(self.contact_error(contact, "place among the constant candidates"));
                }
            }
            None if joints.is_empty() => self.assembler.assemble(jacobian, factor, w),
            None if jacobian.rows() == 0 => w.clear(),
            None => {
                let apply = |x: &mut [T]| {
                    factor.solve_in_place(x);
                    joints.constrain(factor, x);
                };
                self.assembler.assemble_with(jacobian, apply, w);
            }
        }
        b.clear();
        friction.clear();
        self.warm_start.clear();
        let mut known = self.last.contacts.iter().peekable();
        for (i, contact) in self.next.contacts.iter().enumerate() {
            let law = &self.laws[contact.interface];
            let evaluation = law.evaluate(&contact.before, self.settings.theta);
            let valid = evaluation.gamma > T::zero() && all_finite(evaluation.shift.iter());
            if !(valid && all_finite([&evaluation.gamma])) {
                return Err(StepError::Law {
                    step: self.state.index + 1,
                    time: to_f64(self.state.time + self.settings.step),
                    contact: self.system.contact_label(contact.id),
                    law: law.name().into(),
                    gamma: to_f64(evaluation.gamma),
                    shift: to_f64(evaluation.shift[0]),
                });
            }
            b.push(self.jacobian.velocity(i, &self.next.v_free) + evaluation.b_shift(&contact.before));
            friction.push(law.friction());
            // Both lists are ordered by identity: the percussion of the last step is found by walking along.
            if self.passes > 0 {
                self.warm_start.push(self.percussions[i]);
                continue;
            }
            while known.next_if(|old| old.id < contact.id).is_some() {}
            let old = known.next_if(|old| old.id == contact.id);
            self.warm_start.push(old.map_or_else(SVector::zeros, |old| old.percussion));
        }
        Ok(())
    }

    fn solve_cone_problem(&mut self) -> Result<Option<Solution<T>>, StepError> {
        let contacts = self.problem.contacts();
        self.percussions.clear();
        self.percussions.resize(contacts, SVector::zeros());
        if contacts == 0 {
            return Ok(None);
        }
        let Self { problem, islands, warm_start, percussions, solver, .. } = self;
        let solved = if contacts > WORTH_SPLITTING && islands.split(problem.delassus()) > 1 {
            islands.solve(problem, warm_start, percussions, solver)
        } else {
            solver.solve(problem, warm_start, percussions).map_err(|source| (contacts, source))
        };
        solved.map(Some).map_err(|(contacts, source)| {
            let (step, time) = self.place();
            StepError::Solve { step, time, contacts, source }
        })
    }

    fn balance(&mut self) -> Result<(Energies<T>, Balance<T>), StepError> {
        let Self { system, settings, state, next, .. } = self;
        let Settings { theta, step: h, .. } = *settings;
        let half = lit::<T>(0.5);
        let mut balance = Balance::default();
        // Increments by the polarised forms ½(y−x)·A(y+x), which do not cancel.
        let increments = |from: &[T], to: &[T], [a_from, a_to]: &[Vec<T>; 2]| {
            let n = from.len();
            let (to, a_from, a_to) = (&to[..n], &a_from[..n], &a_to[..n]);
            let [change, square] = sums(n, |i| {
                let difference = to[i] - from[i];
                [difference * (a_to[i] + a_from[i]), difference * (a_to[i] - a_from[i])]
            });
            (half * change, square)
        };
        let mut square;
        if let Some(nonlinear) = &self.nonlinear {
            let start = Start::of(state, settings, &next.force);
            (balance.kinetic_change, balance.elastic_change, balance.damping_work, square) =
                nonlinear.changes(start, &next.v);
        } else {
            system.mass().multiply(&next.v, &mut next.momentum[1]);
            (balance.kinetic_change, square) = increments(&state.v, &next.v, &next.momentum);
        }
        if let Some(stiffness) = system.stiffness() {
            stiffness.multiply(&next.q, &mut next.elastic_force[1]);
            let (elastic, stretch) = increments(&state.q, &next.q, &next.elastic_force);
            balance.elastic_change = elastic;
            square += stretch;
        }
        balance.external_work = h * dot(&next.v_theta, &next.force);
        if let Some(damping) = system.damping() {
            damping.multiply(&next.v_theta, &mut next.scratch);
            balance.damping_work = -h * dot(&next.v_theta, &next.scratch);
        }
        balance.numerical_dissipation = (half - theta) * square;
        if system.prescribed().is_some_and(Prescribed::moves) {
            balance.prescribed_work = self.prescribed_work();
        }
        let Self { system, next, .. } = self;
        for contact in &next.contacts {
            balance.normal_contact_work += contact.normal_work;
            balance.tangential_contact_work += contact.tangential_work;
        }
        balance.close();
        let (kinetic, elastic) = self.nonlinear.as_ref().map_or_else(
            || (half * dot(&next.v, &next.momentum[1]), half * dot(&next.q, &next.elastic_force[1])),
            |nonlinear| nonlinear.next_energies(&next.v),
        );
        let energies = Energies { kinetic, elastic, potential: system.forces().potential(&next.q) };
        if !all_finite(&[energies.total(), balance.imbalance]) {
            let (step, time) = self.place();
            return Err(StepError::Energy { step, time, kinetic: to_f64(energies.kinetic) });
        }
        Ok((energies, balance))
    }

    /// Σ v_{k+θ}·R over the prescribed degrees of freedom, R the impulses that move them: what M (v_{k+1} − v_k) +
    /// hK q_{k+θ} + hC v_{k+θ} − hF_{k+θ} − Hᵀp leaves there. The damping force stands in `scratch`.
    fn prescribed_work(&mut self) -> T {
        let Self { system, settings: Settings { theta, step: h, .. }, next, jacobian, free, .. } = self;
        let (theta, h) = (*theta, *h);
        let Next { v_theta, force, scratch, momentum, elastic_force, reaction, .. } = next;
        for (place, i) in (*free..v_theta.len()).enumerate() {
            let mut impulse = momentum[1][i] - momentum[0][i] - h * force[i];
            if system.stiffness().is_some() {
                impulse += h * ((T::one() - theta) * elastic_force[0][i] + theta * elastic_force[1][i]);
            }
            if system.damping().is_some() {
                impulse += h * scratch[i];
            }
            reaction[place] = impulse;
        }
        for (row, p) in self.percussions.iter().enumerate() {
            for (dof, entry) in jacobian.row(row).filter(|&(dof, _)| dof >= *free) {
                reaction[dof - *free] -= entry.dot(p);
            }
        }
        dot(&v_theta[*free..], reaction)
    }

    fn accept(&mut self, solution: Option<Solution<T>>, energies: Energies<T>, balance: Balance<T>) {
        let Self { state, next, last, .. } = self;
        if let Some(nonlinear) = &mut self.nonlinear {
            nonlinear.accept();
        }
        std::mem::swap(&mut state.q, &mut next.q);
        std::mem::swap(&mut state.v, &mut next.v);
        next.momentum.swap(0, 1);
        next.elastic_force.swap(0, 1);
        std::mem::swap(&mut last.contacts, &mut next.contacts);
        // The two lists take turns: both grow now, or the next contact would find the smaller one.
        next.contacts.clear();
        next.contacts.reserve(last.contacts.len());
        (last.energies, last.balance, last.solution) = (energies, balance, solution);
        state.index += 1;
        state.time = self.clock.at(state.index, self.settings.step);
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
    fn contact_error(&self, contact: ContactId, what: &'static str) -> StepError {
        let (step, time) = self.place();
        StepError::Contact { step, time, contact: self.system.contact_label(contact), what }
    }

    #[cold]
    fn unknown(&self, contact: ContactId, what: &'static str, index: usize, count: usize) -> StepError {
        let (step, time) = self.place();
        StepError::Unknown { step, time, contact: self.system.contact_label(contact), what, index, count }
    }
}
