//! From a scene and a run to its event-driven motion.

use super::build::{AnyLaw, AnySystem, parts, stopping};
use super::{PlannedRun, Scene, SceneError};
use crate::event_driven::{EventError, Motion, Settings, integrate};
use crate::registry::Registry;
use crate::solver::ConeSolver;

/// The event-driven integration of a run, ready to start at time 0.
#[derive(Debug)]
pub struct EventDriven<const D: usize> {
    system: AnySystem<f64, D>,
    laws: Vec<AnyLaw<f64, D>>,
    solver: Box<dyn ConeSolver<f64, D>>,
    q: Vec<f64>,
    v: Vec<f64>,
    end: f64,
}

impl<const D: usize> EventDriven<D> {
    /// The system, for the names of its contacts and degrees of freedom.
    pub fn system(&self) -> &AnySystem<f64, D> {
        &self.system
    }

    /// The motion from 0 to the end of the run.
    ///
    /// # Errors
    /// As [`integrate`].
    pub fn integrate(self, settings: &Settings) -> Result<Motion, EventError> {
        let Self { system, laws, solver, q, v, end } = self;
        integrate(system, laws, solver, 0.0, q, v, end, settings)
    }
}

/// Builds the event-driven integration of a run: what [`build`](super::build()) builds a scheme of. θ, the time step and
/// the rule of the active set have no part in it, nor has the scalar type.
///
/// # Errors
/// [`SceneError`] naming what is wrong and its value.
pub fn event_driven<const D: usize>(
    scene: &Scene,
    run: &PlannedRun,
    registry: &Registry,
) -> Result<EventDriven<D>, SceneError> {
    let (system, laws, q, v) = parts(scene, run, registry)?;
    let solver = registry.build_solver(&run.solver, stopping(scene))?;
    Ok(EventDriven { system, laws, solver, q, v, end: scene.time.end })
}
