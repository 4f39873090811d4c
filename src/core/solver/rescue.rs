//! What is tried where the chosen solver failed: other starts, other methods, neighbouring problems.
//!
//! A frictional contact problem is combinatorial: a method that fails from one start succeeds from another, and where one
//! method stalls another seldom does at the same place. Nothing here runs, or allocates, before a solver has failed.

use std::time::{Duration, Instant};

use nalgebra::SVector;

use super::cone_solver::{ConeSolver, Iteration, Solution};
use super::control::Stopping;
use super::error::{Origin, RescueAttempt, RescueFailure, SolveError};
use super::pivoting::pivot;
use super::registry::{DEFAULT, SOLVERS, build, describe};
use crate::cone::ConeProblem;
use crate::scalar::{Scalar, epsilon, lit};

/// The attempts together take at most this multiple of the time limit of one solve.
pub const RESCUE_TIME: f64 = 2.0;

/// Iterations of one attempt: of methods that factor a matrix each, and of those that do not.
const STEPS: usize = 1_000;
const SWEEPS: usize = 20_000;
const PROGRAMS: usize = 100;

/// Contacts up to which an interior-point program is begun under a time limit: one factorisation of more takes from seconds to
/// minutes, and looks at no clock.
const PROGRAMMED: usize = 300;

/// Changes of b and μ, relative, of the problems whose solutions are starts.
const PERTURBATIONS: [f64; 3] = [1e-10, 1e-7, 1e-4];

/// [`ConeSolver::solve`] that does not give up with the chosen solver: see [`rescue`].
///
/// # Errors
/// Those of [`ConeSolver::solve`]; where nothing else solved the problem either, [`SolveError::Unsolved`].
pub fn solve_or_rescue<T: Scalar, const D: usize>(
    solver: &mut (impl ConeSolver<T, D> + ?Sized),
    problem: &ConeProblem<T, D>,
    (start, older): (&[SVector<T, D>], &[SVector<T, D>]),
    r: &mut [SVector<T, D>],
) -> Result<Solution<T>, SolveError> {
    let solved = solver.solve(problem, start, r);
    solved.or_else(|failure| rescue(failure, solver.stopping(), problem, older, r))
}

/// Looks for the solution that a solver with the rule `stopping` missed with `failure`, from its best percussions `r`:
///
/// 1. complementary pivoting, which for planar contacts ends in a solution where one can be expected;
/// 2. the problem with b and μ changed by a few roundings, whose solution is a start for the problem as it is;
/// 3. the same solver from zero and from `older` percussions (empty where there are none);
/// 4. where it is not certain that no percussions bring every velocity into K*: the same solver from its best, every other
///    registered one from the best and from zero, and larger changes of b and μ.
///
/// Every result is measured on the problem by the tolerance of `stopping`; [`Solution::rescued_by`] says who found it.
/// With a time limit all attempts together take at most [`RESCUE_TIME`] times the limit. A single contact is solved exactly
/// by every solver, and no method reaches a tolerance below ε: there is nothing to try.
///
/// # Errors
/// `failure` where it is not a missed tolerance; else [`SolveError::Unsolved`] with the attempts, `r` holding the best
/// percussions of all.
#[cold]
pub fn rescue<T: Scalar, const D: usize>(
    failure: SolveError,
    stopping: &Stopping<T>,
    problem: &ConeProblem<T, D>,
    older: &[SVector<T, D>],
    r: &mut [SVector<T, D>],
) -> Result<Solution<T>, SolveError> {
    let SolveError::NotConverged { solver, iterations, residual, .. } = failure else { return Err(failure) };
    // Below ε nothing is solved but by luck.
    if problem.contacts() < 2 || stopping.tolerance < epsilon() {
        return Err(failure);
    }
    let limit = stopping.max_seconds.and_then(|s| Duration::try_from_secs_f64(s * RESCUE_TIME).ok());
    let mut search = Search {
        problem,
        stopping,
        deadline: limit.and_then(|limit| Instant::now().checked_add(limit)),
        iterations,
        residual,
        best: r,
        failed: Vec::new(),
        margin: None,
    };
    let own = if SOLVERS.iter().any(|known| known.name == solver) { solver } else { DEFAULT };
    if let Some(solution) = search.run(own, older) {
        return Ok(solution);
    }
    let (others, margin) = (search.failed, search.margin);
    Err(SolveError::Unsolved(Box::new(RescueFailure { first: failure, others, margin })))
}

struct Search<'a, T: Scalar, const D: usize> {
    problem: &'a ConeProblem<T, D>,
    stopping: &'a Stopping<T>,
    deadline: Option<Instant>,
    iterations: usize,
    /// The best percussions so far, and their residual.
    residual: f64,
    best: &'a mut [SVector<T, D>],
    failed: Vec<RescueAttempt>,
    margin: Option<f64>,
}

impl<T: Scalar, const D: usize> Search<'_, T, D> {
    fn run(&mut self, own: &'static str, older: &[SVector<T, D>]) -> Option<Solution<T>> {
        let zero = vec![SVector::zeros(); self.problem.contacts()];
        let pivoted = pivot(self.problem, self.deadline);
        if let Some(solution) = pivoted.and_then(|start| self.attempt(own, Origin::Pivoting, &start)) {
            return Some(solution);
        }
        if let Some(solution) = self.by_perturbing(own, PERTURBATIONS[0]) {
            return Some(solution);
        }
        let given = [(Origin::Zero, &zero[..]), (Origin::Older, older)];
        for (origin, start) in given.into_iter().filter(|(_, start)| start.len() == zero.len()) {
            if let Some(solution) = self.attempt(own, origin, start) {
                return Some(solution);
            }
        }
        // Where no solution need exist, the others would look for it in vain, and long.
        self.margin = self.has_time_for(Iteration::Program).then(|| wedged(self.problem)).flatten();
        if self.margin.is_some() {
            return None;
        }
        let others = SOLVERS.iter().map(|solver| solver.name).filter(|&name| name != own);
        for name in std::iter::once(own).chain(others) {
            let best = self.best.to_vec();
            for (origin, start) in [(Origin::Best, &best), (Origin::Zero, &zero)] {
                if name == own && origin == Origin::Zero {
                    continue;
                }
                if let Some(solution) = self.attempt(name, origin, start) {
                    return Some(solution);
                }
            }
        }
        PERTURBATIONS[1..].iter().find_map(|&by| self.by_perturbing(own, by))
    }

    /// Whether an attempt of this kind may be begun.
    fn has_time_for(&self, iteration: Iteration) -> bool {
        let Some(deadline) = self.deadline else { return true };
        let few = iteration != Iteration::Program || self.problem.contacts() <= PROGRAMMED;
        few && Instant::now() < deadline
    }

    /// Iterations and seconds an attempt may take; `None` where no time is left.
    fn budget(&self, name: &str) -> Option<Stopping<T>> {
        let iteration = describe(name).ok()?.iteration;
        if !self.has_time_for(iteration) {
            return None;
        }
        let left = self.deadline.map(|deadline| deadline.saturating_duration_since(Instant::now()));
        let own = match iteration {
            Iteration::Sweep => SWEEPS,
            Iteration::Factorisation => STEPS,
            Iteration::Program => PROGRAMS,
        };
        let most = self.stopping.max_iterations.map_or(own, |given| given.min(own));
        let max_seconds = left.map(|left| left.as_secs_f64());
        Some(Stopping { tolerance: self.stopping.tolerance, max_iterations: Some(most), max_seconds })
    }

    fn attempt(
        &mut self,
        name: &'static str,
        origin: Origin,
        start: &[SVector<T, D>],
    ) -> Option<Solution<T>> {
        let mut solver = build::<T, D>(name, self.budget(name)?).ok()?;
        let mut r = start.to_vec();
        match solver.solve(self.problem, start, &mut r) {
            Ok(solution) => {
                self.best.copy_from_slice(&r);
                let iterations = self.iterations + solution.iterations;
                Some(Solution { iterations, rescued_by: Some(name), ..solution })
            }
            Err(SolveError::NotConverged { iterations, residual, .. }) => {
                self.iterations += iterations;
                self.failed.push(RescueAttempt { solver: name, origin, residual });
                if residual < self.residual {
                    self.residual = residual;
                    self.best.copy_from_slice(&r);
                }
                None
            }
            Err(_) => None,
        }
    }

    fn by_perturbing(&mut self, name: &'static str, by: f64) -> Option<Solution<T>> {
        let mut solver = build::<T, D>(name, self.budget(name)?).ok()?;
        let mut perturbed = self.problem.clone();
        let size = lit::<T>(by) * self.problem.b_norm();
        let (b, cones) = perturbed.terms_mut();
        for (i, (b, cone)) in b.iter_mut().zip(cones).enumerate() {
            // Outwards along the normal, so that what is too tight gets loose.
            let share = (0.618_033_988_749_894_9 * (i + 1) as f64).fract();
            b[0] += size * lit::<T>(share);
            *cone = cone.scaled(lit::<T>(1.0 - by * share));
        }
        let mut start = self.best.to_vec();
        let near = start.clone();
        // Whether that is solved or not, where it led to is a start.
        let _ = solver.solve(&perturbed, &near, &mut start);
        self.attempt(name, Origin::Perturbed(by), &start)
    }
}

/// The margin by which no percussions bring every velocity into K*, where that is certain.
#[cfg(feature = "clarabel")]
fn wedged<T: Scalar, const D: usize>(problem: &ConeProblem<T, D>) -> Option<f64> {
    use super::feasibility::{Feasibility, feasibility};
    match feasibility(problem) {
        Ok(Feasibility::Separated { margin, .. }) => Some(crate::scalar::to_f64(margin)),
        _ => None,
    }
}

/// Without clarabel nothing is certain.
#[cfg(not(feature = "clarabel"))]
fn wedged<T: Scalar, const D: usize>(_problem: &ConeProblem<T, D>) -> Option<f64> {
    None
}
