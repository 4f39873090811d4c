//! The steps of one run, which can be made again.

use std::sync::atomic::AtomicBool;

use super::plan::Job;
use crate::laws::ContactLaw as _;
use crate::observe::{Observer, RunInfo};
use crate::registry::Registry;
use crate::scalar::Scalar;
use crate::scene::{PlanarStepper, SceneError, build};
use crate::scheme::Snapshot;
use crate::simulate::{Outcome, SimulateError, Stepper, begin};

/// A run that is ready to start.
pub(super) struct Runner<T: Scalar, const D: usize> {
    stepper: PlanarStepper<T, D>,
    start: Snapshot,
    steps: usize,
}

impl<T: Scalar, const D: usize> Runner<T, D> {
    /// The run of a job.
    pub(super) fn new(job: &Job, registry: &Registry) -> Result<Self, SceneError> {
        let scheme = build::<T, D>(&job.scene, &job.run, registry)?;
        let start = scheme.snapshot();
        let stepper = Stepper::new(scheme, job.scene.time.adaptive_settings())?;
        Ok(Self { stepper, start, steps: job.run.steps })
    }

    /// Back to the start.
    pub(super) fn rewind(&mut self, job: &Job, registry: &Registry) -> Result<(), String> {
        match self.stepper.fixed() {
            Some(scheme) => scheme.restore(&self.start).map_err(|error| error.to_string()),
            // What error control has learnt is part of a run.
            None => {
                *self = Self::new(job, registry).map_err(|error| error.to_string())?;
                Ok(())
            }
        }
    }

    /// Tells the observers that the run begins.
    pub(super) fn begin(
        &self,
        job: &Job,
        observers: &mut [&mut dyn Observer<T, D>],
    ) -> Result<(), SimulateError> {
        let scheme = self.stepper.scheme();
        let laws = scheme.laws().iter().map(|law| law.name().to_string()).collect();
        let info = RunInfo::new(&job.run.law, &job.run.solver, laws, scheme.settings());
        Ok(begin(scheme, &info, observers)?)
    }

    /// Runs from the start to the end.
    pub(super) fn advance(
        &mut self,
        observers: &mut [&mut dyn Observer<T, D>],
        stop: &AtomicBool,
    ) -> Result<Outcome, SimulateError> {
        self.stepper.advance(self.steps, observers, stop)
    }
}
