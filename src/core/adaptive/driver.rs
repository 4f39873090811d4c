//! The driver: from one step kept to the next.

use std::ops::ControlFlow;

use super::attempt::Attempt;
use super::control::Control;
use super::held::{Adaptive, JUMPS, Record, Report};
use super::path::Path;
use super::{AdaptiveError, AdaptiveSettings, Limit};
use crate::contact::Candidate;
use crate::scalar::{Scalar, epsilon, lit, to_f64};
use crate::scheme::{SetupError, State, Step, ThetaScheme};
use crate::system::{Joints, System};

/// γ, the gap that counts as closed, as a share of ε L.
const CLOSED: f64 = 1e-4;

/// Height of the lowest bounce that is told from rounding, in ε_machine of the scene's length: rule (55) takes what is
/// slower for rest.
const BOUNCE: f64 = 1024.0;

/// Accelerations towards a contact that are reckoned with, in the largest met on the last path.
const CAUTION: f64 = 8.0;

/// Trials from one state at most: each shrinks, and a length has 52 powers of two and a few.
const MOST_TRIALS: usize = 200;

impl<T: Scalar, const D: usize> Adaptive<T, D> {
    /// Takes a scheme over. Tolerances of its active set that the user left open follow ε.
    ///
    /// # Errors
    /// [`AdaptiveError::OutOfRange`], [`AdaptiveError::Setup`] for a system whose steps have one length, with joints
    /// that move, or of bodies that turn in space.
    pub fn new(mut scheme: ThetaScheme<T, D>, settings: AdaptiveSettings<T>) -> Result<Self, AdaptiveError> {
        if scheme.system().joints().is_some_and(Joints::moves) {
            return Err(SetupError::JointsAdaptive.into());
        }
        if scheme.system().flies() {
            return Err(SetupError::FlightAdaptive.into());
        }
        let start = scheme.state().time;
        let (least, first, largest) = settings.check(start)?;
        scheme.set_step(first)?;
        scheme.without_lasting_contacts();
        let scales = scheme.scales();
        let closed = lit::<T>(CLOSED) * settings.tolerance * scales.length;
        let activation = scheme.settings().activation;
        let (gap, velocity) = scheme.tolerances();
        let larger = nalgebra::RealField::max;
        let gap = if activation.gap_tolerance.is_some() { gap } else { larger(closed, gap) };
        let root = nalgebra::ComplexField::sqrt(lit::<T>(BOUNCE) * epsilon::<T>());
        let velocity = if activation.velocity_tolerance.is_some() {
            velocity
        } else {
            larger(velocity, root * scales.speed)
        };
        scheme.set_tolerances((gap, velocity));
        let dofs = scheme.state().v.len();
        let coordinates = scheme.state().q.len();
        let weight = |dof| if scheme.system().turns(dof) { T::one() } else { T::one() / scales.length };
        let weights = (0..dofs).map(weight).collect();
        let zeros = || vec![T::zero(); dofs];
        let record = || Record { state: scheme.state().clone(), step: scheme.last_step().clone() };
        let (records, start_state) = ([record(), record(), record()], scheme.saved());
        let on_ladder = scheme.factors_lengths();
        Ok(Self {
            span: settings.end - start,
            least,
            weights,
            closed: gap,
            on_ladder,
            control: Control::new(first, largest),
            start: start_state,
            came_by: T::zero(),
            ahead: (vec![T::zero(); coordinates], zeros()),
            motions: [zeros(), zeros(), zeros()],
            path: Path::new(dofs),
            records,
            near: Vec::new(),
            watches: true,
            candidates: Vec::new(),
            point: vec![T::zero(); coordinates],
            for_jumps: lit::<T>(JUMPS) * settings.tolerance,
            acceleration: scales.speed * scales.speed / (scales.length * scales.length),
            report: Report {
                accepted: 0,
                rejected: 0,
                computed: 0,
                events: 0,
                estimated_error: T::zero(),
                smallest_step: T::infinity_impl(),
                largest_step: T::zero(),
            },
            trials: 0,
            last_trial: (T::zero(), T::one()),
            density: T::zero(),
            last_error: (T::zero(), T::zero()),
            mark: (start, settings.end - start, 0),
            scheme,
            settings,
        })
    }

    /// The candidate contacts with gap ≤ `reach` in the state of the last step kept.
    pub fn candidates(&mut self, reach: T) -> &[Candidate<T>] {
        self.scheme.candidates(reach)
    }

    /// The scheme, in the state of the last step kept.
    pub fn scheme(&self) -> &ThetaScheme<T, D> {
        &self.scheme
    }

    /// The scheme, handed back.
    pub fn into_scheme(self) -> ThetaScheme<T, D> {
        self.scheme
    }

    /// The settings.
    pub fn settings(&self) -> &AdaptiveSettings<T> {
        &self.settings
    }

    /// What the run has cost so far.
    pub fn report(&self) -> &Report<T> {
        &self.report
    }

    /// What a component of q or v is multiplied with to be a share of the scene's length: 1/L, or 1 for angles.
    pub fn weights(&self) -> &[T] {
        &self.weights
    }

    /// Steps until `time`, exactly, and tells `kept` of every step kept, in order. A break ends the run after the steps
    /// that were kept together, three at most.
    ///
    /// # Errors
    /// [`AdaptiveError`]; the state is that of the last step kept, of which `kept` was told.
    pub fn advance_to<B>(
        &mut self,
        time: T,
        mut kept: impl FnMut(&dyn System<T, D>, &State<T>, &Step<T, D>) -> ControlFlow<B>,
    ) -> Result<ControlFlow<B>, AdaptiveError> {
        loop {
            let left = self.scheme.until(time);
            if !(left >= self.least) {
                return Ok(ControlFlow::Continue(()));
            }
            self.check_progress()?;
            let made = self.advance(left)?;
            let mut broken = ControlFlow::Continue(());
            for Record { state, step } in &self.records[..made] {
                let told = kept(self.scheme.system(), state, step);
                if broken.is_continue() {
                    broken = told;
                }
            }
            if broken.is_break() {
                return Ok(broken);
            }
        }
    }

    /// Makes one to three steps that are kept, `left` long at most; gives their number.
    fn advance(&mut self, left: T) -> Result<usize, AdaptiveError> {
        let smaller = nalgebra::RealField::min;
        let Self { scheme, start, control, .. } = self;
        scheme.save(start);
        self.path.forget();
        let mut size = smaller(control.size, left);
        if control.to_event > T::zero() {
            size = smaller(size, control.to_event);
        }
        self.look_around(size);
        self.watches = self.may_close(size, lit::<T>(CAUTION));
        let mut misses = 0;
        for _ in 0..MOST_TRIALS {
            if let Some(impact) = self.impact_length(size)? {
                return self.make_impact(smaller(self.on_rung(impact), left));
            }
            size = self.keep_open(size);
            // The rest of the run is no rung of the ladder, nor is it to be missed by a rounding.
            size = if size >= left { left } else { self.on_rung(size) };
            match self.attempt(size, misses)? {
                Attempt::Kept(steps) => return Ok(steps),
                Attempt::Rest(rest) => return self.make_rest(smaller(self.on_rung(rest), left)),
                Attempt::Event(time) => {
                    misses += 1;
                    self.report.rejected += 1;
                    self.control.to_event = time;
                    self.shrink(&mut size, time, Limit::Event)?;
                }
                Attempt::Smaller(to) => {
                    self.report.rejected += 1;
                    self.shrink(&mut size, to, Limit::Error)?;
                }
                Attempt::Failed(error) => {
                    self.report.rejected += 1;
                    let quarter = size * lit::<T>(0.25);
                    if quarter < self.least {
                        return Err(error.into());
                    }
                    self.control.size = smaller(self.control.size, quarter);
                    size = quarter;
                }
            }
        }
        Err(self.underflow(size, Limit::Event))
    }

    /// Sees that a thousandth of the span takes no more steps than allowed.
    fn check_progress(&mut self) -> Result<(), AdaptiveError> {
        let left = self.scheme.until(self.settings.end);
        let (since, left_then, computed_then) = self.mark;
        if left_then - left >= self.span * lit::<T>(1e-3) {
            self.mark = (self.scheme.state().time, left, self.report.computed);
            return Ok(());
        }
        let steps = self.report.computed - computed_then;
        if steps <= self.settings.max_steps {
            return Ok(());
        }
        let (error, share) = self.last_error;
        Err(AdaptiveError::TooManySteps {
            time: to_f64(self.scheme.state().time),
            since: to_f64(since),
            steps,
            most: self.settings.max_steps,
            error: to_f64(error),
            share: to_f64(share),
        })
    }

    fn shrink(&self, size: &mut T, to: T, limit: Limit) -> Result<(), AdaptiveError> {
        if !(to >= self.least) {
            return Err(self.underflow(to, limit));
        }
        *size = to;
        Ok(())
    }

    pub(super) fn underflow(&self, step: T, limit: Limit) -> AdaptiveError {
        let (error, share) = self.last_error;
        AdaptiveError::Underflow {
            time: to_f64(self.scheme.state().time),
            limit,
            step: to_f64(step),
            least: to_f64(self.least),
            error: to_f64(error),
            share: to_f64(share),
        }
    }

    /// The longest length not above `size` whose factors are kept.
    pub(super) fn on_rung(&self, size: T) -> T {
        if !self.on_ladder {
            return size;
        }
        let two = lit::<T>(2.0);
        let slack = T::one() + lit::<T>(16.0) * epsilon::<T>();
        let power = nalgebra::ComplexField::floor(nalgebra::ComplexField::log2(size * slack / self.span));
        let rung = self.span * nalgebra::ComplexField::powf(two, power);
        // Half a power between two: a third of it is a power again.
        let between = rung * lit::<T>(1.5);
        if between <= size * slack { between } else { rung }
    }

    /// T − t, for errors of the velocity.
    pub(super) fn remaining(&self) -> T {
        let left = self.scheme.until(self.settings.end);
        nalgebra::RealField::max(left, T::zero())
    }
}
