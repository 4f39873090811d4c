//! The progress bar, where there is a terminal.

use crate::observe::{Frame, ObserveError, Observer};
use crate::scalar::{Scalar, to_f64};
use indicatif::{ProgressBar, ProgressStyle};

/// Parts of the time of a run, and steps between two looks at it.
const THOUSANDTHS: u64 = 1000;
const EVERY: usize = 100;

/// A bar over the runs of a study.
pub(super) fn runs_bar(runs: usize) -> ProgressBar {
    let bar = ProgressBar::new(runs as u64);
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len} runs, {eta} left") {
        bar.set_style(style);
    }
    bar
}

/// Shows the steps of a run; hidden where the error stream is not a terminal.
pub(super) struct StepBar {
    bar: ProgressBar,
    every: usize,
    /// End of the run (s), where its length is known in time alone.
    end: Option<f64>,
}

impl StepBar {
    pub(super) fn new(label: String, steps: usize) -> Self {
        let bar = ProgressBar::new(steps as u64).with_message(label);
        let template = "{msg:24} {wide_bar} {pos}/{len} steps, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Self { bar, every: (steps / 500).max(1), end: None }
    }

    /// Shows the time reached, in thousandths of `end` (s).
    pub(super) fn over_time(label: String, end: f64) -> Self {
        let bar = ProgressBar::new(THOUSANDTHS).with_message(label);
        if let Ok(style) =
            ProgressStyle::with_template("{msg:24} {wide_bar} {percent} % of the time, {eta} left")
        {
            bar.set_style(style);
        }
        Self { bar, every: EVERY, end: Some(end) }
    }
}

impl<T: Scalar, const D: usize> Observer<T, D> for StepBar {
    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        if frame.state.index.is_multiple_of(self.every) {
            self.bar.set_position(match self.end {
                None => frame.state.index as u64,
                Some(end) => (to_f64(frame.state.time) / end * THOUSANDTHS as f64) as u64,
            });
        }
        Ok(())
    }

    fn end(&mut self, _frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        self.bar.finish_and_clear();
        Ok(())
    }
}
