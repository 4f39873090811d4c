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

/// Sweeps before the price of a Newton step is asked, and sweeps without a gain of 0.7 after which it is.
const FIRST_SWEEPS: usize = 20;
const STALLED: usize = 10;
/// Most sweeps.
const MOST_SWEEPS: usize = 6_000;

/// What things cost, in nanoseconds of one machine; only ratios count. A contact in a sweep and in a Newton step, a block
/// of W in a sweep, a floating-point operation of a factorisation.
const PER_CONTACT: (f64, f64) = (80.0, 700.0);
const PER_BLOCK: f64 = 3.0;
const PER_OPERATION: f64 = 0.1;

/// Within this scaled residual a start is left to the proximal Newton method, which stays near it: sweeps, and a smaller
/// proximal term, wander among the percussions that redundant contacts allow.
const NEAR_RESIDUAL: f64 = 1e-5;

/// Settings of [`Hybrid`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct HybridSettings {
    /// Largest number of sweeps before Newton; `None` (default) sweeps for as long as five Newton steps would take, 20
    /// sweeps at least, and on where their rate promises the solution within the time of thirty.
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
        // A start that is nearly right has its statuses: Newton finishes it in a few steps with little proximal term.
        let cold = r.iter().all(|r| *r == SVector::<T, D>::zeros());
        self.sweeps.prepare(problem);
        let start = if cold || m == 1 { T::infinity_impl() } else { self.sweeps.residual(problem, r) };
        if start <= lit::<T>(NEAR_RESIDUAL) {
            return self.newton.run(problem, r, &Plan::default(), 0, control);
        }
        let Self { sweeps, newton, settings } = self;
        let most = control.max_iterations(MOST_SWEEPS);
        let mut price = || {
            let sweep = m as f64 * PER_CONTACT.0 + blocks as f64 * PER_BLOCK;
            let step = newton.operations(problem) * PER_OPERATION + m as f64 * PER_CONTACT.1;
            // Saturates.
            (step / sweep) as usize
        };
        let patience = match settings.sweeps {
            Some(sweeps) => Patience { sweeps, stalled: STALLED, price: None, most: sweeps.min(most) },
            None => Patience { sweeps: FIRST_SWEEPS, stalled: STALLED, price: Some(&mut price), most },
        };
        let swept = sweeps.run(problem, (r, start), Sweep::Forward, patience, control);
        // A single contact is solved exactly: what is left is rounding, or no solution exists.
        if swept.residual <= control.tolerance() || m == 1 {
            return Ok(swept.iterations);
        }
        newton.run(problem, r, &Plan::default(), swept.iterations, control)
    }

    fn workspace(&mut self) -> Option<&mut Workspace<T>> {
        Some(self.sweeps.workspace())
    }
}
