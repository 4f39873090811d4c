//! One trial: a step of 3h against three of h, and what is made of it.

use super::AdaptiveError;
use super::driver::{Adaptive, Record, SMOOTH};
use super::events::Meeting;
use crate::laws::ContactLaw;
use crate::scalar::{Scalar, epsilon, lit};
use crate::scheme::{ContactStep, StepError};
use crate::solver::ConeSolver;
use crate::system::MechanicalSystem;

/// What a trial came to.
pub(super) enum Attempt<T> {
    /// So many steps are kept.
    Kept(usize),
    /// A contact closes, or stops sliding, at this time from the start.
    Event(T),
    /// A bounce too low to be resolved is over after a step of this length.
    Rest(T),
    /// The error is too large: try this length.
    Smaller(T),
    /// The step could not be made.
    Failed(StepError),
}

/// Trials from one state after which an error that stays is that of a jump.
const PATIENCE: usize = 4;

/// Share of what is left for jumps that one of them takes.
const JUMP: f64 = 0.05;

fn larger<T: Scalar>(x: T, y: T) -> T {
    nalgebra::RealField::max(x, y)
}

impl<T, const D: usize, S, L, V> Adaptive<T, D, S, L, V>
where
    T: Scalar,
    S: MechanicalSystem<T, D>,
    L: ContactLaw<T, D>,
    V: ConeSolver<T, D>,
{
    /// Makes one step of the scheme.
    fn make(&mut self, length: T) -> Result<Result<(), StepError>, AdaptiveError> {
        self.scheme.set_step(length)?;
        self.report.computed += 1;
        Ok(self.scheme.step().map(drop))
    }

    /// Tries a step of length `size` from the start, `misses` trials having ended for an event.
    pub(super) fn attempt(&mut self, size: T, misses: usize) -> Result<Attempt<T>, AdaptiveError> {
        if let Err(error) = self.make(size)? {
            return Ok(Attempt::Failed(error));
        }
        let cross_check = self.against_path(size);
        self.set_path(size);
        let event = match self.meeting(size) {
            Some(Meeting::At(time)) => Some(Attempt::Event(time)),
            Some(Meeting::Rest(length)) => Some(Attempt::Rest(length)),
            None => self.end_of_sliding(size, misses).map(Attempt::Event),
        };
        if let Some(event) = event {
            self.scheme.recall(&self.start);
            return Ok(event);
        }
        let share = lit::<T>(SMOOTH) * self.settings.tolerance * size / self.span;
        // No longer than steps known to be good, or as another trial foresaw: one step is enough.
        let known = size <= self.control.verified * lit::<T>(0.5);
        if known || cross_check.is_some_and(|error| error <= share) {
            self.count(size, 1, cross_check.unwrap_or(T::zero()));
            self.keep(0);
            self.came_by = size;
            return Ok(Attempt::Kept(1));
        }
        self.ahead.0.copy_from_slice(&self.scheme.state().q);
        self.ahead.1.copy_from_slice(&self.scheme.state().v);
        let signature = signature(&self.scheme.last_step().contacts);
        self.scheme.recall(&self.start);

        let third = size / lit::<T>(3.0);
        let mut smooth = true;
        for i in 0..3 {
            if let Err(error) = self.make(third)? {
                self.scheme.recall(&self.start);
                return Ok(Attempt::Failed(error));
            }
            if let Some(time) = self.passing(i, third) {
                self.scheme.recall(&self.start);
                return Ok(Attempt::Event(time));
            }
            let contacts = &self.scheme.last_step().contacts;
            smooth &= signature == self::signature(contacts);
            smooth &= i == 0 || turned_not(&self.records[i - 1].step.contacts, contacts);
            self.keep(i);
        }
        if let Some(time) = self.dip(third) {
            self.scheme.recall(&self.start);
            return Ok(Attempt::Event(time));
        }
        let theta = self.scheme.settings().theta;
        let midpoint = nalgebra::ComplexField::abs(theta - lit::<T>(0.5)) <= lit::<T>(4.0) * epsilon::<T>();
        let order = if smooth && midpoint { lit::<T>(2.0) } else { T::one() };
        let state = self.scheme.state();
        let difference = self.distance((&self.ahead.0, &self.ahead.1), (&state.q, &state.v));
        let error = difference / if smooth && midpoint { lit::<T>(8.0) } else { lit::<T>(2.0) };
        self.last_error = (error, share);
        let jump = self.for_jumps * lit::<T>(JUMP);
        if !(error <= share) && self.trials >= PATIENCE && error <= jump {
            self.for_jumps -= error;
            self.count(third, 3, error);
            self.control.verified = T::zero();
        } else if error <= share {
            self.count(third, 3, error);
            self.control.kept(size, error / share, order);
        } else {
            self.trials += 1;
            self.scheme.recall(&self.start);
            return Ok(Attempt::Smaller(self.control.rejected(size, error / share, order)));
        }
        self.came_by = third;
        Ok(Attempt::Kept(3))
    }

    /// e_q + (T − t) e_v of the distance between two states, as a share of the scene's length.
    fn distance(&self, one: (&[T], &[T]), other: (&[T], &[T])) -> T {
        let (mut q, mut v) = (T::zero(), T::zero());
        for (i, &weight) in self.weights.iter().enumerate() {
            q = larger(q, weight * nalgebra::ComplexField::abs(one.0[i] - other.0[i]));
            v = larger(v, weight * nalgebra::ComplexField::abs(one.1[i] - other.1[i]));
        }
        q + v * self.remaining()
    }

    /// The error of the step just made, of length `size`, by the path of a longer trial from the same start: two
    /// approximations of second order whose difference vanishes as their lengths agree.
    fn against_path(&mut self, size: T) -> Option<T> {
        let longer = self.path.size;
        if !(size <= longer * lit::<T>(0.9)) {
            return None;
        }
        let Self { start, path, point, ahead, .. } = self;
        path.at(&start.q, &start.v, size, point);
        ahead
            .1
            .iter_mut()
            .zip(start.v.iter().zip(path.acceleration()))
            .for_each(|(x, (&v, &a))| *x = v + size * a);
        let state = self.scheme.state();
        let difference = self.distance((&self.point, &self.ahead.1), (&state.q, &state.v));
        Some(difference * longer / (longer - size))
    }

    fn set_path(&mut self, size: T) {
        let Self { scheme, start, path, weights, .. } = self;
        path.set(&start.q, &start.v, &scheme.state().q, size);
        let largest = path.acceleration().iter().zip(&*weights);
        self.acceleration =
            largest.fold(T::zero(), |a, (&x, &w)| larger(a, w * nalgebra::ComplexField::abs(x)));
    }

    /// The step just made is number `i` of those kept.
    fn keep(&mut self, i: usize) {
        let (state, step) = (self.scheme.state(), self.scheme.last_step());
        let Record { state: kept, step: kept_step } = &mut self.records[i];
        (kept.index, kept.time) = (state.index, state.time);
        kept.q.copy_from_slice(&state.q);
        kept.v.copy_from_slice(&state.v);
        kept_step.contacts.clone_from(&step.contacts);
        (kept_step.energies, kept_step.balance, kept_step.solution) =
            (step.energies, step.balance, step.solution);
    }

    fn count(&mut self, length: T, steps: usize, error: T) {
        let report = &mut self.report;
        report.accepted += steps;
        report.estimated_error += error;
        report.smallest_step = nalgebra::RealField::min(report.smallest_step, length);
        report.largest_step = larger(report.largest_step, length);
        self.trials = 0;
        let gone = length * lit::<T>(steps as f64);
        let left = self.control.to_event - gone;
        self.control.to_event = if left > self.least { left } else { T::zero() };
    }

    /// A step with an impact.
    pub(super) fn make_impact(&mut self, length: T) -> Result<usize, AdaptiveError> {
        self.make(length)??;
        self.report.events += 1;
        // The velocity is off by what the accelerations make of half the step.
        let error = self.acceleration * length * (length + self.remaining()) * lit::<T>(0.5);
        self.count(length, 1, error);
        self.keep(0);
        self.control.impact();
        self.came_by = T::zero();
        Ok(1)
    }

    /// A step in which a contact comes to rest.
    pub(super) fn make_rest(&mut self, length: T) -> Result<usize, AdaptiveError> {
        let size = nalgebra::RealField::min(length, self.control.size);
        self.make(size)??;
        self.report.events += 1;
        self.count(size, 1, self.closed / self.scheme.scales().length);
        self.keep(0);
        self.came_by = T::zero();
        Ok(1)
    }
}

/// What every active contact does, to see that none changed: open, sticking or sliding, mixed into one number.
fn signature<T: Scalar, const D: usize>(contacts: &[ContactStep<T, D>]) -> u64 {
    contacts.iter().fold(0xcbf2_9ce4_8422_2325, |hash, contact| {
        let sliding = (contact.before + contact.after).norm_squared()
            - (contact.before[0] + contact.after[0]) * (contact.before[0] + contact.after[0]);
        let speed = contact.before.norm_squared() + contact.after.norm_squared();
        let state = match contact.percussion[0] > T::zero() {
            false => 0,
            true if sliding > lit::<T>(1e-12) * speed => 1,
            true => 2,
        };
        if state == 0 { hash } else { (hash ^ (contact.id.0 * 4 + state)).wrapping_mul(0x0100_0000_01b3) }
    })
}

/// Whether H of the active contacts is the same in two steps: H(q_k) v_{k+1} of the first is H(q_{k+1}) v_{k+1} of the
/// second.
fn turned_not<T: Scalar, const D: usize>(one: &[ContactStep<T, D>], other: &[ContactStep<T, D>]) -> bool {
    one.len() == other.len()
        && one.iter().zip(other).all(|(one, other)| {
            let scale = one.before.norm() + one.after.norm() + other.after.norm();
            one.id == other.id && (one.after - other.before).norm() <= lit::<T>(1e3) * epsilon::<T>() * scale
        })
}
