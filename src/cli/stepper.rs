//! The scheme of a run, with fixed steps or under error control.

use std::sync::atomic::AtomicBool;

use nonsmooth::adaptive::Adaptive;
use nonsmooth::observe::{AdaptiveSummary, Observer, RunSummary};
use nonsmooth::scalar::{Scalar, to_f64};
use nonsmooth::scene::{Planar, PlanarAdaptive, SceneError, TimeSpec};
use nonsmooth::simulate::{Outcome, SimulateError, advance, advance_adaptively};

/// What makes the steps of a run.
pub(super) enum Stepper<T: Scalar, const D: usize> {
    Fixed(Box<Planar<T, D>>),
    Adaptive(Box<PlanarAdaptive<T, D>>),
}

impl<T: Scalar, const D: usize> Stepper<T, D> {
    pub(super) fn new(scheme: Planar<T, D>, time: &TimeSpec) -> Result<Self, SceneError> {
        Ok(match time.adaptive_settings() {
            None => Self::Fixed(Box::new(scheme)),
            Some(settings) => Self::Adaptive(Box::new(Adaptive::new(scheme, settings)?)),
        })
    }

    pub(super) fn scheme(&self) -> &Planar<T, D> {
        match self {
            Self::Fixed(scheme) => scheme,
            Self::Adaptive(driver) => driver.scheme(),
        }
    }

    /// The scheme, to be asked or restored; error control keeps what it knows of its state.
    pub(super) fn fixed(&mut self) -> Option<&mut Planar<T, D>> {
        match self {
            Self::Fixed(scheme) => Some(scheme),
            Self::Adaptive(_) => None,
        }
    }

    /// Makes `steps` fixed steps, or all steps under error control.
    pub(super) fn advance(
        &mut self,
        steps: usize,
        observers: &mut [&mut dyn Observer<T, D>],
        interrupt: &AtomicBool,
    ) -> Result<Outcome, SimulateError> {
        match self {
            Self::Fixed(scheme) => advance(scheme, steps, observers, interrupt),
            Self::Adaptive(driver) => {
                let end = driver.settings().end;
                advance_adaptively(driver, end, observers, interrupt)
            }
        }
    }

    /// Adds what error control made of a run to its summary.
    pub(super) fn describe(&self, summary: &mut RunSummary) {
        let Self::Adaptive(driver) = self else { return };
        let report = driver.report();
        if summary.steps > 0 {
            summary.step = to_f64(driver.scheme().state().time) / summary.steps as f64;
        }
        summary.adaptive = Some(AdaptiveSummary {
            tolerance: to_f64(driver.settings().tolerance),
            accepted: report.accepted,
            rejected: report.rejected,
            computed: report.computed,
            events: report.events,
            estimated_error: to_f64(report.estimated_error),
            smallest_step: to_f64(report.smallest_step),
            largest_step: to_f64(report.largest_step),
        });
    }
}
