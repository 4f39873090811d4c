//! The θ-step of Moreau–Jean (52) and Moreau–Jean–Frémond (63) in the one form every law shares.

use std::iter::Peekable;

use nalgebra::SVector;

use super::islands::{WORTH_SPLITTING, choose_start};
use super::joints::joints_of;
use super::lasting::{Lasting, Pace};
use super::nonlinear::Start;
use super::record::Next;
use super::{ActivationRule, ContactStep, Part, Settings, Step, StepError, ThetaScheme};
use crate::contact::{Candidate, ContactId, pose};
use crate::energy::{Balance, Energies};
use crate::laws::{Approach, Rows};
use crate::linalg::{Factor, dot, sums};
use crate::scalar::{Scalar, all_finite, lit, to_f64};
use crate::solver::{Solution, solve_or_rescue};
use crate::system::Prescribed;

/// Most that percussions are scaled by to start the next step with, where its length is another.
const MOST_GROWTH: f64 = 8.0;

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
        // q_{k+1} ← q_{k+1} + Δq, which opens the overlaps of contacts that last
        let position_work = self.correct_positions() + self.place_after_crossings();
        // E_{k+1} − E_k = W_ext + W_damp + (½−θ)(…) + Σ u_{k+θ}·p                                (56)
        let (energies, balance) = self.balance(position_work)?;
        self.set_work_bounds(solution.as_ref());
        self.accept(solution, energies, balance);
        done(Part::Ledger);
        Ok(&self.last)
    }

    fn find_active_contacts(&mut self) -> Result<(), StepError> {
        loop {
            self.list_active_contacts()?;
            let Self { rest, jacobian, .. } = self;
            if !rest.as_mut().is_some_and(|rest| rest.wake(jacobian)) {
                break;
            }
        }
        let Self { lasting, settings, jacobian, next, .. } = self;
        if let Some(lasting) = lasting {
            lasting.assign(settings.theta, jacobian, &mut next.contacts);
        }
        Ok(())
    }

    fn list_active_contacts(&mut self) -> Result<(), StepError> {
        let h = self.settings.step;
        let (mut gap_tolerance, velocity_tolerance) = self.tolerances;
        let mut reach = gap_tolerance;
        if let Some(lasting) = &mut self.lasting {
            lasting.clear();
            if self.settings.activation.gap_tolerance.is_none() {
                gap_tolerance = nalgebra::RealField::max(gap_tolerance, lasting.noise(h));
            }
            reach = gap_tolerance + lasting.reach();
        }
        let rule = self.settings.activation.rule;
        self.candidates.clear();
        let Self { system, state, next: Next { place, scratch, .. }, rest, candidates, crossed, .. } = self;
        if rule == ActivationRule::CurrentGap {
            place.copy_from_slice(&state.q);
        } else {
            scratch.iter_mut().zip(&state.v).for_each(|(s, &v)| *s = h * v);
            system.advance(&state.q, scratch, place);
        }
        let asleep = rest.as_ref().map_or(&[][..], |rest| rest.asleep());
        match rest {
            Some(_) => system.awake_candidates(place, reach, asleep, candidates),
            None => system.candidates(place, reach, candidates),
        }
        crossed.find(&mut **system, &state.q, (h, &state.v), asleep, candidates);
        self.candidates.sort_unstable_by_key(|candidate| candidate.id);
        self.jacobian.clear();
        self.next.contacts.clear();
        let theta = self.settings.theta;
        let mut known = 0;
        for i in 0..self.candidates.len() {
            let Candidate { id, interface, gap } = self.candidates[i];
            if !all_finite([&gap]) {
                return Err(self.contact_error(id, "gap"));
            }
            if interface >= self.laws.len() {
                return Err(self.unknown(id, "interface", interface, self.laws.len()));
            }
            let row = self.jacobian.rows();
            let Next { scratch, place, .. } = &mut self.next;
            let place = self.crossed.place(id, &*self.system, (h, &self.state), (scratch, place));
            self.system.jacobian(id, place, &mut self.jacobian);
            let dofs = self.state.v.len();
            if let Some(column) = self.jacobian.largest_column(row).filter(|&column| column >= dofs) {
                return Err(self.unknown(id, "degree of freedom", column, dofs));
            }
            let before = self.jacobian.velocity(row, &self.state.v);
            if !all_finite(before.iter()) {
                return Err(self.contact_error(id, "Jacobian"));
            }
            let closing = before[0] <= velocity_tolerance;
            let mut lasts = false;
            if let Some(lasting) = &mut self.lasting {
                let last = &self.last.contacts;
                known += last[known..].iter().take_while(|contact| contact.id < id).count();
                let last = last.get(known).filter(|contact| contact.id == id);
                let carried = last.is_some_and(|contact| contact.percussion[0] > T::zero());
                let tolerances = (gap_tolerance, velocity_tolerance);
                let pace =
                    lasting.pace((&self.jacobian, row), h, (id, carried), (gap, before[0]), tolerances);
                // A contact that separates is no impact either: it may have to be kept from closing.
                lasts = pace == Pace::Lasting || !closing;
                if pace == Pace::Lasting || gap <= gap_tolerance {
                    let slow = pace != Pace::Fast;
                    // What is closed to the tolerance is closed: its rounding is no motion.
                    let start = if slow { self.system.gap(id, &self.state.q) } else { T::zero() };
                    let start = if start > gap_tolerance { start } else { T::zero() };
                    lasting.push(&self.jacobian, row, h, (id, start), pace);
                } else {
                    self.jacobian.truncate(row);
                    continue;
                }
            } else if rule == ActivationRule::MoreauJean && !closing {
                self.jacobian.truncate(row);
                continue;
            }
            let contact = ContactStep::starting(id, interface, (gap, before), (theta, lasts));
            self.next.contacts.push(contact);
        }
        Ok(())
    }

    fn set_cone_problem(&mut self) -> Result<(), StepError> {
        let (w, b, cones) = self.problem.parts_mut();
        let Self { jacobian, factor, joints, .. } = self;
        match &mut self.kept {
            Some(kept) => {
                if self.arms.rolls() {
                    kept.forget_selection();
                }
                if let Err(contact) = kept.select(&self.next.contacts, w) {
                    return Err(self.contact_error(contact, "place among the constant candidates"));
                }
            }
            None if joints.is_empty() => self.assembler.assemble(jacobian, factor, w),
            None if jacobian.rows() == 0 => w.clear(),
            None => {
                self.assembler.assemble_with(jacobian, |x: &mut [T]| joints.respond(factor, x), w);
            }
        }
        if self.arms.rolls() {
            self.arms.measure(&self.jacobian, w);
        }
        b.clear();
        cones.clear();
        self.warm_start.clear();
        self.older_start.clear();
        // Percussions of a lasting contact grow with the step; those of an impact, made in a step of its own, do not.
        let growth = growth(self.last_length, self.settings.step);
        let mut known = self.last.contacts.iter().peekable();
        let mut older = self.older.iter().peekable();
        for (i, contact) in self.next.contacts.iter().enumerate() {
            let gap = self.lasting.as_ref().map_or_else(T::zero, |lasting| lasting.entries[i].gap);
            let approach = Approach::impact(contact.before, contact.theta);
            let memory = self.memories.of(contact.id, contact.interface);
            let approach = approach.with_gap(gap, self.settings.step, contact.lasting).with_memory(memory);
            let approach = if self.arms.rolls() { approach.with_rows(Rows::Rolling) } else { approach };
            let free = self.jacobian.velocity(i, &self.next.v_free);
            match pose(&*self.laws[contact.interface], &approach, &free) {
                Ok((shifted, cone)) => {
                    b.push(self.arms.enter_velocity(i, &shifted));
                    cones.push(cone.at_arm(self.arms.length(i)));
                }
                Err(source) => {
                    let (step, time) = self.place();
                    let contact = self.system.contact_label(contact.id);
                    return Err(StepError::Law { step, time, contact, source });
                }
            }
            if self.passes > 0 {
                self.warm_start.push(self.arms.enter(i, &self.percussions[i]));
                continue;
            }
            self.warm_start.push(self.arms.enter(i, &(percussion_of(contact.id, &mut known) * growth)));
            self.older_start.push(self.arms.enter(i, &(percussion_of(contact.id, &mut older) * growth)));
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
        let Self { problem, islands, percussions, solver, jacobian, factor, joints, .. } = self;
        let (warm_start, older) = (&mut self.warm_start, &self.older_start);
        // Of bodies that nothing but contacts couples the solver may see H and M̂.
        let alone = joints.is_empty() && !self.arms.rolls() && self.free == self.system.dofs();
        if let (Factor::Diagonal(inverse), true) = (&*factor, alone) {
            problem.copy_bodies(jacobian, inverse);
        }
        let worth = problem.delassus().formed().filter(|_| contacts > WORTH_SPLITTING);
        let solved = if let Some(w) = worth.filter(|w| islands.split(w) > 1) {
            islands.solve((problem, w), (warm_start, older), percussions, &mut **solver)
        } else {
            // A single contact is solved exactly from anywhere.
            if contacts > 1 {
                choose_start(problem, warm_start, older, solver.stopping().tolerance);
            }
            solve_or_rescue(&mut **solver, problem, (warm_start, older), percussions)
                .map_err(|source| (contacts, source))
        };
        self.arms.leave(percussions);
        if let Some(lasting) = &mut self.lasting {
            lasting.note(problem, solver.stopping().tolerance);
        }
        solved.map(Some).map_err(|(contacts, source)| {
            let (step, time) = self.place();
            StepError::Solve { step, time, contacts, source }
        })
    }

    fn balance(&mut self, position_work: T) -> Result<(Energies<T>, Balance<T>), StepError> {
        let Self { system, settings, state, next, .. } = self;
        let Settings { theta, step: h, .. } = *settings;
        let half = lit::<T>(0.5);
        let mut balance = Balance { position_work, ..Balance::default() };
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
            // (56) is that of the θ-step; springs that a displacement after it stretches give position work.
            let made = self.crossed.made().unwrap_or(&next.q);
            stiffness.multiply(made, &mut next.elastic_force[1]);
            let (elastic, stretch) = increments(&state.q, made, &next.elastic_force);
            balance.elastic_change = elastic;
            square += stretch;
            if self.crossed.made().is_some() {
                let before = dot(made, &next.elastic_force[1]);
                stiffness.multiply(&next.q, &mut next.elastic_force[1]);
                balance.position_work += half * (dot(&next.q, &next.elastic_force[1]) - before);
            }
        }
        balance.external_work = h * dot(&next.v_theta, &next.force);
        if let Some(damping) = system.damping() {
            damping.multiply(&next.v_theta, &mut next.scratch);
            balance.damping_work = -h * dot(&next.v_theta, &next.scratch);
        }
        let [springs, dampers, motors] = self.joints.works(h);
        balance.elastic_change += springs;
        balance.damping_work += dampers;
        balance.external_work += motors;
        if let (false, Some(made)) = (self.joints.is_empty(), self.crossed.made()) {
            let joints = joints_of(&**system);
            balance.position_work += joints.energy(&next.q) - joints.energy(made);
        }
        balance.numerical_dissipation = match self.lasting.as_ref().and_then(Lasting::theta) {
            None => (half - theta) * square,
            Some(thetas) => sums(next.v.len(), |i| {
                let change = next.momentum[1][i] - next.momentum[0][i];
                [(half - thetas[i]) * (next.v[i] - state.v[i]) * change]
            })[0],
        };
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
            || {
                let stretch = system.stiffness().map(|_| dot(&next.q, &next.elastic_force[1]));
                (half * dot(&next.v, &next.momentum[1]), half * stretch.unwrap_or_else(T::zero))
            },
            |nonlinear| nonlinear.next_energies(&next.v),
        );
        let elastic = elastic + joints_of(&**system).energy(&next.q);
        let energies = Energies { kinetic, elastic, potential: system.potential(&next.q) };
        if !all_finite(&[energies.total(), balance.imbalance]) {
            let (step, time) = self.place();
            return Err(StepError::Energy { step, time, kinetic: to_f64(energies.kinetic) });
        }
        Ok((energies, balance))
    }

    /// Σ v_{k+θ}·R over the prescribed degrees of freedom, R the impulses that move them: what M (v_{k+1} − v_k) +
    /// hK q_{k+θ} + hC v_{k+θ} − hF_{k+θ} − Hᵀp leaves there. The damping force stands in `scratch`.
    fn prescribed_work(&mut self) -> T {
        let Self { system, settings: Settings { theta, step: h, .. }, next, jacobian, free, joints, .. } =
            self;
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
        joints.take_from(*free, reaction);
        dot(&v_theta[*free..], reaction)
    }

    fn accept(&mut self, solution: Option<Solution<T>>, energies: Energies<T>, balance: Balance<T>) {
        let Self { system, state, next, last, older, rest, jacobian, .. } = self;
        if let Some(nonlinear) = &mut self.nonlinear {
            nonlinear.accept();
        }
        std::mem::swap(&mut state.q, &mut next.q);
        std::mem::swap(&mut state.v, &mut next.v);
        next.momentum.swap(0, 1);
        next.elastic_force.swap(0, 1);
        if let Some(lasting) = &mut self.lasting {
            lasting.accept(&next.contacts, self.settings.step);
        }
        self.memories.accept(&self.laws, &next.contacts, self.settings.step);
        self.last_length = self.settings.step;
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

/// ½(y−x)·A(y+x) and (y−x)·A(y−x), of x and y with A x and A y: the polarised forms, which do not cancel.
#[inline(always)]
fn increments<T: Scalar>(from: &[T], to: &[T], [a_from, a_to]: &[Vec<T>; 2]) -> (T, T) {
    let n = from.len();
    let (to, a_from, a_to) = (&to[..n], &a_from[..n], &a_to[..n]);
    let [change, square] = sums(n, |i| {
        let difference = to[i] - from[i];
        [difference * (a_to[i] + a_from[i]), difference * (a_to[i] - a_from[i])]
    });
    (lit::<T>(0.5) * change, square)
}

/// Ratio of two lengths of steps, 1 where it is far from that.
fn growth<T: Scalar>(from: T, to: T) -> T {
    let ratio = to / from;
    if ratio <= lit(MOST_GROWTH) && ratio >= lit(1.0 / MOST_GROWTH) { ratio } else { T::one() }
}

/// The percussion of contact `id` in a list ordered by identity, found by walking along; zero where it is not there.
fn percussion_of<'a, T: Scalar, const D: usize>(
    id: ContactId,
    list: &mut Peekable<impl Iterator<Item = &'a ContactStep<T, D>>>,
) -> SVector<T, D> {
    while list.next_if(|old| old.id < id).is_some() {}
    list.next_if(|old| old.id == id).map_or_else(SVector::zeros, |old| old.percussion)
}
