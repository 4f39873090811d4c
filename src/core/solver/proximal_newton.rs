//! Proximal point with a semismooth Newton inside: the solver for hard and large problems.

use nalgebra::SVector;

use super::cone_solver::{Description, Iteration, Method};
use super::control::Control;
use super::error::Breakdown;
use super::newton::{Plan, ProximalPoint};
use super::settings::{Interval, SettingsError, setters};
use crate::cone::{ConeProblem, Workspace};
use crate::scalar::Scalar;

/// Settings of [`ProximalNewton`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ProximalNewtonSettings<T> {
    /// First proximal parameter a, dimensionless (against λ_max(W_αα) = 1), in ]0, 10]. `None` (default) takes 1e-4,
    /// or 1e-2 above 5,000 contacts.
    pub proximal: Option<T>,
}

impl<T> Default for ProximalNewtonSettings<T> {
    fn default() -> Self {
        Self { proximal: None }
    }
}

setters!(ProximalNewtonSettings<T>: with_proximal(proximal: Option<T>));

/// Proximal point algorithm r_{k+1} = solution of w = W r + b + a (r − r_k), each subproblem by semismooth Newton on
/// the Alart–Curnier map, in units where every λ_max(W_αα) is 1.
///
/// The parameter a falls after quick successes and rises after failures; small a with the right statuses is the
/// quadratic finish. One iteration is one Newton step: one factorisation of a matrix with the pattern of W;
/// default budget 6,000. Choose it
/// for hard problems (W singular, chains of contacts) and high accuracy.
#[derive(Debug, Clone)]
pub struct ProximalNewton<T: Scalar, const D: usize> {
    settings: ProximalNewtonSettings<T>,
    core: ProximalPoint<T, D>,
}

impl<T: Scalar, const D: usize> Method<T, D> for ProximalNewton<T, D> {
    const DESCRIPTION: Description = Description {
        name: "proximal-newton",
        title: "proximal point with semismooth Newton on the Alart–Curnier map",
        when: "hard problems (singular W, chains of contacts) and high accuracy",
        reference: "Alart and Curnier (1991), doi:10.1016/0045-7825(91)90022-X; Rockafellar (1976), doi:10.1137/0314056",
        iteration: Iteration::Factorisation,
    };
    type Settings = ProximalNewtonSettings<T>;

    fn new(settings: ProximalNewtonSettings<T>) -> Result<Self, SettingsError> {
        settings.proximal.map_or(Ok(()), |a| Interval::LeftOpen(0.0, 10.0).check("proximal", a))?;
        Ok(Self { settings, core: ProximalPoint::new() })
    }

    fn iterate(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        control: &mut Control<'_, T>,
    ) -> Result<usize, Breakdown> {
        let plan = Plan { proximal: self.settings.proximal, ..Plan::default() };
        self.core.run(problem, r, &plan, 0, control)
    }

    fn workspace(&mut self) -> Option<&mut Workspace<T>> {
        Some(self.core.workspace())
    }
}
