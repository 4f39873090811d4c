//! Newton and the proximal point method around it, from one start to the next, until the budget ends.

use nalgebra::SVector;

use super::inner::{Inner, InnerEnd, Subproblem};
use super::maps::Formulation;
use super::refine::Refinement;
use super::scaled::ScaledProblem;
use super::schedule::{Schedule, Start};
use crate::cone::{ConeProblem, Workspace};
use crate::scalar::{Scalar, epsilon, lit};
use crate::solver::control::Control;
use crate::solver::error::{Breakdown, BreakdownCause};

/// Newton steps where the caller's stopping rule does not say: the hard problems are combinatorial.
const BUDGET: usize = 6_000;
/// Starts after which the method gives up.
const MAX_STARTS: usize = 1_000;
/// Reduction of ‖f‖ at which a proximal subproblem is solved, and most of its Newton steps.
const REDUCTION: f64 = 1e-3;
const INNER_STEPS: usize = 20;
/// What the matrix of a direct step holds of the proximal term, in ε: enough to leave a singular system a step, too little
/// to slow the last ones.
const REGULAR: f64 = 1e4;
/// The first proximal parameter where nothing better is known, up to and above a number of contacts.
const COLD: (f64, f64, usize) = (1e-4, 1e-2, 5_000);

/// What one solver chooses differently from another.
#[derive(Debug, Clone, Copy)]
pub(in crate::solver) struct Plan<T> {
    /// The equation of the first subproblem; the other one takes its turn after a failure.
    pub(in crate::solver) formulation: Formulation,
    /// Newton steps on the problem itself, a = 0, that precede the proximal point method.
    pub(in crate::solver) direct_steps: usize,
    /// Whether the proximal point method follows where they fail.
    pub(in crate::solver) fallback: bool,
    /// First proximal parameter; `None` takes 1e-4, or 1e-2 above 5,000 contacts.
    pub(in crate::solver) proximal: Option<T>,
}

impl<T> Default for Plan<T> {
    /// The proximal point method alone.
    fn default() -> Self {
        let formulation = Formulation::AlartCurnier;
        Self { formulation, direct_steps: 0, fallback: true, proximal: None }
    }
}

/// The proximal point method r_{k+1} = solution of w = W r + b + a (r − r_k), each subproblem by semismooth Newton
/// (Rockafellar 1976, doi:10.1137/0314056).
#[derive(Debug, Clone)]
pub(in crate::solver) struct ProximalPoint<T: Scalar, const D: usize> {
    scaled: ScaledProblem<T, D>,
    inner: Inner<T, D>,
    refinement: Refinement<T, D>,
    best: Vec<SVector<T, D>>,
}

impl<T: Scalar, const D: usize> ProximalPoint<T, D> {
    pub(in crate::solver) fn new() -> Self {
        let (scaled, inner, refinement) = (ScaledProblem::new(), Inner::new(), Refinement::new());
        Self { scaled, inner, refinement, best: Vec::new() }
    }

    /// The workspace of the problem's products.
    pub(in crate::solver) fn workspace(&mut self) -> &mut Workspace<T> {
        self.refinement.workspace()
    }

    /// Improves `r`, counting iterations from `before`; `r` is left at the best iterate.
    pub(in crate::solver) fn run(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        plan: &Plan<T>,
        before: usize,
        control: &mut Control<'_, T>,
    ) -> Result<usize, Breakdown> {
        let Self { scaled, inner, refinement, best } = self;
        scaled.prepare(problem);
        inner.start(scaled, r);
        // Measured again in the problem's units, the residual may differ by rounding.
        let mut target = control.tolerance() * lit::<T>(0.95);
        let lowest = target * lit::<T>(1e-3);
        let cold = lit::<T>(if problem.contacts() > COLD.2 { COLD.1 } else { COLD.0 });
        let first = plan.proximal.unwrap_or(cold);
        let mut schedule = Schedule::new(first);
        let mut start = Start::first(problem.contacts());
        let mut formulation = plan.formulation;
        let mut direct = plan.direct_steps > 0;
        let budget = control.max_iterations(BUDGET);
        let mut steps = 0;
        let mut smallest = inner.residual(scaled);
        best.clear();
        best.extend_from_slice(&inner.r);
        let mut finished = smallest <= target;
        // The residual below which refinement is worth another try.
        let mut refined_below = T::infinity_impl();
        let mut breakdown = None;
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
                    let (residual, taken) = refinement.run(scaled, formulation, problem, r, (target, floor));
                    steps += taken;
                    if residual <= target.max(floor) {
                        return Ok(before + steps);
                    }
                }
            }
            let subproblem = if direct {
                let regular = lit::<T>(REGULAR) * epsilon::<T>();
                let (proximal, reduction, steps) = (T::zero(), T::zero(), plan.direct_steps);
                Subproblem { formulation, proximal, regular, reduction, steps }
            } else {
                let (a, steps) = (schedule.a, INNER_STEPS);
                Subproblem { formulation, proximal: a, regular: a, reduction: lit(REDUCTION), steps }
            };
            let left = Subproblem { steps: subproblem.steps.min(budget - steps), ..subproblem };
            let mut observe = |taken, residual| control.proceed(before + steps + taken, residual);
            let (end, taken) = inner.solve(scaled, &left, target, &mut observe);
            steps += taken;
            let residual = inner.residual(scaled);
            if residual < smallest || end == InnerEnd::Finished {
                smallest = residual;
                best.copy_from_slice(&inner.r);
            }
            let gentle = start.is_gentle(steps);
            match end {
                InnerEnd::Finished => finished = true,
                InnerEnd::Interrupted => break,
                _ if direct && !plan.fallback => {
                    breakdown = Some(BreakdownCause::Stagnation { formulation });
                    break;
                }
                _ if direct => {
                    direct = false;
                    inner.move_to(scaled, best);
                }
                // f = 0 to the last digit, short of the target: nothing is left to improve from here.
                InnerEnd::Solved if taken == 0 => schedule.exhaust(),
                InnerEnd::Solved => schedule.success(taken, gentle),
                // The statuses of a start believed to be near were not right: back to it, with a cold start's caution.
                InnerEnd::Abandoned if plan.proximal.is_some_and(|a| schedule.a == a && a < cold) => {
                    inner.move_to(scaled, best);
                    schedule = Schedule::new(cold);
                }
                InnerEnd::Abandoned => {
                    schedule.failure(gentle);
                    formulation = formulation.other();
                }
            }
            if finished {
                // The last step, which the inner iteration did not tell of.
                if !control.proceed(before + steps, residual) {
                    break;
                }
            } else if schedule.gave_up() || start.is_over(steps) {
                if start.number == MAX_STARTS {
                    breakdown = Some(BreakdownCause::Starts { starts: MAX_STARTS });
                    break;
                }
                start = start.next(steps, problem.contacts());
                start.place(best, scaled.cones(), &mut inner.r);
                inner.update(scaled);
                schedule = Schedule::new(lit(if start.number.is_multiple_of(2) { 1e-4 } else { 1e-8 }));
            }
        }
        scaled.leave(best, r);
        let iterations = before + steps;
        breakdown.map_or(Ok(iterations), |cause| Err(Breakdown { iterations, cause }))
    }
}
