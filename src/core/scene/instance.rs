//! The one place that chooses the compiled arithmetic and contact dimension of a run.

use super::{PlannedRun, ScalarName, Scene, SceneError, build, event_driven};
use crate::event_driven::{EventError, Motion, Settings};
use crate::registry::Registry;
use crate::scalar::{lit, to_f64};
use crate::scheme::ThetaScheme;
use crate::simulate::{Compiled, Simulated, Simulation, Stepper};
use crate::solver::default_tolerance;

/// What is to be done in the arithmetic and the contact dimension of a run, see [`in_kind`].
pub trait InKind {
    /// What comes of it.
    type Output;

    /// Does it in the arithmetic T with contacts of dimension D.
    fn with<T: Compiled<D>, const D: usize>(self) -> Self::Output;
}

/// Does something in the arithmetic of this name with contacts of this dimension: 1, 2, or else 3.
pub fn in_kind<W: InKind>(scalar: ScalarName, dimension: usize, what: W) -> W::Output {
    match (scalar, dimension) {
        (ScalarName::F64, 1) => what.with::<f64, 1>(),
        (ScalarName::F64, 2) => what.with::<f64, 2>(),
        (ScalarName::F64, _) => what.with::<f64, 3>(),
        (ScalarName::F32, 1) => what.with::<f32, 1>(),
        (ScalarName::F32, 2) => what.with::<f32, 2>(),
        (ScalarName::F32, _) => what.with::<f32, 3>(),
    }
}

/// What a run is built from.
struct Parts<'a> {
    scene: &'a Scene,
    run: &'a PlannedRun,
    registry: &'a Registry,
}

/// A simulation of the parts.
struct Simulate<'a>(Parts<'a>);

impl InKind for Simulate<'_> {
    type Output = Result<Box<dyn Simulation>, SceneError>;

    fn with<T: Compiled<D>, const D: usize>(self) -> Self::Output {
        let Parts { scene, run, registry } = self.0;
        let scheme: ThetaScheme<T, D> = build(scene, run, registry)?;
        let stepper = Stepper::new(scheme, scene.time.adaptive_settings())?;
        let simulated = Simulated::new(stepper, &run.law, &run.solver);
        Ok(match run.last_step {
            Some(length) => Box::new(simulated.with_last_step(run.steps.saturating_sub(1), lit(length))),
            None => Box::new(simulated),
        })
    }
}

/// The event-driven motion of the parts.
struct Follow<'a>(Parts<'a>, &'a Settings);

impl InKind for Follow<'_> {
    type Output = Result<Result<Motion, EventError>, SceneError>;

    fn with<T: Compiled<D>, const D: usize>(self) -> Self::Output {
        let Parts { scene, run, registry } = self.0;
        Ok(event_driven::<D>(scene, run, registry)?.integrate(self.1))
    }
}

/// The name of an arithmetic, and the tolerance a solver has in it by default.
struct Facts;

impl InKind for Facts {
    type Output = (&'static str, f64);

    fn with<T: Compiled<D>, const D: usize>(self) -> Self::Output {
        (T::NAME, to_f64(default_tolerance::<T>()))
    }
}

impl ScalarName {
    /// The name: `f64` or `f32`.
    pub fn name(self) -> &'static str {
        in_kind(self, 1, Facts).0
    }

    /// Tolerance of solvers on the scaled residual where a scene gives none (dimensionless).
    pub fn default_tolerance(self) -> f64 {
        in_kind(self, 1, Facts).1
    }
}

impl Scene {
    /// A run of the scene, ready to start, in the scene's arithmetic and with contacts of `dimension`
    /// ([`contact_dimension`](super::contact_dimension)).
    ///
    /// # Errors
    /// [`SceneError`] naming what is wrong and its value.
    pub fn simulation(
        &self,
        run: &PlannedRun,
        dimension: usize,
        registry: &Registry,
    ) -> Result<Box<dyn Simulation>, SceneError> {
        in_kind(self.scalar, dimension, Simulate(Parts { scene: self, run, registry }))
    }

    /// The event-driven motion of a run, with contacts of `dimension`; the inner error is that of the integration.
    ///
    /// # Errors
    /// [`SceneError`] naming what is wrong and its value.
    pub fn motion(
        &self,
        run: &PlannedRun,
        dimension: usize,
        registry: &Registry,
        settings: &Settings,
    ) -> Result<Result<Motion, EventError>, SceneError> {
        // The motion is in double precision, whatever the arithmetic of the runs.
        in_kind(ScalarName::F64, dimension, Follow(Parts { scene: self, run, registry }, settings))
    }
}
