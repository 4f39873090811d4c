//! The state, what a step did, and the step being made.

use nalgebra::SVector;

use crate::contact::ContactId;
use crate::energy::{Balance, Energies};
use crate::scalar::Scalar;
use crate::solver::Solution;

/// The state at a time of the run.
#[derive(Debug, Clone, PartialEq)]
pub struct State<T> {
    /// Steps made, k.
    pub index: usize,
    /// Time t_k (s): t₀ + k h where the steps are equal, their compensated sum where they are not.
    pub time: T,
    /// Configuration q_k.
    pub q: Vec<T>,
    /// Velocity v_k.
    pub v: Vec<T>,
}

/// What happened at an active contact during a step.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    /// How far either work can be positive for the tolerance of the cone solver and rounding alone (J): the tolerance times
    /// ‖b‖ on the percussion, and that over λ_max(W_αα) on the velocities. 0 where neither is positive.
    pub work_bound: T,
    /// θ of the contact's island in the step.
    pub theta: T,
    /// The contact [lasts](crate::laws::Approach::lasting): the law took it for no impact.
    pub lasting: bool,
}

impl<T: Scalar, const D: usize> ContactStep<T, D> {
    /// A contact that enters a step.
    pub(super) fn starting(
        id: ContactId,
        interface: usize,
        (gap, before): (T, SVector<T, D>),
        (theta, lasting): (T, bool),
    ) -> Self {
        let (zero, none) = (SVector::zeros(), T::zero());
        Self {
            id,
            interface,
            gap,
            before,
            after: zero,
            percussion: zero,
            normal_work: none,
            tangential_work: none,
            work_bound: none,
            theta,
            lasting,
        }
    }

    /// Whether the [normal, tangential] work is positive beyond its [bound](Self::work_bound): the law created energy there.
    pub fn creates_energy(&self) -> [bool; 2] {
        [self.normal_work > self.work_bound, self.tangential_work > self.work_bound]
    }

    /// A contact that did no more than carry `percussion`.
    pub(super) fn resting(id: ContactId, interface: usize, gap: T, percussion: SVector<T, D>) -> Self {
        Self { percussion, ..Self::starting(id, interface, (gap, SVector::zeros()), (T::one(), true)) }
    }
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

impl<T: Scalar, const D: usize> Step<T, D> {
    /// The largest [normal, tangential] contact work of one contact (J); 0 without contact.
    pub fn largest_works(&self) -> [T; 2] {
        let larger = nalgebra::RealField::max;
        let mut works = self.contacts.iter().map(|contact| [contact.normal_work, contact.tangential_work]);
        let first = works.next().unwrap_or([T::zero(); 2]);
        works.fold(first, |[a, b], [c, d]| [larger(a, c), larger(b, d)])
    }
}

/// The parts of a step, in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Forces, and the solve for the free velocity (with constant H its first stage).
    FreeVelocity,
    /// Gaps, local velocities, active set.
    ActiveSet,
    /// W, b and μ.
    ConeProblem,
    /// The cone solver.
    ConeSolution,
    /// The solve for what the percussions change (with constant H the second stage), and the next state.
    NextState,
    /// The products M v and K q, energies and balance; the next step uses these products again.
    Ledger,
}

/// The step being made; it becomes the state only when all of it succeeded.
#[derive(Debug)]
pub(super) struct Next<T: Scalar, const D: usize> {
    pub(super) q: Vec<T>,
    /// A configuration on the way.
    pub(super) place: Vec<T>,
    pub(super) v: Vec<T>,
    pub(super) v_theta: Vec<T>,
    pub(super) v_free: Vec<T>,
    pub(super) force: Vec<T>,
    pub(super) scratch: Vec<T>,
    /// Hᵀ p.
    pub(super) impulse: Vec<T>,
    /// M v and K q of the state, and of its successor.
    pub(super) momentum: [Vec<T>; 2],
    pub(super) elastic_force: [Vec<T>; 2],
    /// Impulses that move the prescribed degrees of freedom.
    pub(super) reaction: Vec<T>,
    pub(super) contacts: Vec<ContactStep<T, D>>,
}

impl<T: Scalar, const D: usize> Next<T, D> {
    pub(super) fn new(coordinates: usize, dofs: usize, prescribed: usize) -> Self {
        let zeros = || vec![T::zero(); dofs];
        Self {
            q: vec![T::zero(); coordinates],
            place: vec![T::zero(); coordinates],
            v: zeros(),
            v_theta: zeros(),
            v_free: zeros(),
            force: zeros(),
            scratch: zeros(),
            impulse: zeros(),
            momentum: [zeros(), zeros()],
            elastic_force: [zeros(), zeros()],
            reaction: vec![T::zero(); prescribed],
            contacts: Vec::new(),
        }
    }
}
