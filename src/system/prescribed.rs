//! Degrees of freedom that move as told.

use super::Signal;
use crate::scalar::Scalar;

/// The prescribed degrees of freedom of a system, the last ones: they are eliminated from the equations, and the
/// work of the reactions that move them is a term of the balance.
///
/// A displacement u(t) enters the θ-step as
///
/// ```text
///   v_k = (u(t_k + (1−θ)h) − u(t_k − θh))/h,     q_k = (1−θ) u(t_k − θh) + θ u(t_k + (1−θ)h)
/// ```
///
/// which satisfies q_{k+1} = q_k + h v_{k+θ} exactly, is second-order accurate where u is smooth, and neither drifts
/// nor oscillates where u has kinks or jumps.
#[derive(Debug, Clone)]
pub struct Prescribed<T> {
    first: usize,
    /// Displacement (m) and signal of each degree of freedom.
    motions: Vec<(T, usize)>,
    signals: Vec<Signal<T>>,
}

impl<T: Scalar> Prescribed<T> {
    /// Degrees of freedom `first`, `first + 1`, … move by `motions[i].0` times the signal `signals[motions[i].1]`.
    pub(super) fn new(first: usize, motions: Vec<(T, usize)>, signals: Vec<Signal<T>>) -> Self {
        Self { first, motions, signals }
    }

    /// Index of the first prescribed degree of freedom: the number of free ones.
    pub fn first(&self) -> usize {
        self.first
    }

    /// Number of prescribed degrees of freedom.
    pub fn count(&self) -> usize {
        self.motions.len()
    }

    /// Whether anything moves in time.
    pub fn moves(&self) -> bool {
        self.motions.iter().any(|&(_, signal)| self.signals[signal] != Signal::Constant)
    }

    /// u(t) of prescribed degree of freedom `i`, counted from [`first`](Self::first).
    pub fn displacement(&self, i: usize, time: T) -> T {
        let (value, signal) = self.motions[i];
        value * self.signals[signal].at(time)
    }

    /// Sets the prescribed components of (q, v) at `time` in steps of length `step`.
    pub fn set(&self, time: T, step: T, theta: T, q: &mut [T], v: &mut [T]) {
        let (before, after) = (time - theta * step, time + (T::one() - theta) * step);
        for (i, &(value, signal)) in self.motions.iter().enumerate() {
            let signal = &self.signals[signal];
            let (from, to) = match signal {
                Signal::Constant => (value, value),
                signal => (value * signal.at(before), value * signal.at(after)),
            };
            q[self.first + i] = from + theta * (to - from);
            v[self.first + i] = (to - from) / step;
        }
    }
}
