//! Contacts that last, and the θ of islands at rest.
//!
//! # Lasting contacts
//!
//! A contact *lasts* from where it carried a percussion in the last step and is slow: |u_{N,k}| ≤ 2 s, with the speed
//! s = h Σ √(H_N M⁻¹ H_Nᵀ) √(F·M⁻¹F), summed over its bodies, that their forces make of rest in one step (g h at a disc on
//! the ground, and at one on a wall). One that is slow and new joins where its island is at rest: what bounces lower than a
//! step can resolve does not wake a pile. One that is slow and overlaps by more than a slow impact can lasts too.
//!
//! Such a contact is no impact, and neither is a closed one that separates, u_{N,k} > 0, at any speed. Its law answers with
//! the restitution e* = (1−θ)/θ in place of e ([`Response::lasting`](crate::laws::Response::lasting)): with
//! w = u_{k+1} + (e* u_{N,k} + c/θ, e_T u_{T,k}), c ≥ 0,
//!
//! ```text
//!   u_{k+θ}·p = θ [ −μ‖w_T‖ p_N − (c/θ) p_N + (e* − e_T) u_{T,k}·p_T ]
//! ```
//!
//! the normal part of which is never positive, whatever θ, u_{N,k} and the active set are; with e_T = e* (Frémond, Moreau;
//! Newton where θ = 1) neither is the rest. It also stays in the active set through rounding, while its predicted gap is
//! below h s: to drop a contact that carries a body because u_N = +1e-13 lets the body fall for a step. So with lasting
//! contacts the active set is that of predicted gaps, under rule (55) too: what (55) adds to it, that a contact which
//! separates is no impact, the law is told. A single contact that separates takes no percussion, so that nothing changes
//! where contacts are alone.
//!
//! # θ of an island
//!
//! Bodies that no active contact and no joint couples in a step are independent systems in that step: the balance (56) and
//! Proposition 1 hold for each with a θ of its own, and the ledger adds them. An island with an impact in it takes the θ of
//! the scene; one all of whose contacts last takes θ_rest. At θ_rest = 1, the default, e* = 0: what sticks stands still in
//! place of alternating ±u_T, what is open within h s closes in one step, and the law of Newton is as dissipative as that
//! of Frémond. The price is (½−θ)‖v_{k+1} − v_k‖²_M, zero at rest and of the order of h where bodies slide or roll. Without C
//! and K, M̂ = M for every θ, so that to change θ costs nothing. Systems with C or K, and nonlinear ones, keep the θ of the
//! scene and the rule of the active set as it stands: what is slow at a node of an elastic body, its waves decide.

use super::no_joints::joints_of;
use super::{ContactStep, Settings};
use crate::cone::ConeProblem;
use crate::contact::ContactId;
use crate::laws::ContactLaw;
use crate::linalg::forest::{join, root};
use crate::linalg::{BlockRows, Factor, Symmetric};
use crate::scalar::{Scalar, lit, to_f64};
use crate::system::Dynamics;

/// Speed of a lasting contact, in those the forces make of rest in one step.
const SLOW: f64 = 2.0;

/// What solvers leave, in their tolerance times ‖b‖: its norm is over all contacts, their errors add up over a few steps.
const LEFT: f64 = 10.0;

/// How a contact enters a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pace {
    /// Not slow, or open.
    Fast,
    /// Slow, and new: an impact, unless its island is at rest.
    Joining,
    /// Slow, and it has carried or lasted before, or overlaps by more than a slow impact can.
    Lasting,
}

/// What is known of an active contact, beside what the step reports.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry<T> {
    /// Gap at the start of the step (m), of a contact that is slow.
    pub(super) gap: T,
    /// Whether it lasts because it is slow, and not because it separates.
    pub(super) slow: bool,
    /// Whether it does where the others of its island last.
    pub(super) joins: bool,
    /// What the forces make of rest in one step (m/s).
    pub(super) fall: T,
    /// What the contact has done since it began: works, its part of numerical dissipation and of position work (J); ≤ 0.
    pub(super) account: T,
}

/// What is kept of a contact from one step to the next.
#[derive(Debug, Clone, Copy)]
struct Last<T> {
    id: ContactId,
    account: T,
    slow: bool,
}

/// Lasting contacts, and what their islands make of θ.
#[derive(Debug)]
pub(super) struct Lasting<T> {
    theta_rest: T,
    /// Whether the law of each interface is proved for lasting contacts at θ_rest.
    proved: Vec<bool>,
    /// M does not couple islands.
    separable: bool,
    /// Degrees of freedom of a body, and their 1/M_jj; where there are no bodies, or M is no diagonal, each degree of freedom
    /// counts for itself.
    unit: usize,
    mobility: Vec<T>,
    /// √(F·M⁻¹F) of every body; empty before the first step.
    pull: Vec<T>,
    /// Degrees of freedom that joints couple.
    joined: Vec<(usize, usize)>,
    /// Of the active contacts, in their order.
    pub(super) entries: Vec<Entry<T>>,
    /// The contacts of the last step, ordered by identity.
    before: Vec<Last<T>>,
    /// Largest predicted gap at which a contact of the last step still lasts (m).
    reach: T,
    /// What the last solve left of velocities (m/s).
    left: T,
    /// Whether θ differs from that of the scene anywhere in this step, and θ of every degree of freedom then.
    pub(super) changed: bool,
    pub(super) theta: Vec<T>,
    /// A degree of freedom of the same island, itself for the one that stands for it; whether that island has an impact,
    /// and its sums.
    pub(super) parent: Vec<usize>,
    impact: Vec<bool>,
    pub(super) sums: Vec<[T; 4]>,
    pub(super) target: Vec<T>,
    pub(super) opening: Vec<T>,
}

/// [`Lasting`] as plain numbers.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "outputs", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct LastingMark {
    reach: f64,
    left: f64,
    pull: Vec<f64>,
    before: Vec<(ContactId, f64, bool)>,
}

impl<T: Scalar> Lasting<T> {
    /// `None` where the settings or the system know no lasting contacts.
    pub(super) fn new<const D: usize>(
        system: &dyn Dynamics<T>,
        laws: &[Box<dyn ContactLaw<T, D>>],
        settings: &Settings<T>,
        q: &[T],
    ) -> Option<Self> {
        let rigid = joints_of(system).all_held();
        let stiff = system.stiffness().is_some() || system.damping().is_some() || !rigid;
        if !settings.lasting || stiff || system.nonlinear().is_some() || system.prescribed().is_some() {
            return None;
        }
        let theta_rest = settings.theta_rest;
        let claims =
            |law: &dyn ContactLaw<T, D>| law.lasting_theta().is_some_and(|claim| claim.contains(&theta_rest));
        let n = system.dofs();
        let mut joints = BlockRows::<T, 1>::new();
        joints_of(system).jacobian(q, &vec![T::zero(); n], &mut joints);
        let mut joined = Vec::new();
        for row in 0..joints.rows() {
            let mut dofs = joints.row(row).map(|(dof, _)| dof);
            if let Some(first) = dofs.next() {
                joined.extend(dofs.map(|dof| (first, dof)));
            }
        }
        let unit = system.body_dofs().filter(|&unit| unit > 0 && n.is_multiple_of(unit));
        let (unit, mobility) = match system.mass() {
            Symmetric::Diagonal(mass) => (unit.unwrap_or(1), mass.iter().map(|&m| T::one() / m).collect()),
            _ => (1, vec![T::one(); n]),
        };
        Some(Self {
            unit,
            mobility,
            theta_rest,
            proved: laws.iter().map(|law| claims(&**law)).collect(),
            separable: matches!(system.mass(), Symmetric::Diagonal(_)),
            pull: Vec::new(),
            joined,
            entries: Vec::new(),
            before: Vec::new(),
            reach: T::zero(),
            left: T::zero(),
            changed: false,
            theta: vec![settings.theta; n],
            parent: vec![0; n],
            impact: vec![false; n],
            sums: vec![[T::zero(); 4]; n],
            target: Vec::new(),
            opening: Vec::new(),
        })
    }

    /// The gap that solves leave in a step of length h.
    pub(super) fn noise(&self, step: T) -> T {
        self.left * step
    }

    /// The largest gap at which a contact that lasts may be found.
    pub(super) fn reach(&self) -> T {
        self.reach
    }

    /// Forgets the contacts of the step before, whose list is made anew.
    pub(super) fn clear(&mut self) {
        self.entries.clear();
    }

    /// The pace of a contact with predicted gap and normal velocity `(gap, rate)`; `carried` where it had a percussion in
    /// the last step.
    pub(super) fn pace<const D: usize>(
        &self,
        (rows, row): (&BlockRows<T, D>, usize),
        step: T,
        (id, carried): (ContactId, bool),
        (gap, rate): (T, T),
        (gap_tolerance, velocity_tolerance): (T, T),
    ) -> Pace {
        let fall = self.fall(rows, row, step);
        let most = lit::<T>(SLOW) * fall + velocity_tolerance;
        if !(nalgebra::ComplexField::abs(rate) <= most) {
            return Pace::Fast;
        }
        let lasted = || self.last(id).is_some_and(|last| last.slow);
        if gap <= gap_tolerance + step * fall && (carried || lasted()) || gap < -(step * most + gap_tolerance)
        {
            return Pace::Lasting;
        }
        if gap <= gap_tolerance { Pace::Joining } else { Pace::Fast }
    }

    fn last(&self, id: ContactId) -> Option<&Last<T>> {
        self.before.binary_search_by_key(&id, |last| last.id).ok().map(|place| &self.before[place])
    }

    /// What the forces make of rest in one step at a contact, whatever the direction of its normal: Σ over the bodies of
    /// h √(H_N M⁻¹ H_Nᵀ) √(F·M⁻¹F).
    fn fall<const D: usize>(&self, rows: &BlockRows<T, D>, row: usize, step: T) -> T {
        let sqrt = nalgebra::ComplexField::sqrt;
        let pull = |body: usize| self.pull.get(body).copied().unwrap_or_else(T::zero);
        let (mut sum, mut last, mut mobility) = (T::zero(), None, T::zero());
        for (dof, h) in rows.row(row) {
            let body = dof / self.unit;
            if let Some(other) = last.replace(body).filter(|&other| other != body) {
                sum += sqrt(mobility) * pull(other);
                mobility = T::zero();
            }
            mobility += h[0] * h[0] * self.mobility[dof];
        }
        step * (sum + last.map_or_else(T::zero, |body| sqrt(mobility) * pull(body)))
    }

    pub(super) fn push<const D: usize>(
        &mut self,
        rows: &BlockRows<T, D>,
        row: usize,
        step: T,
        (id, gap): (ContactId, T),
        pace: Pace,
    ) {
        let account = self.last(id).map_or_else(T::zero, |last| last.account);
        let fall = self.fall(rows, row, step);
        let (slow, joins) = (pace == Pace::Lasting, pace == Pace::Joining);
        self.entries.push(Entry { gap, slow, joins, fall, account });
    }

    /// Finds the islands and gives each its θ; `contacts` are the active ones, with H in `rows`.
    pub(super) fn assign<const D: usize>(
        &mut self,
        theta: T,
        rows: &BlockRows<T, D>,
        contacts: &mut [ContactStep<T, D>],
    ) {
        self.changed = false;
        if !self.entries.iter().any(|entry| entry.slow) {
            return;
        }
        let Self { parent, impact, .. } = self;
        parent
            .iter_mut()
            .enumerate()
            .for_each(|(dof, parent)| *parent = if self.separable { dof } else { 0 });
        impact.fill(false);
        self.theta.fill(theta);
        for row in 0..contacts.len() {
            let mut dofs = rows.row(row).map(|(dof, _)| dof);
            if let Some(first) = dofs.next() {
                dofs.for_each(|dof| {
                    join(parent, first, dof);
                });
            }
        }
        self.joined.iter().for_each(|&(one, other)| {
            join(parent, one, other);
        });
        if self.theta_rest == theta {
            return;
        }
        let island =
            |parent: &mut [usize], row: usize| rows.row(row).next().map(|(dof, _)| root(parent, dof));
        for (row, contact) in contacts.iter().enumerate() {
            let Some(island) = island(parent, row) else { continue };
            let Entry { slow, joins, .. } = self.entries[row];
            impact[island] |= !((slow || joins) && self.proved[contact.interface]);
        }
        for row in 0..contacts.len() {
            let Some(island) = island(parent, row) else { continue };
            if self.entries[row].slow && !impact[island] {
                self.theta[island] = self.theta_rest;
                self.changed = true;
            }
        }
        if !self.changed {
            return;
        }
        for (row, contact) in contacts.iter_mut().enumerate() {
            let Some(island) = island(parent, row) else { continue };
            contact.theta = self.theta[island];
            let rests = !impact[island] && contact.theta == self.theta_rest;
            self.entries[row].slow |= rests;
            contact.lasting |= rests;
        }
        for dof in 0..parent.len() {
            self.theta[dof] = self.theta[root(parent, dof)];
        }
    }

    /// The degree of freedom that stands for the island of a contact.
    pub(super) fn island<const D: usize>(&mut self, rows: &BlockRows<T, D>, row: usize) -> Option<usize> {
        rows.row(row).next().map(|(dof, _)| root(&mut self.parent, dof))
    }

    /// θ of every degree of freedom, where it is not that of the scene everywhere.
    pub(super) fn theta(&self) -> Option<&[T]> {
        self.changed.then_some(self.theta.as_slice())
    }

    /// Notes what a solve to `tolerance` left.
    pub(super) fn note<const D: usize>(&mut self, problem: &ConeProblem<T, D>, tolerance: T) {
        self.left = lit::<T>(LEFT) * tolerance * problem.b_norm();
    }

    /// Keeps what the next step asks for.
    pub(super) fn accept<const D: usize>(&mut self, contacts: &[ContactStep<T, D>], step: T) {
        self.before.clear();
        self.reach = T::zero();
        for (contact, entry) in contacts.iter().zip(&self.entries) {
            self.before.push(Last { id: contact.id, account: entry.account, slow: entry.slow });
            self.reach = nalgebra::RealField::max(self.reach, entry.fall * step);
        }
    }

    pub(super) fn mark(&self) -> LastingMark {
        LastingMark {
            reach: to_f64(self.reach),
            left: to_f64(self.left),
            pull: self.pull.iter().map(|&x| to_f64(x)).collect(),
            before: self.before.iter().map(|last| (last.id, to_f64(last.account), last.slow)).collect(),
        }
    }

    /// Goes to a mark, if it is one of a scene of this size.
    pub(super) fn restore(&mut self, mark: &LastingMark) -> Option<()> {
        if !(mark.pull.is_empty() || mark.pull.len() * self.unit == self.parent.len()) {
            return None;
        }
        (self.reach, self.left) = (lit(mark.reach), lit(mark.left));
        self.pull = mark.pull.iter().map(|&x| lit(x)).collect();
        let last = |&(id, account, slow)| Last { id, account: lit(account), slow };
        self.before = mark.before.iter().map(last).collect();
        self.before.sort_unstable_by_key(|last| last.id);
        Some(())
    }

    /// √(F·M⁻¹F) of the bodies, of the forces F in the step that is being made; they are known from the step before where
    /// they do not vary.
    pub(super) fn set_pull(&mut self, vary: bool, force: &[T], factor: &mut Factor<T>, scratch: &mut [T]) {
        let Self { pull, mobility, unit, .. } = self;
        if !pull.is_empty() && !vary {
            return;
        }
        scratch.copy_from_slice(force);
        factor.solve_in_place(scratch);
        pull.clear();
        let bodies = scratch.chunks(*unit).zip(mobility.chunks(*unit));
        pull.extend(bodies.map(|(accelerations, mobility)| {
            let sum = accelerations.iter().zip(mobility).fold(T::zero(), |sum, (&a, &w)| sum + a * a / w);
            nalgebra::ComplexField::sqrt(sum)
        }));
    }
}
