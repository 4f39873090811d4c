//! What the user chooses, and why a run under error control cannot be set up or go on.

use crate::scalar::{Scalar, all_finite, epsilon, lit, to_f64};
use crate::scheme::{SetupError, StepError};

/// Settings of a run under error control; see the [module](super) for what they mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdaptiveSettings<T> {
    /// ε, the error aimed at in q (L∞ over time) and v (L1 over time), as a share of the scene's length; in
    /// [4096 ε_machine, 0.5].
    pub tolerance: T,
    /// T, the end of the span that ε is meant for (s); > the time of the scheme.
    pub end: T,
    /// Length of the first step tried (s); by default a hundredth of the span.
    pub first_step: Option<T>,
    /// Smallest length of a step (s); by default 64 ε_machine of the span.
    pub min_step: Option<T>,
    /// Largest length of a step (s); by default a tenth of the span.
    pub max_step: Option<T>,
    /// Largest number of θ-steps computed, kept or not, in a thousandth of the span, ≥ 1; by default 500 000. A run that
    /// needs more ends with [`AdaptiveError::TooManySteps`].
    pub max_steps: usize,
}

/// θ-steps in a thousandth of the span: some ten thousand impacts, or smooth motion at any tolerance that a double resolves.
const MOST_STEPS: usize = 500_000;

impl<T: Scalar> AdaptiveSettings<T> {
    /// Tolerance ε until time `end`, step lengths by default.
    pub fn new(tolerance: T, end: T) -> Self {
        Self { tolerance, end, first_step: None, min_step: None, max_step: None, max_steps: MOST_STEPS }
    }

    /// Smallest tolerance of the scalar: a few thousand roundings of a length are left for the roots of gaps.
    pub fn least_tolerance() -> T {
        lit::<T>(4096.0) * epsilon::<T>()
    }

    /// Checks the settings for a run from `start`; gives (smallest, first, largest) length of a step.
    pub(super) fn check(&self, start: T) -> Result<(T, T, T), AdaptiveError> {
        let refuse = |what, value: T, range: String| {
            Err(AdaptiveError::OutOfRange { what, value: to_f64(value), range })
        };
        let (least, most) = (Self::least_tolerance(), lit::<T>(0.5));
        if !(self.tolerance >= least && self.tolerance <= most) {
            return refuse("the tolerance", self.tolerance, format!("in [{:e}, 0.5]", to_f64(least)));
        }
        if self.max_steps == 0 {
            return refuse("the largest number", T::zero(), "≥ 1".into());
        }
        let span = self.end - start;
        if !(span > T::zero() && all_finite([&self.end])) {
            return refuse("the end time", self.end, format!("finite and > {}", to_f64(start)));
        }
        let smallest = self.min_step.unwrap_or(lit::<T>(64.0) * epsilon::<T>() * span);
        if !(smallest > T::zero() && smallest < span) {
            return refuse("the smallest step", smallest, format!("> 0 and < {}", to_f64(span)));
        }
        let largest = self.max_step.unwrap_or(nalgebra::RealField::max(span * lit::<T>(0.1), smallest));
        if !(largest >= smallest && all_finite([&largest])) {
            return refuse("the largest step", largest, format!("finite and ≥ {:e}", to_f64(smallest)));
        }
        let inside = |x: T| nalgebra::RealField::min(nalgebra::RealField::max(x, smallest), largest);
        let first = self.first_step.unwrap_or(inside(span * lit::<T>(0.01)));
        if !(first >= smallest && first <= largest) {
            let range = format!("in [{:e}, {:e}]", to_f64(smallest), to_f64(largest));
            return refuse("the first step", first, range);
        }
        Ok((smallest, first, largest))
    }
}

/// What a step fell below its smallest length for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// The estimated error of the step.
    Error,
    /// The place of an impact, or of the end of sliding.
    Event,
}

impl std::fmt::Display for Limit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Error => "its estimated error",
            Self::Event => "the place of an impact or of the end of sliding",
        })
    }
}

/// Why a run under error control was not set up or ended early. The state is that of the last step kept.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AdaptiveError {
    /// A setting is out of range.
    #[error("{what} of adaptive steps is {value:e}, it must be {range}")]
    OutOfRange {
        /// Which.
        what: &'static str,
        /// The value refused.
        value: f64,
        /// The range in words.
        range: String,
    },
    /// The scheme takes no other step.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A step of the smallest length failed.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The motion does not get on: too many steps for a thousandth of the span.
    #[error(
        "t = {time} s: {steps} steps have been computed since t = {since} s, {most} are allowed in a thousandth of the span          (`max_steps`); the last trial had an error of {error:e} of the scene's length, {share:e} was its share of the          tolerance"
    )]
    TooManySteps {
        /// Time of the last step kept (s).
        time: f64,
        /// Time from which the steps are counted (s).
        since: f64,
        /// Steps computed since then.
        steps: usize,
        /// The number allowed.
        most: usize,
        /// Estimated error of the last trial that had an estimate, in lengths of the scene; 0 if none had.
        error: f64,
        /// Its share of the tolerance.
        share: f64,
    },
    /// No step length meets the tolerance.
    #[error(
        "t = {time} s: {limit} asks for a step of {step:e} s, the smallest is {least:e} s; the last trial had an error of \
         {error:e} of the scene's length, {share:e} was its share of the tolerance"
    )]
    Underflow {
        /// Time of the last step kept (s).
        time: f64,
        /// What asks for a smaller step.
        limit: Limit,
        /// The step asked for (s).
        step: f64,
        /// The smallest (s).
        least: f64,
        /// Estimated error of the last trial that had an estimate, in lengths of the scene; 0 if none had.
        error: f64,
        /// Its share of the tolerance.
        share: f64,
    },
}
