//! Rows over one relative coordinate: what sliders hold, springs, dampers, motors, dry friction; and stops.

use std::fmt::Debug;

use super::rigid_bodies::check;
use super::{RowLaw, Signal, SystemError};
use crate::contact::{Candidate, ContactId};
use crate::scalar::{Scalar, lit};

/// The part of an error of place that a step takes back: at ¼ an error dies out without swinging for θ from ½ to 1.
const TAKEN_BACK: f64 = 0.25;

/// A coordinate x(q) of bodies relative to each other (m or rad).
pub(super) trait Coordinate<T>: Debug {
    /// x(q).
    fn value(&self, q: &[T]) -> T;

    /// How far one value is from another; of angles, the short way.
    fn difference(&self, from: T, to: T) -> T;

    /// Calls `push(j, Ḡ_j)` for every degree of freedom j that moves it, with x(q ⊕ s) − x(q) = Ḡ(q, s) s.
    fn row(&self, q: &[T], s: &[T], push: impl FnMut(usize, T));
}

/// Something that acts along one relative coordinate.
#[derive(Debug, Clone)]
pub(super) struct Element<T, M> {
    pub(super) label: String,
    pub(super) measure: M,
    pub(super) acts: Acts<T>,
}

/// What an element does; forces in N or N m, lengths in m or rad.
#[derive(Debug, Clone)]
pub(super) enum Acts<T> {
    /// Keeps the coordinate at a value.
    Holds { at: T },
    /// A spring without force at `rest`, and a damper.
    Springs { stiffness: T, damping: T, rest: T },
    /// A speed times a signal, with at most a force.
    Drives { speed: T, signal: Signal<T>, most: Option<T> },
    /// Displacements from a value, each times a signal, whatever force it takes.
    Moves { from: T, parts: Vec<(T, Signal<T>)> },
    /// A force times a signal.
    Pushes { force: T, signal: Signal<T> },
    /// Dry friction of at most a force.
    Rubs { most: T },
}

impl<T: Scalar> Acts<T> {
    /// A spring of stiffness k ≥ 0 without force at `rest`, beside a damper c ≥ 0, not both 0.
    pub(super) fn springs(label: &str, (stiffness, damping): (T, T), rest: T) -> Result<Self, SystemError> {
        let range = "finite and ≥ 0";
        check(|| format!("stiffness of `{label}`"), &[stiffness], |k| k >= T::zero(), range)?;
        check(|| format!("damping of `{label}`"), &[damping], |c| c >= T::zero(), range)?;
        check(|| format!("rest length of `{label}`"), &[rest], |_| true, "finite")?;
        let sum = stiffness + damping;
        check(|| format!("stiffness and damping of `{label}`"), &[sum], |x| x > T::zero(), "not both 0")?;
        Ok(Self::Springs { stiffness, damping, rest })
    }

    /// A motor with a speed, of at most a force ≥ 0.
    pub(super) fn drives(
        label: &str,
        (speed, most): (T, Option<T>),
        signal: Signal<T>,
    ) -> Result<Self, SystemError> {
        signal.check()?;
        check(|| format!("speed of the motor of `{label}`"), &[speed], |_| true, "finite")?;
        let bound = most.unwrap_or_else(T::zero);
        check(|| format!("largest force of `{label}`"), &[bound], |x| x >= T::zero(), "finite and ≥ 0")?;
        Ok(Self::Drives { speed, signal, most })
    }

    /// A motor with a force.
    pub(super) fn pushes(label: &str, force: T, signal: Signal<T>) -> Result<Self, SystemError> {
        signal.check()?;
        check(|| format!("force of the motor of `{label}`"), &[force], |_| true, "finite")?;
        Ok(Self::Pushes { force, signal })
    }

    /// Dry friction of at most a force ≥ 0.
    pub(super) fn rubs(label: &str, most: T) -> Result<Self, SystemError> {
        check(|| format!("friction of `{label}`"), &[most], |x| x >= T::zero(), "finite and ≥ 0")?;
        Ok(Self::Rubs { most })
    }
}

impl<T: Scalar, M: Coordinate<T>> Element<T, M> {
    /// How far the coordinate is from where it is to be, or where the spring is without force; itself where neither is.
    pub(super) fn residual(&self, q: &[T]) -> T {
        let value = self.measure.value(q);
        match &self.acts {
            Acts::Holds { at } => value - *at,
            Acts::Springs { rest, .. } => value - *rest,
            _ => value,
        }
    }

    /// ½ k x².
    pub(super) fn energy(&self, q: &[T]) -> T {
        match &self.acts {
            Acts::Springs { stiffness, .. } => {
                let stretch = self.residual(q);
                lit::<T>(0.5) * *stiffness * stretch * stretch
            }
            _ => T::zero(),
        }
    }

    /// The law of a step; signals are averaged over its ends.
    pub(super) fn law(&self, q: &[T], time: T, step: T) -> RowLaw<T> {
        let mean = |signal: &Signal<T>| (signal.at(time) + signal.at(time + step)) * lit::<T>(0.5);
        match &self.acts {
            Acts::Holds { .. } => RowLaw::Held,
            &Acts::Springs { stiffness, damping, .. } => {
                RowLaw::Spring { stiffness, damping, stretch: self.residual(q) }
            }
            Acts::Drives { speed, signal, most } => {
                RowLaw::Driven { rate: *speed * mean(signal), most: *most }
            }
            Acts::Moves { from, parts } => {
                let half = lit::<T>(0.5);
                let at = |steps: f64| {
                    let time = time + step * lit::<T>(steps);
                    parts.iter().fold(T::zero(), |sum, (by, signal)| sum + *by * signal.at(time))
                };
                // As prescribed displacements have them for θ = ½, which neither drift nor swing where signals bend; a part of
                // what other θ have left is taken back.
                let place = *from + (at(-0.5) + at(0.5)) * half;
                let left = self.measure.difference(self.measure.value(q), place);
                let rate = (at(1.5) - at(0.5) + left * lit::<T>(TAKEN_BACK)) / step;
                RowLaw::Driven { rate, most: None }
            }
            Acts::Pushes { force, signal } => RowLaw::Given { force: *force * mean(signal) },
            &Acts::Rubs { most } => RowLaw::Driven { rate: T::zero(), most: Some(most) },
        }
    }
}

/// A one-sided bound on a relative coordinate: the gap is `sign` (x − bound).
#[derive(Debug, Clone)]
pub(super) struct Stop<T, M> {
    pub(super) label: String,
    pub(super) measure: M,
    pub(super) bound: T,
    pub(super) sign: T,
    pub(super) interface: usize,
}

impl<T: Scalar, M: Coordinate<T> + Clone> Stop<T, M> {
    /// Two stops that keep a coordinate between `lower` and `upper`.
    pub(super) fn pair(
        label: &str,
        measure: M,
        [lower, upper]: [T; 2],
        interface: usize,
    ) -> Result<[Self; 2], SystemError> {
        check(|| format!("a limit of `{label}`"), &[lower, upper], |_| true, "finite")?;
        let range = [upper - lower];
        check(|| format!("upper less lower limit of `{label}`"), &range, |x| x > T::zero(), "> 0")?;
        let at = |name: &str, bound: T, sign: T, measure: M| Self {
            label: format!("{label}|{name}"),
            measure,
            bound,
            sign,
            interface,
        };
        Ok([at("lower", lower, T::one(), measure.clone()), at("upper", upper, -T::one(), measure)])
    }

    pub(super) fn gap(&self, q: &[T]) -> T {
        self.sign * (self.measure.value(q) - self.bound)
    }

    /// Appends the stops with a gap of at most `reach`, under the identities `id` of their places.
    pub(super) fn near(
        stops: &[Self],
        q: &[T],
        reach: T,
        id: impl Fn(usize) -> ContactId,
        out: &mut Vec<Candidate<T>>,
    ) {
        for (i, stop) in stops.iter().enumerate() {
            let gap = stop.gap(q);
            if !(gap > reach) {
                out.push(Candidate { id: id(i), interface: stop.interface, gap });
            }
        }
    }
}
