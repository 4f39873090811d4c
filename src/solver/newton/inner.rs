//! The inner iteration: semismooth Newton on the proximal subproblem w_a(r) = W r + b + a (r − r_k).

use nalgebra::{ComplexField, SVector};

use super::Scaled;
use super::maps::Linear;
use crate::scalar::{Scalar, from_usize, lit};

/// Newton steps after which a subproblem is abandoned.
const MAX_STEPS: usize = 20;
/// Free full steps without progress before the line search.
const FREE_STEPS: usize = 6;
/// Line-search steps before full steps are tried again.
const GUARDED_STEPS: usize = 2;
const HALVINGS: usize = 12;
/// Merits the non-monotone line search compares with.
const MEMORY: usize = 4;

/// How a subproblem ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::solver) enum Outcome {
    /// The residual of the outer problem reached the target on the way; the iterate is on the cones.
    Finished,
    /// The subproblem is solved well enough.
    Solved,
    Abandoned,
}

/// The iterate, the proximal centre and the buffers of the inner iteration, all scaled.
#[derive(Debug, Clone)]
pub(in crate::solver) struct Inner<T: Scalar, const D: usize> {
    pub(in crate::solver) r: Vec<SVector<T, D>>,
    pub(in crate::solver) w: Vec<SVector<T, D>>,
    centre: Vec<SVector<T, D>>,
    reference: Vec<SVector<T, D>>,
    dr: Vec<SVector<T, D>>,
    dw: Vec<SVector<T, D>>,
    trial: Vec<SVector<T, D>>,
    trial_w: Vec<SVector<T, D>>,
    linear: Vec<Linear<T, D>>,
}

impl<T: Scalar, const D: usize> Inner<T, D> {
    pub(in crate::solver) fn new() -> Self {
        Self {
            r: Vec::new(),
            w: Vec::new(),
            centre: Vec::new(),
            reference: Vec::new(),
            dr: Vec::new(),
            dw: Vec::new(),
            trial: Vec::new(),
            trial_w: Vec::new(),
            linear: Vec::new(),
        }
    }

    /// Starts from the percussions `r`.
    pub(in crate::solver) fn start(&mut self, problem: &mut Scaled<T, D>, r: &[SVector<T, D>]) {
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

    /// Starts number `attempt` from elsewhere: percussions of the size of `best`'s, spread over the cones by the golden
    /// ratio, so that every attempt tries other statuses.
    pub(in crate::solver) fn restart(
        &mut self,
        problem: &mut Scaled<T, D>,
        best: &[SVector<T, D>],
        attempt: usize,
    ) {
        let square = best.iter().fold(T::zero(), |sum, r| sum + r.norm_squared());
        let reach = [1.0, 10.0, 0.1, 100.0][attempt % 4];
        let size = (ComplexField::sqrt(square / from_usize::<T>(best.len())) + T::one()) * lit::<T>(reach);
        spread(&mut self.r, problem.friction(), size, attempt);
        problem.velocity(&self.r, &mut self.w);
    }

    /// Solves the subproblem centred at the current iterate with parameter `a`; returns how it ended and the Newton
    /// steps taken. `self.r` is left where the iteration ended, even if worse: what the failure saw is worth keeping.
    ///
    /// Globalisation: up to six free full steps (counted anew where the merit falls below 0.9 of the reference), else
    /// back to the reference and two non-monotone Armijo steps. Solved at 1e-3 of the start, or at 3 % when the
    /// iteration ends.
    pub(in crate::solver) fn solve(
        &mut self,
        problem: &mut Scaled<T, D>,
        a: T,
        target: T,
    ) -> (Outcome, usize) {
        self.centre.copy_from_slice(&self.r);
        let start = problem.merit(&self.r, &self.w, a, &self.centre);
        let mut merit = start;
        self.reference.copy_from_slice(&self.r);
        let mut reference_merit = start;
        let mut recent = [start; MEMORY];
        let (mut free, mut guarded, mut short, mut steps) = (0, 0, 0, 0);
        while merit > start * lit::<T>(1e-3) && steps < MAX_STEPS {
            problem.linearise(&self.r, &self.w, a, &self.centre, &mut self.linear);
            let factored = problem.step(&self.linear, a, &mut self.dr).is_ok();
            steps += 1;
            if !factored {
                break;
            }
            if guarded == 0 {
                self.r.iter_mut().zip(&self.dr).for_each(|(r, dr)| *r += dr);
                problem.velocity(&self.r, &mut self.w);
                merit = problem.merit(&self.r, &self.w, a, &self.centre);
                if merit < lit::<T>(0.9) * reference_merit {
                    self.reference.copy_from_slice(&self.r);
                    (reference_merit, free) = (merit, 0);
                } else {
                    free += 1;
                    if free == FREE_STEPS || !(merit < T::infinity_impl()) {
                        self.return_to_reference(problem);
                        (merit, free, guarded) = (reference_merit, 0, GUARDED_STEPS);
                        recent = [merit; MEMORY];
                    }
                }
            } else {
                let length = self.search(problem, a, recent);
                merit = problem.merit(&self.r, &self.w, a, &self.centre);
                recent.rotate_left(1);
                recent[MEMORY - 1] = merit;
                short += usize::from(length < lit::<T>(0.1));
                guarded -= 1;
                if guarded == 0 {
                    self.reference.copy_from_slice(&self.r);
                    reference_merit = merit;
                }
                if short == 3 {
                    break;
                }
            }
            if problem.residual(&self.r, &self.w) <= target && self.finish(problem, target) {
                return (Outcome::Finished, steps);
            }
        }
        if !(merit < T::infinity_impl()) {
            self.return_to_reference(problem);
        }
        let solved = merit <= start * lit::<T>(0.03);
        (if solved { Outcome::Solved } else { Outcome::Abandoned }, steps)
    }

    /// Moves to the projection of the iterate on the cones if that meets the target too: W may magnify the little the
    /// projection changes.
    fn finish(&mut self, problem: &mut Scaled<T, D>, target: T) -> bool {
        problem.project(&self.r, &mut self.trial);
        problem.velocity(&self.trial, &mut self.trial_w);
        let finished = problem.residual(&self.trial, &self.trial_w) <= target;
        if finished {
            std::mem::swap(&mut self.r, &mut self.trial);
            std::mem::swap(&mut self.w, &mut self.trial_w);
        }
        finished
    }

    /// Moves to `r`.
    pub(in crate::solver) fn return_to(&mut self, problem: &mut Scaled<T, D>, r: &[SVector<T, D>]) {
        self.r.copy_from_slice(r);
        problem.velocity(&self.r, &mut self.w);
    }

    fn return_to_reference(&mut self, problem: &mut Scaled<T, D>) {
        self.r.copy_from_slice(&self.reference);
        problem.velocity(&self.r, &mut self.w);
    }

    /// The longest of the steps 1, ½, ¼… that passes Armijo's test against the largest recent merit, or the shortest
    /// tried; moves there and returns its length.
    fn search(&mut self, problem: &mut Scaled<T, D>, a: T, recent: [T; MEMORY]) -> T {
        let bound = recent.into_iter().fold(T::zero(), |x, y| x.max(y));
        problem.apply(&self.dr, &mut self.dw);
        let mut length = T::one();
        for halving in 0..=HALVINGS {
            for i in 0..self.r.len() {
                self.trial[i] = self.r[i] + self.dr[i] * length;
                self.trial_w[i] = self.w[i] + self.dw[i] * length;
            }
            let merit = problem.merit(&self.trial, &self.trial_w, a, &self.centre);
            if merit <= bound * (T::one() - lit::<T>(1e-4) * length) || halving == HALVINGS {
                break;
            }
            length *= lit::<T>(0.5);
        }
        if length * T::zero() == T::zero() && self.trial.iter().all(|x| crate::scalar::all_finite(x.iter())) {
            std::mem::swap(&mut self.r, &mut self.trial);
            std::mem::swap(&mut self.w, &mut self.trial_w);
        }
        length
    }
}

/// The fractional part of the golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Percussions of about `size` spread over the cones by the quadratic Weyl sequence 2 frac(φ n²) in [0, 2), elsewhere for
/// every `attempt`.
pub(in crate::solver) fn spread<T: Scalar, const D: usize>(
    r: &mut [SVector<T, D>],
    friction: &[T],
    size: T,
    attempt: usize,
) {
    let mut n = (attempt * D * r.len()) as f64;
    let mut next = || {
        n += 1.0;
        2.0 * (GOLDEN * n * n).fract()
    };
    for (r, &mu) in r.iter_mut().zip(friction) {
        r[0] = size * lit::<T>(next());
        (1..D).for_each(|d| r[d] = mu * r[0] * lit::<T>(2.0 * next() - 2.0));
    }
}
