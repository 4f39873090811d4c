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

use nalgebra::SVector;

use super::delassus::Assembler;
use super::lasting::Lasting;
use super::{Settings, State};
use crate::cone::BlockMatrix;
use crate::linalg::{BlockRows, Factor, Multifrontal, SolveBuffers, axpy, max_abs};
use crate::scalar::{Scalar, epsilon, lit};
use crate::solver::Anderson;
use crate::system::MechanicalSystem;

/// Rounding of the positions that joints compare, in ε of the largest: they are sums of a few products.
pub(super) const ROUNDING: f64 = 64.0;

/// K̂ is not to fall below this share of M̂: it stays positive definite.
const LEAST_SHARE: f64 = 0.125;

/// Most halvings of a step of Newton's method.
const HALVINGS: usize = 8;

/// Most iterations in a pass.
const MOST_ITERATIONS: usize = 50;

/// Most times that percussions are drawn back halfway to those of the last pass.
const RETREATS: usize = 6;

/// Excess over the tolerances that rounding may leave where masses differ much: once an iteration gains nothing more, this is
/// enough.
pub(super) const STAGNATION: f64 = 64.0;

/// Passes that their acceleration remembers.
const MEMORY: usize = 6;

/// A step as joints see it: where it starts, its length, and θ of each degree of freedom.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span<'a, T, F> {
    pub(super) q: &'a [T],
    pub(super) v: &'a [T],
    pub(super) step: T,
    pub(super) theta: F,
}

impl<'a, T: Scalar> Span<'a, T, ()> {
    /// The step from `state`, with the θ of the island each degree of freedom is in.
    pub(super) fn of(
        settings: &Settings<T>,
        state: &'a State<T>,
        lasting: Option<&'a Lasting<T>>,
    ) -> Span<'a, T, impl Fn(usize) -> T + use<'a, T>> {
        let (theta, thetas) = (settings.theta, lasting.and_then(Lasting::theta));
        let theta = move |dof: usize| thetas.map_or(theta, |thetas| thetas[dof]);
        Span { q: &state.q, v: &state.v, step: settings.step, theta }
    }
}

/// An iterate: velocities, multipliers of the joints, and the impulse Hᵀp of the contacts.
#[derive(Debug)]
struct Iterate<T> {
    v: Vec<T>,
    multipliers: Vec<T>,
    impulse: Vec<T>,
}

impl<T: Scalar> Iterate<T> {
    fn new(rows: usize, dofs: usize) -> Self {
        let zeros = |n: usize| vec![T::zero(); n];
        Self { v: zeros(dofs), multipliers: zeros(rows), impulse: zeros(dofs) }
    }

    fn set(&mut self, other: &Self) {
        self.v.copy_from_slice(&other.v);
        self.multipliers.copy_from_slice(&other.multipliers);
        self.impulse.copy_from_slice(&other.impulse);
    }

    /// The point midway to another.
    fn approach(&mut self, other: &Self) {
        let half = lit::<T>(0.5);
        let middle = |x: &mut [T], y: &[T]| x.iter_mut().zip(y).for_each(|(x, &y)| *x = (*x + y) * half);
        middle(&mut self.v, &other.v);
        middle(&mut self.multipliers, &other.multipliers);
        middle(&mut self.impulse, &other.impulse);
    }
}

/// A matrix over the rows of the joints, and its factors.
#[derive(Debug)]
struct Schur<T: Scalar> {
    matrix: BlockMatrix<T, 1>,
    values: Vec<T>,
    active: Vec<bool>,
    factor: Multifrontal<T>,
    buffers: SolveBuffers<T>,
}

impl<T: Scalar> Schur<T> {
    fn new(rows: usize) -> Self {
        Self {
            matrix: BlockMatrix::new(),
            values: Vec::new(),
            active: vec![true; rows],
            factor: Multifrontal::new(),
            buffers: SolveBuffers::default(),
        }
    }

    /// Factors G K̂⁻¹ Ḡᵀ, K̂ diagonal where an `inverse` is given.
    fn factor(
        &mut self,
        assembler: &mut Assembler<T, 1>,
        (left, right): (&BlockRows<T, 1>, &BlockRows<T, 1>),
        mass: &mut Factor<T>,
        inverse: &[T],
        column: &mut [T],
    ) -> Result<(), usize> {
        if matches!(mass, Factor::Diagonal(_)) {
            assembler.assemble_pair(left, right, inverse, &mut self.matrix);
            self.values.clear();
            self.values.extend(self.matrix.blocks().iter().map(|block| block[(0, 0)]));
        } else {
            let (rows, one) = (right.rows(), SVector::<T, 1>::new(T::one()));
            self.matrix.clear();
            for _ in 0..rows {
                self.matrix.start_row();
                (0..rows).for_each(|j| self.matrix.push(j, one));
            }
            self.values.resize(rows * rows, T::zero());
            for j in 0..rows {
                column.fill(T::zero());
                right.add_transpose(j, &one, column);
                solve(mass, inverse, column);
                for i in 0..rows {
                    self.values[i * rows + j] = left.velocity(i, column)[0];
                }
            }
        }
        let (starts, columns) = self.matrix.pattern();
        self.factor.analyse(starts, columns, 1);
        self.factor.factor(&self.values, &self.active)
    }

    fn solve(&mut self, x: &mut [T]) {
        self.factor.solve(x, &mut self.buffers);
    }
}

/// x ← K̂⁻¹ x over the free degrees of freedom, zero elsewhere.
fn solve<T: Scalar>(mass: &mut Factor<T>, inverse: &[T], x: &mut [T]) {
    let free = mass.size();
    x[free..].fill(T::zero());
    match mass {
        Factor::Diagonal(_) => x.iter_mut().zip(inverse).for_each(|(x, &inverse)| *x *= inverse),
        mass => mass.solve_in_place(&mut x[..free]),
    }
}

/// How velocities and multipliers are iterated for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Method {
    Newton,
    /// G₁ = Ḡ and K̂ = M̂: slower, and met where Newton's method is caught near a singular position.
    FixedPoint,
}

/// What is left of the equations of a step with joints.
#[derive(Debug, Clone, Copy)]
pub(super) struct LeftOver<T> {
    /// max |φ(q_{k+1}) − φ(q_0)| (m or rad), what is allowed, and the row.
    pub(super) opening: T,
    pub(super) tolerance: T,
    pub(super) row: usize,
    /// The larger of the opening and the residual of the equations of motion, in what is allowed of each.
    pub(super) excess: T,
    /// Both in energy, ‖ρ‖²_M + Σ (opening/h)² / (Ḡ M̂⁻¹ Ḡᵀ)_ii.
    merit: T,
}

/// Ḡ, G₁, the factors of a pass and its iterates; without rows, nothing.
#[derive(Debug)]
pub(super) struct Joints<T: Scalar> {
    count: usize,
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
    newton: Schur<T>,
    symmetric: Schur<T>,
    /// Diagonal K̂⁻¹ and K̂⁻¹ M̂.
    inverse: Vec<T>,
    ratio: Vec<T>,
    trial: Iterate<T>,
    accepted: Iterate<T>,
    /// Where the joints were met last in this step.
    last_good: Iterate<T>,
    has_good: bool,
    left_over: LeftOver<T>,
    /// Fixed point of the impulses Hᵀp.
    percussions: Anderson<T, T>,
    /// v_free without joints, and the multipliers without percussions.
    unbound: Vec<T>,
    base: Vec<T>,
    multipliers: Vec<T>,
    step: Vec<T>,
    end: Vec<T>,
    zero: Vec<T>,
    work: Vec<T>,
    sizes: Vec<T>,
}

impl<T: Scalar> Joints<T> {
    pub(super) fn new<const D: usize, S: MechanicalSystem<T, D>>(
        system: &S,
        q: &[T],
        tolerance: Option<T>,
    ) -> Self {
        let count = system.joint_rows();
        let zeros = |n: usize| vec![T::zero(); n];
        let used = if count == 0 { 0 } else { system.dofs() };
        let mut closed = zeros(count);
        system.joint_residual(q, &mut closed);
        let mut percussions = Anderson::new(MEMORY);
        percussions.prepare(used);
        Self {
            count,
            closed,
            drift: zeros(count),
            opening: zeros(count),
            tolerance,
            allowed: T::zero(),
            rows: BlockRows::new(),
            end_rows: BlockRows::new(),
            assembler: Assembler::new(used, used),
            newton: Schur::new(count),
            symmetric: Schur::new(count),
            inverse: zeros(used),
            ratio: zeros(used),
            trial: Iterate::new(count, used),
            accepted: Iterate::new(count, used),
            last_good: Iterate::new(count, used),
            has_good: false,
            left_over: LeftOver {
                opening: T::zero(),
                tolerance: T::zero(),
                row: 0,
                excess: T::zero(),
                merit: T::zero(),
            },
            percussions,
            unbound: zeros(used),
            base: zeros(count),
            multipliers: zeros(count),
            step: zeros(used),
            end: zeros(used),
            zero: zeros(used),
            work: zeros(used),
            sizes: zeros(used),
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The first iterate of a step from q: the velocity `v`, no percussions.
    pub(super) fn start<const D: usize, S: MechanicalSystem<T, D>>(
        &mut self,
        system: &S,
        q: &[T],
        v: &[T],
        length: T,
    ) {
        let least = lit::<T>(ROUNDING) * epsilon::<T>() * nalgebra::RealField::max(length, max_abs(q));
        self.allowed = self.tolerance.map_or(least, |given| nalgebra::RealField::max(given, least));
        // Half of what is allowed is left alone: to correct rounding would be work of the joints.
        let half = self.allowed * lit::<T>(0.5);
        system.joint_residual(q, &mut self.drift);
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
    }

    /// s = h v_{k+θ} of a velocity at the end, and q_k + s.
    fn span(step: &mut [T], end: &mut [T], v: &[T], span: &Span<'_, T, impl Fn(usize) -> T>) {
        for i in 0..v.len() {
            let theta = (span.theta)(i);
            step[i] = span.step * ((T::one() - theta) * span.v[i] + theta * v[i]);
            end[i] = span.q[i] + step[i];
        }
    }

    /// Takes the free velocity without joints to the one of this pass, with them: Newton's method under the percussions of
    /// the pass before. `contacts` tells whether percussions follow.
    ///
    /// # Errors
    /// The row that cannot be met: S is singular, the joints are redundant.
    pub(super) fn bind<const D: usize, S: MechanicalSystem<T, D>>(
        &mut self,
        system: &S,
        span: Span<'_, T, impl Fn(usize) -> T>,
        contacts: bool,
        mass: &mut Factor<T>,
        v_free: &mut [T],
    ) -> Result<(), usize> {
        self.unbound.copy_from_slice(v_free);
        let mut outcome = self.iterate(system, &span, Method::Newton, mass);
        for _ in 0..RETREATS {
            if !self.has_good || self.is_met(&outcome) {
                break;
            }
            // Percussions too far from those of the last pass: half the way.
            self.retreat();
            outcome = self.iterate(system, &span, Method::Newton, mass);
        }
        if !self.is_met(&outcome) {
            self.accepted.v.copy_from_slice(span.v);
            self.accepted.multipliers.fill(T::zero());
            outcome = self.iterate(system, &span, Method::FixedPoint, mass);
        }
        outcome?;
        if self.left_over.excess <= lit(STAGNATION) {
            self.last_good.set(&self.accepted);
            self.has_good = true;
        }
        v_free.copy_from_slice(&self.accepted.v);
        self.base.copy_from_slice(&self.accepted.multipliers);
        if contacts {
            // P is that of the velocities found. What percussions do is added by `respond`, for all of them.
            self.linearise(system, &span, Method::Newton, mass);
            let (rows, inverse, column) = (&self.rows, &self.inverse[..], &mut self.work[..]);
            self.symmetric.factor(&mut self.assembler, (rows, rows), mass, inverse, column)?;
            let mut response = std::mem::take(&mut self.step);
            response.copy_from_slice(&self.accepted.impulse);
            self.respond(mass, &mut response);
            axpy(v_free, -T::one(), &response);
            self.step = response;
            axpy(&mut self.base, T::one(), &self.multipliers);
        }
        Ok(())
    }

    fn is_met(&self, outcome: &Result<(), usize>) -> bool {
        outcome.is_ok() && self.left_over.excess <= lit(STAGNATION)
    }

    /// Goes half the way back, in percussions, to where the joints were met last.
    fn retreat(&mut self) {
        let half = lit::<T>(0.5);
        let impulse = self.accepted.impulse.iter_mut().zip(&self.last_good.impulse);
        impulse.for_each(|(x, &good)| *x = (*x + good) * half);
        self.accepted.v.copy_from_slice(&self.last_good.v);
        self.accepted.multipliers.copy_from_slice(&self.last_good.multipliers);
    }

    /// Iterates for velocities and multipliers from the iterate accepted, under its percussions.
    fn iterate<const D: usize, S: MechanicalSystem<T, D>>(
        &mut self,
        system: &S,
        span: &Span<'_, T, impl Fn(usize) -> T>,
        method: Method,
        mass: &mut Factor<T>,
    ) -> Result<(), usize> {
        self.trial.set(&self.accepted);
        self.left_over = self.measure(system, span, mass);
        let halvings = if method == Method::Newton { HALVINGS } else { 0 };
        for iteration in 0..MOST_ITERATIONS {
            let before = self.left_over;
            self.linearise(system, span, method, mass);
            self.newton_step(span, mass)?;
            let mut left_over = self.measure(system, span, mass);
            for halving in 1..=halvings {
                let share = lit::<T>(0.25 / f64::powi(2.0, halving as i32));
                // Written so that a NaN is drawn back.
                if left_over.excess <= T::one() || left_over.merit <= before.merit * (T::one() - share) {
                    break;
                }
                self.trial.approach(&self.accepted);
                left_over = self.measure(system, span, mass);
            }
            std::mem::swap(&mut self.trial, &mut self.accepted);
            self.left_over = left_over;
            let stagnates = iteration > 2 && !(left_over.merit < before.merit * lit::<T>(0.25));
            let enough = lit::<T>(if stagnates { STAGNATION } else { 1.0 });
            if left_over.excess <= enough {
                break;
            }
        }
        Ok(())
    }

    /// Newton's step from the iterate accepted, into the trial.
    fn newton_step(
        &mut self,
        span: &Span<'_, T, impl Fn(usize) -> T>,
        mass: &mut Factor<T>,
    ) -> Result<(), usize> {
        let Self { accepted, trial, rows, end_rows, newton, inverse, ratio, opening, work, unbound, .. } =
            self;
        let (ends, start) = (end_rows, &accepted.v);
        let Iterate { v, multipliers, impulse } = trial;
        impulse.copy_from_slice(&accepted.impulse);
        // v_free + (1 − K̂⁻¹ M̂)(v_i − v_free) + K̂⁻¹ Hᵀ p_i
        work.copy_from_slice(impulse);
        solve(mass, inverse, work);
        v.copy_from_slice(unbound);
        for i in 0..mass.size() {
            v[i] += (T::one() - ratio[i]) * (start[i] - unbound[i]) + work[i];
        }
        let size = max_abs(v) + max_abs(start);
        let wanted = |i: usize| {
            let first = ends.row(i).next().map_or(0, |(dof, _)| dof);
            ends.velocity(i, start)[0] - opening[i] / (span.theta)(first)
        };
        for (i, multiplier) in multipliers.iter_mut().enumerate() {
            *multiplier = wanted(i) - ends.velocity(i, v)[0];
        }
        newton.factor(&mut self.assembler, (ends, rows), mass, inverse, work)?;
        newton.solve(multipliers);
        work.fill(T::zero());
        for (i, &multiplier) in multipliers.iter().enumerate() {
            rows.add_transpose(i, &SVector::<T, 1>::new(multiplier), work);
        }
        solve(mass, inverse, work);
        axpy(v, T::one(), work);
        // Far above the rounding of a solve, far below the velocities themselves.
        let bound = lit::<T>(1e-6) * (size + max_abs(v));
        let missed = |i: usize| nalgebra::ComplexField::abs(wanted(i) - ends.velocity(i, v)[0]);
        match (0..self.count).find(|&i| !(missed(i) <= bound)) {
            Some(row) => Err(row),
            None => Ok(()),
        }
    }

    /// G₁ and K̂ at the iterate accepted, which was measured last: Ḡ is there.
    fn linearise<const D: usize, S: MechanicalSystem<T, D>>(
        &mut self,
        system: &S,
        span: &Span<'_, T, impl Fn(usize) -> T>,
        method: Method,
        mass: &mut Factor<T>,
    ) {
        self.end_rows.clear();
        match method {
            Method::Newton => system.joint_jacobian(&self.end, &self.zero, &mut self.end_rows),
            Method::FixedPoint => system.joint_jacobian(span.q, &self.step, &mut self.end_rows),
        }
        for i in 0..self.count {
            self.opening[i] = (self.rows.velocity(i, &self.step)[0] + self.drift[i]) / span.step;
        }
        if let Factor::Diagonal(inverse) = mass {
            self.work.fill(T::zero());
            if method == Method::Newton {
                system.joint_curvature(span.q, &self.step, &self.accepted.multipliers, &mut self.work);
            }
            let least = lit::<T>(LEAST_SHARE);
            for (i, &inverse) in inverse.iter().enumerate() {
                let share = T::one() - span.step * (span.theta)(i) * self.work[i] * inverse;
                // Written so that a NaN becomes the least.
                let share = if share > least { share } else { least };
                self.ratio[i] = T::one() / share;
                self.inverse[i] = inverse * self.ratio[i];
            }
        } else {
            self.ratio.fill(T::one());
        }
    }

    /// x ← P x, what an impulse does to the velocities; its multipliers, but for their sign, stay behind.
    pub(super) fn respond(&mut self, mass: &mut Factor<T>, x: &mut [T]) {
        solve(mass, &self.inverse, x);
        for (i, multiplier) in self.multipliers.iter_mut().enumerate() {
            *multiplier = self.rows.velocity(i, x)[0];
        }
        self.symmetric.solve(&mut self.multipliers);
        self.push(mass);
        axpy(x, -T::one(), &self.work);
    }

    /// Takes what a motion from `from` to `to`, along the joints to first order, has opened, with the rows of the step, until
    /// rounding is left or nothing is gained.
    pub(super) fn close<const D: usize, S: MechanicalSystem<T, D>>(
        &mut self,
        system: &S,
        mass: &mut Factor<T>,
        from: &[T],
        to: &mut [T],
    ) {
        let mut last = T::infinity_impl();
        system.joint_residual(from, &mut self.drift);
        loop {
            system.joint_residual(to, &mut self.multipliers);
            self.multipliers.iter_mut().zip(&self.drift).for_each(|(open, &before)| *open -= before);
            let open = max_abs(&self.multipliers);
            if !(open < last * lit::<T>(0.5)) {
                return;
            }
            last = open;
            self.symmetric.solve(&mut self.multipliers);
            self.push(mass);
            axpy(to, -T::one(), &self.work);
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
    pub(super) fn judge<const D: usize, S: MechanicalSystem<T, D>>(
        &mut self,
        system: &S,
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

    /// What the trial leaves.
    fn measure<const D: usize, S: MechanicalSystem<T, D>>(
        &mut self,
        system: &S,
        span: &Span<'_, T, impl Fn(usize) -> T>,
        mass: &mut Factor<T>,
    ) -> LeftOver<T> {
        let abs = |x: T| nalgebra::ComplexField::abs(x);
        let Self { trial, rows, step, end, work, sizes, unbound, .. } = self;
        Self::span(step, end, &trial.v, span);
        // v − v_free − M̂⁻¹ (Hᵀp + Ḡᵀλ), against the sizes of its terms.
        rows.clear();
        system.joint_jacobian(span.q, step, rows);
        work.copy_from_slice(&trial.impulse);
        sizes.iter_mut().zip(&trial.impulse).for_each(|(size, &impulse)| *size = abs(impulse));
        for (i, &multiplier) in trial.multipliers.iter().enumerate() {
            for (dof, entry) in rows.row(i) {
                work[dof] += entry[0] * multiplier;
                sizes[dof] += abs(entry[0] * multiplier);
            }
        }
        let free = mass.size();
        if let Factor::Diagonal(inverse) = mass {
            for i in 0..free {
                work[i] *= inverse[i];
                sizes[i] *= inverse[i];
            }
        } else {
            mass.solve_in_place(&mut work[..free]);
            let size = max_abs(&work[..free]);
            sizes.fill(size);
        }
        let rounding = lit::<T>(ROUNDING) * epsilon::<T>();
        // A given tolerance is one of the positions, and of the equations of motion as much as moves them so far.
        let given = self.tolerance.map_or(T::zero(), |_| self.allowed);
        let mut worst = (T::zero(), given, 0);
        let (mut excess, mut merit) = (T::zero(), T::zero());
        let weight = |dof: usize| match &*mass {
            Factor::Diagonal(inverse) => inverse.get(dof).copied().unwrap_or_else(T::zero),
            _ => T::one(),
        };
        for i in 0..self.count {
            let (mut opening, mut size, mut mobility) = (self.drift[i], T::zero(), T::zero());
            for (dof, entry) in rows.row(i) {
                opening += entry[0] * step[dof];
                mobility += entry[0] * entry[0] * weight(dof);
                size += abs(entry[0]) * (abs(step[dof]) + span.step * sizes[dof]);
            }
            let rate = opening / span.step;
            merit += rate * rate / mobility;
            let (opening, tolerance) = (abs(opening), nalgebra::RealField::max(given, rounding * size));
            // Written so that a NaN is the worst.
            if !(opening <= tolerance * excess) {
                excess = opening / tolerance;
                worst = (opening, tolerance, i);
            }
        }
        // In the norm of M̂: components of one body differ in their units.
        let (mut left_over, mut size) = (T::zero(), T::zero());
        for i in 0..free {
            let weight = weight(i);
            let (by, of) = (trial.v[i] - unbound[i] - work[i], sizes[i] + abs(trial.v[i]) + abs(unbound[i]));
            left_over += by * by / weight;
            size += of * of / weight;
        }
        merit += left_over;
        let (left_over, size) = (nalgebra::ComplexField::sqrt(left_over), nalgebra::ComplexField::sqrt(size));
        // Written so that a NaN goes on.
        if !(left_over <= rounding * size * excess) {
            excess = left_over / (rounding * size);
        }
        let (opening, tolerance, row) = worst;
        LeftOver { opening, tolerance, row, excess, merit }
    }
}

/// The least tolerance of joints, in ε of the largest coordinate.
pub(super) const LEAST_ROUNDING: f64 = 8.0;
