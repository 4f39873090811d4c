//! The θ-step of Moreau–Jean (52) and Moreau–Jean–Frémond (63) in the one form every law shares.

use nalgebra::SVector;

use super::delassus::Assembler;
use super::{Activation, ActivationRule, SetupError, StepError};
use crate::cone::ConeProblem;
use crate::contact::{Candidate, ContactId};
use crate::energy::{Balance, Energies};
use crate::laws::ContactLaw;
use crate::linalg::{BlockRows, Factor, Symmetric, axpy, dot};
use crate::scalar::{Scalar, all_finite, epsilon, lit, to_f64};
use crate::solver::{ConeSolver, Solution};
use crate::system::MechanicalSystem;

/// Parameters of the scheme.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings<T> {
    /// θ ∈ [0, 1] of x_{k+θ} = (1−θ) x_k + θ x_{k+1}; ½ conserves energy between impacts.
    pub theta: T,
    /// Time step h > 0 (s).
    pub step: T,
    /// Rule and tolerances of the active set.
    pub activation: Activation<T>,
    /// Opt-out: accept a θ outside the interval in which a law is proved dissipative. Default `false`. Laws that
    /// claim no interval at all constrain θ in neither case.
    pub allow_unproved_theta: bool,
}

impl<T: Scalar> Settings<T> {
    /// θ and h, with the paper's active set (55).
    pub fn new(theta: T, step: T) -> Self {
        Self { theta, step, activation: Activation::default(), allow_unproved_theta: false }
    }
}

/// The state at a time of the run.
#[derive(Debug, Clone, PartialEq)]
pub struct State<T> {
    /// Steps made, k.
    pub index: usize,
    /// Time t_k = t₀ + k h (s).
    pub time: T,
    /// Configuration q_k.
    pub q: Vec<T>,
    /// Velocity v_k.
    pub v: Vec<T>,
}

/// What happened at an active contact during a step.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactStep<T: Scalar, const D: usize> {
    /// Who.
    pub id: ContactId,
    /// Interface, and so law, it belongs to.
    pub interface: usize,
    /// The gap the activation rule tested (m).
    pub gap: T,
    /// Local velocity u_k = H(q_k) v_k (m/s).
    pub before: SVector<T, D>,
    /// Local velocity u_{k+1} = H(q_k) v_{k+1} (m/s).
    pub after: SVector<T, D>,
    /// Percussion p_{k+1} (N s).
    pub percussion: SVector<T, D>,
    /// Normal contact work u_{N,k+θ} p_N (J).
    pub normal_work: T,
    /// Tangential contact work u_{T,k+θ}·p_T (J).
    pub tangential_work: T,
}

/// What a step did.
#[derive(Debug, Clone, PartialEq)]
pub struct Step<T: Scalar, const D: usize> {
    /// The active contacts, ordered by identity.
    pub contacts: Vec<ContactStep<T, D>>,
    /// Energies at the end of the step.
    pub energies: Energies<T>,
    /// The balance (56) of the step.
    pub balance: Balance<T>,
    /// What the cone solver reported; `None` where no contact was active.
    pub solution: Option<Solution<T>>,
}

/// The Moreau–Jean θ-scheme over a system, one law per interface, and a cone solver.
///
/// A warm step allocates nothing. A step that fails leaves the state as it was.
#[derive(Debug)]
pub struct ThetaScheme<T: Scalar, const D: usize, S, L, V> {
    system: S,
    laws: Vec<L>,
    solver: V,
    settings: Settings<T>,
    tolerances: (T, T),
    /// Factors of M̂ = M + hθC + h²θ²K.
    factor: Factor<T>,
    assembler: Assembler<T, D>,
    start_time: T,
    state: State<T>,
    last: Step<T, D>,
    next: Next<T, D>,
    candidates: Vec<Candidate<T>>,
    jacobian: BlockRows<T, D>,
    problem: ConeProblem<T, D>,
    warm_start: Vec<SVector<T, D>>,
    percussions: Vec<SVector<T, D>>,
}

/// The step being made; it becomes the state only when all of it succeeded.
#[derive(Debug)]
struct Next<T: Scalar, const D: usize> {
    q: Vec<T>,
    v: Vec<T>,
    v_theta: Vec<T>,
    v_free: Vec<T>,
    force: Vec<T>,
    scratch: Vec<T>,
    /// M v and K q of the state, and of its successor.
    momentum: [Vec<T>; 2],
    elastic_force: [Vec<T>; 2],
    contacts: Vec<ContactStep<T, D>>,
}

impl<T, const D: usize, S, L, V> ThetaScheme<T, D, S, L, V>
where
    T: Scalar,
    S: MechanicalSystem<T, D>,
    L: ContactLaw<T, D>,
    V: ConeSolver<T, D>,
{
    /// Sets the scheme up at time `start_time` in the state (q, v); `laws[i]` governs interface i.
    ///
    /// # Errors
    /// [`SetupError`]: θ outside [0, 1] or outside the interval claimed by a law, h ≤ 0, wrong sizes, a state
    /// that is not finite, M or M̂ not positive definite.
    pub fn new(
        system: S,
        laws: Vec<L>,
        solver: V,
        settings: Settings<T>,
        start_time: T,
        q: Vec<T>,
        v: Vec<T>,
    ) -> Result<Self, SetupError> {
        solver.stopping().check()?;
        check_settings(&settings)?;
        check_laws(&laws, system.interfaces(), &settings)?;
        let n = system.dofs();
        for (what, x) in [("q", &q), ("v", &v)] {
            if x.len() != n {
                return Err(SetupError::StateSize { what, expected: n, given: x.len() });
            }
            if let Some(component) = x.iter().position(|x| !all_finite([x])) {
                return Err(SetupError::NotFinite { what, component });
            }
        }
        Factor::new(system.mass()).map_err(SetupError::Mass)?;
        let factor =
            Factor::new(&iteration_matrix(&system, &settings)).map_err(SetupError::IterationMatrix)?;

        let tolerances = settings.activation.tolerances(system.scales(&q, &v));
        for (what, value) in [("gap", tolerances.0), ("velocity", tolerances.1)] {
            if !(value > T::zero() && all_finite([&value])) {
                return Err(SetupError::ActivationTolerance { what, value: to_f64(value) });
            }
        }
        let zeros = || vec![T::zero(); n];
        let mut next = Next {
            q: zeros(),
            v: zeros(),
            v_theta: zeros(),
            v_free: zeros(),
            force: zeros(),
            scratch: zeros(),
            momentum: [zeros(), zeros()],
            elastic_force: [zeros(), zeros()],
            contacts: Vec::new(),
        };
        system.mass().multiply(&v, &mut next.momentum[0]);
        if let Some(stiffness) = system.stiffness() {
            stiffness.multiply(&q, &mut next.elastic_force[0]);
        }
        let energies = Energies {
            kinetic: dot(&v, &next.momentum[0]) * lit::<T>(0.5),
            elastic: dot(&q, &next.elastic_force[0]) * lit::<T>(0.5),
            potential: system.forces().potential(&q),
        };
        Ok(Self {
            system,
            laws,
            solver,
            settings,
            tolerances,
            factor,
            assembler: Assembler::new(n),
            start_time,
            state: State { index: 0, time: start_time, q, v },
            last: Step { contacts: Vec::new(), energies, balance: Balance::default(), solution: None },
            next,
            candidates: Vec::new(),
            jacobian: BlockRows::new(),
            problem: ConeProblem::default(),
            warm_start: Vec::new(),
            percussions: Vec::new(),
        })
    }

    /// Makes one step of (52)/(63).
    ///
    /// # Errors
    /// [`StepError`] with the time and the numbers; the state is then that of before the step.
    pub fn step(&mut self) -> Result<&Step<T, D>, StepError> {
        // M̂ (v_free − v_k) = h (F_{k+θ} − C v_k − K (q_k + hθ v_k))
        self.set_free_velocity();
        // α is active iff g^α(q_k + h v_k) ≤ 0 and u^α_{N,k} ≤ 0                                 (55)
        self.find_active_contacts()?;
        // w = W p + b,  W = H M̂⁻¹ Hᵀ,  b = H v_free + δ,  δ = ((1−γ) u_k + s)/γ
        self.set_cone_problem()?;
        // K* ∋ Φ(w) ⟂ p ∈ K                                                                      (81)
        let solution = self.solve_cone_problem()?;
        // v_{k+1} = v_free + M̂⁻¹ Hᵀ p,  q_{k+1} = q_k + h v_{k+θ}
        self.set_next_state()?;
        // E_{k+1} − E_k = W_ext + W_damp + (½−θ)(…) + Σ u_{k+θ}·p                                (56)
        let (energies, balance) = self.balance();
        self.accept(solution, energies, balance);
        Ok(&self.last)
    }

    fn set_free_velocity(&mut self) {
        let Self { system, settings: Settings { theta, step: h, .. }, state, next, factor, .. } = self;
        let Next { v_free, force, scratch, elastic_force, .. } = next;
        system.forces().averaged(state.time, *h, *theta, force, scratch);
        v_free.copy_from_slice(force);
        if let Some(damping) = system.damping() {
            damping.multiply(&state.v, scratch);
            axpy(v_free, -T::one(), scratch);
        }
        if let Some(stiffness) = system.stiffness() {
            stiffness.multiply(&state.v, scratch);
            axpy(v_free, -(*h * *theta), scratch);
            axpy(v_free, -T::one(), &elastic_force[0]);
        }
        v_free.iter_mut().for_each(|x| *x *= *h);
        factor.solve_in_place(v_free);
        axpy(v_free, T::one(), &state.v);
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
            let row = self.jacobian.rows();
            self.system.jacobian(id, &self.state.q, &mut self.jacobian);
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
        self.assembler.assemble(&self.jacobian, &mut self.factor, w);
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
        match self.solver.solve(&self.problem, &self.warm_start, &mut self.percussions) {
            Ok(solution) => Ok(Some(solution)),
            Err(source) => {
                let (step, time) = (self.state.index + 1, to_f64(self.state.time + self.settings.step));
                Err(StepError::Solve { step, time, contacts, source })
            }
        }
    }

    fn set_next_state(&mut self) -> Result<(), StepError> {
        let Settings { theta, step: h, .. } = self.settings;
        let Next { q, v, v_theta, v_free, scratch, contacts, .. } = &mut self.next;
        v.copy_from_slice(v_free);
        if !contacts.is_empty() {
            scratch.fill(T::zero());
            for (row, p) in self.percussions.iter().enumerate() {
                self.jacobian.add_transpose(row, p, scratch);
            }
            self.factor.solve_in_place(scratch);
            axpy(v, T::one(), scratch);
        }
        let other = T::one() - theta;
        for (i, v_theta) in v_theta.iter_mut().enumerate() {
            *v_theta = other * self.state.v[i] + theta * v[i];
            q[i] = self.state.q[i] + h * *v_theta;
        }
        for (i, contact) in contacts.iter_mut().enumerate() {
            contact.percussion = self.percussions[i];
            contact.after = self.jacobian.velocity(i, v);
            let average = contact.before * other + contact.after * theta;
            contact.normal_work = average[0] * contact.percussion[0];
            contact.tangential_work = average.dot(&contact.percussion) - contact.normal_work;
            if D == 1 {
                contact.tangential_work = T::zero();
            }
        }
        for (what, x) in [("v", &*v), ("q", &*q)] {
            if !all_finite(x) {
                let component = x.iter().position(|x| !all_finite([x])).unwrap_or_default();
                let (step, time) = (self.state.index + 1, to_f64(self.state.time + h));
                return Err(StepError::State { step, time, what, component });
            }
        }
        Ok(())
    }

    fn balance(&mut self) -> (Energies<T>, Balance<T>) {
        let Self { system, settings: Settings { theta, step: h, .. }, state, next, .. } = self;
        let (half, h) = (lit::<T>(0.5), *h);
        let mut balance = Balance::default();
        // Increments by the polarised forms ½(y−x)·A(y+x), which do not cancel.
        let increments = |from: &[T], to: &[T], [a_from, a_to]: &[Vec<T>; 2]| {
            let (mut change, mut square) = (T::zero(), T::zero());
            for i in 0..from.len() {
                let difference = to[i] - from[i];
                change += difference * (a_to[i] + a_from[i]);
                square += difference * (a_to[i] - a_from[i]);
            }
            (half * change, square)
        };
        system.mass().multiply(&next.v, &mut next.momentum[1]);
        let (kinetic, mut square) = increments(&state.v, &next.v, &next.momentum);
        balance.kinetic_change = kinetic;
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
        balance.numerical_dissipation = (half - *theta) * square;
        for contact in &next.contacts {
            balance.normal_contact_work += contact.normal_work;
            balance.tangential_contact_work += contact.tangential_work;
        }
        balance.close();
        let energies = Energies {
            kinetic: half * dot(&next.v, &next.momentum[1]),
            elastic: half * dot(&next.q, &next.elastic_force[1]),
            potential: system.forces().potential(&next.q),
        };
        (energies, balance)
    }

    fn accept(&mut self, solution: Option<Solution<T>>, energies: Energies<T>, balance: Balance<T>) {
        let Self { state, next, last, .. } = self;
        std::mem::swap(&mut state.q, &mut next.q);
        std::mem::swap(&mut state.v, &mut next.v);
        next.momentum.swap(0, 1);
        next.elastic_force.swap(0, 1);
        std::mem::swap(&mut last.contacts, &mut next.contacts);
        (last.energies, last.balance, last.solution) = (energies, balance, solution);
        state.index += 1;
        // By multiplication, so that the clock does not drift over many steps.
        state.time = self.start_time + self.settings.step * lit::<T>(state.index as f64);
    }

    fn contact_error(&self, contact: ContactId, what: &'static str) -> StepError {
        let (step, time) = (self.state.index + 1, to_f64(self.state.time + self.settings.step));
        StepError::Contact { step, time, contact: self.system.contact_label(contact), what }
    }

    /// The candidate contacts with gap ≤ `reach` in the state reached.
    pub fn candidates(&mut self, reach: T) -> &[Candidate<T>] {
        self.candidates.clear();
        self.system.candidates(&self.state.q, reach, &mut self.candidates);
        &self.candidates
    }

    /// The state reached.
    pub fn state(&self) -> &State<T> {
        &self.state
    }

    /// The last step made; before the first, the energies of the initial state.
    pub fn last_step(&self) -> &Step<T, D> {
        &self.last
    }

    /// The system.
    pub fn system(&self) -> &S {
        &self.system
    }

    /// The laws, by interface.
    pub fn laws(&self) -> &[L] {
        &self.laws
    }

    /// The cone solver.
    pub fn solver(&self) -> &V {
        &self.solver
    }

    /// The settings.
    pub fn settings(&self) -> &Settings<T> {
        &self.settings
    }

    /// The cone problem of the last step tried.
    pub fn cone_problem(&self) -> &ConeProblem<T, D> {
        &self.problem
    }
}

fn check_settings<T: Scalar>(settings: &Settings<T>) -> Result<(), SetupError> {
    let Settings { theta, step, .. } = *settings;
    if !(T::zero() <= theta && theta <= T::one()) {
        return Err(SetupError::Theta { theta: to_f64(theta) });
    }
    if !(step > T::zero() && all_finite([&step])) {
        return Err(SetupError::TimeStep { step: to_f64(step) });
    }
    Ok(())
}

fn check_laws<T: Scalar, const D: usize, L: ContactLaw<T, D>>(
    laws: &[L],
    interfaces: usize,
    settings: &Settings<T>,
) -> Result<(), SetupError> {
    if laws.len() != interfaces {
        return Err(SetupError::Laws { interfaces, laws: laws.len() });
    }
    let theta = settings.theta;
    // θ and the ends of the interval are rounded: 1/(1+e) typed by hand must pass.
    let slack = lit::<T>(4.0) * epsilon::<T>();
    for (interface, law) in laws.iter().enumerate() {
        let name = || law.name().to_string();
        if let (Some(claimed), false) = (law.dissipative_theta(), settings.allow_unproved_theta) {
            let (min, max) = (*claimed.start(), *claimed.end());
            if !(min - slack <= theta && theta <= max + slack) {
                let (theta, min, max) = (to_f64(theta), to_f64(min), to_f64(max));
                return Err(SetupError::UnprovedTheta { law: name(), interface, theta, min, max });
            }
        }
        let gamma = law.evaluate(&SVector::zeros(), theta).gamma;
        let error = |what, value| SetupError::Law { law: name(), what, value, theta: to_f64(theta) };
        if !(gamma > T::zero() && all_finite([&gamma])) {
            return Err(error("γ", to_f64(gamma)));
        }
        let friction = law.friction();
        if !(friction >= T::zero() && all_finite([&friction])) {
            return Err(error("μ", to_f64(friction)));
        }
    }
    Ok(())
}

/// M̂ = M + hθC + h²θ²K.
fn iteration_matrix<T: Scalar, const D: usize, S: MechanicalSystem<T, D>>(
    system: &S,
    settings: &Settings<T>,
) -> Symmetric<T> {
    let weight = settings.step * settings.theta;
    let mut matrix = system.mass().clone();
    if let Some(damping) = system.damping() {
        matrix = matrix.plus(weight, damping);
    }
    if let Some(stiffness) = system.stiffness() {
        matrix = matrix.plus(weight * weight, stiffness);
    }
    matrix
}
