//! Settings that are out of range, and what checks and builds settings.

use std::fmt;

use super::anderson::MAX_DEPTH;
use super::control::StoppingError;
use crate::scalar::{Scalar, to_f64};

/// A setting no solver can work with.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// The stopping rule is out of range.
    #[error(transparent)]
    Stopping(#[from] StoppingError),
    /// A setting of the method is out of range.
    #[error("`{setting}` is {value}, it must be in {range}")]
    OutOfRange {
        /// The field.
        setting: &'static str,
        /// The value refused.
        value: f64,
        /// The values allowed.
        range: Interval,
    },
}

/// An interval of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Interval {
    /// Without its ends.
    Open(f64, f64),
    /// Without its lower end.
    LeftOpen(f64, f64),
    /// With its ends.
    Closed(f64, f64),
}

impl Interval {
    /// Whether `value` lies in it; no NaN does.
    pub fn contains(self, value: f64) -> bool {
        match self {
            Self::Open(low, high) => low < value && value < high,
            Self::LeftOpen(low, high) => low < value && value <= high,
            Self::Closed(low, high) => low <= value && value <= high,
        }
    }

    /// Checks a setting.
    ///
    /// # Errors
    /// [`SettingsError::OutOfRange`].
    pub fn check<T: Scalar>(self, setting: &'static str, value: T) -> Result<(), SettingsError> {
        let value = to_f64(value);
        if self.contains(value) {
            return Ok(());
        }
        Err(SettingsError::OutOfRange { setting, value, range: self })
    }
}

impl fmt::Display for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open(low, high) => write!(f, "]{low}, {high}["),
            Self::LeftOpen(low, high) => write!(f, "]{low}, {high}]"),
            Self::Closed(low, high) => write!(f, "[{low}, {high}]"),
        }
    }
}

/// Checks a depth of Anderson acceleration.
pub(super) fn check_depth(setting: &'static str, depth: usize) -> Result<(), SettingsError> {
    Interval::Closed(0.0, MAX_DEPTH as f64).check(setting, depth as f64)
}

/// A `with_…` for every field, so that settings can be built outside this crate in one expression.
macro_rules! setters {
    ($settings:ident $(<$scalar:ident>)?: $($setter:ident($field:ident: $type:ty)),+ $(,)?) => {
        impl $(<$scalar: $crate::scalar::Scalar>)? $settings $(<$scalar>)? {
            $(
                #[doc = concat!("The settings with another [`", stringify!($field), "`](Self::", stringify!($field), ").")]
                #[must_use]
                pub fn $setter(mut self, $field: $type) -> Self {
                    self.$field = $field;
                    self
                }
            )+
        }
    };
}

pub(super) use setters;
