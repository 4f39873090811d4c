//! Newton's method on velocities and multipliers, under given percussions.

use nalgebra::SVector;

use super::schur::solve;
use super::span::{Iterate, Span};
use super::{Bilateral, LeftOver, ROUNDING, STAGNATION};
use crate::linalg::{Factor, axpy, max_abs};
use crate::scalar::{Scalar, epsilon, lit};
use crate::scheme::no_joints::joints_of;
use crate::system::Dynamics;

/// K̂ is not to fall below this share of M̂: it stays positive definite.
const LEAST_SHARE: f64 = 0.125;

/// Most halvings of a step of Newton's method.
const HALVINGS: usize = 8;

/// What a step of Newton's method is to leave of the merit, a square.
const SLOW: f64 = 1e-2;

/// Most iterations in a pass.
const MOST_ITERATIONS: usize = 50;

/// How velocities and multipliers are iterated for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Method {
    Newton,
    /// G₁ = Ḡ and K̂ = M̂: slower, and met where Newton's method is caught near a singular position.
    FixedPoint,
}

impl<T: Scalar> Bilateral<T> {
    /// s = h v_{k+θ} of a velocity at the end, and q_k ⊕ s.
    pub(super) fn span(
        system: &dyn Dynamics<T>,
        (step, end): (&mut [T], &mut [T]),
        v: &[T],
        span: &Span<'_, T, impl Fn(usize) -> T>,
    ) {
        for i in 0..v.len() {
            let theta = (span.theta)(i);
            step[i] = span.step * ((T::one() - theta) * span.v[i] + theta * v[i]);
        }
        system.advance(span.q, step, end);
    }

    pub(super) fn is_met(&self, outcome: &Result<(), usize>) -> bool {
        outcome.is_ok() && (self.left_over.excess <= lit(STAGNATION) || self.left_over.is_rounding)
    }

    /// Iterates for velocities and multipliers from the iterate accepted, under its percussions.
    pub(super) fn iterate(
        &mut self,
        system: &dyn Dynamics<T>,
        span: &Span<'_, T, impl Fn(usize) -> T>,
        method: Method,
        mass: &mut Factor<T>,
    ) -> Result<(), usize> {
        self.trial.set(&self.accepted);
        self.left_over = self.measure(system, span, mass);
        self.iterates.forget();
        let halvings = if method == Method::Newton { HALVINGS } else { 0 };
        for iteration in 0..MOST_ITERATIONS {
            if self.switch() {
                self.trial.set(&self.accepted);
                self.left_over = self.measure(system, span, mass);
                self.iterates.forget();
            }
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
            left_over = self.extrapolate(system, span, mass, (before, left_over));
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

    /// Goes on along the iterates made where K̂ leaves so much out that Newton's method gains little: what joints in space bend, and
    /// gyroscopic torques. Returns what the trial then leaves.
    fn extrapolate(
        &mut self,
        system: &dyn Dynamics<T>,
        span: &Span<'_, T, impl Fn(usize) -> T>,
        mass: &mut Factor<T>,
        (before, plain): (LeftOver<T>, LeftOver<T>),
    ) -> LeftOver<T> {
        // Fast ones are neither helped nor remembered.
        if !(plain.excess > T::one() && plain.merit > before.merit * lit::<T>(SLOW)) {
            return plain;
        }
        let Self { iterates, packed: [from, to], accepted, trial, .. } = self;
        accepted.pack(from);
        trial.pack(to);
        let dofs = trial.v.len();
        let weight = |i: usize| match &*mass {
            // Multipliers follow the velocities.
            _ if i >= dofs => T::zero(),
            Factor::Diagonal(inverse) => inverse.get(i).map_or_else(T::zero, |&inverse| T::one() / inverse),
            _ => T::one(),
        };
        let entries = 0..to.len();
        if !iterates.accelerate(from, to, entries.map(weight)) {
            return plain;
        }
        trial.pack(from);
        trial.unpack(to);
        let left_over = self.measure(system, span, mass);
        if left_over.merit < plain.merit {
            return left_over;
        }
        let Self { packed: [plain, _], trial, .. } = self;
        trial.unpack(plain);
        self.measure(system, span, mass)
    }

    /// Newton's step from the iterate accepted, into the trial.
    pub(super) fn newton_step(
        &mut self,
        span: &Span<'_, T, impl Fn(usize) -> T>,
        mass: &mut Factor<T>,
    ) -> Result<(), usize> {
        let Self {
            accepted,
            trial,
            rows,
            end_rows,
            tangent,
            inverse,
            ratio,
            opening,
            work,
            unbound,
            inertial,
            laws,
            ..
        } = self;
        let (ends, start) = (end_rows, &accepted.v);
        let Iterate { v, multipliers, impulse } = trial;
        impulse.copy_from_slice(&accepted.impulse);
        // v_free + (1 − K̂⁻¹ M̂)(v_i − v_free) + K̂⁻¹ (Hᵀ p_i + Ḡᵀ λ), λ where it is given
        work.copy_from_slice(impulse);
        Self::push_given(laws, rows, &accepted.multipliers, work);
        axpy(work, T::one(), inertial);
        solve(mass, inverse, work);
        v.copy_from_slice(unbound);
        for i in 0..mass.size() {
            v[i] += (T::one() - ratio[i]) * (start[i] - unbound[i]) + work[i];
        }
        let size = max_abs(v) + max_abs(start);
        let theta = |i: usize| (span.theta)(ends.row(i).next().map_or(0, |(dof, _)| dof));
        let wanted = |i: usize| ends.velocity(i, start)[0] - opening[i] / theta(i);
        tangent.factor(&mut self.assembler, (ends, rows), (mass, inverse), (laws, &span.theta), work)?;
        for (i, multiplier) in multipliers.iter_mut().enumerate() {
            *multiplier = if laws.active[i] {
                wanted(i) - ends.velocity(i, v)[0] + tangent.ridges[i] * accepted.multipliers[i]
            } else {
                accepted.multipliers[i]
            };
        }
        tangent.solve(multipliers);
        work.fill(T::zero());
        for (i, &multiplier) in multipliers.iter().enumerate().filter(|&(i, _)| laws.active[i]) {
            rows.add_transpose(i, &SVector::<T, 1>::new(multiplier), work);
        }
        solve(mass, inverse, work);
        axpy(v, T::one(), work);
        // Far above the rounding of a solve, far below the velocities themselves.
        let bound = lit::<T>(1e-6) * (size + max_abs(v));
        let missed = |i: usize| {
            let yields = laws.compliance[i] / theta(i) * multipliers[i];
            let ridge = tangent.ridges[i] * (multipliers[i] - accepted.multipliers[i]);
            nalgebra::ComplexField::abs(wanted(i) - ends.velocity(i, v)[0] - yields - ridge)
        };
        match (0..self.count).find(|&i| laws.active[i] && !(missed(i) <= bound)) {
            Some(row) => Err(row),
            None => Ok(()),
        }
    }

    /// G₁ and K̂ at the iterate accepted, which was measured last: Ḡ is there.
    pub(super) fn linearise(
        &mut self,
        system: &dyn Dynamics<T>,
        span: &Span<'_, T, impl Fn(usize) -> T>,
        method: Method,
        mass: &mut Factor<T>,
    ) {
        self.end_rows.clear();
        match method {
            Method::Newton => {
                let end = (&self.end[..], &self.zero[..]);
                joints_of(system).tangent(span.q, &self.step, end, &mut self.end_rows);
            }
            Method::FixedPoint => joints_of(system).jacobian(span.q, &self.step, &mut self.end_rows),
        }
        for i in 0..self.count {
            self.opening[i] = (self.rows.velocity(i, &self.step)[0] + self.drift[i]) / span.step;
        }
        if let Factor::Diagonal(inverse) = mass {
            self.work.fill(T::zero());
            if method == Method::Newton {
                let multipliers = &self.accepted.multipliers;
                joints_of(system).curvature(span.q, &self.step, multipliers, &mut self.work);
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

    /// What the trial leaves.
    pub(super) fn measure(
        &mut self,
        system: &dyn Dynamics<T>,
        span: &Span<'_, T, impl Fn(usize) -> T>,
        mass: &mut Factor<T>,
    ) -> LeftOver<T> {
        let abs = |x: T| nalgebra::ComplexField::abs(x);
        let Self { trial, rows, step, end, work, sizes, unbound, inertial, laws, .. } = self;
        Self::span(system, (step, end), &trial.v, span);
        // v − v_free − M̂⁻¹ (Hᵀp + Ḡᵀλ), against the sizes of its terms.
        rows.clear();
        joints_of(system).jacobian(span.q, step, rows);
        work.copy_from_slice(&trial.impulse);
        inertial.fill(T::zero());
        joints_of(system).inertial(step, span.step, inertial);
        axpy(work, T::one(), inertial);
        for (size, (&impulse, &inertial)) in sizes.iter_mut().zip(trial.impulse.iter().zip(&*inertial)) {
            *size = abs(impulse) + abs(inertial);
        }
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
        let (mut widest, mut violated) = (T::zero(), false);
        // Of redundant rows those without a load take the rounding of the others.
        let shared = if laws.redundant { span.step * max_abs(unbound) } else { T::zero() };
        let weight = |dof: usize| match &*mass {
            Factor::Diagonal(inverse) => inverse.get(dof).copied().unwrap_or_else(T::zero),
            _ => T::one(),
        };
        for i in 0..self.count {
            let (mut opening, mut size, mut mobility) = (self.drift[i], T::zero(), laws.compliance[i]);
            for (dof, entry) in rows.row(i) {
                opening += entry[0] * step[dof];
                mobility += entry[0] * entry[0] * weight(dof);
                size += abs(entry[0]) * (abs(step[dof]) + span.step * sizes[dof] + shared);
            }
            laws.moved[i] = opening;
            // Written so that a NaN is the worst.
            let violation = laws.violation(i, trial.multipliers[i], size);
            violated |= !(violation <= lit(STAGNATION));
            if !(violation <= excess) {
                (excess, worst) = (violation, (abs(opening), T::zero(), i));
            }
            if !laws.active[i] {
                continue;
            }
            let yields = span.step * laws.compliance[i] * trial.multipliers[i];
            (opening, size) = (opening + yields, size + abs(self.drift[i]) + abs(yields));
            let rate = opening / span.step;
            merit += rate * rate / mobility;
            let tolerance = nalgebra::RealField::max(given, rounding * size);
            let opening = abs(opening);
            widest = nalgebra::RealField::max(widest, opening);
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
        let is_rounding =
            widest <= self.allowed && !violated && left_over <= rounding * size * lit::<T>(STAGNATION);
        LeftOver { opening, tolerance, row, excess, is_rounding, merit }
    }
}
