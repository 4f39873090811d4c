//! θ of a run: as the scene says, or as its laws want it.

use super::build::AnyLaw;
use super::{PlannedRun, Scene, SceneError};
use crate::registry::Registry;
use crate::scheme::{claim_slack, claims};

/// θ of a scene without laws that want another: the only one of second order.
const THETA: f64 = 0.5;

impl Scene {
    /// θ of the runs under a law: that of the scene, or where it has none the nearest to ½ for which all laws of the run are
    /// proved dissipative. Where there is none, or a law cannot be made, [`check_theta`](Self::check_theta) and whoever makes
    /// the laws say so.
    pub(super) fn theta(&self, run_law: &str, registry: &Registry) -> f64 {
        if let Some(theta) = self.time.theta {
            return theta;
        }
        if self.time.allow_unproved_theta {
            return THETA;
        }
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        for interface in self.all_interfaces() {
            let Ok(law) = interface.law_of::<f64, 2>(run_law, registry) else { continue };
            if let Some(claimed) = law.dissipative_theta() {
                (low, high) = (low.max(*claimed.start()), high.min(*claimed.end()));
            }
        }
        THETA.max(low).min(high)
    }

    /// Checks that θ of a run is one for which all its laws are proved dissipative, unless the scene allows others.
    ///
    /// # Errors
    /// [`SceneError::Law`]; [`SceneError::UnprovedTheta`] where the scene's θ is outside the interval of a law,
    /// [`SceneError::NoTheta`] where no θ is inside that of each.
    pub(super) fn check_theta(&self, run: &PlannedRun, registry: &Registry) -> Result<(), SceneError> {
        let (theta, (mut low, mut high)) = (run.theta, (0.0_f64, 1.0_f64));
        let slack = claim_slack::<f64>();
        // What is no θ at all the scheme refuses.
        if self.time.allow_unproved_theta || !(0.0..=1.0).contains(&theta) {
            return Ok(());
        }
        for spec in self.all_interfaces() {
            let law: AnyLaw<f64, 2> = spec.law_of(&run.law, registry)?;
            let Some(claimed) = law.dissipative_theta() else { continue };
            let (min, max) = (*claimed.start(), *claimed.end());
            let (law, interface) = (law.name().to_string(), spec.label());
            let is_given = self.time.theta.is_some();
            if is_given && !claims(&claimed, theta) {
                return Err(SceneError::UnprovedTheta { interface, law, theta, min, max });
            }
            if !is_given && (min > high + slack || max < low - slack) {
                return Err(SceneError::NoTheta { interface, law, min, max, low, high });
            }
            (low, high) = (low.max(min), high.min(max));
        }
        Ok(())
    }
}
