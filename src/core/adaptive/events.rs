//! Impacts, bounces too low to matter, and ends of sliding: where steps are to end.

use super::attempt::JUMP;
use super::held::{Adaptive, Meeting, Near};
use super::roots::{falling_root, parabola_minimum};
use super::{AdaptiveError, Limit};
use crate::contact::ContactId;
use crate::scalar::{Scalar, epsilon, lit};
use crate::scheme::ActivationRule;

/// Gap at which a flight ends for an impact, and up to which a closing contact is made one, in γ.
const LANDING: f64 = 0.3;
const NEAR: f64 = 2.0;

/// Gap that a contact which closes at its present speed is to keep over a flight, in γ: the active set leaves it out, and an
/// impact is made from there.
const BEFORE: f64 = 1.1;

/// What the smallest step may move a body by at an impact, in γ.
const COARSE: f64 = 100.0;

/// Share of ε for the error that the velocity makes of one impact.
const IMPACT: f64 = 1e-2;

/// Speed up to which sliding has ended, in ε L/(T − t).
const SLIDING: f64 = 1e-2;

fn abs<T: Scalar>(x: T) -> T {
    nalgebra::ComplexField::abs(x)
}

fn smaller<T: Scalar>(x: T, y: T) -> T {
    nalgebra::RealField::min(x, y)
}

fn larger<T: Scalar>(x: T, y: T) -> T {
    nalgebra::RealField::max(x, y)
}

impl<T: Scalar, const D: usize> Adaptive<T, D> {
    /// Finds the candidates that steps of length `size` may close.
    pub(super) fn look_around(&mut self, size: T) {
        let Self { scheme, start, candidates, near, closed, .. } = self;
        let scales = scheme.scales();
        let largest = start.v.iter().fold(T::zero(), |largest, &v| larger(largest, abs(v)));
        // |u_N| is at most the sum of both bodies' velocities and of what their spin makes at a length.
        let two = lit::<T>(2.0);
        let reach = *closed * lit::<T>(4.0) + two * (two + scales.length) * (largest + scales.speed) * size;
        scheme.candidates_at(&start.q, reach, candidates);
        near.clear();
        for candidate in &*candidates {
            let (id, gap) = (candidate.id, candidate.gap);
            let rate = scheme.gap_rate(id, &start.q, &start.v);
            near.push(Near { id, gap, rate, gaps: [gap; 4], seen: false });
        }
    }

    fn was_near(&self, id: ContactId) -> Option<&Near<T>> {
        self.near.iter().find(|near| near.id == id)
    }

    /// Whether a contact is touched at the start: an impact is made from there, no flight. So is one that closes before
    /// the smallest step is over.
    fn touched(&self, near: &Near<T>) -> bool {
        let least_flight = self.least * lit::<T>(3.0);
        near.gap <= larger(self.closed * lit::<T>(NEAR), -near.rate * least_flight)
    }

    /// The length of a step with an impact at its middle, where a contact touched approaches.
    ///
    /// # Errors
    /// The smallest length would move a body by far more than what counts as closed, and by more than ε has left for it.
    pub(super) fn impact_length(&mut self, size: T) -> Result<Option<T>, AdaptiveError> {
        let half = lit::<T>(0.5);
        let mut wanted = None::<(T, T)>;
        for near in self.near.iter().filter(|near| self.touched(near)) {
            let speed = -near.rate;
            // Slower, the jump moves nothing by more than the gap that counts as closed.
            if !(speed * size > half * self.closed) {
                continue;
            }
            let to_wall = larger(near.gap, half * self.closed * lit::<T>(LANDING));
            let centred = (to_wall + to_wall) / speed;
            let (shortest, fastest) = wanted.unwrap_or((centred, speed));
            wanted = Some((smaller(shortest, centred), larger(fastest, speed)));
        }
        let Some((centred, speed)) = wanted else { return Ok(None) };
        let drift = larger(self.acceleration * self.remaining(), self.least);
        let length = smaller(centred, lit::<T>(IMPACT) * self.settings.tolerance / drift);
        if length < self.least && self.least * speed > self.closed * lit::<T>(COARSE) {
            // How far the middle of the smallest step is from the impact, and what accelerations make of the velocity in it.
            let off = larger(self.least - centred, T::zero()) * speed / self.scheme.scales().length;
            let cost = half * (off + self.acceleration * self.least * self.remaining());
            if !(cost <= self.for_jumps * lit::<T>(JUMP)) {
                return Err(self.underflow(length, Limit::Event));
            }
            self.for_jumps -= cost;
        }
        Ok(Some(larger(length, self.least)))
    }

    /// The longest length, `size` at most, over which no contact that is open closes at its present speed: the rules by
    /// predicted gaps would make it active, and none may be passed through.
    pub(super) fn keep_open(&mut self, mut size: T) -> T {
        let rule = self.scheme.settings().activation.rule;
        // A rule by gaps as they are makes contacts active once they are closed.
        let by_prediction = rule != ActivationRule::CurrentGap;
        let kept = if by_prediction { self.closed * lit::<T>(BEFORE) } else { T::zero() };
        // Room for half an impact step, where the smallest goes further.
        let least = self.least;
        let before = |rate: T| larger(kept, -rate * least);
        // A longer flight may carry a body through another, and show no overlap at its end.
        for near in self.near.iter().filter(|near| near.rate < T::zero() && !self.touched(near)) {
            size = smaller(size, (near.gap - before(near.rate)) / -near.rate);
        }
        if !by_prediction {
            return size;
        }
        let velocity_tolerance = self.scheme.tolerances().1;
        for _ in 0..40 {
            let Self { scheme, start, candidates, point, closed, motions: [motion, ..], .. } = self;
            motion.iter_mut().zip(&start.v).for_each(|(s, &v)| *s = size * v);
            scheme.system().advance(&start.q, motion, point);
            scheme.candidates_at(point, *closed, candidates);
            let mut shortest = size;
            for i in 0..self.candidates.len() {
                let (id, then) = (self.candidates[i].id, self.candidates[i].gap);
                let Some(near) = self.was_near(id) else {
                    shortest = smaller(shortest, size * lit::<T>(0.5));
                    continue;
                };
                let ignored = rule == ActivationRule::MoreauJean && near.rate > velocity_tolerance;
                if self.touched(near) || ignored {
                    continue;
                }
                let to_go = (near.gap - before(near.rate)) / (near.gap - then);
                shortest = smaller(shortest, size * to_go);
            }
            if !(shortest < size) || shortest < self.least {
                break;
            }
            size = shortest;
        }
        size
    }

    /// Whether a contact that is open, or opens, may close within the time `size`: a trial step then comes first, whose path
    /// tells when.
    pub(super) fn may_close(&self, size: T, caution: T) -> bool {
        let acceleration = caution * self.acceleration * self.scheme.scales().length;
        let falls = |near: &Near<T>| near.gap + size * (near.rate - acceleration * size) < T::zero();
        let moves = |near: &Near<T>| abs(near.rate) * size > self.closed;
        self.near.iter().any(|near| (!self.touched(near) || moves(near)) && falls(near))
    }

    fn is_active(&self, id: ContactId) -> bool {
        self.scheme.last_step().contacts.iter().any(|contact| contact.id == id)
    }

    /// Finds the contacts that overlap at the end of a trial, and were left out of it.
    fn overlapping(&mut self) -> Option<T> {
        let Self { scheme, candidates, point, closed, .. } = self;
        point.copy_from_slice(&scheme.state().q);
        scheme.candidates_at(point, -*closed, candidates);
        (!candidates.is_empty()).then_some(*closed)
    }

    /// Where the first contact closes that overlaps at the end of the trial just made, of length `size`; the path is
    /// that of the trial.
    pub(super) fn meeting(&mut self, size: T) -> Option<Meeting<T>> {
        let closed = self.overlapping()?;
        let mut first = None::<Meeting<T>>;
        for i in 0..self.candidates.len() {
            let (id, end) = (self.candidates[i].id, self.candidates[i].gap);
            if self.is_active(id) {
                continue;
            }
            let near = self.was_near(id).copied();
            let near = near.unwrap_or(Near {
                id,
                gap: closed + closed,
                rate: T::zero(),
                gaps: [end; 4],
                seen: false,
            });
            if !(end < smaller(near.gap, T::zero()) - closed) {
                continue;
            }
            let meeting = self.closing(&near, end, size);
            first = Some(match (first, meeting) {
                (Some(Meeting::At(one)), Meeting::At(other)) => Meeting::At(smaller(one, other)),
                (Some(at @ Meeting::At(_)), Meeting::Rest(_)) => at,
                (Some(Meeting::Rest(one)), Meeting::Rest(other)) => Meeting::Rest(smaller(one, other)),
                (_, meeting) => meeting,
            });
            // The root of one gap walks through the candidates.
            self.overlapping();
        }
        first
    }

    fn closing(&mut self, near: &Near<T>, end: T, size: T) -> Meeting<T> {
        let (half, closed) = (lit::<T>(0.5), self.closed);
        let landing = closed * lit::<T>(LANDING);
        let mut level = landing;
        let mut from = (T::zero(), near.gap - landing);
        let mut fine = closed * lit::<T>(0.05);
        if near.gap <= landing || (self.touched(near) && near.rate > T::zero()) {
            // It has just bounced: the way up comes first.
            let fall = (end - near.gap - near.rate * size) * lit::<T>(2.0) / (size * size);
            if !(near.rate > T::zero() && fall < T::zero()) {
                return Meeting::At(size * half);
            }
            let top = -near.rate / fall;
            // Where the active set would keep it in a flight this low, the law may as well bring it to rest.
            let room = (closed * lit::<T>(0.999) - near.gap) / near.rate;
            let rule = self.scheme.settings().activation.rule;
            let kept = rule != ActivationRule::MoreauJean || near.rate <= self.scheme.tolerances().1;
            if room >= top + top && kept {
                return Meeting::Rest(room);
            }
            fine = smaller(fine, near.rate * top * lit::<T>(1e-3));
            level = smaller(near.gap, landing);
            from = (top, self.gap_on_path(near, top) - level);
            if !(from.1 > T::zero()) {
                return Meeting::At(size * half);
            }
        }
        let close = fine + lit::<T>(4.0) * epsilon::<T>() * self.scheme.scales().length;
        let time =
            falling_root(from, (size, end - level), close, |time| self.gap_on_path(near, time) - level);
        Meeting::At(time)
    }

    fn gap_on_path(&mut self, near: &Near<T>, time: T) -> T {
        let Self { scheme, start, candidates, point, path, .. } = self;
        path.at(scheme.system(), (&start.q, &start.v), time, point);
        let reach = larger(abs(near.gap), scheme.scales().length);
        scheme.candidates_at(point, reach, candidates);
        candidates.iter().find(|candidate| candidate.id == near.id).map_or(reach, |candidate| candidate.gap)
    }

    /// Speed up to which sliding counts as ended.
    fn stopped(&self) -> T {
        let remaining = larger(self.remaining(), self.span * lit::<T>(1e-2));
        lit::<T>(SLIDING) * self.settings.tolerance * self.scheme.scales().length / remaining
    }

    /// Where in the trial just made, of length `size`, a contact stops sliding one way.
    pub(super) fn end_of_sliding(&self, size: T, misses: usize) -> Option<T> {
        if D == 1 {
            return None;
        }
        let still = self.stopped();
        let tangential = |u: &nalgebra::SVector<T, D>| u.norm_squared() - u[0] * u[0];
        let mut first = None::<T>;
        for contact in &self.scheme.last_step().contacts {
            let speed = nalgebra::ComplexField::sqrt(larger(tangential(&contact.before), T::zero()));
            if !(speed > still) {
                continue;
            }
            let along =
                |u: &nalgebra::SVector<T, D>| (u.dot(&contact.before) - u[0] * contact.before[0]) / speed;
            if along(&contact.after) > still * lit::<T>(0.25) {
                continue;
            }
            // It slowed down on the way here: it stops where that leads.
            let before = self.start.contacts.iter().find(|before| before.id == contact.id);
            let slowing = before
                .filter(|_| self.came_by > T::zero())
                .map(|before| (along(&before.before) - along(&before.after)) / self.came_by);
            let time = match slowing.filter(|&slowing| slowing > T::zero()) {
                Some(slowing) => (speed - still * lit::<T>(0.5)) / slowing,
                None => size * lit::<T>(0.125),
            };
            let misses = lit::<T>(misses as f64);
            let time = time * (T::one() - lit::<T>(0.02) * smaller(misses * misses, lit::<T>(25.0)));
            let time = if time < size { time } else { size * lit::<T>(0.5) };
            first = Some(first.map_or(time, |first| smaller(first, time)));
        }
        first
    }

    /// Looks at the gaps after step `i` of three of length `third`: where the next trial is to end if a contact has closed.
    pub(super) fn passing(&mut self, i: usize, third: T) -> Option<T> {
        let fresh = |id: ContactId| !self.near.iter().any(|near| near.id == id && self.touched(near));
        let hit = self.scheme.last_step().contacts.iter().any(|c| c.percussion[0] > T::zero() && fresh(c.id));
        if hit {
            return Some(if i > 0 { third * lit::<T>(i as f64) } else { third * lit::<T>(0.5) });
        }
        if !self.watches {
            return None;
        }
        let Self { scheme, candidates, point, near, closed, .. } = self;
        point.copy_from_slice(&scheme.state().q);
        let reach = near.iter().fold(*closed, |reach, near| larger(reach, near.gaps[i]));
        scheme.candidates_at(point, reach, candidates);
        near.iter_mut().for_each(|near| near.seen = false);
        let mut first = None::<T>;
        for candidate in &*candidates {
            let Some(near) = near.iter_mut().find(|near| near.id == candidate.id) else { continue };
            near.seen = true;
            near.gaps[i + 1] = candidate.gap;
            let active = scheme.last_step().contacts.iter().any(|contact| contact.id == candidate.id);
            if !active && candidate.gap < smaller(near.gap, T::zero()) - *closed {
                let (from, to) = (near.gaps[i], candidate.gap);
                let part = larger(from, T::zero()) / larger(from - to, *closed);
                let time = third * (lit::<T>(i as f64) + larger(part, lit::<T>(0.5)));
                first = Some(first.map_or(time, |first| smaller(first, time)));
            }
        }
        near.iter_mut().filter(|near| !near.seen).for_each(|near| near.gaps[i + 1] = near.gaps[i]);
        first
    }

    /// Where a gap had a minimum, over three steps of length `third`, that may have closed it.
    pub(super) fn dip(&self, third: T) -> Option<T> {
        let mut first = None::<T>;
        for near in self.near.iter().filter(|near| !self.touched(near)) {
            for (offset, gaps) in near.gaps.windows(3).enumerate() {
                let Some((at, least)) = parabola_minimum([gaps[0], gaps[1], gaps[2]]) else { continue };
                let place = at + lit::<T>(offset as f64);
                let (from, to) =
                    ([lit::<T>(3e-3), lit::<T>(1.5)][offset], [lit::<T>(1.5), lit::<T>(2.97)][offset]);
                let sampled = smaller(gaps[0], smaller(gaps[1], gaps[2]));
                let uncertain = lit::<T>(0.2) * (sampled - least) + self.closed;
                if place > from && place <= to && least < uncertain {
                    let time = place * third;
                    first = Some(first.map_or(time, |first| smaller(first, time)));
                }
            }
        }
        first
    }
}
