//! The watchdog line search: full steps on trust, then back and careful, against the worst of the last merits
//! (Grippo, Lampariello & Lucidi 1991). The counts are measured on frictional contact.

use crate::scalar::{Scalar, lit};

/// Full steps that may fail to lower the merit before the search goes back to the reference.
const FREE_STEPS: usize = 6;
/// Careful steps before the next full ones.
const GUARDED_STEPS: usize = 2;
/// Part of the merit that promotes an iterate to the new reference.
const SUFFICIENT: f64 = 0.9;
/// Merits the careful steps are compared with.
const MEMORY: usize = 4;
/// Armijo's constant on ‖f‖.
const ARMIJO: f64 = 1e-4;
/// A step length below this is short, and so many short ones are a stagnation.
const SHORT: (f64, usize) = (0.1, 3);

/// What to do with the iterate after a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    /// Step on from it.
    Keep,
    /// It is the new reference.
    Promote,
    /// The free steps led nowhere: back to the reference.
    Return,
    /// The steps have become too short to go on.
    Stagnant,
}

/// State of the search on the merit ‖f‖.
#[derive(Debug, Clone)]
pub(super) struct Watchdog<T> {
    reference: T,
    recent: [T; MEMORY],
    free: usize,
    guarded: usize,
    short: usize,
}

impl<T: Scalar> Watchdog<T> {
    /// A search whose reference is an iterate of this merit.
    pub(super) fn new(merit: T) -> Self {
        Self { reference: merit, recent: [merit; MEMORY], free: 0, guarded: 0, short: 0 }
    }

    /// The merit of the reference.
    pub(super) fn reference(&self) -> T {
        self.reference
    }

    /// Whether the next step is taken in full, whatever its merit.
    pub(super) fn trusts(&self) -> bool {
        self.guarded == 0
    }

    /// After a full step to an iterate of this merit.
    pub(super) fn stepped(&mut self, merit: T) -> Verdict {
        if merit < lit::<T>(SUFFICIENT) * self.reference {
            (self.reference, self.free) = (merit, 0);
            return Verdict::Promote;
        }
        self.free += 1;
        if self.free == FREE_STEPS || !(merit < T::infinity_impl()) {
            (self.free, self.guarded, self.recent) = (0, GUARDED_STEPS, [self.reference; MEMORY]);
            return Verdict::Return;
        }
        Verdict::Keep
    }

    /// Armijo's condition against the worst of the last merits, for a careful step of `length`; false for a NaN.
    pub(super) fn accepts(&self, merit: T, length: T) -> bool {
        let worst = self.recent.iter().fold(T::zero(), |worst: T, &merit| worst.max(merit));
        merit <= worst * (T::one() - lit::<T>(ARMIJO) * length)
    }

    /// After a careful step of `length` to an iterate of this merit.
    pub(super) fn searched(&mut self, length: T, merit: T) -> Verdict {
        self.recent.rotate_left(1);
        self.recent[MEMORY - 1] = merit;
        self.short += usize::from(length < lit::<T>(SHORT.0));
        self.guarded -= 1;
        if self.short >= SHORT.1 {
            return Verdict::Stagnant;
        }
        if self.guarded == 0 {
            self.reference = merit;
            return Verdict::Promote;
        }
        Verdict::Keep
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_steps_that_lead_nowhere_are_taken_back() {
        let mut watchdog = Watchdog::new(1.0);
        for merit in [5.0, 4.0, 8.0, 2.0, 3.0] {
            assert!(watchdog.trusts());
            assert_eq!(watchdog.stepped(merit), Verdict::Keep);
        }
        assert_eq!(watchdog.stepped(1.0), Verdict::Return);
        assert_eq!(watchdog.reference(), 1.0);
        assert!(!watchdog.trusts());
        // From the reference only a merit below its own is accepted.
        assert!(!watchdog.accepts(1.0, 1.0));
        assert!(!watchdog.accepts(f64::NAN, 1.0));
        assert!(watchdog.accepts(0.99, 1.0));
        assert_eq!(watchdog.searched(1.0, 0.99), Verdict::Keep);
        assert_eq!(watchdog.searched(0.5, 0.98), Verdict::Promote);
        assert!(watchdog.trusts());
    }

    #[test]
    fn a_fall_of_the_merit_renews_the_trust() {
        let mut watchdog = Watchdog::new(1.0);
        for k in 1..20 {
            let merit = 0.8f64.powi(k);
            assert!(watchdog.trusts());
            assert_eq!(watchdog.stepped(merit), Verdict::Promote);
        }
    }

    #[test]
    fn three_short_steps_are_a_stagnation() {
        let mut watchdog = Watchdog::new(1.0);
        for verdict in [[Verdict::Keep, Verdict::Promote], [Verdict::Stagnant; 2]] {
            // A merit that is not finite leads back at once.
            assert_eq!(watchdog.stepped(f64::INFINITY), Verdict::Return);
            assert_eq!(watchdog.searched(0.01, 0.99), verdict[0]);
            if verdict[0] == Verdict::Stagnant {
                break;
            }
            assert_eq!(watchdog.searched(0.01, 0.99), verdict[1]);
        }
    }
}
