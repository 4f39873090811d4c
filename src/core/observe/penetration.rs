//! How deep bodies are in each other.

use std::any::Any;

use nalgebra::SVector;
use serde::{Deserialize, Serialize};

use super::Frame;
use crate::contact::ContactId;
use crate::scalar::{Scalar, to_f64};
use crate::scheme::ContactStep;

/// A contact is looked at where it may be deeper than this share of the deepest so far.
const NEAR: f64 = 0.5;

/// Depths of overlap at the active contacts of a run, as the configurations have them (m); 0 where nothing overlaps.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Penetration {
    /// The largest of all steps.
    pub largest: f64,
    /// When it was (s).
    pub time: f64,
    /// Label of the contact, empty where nothing overlaps.
    pub contact: String,
    /// The largest after the last step.
    pub last: f64,
}

impl Penetration {
    fn meet(&mut self, depth: f64, time: f64, label: impl FnOnce() -> String) {
        if depth > self.largest {
            (self.largest, self.time, self.contact) = (depth, time, label());
        }
    }
}

/// Finds the [`Penetration`] of a run. Of a contact that is new the configuration before the step counts as well: its law
/// may have opened it again.
#[derive(Debug)]
pub(super) struct Depths {
    pub(super) found: Penetration,
    /// Whether a configuration before the step is known: not after a resumption, whose contacts are.
    starts: bool,
    /// The configuration before the step, a `Vec<T>` of the run.
    before: Box<dyn Any + Send>,
    time: f64,
}

impl Default for Depths {
    fn default() -> Self {
        Self::resume(Penetration::default())
    }
}

impl Depths {
    pub(super) fn resume(found: Penetration) -> Self {
        Self { found, starts: false, before: Box::new(()), time: 0.0 }
    }

    /// Remembers where the step to come starts.
    pub(super) fn start<T: Scalar, const D: usize>(&mut self, frame: Frame<'_, T, D>) {
        self.starts = true;
        self.time = to_f64(frame.state.time);
        match self.before.downcast_mut::<Vec<T>>() {
            Some(before) if before.len() == frame.state.q.len() => before.copy_from_slice(&frame.state.q),
            _ => self.before = Box::new(frame.state.q.clone()),
        }
    }

    /// Looks at the contacts of a step; `touched` are those of the step before, in their order. Gaps are dear: of those that were
    /// there before and cannot be nearly as deep as the deepest so far, by the gap they were found with and their velocities, none
    /// is taken.
    pub(super) fn step<T: Scalar, const D: usize>(&mut self, frame: Frame<'_, T, D>, touched: &[ContactId]) {
        let time = to_f64(frame.state.time);
        let length = time - self.time;
        let speed = |u: &SVector<T, D>| u.iter().fold(0.0, |sum, &u| sum + to_f64(u).abs());
        for contact in &frame.step.contacts {
            let label = || frame.system.contact_label(contact.id);
            if let (Some(before), true) = (self.before.downcast_ref::<Vec<T>>(), self.starts)
                && touched.binary_search(&contact.id).is_err()
            {
                let depth = -to_f64(frame.system.gap(contact.id, before));
                self.found.meet(depth, self.time, label);
            }
            let moved = 2.0 * length * (speed(&contact.before) + speed(&contact.after));
            if moved - to_f64(contact.gap) <= NEAR * self.found.largest {
                continue;
            }
            self.found.meet(-to_f64(frame.system.gap(contact.id, &frame.state.q)), time, label);
        }
        self.start(frame);
    }

    /// Looks at where the last step has left its contacts.
    pub(super) fn end<T: Scalar, const D: usize>(&mut self, frame: Frame<'_, T, D>) {
        let depth = |contact: &ContactStep<T, D>| -to_f64(frame.system.gap(contact.id, &frame.state.q));
        self.found.last = frame.step.contacts.iter().map(depth).fold(0.0, f64::max);
    }
}
