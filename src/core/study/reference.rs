//! The motion errors are measured against.

use std::fmt::Debug;

use crate::event_driven::Motion;

/// A motion of a system that is taken for the true one.
///
/// It knows a whole run: times are between its start and its end. Vectors are in the order of the degrees of freedom of
/// the system the runs are of.
pub trait Reference: Debug + Send + Sync {
    /// Configuration and velocity at a time; where the velocity jumps, the one before.
    fn at(&self, time: f64, q: &mut [f64], v: &mut [f64]);

    /// Calls `visit` with the times in (from, to) at which the velocity is known to jump, in ascending order.
    fn jumps(&self, _from: f64, _to: f64, _visit: &mut dyn FnMut(f64)) {}

    /// Normal percussions of all contacts since the start, summed (N s).
    fn percussion(&self, time: f64) -> f64;

    /// Energy with the potential of the constant forces (J), as [`crate::energy::Energies::total`].
    fn energy(&self, time: f64) -> f64;
}

/// Calls `visit` with the times in (from, to) of events in ascending order.
pub(super) fn visit_between<E>(
    events: &[E],
    time: impl Fn(&E) -> f64,
    (from, to): (f64, f64),
    visit: &mut dyn FnMut(f64),
) {
    let first = events.partition_point(|event| time(event) <= from);
    events[first..].iter().map(time).take_while(|&time| time < to).for_each(visit);
}

impl Reference for Motion {
    fn at(&self, time: f64, q: &mut [f64], v: &mut [f64]) {
        self.before(time, q, v);
    }

    fn jumps(&self, from: f64, to: f64, visit: &mut dyn FnMut(f64)) {
        visit_between(self.impacts(), |impact| impact.time, (from, to), visit);
    }

    fn percussion(&self, time: f64) -> f64 {
        self.percussion(time)[0]
    }

    fn energy(&self, time: f64) -> f64 {
        self.energy(time).total()
    }
}
