//! The clock of a scheme: by multiplication where steps are equal, with a compensated origin where they change.

use crate::scalar::{Scalar, lit};

/// t_k = (t₀ + c) + h (k − k₀), with the digits c that t₀ cannot hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Clock<T> {
    pub(super) origin: T,
    pub(super) low: T,
    pub(super) index: usize,
}

impl<T: Scalar> Clock<T> {
    pub(super) fn starting(origin: T) -> Self {
        Self { origin, low: T::zero(), index: 0 }
    }

    /// By multiplication, so that the clock does not drift over many steps.
    #[inline]
    pub(super) fn at(&self, index: usize, step: T) -> T {
        self.origin + (self.low + step * lit::<T>((index - self.index) as f64))
    }

    /// The clock that starts from here, losing nothing of the time.
    pub(super) fn moved(&self, index: usize, step: T) -> Self {
        let gone = self.low + step * lit::<T>((index - self.index) as f64);
        // The error of a sum (Knuth), exact in binary arithmetic.
        let sum = self.origin + gone;
        let part = sum - self.origin;
        let low = (self.origin - (sum - part)) + (gone - part);
        Self { origin: sum, low, index }
    }

    /// t − t_k, with all digits of t_k.
    pub(super) fn until(&self, time: T, index: usize, step: T) -> T {
        let now = self.moved(index, step);
        (time - now.origin) - now.low
    }
}
