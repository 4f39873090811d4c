//! Named signals: the time functions that loads and prescribed displacements are multiplied with.

use nalgebra::ComplexField;

use super::SystemError;
use crate::scalar::{Scalar, all_finite, lit, to_f64};

/// A dimensionless function of time.
#[derive(Debug, Clone, PartialEq)]
pub enum Signal<T> {
    /// 1.
    Constant,
    /// sin 2π(f t + φ).
    Sine {
        /// f > 0 (1/s).
        frequency: T,
        /// φ, as a fraction of the period.
        phase: T,
    },
    /// sgn sin 2π(f t + φ). At a jump the value is 0, the mean of both sides; times within 1e-9 of a period from a
    /// jump are at it, so that the rounding of t_k = k h does not choose a side.
    Square {
        /// f > 0 (1/s).
        frequency: T,
        /// φ, as a fraction of the period.
        phase: T,
    },
    /// 0 before `start`, 1 after `end`, linear between.
    Ramp {
        /// Where it leaves 0 (s).
        start: T,
        /// Where it reaches 1 (s), > `start`.
        end: T,
    },
    /// Linear between points, constant before the first and after the last.
    Table {
        /// Strictly increasing times (s).
        times: Vec<T>,
        /// Values at these times.
        values: Vec<T>,
    },
}

impl<T: Scalar> Signal<T> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`] naming the parameter and its value.
    pub fn check(&self) -> Result<(), SystemError> {
        let refuse = |what: String, value: T, range| {
            Err(SystemError::OutOfRange { what, value: to_f64(value), range })
        };
        match self {
            Self::Constant => Ok(()),
            Self::Sine { frequency, phase } | Self::Square { frequency, phase } => {
                if !(*frequency > T::zero() && all_finite([frequency])) {
                    return refuse("the frequency of a signal".into(), *frequency, "finite and > 0");
                }
                if !all_finite([phase]) {
                    return refuse("the phase of a signal".into(), *phase, "finite");
                }
                Ok(())
            }
            Self::Ramp { start, end } => {
                if !all_finite([start]) {
                    return refuse("the start of a ramp".into(), *start, "finite");
                }
                if !(end > start && all_finite([end])) {
                    return refuse("the end of a ramp".into(), *end, "finite and after its start");
                }
                Ok(())
            }
            Self::Table { times, values } => {
                if times.is_empty() || times.len() != values.len() {
                    let (what, expected) =
                        ("a table with times and values that differ in number", times.len());
                    return Err(SystemError::Size { what, expected, given: values.len() });
                }
                for (i, t) in times.iter().enumerate() {
                    if !all_finite([t]) || (i > 0 && !(*t > times[i - 1])) {
                        return refuse(format!("time {i} of a table"), *t, "finite and after the one before");
                    }
                }
                match values.iter().find(|value| !all_finite([*value])) {
                    Some(value) => refuse("a value of a table".into(), *value, "finite"),
                    None => Ok(()),
                }
            }
        }
    }

    /// The value at a time.
    pub fn at(&self, time: T) -> T {
        match self {
            Self::Constant => T::one(),
            Self::Sine { frequency, phase } => {
                ComplexField::sin(lit::<T>(std::f64::consts::TAU) * turn(*frequency * time + *phase))
            }
            Self::Square { frequency, phase } => {
                let twice = lit::<T>(2.0) * turn(*frequency * time + *phase);
                let jump = ComplexField::round(twice);
                if ComplexField::abs(twice - jump) < lit(2e-9) {
                    T::zero()
                } else if twice < T::one() {
                    T::one()
                } else {
                    -T::one()
                }
            }
            Self::Ramp { start, end } => {
                let x = (time - *start) / (*end - *start);
                nalgebra::RealField::clamp(x, T::zero(), T::one())
            }
            Self::Table { times, values } => {
                let after = times.partition_point(|t| *t <= time);
                if after == 0 || after == times.len() {
                    return values[after.saturating_sub(1).min(values.len() - 1)];
                }
                let (t0, t1) = (times[after - 1], times[after]);
                let x = (time - t0) / (t1 - t0);
                values[after - 1] + x * (values[after] - values[after - 1])
            }
        }
    }

    /// Largest |value|.
    pub fn amplitude(&self) -> T {
        match self {
            Self::Table { values, .. } => crate::linalg::max_abs(values),
            _ => T::one(),
        }
    }
}

/// The fraction of x above the next whole number below.
fn turn<T: Scalar>(x: T) -> T {
    x - ComplexField::floor(x)
}
