//! θ of a run: as the scene says, or as its laws want it.

use super::build::AnyLaw;
use super::{Scene, SceneError};
use crate::registry::Registry;

/// θ of a scene without laws that want another: the only one of second order.
const THETA: f64 = 0.5;

/// θ and the ends of an interval are rounded: 1/(1+e) typed by hand must pass.
const SLACK: f64 = 4.0 * f64::EPSILON;

impl Scene {
    /// θ of the runs under a law: that of the scene, or where it has none the nearest to ½ for which all laws of the run are
    /// proved dissipative.
    ///
    /// # Errors
    /// [`SceneError::Law`]; [`SceneError::UnprovedTheta`] where the scene's θ is outside the interval of a law,
    /// [`SceneError::NoTheta`] where no θ is inside that of each, unless the scene allows it.
    pub(super) fn theta(&self, run_law: &str, registry: &Registry) -> Result<f64, SceneError> {
        let time = &self.time;
        if time.allow_unproved_theta {
            return Ok(time.theta.unwrap_or(THETA));
        }
        let mut narrowest: Option<(f64, f64)> = None;
        for interface in &self.interfaces {
            let law: AnyLaw<f64, 2> = interface.law_of(run_law, registry)?;
            let Some(claimed) = law.dissipative_theta() else { continue };
            let (min, max) = (*claimed.start(), *claimed.end());
            let (law, interface) = (law.name().to_string(), interface.label());
            if let Some(theta) = time.theta
                && (0.0..=1.0).contains(&theta)
                && !(min - SLACK..=max + SLACK).contains(&theta)
            {
                return Err(SceneError::UnprovedTheta { interface, law, theta, min, max });
            }
            let (low, high) = narrowest.unwrap_or((min, max));
            if time.theta.is_none() && (min > high + SLACK || max < low - SLACK) {
                return Err(SceneError::NoTheta { interface, law, min, max, low, high });
            }
            narrowest = Some((low.max(min), high.min(max)));
        }
        Ok(time.theta.unwrap_or_else(|| narrowest.map_or(THETA, |(low, high)| THETA.max(low).min(high))))
    }
}
