//! Gauss–Seidel sweeps with Anderson acceleration between them, until the tolerance or the end of patience.

use nalgebra::SVector;

use super::anderson::Anderson;
use super::control::Control;
use super::gauss_seidel::GaussSeidel;
use crate::cone::{ConeProblem, Residual, Workspace, project};
use crate::scalar::{Scalar, lit};

/// Order in which a sweep visits the contacts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Sweep {
    /// First to last (default).
    #[default]
    Forward,
    /// Last to first.
    Reverse,
    /// Forward, then reverse, in turn.
    Symmetric,
}

impl Sweep {
    /// Whether sweep number `sweep` (from 1) runs from the last contact to the first.
    fn is_reverse(self, sweep: usize) -> bool {
        match self {
            Self::Forward => false,
            Self::Reverse => true,
            Self::Symmetric => sweep.is_multiple_of(2),
        }
    }
}

/// Accelerated sweeps without a gain of 0.7 that are taken for a cycle.
const CYCLE: usize = 100;

/// When [`Accelerated::run`] gives up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patience {
    /// Largest number of sweeps.
    pub(super) sweeps: usize,
    /// Sweeps without a gain of 0.7 after which it stops.
    pub(super) stalled: usize,
}

impl Patience {
    pub(super) fn endless(sweeps: usize) -> Self {
        Self { sweeps, stalled: usize::MAX }
    }
}

/// How a run of sweeps ended.
#[derive(Debug, Clone, Copy)]
pub(super) struct SweepsEnd<T> {
    pub(super) iterations: usize,
    /// Scaled residual of the iterate returned.
    pub(super) residual: T,
}

/// Sweeps with Anderson acceleration that return the best iterate met.
#[derive(Debug, Clone)]
pub(super) struct Accelerated<T: Scalar, const D: usize> {
    sweeps: GaussSeidel<T, D>,
    anderson: Anderson<T, SVector<T, D>>,
    accelerated: bool,
    from: Vec<SVector<T, D>>,
    best: Vec<SVector<T, D>>,
}

impl<T: Scalar, const D: usize> Accelerated<T, D> {
    pub(super) fn new(depth: usize) -> Self {
        let anderson = Anderson::new(depth);
        Self {
            sweeps: GaussSeidel::new(),
            anderson,
            accelerated: depth > 0,
            from: Vec::new(),
            best: Vec::new(),
        }
    }

    /// [`ConeProblem::residual`], in the workspace of the sweeps.
    pub(super) fn residual(&mut self, problem: &ConeProblem<T, D>, r: &[SVector<T, D>]) -> Residual<T> {
        self.sweeps.residual(problem, r)
    }

    pub(super) fn workspace(&mut self) -> &mut Workspace<T> {
        self.sweeps.workspace()
    }

    /// Sweeps until the tolerance or the end of patience; `r` is left at the best iterate measured.
    pub(super) fn run(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        order: Sweep,
        patience: Patience,
        control: &mut Control<'_, T>,
    ) -> SweepsEnd<T> {
        self.sweeps.prepare(problem);
        if r.len() == 1 {
            // The sweep is the solution.
            self.sweeps.sweep(problem, r, false);
            let residual = self.sweeps.scaled_residual(problem, r);
            control.proceed(1, residual);
            return SweepsEnd { iterations: 1, residual };
        }
        if self.accelerated {
            self.anderson.prepare(r.len());
        }
        self.from.resize(r.len(), SVector::zeros());
        self.best.clear();
        self.best.extend_from_slice(r);
        let b_norm = problem.b_norm();
        let tolerance = control.tolerance();
        let mut best = self.sweeps.scaled_residual(problem, r);
        // The change of a sweep bounds the residual only loosely, so the residual decides, and is measured where the
        // change promises it, and from time to time.
        let (mut trigger, mut next_check) = (tolerance, 4);
        let (mut mark, mut since) = (T::infinity_impl(), 0);
        // Acceleration can cycle; plain sweeps leave the cycle, and are given twice as long each time.
        let (mut plain_until, mut plain) = (0, CYCLE);
        let mut iterations = 0;
        for sweep in 1..=patience.sweeps {
            if best <= tolerance {
                break;
            }
            iterations = sweep;
            if self.accelerated {
                self.from.copy_from_slice(r);
            }
            let change = self.sweeps.sweep(problem, r, order.is_reverse(sweep));
            let estimate = nalgebra::ComplexField::sqrt(change) / b_norm;
            let go_on = control.proceed(sweep, estimate);
            if estimate < mark * lit::<T>(0.7) {
                (mark, since) = (estimate, 0);
            } else {
                since += 1;
            }
            let last = !go_on || sweep == patience.sweeps || since > patience.stalled;
            if estimate <= trigger || sweep >= next_check || last {
                let residual = self.sweeps.scaled_residual(problem, r);
                if residual < best {
                    best = residual;
                    self.best.copy_from_slice(r);
                }
                next_check = sweep + 8 + sweep / 2;
                let needed = estimate * tolerance / residual;
                trigger = if needed < tolerance { needed } else { tolerance };
            }
            if last || !(estimate < T::infinity_impl()) {
                break;
            }
            if self.accelerated && since >= CYCLE && sweep >= plain_until {
                self.anderson.forget();
                (plain_until, plain) = (sweep + plain, 2 * plain);
                (mark, since) = (T::infinity_impl(), 0);
            }
            if self.accelerated && sweep >= plain_until {
                // Contact α weighs λ_max(W_αα), so that the iterates do not depend on the units.
                let weights = self.sweeps.sizes().iter().copied();
                if self.anderson.accelerate(&self.from, r, weights) {
                    r.iter_mut().zip(problem.cones()).for_each(|(r, &cone)| *r = project(r, cone));
                }
            }
        }
        r.copy_from_slice(&self.best);
        SweepsEnd { iterations, residual: best }
    }
}
