//! One run of a study: its errors, then its time.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use cpu_time::ThreadTime;
use serde::{Deserialize, Serialize};

use super::errors::{ErrorRecorder, Errors, Norm};
use super::job::Job;
use super::reference::Reference;
use super::runner::{Runner, RunnerError};
use crate::observe::{Frame, ObserveError, Observer};
use crate::registry::Registry;
use crate::scalar::Scalar;
use crate::simulate::Ended;

/// What came of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunOutcome {
    /// Whether the run reached its end.
    pub ok: bool,
    /// Why it did not.
    pub message: String,
    /// Steps made.
    pub steps: usize,
    /// Iterations of the cone solver.
    pub iterations: usize,
    /// Distances from the reference.
    pub errors: Errors,
    /// CPU time of the thread over the steps (s), the least of `repeats` runs without observers.
    pub cpu_seconds: f64,
    /// Wall time of that run (s).
    pub wall_seconds: f64,
    /// Runs timed.
    pub repeats: usize,
}

/// Timed runs of one setting at most.
const MOST_REPEATS: usize = 1000;

/// Steps and iterations of a run.
#[derive(Default)]
struct Counter {
    steps: usize,
    iterations: usize,
}

impl<T: Scalar, const D: usize> Observer<T, D> for Counter {
    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        self.steps += 1;
        self.iterations += frame.step.solution.as_ref().map_or(0, |solution| solution.iterations);
        Ok(())
    }
}

/// Makes the run of a job, then again until `least` seconds are timed; `None` where it was interrupted.
pub(super) fn measure(
    registry: &Registry,
    job: &Job,
    reference: &Arc<dyn Reference>,
    least: f64,
    stop: &AtomicBool,
) -> Option<RunOutcome> {
    let mut counter = Counter::default();
    match try_measure(registry, job, reference, least, stop, &mut counter) {
        Ok(outcome) => outcome,
        Err(error) => Some(RunOutcome {
            ok: false,
            message: error.to_string().split_whitespace().collect::<Vec<_>>().join(" "),
            steps: counter.steps,
            iterations: counter.iterations,
            errors: Errors::UNKNOWN,
            cpu_seconds: f64::NAN,
            wall_seconds: f64::NAN,
            repeats: 0,
        }),
    }
}

fn try_measure(
    registry: &Registry,
    job: &Job,
    reference: &Arc<dyn Reference>,
    least: f64,
    stop: &AtomicBool,
    counter: &mut Counter,
) -> Result<Option<RunOutcome>, RunnerError> {
    let mut runner = Runner::new(job, registry)?;
    let norm = if job.scene.solid.is_some() { Norm::RootMeanSquare } else { Norm::Largest };
    let mut recorder = ErrorRecorder::new(Arc::clone(reference), norm, job.scene.time.end);
    if runner.first(&mut [&mut recorder, counter], stop)? == Ended::Interrupted {
        return Ok(None);
    }

    let (mut cpu_seconds, mut wall_seconds, mut total, mut repeats) = (f64::INFINITY, f64::INFINITY, 0.0, 0);
    while repeats == 0 || (total < least && repeats < MOST_REPEATS) {
        runner.rewind(job, registry)?;
        let (cpu, wall) = (ThreadTime::now(), Instant::now());
        let ended = runner.advance(&mut [], stop);
        let (cpu, wall) = (cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64());
        if ended? == Ended::Interrupted {
            return Ok(None);
        }
        if cpu < cpu_seconds {
            (cpu_seconds, wall_seconds) = (cpu, wall);
        }
        total += cpu;
        repeats += 1;
    }
    Ok(Some(RunOutcome {
        ok: true,
        message: String::new(),
        steps: counter.steps,
        iterations: counter.iterations,
        errors: recorder.errors(),
        cpu_seconds,
        wall_seconds,
        repeats,
    }))
}
