//! Proximal point with a semismooth Newton inside: the solver for hard and large problems.

use nalgebra::{ComplexField, SVector};

use super::newton::{Inner, Map, Outcome, Refinement, Scaled};
use super::{Breakdown, ConeSolver, Control, Description, Family, Stopping};
use crate::cone::{ConeProblem, Workspace};
use crate::scalar::{Scalar, epsilon, lit};

/// Newton steps allowed by default: the hard problems are combinatorial.
const DEFAULT_STEPS: usize = 6_000;
/// Failures in a row after which the solver gives up.
const MAX_FAILURES: usize = 20;
/// Newton steps after which the schedule turns gentle.
const PATIENCE: usize = 120;
/// Newton steps of the first attempt, at least and per contact, before another start is tried; likewise of the others.
const FIRST_ATTEMPT: (usize, usize) = (300, 40);
const OTHER_ATTEMPT: (usize, usize) = (100, 10);
/// Starts after which the solver gives up.
const MAX_ATTEMPTS: usize = 1_000;

/// Settings of [`ProximalNewton`].
#[derive(Debug, Clone)]
pub struct ProximalNewtonSettings<T> {
    /// Tolerance and budget; the default budget is 6,000 Newton steps.
    pub stopping: Stopping<T>,
    /// First proximal parameter a, dimensionless (against λ_max(W_αα) = 1), in ]0, 10]. `None` (default) takes 1e-4,
    /// or 1e-2 above 5,000 contacts.
    pub proximal: Option<T>,
}

impl<T: Scalar> Default for ProximalNewtonSettings<T> {
    fn default() -> Self {
        Self { stopping: Stopping::default(), proximal: None }
    }
}

/// Proximal point algorithm r_{k+1} = solution of w = W r + b + a (r − r_k), each subproblem by semismooth Newton on
/// the Alart–Curnier map, in units where every λ_max(W_αα) is 1.
///
/// The parameter a falls after quick successes and rises after failures; small a with the right statuses is the
/// quadratic finish. One iteration is one Newton step: one factorisation of a matrix with the pattern of W. Choose it
/// for hard problems (W singular, chains of contacts) and high accuracy.
#[derive(Debug, Clone)]
pub struct ProximalNewton<T: Scalar, const D: usize> {
    settings: ProximalNewtonSettings<T>,
    core: ProximalPoint<T, D>,
}

impl<T: Scalar, const D: usize> ProximalNewton<T, D> {
    /// The solver with its settings.
    pub fn new(settings: ProximalNewtonSettings<T>) -> Self {
        Self { settings, core: ProximalPoint::new() }
    }
}

impl<T: Scalar, const D: usize> Family<T> for ProximalNewton<T, D> {
    const DESCRIPTION: Description = Description {
        name: "proximal-newton",
        title: "proximal point with semismooth Newton on the Alart–Curnier map",
        when: "hard problems (singular W, chains of contacts) and high accuracy",
        reference: "Alart and Curnier (1991), doi:10.1016/0045-7825(91)90022-X; Rockafellar (1976), doi:10.1137/0314056",
    };

    fn with_stopping(stopping: Stopping<T>) -> Self {
        Self::new(ProximalNewtonSettings { stopping, ..ProximalNewtonSettings::default() })
    }
}

impl<T: Scalar, const D: usize> ConeSolver<T, D> for ProximalNewton<T, D> {
    fn name(&self) -> &'static str {
        <Self as Family<T>>::DESCRIPTION.name
    }

    fn stopping(&self) -> &Stopping<T> {
        &self.settings.stopping
    }

    fn iterate(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        control: &mut Control<'_, T>,
    ) -> Result<usize, Breakdown> {
        self.core.run(problem, r, self.settings.proximal, 0, control)
    }

    fn workspace(&mut self) -> Option<&mut Workspace<T>> {
        Some(self.core.refinement.workspace())
    }
}

/// The proximal parameter's schedule.
struct Schedule<T> {
    a: T,
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
    fn new(a: T) -> Self {
        Self { a, floor: T::zero(), failures: 0, quick: false, wait: 0, penalty: 0, failed: T::zero() }
    }

    fn success(&mut self, steps: usize, gentle: bool) {
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

    fn failure(&mut self, gentle: bool) {
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

/// Newton steps between two starts: the problem is combinatorial, and from some places the path only circles.
struct Attempt {
    number: usize,
    begin: usize,
    end: usize,
}

impl Attempt {
    fn first(contacts: usize) -> Self {
        Self { number: 0, begin: 0, end: FIRST_ATTEMPT.0.max(FIRST_ATTEMPT.1 * contacts) }
    }

    fn next(&mut self, steps: usize, contacts: usize) {
        self.number += 1;
        self.begin = steps;
        self.end = steps + OTHER_ATTEMPT.0.max(OTHER_ATTEMPT.1 * contacts);
    }
}

/// The algorithm with its buffers.
#[derive(Debug, Clone)]
pub(super) struct ProximalPoint<T: Scalar, const D: usize> {
    scaled: Scaled<T, D>,
    inner: Inner<T, D>,
    refinement: Refinement<T, D>,
    best: Vec<SVector<T, D>>,
}

impl<T: Scalar, const D: usize> ProximalPoint<T, D> {
    pub(super) fn new() -> Self {
        Self { scaled: Scaled::new(), inner: Inner::new(), refinement: Refinement::new(), best: Vec::new() }
    }

    /// Improves `r`, counting iterations from `before`; `r` is left at the best iterate.
    pub(super) fn run(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        proximal: Option<T>,
        before: usize,
        control: &mut Control<'_, T>,
    ) -> Result<usize, Breakdown> {
        let Self { scaled, inner, refinement, best } = self;
        scaled.prepare(problem);
        inner.start(scaled, r);
        // Measured again in the problem's units, the residual may differ by rounding.
        let mut target = control.tolerance() * lit::<T>(0.95);
        let cold = lit::<T>(if problem.contacts() > 5_000 { 1e-2 } else { 1e-4 });
        let a = proximal.unwrap_or(cold);
        let mut schedule = Schedule::new(a);
        let mut attempt = Attempt::first(problem.contacts());
        scaled.map = Map::AlartCurnier;
        let budget = control.max_iterations(DEFAULT_STEPS);
        let mut steps = 0;
        let mut smallest = scaled.residual(&inner.r, &inner.w);
        best.clear();
        best.extend_from_slice(&inner.r);
        let mut reason = None;
        let mut finished = smallest <= target;
        // The residual below which refinement is worth another try.
        let mut refined_below = T::infinity_impl();
        let lowest = target * lit::<T>(1e-3);
        loop {
            if finished {
                // The little that is left may be larger in the problem's units, where percussions nearly cancel: on with it.
                scaled.leave(best, r);
                if problem.residual_in(r, refinement.workspace()).scaled <= control.tolerance()
                    || target <= lowest
                {
                    break;
                }
                target *= lit::<T>(0.25);
                (finished, refined_below) = (smallest <= target, T::infinity_impl());
            }
            if steps >= budget {
                break;
            }
            if smallest < refined_below {
                refined_below = smallest * lit::<T>(0.5);
                scaled.leave(best, r);
                let floor = problem.floor(r);
                if ConeProblem::<T, D>::is_near_floor(smallest, floor) {
                    let (residual, taken) = refinement.run(scaled, problem, r, (target, floor));
                    steps += taken;
                    if residual <= target.max(floor) {
                        return Ok(before + steps);
                    }
                }
            }
            let (outcome, taken) = inner.solve(scaled, schedule.a, target);
            steps += taken;
            let residual = scaled.residual(&inner.r, &inner.w);
            if residual < smallest || outcome == Outcome::Finished {
                smallest = residual;
                best.copy_from_slice(&inner.r);
            }
            let gentle = steps - attempt.begin > PATIENCE;
            match outcome {
                Outcome::Finished => finished = true,
                Outcome::Solved => schedule.success(taken, gentle),
                // The statuses of a start believed to be near were not right: back to it, with a cold start's caution.
                Outcome::Abandoned if proximal.is_some_and(|a| schedule.a == a && a < cold) => {
                    inner.return_to(scaled, best);
                    schedule = Schedule::new(cold);
                }
                Outcome::Abandoned => {
                    schedule.failure(gentle);
                    scaled.map = scaled.map.other();
                }
            }
            if !control.proceed(before + steps, residual) {
                break;
            }
            // f = 0 to the last digit, short of the target: nothing is left to improve from here.
            let exhausted = taken == 0 && outcome == Outcome::Solved;
            if !finished && (exhausted || schedule.failures >= MAX_FAILURES || steps >= attempt.end) {
                if attempt.number == MAX_ATTEMPTS {
                    reason = Some(format!("{MAX_ATTEMPTS} starts did not lead to a solution"));
                    break;
                }
                attempt.next(steps, problem.contacts());
                inner.restart(scaled, best, attempt.number);
                schedule = Schedule::new(lit(if attempt.number.is_multiple_of(2) { 1e-4 } else { 1e-8 }));
            }
        }
        scaled.leave(best, r);
        match reason {
            Some(message) => Err(Breakdown { iterations: before + steps, message }),
            None => Ok(before + steps),
        }
    }
}
