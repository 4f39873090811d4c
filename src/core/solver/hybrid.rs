//! The default solver: accelerated Gauss–Seidel first, proximal Newton for what is left.

use nalgebra::SVector;

use super::anderson::MAX_DEPTH;
use super::cone_solver::{Description, Iteration, Method};
use super::control::Control;
use super::error::Breakdown;
use super::newton::{Plan, ProximalPoint};
use super::settings::{SettingsError, setters};
use super::sweeps::{Accelerated, Patience, Sweep};
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
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct HybridSettings {
    /// Largest number of sweeps before Newton; `None` (default) takes 16 per stored block and contact, between 20
    /// and 400.
    pub sweeps: Option<usize>,
}

setters!(HybridSettings: with_sweeps(sweeps: Option<usize>));

/// The cascade: Gauss–Seidel sweeps with Anderson acceleration while they gain, then the proximal point with
/// semismooth Newton ([`ProximalNewton`](super::ProximalNewton)) from where they stopped.
///
/// Easy problems end in the sweeps, at the price of a few gathers; hard ones get a start with mostly the right
/// statuses. One iteration is a sweep or a Newton step, default budget 6,000 of these. Choose it unless you know better.
#[derive(Debug, Clone)]
pub struct Hybrid<T: Scalar, const D: usize> {
    settings: HybridSettings,
    sweeps: Accelerated<T, D>,
    newton: ProximalPoint<T, D>,
}

impl<T: Scalar, const D: usize> Method<T, D> for Hybrid<T, D> {
    const DESCRIPTION: Description = Description {
        name: "hybrid",
        title: "accelerated Gauss–Seidel, then proximal Newton",
        when: "always, unless you know better (default)",
        reference: "Acary, Brémond, Huber (2018), doi:10.1007/978-3-319-75972-2_10",
        iteration: Iteration::Factorisation,
    };
    type Settings = HybridSettings;

    fn new(settings: HybridSettings) -> Result<Self, SettingsError> {
        Ok(Self { settings, sweeps: Accelerated::new(MAX_DEPTH), newton: ProximalPoint::new() })
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
            return self.newton.run(problem, r, &Plan::default(), 0, control);
        }
        let warm = m >= WARM_CONTACTS && start <= lit::<T>(WARM_RESIDUAL);
        let (sweeps, proximal) = if warm { (sweeps.min(4), Some(lit::<T>(1e-6))) } else { (sweeps, None) };
        let patience = Patience { sweeps: sweeps.min(control.max_iterations(sweeps)), stalled: STALLED };
        let swept = self.sweeps.run(problem, r, Sweep::Forward, patience, control);
        // A single contact is solved exactly: what is left is rounding, or no solution exists.
        if swept.residual <= control.tolerance() || m == 1 {
            return Ok(swept.iterations);
        }
        let plan = Plan { proximal, ..Plan::default() };
        self.newton.run(problem, r, &plan, swept.iterations, control)
    }

    fn workspace(&mut self) -> Option<&mut Workspace<T>> {
        Some(self.sweeps.workspace())
    }
}
