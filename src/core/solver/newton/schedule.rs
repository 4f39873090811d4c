//! How the proximal parameter falls and rises, and where the next start lies.

use nalgebra::{ComplexField, SVector};

use crate::cone::{Cone, cones};
use crate::scalar::{Scalar, epsilon, from_usize, lit};

/// Failures in a row after which a start is given up.
const MAX_FAILURES: usize = 20;
/// Newton steps after which the schedule turns gentle.
const PATIENCE: usize = 120;
/// Newton steps of the first start, at least and per contact, before another one is tried; likewise of the others.
const FIRST_START: (usize, usize) = (300, 40);
const OTHER_START: (usize, usize) = (100, 10);
/// The fractional part of the golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The proximal parameter's schedule.
#[derive(Debug, Clone)]
pub(super) struct Schedule<T> {
    pub(super) a: T,
    floor: T,
    failures: usize,
    /// Whether the last success took at most eight steps.
    quick: bool,
    /// Successes to wait for before a falls again, and how many the next failed fall will cost.
    wait: usize,
    penalty: usize,
    /// The parameter that failed last.
    failed: T,
}

impl<T: Scalar> Schedule<T> {
    pub(super) fn new(a: T) -> Self {
        Self { a, floor: T::zero(), failures: 0, quick: false, wait: 0, penalty: 0, failed: T::zero() }
    }

    /// Whether it is time for another start.
    pub(super) fn gave_up(&self) -> bool {
        self.failures >= MAX_FAILURES
    }

    /// The subproblem was solved in so many steps.
    pub(super) fn success(&mut self, steps: usize, gentle: bool) {
        let tenth = lit::<T>(0.1);
        let factor = match steps {
            0..=4 => tenth,
            5..=8 if self.quick => ComplexField::sqrt(tenth),
            13.. => lit(2.0),
            _ => T::one(),
        };
        let mut factor = if gentle { factor.max(lit(0.4)) } else { factor };
        // Where a smaller a keeps failing, the way out is along the proximal path at this one.
        if factor < T::one() && self.wait > 0 {
            self.wait -= 1;
            factor = T::one();
        } else if self.a <= self.failed {
            self.penalty = 0;
        }
        self.quick = steps <= 8;
        self.failures = 0;
        self.floor *= lit::<T>(0.5);
        let least = lit::<T>(1e-9).max(lit::<T>(8.0) * epsilon::<T>());
        self.a = (self.a * factor).max(self.floor).max(least).min(lit(10.0));
    }

    /// Nothing is left to improve from here.
    pub(super) fn exhaust(&mut self) {
        self.failures = MAX_FAILURES;
    }

    /// The subproblem was abandoned.
    pub(super) fn failure(&mut self, gentle: bool) {
        self.failures += 1;
        self.quick = false;
        self.failed = self.a;
        self.wait = self.penalty;
        self.penalty = (2 * self.penalty).clamp(1, 64);
        self.floor = self.a * lit::<T>(2.0);
        let factor = match self.failures {
            1 if gentle => 2.0,
            1 => 4.0,
            _ => 10.0,
        };
        self.a = (self.a * lit::<T>(factor)).min(lit(10.0));
    }
}

/// The Newton steps between two starts: the problem is combinatorial, and from some places the path only circles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start {
    /// 0 for the caller's percussions.
    pub(super) number: usize,
    begin: usize,
    end: usize,
}

impl Start {
    pub(super) fn first(contacts: usize) -> Self {
        Self { number: 0, begin: 0, end: FIRST_START.0.max(FIRST_START.1 * contacts) }
    }

    /// The next start, after so many Newton steps.
    pub(super) fn next(self, steps: usize, contacts: usize) -> Self {
        let end = steps + OTHER_START.0.max(OTHER_START.1 * contacts);
        Self { number: self.number + 1, begin: steps, end }
    }

    pub(super) fn is_gentle(&self, steps: usize) -> bool {
        steps - self.begin > PATIENCE
    }

    pub(super) fn is_over(&self, steps: usize) -> bool {
        steps >= self.end
    }

    /// The percussions of this start: of the size of `best`'s, spread over the cones by the quadratic Weyl sequence
    /// 2 frac(φ n²) in [0, 2), so that every start tries other statuses.
    pub(super) fn place<T: Scalar, const D: usize>(
        &self,
        best: &[SVector<T, D>],
        apertures: &[Cone<T>],
        r: &mut [SVector<T, D>],
    ) {
        let square = best.iter().fold(T::zero(), |sum, r| sum + r.norm_squared());
        let reach = [1.0, 10.0, 0.1, 100.0][self.number % 4];
        let size = (ComplexField::sqrt(square / from_usize::<T>(best.len())) + T::one()) * lit::<T>(reach);
        let mut n = (self.number * D * r.len()) as f64;
        let mut next = || {
            n += 1.0;
            2.0 * (GOLDEN * n * n).fract()
        };
        for (r, &cone) in r.iter_mut().zip(apertures) {
            r[0] = size * lit::<T>(next());
            (1..D).for_each(|d| {
                r[d] = cones::coefficient::<T, D>(cone, d) * r[0] * lit::<T>(2.0 * next() - 2.0)
            });
        }
    }
}
