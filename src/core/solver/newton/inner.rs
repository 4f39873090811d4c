//! The inner iteration: semismooth Newton on the proximal subproblem w_a(r) = W r + b + a (r − r_k).

use nalgebra::SVector;

use super::maps::{Formulation, Linear};
use super::scaled::ScaledProblem;
use super::watchdog::{Verdict, Watchdog};
use crate::scalar::{Scalar, lit};

/// Most halvings of a careful step.
const HALVINGS: usize = 12;

/// How a subproblem ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum InnerEnd {
    /// The residual of the outer problem reached the target on the way; the iterate is on the cones.
    Finished,
    /// The subproblem is solved well enough.
    Solved,
    /// It made too little progress, or its matrix had no pivot.
    Abandoned,
    /// The caller's clock has run out.
    Interrupted,
}

/// A subproblem centred at the current iterate, and how far it is taken.
#[derive(Debug, Clone, Copy)]
pub(super) struct Subproblem<T> {
    pub(super) formulation: Formulation,
    /// a of the equation.
    pub(super) proximal: T,
    /// a of the matrix: that of the equation, or next to nothing where that is 0, so that redundant contacts, which leave
    /// W singular, still have a step.
    pub(super) regular: T,
    /// It is solved where ‖f‖ has fallen to this part of its start.
    pub(super) reduction: T,
    /// Most Newton steps.
    pub(super) steps: usize,
}

/// Part of ‖f‖ at which a subproblem that ended without its reduction still counts as solved.
const ENOUGH: f64 = 0.03;

/// The iterate, the proximal centre and the buffers of the inner iteration, all scaled.
#[derive(Debug, Clone)]
pub(super) struct Inner<T: Scalar, const D: usize> {
    pub(super) r: Vec<SVector<T, D>>,
    pub(super) w: Vec<SVector<T, D>>,
    centre: Vec<SVector<T, D>>,
    reference: Vec<SVector<T, D>>,
    dr: Vec<SVector<T, D>>,
    dw: Vec<SVector<T, D>>,
    trial: Vec<SVector<T, D>>,
    trial_w: Vec<SVector<T, D>>,
    linear: Vec<Linear<T, D>>,
}

impl<T: Scalar, const D: usize> Inner<T, D> {
    pub(super) fn new() -> Self {
        let [r, w, centre, reference, dr, dw, trial, trial_w] = std::array::from_fn(|_| Vec::new());
        Self { r, w, centre, reference, dr, dw, trial, trial_w, linear: Vec::new() }
    }

    /// Starts from the percussions `r`.
    pub(super) fn start(&mut self, problem: &mut ScaledProblem<T, D>, r: &[SVector<T, D>]) {
        problem.enter(r, &mut self.r);
        let buffers = [
            &mut self.w,
            &mut self.centre,
            &mut self.reference,
            &mut self.dr,
            &mut self.dw,
            &mut self.trial,
            &mut self.trial_w,
        ];
        buffers.into_iter().for_each(|buffer| buffer.resize(problem.contacts(), SVector::zeros()));
        problem.velocity(&self.r, &mut self.w);
    }

    /// Moves to `r`.
    pub(super) fn move_to(&mut self, problem: &mut ScaledProblem<T, D>, r: &[SVector<T, D>]) {
        self.r.copy_from_slice(r);
        self.update(problem);
    }

    /// The velocities of percussions that were written to `self.r`.
    pub(super) fn update(&mut self, problem: &mut ScaledProblem<T, D>) {
        problem.velocity(&self.r, &mut self.w);
    }

    /// The scaled residual of the problem as given.
    pub(super) fn residual(&self, problem: &ScaledProblem<T, D>) -> T {
        problem.residual(&self.r, &self.w)
    }

    /// Solves the subproblem centred at the current iterate, telling `observe` of every Newton step (their number, the
    /// residual of the outer problem) until it answers false; returns how it ended and the Newton steps taken. `self.r` is
    /// left where the iteration ended, even if worse: what the failure saw is worth keeping.
    pub(super) fn solve(
        &mut self,
        problem: &mut ScaledProblem<T, D>,
        subproblem: &Subproblem<T>,
        target: T,
        observe: &mut dyn FnMut(usize, T) -> bool,
    ) -> (InnerEnd, usize) {
        let Subproblem { formulation, proximal: a, regular, reduction, steps: most } = *subproblem;
        self.centre.copy_from_slice(&self.r);
        self.reference.copy_from_slice(&self.r);
        let start = problem.merit(formulation, (&self.r, &self.w), (a, &self.centre));
        let mut merit = start;
        let mut watchdog = Watchdog::new(start);
        let mut steps = 0;
        while merit > start * reduction && steps < most {
            problem.linearise(formulation, (&self.r, &self.w), (a, &self.centre), &mut self.linear);
            steps += 1;
            if problem.factor(&self.linear, regular).is_err() {
                break;
            }
            problem.step(&self.linear, &mut self.dr);
            let verdict = if watchdog.trusts() {
                self.r.iter_mut().zip(&self.dr).for_each(|(r, dr)| *r += dr);
                problem.velocity(&self.r, &mut self.w);
                merit = problem.merit(formulation, (&self.r, &self.w), (a, &self.centre));
                watchdog.stepped(merit)
            } else {
                let length = self.search(problem, formulation, a, &watchdog);
                merit = problem.merit(formulation, (&self.r, &self.w), (a, &self.centre));
                watchdog.searched(length, merit)
            };
            match verdict {
                Verdict::Keep => {}
                Verdict::Promote => self.reference.copy_from_slice(&self.r),
                Verdict::Return => {
                    self.return_to_reference(problem);
                    merit = watchdog.reference();
                }
                Verdict::Stagnant => break,
            }
            let residual = self.residual(problem);
            if residual <= target && self.finish(problem, target) {
                return (InnerEnd::Finished, steps);
            }
            if !observe(steps, residual) {
                return (InnerEnd::Interrupted, steps);
            }
        }
        if !(merit < T::infinity_impl()) {
            self.return_to_reference(problem);
        }
        let solved = merit <= start * lit::<T>(ENOUGH);
        (if solved { InnerEnd::Solved } else { InnerEnd::Abandoned }, steps)
    }

    /// Moves to the projection of the iterate on the cones if that meets the target too: W may magnify the little the
    /// projection changes.
    fn finish(&mut self, problem: &mut ScaledProblem<T, D>, target: T) -> bool {
        problem.project(&self.r, &mut self.trial);
        problem.velocity(&self.trial, &mut self.trial_w);
        let finished = problem.residual(&self.trial, &self.trial_w) <= target;
        if finished {
            self.accept_trial();
        }
        finished
    }

    fn return_to_reference(&mut self, problem: &mut ScaledProblem<T, D>) {
        self.r.copy_from_slice(&self.reference);
        self.update(problem);
    }

    /// The longest of the steps 1, ½, ¼… that passes the watchdog's test, or the shortest tried; moves there and returns
    /// its length.
    fn search(
        &mut self,
        problem: &mut ScaledProblem<T, D>,
        formulation: Formulation,
        a: T,
        watchdog: &Watchdog<T>,
    ) -> T {
        problem.apply(&self.dr, &mut self.dw);
        let mut length = T::one();
        for halving in 0..=HALVINGS {
            for i in 0..self.r.len() {
                self.trial[i] = self.r[i] + self.dr[i] * length;
                self.trial_w[i] = self.w[i] + self.dw[i] * length;
            }
            let merit = problem.merit(formulation, (&self.trial, &self.trial_w), (a, &self.centre));
            if watchdog.accepts(merit, length) || halving == HALVINGS {
                break;
            }
            length *= lit::<T>(0.5);
        }
        if self.trial.iter().all(|x| crate::scalar::all_finite(x.iter())) {
            self.accept_trial();
        }
        length
    }

    fn accept_trial(&mut self) {
        std::mem::swap(&mut self.r, &mut self.trial);
        std::mem::swap(&mut self.w, &mut self.trial_w);
    }
}
