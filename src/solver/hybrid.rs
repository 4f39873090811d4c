//! The default solver: accelerated Gauss–Seidel first, proximal Newton for what is left.

use nalgebra::SVector;

use super::anderson::MAX_DEPTH;
use super::nsgs::{Accelerated, Patience, Sweep};
use super::proximal_newton::ProximalPoint;
use super::{Breakdown, ConeSolver, Control, Description, Family, Stopping};
use crate::cone::{ConeProblem, Workspace};
use crate::scalar::{Scalar, lit};

/// Checks without a gain of 0.7 after which the sweeps hand over.
const STALLED: usize = 10;

/// From this many contacts on, sweeps are skipped where the start is within this scaled residual of a solution.
const WARM_CONTACTS: usize = 50;
const WARM_RESIDUAL: f64 = 0.1;

/// Within this scaled residual a start is left to the proximal Newton method, which stays near it: sweeps, and a smaller
/// proximal term, wander among the percussions that redundant contacts allow.
const NEAR_RESIDUAL: f64 = 1e-5;

/// Settings of [`Hybrid`].
#[derive(Debug, Clone)]
pub struct HybridSettings<T> {
    /// Tolerance and budget; the default budget is 6,000 Newton steps.
    pub stopping: Stopping<T>,
    /// Largest number of sweeps before Newton; `None` (default) takes 16 per stored block and contact, between 20
    /// and 400.
    pub sweeps: Option<usize>,
}

impl<T: Scalar> Default for HybridSettings<T> {
    fn default() -> Self {
        Self { stopping: Stopping::default(), sweeps: None }
    }
}

/// The cascade: Gauss–Seidel sweeps with Anderson acceleration while they gain, then the proximal point with
/// semismooth Newton ([`ProximalNewton`](super::ProximalNewton)) from where they stopped.
///
/// Easy problems end in the sweeps, at the price of a few gathers; hard ones get a start with mostly the right
/// statuses. One iteration is a sweep or a Newton step. Choose it unless you know better.
#[derive(Debug, Clone)]
pub struct Hybrid<T: Scalar, const D: usize> {
    settings: HybridSettings<T>,
    sweeps: Accelerated<T, D>,
    newton: ProximalPoint<T, D>,
}

impl<T: Scalar, const D: usize> Hybrid<T, D> {
    /// The solver with its settings.
    pub fn new(settings: HybridSettings<T>) -> Self {
        Self { settings, sweeps: Accelerated::new(MAX_DEPTH), newton: ProximalPoint::new() }
    }
}

impl<T: Scalar, const D: usize> Family<T> for Hybrid<T, D> {
    const DESCRIPTION: Description = Description {
        name: "hybrid",
        title: "accelerated Gauss–Seidel, then proximal Newton",
        when: "always, unless you know better (default)",
        reference: "Acary, Brémond, Huber (2018), doi:10.1007/978-3-319-75972-2_10",
    };

    fn with_stopping(stopping: Stopping<T>) -> Self {
        Self::new(HybridSettings { stopping, ..HybridSettings::default() })
    }
}

impl<T: Scalar, const D: usize> ConeSolver<T, D> for Hybrid<T, D> {
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
        let (m, blocks) = (problem.contacts(), problem.delassus().blocks());
        let sweeps = self.settings.sweeps.unwrap_or_else(|| (16 * blocks / m).clamp(20, 400));
        // A start that is nearly right has its statuses: Newton finishes it in a few steps with little proximal term.
        let cold = r.iter().all(|r| *r == SVector::<T, D>::zeros());
        let start = if cold || m == 1 { T::infinity_impl() } else { self.sweeps.residual(problem, r).scaled };
        if start <= lit::<T>(NEAR_RESIDUAL) {
            return self.newton.run(problem, r, None, 0, control);
        }
        let warm = m >= WARM_CONTACTS && start <= lit::<T>(WARM_RESIDUAL);
        let (sweeps, proximal) = if warm { (sweeps.min(4), Some(lit::<T>(1e-6))) } else { (sweeps, None) };
        let patience = Patience { sweeps: sweeps.min(control.max_iterations(sweeps)), stalled: STALLED };
        let run = self.sweeps.run(problem, r, Sweep::Forward, patience, control);
        // A single contact is solved exactly: what is left is rounding, or no solution exists.
        if run.residual <= control.tolerance() || m == 1 {
            return Ok(run.iterations);
        }
        self.newton.run(problem, r, proximal, run.iterations, control)
    }

    fn workspace(&mut self) -> Option<&mut Workspace<T>> {
        Some(self.sweeps.workspace())
    }
}
