//! The last digits: Newton steps on velocities evaluated precisely.

use nalgebra::SVector;

use super::maps::{Formulation, Linear};
use super::scaled::ScaledProblem;
use crate::cone::{ConeProblem, Workspace, project};
use crate::scalar::{Scalar, epsilon, lit};

/// Steps at most; each gains some digits, and a solution within reach of rounding lacks few.
const MOST_STEPS: usize = 5;

/// Parts of W that the Newton step adds, in ε: enough to leave redundant contacts a step, too little to slow it; where that
/// stalls, next to nothing: contacts that are redundant but for the overlap of their bodies carry percussions of the size
/// of 1/(that little), and none other.
const REGULAR: f64 = 1e4;
const NEXT_TO_NOTHING: f64 = 1.0;

/// Iterative refinement of a solution that rounding of W r + b keeps from its tolerance: the Newton step of the
/// statuses found, from velocities of [`ConeProblem::precise_velocities`], added to percussions in the problem's units.
#[derive(Debug, Clone)]
pub(super) struct Refinement<T: Scalar, const D: usize> {
    w: Vec<SVector<T, D>>,
    scaled_r: Vec<SVector<T, D>>,
    scaled_w: Vec<SVector<T, D>>,
    step: Vec<SVector<T, D>>,
    linear: Vec<Linear<T, D>>,
    best: Vec<SVector<T, D>>,
    workspace: Workspace<T>,
}

impl<T: Scalar, const D: usize> Refinement<T, D> {
    pub(super) fn new() -> Self {
        let [w, scaled_r, scaled_w, step, best] = std::array::from_fn(|_| Vec::new());
        Self { w, scaled_r, scaled_w, step, linear: Vec::new(), best, workspace: Workspace::default() }
    }

    /// The workspace of the problem's products.
    pub(super) fn workspace(&mut self) -> &mut Workspace<T> {
        &mut self.workspace
    }

    /// Refines `r` down to `target` or as far as it goes; returns the scaled residual of the iterate where `r` is left and
    /// the Newton steps taken.
    ///
    /// Within the floor of the residual the last iterate is the best: what its residual shows is the rounding of large
    /// percussions on light bodies, under which the velocities of heavy ones still come right.
    pub(super) fn run(
        &mut self,
        scaled: &mut ScaledProblem<T, D>,
        formulation: Formulation,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        (target, floor): (T, T),
    ) -> (T, usize) {
        let Self { w, scaled_r, scaled_w, step, linear, best, workspace } = self;
        let (mut least, mut steps) = (T::infinity_impl(), 0);
        let (mut regular, mut most) = (REGULAR, MOST_STEPS);
        // What comes back where no residual is a number.
        best.clear();
        best.extend_from_slice(r);
        loop {
            w.clear();
            problem.precise_velocities(r, workspace, &mut |_, velocity| w.push(velocity));
            let residual = problem.residual_at(r, w).scaled;
            let gains = residual < least * lit::<T>(0.7);
            if residual < least || residual <= floor {
                least = residual;
                best.clear();
                best.extend_from_slice(r);
            }
            if residual <= target {
                break;
            }
            if !gains || steps == most {
                if residual <= floor || least <= floor || regular == NEXT_TO_NOTHING {
                    break;
                }
                (regular, most) = (NEXT_TO_NOTHING, steps + MOST_STEPS);
            }
            scaled.enter(r, scaled_r);
            scaled.enter_velocities(w, scaled_w);
            step.clear();
            step.resize(r.len(), SVector::zeros());
            scaled.linearise(formulation, (scaled_r, scaled_w), (T::zero(), scaled_r), linear);
            if scaled.factor(linear, lit::<T>(regular) * epsilon::<T>()).is_err() {
                break;
            }
            scaled.step(linear, step);
            steps += 1;
            for ((i, r), step) in r.iter_mut().enumerate().zip(step.iter()) {
                *r = project(&(*r + step * scaled.unit(i)), problem.cones()[i]);
            }
        }
        r.copy_from_slice(best);
        (least, steps)
    }
}
