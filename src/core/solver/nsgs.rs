//! Nonsmooth Gauss–Seidel: one contact after another, each solved exactly.

use nalgebra::SVector;

use super::anderson::MAX_DEPTH;
use super::cone_solver::{Description, Iteration, Method};
use super::control::Control;
use super::error::Breakdown;
use super::settings::{SettingsError, check_depth, setters};
use super::sweeps::{Accelerated, Patience, Sweep};
use crate::cone::{ConeProblem, Workspace};
use crate::scalar::Scalar;

/// Settings of [`Nsgs`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct NsgsSettings {
    /// Order of the sweeps. Default: forward.
    pub sweep: Sweep,
    /// Depth of Anderson acceleration, 0 for none, at most 10. Default 10.
    pub acceleration: usize,
}

impl Default for NsgsSettings {
    fn default() -> Self {
        Self { sweep: Sweep::default(), acceleration: MAX_DEPTH }
    }
}

setters!(NsgsSettings: with_sweep(sweep: Sweep), with_acceleration(acceleration: usize));

/// Nonsmooth Gauss–Seidel: for α = 1…m, r_α ← the exact solution of w_α = W_αα r_α + (b_α + Σ_{β≠α} W_αβ r_β),
/// optionally with Anderson acceleration between the sweeps.
///
/// Default budget: 100,000 sweeps. Choose it for few contacts, or for a good warm start at moderate accuracy: a sweep is cheap and allocates
/// nothing, but the number of sweeps grows with the length of contact chains (walls of more than 1,000 contacts
/// stall at 2e-3).
#[derive(Debug, Clone)]
pub struct Nsgs<T: Scalar, const D: usize> {
    settings: NsgsSettings,
    core: Accelerated<T, D>,
}

impl<T: Scalar, const D: usize> Method<T, D> for Nsgs<T, D> {
    const DESCRIPTION: Description = Description {
        name: "nsgs",
        title: "nonsmooth Gauss–Seidel with exact one-contact solutions",
        when: "few contacts, or a good warm start at moderate accuracy",
        reference: "Jean (1999), doi:10.1016/S0045-7825(98)00383-1",
        iteration: Iteration::Sweep,
    };
    type Settings = NsgsSettings;

    fn new(settings: NsgsSettings) -> Result<Self, SettingsError> {
        check_depth("acceleration", settings.acceleration)?;
        Ok(Self { settings, core: Accelerated::new(settings.acceleration) })
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
