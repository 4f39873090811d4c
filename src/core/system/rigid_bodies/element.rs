//! Rows over one relative coordinate: what sliders hold, springs, dampers, motors, dry friction; and stops.

use super::RigidBodies;
use super::identity::Pair;
use super::measure::Measure;
use crate::contact::Candidate;
use crate::scalar::{Scalar, lit};
use crate::system::{RowLaw, Signal};

/// Something that acts along one relative coordinate.
#[derive(Debug, Clone)]
pub(super) struct Element<T> {
    pub(super) label: String,
    pub(super) measure: Measure<T>,
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
    /// A force times a signal.
    Pushes { force: T, signal: Signal<T> },
    /// Dry friction of at most a force.
    Rubs { most: T },
}

impl<T: Scalar> Element<T> {
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
            Acts::Pushes { force, signal } => RowLaw::Given { force: *force * mean(signal) },
            &Acts::Rubs { most } => RowLaw::Driven { rate: T::zero(), most: Some(most) },
        }
    }
}

/// A one-sided bound on a relative coordinate: the gap is `sign` (x − bound).
#[derive(Debug, Clone)]
pub(super) struct Stop<T> {
    pub(super) label: String,
    pub(super) measure: Measure<T>,
    pub(super) bound: T,
    pub(super) sign: T,
    pub(super) interface: usize,
}

impl<T: Scalar> Stop<T> {
    pub(super) fn gap(&self, q: &[T]) -> T {
        self.sign * (self.measure.value(q) - self.bound)
    }
}

impl<T: Scalar> RigidBodies<T> {
    /// Limits of joints that are near.
    pub(super) fn stop_candidates(&self, q: &[T], reach: T, out: &mut Vec<Candidate<T>>) {
        for (i, stop) in self.stops.iter().enumerate() {
            let gap = stop.gap(q);
            if !(gap > reach) {
                out.push(Candidate { id: Pair::Stop(i).id(), interface: stop.interface, gap });
            }
        }
    }
}
