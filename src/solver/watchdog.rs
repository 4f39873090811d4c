//! The watchdog line search: full steps on trust, then back and careful, against the worst of the last merits
//! (Grippo, Lampariello & Lucidi 1991). The counts are measured on frictional contact.

use crate::scalar::{Scalar, lit};

/// Full steps that may raise the merit before the search goes back to the reference.
const FREE_STEPS: usize = 6;
/// Careful steps before the next full ones.
const SEARCHED_STEPS: usize = 2;
/// Part of the merit that promotes an iterate to the new reference.
const SUFFICIENT: f64 = 0.9;
/// Armijo's constant, on ‖F‖² whose slope along a Newton step is −2‖F‖².
const ARMIJO: f64 = 1e-4;
/// A step length below this is short, and so many in a row are a stagnation.
const SHORT: (f64, usize) = (0.1, 3);

/// State of the search on the merit ‖F‖².
#[derive(Debug, Clone)]
pub(super) struct Watchdog<T> {
    history: [T; 4],
    reference: T,
    free: usize,
    searched: usize,
    short: usize,
}

impl<T: Scalar> Watchdog<T> {
    /// A search whose reference is an iterate of this merit.
    pub(super) fn new(merit: T) -> Self {
        Self { history: [merit; 4], reference: merit, free: 0, searched: 0, short: 0 }
    }

    /// The merit of the reference, where the free steps led nowhere and the iterate has to go back to it.
    pub(super) fn back(&mut self) -> Option<T> {
        let led_nowhere = self.free == FREE_STEPS && self.searched == 0;
        led_nowhere.then(|| {
            self.history = [self.reference; 4];
            self.reference
        })
    }

    /// Whether the full step to an iterate of this merit is taken on trust.
    pub(super) fn trusts(&mut self, merit: T) -> bool {
        let trusted = self.free < FREE_STEPS && merit.is_finite();
        self.free = if trusted { self.free + 1 } else { FREE_STEPS };
        trusted
    }

    /// Armijo's condition against the worst of the last merits, for a step of `length` from a merit of `now`; false
    /// for a NaN.
    pub(super) fn accepts(&self, merit: T, length: T, now: T) -> bool {
        let worst = self.history.iter().fold(T::zero(), |worst: T, &h| worst.max(h));
        merit <= worst - lit::<T>(2.0 * ARMIJO) * length * now
    }

    /// Counts a searched step; whether the steps have become too short to go on.
    pub(super) fn searched(&mut self, length: T, merit: T) -> bool {
        self.searched += 1;
        self.short = if length < lit(SHORT.0) { self.short + 1 } else { 0 };
        self.short >= SHORT.1 || !merit.is_finite()
    }

    /// Records the iterate now stood on; whether it is the new reference.
    pub(super) fn stands(&mut self, merit: T) -> bool {
        self.history.rotate_left(1);
        self.history[3] = merit;
        let promoted = merit <= self.reference * lit::<T>(SUFFICIENT) || self.searched == SEARCHED_STEPS;
        if promoted {
            (self.reference, self.free, self.searched) = (merit, 0, 0);
        }
        promoted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_steps_that_lead_nowhere_are_taken_back() {
        let mut watchdog = Watchdog::new(1.0);
        for merit in [5.0, 4.0, 8.0, 2.0, 3.0, 1.0] {
            assert_eq!(watchdog.back(), None);
            assert!(watchdog.trusts(merit));
            assert!(!watchdog.stands(merit));
        }
        assert_eq!(watchdog.back(), Some(1.0));
        assert!(!watchdog.trusts(0.5));
        // From the reference only a merit below its own is accepted.
        assert!(!watchdog.accepts(1.0, 1.0, 1.0));
        assert!(!watchdog.accepts(f64::NAN, 1.0, 1.0));
        assert!(watchdog.accepts(0.99, 1.0, 1.0));
    }

    #[test]
    fn a_fall_of_the_merit_renews_the_trust() {
        let mut watchdog = Watchdog::new(1.0);
        for k in 1..20 {
            let merit = 0.8f64.powi(k);
            assert_eq!(watchdog.back(), None);
            assert!(watchdog.trusts(merit));
            assert!(watchdog.stands(merit));
        }
    }

    #[test]
    fn three_short_steps_are_a_stagnation() {
        let mut watchdog = Watchdog::new(1.0);
        assert!(!watchdog.trusts(f64::INFINITY));
        assert!(!watchdog.searched(0.01, 0.99));
        assert!(!watchdog.searched(0.01, 0.99));
        assert!(watchdog.searched(0.01, 0.99));
        assert!(Watchdog::new(1.0).searched(1.0, f64::NAN));
    }
}
