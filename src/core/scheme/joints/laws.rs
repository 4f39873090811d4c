//! What holds each row over a step: rows that are no rigid joints.
//!
//! A spring with a damper is a row with a compliance. With Δ = Ḡ s, stretch x and D = 1/(½ h k + c),
//!
//! ```text
//!   λ = −h k (x + ½ Δ) − c Δ     ⇔     Δ + D λ + D h k x = 0
//! ```
//!
//! so that S gains D/(hθ) on its diagonal and nothing else changes. A row that is given is none for S; its percussion joins
//! the equations of motion. A driven row with a bound is one or the other: its state is found within Newton's iteration, by
//! the signs that |λ| ≤ h·most ⟂ the motion relative to the rate wants, and what has the wrong sign is not converged.
//!
//! # Redundant rows
//!
//! Where joints hold the same thing twice, as a closed loop does, S is singular. Held rows then get a ridge r, a small share
//! of their diagonal entry, around the multipliers λ_i of the iterate,
//!
//! ```text
//!   (S + r) λ = … + r λ_i
//! ```
//!
//! the proximal method of multipliers: residuals are those of the rigid rows, the iteration gains a factor of that share, and
//! of the multipliers that rows could share in any way it takes those nearest to none.

use nalgebra::SVector;

use super::{Bilateral, ROUNDING, Span};
use crate::linalg::BlockRows;
use crate::scalar::{Scalar, epsilon, lit};
use crate::scheme::no_joints::joints_of;
use crate::system::{Dynamics, RowLaw};

/// Ridge of redundant rows, in their diagonal entry of S.
pub(super) const RIDGE: f64 = 1e-7;

/// What bounded rows that stick give way to percussions, in their diagonal entry of S: a percussion may make them slide, and a
/// contact must find something that moves. The passes hold them, and gain this factor each.
const GIVES: f64 = 1e-2;

/// Relative motion of a bounded row that slides at the start, in the largest velocity.
const SLIDES: f64 = 1e-9;

/// The laws of the rows over a step.
#[derive(Debug)]
pub(super) struct Laws<T> {
    /// Whether there is any but held rows.
    pub(super) any: bool,
    pub(super) rows: Vec<RowLaw<T>>,
    /// D/h, (m/s)/(N s).
    pub(super) compliance: Vec<T>,
    /// h·most of a bounded row (N s).
    pub(super) most: Vec<Option<T>>,
    /// Whether a row is one of S: not given, and not sliding.
    pub(super) active: Vec<bool>,
    /// Displacement against what the row asks for, without its compliance, as measured last.
    pub(super) moved: Vec<T>,
    /// Whether rows have turned out to be redundant.
    pub(super) redundant: bool,
}

impl<T: Scalar> Laws<T> {
    pub(super) fn new(any: bool, rows: usize) -> Self {
        Self {
            any,
            rows: vec![RowLaw::Held; rows],
            compliance: vec![T::zero(); rows],
            most: vec![None; rows],
            active: vec![true; rows],
            moved: vec![T::zero(); rows],
            redundant: false,
        }
    }

    fn is_held(&self, row: usize) -> bool {
        self.rows[row] == RowLaw::Held
    }

    /// What S gains on the diagonal of a row whose entry is `entry`, at θ, in Newton's iteration or in the response to
    /// percussions; and the share of it that is a ridge.
    pub(super) fn gain(&self, row: usize, entry: T, theta: T, percussions: bool) -> (T, T) {
        if percussions && self.most[row].is_some() {
            return (entry * lit::<T>(GIVES), T::zero());
        }
        let ridge = if self.redundant && self.is_held(row) { entry * lit::<T>(RIDGE) } else { T::zero() };
        (self.compliance[row] / theta + ridge, ridge)
    }

    /// What of a bounded row has the wrong sign, in what rounding allows; `size` is that of its displacement.
    pub(super) fn violation(&self, row: usize, multiplier: T, size: T) -> T {
        let Some(most) = self.most[row] else { return T::zero() };
        let rounding = lit::<T>(ROUNDING) * epsilon::<T>();
        let abs = |x: T| nalgebra::ComplexField::abs(x);
        if self.active[row] {
            let over = abs(multiplier) - most;
            return if over > T::zero() { over / (rounding * abs(multiplier)) } else { T::zero() };
        }
        let drives = multiplier * self.moved[row] > T::zero();
        if drives { abs(self.moved[row]) / (rounding * size) } else { T::zero() }
    }
}

impl<T: Scalar> Bilateral<T> {
    /// The laws of the step of length `step` from q at `time` with the velocity `v`, and the multipliers of rows that are given
    /// or slide.
    pub(super) fn set_laws(
        &mut self,
        system: &dyn Dynamics<T>,
        span: &Span<'_, T, impl Fn(usize) -> T>,
        v: &[T],
        time: T,
    ) {
        let (q, step) = (span.q, span.step);
        if !self.laws.any {
            return;
        }
        let joints = joints_of(system);
        self.end_rows.clear();
        // The speed at the start is that of the way on at this velocity: an angle that a motor turns steadily has it exactly.
        self.step.iter_mut().zip(v).for_each(|(s, &v)| *s = step * v);
        joints.jacobian(q, &self.step, &mut self.end_rows);
        let slides = lit::<T>(SLIDES) * crate::linalg::max_abs(v);
        let Self { laws, drift, accepted, end_rows, .. } = self;
        for (row, drift) in drift.iter_mut().enumerate() {
            let law = joints.law(row, q, time, step);
            laws.rows[row] = law;
            (laws.compliance[row], laws.most[row], laws.active[row]) = (T::zero(), None, true);
            match law {
                RowLaw::Held => {}
                RowLaw::Spring { stiffness, damping, stretch } => {
                    let pull = step * stiffness;
                    let compliance = T::one() / (pull * lit::<T>(0.5) + damping);
                    laws.compliance[row] = compliance / step;
                    *drift = compliance * pull * stretch;
                }
                RowLaw::Driven { rate, most } => {
                    let start = end_rows.velocity(row, v)[0];
                    let theta = (span.theta)(end_rows.row(row).next().map_or(0, |(dof, _)| dof));
                    *drift = -(step * law.way(start, theta).unwrap_or(rate));
                    laws.most[row] = most.map(|most| step * most);
                    if let Some(most) = laws.most[row] {
                        let by = start - rate;
                        laws.active[row] = !(nalgebra::ComplexField::abs(by) > slides);
                        if !laws.active[row] {
                            accepted.multipliers[row] = if by > T::zero() { -most } else { most };
                        }
                    }
                }
                RowLaw::Given { force } => {
                    *drift = T::zero();
                    laws.active[row] = false;
                    accepted.multipliers[row] = step * force;
                }
            }
        }
    }

    /// Gives bounded rows the state that the iterate measured last wants; whether one has changed.
    pub(super) fn switch(&mut self) -> bool {
        if !self.laws.any {
            return false;
        }
        let Self { laws, accepted, .. } = self;
        let mut changed = false;
        for row in 0..self.count {
            let Some(most) = laws.most[row] else { continue };
            let multiplier = &mut accepted.multipliers[row];
            if laws.active[row] && nalgebra::ComplexField::abs(*multiplier) > most {
                laws.active[row] = false;
                *multiplier = if *multiplier > T::zero() { most } else { -most };
                changed = true;
            } else if !laws.active[row] && *multiplier * laws.moved[row] > T::zero() {
                laws.active[row] = true;
                changed = true;
            }
        }
        changed
    }

    /// (change of the energy of springs, work of dampers and dry friction, work of motors) over the step made (J).
    pub(in crate::scheme) fn works(&self, step: T) -> [T; 3] {
        let mut works = [T::zero(); 3];
        if !self.laws.any {
            return works;
        }
        for (row, law) in self.laws.rows.iter().enumerate() {
            let by = self.rows.velocity(row, &self.step)[0];
            let work = self.accepted.multipliers[row] * by / step;
            match *law {
                RowLaw::Held => {}
                RowLaw::Spring { stiffness, damping, stretch } => {
                    works[0] += stiffness * by * (stretch + by * lit::<T>(0.5));
                    works[1] -= damping * by * by / step;
                }
                RowLaw::Driven { rate, .. } if rate == T::zero() => works[1] += work,
                RowLaw::Driven { .. } | RowLaw::Given { .. } => works[2] += work,
            }
        }
        works
    }

    /// Whether motors or dry friction act in any row.
    pub(in crate::scheme) fn drives(&self) -> bool {
        self.laws.any
    }

    /// out ← out + Ḡᵀ λ/h over the rows of motors and dry friction, of the step made (N, N m).
    pub(in crate::scheme) fn add_forces(&self, step: T, out: &mut [T]) {
        for (row, law) in self.laws.rows.iter().enumerate() {
            if matches!(law, RowLaw::Driven { .. } | RowLaw::Given { .. }) {
                let force = SVector::<T, 1>::new(self.accepted.multipliers[row] / step);
                self.rows.add_transpose(row, &force, out);
            }
        }
    }

    /// Takes the impulses of the rows on the degrees of freedom from `free` on out of `reaction`.
    pub(in crate::scheme) fn take_from(&self, free: usize, reaction: &mut [T]) {
        for row in 0..self.count {
            for (dof, entry) in self.rows.row(row).filter(|&(dof, _)| dof >= free) {
                reaction[dof - free] -= entry[0] * self.accepted.multipliers[row];
            }
        }
    }

    /// out ← out + Ḡᵀ λ over the rows whose percussion is given.
    pub(super) fn push_given(laws: &Laws<T>, rows: &BlockRows<T, 1>, multipliers: &[T], out: &mut [T]) {
        for (row, &multiplier) in multipliers.iter().enumerate().filter(|&(row, _)| !laws.active[row]) {
            rows.add_transpose(row, &SVector::<T, 1>::new(multiplier), out);
        }
    }
}
