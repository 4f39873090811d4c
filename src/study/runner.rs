//! The steps of one run, of one length or under error control.

use std::sync::atomic::AtomicBool;

use super::plan::Job;
use crate::adaptive::Adaptive;
use crate::laws::ContactLaw as _;
use crate::observe::{Observer, RunInfo};
use crate::scalar::Scalar;
use crate::scene::{Planar, PlanarAdaptive, SceneError, build};
use crate::scheme::Snapshot;
use crate::simulate::{Outcome, SimulateError, advance, advance_adaptively, begin};

/// A run that is ready to start.
pub(super) enum Runner<T: Scalar, const D: usize> {
    Fixed { scheme: Box<Planar<T, D>>, start: Box<Snapshot>, steps: usize },
    Adaptive(Box<PlanarAdaptive<T, D>>),
}

impl<T: Scalar, const D: usize> Runner<T, D> {
    /// The run of a job.
    pub(super) fn new(job: &Job) -> Result<Self, SceneError> {
        let scheme = build::<T, D>(&job.scene, &job.run)?;
        Ok(match job.scene.time.adaptive_settings() {
            None => {
                let start = Box::new(scheme.snapshot());
                Self::Fixed { scheme: Box::new(scheme), start, steps: job.run.steps }
            }
            Some(settings) => Self::Adaptive(Box::new(Adaptive::new(scheme, settings)?)),
        })
    }

    /// Back to the start.
    pub(super) fn rewind(&mut self, job: &Job) -> Result<(), String> {
        match self {
            Self::Fixed { scheme, start, .. } => scheme.restore(start).map_err(|error| error.to_string()),
            // What error control has learnt is part of a run.
            Self::Adaptive(_) => {
                *self = Self::new(job).map_err(|error| error.to_string())?;
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
        let scheme = match self {
            Self::Fixed { scheme, .. } => scheme,
            Self::Adaptive(driver) => driver.scheme(),
        };
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
        match self {
            Self::Fixed { scheme, steps, .. } => advance(scheme, *steps, observers, stop),
            Self::Adaptive(driver) => {
                let end = driver.settings().end;
                advance_adaptively(driver, end, observers, stop)
            }
        }
    }
}
