//! The passes of a step whose terms depend on its end: joints and nonlinear systems.

use super::equations::Equations;
use super::joints::{STAGNATION as JOINT_STAGNATION, Span};
use super::matrix::Matrix;
use super::no_joints::joints_of;
use super::nonlinear::Start;
use super::record::{Next, State};
use super::{Settings, StepError, ThetaScheme};
use crate::linalg::max_abs;
use crate::scalar::{Scalar, all_finite, epsilon, lit, to_f64};

/// Most passes of a step. Each gains a factor of the order of h‖ω‖, so that a sound step takes three to five.
const MOST_PASSES: usize = 50;

/// What is to be left of the equations of motion, in ε of their largest term.
const EQUATIONS: f64 = 8.0;

/// What rounding may leave of the equations of motion where M̂ is badly conditioned, in ε: once a pass gains nothing more,
/// this is enough. The balance (56) shows it.
const STAGNATION: f64 = 4096.0;

impl<'a, T: Scalar> Start<'a, T> {
    pub(super) fn of(state: &'a State<T>, settings: &Settings<T>, force: &'a [T]) -> Self {
        let Settings { theta, step, .. } = *settings;
        Self { time: state.time, step, theta, q: &state.q, v: &state.v, force }
    }
}

impl<T: Scalar, const D: usize> ThetaScheme<T, D> {
    /// F_{k+θ}, the end of the prescribed motions, v_{k+θ} ← v_k elsewhere as a first guess, and the iteration matrix of
    /// a nonlinear system.
    pub(super) fn start_passes(&mut self) -> Result<(), StepError> {
        let Self { system, settings, state, next, matrix: Matrix { free, .. }, rest, .. } = &mut *self;
        let Settings { theta, step: h, .. } = *settings;
        let Next { q, v, v_theta, v_free, force, scratch, .. } = next;
        system.forces().averaged(state.time, h, theta, force, scratch);
        let torques = system.fixed_torques();
        if let Some(torques) = torques {
            torques.averaged(state.time, h, theta, v_free, scratch);
            system.pull_back(&state.q, v_free, force);
        }
        if let Some(rest) = rest {
            rest.still(force);
        }
        if let Some(prescribed) = system.prescribed() {
            prescribed.set(state.time + h, h, theta, q, v);
        }
        let other = T::one() - theta;
        for i in *free..v.len() {
            v_theta[i] = other * state.v[i] + theta * v[i];
            v_free[i] = v[i];
        }
        v[..*free].copy_from_slice(&state.v[..*free]);
        v_theta[..*free].copy_from_slice(&state.v[..*free]);
        if !all_finite(&*force) {
            return Err(self.state_error("F", &self.next.force));
        }
        let varies = torques.is_some() || system.forces().varies();
        let Self { next, matrix, lasting, .. } = self;
        if let Some(lasting) = lasting.as_mut().filter(|l| l.wants_pull(varies)) {
            let Next { force, scratch, .. } = next;
            scratch.copy_from_slice(force);
            lasting.set_pull(&mut matrix.factor, scratch);
        }
        self.equations.passes = 0;
        let Self {
            system,
            settings,
            state,
            next,
            equations: Equations { nonlinear, scales, .. },
            matrix: Matrix { factor, .. },
            ..
        } = &mut *self;
        if let (Some(nonlinear), Some(dynamics)) = (nonlinear, system.nonlinear()) {
            let start = Start::of(state, settings, &next.force);
            let speed = nalgebra::RealField::max(scales.speed, max_abs(&state.v));
            if !nonlinear.linearise(dynamics, start, speed, factor) {
                let (step, time) = self.place();
                return Err(StepError::Mass { step, time });
            }
        }
        Ok(())
    }

    /// Whether the pass leaves nothing to iterate for.
    pub(super) fn is_last_pass(&mut self) -> Result<bool, StepError> {
        let Self {
            system,
            settings,
            state,
            next,
            equations: Equations { joints, .. },
            matrix: Matrix { factor, .. },
            lasting,
            flight,
            ..
        } = self;
        let mut worst = None::<(&'static str, T, T)>;
        if !joints.is_empty() {
            let span = Span::of(settings, state, flight.as_ref(), lasting.as_ref());
            let impulse = (!next.contacts.is_empty()).then_some(&next.impulse[..]);
            let left_over = joints.judge(&**system, span, factor, &next.v, impulse);
            let stagnates =
                self.equations.passes > 3 && !(left_over.excess < self.equations.left_over * lit::<T>(0.5));
            let ends = stagnates || impulse.is_none();
            let enough = lit::<T>(if ends { JOINT_STAGNATION } else { 1.0 });
            self.equations.left_over = left_over.excess;
            // Written so that a NaN goes on.
            if left_over.excess <= enough || ends && left_over.is_rounding {
                return Ok(true);
            }
            let contacts = impulse.is_some();
            self.equations.passes += 1;
            // Without contacts nothing changes from pass to pass.
            if contacts && self.equations.passes < MOST_PASSES {
                return Ok(false);
            }
            let ((step, time), passes) = (self.place(), self.equations.passes);
            let (excess, tolerance) = (to_f64(left_over.excess), to_f64(left_over.tolerance));
            let (joint, opening) = (joints_of(&*self.system).label(left_over.row), to_f64(left_over.opening));
            return Err(StepError::JointPasses { step, time, joint, opening, tolerance, excess, passes });
        }
        if let (Some(nonlinear), Some(dynamics)) = (&mut self.equations.nonlinear, system.nonlinear()) {
            let start = Start::of(state, settings, &next.force);
            let left_over = nonlinear.left_over(dynamics, start, &next.v, &next.impulse);
            let stagnates =
                self.equations.passes > 3 && left_over >= self.equations.left_over * lit::<T>(0.5);
            let enough = lit::<T>(if stagnates { STAGNATION } else { EQUATIONS }) * epsilon::<T>();
            self.equations.left_over = left_over;
            if !(left_over <= enough) {
                worst = Some(("the residual of the equations of motion", left_over, enough));
            }
        }
        let Some((what, left_over, tolerance)) = worst else { return Ok(true) };
        self.equations.passes += 1;
        if self.equations.passes < MOST_PASSES {
            return Ok(false);
        }
        let ((step, time), passes) = (self.place(), self.equations.passes);
        let (left_over, tolerance) = (to_f64(left_over), to_f64(tolerance));
        Err(StepError::Iteration { step, time, what, left_over, tolerance, passes })
    }
}
