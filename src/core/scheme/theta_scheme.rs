//! The scheme over a system: what it holds, how it is set up, what it shows.

use super::active_set::ActiveSet;
use super::arms::Arms;
use super::clock::Clock;
use super::cones::{Cones, WarmStart};
use super::equations::Equations;
use super::flight::Flight;
use super::joints::Bilateral;
use super::lasting::Lasting;
use super::matrix::Matrix;
use super::memory::Memories;
use super::no_joints::joints_of;
use super::nonlinear::Nonlinear;
use super::record::Next;
use super::rest::Rest;
use super::setup::{check_joints, check_laws, check_settings, check_sizes, tolerances};
use super::{Settings, SetupError, State, Step};
use crate::cone::ConeProblem;
use crate::contact::{Candidate, ContactId};
use crate::energy::{Balance, Energies};
use crate::laws::{ContactLaw, Rows};
use crate::linalg::{Factor, dot};
use crate::scalar::{Scalar, all_finite, lit, to_f64};
use crate::solver::ConeSolver;
use crate::system::System;

/// The Moreau–Jean θ-scheme over a system, one law per interface, and a cone solver.
///
/// D = 1 without friction, 2 in the plane, 3 in space, and with rolling resistance 3 in the plane and 6 in space: where D = 3
/// and a law [rolls](ContactLaw::rows), the third row of every contact is a rotation, and its percussion a moment.
///
/// A warm step allocates nothing. A step that fails leaves the state as it was.
#[derive(Debug)]
pub struct ThetaScheme<T: Scalar, const D: usize> {
    pub(super) system: Box<dyn System<T, D>>,
    pub(super) laws: Vec<Box<dyn ContactLaw<T, D>>>,
    pub(super) solver: Box<dyn ConeSolver<T, D>>,
    pub(super) settings: Settings<T>,
    pub(super) matrix: Matrix<T, D>,
    pub(super) active: ActiveSet<T, D>,
    pub(super) cones: Cones<T, D>,
    pub(super) warm: WarmStart<T, D>,
    pub(super) equations: Equations<T>,
    pub(super) flight: Option<Flight<T>>,
    pub(super) lasting: Option<Lasting<T>>,
    pub(super) rest: Option<Rest<T, D>>,
    pub(super) memories: Memories<T>,
    pub(super) clock: Clock<T>,
    pub(super) state: State<T>,
    pub(super) last: Step<T, D>,
    pub(super) next: Next<T, D>,
}

impl<T: Scalar, const D: usize> ThetaScheme<T, D> {
    /// Sets the scheme up at time `start_time` in the state (q, v); `laws[i]` governs interface i.
    ///
    /// # Errors
    /// [`SetupError`]: θ outside [0, 1] or outside the interval claimed by a law, h ≤ 0, wrong sizes, a state
    /// that is not finite, M or M̂ not positive definite.
    pub fn new(
        system: Box<dyn System<T, D>>,
        laws: Vec<Box<dyn ContactLaw<T, D>>>,
        solver: Box<dyn ConeSolver<T, D>>,
        settings: Settings<T>,
        start_time: T,
        q: Vec<T>,
        v: Vec<T>,
    ) -> Result<Self, SetupError> {
        solver.stopping().check()?;
        check_settings(&settings)?;
        check_laws(&laws, system.interfaces(), &settings)?;
        check_sizes(&*system, &q, &v)?;
        let scales = system.scales(&q, &v);
        check_joints(&*system, &settings, &q, scales.length)?;
        let (mut q, mut v, mut system) = (q, v, system);
        let free = system.prescribed().map_or(system.dofs(), |prescribed| prescribed.first());
        // What moves as told may have no mass.
        Factor::new(&system.mass().leading(free)).map_err(SetupError::Mass)?;
        if let Some(prescribed) = system.prescribed() {
            prescribed.set(start_time, settings.step, settings.theta, &mut q, &mut v);
        }
        let matrix = Matrix::new(&mut *system, &settings, &q)?;
        let nonlinear = system.nonlinear().map(|dynamics| Box::new(Nonlinear::new(dynamics, &q)));

        let n = system.dofs();
        let mut next = Next::new(q.len(), n, n - matrix.free);
        system.mass().multiply(&v, &mut next.momentum[0]);
        if let Some(stiffness) = system.stiffness() {
            stiffness.multiply(&q, &mut next.elastic_force[0]);
        }
        let (kinetic, elastic) = nonlinear.as_ref().map_or_else(
            || (dot(&v, &next.momentum[0]) * lit::<T>(0.5), dot(&q, &next.elastic_force[0]) * lit::<T>(0.5)),
            |nonlinear| nonlinear.energies(&v),
        );
        let elastic = elastic + joints_of(&*system).energy(&q);
        let energies = Energies { kinetic, elastic, potential: system.potential(&q) };
        if !all_finite(&[energies.total()]) {
            let (kinetic, elastic) = (to_f64(energies.kinetic), to_f64(energies.elastic));
            return Err(SetupError::Energy { kinetic, elastic });
        }
        let tolerances = tolerances(&settings.activation, solver.stopping().tolerance, &*system, &q, &v)?;
        let rest = settings.sleep.then(|| Rest::new(&*system, settings.step, solver.stopping().tolerance));
        let rest = rest.flatten();
        let lasting = Lasting::new(&*system, &laws, &settings, &q);
        let memories = Memories::new(&laws);
        let rolls = D > 2 && laws.iter().any(|law| law.rows() == Rows::Rolling);
        let arms = Arms::new(rolls || D == 6, system.mass());
        let joints = Bilateral::new(&*system, &q, settings.joint_tolerance);
        Ok(Self {
            active: ActiveSet::new(q.len(), n, tolerances),
            cones: Cones::new(n, matrix.free, arms),
            warm: WarmStart::new(settings.step),
            equations: Equations { joints, nonlinear, passes: 0, left_over: T::zero(), scales },
            flight: Flight::new(&*system, settings.theta),
            system,
            laws,
            solver,
            settings,
            matrix,
            lasting,
            rest,
            memories,
            clock: Clock::starting(start_time),
            state: State { index: 0, time: start_time, q, v },
            last: Step { contacts: Vec::new(), energies, balance: Balance::default(), solution: None },
            next,
        })
    }

    /// The candidate contacts with gap ≤ `reach` in the state reached.
    pub fn candidates(&mut self, reach: T) -> &[Candidate<T>] {
        self.active.candidates.clear();
        self.system.candidates(&self.state.q, reach, &mut self.active.candidates);
        &self.active.candidates
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
    pub fn system(&self) -> &dyn System<T, D> {
        &*self.system
    }

    /// The laws, by interface.
    pub fn laws(&self) -> &[Box<dyn ContactLaw<T, D>>] {
        &self.laws
    }

    /// The cone solver.
    pub fn solver(&self) -> &dyn ConeSolver<T, D> {
        &*self.solver
    }

    /// The components of the contacts.
    pub fn rows(&self) -> Rows {
        match D {
            1 => Rows::Normal,
            _ if self.cones.arms.rolls() => Rows::Rolling,
            _ => Rows::Tangent,
        }
    }

    /// The settings.
    pub fn settings(&self) -> &Settings<T> {
        &self.settings
    }

    /// Passes the last step took over its equations: 1 where nothing but the contacts is unknown, more with joints and
    /// nonlinear terms.
    pub fn passes(&self) -> usize {
        self.equations.passes + 1
    }

    /// What the law of interface `interface` remembers of a contact.
    ///
    /// # Panics
    /// If there is no such interface.
    pub fn memory(&self, contact: ContactId, interface: usize) -> &[T] {
        self.memories.of(contact, interface)
    }

    /// The cone problem of the last step tried.
    pub fn cone_problem(&self) -> &ConeProblem<T, D> {
        &self.cones.problem
    }
}
