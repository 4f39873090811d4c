//! Degrees of freedom that move as told.

use super::{Signal, SystemError};
use crate::scalar::{Scalar, all_finite, to_f64};

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
    /// Where each degree of freedom is displaced from; nothing where that is 0 for all.
    origins: Vec<T>,
    /// Displacement (m) and signal of each degree of freedom.
    motions: Vec<(T, usize)>,
    signals: Vec<Signal<T>>,
}

impl<T: Scalar> Prescribed<T> {
    /// Degrees of freedom `first`, `first + 1`, … move by `motions[i].0` (m or rad) times the signal `signals[motions[i].1]`.
    ///
    /// # Errors
    /// [`SystemError::Unknown`] for a signal that does not exist, [`SystemError::OutOfRange`] for a displacement that is not
    /// finite.
    pub fn new(first: usize, motions: Vec<(T, usize)>, signals: Vec<Signal<T>>) -> Result<Self, SystemError> {
        for &(value, index) in &motions {
            if index >= signals.len() {
                return Err(SystemError::Unknown { what: "signal", index, count: signals.len() });
            }
            if !all_finite([&value]) {
                let what = "a prescribed displacement".into();
                return Err(SystemError::OutOfRange { what, value: to_f64(value), range: "finite" });
            }
        }
        Ok(Self { first, origins: Vec::new(), motions, signals })
    }

    /// The same motions from `origins` (m or rad), one for each degree of freedom and 0 where there are fewer.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`] for one that is not finite.
    pub fn with_origins(mut self, origins: Vec<T>) -> Result<Self, SystemError> {
        if let Some(origin) = origins.iter().find(|origin| !all_finite([*origin])) {
            let what = "the origin of a prescribed displacement".into();
            return Err(SystemError::OutOfRange { what, value: to_f64(*origin), range: "finite" });
        }
        self.origins = origins;
        Ok(self)
    }

    fn origin(&self, i: usize) -> T {
        self.origins.get(i).copied().unwrap_or_else(T::zero)
    }

    /// The same motions of degrees of freedom that stand `by` further on.
    pub(super) fn shifted(&self, by: usize) -> Self {
        Self { first: self.first + by, ..self.clone() }
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
        self.origin(i) + value * self.signals[signal].at(time)
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
            q[self.first + i] = self.origin(i) + (from + theta * (to - from));
            v[self.first + i] = (to - from) / step;
        }
    }
}
