//! Semismooth Newton on the whole problem, with a line search and a proximal fallback.

use nalgebra::SVector;

use super::cone_solver::{Description, Iteration, Method};
use super::control::Control;
use super::error::Breakdown;
use super::newton::{Formulation, Plan, ProximalPoint};
use super::settings::{Interval, SettingsError, setters};
use crate::cone::{ConeProblem, Workspace};
use crate::scalar::{Scalar, lit};

/// Settings of [`SemismoothNewton`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SemismoothNewtonSettings<T> {
    /// The nonsmooth equation. Default: Alart–Curnier.
    pub formulation: Formulation,
    /// Newton steps on the problem itself before the proximal fallback (count). Default 30; 0 goes straight to
    /// the proximal point method.
    pub direct_steps: usize,
    /// First proximal weight a₀ of the fallback, relative to λ_max(W_αα) = 1 (dimensionless, in ]0, 10]). Default 1e-4.
    pub proximal_weight: T,
    /// Whether the fallback may run. Default true; without it a stagnation ends the solve.
    pub fallback: bool,
}

impl<T: Scalar> Default for SemismoothNewtonSettings<T> {
    fn default() -> Self {
        let formulation = Formulation::default();
        Self { formulation, direct_steps: 30, proximal_weight: lit(1e-4), fallback: true }
    }
}

setters!(SemismoothNewtonSettings<T>:
    with_formulation(formulation: Formulation),
    with_direct_steps(direct_steps: usize),
    with_proximal_weight(proximal_weight: T),
    with_fallback(fallback: bool),
);

/// Semismooth Newton: F(r) = 0 with F the [`Formulation`] of every contact on the problem scaled to
/// λ_max(W_αα) = 1, the Newton system
///
/// ```text
///   Σ_β C_α W_αβ dr_β + (A_α + a C_α) dr_α = −F_α,     dF = A dr + C dw
/// ```
///
/// and a non-monotone line search on ½‖F‖². With a = 0 in F and a few ε in the matrix (so that redundant contacts,
/// which leave W singular, still have a step) it converges quadratically near a solution; where it stagnates the
/// fallback solves w + a (r − r_k) in place of w for a decreasing a, r_k being the last iterate (proximal point;
/// Acary, Brémond & Huber 2018, doi:10.1007/978-3-319-75972-2_10), in turn with both formulations and from other
/// starts, until the budget of Newton steps ends.
///
/// Choose it for accuracy on up to a few thousand contacts; the cost is one factorisation per step, and the default budget
/// 6,000 steps.
#[derive(Debug, Clone)]
pub struct SemismoothNewton<T: Scalar, const D: usize> {
    plan: Plan<T>,
    core: ProximalPoint<T, D>,
}

impl<T: Scalar, const D: usize> Method<T, D> for SemismoothNewton<T, D> {
    const DESCRIPTION: Description = Description {
        name: "newton",
        title: "semismooth Newton (Alart–Curnier or natural map) with a line search and a proximal fallback",
        when: "accuracy on up to a few thousand contacts, redundant contacts included",
        reference: "Alart & Curnier (1991), doi:10.1016/0045-7825(91)90022-X",
        iteration: Iteration::Factorisation,
    };
    type Settings = SemismoothNewtonSettings<T>;

    fn new(settings: SemismoothNewtonSettings<T>) -> Result<Self, SettingsError> {
        let SemismoothNewtonSettings { formulation, direct_steps, proximal_weight, fallback } = settings;
        Interval::LeftOpen(0.0, 10.0).check("proximal_weight", proximal_weight)?;
        let plan = Plan { formulation, direct_steps, fallback, proximal: Some(proximal_weight) };
        Ok(Self { plan, core: ProximalPoint::new() })
    }

    fn iterate(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        control: &mut Control<'_, T>,
    ) -> Result<usize, Breakdown> {
        self.core.run(problem, r, &self.plan, 0, control)
    }

    fn workspace(&mut self) -> Option<&mut Workspace<T>> {
        Some(self.core.workspace())
    }
}
