//! One Gauss–Seidel sweep, with what it remembers from one sweep to the next.

use nalgebra::SVector;

use crate::cone::{ConeProblem, largest_eigenvalue, solve_one_contact_from};
use crate::scalar::Scalar;

/// Sweeps over a problem: for every contact r_α ← the exact solution of w_α = W_αα r_α + (b_α + Σ_{β≠α} W_αβ r_β).
#[derive(Debug, Clone)]
pub(super) struct GaussSeidel<T> {
    /// λ_max(W_αα), one per contact.
    sizes: Vec<T>,
    /// The slip's α = −w_T/r_T of the last sweep, one per contact: where the next root-finder starts.
    slips: Vec<T>,
}

impl<T: Scalar> GaussSeidel<T> {
    pub(super) fn new() -> Self {
        Self { sizes: Vec::new(), slips: Vec::new() }
    }

    /// Reads the diagonal of W; allocates only where the problem is larger than any before.
    pub(super) fn prepare<const D: usize>(&mut self, problem: &ConeProblem<T, D>) {
        let m = problem.contacts();
        self.sizes.clear();
        self.sizes.extend((0..m).map(|i| largest_eigenvalue(problem.diagonal(i))));
        self.slips.clear();
        self.slips.resize(m, T::zero());
    }

    pub(super) fn sizes(&self) -> &[T] {
        &self.sizes
    }

    /// One sweep; returns Σ ‖λ_max(W_αα) Δr_α‖², what the sweep changed as a velocity squared.
    pub(super) fn sweep<const D: usize>(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        reverse: bool,
    ) -> T {
        let m = r.len();
        if reverse {
            (0..m).rev().fold(T::zero(), |change, i| change + self.visit(problem, r, i))
        } else {
            (0..m).fold(T::zero(), |change, i| change + self.visit(problem, r, i))
        }
    }

    #[inline(always)]
    fn visit<const D: usize>(&mut self, problem: &ConeProblem<T, D>, r: &mut [SVector<T, D>], i: usize) -> T {
        let old = r[i];
        let block = problem.diagonal(i);
        let others = problem.shifted_velocity(i, r) - block * old;
        let next = solve_one_contact_from(block, &others, problem.friction()[i], &mut self.slips[i]);
        r[i] = next;
        ((next - old) * self.sizes[i]).norm_squared()
    }
}
