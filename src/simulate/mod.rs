//! The loop over steps, with observers and an orderly end.

mod stepper;

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

pub use stepper::Stepper;

use crate::adaptive::{Adaptive, AdaptiveError};
use crate::observe::{Frame, ObserveError, Observer, RunInfo};
use crate::scalar::Scalar;
use crate::scheme::{StepError, ThetaScheme};

/// How a run ended that nothing went wrong in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Every step was made.
    Completed,
    /// The interrupt flag was raised; what was done is recorded.
    Interrupted,
}

/// Why a run ended early. The observers were told of the end, so that nothing computed is lost.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimulateError {
    /// A step could not be made.
    #[error(transparent)]
    Step(#[from] StepError),
    /// A step under error control could not be made.
    #[error(transparent)]
    Adaptive(#[from] AdaptiveError),
    /// An output could not be written.
    #[error(transparent)]
    Observe(#[from] ObserveError),
}

/// Makes `steps` steps, unless `interrupt` is raised before, and tells the observers of each.
///
/// # Errors
/// [`SimulateError`]; the observers' `end` has then been called all the same.
pub fn simulate<T: Scalar, const D: usize>(
    scheme: &mut ThetaScheme<T, D>,
    steps: usize,
    run: &RunInfo,
    observers: &mut [&mut dyn Observer<T, D>],
    interrupt: &AtomicBool,
) -> Result<Outcome, SimulateError> {
    begin(scheme, run, observers)?;
    let outcome = advance(scheme, steps, observers, interrupt);
    let ended = end(scheme, observers);
    let outcome = outcome?;
    ended?;
    Ok(outcome)
}

/// Tells the observers that a run begins. [`simulate`] in pieces, for who stops between: one `begin`, any number of
/// [`advance`], one [`end`].
///
/// # Errors
/// [`ObserveError`].
pub fn begin<T: Scalar, const D: usize>(
    scheme: &ThetaScheme<T, D>,
    run: &RunInfo,
    observers: &mut [&mut dyn Observer<T, D>],
) -> Result<(), ObserveError> {
    tell(frame(scheme), observers, |observer, frame| observer.begin(run, frame))
}

/// Makes `steps` steps, unless `interrupt` is raised before, and tells the observers of each.
///
/// # Errors
/// [`SimulateError`].
pub fn advance<T: Scalar, const D: usize>(
    scheme: &mut ThetaScheme<T, D>,
    steps: usize,
    observers: &mut [&mut dyn Observer<T, D>],
    interrupt: &AtomicBool,
) -> Result<Outcome, SimulateError> {
    for _ in 0..steps {
        if interrupt.load(Ordering::Relaxed) {
            return Ok(Outcome::Interrupted);
        }
        scheme.step()?;
        tell(frame(scheme), observers, |observer, frame| observer.step(frame))?;
    }
    Ok(Outcome::Completed)
}

/// Tells the observers that the run is over.
///
/// # Errors
/// [`ObserveError`].
pub fn end<T: Scalar, const D: usize>(
    scheme: &ThetaScheme<T, D>,
    observers: &mut [&mut dyn Observer<T, D>],
) -> Result<(), ObserveError> {
    tell(frame(scheme), observers, |observer, frame| observer.end(frame))
}

/// Steps under error control until `time`, unless `interrupt` is raised before, and tells the observers of each step kept.
/// Between [`begin`] and [`end`] of its scheme, as [`advance`] is for fixed steps.
///
/// # Errors
/// [`SimulateError`].
pub fn advance_adaptively<T: Scalar, const D: usize>(
    driver: &mut Adaptive<T, D>,
    time: T,
    observers: &mut [&mut dyn Observer<T, D>],
    interrupt: &AtomicBool,
) -> Result<Outcome, SimulateError> {
    if interrupt.load(Ordering::Relaxed) {
        return Ok(Outcome::Interrupted);
    }
    let ended = driver.advance_to(time, |system, state, step| {
        match tell(Frame { system, state, step }, observers, |observer, frame| observer.step(frame)) {
            Err(error) => ControlFlow::Break(Err(error)),
            Ok(()) if interrupt.load(Ordering::Relaxed) => ControlFlow::Break(Ok(Outcome::Interrupted)),
            Ok(()) => ControlFlow::Continue(()),
        }
    })?;
    match ended {
        ControlFlow::Continue(()) => Ok(Outcome::Completed),
        ControlFlow::Break(ended) => Ok(ended?),
    }
}

fn frame<T: Scalar, const D: usize>(scheme: &ThetaScheme<T, D>) -> Frame<'_, T, D> {
    Frame { system: scheme.system(), state: scheme.state(), step: scheme.last_step() }
}

/// Tells every observer, even after one failed, and returns the first failure.
fn tell<T: Scalar, const D: usize>(
    frame: Frame<'_, T, D>,
    observers: &mut [&mut dyn Observer<T, D>],
    mut message: impl FnMut(&mut dyn Observer<T, D>, Frame<'_, T, D>) -> Result<(), ObserveError>,
) -> Result<(), ObserveError> {
    let mut first = Ok(());
    for observer in observers {
        let told = message(*observer, frame);
        first = first.and(told);
    }
    first
}
