//! One trial: a step of 3h against three of h, and what is made of it.

use super::AdaptiveError;
use super::held::{Adaptive, Meeting, Record, SMOOTH};
use crate::linalg::{axpy, max_abs};
use crate::scalar::{Scalar, epsilon, lit};
use crate::scheme::{ContactStep, StepError};

/// What is left of a difference beyond its rounding.
fn beyond<T: Scalar>(difference: T, rounding: T) -> T {
    // A NaN stays one: it is no small error.
    if difference <= rounding { T::zero() } else { difference - rounding }
}

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

/// Trials from one state after which an error that does not fall as that of smooth motion is one of a jump.
const PATIENCE: usize = 3;

/// Power of the length by which the error of a trial falls at least where the motion is smooth: two for contacts that
/// curve, three else.
const SMOOTH_POWER: f64 = 1.9;

/// Share of what is left for jumps that one of them takes.
pub(super) const JUMP: f64 = 0.05;

/// Share of ε for what a force does unseen, before a contact starts to slide or lifts.
const HIDDEN: f64 = 0.05;

/// Rounding of local velocities, in ε of the scene's speed.
const ROUNDING: f64 = 1e5;

/// What a few steps round a state by, in ε of its largest component: shorter steps do not make less of it.
const STATE_ROUNDING: f64 = 16.0;

fn larger<T: Scalar>(x: T, y: T) -> T {
    nalgebra::RealField::max(x, y)
}

impl<T: Scalar, const D: usize> Adaptive<T, D> {
    /// Makes one step of the scheme.
    fn make(&mut self, length: T) -> Result<Result<(), StepError>, AdaptiveError> {
        self.scheme.set_step(length)?;
        self.report.computed += 1;
        Ok(self.scheme.step().map(drop))
    }

    /// Tries a step of length `size` from the start, `misses` trials having ended for an event.
    pub(super) fn attempt(&mut self, size: T, misses: usize) -> Result<Attempt<T>, AdaptiveError> {
        let share = lit::<T>(SMOOTH) * self.settings.tolerance * size / self.span;
        if std::mem::take(&mut self.control.coasts) && !self.may_close(size, T::one()) {
            return self.coast(size, share);
        }
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
        // On the way to an event: no longer than steps known to be good, or as another trial foresaw, one step is enough.
        let approaches = self.control.to_event > T::zero() && size < self.control.size;
        let known = approaches && size <= self.control.verified * lit::<T>(0.5);
        if known || cross_check.is_some_and(|error| error <= share) {
            self.count(size, 1, if known { self.density * size } else { cross_check.unwrap_or(T::zero()) });
            self.keep(0);
            self.came_by = size;
            return Ok(Attempt::Kept(1));
        }
        self.ahead.0.copy_from_slice(&self.scheme.state().q);
        self.ahead.1.copy_from_slice(&self.scheme.state().v);
        let signature = signature(&self.scheme.last_step().contacts, self.still());
        self.scheme.recall(&self.start);
        let same = match self.three(size)? {
            Ok(same) => same,
            Err(ended) => return Ok(ended),
        };
        let smooth = same == Some(signature) && self.is_midpoint();
        let order = if smooth { lit::<T>(2.0) } else { T::one() };
        let difference = self.distance_ahead();
        let error = difference / if smooth { lit::<T>(8.0) } else { lit::<T>(2.0) };
        let hidden = self.unresolved_force(size);
        if hidden > T::one() {
            self.scheme.recall(&self.start);
            return Ok(Attempt::Smaller(self.control.for_force(size, hidden)));
        }
        let jump = self.for_jumps * lit::<T>(JUMP);
        let (before, longer) = self.last_trial;
        let falls = nalgebra::ComplexField::powf(size / longer, lit::<T>(SMOOTH_POWER));
        (self.last_error, self.last_trial) = ((error, share), (error, size));
        if error <= share {
            self.control.coasts = smooth && self.third_differences() <= share;
            self.control.contacts = signature;
            self.density = error / size;
            self.count(size / lit::<T>(3.0), 3, error);
            self.control.kept(size, error / share, order);
            self.control.for_force(size, hidden);
        } else if self.trials >= PATIENCE && error <= jump && !(error <= before * falls) {
            self.for_jumps -= error;
            self.count(size / lit::<T>(3.0), 3, error);
            self.control.jumped();
        } else {
            self.trials += 1;
            self.scheme.recall(&self.start);
            return Ok(Attempt::Smaller(self.control.rejected(size, error / share, order)));
        }
        self.came_by = size / lit::<T>(3.0);
        Ok(Attempt::Kept(3))
    }

    /// Three steps whose error is told by their own third differences, where those of the last three agreed with a longer
    /// step.
    fn coast(&mut self, size: T, share: T) -> Result<Attempt<T>, AdaptiveError> {
        let same = match self.three(size)? {
            Ok(same) => same,
            Err(ended) => return Ok(ended),
        };
        // Contacts that change between two triples change within the first step of the second.
        let same = same.filter(|&now| now == self.control.contacts);
        let (error, hidden) = (self.third_differences(), self.unresolved_force(size));
        if same.is_some() && hidden > T::one() {
            self.scheme.recall(&self.start);
            return Ok(Attempt::Smaller(self.control.for_force(size, hidden)));
        }
        if same.is_none() || !(error <= share) {
            self.scheme.recall(&self.start);
            let ratio = error / share;
            let again = if same.is_none() { size } else { self.control.rejected(size, ratio, lit::<T>(2.0)) };
            return Ok(Attempt::Smaller(again));
        }
        self.last_error = (error, share);
        self.control.coasts = true;
        self.density = error / size;
        self.count(size / lit::<T>(3.0), 3, error);
        self.control.kept(size, error / share, lit::<T>(2.0));
        self.control.for_force(size, hidden);
        self.came_by = size / lit::<T>(3.0);
        Ok(Attempt::Kept(3))
    }

    /// Makes three steps of a third of `size`: what their contacts do, if all do the same, or why they ended.
    fn three(&mut self, size: T) -> Result<Result<Option<u64>, Attempt<T>>, AdaptiveError> {
        let third = size / lit::<T>(3.0);
        let still = self.still();
        let mut same = None;
        for i in 0..3 {
            if let Err(error) = self.make(third)? {
                self.scheme.recall(&self.start);
                return Ok(Err(Attempt::Failed(error)));
            }
            if let Some(time) = self.passing(i, third) {
                self.scheme.recall(&self.start);
                return Ok(Err(Attempt::Event(time)));
            }
            let contacts = &self.scheme.last_step().contacts;
            let now = signature(contacts, still);
            let turned = i > 0 && !turned_not(&self.records[i - 1].step.contacts, contacts, still);
            same = if i == 0 { Some(now) } else { same.filter(|&before| before == now && !turned) };
            self.keep(i);
        }
        if let Some(time) = self.dip(third).filter(|_| self.watches) {
            self.scheme.recall(&self.start);
            return Ok(Err(Attempt::Event(time)));
        }
        Ok(Ok(same))
    }

    fn is_midpoint(&self) -> bool {
        let from_half = nalgebra::ComplexField::abs(self.scheme.settings().theta - lit::<T>(0.5));
        from_half <= lit::<T>(4.0) * epsilon::<T>()
    }

    /// Speed below which a local velocity is rounding.
    fn still(&self) -> T {
        lit::<T>(ROUNDING) * epsilon::<T>() * self.scheme.scales().speed
    }

    /// The error of three steps at θ = ½, whose local errors are h³/12 times the third derivatives of q and of v, by
    /// their third differences.
    fn third_differences(&mut self) -> T {
        let (mut q, mut v) = (T::zero(), T::zero());
        let [one, two, three] = &self.records;
        let system = self.scheme.system();
        let [first, second, third] = &mut self.motions;
        system.difference(&self.start.q, &one.state.q, first);
        system.difference(&one.state.q, &two.state.q, second);
        system.difference(&two.state.q, &three.state.q, third);
        for (i, &weight) in self.weights.iter().enumerate() {
            let turned = (third[i] - second[i]) - (second[i] - first[i]);
            q = larger(q, weight * nalgebra::ComplexField::abs(turned));
            let of = |x: &Record<T, D>| x.state.v[i];
            let bent = (of(three) - self.start.v[i]) - lit::<T>(3.0) * (of(two) - of(one));
            v = larger(v, weight * nalgebra::ComplexField::abs(bent));
        }
        let (rounding_q, rounding_v) = self.rounding();
        (beyond(q, rounding_q) + beyond(v, rounding_v) * self.remaining()) * lit::<T>(0.25)
    }

    /// What rounding makes of q and of v in a trial, as a share of the scene's length (and per second).
    fn rounding(&self) -> (T, T) {
        let largest = |x: &[T]| {
            let terms = x.iter().zip(&self.weights);
            terms.fold(T::zero(), |most, (&x, &w)| larger(most, w * nalgebra::ComplexField::abs(x)))
        };
        let unit = lit::<T>(STATE_ROUNDING) * epsilon::<T>();
        let state = self.scheme.state();
        let largest_place = |q: &[T]| {
            if self.scheme.system().is_flat() {
                return largest(q);
            }
            // Components of q are no degrees of freedom: the most that any of them may count.
            self.weights.iter().fold(T::zero(), |most, &w| larger(most, w)) * max_abs(q)
        };
        (
            unit * larger(largest_place(&self.start.q), largest_place(&state.q)),
            unit * larger(largest(&self.start.v), largest(&state.v)),
        )
    }

    /// What forces that vary in time may do between the ends of the three steps that are kept, together of length `size`, as
    /// an error until T over what is allowed: a body that sticks shows nothing of the forces on it until it slides.
    fn unresolved_force(&mut self, size: T) -> T {
        let third = size / lit::<T>(3.0);
        let still = self.still();
        let sticks =
            |contact: &ContactStep<T, D>| contact.percussion[0] > T::zero() && !slides(contact, still);
        if !self.scheme.system().forces().varies() || !self.scheme.last_step().contacts.iter().any(sticks) {
            return T::zero();
        }
        let Self { scheme, motions: [force, sum, _], weights, start, .. } = self;
        let from = start.time();
        let mut largest = T::zero();
        // Second differences over the four ends of steps.
        for offset in 0..2 {
            sum.fill(T::zero());
            for (i, factor) in [(0, T::one()), (1, -lit::<T>(2.0)), (2, T::one())] {
                scheme.system().forces().at(from + third * lit::<T>((offset + i) as f64), force);
                axpy(sum, factor, force);
            }
            scheme.accelerate(sum);
            let bend = sum.iter().zip(&*weights).map(|(&a, &w)| w * nalgebra::ComplexField::abs(a));
            largest = bend.fold(largest, larger);
        }
        // A parabola bends off its chord by an eighth of its second difference.
        let hidden = largest * lit::<T>(0.125) * third * self.remaining();
        hidden / (self.settings.tolerance * lit::<T>(HIDDEN))
    }

    /// e_q + (T − t) e_v of the distance between the state ahead and the one reached, as a share of the scene's length,
    /// beyond their rounding.
    fn distance_ahead(&mut self) -> T {
        let (mut q, mut v) = (T::zero(), T::zero());
        let (state, [motion, ..]) = (self.scheme.state(), &mut self.motions);
        self.scheme.system().difference(&state.q, &self.ahead.0, motion);
        for (i, &weight) in self.weights.iter().enumerate() {
            q = larger(q, weight * nalgebra::ComplexField::abs(motion[i]));
            v = larger(v, weight * nalgebra::ComplexField::abs(self.ahead.1[i] - state.v[i]));
        }
        let (rounding_q, rounding_v) = self.rounding();
        beyond(q, rounding_q) + beyond(v, rounding_v) * self.remaining()
    }

    /// The error of the step just made, of length `size`, by the path of a longer trial from the same start: two
    /// approximations of second order whose difference vanishes as their lengths agree.
    fn against_path(&mut self, size: T) -> Option<T> {
        let longer = self.path.size;
        if !(size <= longer * lit::<T>(0.9)) {
            return None;
        }
        let Self { scheme, start, path, ahead, .. } = self;
        path.at(scheme.system(), (&start.q, &start.v), size, &mut ahead.0);
        ahead
            .1
            .iter_mut()
            .zip(start.v.iter().zip(path.acceleration()))
            .for_each(|(x, (&v, &a))| *x = v + size * a);
        let difference = self.distance_ahead();
        Some(difference * longer / (longer - size))
    }

    fn set_path(&mut self, size: T) {
        let Self { scheme, start, path, weights, .. } = self;
        path.set(scheme.system(), (&start.q, &start.v), &scheme.state().q, size);
        let terms = path.acceleration().iter().zip(&*weights);
        let largest = terms.fold(T::zero(), |a, (&x, &w)| larger(a, w * nalgebra::ComplexField::abs(x)));
        // A short path shows the rounding of its ends: what was known before stands where it cannot tell better.
        let unseen = self.rounding().0 * lit::<T>(2.0) / (size * size);
        self.acceleration =
            larger(beyond(largest, unseen), nalgebra::RealField::min(self.acceleration, unseen));
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

/// What every active contact does, to see that none changed: open, sticking or sliding, mixed into one number. Speeds
/// below `still` are rounding.
fn signature<T: Scalar, const D: usize>(contacts: &[ContactStep<T, D>], still: T) -> u64 {
    contacts.iter().fold(0xcbf2_9ce4_8422_2325, |hash: u64, contact| {
        let state = match contact.percussion[0] > T::zero() {
            false => return hash,
            true if slides(contact, still) => 1,
            true => 2,
        };
        (hash ^ contact.id.digest().wrapping_mul(4).wrapping_add(state)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Whether a contact slides over a step, faster than `still` in the mean.
fn slides<T: Scalar, const D: usize>(contact: &ContactStep<T, D>, still: T) -> bool {
    let sum = contact.before + contact.after;
    larger(sum.norm_squared() - sum[0] * sum[0], T::zero()) > still * still
}

/// Whether H of the active contacts is the same in two steps: H(q_k) v_{k+1} of the first is H(q_{k+1}) v_{k+1} of the
/// second, to `still`.
fn turned_not<T: Scalar, const D: usize>(
    one: &[ContactStep<T, D>],
    other: &[ContactStep<T, D>],
    still: T,
) -> bool {
    one.len() == other.len()
        && one
            .iter()
            .zip(other)
            .all(|(one, other)| one.id == other.id && (one.after - other.before).norm() <= still)
}
