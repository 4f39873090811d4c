//! The steps of one run, of one length or under error control.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use super::plan::Job;
use super::settings::Stepping;
use crate::adaptive::{Adaptive, AdaptiveSettings};
use crate::laws::ContactLaw;
use crate::observe::{Frame, Observer, RunInfo};
use crate::scalar::{Scalar, lit};
use crate::scene::{Planar, build};
use crate::scheme::Snapshot;
use crate::simulate::{self, Outcome, advance, simulate};
use crate::solver::ConeSolver;
use crate::system::MechanicalSystem;

/// The scheme of a scene under error control.
type Controlled<T, const D: usize> =
    Adaptive<T, D, Box<dyn MechanicalSystem<T, D>>, Box<dyn ContactLaw<T, D>>, Box<dyn ConeSolver<T, D>>>;

/// A run that is ready to start.
pub(super) enum Runner<T: Scalar, const D: usize> {
    Fixed { scheme: Box<Planar<T, D>>, start: Snapshot, steps: usize },
    Adaptive { run: Box<Controlled<T, D>>, end: T },
}

impl<T: Scalar, const D: usize> Runner<T, D> {
    /// The run of a job.
    pub(super) fn new(job: &Job) -> Result<Self, String> {
        let scheme = build::<T, D>(&job.scene, &job.run).map_err(|error| error.to_string())?;
        match job.settings.stepping {
            Stepping::Fixed(_) => {
                let start = scheme.snapshot();
                Ok(Self::Fixed { scheme: Box::new(scheme), start, steps: job.run.steps })
            }
            Stepping::Adaptive(tolerance) => {
                let end = lit(job.scene.time.end);
                let run = Adaptive::new(scheme, AdaptiveSettings::new(lit(tolerance), end));
                Ok(Self::Adaptive { run: Box::new(run.map_err(|error| error.to_string())?), end })
            }
        }
    }

    /// Back to the start.
    pub(super) fn rewind(&mut self, job: &Job) -> Result<(), String> {
        match self {
            Self::Fixed { scheme, start, .. } => scheme.restore(start).map_err(|error| error.to_string()),
            // What its controller has learnt is part of a run.
            Self::Adaptive { .. } => {
                *self = Self::new(job)?;
                Ok(())
            }
        }
    }

    /// Runs from the start to the end, and tells the observers.
    pub(super) fn observed(
        &mut self,
        job: &Job,
        observers: &mut [&mut dyn Observer<T, D>],
        stop: &AtomicBool,
    ) -> Result<Outcome, String> {
        let scheme = match self {
            Self::Fixed { scheme, .. } => &**scheme,
            Self::Adaptive { run, .. } => run.scheme(),
        };
        let laws = scheme.laws().iter().map(|law| law.name().to_string()).collect();
        let info = RunInfo::new(&job.run.law, &job.run.solver, laws, scheme.settings());
        match self {
            Self::Fixed { scheme, steps, .. } => {
                simulate(scheme, *steps, &info, observers, stop).map_err(|error| error.to_string())
            }
            Self::Adaptive { run, end } => {
                simulate::begin(run.scheme(), &info, observers).map_err(|error| error.to_string())?;
                let mut lost = None;
                let outcome = adapt(run, *end, stop, |frame| {
                    for observer in observers.iter_mut() {
                        lost = lost.take().or(observer.step(frame).err());
                    }
                });
                lost.map_or(outcome, |error| Err(error.to_string()))
            }
        }
    }

    /// Runs from the start to the end.
    pub(super) fn plain(&mut self, stop: &AtomicBool) -> Result<Outcome, String> {
        match self {
            Self::Fixed { scheme, steps, .. } => {
                advance(scheme, *steps, &mut [], stop).map_err(|error| error.to_string())
            }
            Self::Adaptive { run, end } => adapt(run, *end, stop, |_| {}),
        }
    }
}

/// Steps until `end`, unless `stop` is raised before.
fn adapt<T: Scalar, const D: usize>(
    run: &mut Controlled<T, D>,
    end: T,
    stop: &AtomicBool,
    mut each: impl FnMut(Frame<'_, T, D>),
) -> Result<Outcome, String> {
    let kept = run.advance_to(end, |system, state, step| {
        each(Frame { system, state, step });
        if stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    match kept.map_err(|error| error.to_string())? {
        ControlFlow::Continue(()) => Ok(Outcome::Completed),
        ControlFlow::Break(()) => Ok(Outcome::Interrupted),
    }
}
