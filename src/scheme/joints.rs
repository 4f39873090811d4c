//! Joints: bilateral rows of the cone problem, eliminated exactly.
//!
//! With joints the problem of a step is (81) with more rows, those of Ḡ, on which the cone is the whole line:
//!
//! ```text
//!   M̂ (v_{k+1} − v_free) = Hᵀ p + Ḡᵀ λ,   K* ∋ Φ(w) ⟂ p ∈ K,   {0} ∋ Ḡ v_{k+θ} ⟂ λ ∈ ℝ
//! ```
//!
//! The dual of the whole line is {0}, so that λ follows from the velocities by a linear solve. Eliminated, with
//! S = Ḡ M̂⁻¹ Ḡᵀ,
//!
//! ```text
//!   M̂⁻¹  →  P = M̂⁻¹ − M̂⁻¹ Ḡᵀ S⁻¹ Ḡ M̂⁻¹,     v_free  →  v_free + M̂⁻¹ Ḡᵀ S⁻¹ (c − Ḡ v_free)
//! ```
//!
//! the remaining rows are again a cone problem, W = H P Hᵀ symmetric and positive semidefinite, for any solver. The
//! right side is c = −((1−θ)/θ) Ḡ v_k, so that Ḡ v_{k+θ} = 0: joints do no work in the balance (56), whatever θ and λ,
//! as Frémond's law would have it. Ḡ is the discrete derivative of φ over the step; that step is an unknown, and
//! iterated for.

use nalgebra::SVector;

use super::delassus::Assembler;
use crate::cone::BlockMatrix;
use crate::linalg::{BlockRows, Factor, Multifrontal, SolveBuffers, axpy, max_abs};
use crate::scalar::{Scalar, lit};
use crate::system::MechanicalSystem;

/// Ḡ, S and its factors; without rows, nothing.
#[derive(Debug)]
pub(super) struct Joints<T: Scalar> {
    count: usize,
    rows: BlockRows<T, 1>,
    assembler: Assembler<T, 1>,
    schur: BlockMatrix<T, 1>,
    values: Vec<T>,
    active: Vec<bool>,
    factor: Multifrontal<T>,
    buffers: SolveBuffers<T>,
    multipliers: Vec<T>,
    reaction: Vec<T>,
    /// φ(q_k) and φ(q_{k+1}).
    residual: [Vec<T>; 2],
    step: Vec<T>,
}

impl<T: Scalar> Joints<T> {
    pub(super) fn new(count: usize, dofs: usize) -> Self {
        let zeros = |n: usize| vec![T::zero(); n];
        let used = if count == 0 { 0 } else { dofs };
        Self {
            count,
            rows: BlockRows::new(),
            assembler: Assembler::new(used, used),
            schur: BlockMatrix::new(),
            values: zeros(0),
            active: vec![true; count],
            factor: Multifrontal::new(),
            buffers: SolveBuffers::default(),
            multipliers: zeros(count),
            reaction: zeros(used),
            residual: [zeros(count), zeros(count)],
            step: zeros(used),
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Sets Ḡ(q, h v) and factors S.
    ///
    /// # Errors
    /// The row at which S is singular.
    pub(super) fn set<const D: usize, S: MechanicalSystem<T, D>>(
        &mut self,
        system: &S,
        q: &[T],
        (h, v): (T, &[T]),
        mass: &mut Factor<T>,
    ) -> Result<(), usize> {
        self.step.iter_mut().zip(v).for_each(|(s, &v)| *s = h * v);
        self.rows.clear();
        system.joint_jacobian(q, &self.step, &mut self.rows);
        self.assembler.assemble(&self.rows, mass, &mut self.schur);
        let (starts, columns) = self.schur.pattern();
        self.factor.analyse(starts, columns, 1);
        self.values.clear();
        self.values.extend(self.schur.blocks().iter().map(|block| block[(0, 0)]));
        self.factor.factor(&self.values, &self.active)
    }

    /// Takes v to the velocity with Ḡ v = `bias` Ḡ `other`, `bias` given by a degree of freedom of the row, by λ ← S⁻¹ (…), v ← v + M̂⁻¹ Ḡᵀ λ.
    ///
    /// # Errors
    /// The row that is not met: S is singular to rounding, the joints are redundant.
    pub(super) fn project(
        &mut self,
        mass: &mut Factor<T>,
        v: &mut [T],
        bias: impl Fn(usize) -> T,
        other: &[T],
    ) -> Result<(), usize> {
        let wanted = |rows: &BlockRows<T, 1>, i: usize| {
            rows.row(i).next().map_or_else(T::zero, |(dof, _)| bias(dof) * rows.velocity(i, other)[0])
        };
        for i in 0..self.count {
            self.multipliers[i] = wanted(&self.rows, i) - self.rows.velocity(i, v)[0];
        }
        // Far above the rounding of a solve, far below the velocities themselves; of what hangs at rest all are gone after it.
        let before = max_abs(v);
        self.react(mass, v);
        let bound = lit::<T>(1e-6) * (before + max_abs(v) + max_abs(other));
        let missed =
            |i: usize| nalgebra::ComplexField::abs(wanted(&self.rows, i) - self.rows.velocity(i, v)[0]);
        match (0..self.count).find(|&i| !(missed(i) <= bound)) {
            Some(row) => Err(row),
            None => Ok(()),
        }
    }

    /// x ← P f for x = M̂⁻¹ f.
    pub(super) fn constrain(&mut self, mass: &mut Factor<T>, x: &mut [T]) {
        for i in 0..self.count {
            self.multipliers[i] = -self.rows.velocity(i, x)[0];
        }
        self.react(mass, x);
    }

    /// x ← x + M̂⁻¹ Ḡᵀ S⁻¹ λ.
    fn react(&mut self, mass: &mut Factor<T>, x: &mut [T]) {
        self.factor.solve(&mut self.multipliers, &mut self.buffers);
        self.reaction.fill(T::zero());
        for (i, &multiplier) in self.multipliers.iter().enumerate() {
            self.rows.add_transpose(i, &SVector::<T, 1>::new(multiplier), &mut self.reaction);
        }
        mass.solve_in_place(&mut self.reaction);
        axpy(x, T::one(), &self.reaction);
    }

    /// Takes what a motion from `from` to `to`, along the joints to first order, has opened: Newton's iteration with the rows
    /// of the step, until rounding is left or nothing is gained.
    pub(super) fn close<const D: usize, S: MechanicalSystem<T, D>>(
        &mut self,
        system: &S,
        mass: &mut Factor<T>,
        (from, to): (&[T], &mut [T]),
        scratch: &mut [T],
    ) {
        let mut last = T::infinity_impl();
        loop {
            let (open, _) = self.opening(system, from, to);
            if !(open < last * lit::<T>(0.5)) {
                return;
            }
            last = open;
            for i in 0..self.count {
                self.multipliers[i] = self.residual[0][i] - self.residual[1][i];
            }
            scratch.fill(T::zero());
            self.react(mass, scratch);
            axpy(to, T::one(), scratch);
        }
    }

    /// max |φ(q_{k+1}) − φ(q_k)|, and the row.
    pub(super) fn opening<const D: usize, S: MechanicalSystem<T, D>>(
        &mut self,
        system: &S,
        q: &[T],
        next: &[T],
    ) -> (T, usize) {
        let [before, after] = &mut self.residual;
        system.joint_residual(q, before);
        system.joint_residual(next, after);
        let mut worst = (T::zero(), 0);
        for (i, (a, b)) in after.iter().zip(before.iter()).enumerate() {
            let opening = nalgebra::ComplexField::abs(*a - *b);
            // Written so that a NaN is the worst.
            if !(opening <= worst.0) {
                worst = (opening, i);
            }
        }
        worst
    }
}
