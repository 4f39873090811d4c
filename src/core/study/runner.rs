//! The steps of one run, which can be made again.

use std::sync::atomic::AtomicBool;

use super::job::Job;
use crate::registry::Registry;
use crate::scene::SceneError;
use crate::scheme::{RestoreError, Snapshot};
use crate::simulate::{Ended, SimulateError, Simulation, Sink};

/// A run that is ready to start.
pub(super) struct Runner {
    simulation: Box<dyn Simulation>,
    /// Where it starts; `None` under error control.
    start: Option<Snapshot>,
    steps: usize,
}

/// Why a run was not made.
#[derive(Debug, thiserror::Error)]
pub(super) enum RunnerError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    #[error(transparent)]
    Restore(#[from] RestoreError),
}

impl Runner {
    /// The run of a job.
    pub(super) fn new(job: &Job, registry: &Registry) -> Result<Self, SceneError> {
        let simulation = job.scene.simulation(&job.run, job.dimension, registry)?;
        let start = simulation.snapshot();
        Ok(Self { simulation, start, steps: job.run.steps })
    }

    /// Back to the start.
    pub(super) fn rewind(&mut self, job: &Job, registry: &Registry) -> Result<(), RunnerError> {
        match &self.start {
            Some(start) => self.simulation.restore(start)?,
            // What error control has learnt is part of a run.
            None => *self = Self::new(job, registry)?,
        }
        Ok(())
    }

    /// Runs from the start to the end, the sinks told of the beginning and of each step.
    pub(super) fn first(
        &mut self,
        sinks: &mut [&mut dyn Sink],
        stop: &AtomicBool,
    ) -> Result<Ended, SimulateError> {
        self.simulation.begin(sinks)?;
        self.advance(sinks, stop)
    }

    /// Runs from the start to the end.
    pub(super) fn advance(
        &mut self,
        sinks: &mut [&mut dyn Sink],
        stop: &AtomicBool,
    ) -> Result<Ended, SimulateError> {
        self.simulation.advance(self.steps, sinks, stop)
    }
}
