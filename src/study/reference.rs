//! The motion errors are measured against.

use std::fmt::Debug;

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

/// Calls `visit` with those of ascending `times` that are in (from, to).
pub(super) fn visit_between(times: &[f64], from: f64, to: f64, visit: &mut dyn FnMut(f64)) {
    let first = times.partition_point(|&time| time <= from);
    times[first..].iter().take_while(|&&time| time < to).for_each(|&time| visit(time));
}
