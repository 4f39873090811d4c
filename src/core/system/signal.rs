//! Named signals: the time functions that loads and prescribed displacements are multiplied with.

use nalgebra::ComplexField;

use super::SystemError;
use crate::scalar::{Scalar, all_finite, lit, to_f64};

/// A dimensionless function of time.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(
    feature = "scene",
    derive(serde::Deserialize),
    serde(rename_all = "lowercase", deny_unknown_fields)
)]
pub enum Signal<T> {
    /// 1 (default).
    #[default]
    Constant,
    /// sin 2π(f t + φ).
    Sine {
        /// f > 0 (1/s).
        frequency: T,
        /// φ, as a fraction of the period.
        #[cfg_attr(feature = "scene", serde(default))]
        phase: T,
    },
    /// sgn sin 2π(f t + φ). At a jump the value is 0, the mean of both sides; times within 1e-9 of a period from a
    /// jump are at it, so that the rounding of t_k = k h does not choose a side.
    Square {
        /// f > 0 (1/s).
        frequency: T,
        /// φ, as a fraction of the period.
        #[cfg_attr(feature = "scene", serde(default))]
        phase: T,
    },
    /// rate · t, at all times.
    Linear {
        /// rate (1/s).
        rate: T,
    },
    /// 0 before `start`, 1 after `end`, linear between.
    Ramp {
        /// Where it leaves 0 (s).
        #[cfg_attr(feature = "scene", serde(default))]
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
    /// The signal in another arithmetic.
    pub fn cast<U: Scalar>(&self) -> Signal<U> {
        let one = |x: T| lit::<U>(to_f64(x));
        let all = |values: &[T]| values.iter().map(|&x| one(x)).collect();
        match self {
            Self::Constant => Signal::Constant,
            &Self::Sine { frequency, phase } => Signal::Sine { frequency: one(frequency), phase: one(phase) },
            &Self::Square { frequency, phase } => {
                Signal::Square { frequency: one(frequency), phase: one(phase) }
            }
            &Self::Linear { rate } => Signal::Linear { rate: one(rate) },
            &Self::Ramp { start, end } => Signal::Ramp { start: one(start), end: one(end) },
            Self::Table { times, values } => Signal::Table { times: all(times), values: all(values) },
        }
    }

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
            Self::Linear { rate } => {
                if !all_finite([rate]) {
                    return refuse("the rate of a signal".into(), *rate, "finite");
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
            Self::Linear { rate } => *rate * time,
            Self::Ramp { start, end } => {
                let x = (time - *start) / (*end - *start);
                nalgebra::RealField::clamp(x, T::zero(), T::one())
            }
            Self::Table { times, values } => {
                let after = times.partition_point(|t| *t <= time);
                if after == 0 || after == times.len() {
                    return values[after.saturating_sub(1).min(values.len() - 1)];
                }
                segment(times, values, after, time)
            }
        }
    }

    /// The first time after `time` at which the signal jumps or has a kink.
    pub fn next_break(&self, time: T) -> Option<T> {
        match self {
            Self::Constant | Self::Sine { .. } | Self::Linear { .. } => None,
            Self::Square { frequency, phase } => {
                let half = lit::<T>(0.5);
                let index = ComplexField::floor((*frequency * time + *phase) / half);
                // The first of the two is at or before `time` where rounding has moved it there.
                let jump = |index: T| (index * half - *phase) / *frequency;
                [1.0, 2.0].map(|next| jump(index + lit::<T>(next))).into_iter().find(|jump| *jump > time)
            }
            Self::Ramp { start, end } => [*start, *end].into_iter().find(|kink| *kink > time),
            Self::Table { times, .. } => times.iter().copied().find(|kink| *kink > time),
        }
    }

    /// The value at a time of the smooth function that is the signal around `inside`: at `inside`'s side of a jump, and
    /// beyond a kink.
    pub fn continued(&self, time: T, inside: T) -> T {
        match self {
            Self::Constant | Self::Sine { .. } | Self::Linear { .. } => self.at(time),
            Self::Square { .. } => self.at(inside),
            Self::Ramp { start, end } => {
                if inside < *start || inside > *end {
                    self.at(inside)
                } else {
                    (time - *start) / (*end - *start)
                }
            }
            Self::Table { times, values } => {
                let after = times.partition_point(|t| *t <= inside);
                if after == 0 || after == times.len() {
                    self.at(inside)
                } else {
                    segment(times, values, after, time)
                }
            }
        }
    }

    /// Largest |value|; of a linear one, what it gains in 1 s.
    pub fn amplitude(&self) -> T {
        match self {
            Self::Table { values, .. } => crate::linalg::max_abs(values),
            Self::Linear { rate } => ComplexField::abs(*rate),
            _ => T::one(),
        }
    }
}

/// The line through points `after` − 1 and `after` of a table.
fn segment<T: Scalar>(times: &[T], values: &[T], after: usize, time: T) -> T {
    let (t0, t1) = (times[after - 1], times[after]);
    let x = (time - t0) / (t1 - t0);
    values[after - 1] + x * (values[after] - values[after - 1])
}

/// The fraction of x above the next whole number below.
fn turn<T: Scalar>(x: T) -> T {
    x - ComplexField::floor(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_is_smooth_between_its_breaks_and_continued_beyond_them() {
        let table = Signal::Table { times: vec![0.0, 0.5, 2.0], values: vec![1.0, -1.0, 4.0] };
        let signals: [(Signal<f64>, &[f64]); 5] = [
            (Signal::Sine { frequency: 3.0, phase: 0.2 }, &[]),
            (Signal::Square { frequency: 2.0, phase: 0.1 }, &[0.2, 0.45, 0.7, 0.95, 1.2, 1.45]),
            (Signal::Square { frequency: 2.0, phase: 0.0 }, &[0.25, 0.5, 0.75, 1.0, 1.25, 1.5]),
            (Signal::Ramp { start: 0.3, end: 0.9 }, &[0.3, 0.9]),
            (table, &[0.5, 2.0]),
        ];
        for (signal, expected) in signals {
            let (mut time, mut breaks) = (0.0, Vec::new());
            while let Some(next) = signal.next_break(time).filter(|&t| t < 1.6 || t == 2.0) {
                assert!(next > time, "{signal:?}: {next} after {time}");
                let inside = 0.5 * (time + next);
                for t in [0.9 * time + 0.1 * next, inside, 0.1 * time + 0.9 * next] {
                    let (value, continued) = (signal.at(t), signal.continued(t, inside));
                    assert!((value - continued).abs() < 1e-14, "{signal:?} at {t}: {value} and {continued}");
                }
                // The limit at the break: where it is linear, the line goes on.
                let [a, b] = [inside, next].map(|t| signal.continued(t, inside));
                let quarter = signal.continued(0.5 * (inside + next), inside);
                assert!(
                    (a + b - 2.0 * quarter).abs() < 1e-14,
                    "{signal:?} up to {next}: {a}, {quarter}, {b}"
                );
                breaks.push(next);
                time = next;
            }
            assert_eq!(breaks.len(), expected.len(), "{signal:?}: {breaks:?}");
            breaks
                .iter()
                .zip(expected)
                .for_each(|(found, t)| assert!((found - t).abs() < 1e-15, "{breaks:?}"));
        }
    }
}
