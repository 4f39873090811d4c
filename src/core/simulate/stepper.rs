//! The steps of a run, of one length or under error control.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use super::{Ended, SimulateError};
use crate::adaptive::{Adaptive, AdaptiveError, AdaptiveSettings};
use crate::observe::{Frame, ObserveError, Observer, RunInfo};
use crate::scalar::Scalar;
use crate::scheme::ThetaScheme;

/// Observers of a run, told of it in their order.
type Observers<'a, 'b, T, const D: usize> = &'a mut [&'b mut dyn Observer<T, D>];

/// What makes the steps of a run.
///
/// [`run`](Self::run) makes all of them; who stops in between calls [`begin`](Self::begin), [`advance`](Self::advance) any
/// number of times, and [`end`](Self::end).
#[derive(Debug)]
pub enum Stepper<T: Scalar, const D: usize> {
    /// Steps of one length.
    Fixed(Box<ThetaScheme<T, D>>),
    /// Steps under error control.
    Adaptive(Box<Adaptive<T, D>>),
}

impl<T: Scalar, const D: usize> From<ThetaScheme<T, D>> for Stepper<T, D> {
    /// Steps of one length.
    fn from(scheme: ThetaScheme<T, D>) -> Self {
        Self::Fixed(Box::new(scheme))
    }
}

impl<T: Scalar, const D: usize> Stepper<T, D> {
    /// Takes a scheme over, under error control where there are settings for it.
    ///
    /// # Errors
    /// [`AdaptiveError`] of [`Adaptive::new`].
    pub fn new(
        scheme: ThetaScheme<T, D>,
        control: Option<AdaptiveSettings<T>>,
    ) -> Result<Self, AdaptiveError> {
        Ok(match control {
            None => scheme.into(),
            Some(settings) => Self::Adaptive(Box::new(Adaptive::new(scheme, settings)?)),
        })
    }

    /// The scheme.
    pub fn scheme(&self) -> &ThetaScheme<T, D> {
        match self {
            Self::Fixed(scheme) => scheme,
            Self::Adaptive(driver) => driver.scheme(),
        }
    }

    /// The scheme, to be restored; `None` under error control, which keeps what it knows of its state.
    pub fn fixed(&mut self) -> Option<&mut ThetaScheme<T, D>> {
        match self {
            Self::Fixed(scheme) => Some(scheme),
            Self::Adaptive(_) => None,
        }
    }

    /// Makes `steps` fixed steps, or under error control all steps to the end, unless `interrupt` is raised before, and
    /// tells the observers of the beginning, each step and the end.
    ///
    /// # Errors
    /// [`SimulateError`]; the observers' `end` has then been called all the same.
    pub fn run(
        &mut self,
        steps: usize,
        run: &RunInfo,
        observers: Observers<'_, '_, T, D>,
        interrupt: &AtomicBool,
    ) -> Result<Ended, SimulateError> {
        self.begin(run, observers)?;
        let ended = self.advance(steps, observers, interrupt);
        let told = self.end(observers);
        let ended = ended?;
        told?;
        Ok(ended)
    }

    /// Tells the observers that a run begins.
    ///
    /// # Errors
    /// [`ObserveError`].
    pub fn begin(&self, run: &RunInfo, observers: Observers<'_, '_, T, D>) -> Result<(), ObserveError> {
        tell(frame(self.scheme()), observers, |observer, frame| observer.begin(run, frame))
    }

    /// Makes `steps` fixed steps, or under error control all steps to the end, unless `interrupt` is raised before, and
    /// tells the observers of each.
    ///
    /// # Errors
    /// [`SimulateError`].
    pub fn advance(
        &mut self,
        steps: usize,
        observers: Observers<'_, '_, T, D>,
        interrupt: &AtomicBool,
    ) -> Result<Ended, SimulateError> {
        match self {
            Self::Fixed(scheme) => {
                for _ in 0..steps {
                    if interrupt.load(Ordering::Relaxed) {
                        return Ok(Ended::Interrupted);
                    }
                    scheme.step()?;
                    tell(frame(scheme), observers, |observer, frame| observer.step(frame))?;
                }
                Ok(Ended::Completed)
            }
            Self::Adaptive(driver) => to_the_end(driver, observers, interrupt),
        }
    }

    /// Tells the observers that the run is over.
    ///
    /// # Errors
    /// [`ObserveError`].
    pub fn end(&self, observers: Observers<'_, '_, T, D>) -> Result<(), ObserveError> {
        tell(frame(self.scheme()), observers, |observer, frame| observer.end(frame))
    }
}

fn to_the_end<T: Scalar, const D: usize>(
    driver: &mut Adaptive<T, D>,
    observers: Observers<'_, '_, T, D>,
    interrupt: &AtomicBool,
) -> Result<Ended, SimulateError> {
    if interrupt.load(Ordering::Relaxed) {
        return Ok(Ended::Interrupted);
    }
    let time = driver.settings().end;
    let ended = driver.advance_to(time, |system, state, step| {
        match tell(Frame { system, state, step }, observers, |observer, frame| observer.step(frame)) {
            Err(error) => ControlFlow::Break(Err(error)),
            Ok(()) if interrupt.load(Ordering::Relaxed) => ControlFlow::Break(Ok(Ended::Interrupted)),
            Ok(()) => ControlFlow::Continue(()),
        }
    })?;
    match ended {
        ControlFlow::Continue(()) => Ok(Ended::Completed),
        ControlFlow::Break(ended) => Ok(ended?),
    }
}

fn frame<T: Scalar, const D: usize>(scheme: &ThetaScheme<T, D>) -> Frame<'_, T, D> {
    Frame { system: scheme.system(), state: scheme.state(), step: scheme.last_step() }
}

/// Tells every observer, even after one failed, and returns the first failure.
fn tell<T: Scalar, const D: usize>(
    frame: Frame<'_, T, D>,
    observers: Observers<'_, '_, T, D>,
    mut message: impl FnMut(&mut dyn Observer<T, D>, Frame<'_, T, D>) -> Result<(), ObserveError>,
) -> Result<(), ObserveError> {
    let mut first = Ok(());
    for observer in observers {
        let told = message(*observer, frame);
        first = first.and(told);
    }
    first
}
