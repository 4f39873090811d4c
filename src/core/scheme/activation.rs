//! The active set: which candidate contacts enter the cone problem of a step.

use crate::scalar::{Scalar, epsilon, lit};
use crate::system::Scales;

/// The rule of the active set.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "scene", derive(serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum ActivationRule {
    /// The paper's rule (55): g^α(q_k + h v_k) ≤ 0 and u^α_{N,k} ≤ 0. Default.
    ///
    /// A contact that lifts off within round-off of rest leaves the active set and falls back in the next step. With
    /// θ = ½ and e < 1 a body at rest under gravity so creeps into its support, at (gh/2)(1−e)/(1+e), and a pile of
    /// rolling bodies does not come to rest: take [`PredictedGap`](Self::PredictedGap) for those.
    #[default]
    MoreauJean,
    /// g^α(q_k + h v_k) ≤ 0 alone. It keeps a contact that slides on a convex obstacle, which (55) drops every other
    /// step because H(q_k) v_k ≠ 0 there, and bodies come to rest under it. With Frémond's law it stays dissipative;
    /// with Newton's a separating contact may be given positive normal work.
    PredictedGap,
    /// g^α(q_k) ≤ 0 alone: contacts that are closed at the start of the step.
    CurrentGap,
}

/// The rule with its tolerances: a contact is active where gap ≤ `gap_tolerance` and, under (55),
/// u_N ≤ `velocity_tolerance`.
///
/// Both must be positive: taken literally, the rule lets round-off decide whether a resting contact is there. The
/// default is 1e-12 (64 ε for scalars that cannot resolve it) times the length and the speed of the scene; the one on
/// velocities is at least ten times what the cone solver may leave, its tolerance times the speed: a closed contact
/// has u_N = 0 to that accuracy and no better.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Activation<T> {
    /// The rule.
    pub rule: ActivationRule,
    /// Tolerance on the gap (m); `None` scales with the scene.
    pub gap_tolerance: Option<T>,
    /// Tolerance on the normal velocity (m/s); `None` scales with the scene. Below what the solver leaves, closed contacts
    /// drop out at random and energies are wrong without any number showing it: the sliding block at a solver's tolerance
    /// of 1e-10 and 1e-10 mm/ms here ends a fifth of its run with twice its energy under `proximal-newton`.
    pub velocity_tolerance: Option<T>,
}

impl<T> Default for Activation<T> {
    fn default() -> Self {
        Self { rule: ActivationRule::default(), gap_tolerance: None, velocity_tolerance: None }
    }
}

impl<T: Scalar> Activation<T> {
    /// A rule with tolerances that scale with the scene.
    pub fn new(rule: ActivationRule) -> Self {
        Self { rule, ..Self::default() }
    }

    /// (gap tolerance, velocity tolerance) in a scene of the given scales with a solver of the given tolerance.
    pub(super) fn tolerances(&self, scales: Scales<T>, solver_tolerance: T) -> (T, T) {
        let floor = lit::<T>(64.0) * epsilon::<T>();
        let relative = nalgebra::RealField::max(lit::<T>(1e-12), floor);
        let left = nalgebra::RealField::max(relative, lit::<T>(10.0) * solver_tolerance);
        (
            self.gap_tolerance.unwrap_or(relative * scales.length),
            self.velocity_tolerance.unwrap_or(left * scales.speed),
        )
    }
}
