//! Nonsmooth Gauss–Seidel: one contact after another, each solved exactly.

use nalgebra::SVector;

use super::{Breakdown, ConeSolver, Control, Description, Family, Stopping};
use crate::cone::{ConeProblem, largest_eigenvalue};
use crate::scalar::Scalar;

/// Order in which a sweep visits the contacts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Sweep {
    /// First to last (default).
    #[default]
    Forward,
    /// Last to first.
    Reverse,
    /// Forward, then reverse, in turn.
    Symmetric,
}

/// Settings of [`Nsgs`].
#[derive(Debug, Clone)]
pub struct NsgsSettings<T> {
    /// Tolerance and budget; the default budget is 100,000 sweeps.
    pub stopping: Stopping<T>,
    /// Order of the sweeps.
    pub sweep: Sweep,
}

impl<T: Scalar> Default for NsgsSettings<T> {
    fn default() -> Self {
        Self { stopping: Stopping::default(), sweep: Sweep::default() }
    }
}

/// Nonsmooth Gauss–Seidel: for α = 1…m, r_α ← the exact solution of w_α = W_αα r_α + (b_α + Σ_{β≠α} W_αβ r_β).
///
/// Choose it for few contacts, or for a good warm start at moderate accuracy: a sweep is cheap and allocates
/// nothing, but the number of sweeps grows with the length of contact chains.
#[derive(Debug, Clone)]
pub struct Nsgs<T: Scalar, const D: usize> {
    settings: NsgsSettings<T>,
}

impl<T: Scalar, const D: usize> Nsgs<T, D> {
    /// The solver with its settings.
    pub fn new(settings: NsgsSettings<T>) -> Self {
        Self { settings }
    }
}

impl<T: Scalar, const D: usize> Family<T> for Nsgs<T, D> {
    const DESCRIPTION: Description = Description {
        name: "nsgs",
        title: "nonsmooth Gauss–Seidel with exact one-contact solutions",
        when: "few contacts, or a good warm start at moderate accuracy",
        reference: "Jean (1999), doi:10.1016/S0045-7825(98)00383-1",
    };

    fn with_stopping(stopping: Stopping<T>) -> Self {
        Self::new(NsgsSettings { stopping, ..NsgsSettings::default() })
    }
}

impl<T: Scalar, const D: usize> ConeSolver<T, D> for Nsgs<T, D> {
    fn name(&self) -> &'static str {
        <Self as Family<T>>::DESCRIPTION.name
    }

    fn stopping(&self) -> &Stopping<T> {
        &self.settings.stopping
    }

    fn iterate(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        control: &mut Control<'_, T>,
    ) -> Result<usize, Breakdown> {
        let m = problem.contacts();
        let b_norm = problem.b_norm();
        for sweep in 1..=control.max_iterations(100_000) {
            let reverse = match self.settings.sweep {
                Sweep::Forward => false,
                Sweep::Reverse => true,
                Sweep::Symmetric => sweep % 2 == 0,
            };
            // Σ ‖λ_max(W_αα) Δr_α‖²: what the sweep changed, as a velocity.
            let mut change = T::zero();
            for k in 0..m {
                let i = if reverse { m - 1 - k } else { k };
                let next = problem.solve_contact(i, r);
                change += ((next - r[i]) * largest_eigenvalue(problem.diagonal(i))).norm_squared();
                r[i] = next;
            }
            // One contact is solved by its first sweep.
            if m == 1 {
                return Ok(sweep);
            }
            let estimate = nalgebra::ComplexField::sqrt(change) / b_norm;
            if !control.proceed(sweep, estimate) {
                return Ok(sweep);
            }
            // The change of a sweep bounds the residual only loosely, so the residual itself decides.
            if estimate <= control.tolerance() && problem.residual(r).scaled <= control.tolerance() {
                return Ok(sweep);
            }
        }
        Ok(control.max_iterations(100_000))
    }
}
