//! The length of the next step.

use crate::scalar::{Scalar, lit};

/// Safety factor on the length that the estimate would allow.
const SAFETY: f64 = 0.9;

/// Most that a length grows and shrinks by at once.
const GROWTH: f64 = 5.0;
const SHRINKAGE: f64 = 0.1;

/// The controller of the length 3h of a trial; steps kept have a third of it.
#[derive(Debug)]
pub(super) struct Control<T> {
    /// 3h of the next trial between events.
    pub(super) size: T,
    /// The last 3h kept for its estimate.
    proven: T,
    /// Whether three steps need no longer one to compare with.
    pub(super) coasts: bool,
    /// What the contacts did in the last three steps.
    pub(super) contacts: u64,
    /// Largest 3h.
    largest: T,
    /// Estimate over share of the last trial kept.
    last: T,
    /// Longest step whose error is known to be small enough where the motion now is; 0 after an impact.
    pub(super) verified: T,
    /// Time left to an event that an approach is made to; 0 where none is known.
    pub(super) to_event: T,
}

impl<T: Scalar> Control<T> {
    pub(super) fn new(first: T, largest: T) -> Self {
        let three = lit::<T>(3.0);
        let (size, largest) = (first * three, largest * three);
        Self {
            size,
            proven: size,
            largest,
            last: T::one(),
            verified: T::zero(),
            to_event: T::zero(),
            coasts: false,
            contacts: 0,
        }
    }

    /// A trial of length `size` was kept, its estimate `ratio` times its share, at the order `order` of the scheme.
    ///
    /// A PI controller (Gustafsson 1991, doi:10.1145/210232.210242): exponents 0.7 and −0.4 over the order of the error
    /// per unit of time.
    pub(super) fn kept(&mut self, size: T, ratio: T, order: T) {
        let power = |x: T, y: T| nalgebra::ComplexField::powf(x, y);
        let floor = lit::<T>(1e-4);
        let (now, before) = (nalgebra::RealField::max(ratio, floor), self.last);
        let factor =
            lit::<T>(SAFETY) * power(now, lit::<T>(-0.7) / order) * power(before, lit::<T>(0.4) / order);
        let factor = nalgebra::RealField::min(factor, lit::<T>(GROWTH));
        // A trial cut short by an event says nothing of longer ones.
        if size >= self.size * lit::<T>(0.4) || factor < T::one() {
            let grown = size * nalgebra::RealField::max(factor, lit::<T>(0.2));
            self.size = if factor < T::one() { grown } else { nalgebra::RealField::max(grown, self.size) };
        }
        self.size = nalgebra::RealField::min(self.size, self.largest);
        self.last = now;
        (self.verified, self.proven) = (size / lit::<T>(3.0), size);
    }

    /// The length to try in place of `size`, whose estimate was `ratio` > 1 times its share.
    pub(super) fn rejected(&mut self, size: T, ratio: T, order: T) -> T {
        let factor = lit::<T>(SAFETY) * nalgebra::ComplexField::powf(ratio, -T::one() / order);
        let bounded = nalgebra::RealField::min(factor, lit::<T>(0.7));
        // Written so that a NaN shrinks.
        let factor = if bounded > lit::<T>(SHRINKAGE) { bounded } else { lit::<T>(SHRINKAGE) };
        (self.last, self.verified) = (T::one(), T::zero());
        self.size = nalgebra::RealField::min(self.size, size * factor);
        size * factor
    }

    /// The length that leaves nothing of a force in time unresolved, `hidden` times what is allowed in `size`, where it grows
    /// as the third power of the length; no longer trial comes next.
    pub(super) fn for_force(&mut self, size: T, hidden: T) -> T {
        // Where no force hides, a short trial before an event is no reason for short ones after it.
        if hidden == T::zero() {
            return size;
        }
        let root = nalgebra::ComplexField::cbrt(nalgebra::RealField::max(hidden, lit::<T>(1e-3)));
        let length = lit::<T>(SAFETY) * size / root;
        self.size = nalgebra::RealField::min(self.size, length);
        length
    }

    /// A jump was stepped over in small steps: behind it the motion is as smooth as before.
    pub(super) fn jumped(&mut self) {
        (self.last, self.verified) = (T::one(), T::zero());
        self.size = self.proven;
    }

    /// An impact: what was known of the motion before it says nothing of that after it, but its length is a guess.
    pub(super) fn impact(&mut self) {
        (self.last, self.verified, self.to_event, self.coasts) = (T::one(), T::zero(), T::zero(), false);
    }
}
