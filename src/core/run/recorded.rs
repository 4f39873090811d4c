//! Runs of scenes in memory.

use std::sync::atomic::AtomicBool;

use crate::observe::{Recorder, Recording};
use crate::registry::Registry;
use crate::scene::{PlannedRun, Scene, SceneError, contact_dimension};
use crate::simulate::SimulateError;

/// Why the runs of a scene did not all come to their end.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum RunFailure {
    /// The scene cannot be built.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A run ended before its end time.
    #[error("{law} with {solver}: {source}")]
    Stopped {
        /// Law of the run.
        law: String,
        /// Its cone solver.
        solver: String,
        /// What was recorded before.
        recording: Box<Recording>,
        /// Why.
        source: Box<SimulateError>,
    },
}

impl Scene {
    /// Makes every run of the scene, every law with every solver, and returns what happened as arrays. The scene's
    /// `output.every` thins them.
    ///
    /// # Errors
    /// [`RunFailure`]: a scene that cannot be built, or the first run that ended early.
    pub fn run(&self, registry: &Registry) -> Result<Vec<Recording>, RunFailure> {
        let runs = self.runs(registry)?;
        let dimension = contact_dimension(self, &runs, registry)?;
        runs.iter().map(|run| self.record(run, dimension, registry)).collect()
    }

    fn record(
        &self,
        run: &PlannedRun,
        dimension: usize,
        registry: &Registry,
    ) -> Result<Recording, RunFailure> {
        let mut simulation = self.simulation(run, dimension, registry)?;
        let mut recorder = Recorder::new(self.output.trajectory_every());
        let ended = simulation.run(run.steps, &mut [&mut recorder], &AtomicBool::new(false));
        let recording = recorder.finish();
        match ended {
            Ok(_) => Ok(recording),
            Err(source) => Err(RunFailure::Stopped {
                law: run.law.clone(),
                solver: run.solver.clone(),
                recording: Box::new(recording),
                source: Box::new(source),
            }),
        }
    }
}
