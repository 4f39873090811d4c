//! A run with a much finer step, sampled.

use super::reference::{Reference, visit_between};
use crate::observe::{Frame, ObserveError, Observer};
use crate::scalar::{Scalar, to_f64};

/// A run as samples of equal distance; between two of them q and v are linear. Where every step is a sample that is the
/// scheme's own motion, and where only each s-th is, an impact is known to s h.
#[derive(Debug)]
pub(super) struct Sampled {
    dofs: usize,
    times: Vec<f64>,
    /// q, v, the sum of percussions and the energy, sample after sample.
    values: Vec<f64>,
    stride: usize,
    percussion: f64,
    /// Ends of the steps with percussions whose predecessors had none.
    jumps: Vec<f64>,
    pressing: bool,
}

/// Jumps remembered: a contact that trembles makes one every other step.
const MOST_JUMPS: usize = 100_000;

impl Sampled {
    /// Samples of a run of `steps` steps of a system of `dofs` degrees of freedom, in about `bytes` of memory.
    pub(super) fn new(dofs: usize, steps: usize, bytes: usize) -> Self {
        let most = (bytes / (8 * (2 * dofs + 3))).max(2);
        Self {
            dofs,
            times: Vec::new(),
            values: Vec::new(),
            stride: steps.div_ceil(most).max(1),
            percussion: 0.0,
            jumps: Vec::new(),
            pressing: false,
        }
    }

    fn width(&self) -> usize {
        2 * self.dofs + 2
    }

    fn sample<T: Scalar, const D: usize>(&mut self, frame: Frame<'_, T, D>) {
        let (state, energies) = (frame.state, &frame.step.energies);
        self.times.push(to_f64(state.time));
        self.values.extend(state.q.iter().chain(&state.v).map(|&x| to_f64(x)));
        self.values.extend([self.percussion, to_f64(energies.total())]);
    }

    /// The place of a time: a sample and the share of the way to the next.
    fn place(&self, time: f64) -> (usize, f64) {
        let last = self.times.len() - 1;
        let next = self.times.partition_point(|&t| t < time).clamp(1.min(last), last);
        let before = next.saturating_sub(1);
        let (from, to) = (self.times[before], self.times[next]);
        let share = if to > from { ((time - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        (before, share)
    }

    fn value(&self, (sample, share): (usize, f64), column: usize) -> f64 {
        let width = self.width();
        let before = self.values[sample * width + column];
        let next = self.values.get((sample + 1) * width + column).copied().unwrap_or(before);
        before + share * (next - before)
    }
}

impl<T: Scalar, const D: usize> Observer<T, D> for Sampled {
    fn begin(&mut self, _run: &crate::observe::RunInfo, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        self.sample(frame);
        Ok(())
    }

    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        let contacts = frame.step.contacts.iter();
        let percussion: f64 = contacts.map(|contact| to_f64(contact.percussion[0])).sum();
        let pressing = percussion > 0.0;
        if pressing && !self.pressing && self.jumps.len() < MOST_JUMPS {
            self.jumps.push(to_f64(frame.state.time));
        }
        (self.percussion, self.pressing) = (self.percussion + percussion, pressing);
        if frame.state.index.is_multiple_of(self.stride) {
            self.sample(frame);
        }
        Ok(())
    }

    fn end(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        if self.times.last().is_some_and(|&time| time < to_f64(frame.state.time)) {
            self.sample(frame);
        }
        Ok(())
    }
}

impl Reference for Sampled {
    fn at(&self, time: f64, q: &mut [f64], v: &mut [f64]) {
        let place = self.place(time);
        q.iter_mut().enumerate().for_each(|(i, q)| *q = self.value(place, i));
        v.iter_mut().enumerate().for_each(|(i, v)| *v = self.value(place, self.dofs + i));
    }

    fn jumps(&self, from: f64, to: f64, visit: &mut dyn FnMut(f64)) {
        visit_between(&self.jumps, |&time| time, (from, to), visit);
    }

    fn percussion(&self, time: f64) -> f64 {
        self.value(self.place(time), 2 * self.dofs)
    }

    fn energy(&self, time: f64) -> f64 {
        self.value(self.place(time), 2 * self.dofs + 1)
    }
}
