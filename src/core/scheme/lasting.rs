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
//! of Frémond. The price is (½−θ)‖v_{k+1} − v_k‖²_M, zero at rest and of the order of h where bodies slide or roll.
//!
//! What moves as told is no part of any island: like the ground it connects nothing. It keeps the θ of the scene, by which its
//! displacements are defined. In a step over which its velocity is constant (a belt, a drum that turns evenly) v_{k+θ} is the same
//! for every θ, and so are u_{k+θ} of a contact with it, the work of what moves it and the balance. Contacts with what changes
//! its velocity in a step (a shaker) do not last in it, and are met by the rule of the active set as it stands. The
//! bodies on a belt take θ_rest only where they stick to it: what slides is carried to its speed at the price of the order of h.
//! Bodies that joints tie to what moves as told keep the θ of the scene. Without C
//! and K, M̂ = M for every θ, so that to change θ costs nothing. Systems with C or K, and nonlinear ones, keep the θ of the
//! scene and the rule of the active set as it stands: what is slow at a node of an elastic body, its waves decide.

use super::no_joints::joints_of;
use super::{ContactStep, Settings};
use crate::cone::ConeProblem;
use crate::contact::ContactId;
use crate::laws::ContactLaw;
use crate::linalg::forest::{join, root};
use crate::linalg::{BlockRows, Factor, Symmetric};
use crate::scalar::{Scalar, epsilon, lit, to_f64};
use crate::system::{Dynamics, Prescribed, RowLaw};

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
    /// Whether it slid in the last step on what moves as told, or is new there.
    slides: bool,
    /// What the contact has done since it began: works, its part of numerical dissipation and of position work (J); ≤ 0.
    pub(super) account: T,
}

/// What is kept of a contact from one step to the next.
#[derive(Debug, Clone, Copy)]
struct Last<T> {
    id: ContactId,
    account: T,
    slow: bool,
    sticks: bool,
}

/// Lasting contacts, and what their islands make of θ.
#[derive(Debug)]
pub(super) struct Lasting<T> {
    theta_rest: T,
    /// Whether the law of each interface is proved for lasting contacts at θ_rest.
    proved: Vec<bool>,
    /// M does not couple islands.
    separable: bool,
    /// Number of degrees of freedom that move under forces, the first ones.
    free: usize,
    /// Whether each of those that move as told has a constant velocity over the step.
    steady: Vec<bool>,
    /// Degrees of freedom that joints couple to what moves as told.
    tied: Vec<usize>,
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
    before: Vec<(ContactId, f64, bool, bool)>,
}

impl<T: Scalar> Last<T> {
    fn mark(&self) -> (ContactId, f64, bool, bool) {
        (self.id, to_f64(self.account), self.slow, self.sticks)
    }
}

impl<T: Scalar> Lasting<T> {
    /// `None` where the settings or the system know no lasting contacts.
    pub(super) fn new<const D: usize>(
        system: &dyn Dynamics<T>,
        laws: &[Box<dyn ContactLaw<T, D>>],
        settings: &Settings<T>,
        q: &[T],
    ) -> Option<Self> {
        let joints = joints_of(system);
        let springs =
            |row: usize| matches!(joints.law(row, q, T::zero(), settings.step), RowLaw::Spring { .. });
        let springs = !joints.all_held() && (0..joints.rows()).any(springs);
        let stiff = system.stiffness().is_some() || system.damping().is_some() || springs;
        let n = system.dofs();
        let free = system.prescribed().map_or(n, Prescribed::first);
        let separable = matches!(system.mass(), Symmetric::Diagonal(_));
        let coupled = free < n && !separable;
        if !settings.lasting || stiff || system.nonlinear().is_some() || coupled {
            return None;
        }
        let theta_rest = settings.theta_rest;
        let claims =
            |law: &dyn ContactLaw<T, D>| law.lasting_theta().is_some_and(|claim| claim.contains(&theta_rest));
        let mut rows = BlockRows::<T, 1>::new();
        joints.jacobian(q, &vec![T::zero(); n], &mut rows);
        let (mut joined, mut tied) = (Vec::new(), Vec::new());
        for row in 0..rows.rows() {
            let mut dofs = rows.row(row).map(|(dof, _)| dof).filter(|&dof| dof < free);
            let Some(first) = dofs.next() else { continue };
            joined.extend(dofs.map(|dof| (first, dof)));
            if rows.row(row).any(|(dof, _)| dof >= free) {
                tied.push(first);
            }
        }
        let unit = system.body_dofs().filter(|&unit| unit > 0 && n.is_multiple_of(unit));
        let (unit, mobility) = match system.mass() {
            // What moves as told is moved by no force.
            Symmetric::Diagonal(mass) => {
                let inverse = |(dof, &m): (usize, &T)| if dof < free { T::one() / m } else { T::zero() };
                (unit.unwrap_or(1), mass.iter().enumerate().map(inverse).collect())
            }
            _ => (1, vec![T::one(); n]),
        };
        Some(Self {
            unit,
            mobility,
            theta_rest,
            proved: laws.iter().map(|law| claims(&**law)).collect(),
            separable,
            free,
            steady: vec![true; n - free],
            tied,
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

    /// Forgets the contacts of the step before, whose list is made anew; `told` are the velocities at its two ends, and the
    /// configuration, of what moves as told.
    pub(super) fn clear(&mut self, [before, after, q]: [&[T]; 3], step: T, tolerance: T) {
        self.entries.clear();
        let abs = |x: T| nalgebra::ComplexField::abs(x);
        for (i, steady) in self.steady.iter_mut().enumerate() {
            // A velocity is a difference of positions over h, which rounding makes no smoother than that.
            let rounding = lit::<T>(LEFT) * epsilon::<T>() * abs(q[i]) / step;
            *steady = abs(after[i] - before[i]) <= nalgebra::RealField::max(tolerance, rounding);
        }
    }

    /// Whether what a contact touches moves under forces, stands, or has a constant velocity over the step: it may last.
    pub(super) fn may_last<const D: usize>(&self, rows: &BlockRows<T, D>, row: usize) -> bool {
        self.steady.is_empty()
            || rows.row(row).all(|(dof, _)| dof < self.free || self.steady[dof - self.free])
    }

    fn is_told<const D: usize>(&self, rows: &BlockRows<T, D>, row: usize) -> bool {
        !self.steady.is_empty() && rows.row(row).any(|(dof, _)| dof >= self.free)
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
        let slides = self.is_told(rows, row) && !self.last(id).is_some_and(|last| last.sticks);
        self.entries.push(Entry { gap, slow, joins, fall, slides, account });
    }

    /// Finds the islands and gives each its θ; `contacts` are the active ones, with H in `rows`.
    pub(super) fn assign<const D: usize>(
        &mut self,
        theta: T,
        rows: &BlockRows<T, D>,
        contacts: &mut [ContactStep<T, D>],
    ) {
        self.changed = false;
        // What θ > ½ takes in an impact pays for what the impact leaves, so that its island is asked for.
        let takes = theta > lit(0.5) && !self.entries.is_empty();
        if !(takes || self.entries.iter().any(|entry| entry.slow)) {
            return;
        }
        let Self { parent, impact, free, .. } = self;
        let free = *free;
        parent
            .iter_mut()
            .enumerate()
            .for_each(|(dof, parent)| *parent = if self.separable { dof } else { 0 });
        impact.fill(false);
        self.theta.fill(theta);
        for row in 0..contacts.len() {
            let mut dofs = rows.row(row).map(|(dof, _)| dof).filter(|&dof| dof < free);
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
        let island = |parent: &mut [usize], row: usize| {
            rows.row(row).find(|&(dof, _)| dof < free).map(|(dof, _)| root(parent, dof))
        };
        for (row, contact) in contacts.iter().enumerate() {
            let Some(island) = island(parent, row) else { continue };
            let Entry { slow, joins, slides, .. } = self.entries[row];
            impact[island] |= slides || !((slow || joins) && self.proved[contact.interface]);
        }
        for &dof in &self.tied {
            impact[root(parent, dof)] = true;
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
        let free = self.free;
        rows.row(row).find(|&(dof, _)| dof < free).map(|(dof, _)| root(&mut self.parent, dof))
    }

    /// θ of every degree of freedom, where it is not that of the scene everywhere.
    pub(super) fn theta(&self) -> Option<&[T]> {
        self.changed.then_some(self.theta.as_slice())
    }

    /// Notes what a solve to `tolerance` left.
    pub(super) fn note<const D: usize>(&mut self, problem: &ConeProblem<T, D>, tolerance: T) {
        self.left = lit::<T>(LEFT) * tolerance * problem.b_norm();
    }

    /// Keeps what the next step asks for; velocities to `tolerance` are none.
    pub(super) fn accept<const D: usize>(&mut self, contacts: &[ContactStep<T, D>], step: T, tolerance: T) {
        self.before.clear();
        self.reach = T::zero();
        for (contact, entry) in contacts.iter().zip(&self.entries) {
            // Sticking is u_{T,k+θ} = 0 under one law and u_{T,k+1} = 0 under another.
            let theta = contact.theta;
            let slips = (1..D).fold([T::zero(); 2], |[average, end], i| {
                let (before, after) = (contact.before[i], contact.after[i]);
                let between = (T::one() - theta) * before + theta * after;
                [average + between * between, end + after * after]
            });
            let least = nalgebra::RealField::min(slips[0], slips[1]);
            let (id, account, slow) = (contact.id, entry.account, entry.slow);
            self.before.push(Last { id, account, slow, sticks: least <= tolerance * tolerance });
            self.reach = nalgebra::RealField::max(self.reach, entry.fall * step);
        }
    }

    pub(super) fn mark(&self) -> LastingMark {
        LastingMark {
            reach: to_f64(self.reach),
            left: to_f64(self.left),
            pull: self.pull.iter().map(|&x| to_f64(x)).collect(),
            before: self.before.iter().map(|last| last.mark()).collect(),
        }
    }

    /// Goes to a mark, if it is one of a scene of this size.
    pub(super) fn restore(&mut self, mark: &LastingMark) -> Option<()> {
        if !(mark.pull.is_empty() || mark.pull.len() * self.unit == self.parent.len()) {
            return None;
        }
        (self.reach, self.left) = (lit(mark.reach), lit(mark.left));
        self.pull = mark.pull.iter().map(|&x| lit(x)).collect();
        let last = |&(id, account, slow, sticks)| Last { id, account: lit(account), slow, sticks };
        self.before = mark.before.iter().map(last).collect();
        self.before.sort_unstable_by_key(|last| last.id);
        Some(())
    }

    /// Whether √(F·M⁻¹F) is to be found in this step: it is known from the step before where the forces do not vary.
    pub(super) fn wants_pull(&self, vary: bool) -> bool {
        vary || self.pull.is_empty()
    }

    /// √(F·M⁻¹F) of the bodies, of the forces F that stand in `scratch`.
    pub(super) fn set_pull(&mut self, factor: &mut Factor<T>, scratch: &mut [T]) {
        let Self { pull, mobility, unit, free, .. } = self;
        factor.solve_in_place(&mut scratch[..*free]);
        scratch[*free..].fill(T::zero());
        pull.clear();
        let bodies = scratch.chunks(*unit).zip(mobility.chunks(*unit));
        pull.extend(bodies.map(|(accelerations, mobility)| {
            let both = accelerations.iter().zip(mobility).filter(|&(_, &w)| w > T::zero());
            nalgebra::ComplexField::sqrt(both.fold(T::zero(), |sum, (&a, &w)| sum + a * a / w))
        }));
    }
}
