//! Joints: bilateral rows of the cone problem, eliminated exactly.
//!
//! With joints the problem of a step is (81) with more rows, those of Ḡ, on which the cone is the whole line:
//!
//! ```text
//!   M̂ (v_{k+1} − v_free) = Hᵀ p + Ḡᵀ λ,   K* ∋ Φ(w) ⟂ p ∈ K,   {0} ∋ Ḡ v_{k+θ} ⟂ λ ∈ ℝ
//! ```
//!
//! The dual of the whole line is {0}. Ḡ is the discrete derivative of φ over the step s = h v_{k+θ}, so that Ḡ s = 0 says
//! φ(q_k + s) = φ(q_k), and joints do no work in the balance (56), whatever θ and λ, as Frémond's law would have it. What
//! is asked for is φ(q_k + s) = φ(q_0): the same but for what rounding has left of earlier steps, which does not add up.
//!
//! # Passes
//!
//! Ḡ depends on the end of the step. Newton's method on (v, λ) at an iterate (v_i, λ_i) with percussions p_i reads
//!
//! ```text
//!   K̂ (v − v_i) = Hᵀ p + Ḡᵀ λ − M̂ (v_i − v_free),     K̂ = M̂ − hθ ∂(Ḡᵀλ_i)/∂s
//!   hθ G₁ (v − v_i) = φ(q_0) − φ(q_k + s_i)
//! ```
//!
//! with the rows Ḡ = Ḡ(q_k, s_i) that percussions act by and the derivative G₁ = ∂φ(q_k + s_i). Eliminating λ at p = p_i,
//! by S = G₁ K̂⁻¹ Ḡᵀ, is Newton's step for percussions that stay; their change acts by the symmetric operator
//!
//! ```text
//!   P = K̂⁻¹ − K̂⁻¹ Ḡᵀ (Ḡ K̂⁻¹ Ḡᵀ)⁻¹ Ḡ K̂⁻¹
//! ```
//!
//! so that W = H P Hᵀ is symmetric and positive semidefinite for any solver, the law holds exactly at the velocities of
//! every pass, and the passes converge quadratically without contacts, and with them by a factor of the turn per step. A
//! pass that leaves more than the one before is drawn back towards it.
//!
//! The passes end where the joints are closed to their tolerance and the equations of motion hold to a like one. By
//! default the tolerance is 64 ε of the largest coordinate: positions are sums of a few products of such numbers, so that
//! less cannot be asked for, and Newton's method reaches it a pass after any looser one.

mod iteration;
mod laws;
mod schur;
mod span;

use crate::scheme::no_joints::joints_of;
use nalgebra::SVector;

use iteration::Method;
use laws::Laws;
use schur::{Schur, solve};
use span::Iterate;
pub(super) use span::Span;

use super::delassus::Assembler;
use crate::linalg::{BlockRows, Factor, axpy, max_abs};
use crate::scalar::{Scalar, epsilon, lit};
use crate::solver::Anderson;
use crate::system::{Dynamics, RowLaw};

pub(super) const ROUNDING: f64 = 64.0;

/// The least tolerance of joints, in ε of the largest coordinate.
pub(super) const LEAST_ROUNDING: f64 = 8.0;

/// Most times that percussions are drawn back halfway to those of the last pass.
const RETREATS: usize = 6;

/// Excess over the tolerances that rounding may leave where masses differ much: once an iteration gains nothing more, this is
/// enough.
pub(super) const STAGNATION: f64 = 64.0;

/// Passes that their acceleration remembers.
const MEMORY: usize = 6;

/// What is left of the equations of a step with joints.
#[derive(Debug, Clone, Copy)]
pub(super) struct LeftOver<T> {
    /// max |φ(q_{k+1}) − φ(q_0)| (m or rad), what is allowed, and the row.
    pub(super) opening: T,
    pub(super) tolerance: T,
    pub(super) row: usize,
    /// The larger of the opening and the residual of the equations of motion, in what is allowed of each.
    pub(super) excess: T,
    /// Whether that is no more than the rounding of positions, and of the equations of motion: enough where nothing is gained
    /// any more. The opening allowed is that of the motion of the step, which may be far less.
    pub(super) is_rounding: bool,
    /// Both in energy, ‖ρ‖²_M + Σ (opening/h)² / (Ḡ M̂⁻¹ Ḡᵀ)_ii.
    merit: T,
}

/// Ḡ, G₁, the factors of a pass and its iterates; without rows, nothing.
#[derive(Debug)]
pub(super) struct Bilateral<T: Scalar> {
    count: usize,
    laws: Laws<T>,
    /// φ(q_0), and the opening allowed where one is given.
    closed: Vec<T>,
    /// What is to be taken back of φ(q_k) − φ(q_0), and Ḡ v_{k+θ} with it.
    drift: Vec<T>,
    opening: Vec<T>,
    tolerance: Option<T>,
    allowed: T,
    /// Ḡ and G₁.
    rows: BlockRows<T, 1>,
    end_rows: BlockRows<T, 1>,
    assembler: Assembler<T, 1>,
    tangent: Schur<T>,
    symmetric: Schur<T>,
    /// Diagonal K̂⁻¹ and K̂⁻¹ M̂.
    inverse: Vec<T>,
    ratio: Vec<T>,
    trial: Iterate<T>,
    accepted: Iterate<T>,
    /// Where the joints were met last in this step.
    last_good: Iterate<T>,
    has_good: bool,
    /// Whether P of this step is factored: contacts alone need it.
    factored: bool,
    left_over: LeftOver<T>,
    /// Fixed point of the impulses Hᵀp.
    percussions: Anderson<T, T>,
    /// Newton's method as a fixed point of (v, λ), and two of its iterates.
    iterates: Anderson<T, T>,
    packed: [Vec<T>; 2],
    /// v_free without joints, and the multipliers without percussions.
    unbound: Vec<T>,
    base: Vec<T>,
    multipliers: Vec<T>,
    step: Vec<T>,
    end: Vec<T>,
    zero: Vec<T>,
    work: Vec<T>,
    sizes: Vec<T>,
    /// Impulses of the inertial forces of the iterate measured last.
    inertial: Vec<T>,
}

impl<T: Scalar> Bilateral<T> {
    pub(super) fn new(system: &dyn Dynamics<T>, q: &[T], tolerance: Option<T>) -> Self {
        let joints = joints_of(system);
        let count = joints.rows();
        let zeros = |n: usize| vec![T::zero(); n];
        let used = if count == 0 { 0 } else { system.dofs() };
        let mut closed = zeros(count);
        joints.residual(q, &mut closed);
        let mut percussions = Anderson::new(MEMORY);
        percussions.prepare(used);
        let mut iterates = Anderson::new(MEMORY);
        iterates.prepare(used + count);
        Self {
            count,
            laws: Laws::new(!joints.all_held(), count),
            closed,
            drift: zeros(count),
            opening: zeros(count),
            tolerance,
            allowed: T::zero(),
            rows: BlockRows::new(),
            end_rows: BlockRows::new(),
            assembler: Assembler::new(used, used),
            tangent: Schur::new(count, false),
            symmetric: Schur::new(count, true),
            inverse: zeros(used),
            ratio: zeros(used),
            trial: Iterate::new(count, used),
            accepted: Iterate::new(count, used),
            last_good: Iterate::new(count, used),
            has_good: false,
            factored: false,
            left_over: LeftOver {
                opening: T::zero(),
                tolerance: T::zero(),
                row: 0,
                excess: T::zero(),
                is_rounding: false,
                merit: T::zero(),
            },
            percussions,
            iterates,
            packed: [zeros(used + count), zeros(used + count)],
            unbound: zeros(used),
            base: zeros(count),
            multipliers: zeros(count),
            step: zeros(used),
            end: zeros(if count == 0 { 0 } else { q.len() }),
            zero: zeros(used),
            work: zeros(used),
            sizes: zeros(used),
            inertial: zeros(used),
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The first iterate of a step that starts at `time`: the velocity `v`, no percussions.
    pub(super) fn start(
        &mut self,
        system: &dyn Dynamics<T>,
        span: &Span<'_, T, impl Fn(usize) -> T>,
        v: &[T],
        time: T,
        length: T,
    ) {
        let q = span.q;
        let least = lit::<T>(ROUNDING) * epsilon::<T>() * nalgebra::RealField::max(length, max_abs(q));
        self.allowed = self.tolerance.map_or(least, |given| nalgebra::RealField::max(given, least));
        // Half of what is allowed is left alone: to correct rounding would be work of the joints.
        let half = self.allowed * lit::<T>(0.5);
        joints_of(system).residual(q, &mut self.drift);
        for (drift, &closed) in self.drift.iter_mut().zip(&self.closed) {
            let by = *drift - closed;
            *drift = if by > half {
                by - half
            } else if by < -half {
                by + half
            } else {
                T::zero()
            };
        }
        self.accepted.v.copy_from_slice(v);
        self.accepted.multipliers.fill(T::zero());
        self.accepted.impulse.fill(T::zero());
        self.percussions.forget();
        self.has_good = false;
        self.set_laws(system, span, v, time);
    }

    /// Takes the free velocity without joints to the one of this pass, with them: Newton's method under the percussions of
    /// the pass before. `contacts` tells whether percussions follow.
    ///
    /// # Errors
    /// The row that cannot be met: S is singular, the joints are redundant.
    pub(super) fn bind(
        &mut self,
        system: &dyn Dynamics<T>,
        span: Span<'_, T, impl Fn(usize) -> T>,
        contacts: bool,
        mass: &mut Factor<T>,
        v_free: &mut [T],
    ) -> Result<(), usize> {
        self.unbound.copy_from_slice(v_free);
        let mut outcome = self.find(system, &span, mass);
        if !self.laws.redundant && (outcome.is_err() || !self.is_met(&outcome)) {
            // Joints that hold the same thing twice, here or from here on.
            self.laws.redundant = true;
            self.restart(span.v, mass.size());
            let with_ridge = self.find(system, &span, mass);
            if self.is_met(&with_ridge) {
                outcome = with_ridge;
            } else {
                self.laws.redundant = false;
                self.restart(span.v, mass.size());
                outcome = self.find(system, &span, mass);
            }
        }
        outcome?;
        if self.is_met(&outcome) {
            self.last_good.set(&self.accepted);
            self.has_good = true;
        }
        v_free.copy_from_slice(&self.accepted.v);
        self.base.copy_from_slice(&self.accepted.multipliers);
        self.factored = contacts;
        if contacts {
            // P is that of the velocities found. What percussions do is added by `respond`, for all of them.
            self.linearise(system, &span, Method::Newton, mass);
            let (rows, inverse, column) = (&self.rows, &self.inverse[..], &mut self.work[..]);
            let gains = (&self.laws, &span.theta);
            self.symmetric.factor(&mut self.assembler, (rows, rows), (mass, inverse), gains, column)?;
            let mut response = std::mem::take(&mut self.step);
            response.copy_from_slice(&self.accepted.impulse);
            self.respond(mass, &mut response);
            axpy(v_free, -T::one(), &response);
            self.step = response;
            axpy(&mut self.base, T::one(), &self.multipliers);
        }
        Ok(())
    }

    /// Newton's method from the iterate accepted, from a point half the way back to the last pass, or slower.
    fn find(
        &mut self,
        system: &dyn Dynamics<T>,
        span: &Span<'_, T, impl Fn(usize) -> T>,
        mass: &mut Factor<T>,
    ) -> Result<(), usize> {
        let mut outcome = self.iterate(system, span, Method::Newton, mass);
        for _ in 0..RETREATS {
            if !self.has_good || self.is_met(&outcome) {
                break;
            }
            // Percussions too far from those of the last pass: half the way.
            self.retreat();
            outcome = self.iterate(system, span, Method::Newton, mass);
        }
        if !self.is_met(&outcome) {
            self.restart(span.v, mass.size());
            outcome = self.iterate(system, span, Method::FixedPoint, mass);
        }
        outcome
    }

    /// The iterate accepted becomes the velocity `v`, but for what moves as told, with the multipliers that are given alone.
    fn restart(&mut self, v: &[T], free: usize) {
        self.accepted.v[..free].copy_from_slice(&v[..free]);
        for (multiplier, &active) in self.accepted.multipliers.iter_mut().zip(&self.laws.active) {
            if active {
                *multiplier = T::zero();
            }
        }
    }

    /// Goes half the way back, in percussions, to where the joints were met last.
    fn retreat(&mut self) {
        let half = lit::<T>(0.5);
        let impulse = self.accepted.impulse.iter_mut().zip(&self.last_good.impulse);
        impulse.for_each(|(x, &good)| *x = (*x + good) * half);
        self.accepted.v.copy_from_slice(&self.last_good.v);
        self.accepted.multipliers.copy_from_slice(&self.last_good.multipliers);
    }

    /// x ← P x, what an impulse does to the velocities; its multipliers, but for their sign, stay behind.
    pub(super) fn respond(&mut self, mass: &mut Factor<T>, x: &mut [T]) {
        solve(mass, &self.inverse, x);
        for (i, multiplier) in self.multipliers.iter_mut().enumerate() {
            *multiplier = if self.laws.active[i] { self.rows.velocity(i, x)[0] } else { T::zero() };
        }
        self.symmetric.solve(&mut self.multipliers);
        self.push(mass);
        axpy(x, -T::one(), &self.work);
    }

    /// Takes what a motion from `from` to `to`, along the joints to first order, has opened, with the rows of the step, until
    /// rounding is left or nothing is gained.
    pub(super) fn close(&mut self, system: &dyn Dynamics<T>, mass: &mut Factor<T>, from: &[T], to: &mut [T]) {
        let theta = |_: usize| T::one();
        let mut last = T::infinity_impl();
        if !self.factored {
            let (rows, inverse, column) = (&self.rows, &self.inverse[..], &mut self.work[..]);
            let gains = (&self.laws, &theta);
            // What cannot be factored has been refused by now.
            if self
                .symmetric
                .factor(&mut self.assembler, (rows, rows), (mass, inverse), gains, column)
                .is_err()
            {
                return;
            }
            self.factored = true;
        }
        let joints = joints_of(system);
        joints.residual(from, &mut self.drift);
        loop {
            joints.residual(to, &mut self.multipliers);
            for (row, open) in self.multipliers.iter_mut().enumerate() {
                // Springs and motors hold no place.
                let held = self.laws.rows[row] == RowLaw::Held;
                *open = if held { *open - self.drift[row] } else { T::zero() };
            }
            let open = max_abs(&self.multipliers);
            if !(open < last * lit::<T>(0.5)) {
                return;
            }
            last = open;
            self.symmetric.solve(&mut self.multipliers);
            self.push(mass);
            self.work.iter_mut().for_each(|x| *x = -*x);
            self.end.copy_from_slice(to);
            system.advance(&self.end, &self.work, to);
        }
    }

    /// work ← K̂⁻¹ Ḡᵀ λ for the multipliers λ.
    fn push(&mut self, mass: &mut Factor<T>) {
        self.work.fill(T::zero());
        for (i, &multiplier) in self.multipliers.iter().enumerate() {
            self.rows.add_transpose(i, &SVector::<T, 1>::new(multiplier), &mut self.work);
        }
        solve(mass, &self.inverse, &mut self.work);
    }

    /// Judges the pass that ended at `v` with the impulse Hᵀp of contacts, if any, to which `respond` was applied last, and
    /// tells where the next one starts.
    pub(super) fn judge(
        &mut self,
        system: &dyn Dynamics<T>,
        span: Span<'_, T, impl Fn(usize) -> T>,
        mass: &mut Factor<T>,
        v: &[T],
        impulse: Option<&[T]>,
    ) -> LeftOver<T> {
        let Some(impulse) = impulse else { return self.left_over };
        let Iterate { v: trial, multipliers, impulse: reached } = &mut self.trial;
        trial.copy_from_slice(v);
        reached.copy_from_slice(impulse);
        multipliers.copy_from_slice(&self.base);
        axpy(multipliers, -T::one(), &self.multipliers);
        let left_over = self.measure(system, &span, mass);
        if left_over.excess > T::one() {
            let weight = |i: usize| match &*mass {
                Factor::Diagonal(inverse) => inverse.get(i).copied().unwrap_or_else(T::zero),
                _ => T::one(),
            };
            let weights = (0..v.len()).map(weight);
            self.percussions.accelerate(&self.accepted.impulse, &mut self.trial.impulse, weights);
        }
        std::mem::swap(&mut self.trial, &mut self.accepted);
        left_over
    }
}
