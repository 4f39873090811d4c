//! Nonsmooth Gauss–Seidel: one contact after another, each solved exactly.

use nalgebra::SVector;

use super::anderson::{Anderson, MAX_DEPTH};
use super::gauss_seidel::GaussSeidel;
use super::{Breakdown, ConeSolver, Control, Description, Family, Stopping};
use crate::cone::{ConeProblem, Residual, Workspace, project};
use crate::scalar::{Scalar, lit};

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

/// Settings of [`Nsgs`].
#[derive(Debug, Clone)]
pub struct NsgsSettings<T> {
    /// Tolerance and budget; the default budget is 100,000 sweeps.
    pub stopping: Stopping<T>,
    /// Order of the sweeps. Default: forward.
    pub sweep: Sweep,
    /// Depth of Anderson acceleration, 0 for none, at most 10 (more is taken as 10). Default 10.
    pub acceleration: usize,
}

impl<T: Scalar> Default for NsgsSettings<T> {
    fn default() -> Self {
        Self { stopping: Stopping::default(), sweep: Sweep::default(), acceleration: MAX_DEPTH }
    }
}

/// Nonsmooth Gauss–Seidel: for α = 1…m, r_α ← the exact solution of w_α = W_αα r_α + (b_α + Σ_{β≠α} W_αβ r_β),
/// optionally with Anderson acceleration between the sweeps.
///
/// Choose it for few contacts, or for a good warm start at moderate accuracy: a sweep is cheap and allocates
/// nothing, but the number of sweeps grows with the length of contact chains (walls of more than 1,000 contacts
/// stall at 2e-3).
#[derive(Debug, Clone)]
pub struct Nsgs<T: Scalar, const D: usize> {
    settings: NsgsSettings<T>,
    core: Accelerated<T, D>,
}

impl<T: Scalar, const D: usize> Nsgs<T, D> {
    /// The solver with its settings.
    pub fn new(settings: NsgsSettings<T>) -> Self {
        let core = Accelerated::new(settings.acceleration);
        Self { settings, core }
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
        let sweeps = control.max_iterations(100_000);
        Ok(self.core.run(problem, r, self.settings.sweep, Patience::endless(sweeps), control).iterations)
    }

    fn workspace(&mut self) -> Option<&mut Workspace<T>> {
        Some(self.core.workspace())
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
    fn endless(sweeps: usize) -> Self {
        Self { sweeps, stalled: usize::MAX }
    }
}

/// How a run of sweeps ended.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run<T> {
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
    ) -> Run<T> {
        self.sweeps.prepare(problem);
        if r.len() == 1 {
            // The sweep is the solution.
            self.sweeps.sweep(problem, r, false);
            let residual = self.sweeps.scaled_residual(problem, r);
            control.proceed(1, residual);
            return Run { iterations: 1, residual };
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
                    r.iter_mut().zip(problem.friction()).for_each(|(r, &mu)| *r = project(r, mu));
                }
            }
        }
        r.copy_from_slice(&self.best);
        Run { iterations, residual: best }
    }
}
