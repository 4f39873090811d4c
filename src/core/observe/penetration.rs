//! How deep bodies are in each other.

use std::any::Any;

use serde::{Deserialize, Serialize};

use super::Frame;
use crate::contact::ContactId;
use crate::scalar::{Scalar, to_f64};

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

    /// Looks at the contacts of a step; `touched` are those of the step before, in their order.
    pub(super) fn step<T: Scalar, const D: usize>(&mut self, frame: Frame<'_, T, D>, touched: &[ContactId]) {
        self.found.last = 0.0;
        for contact in &frame.step.contacts {
            let label = || frame.system.contact_label(contact.id);
            if let (Some(before), true) = (self.before.downcast_ref::<Vec<T>>(), self.starts)
                && touched.binary_search(&contact.id).is_err()
            {
                let depth = -to_f64(frame.system.gap(contact.id, before));
                self.found.meet(depth, self.time, label);
            }
            let depth = -to_f64(frame.system.gap(contact.id, &frame.state.q));
            self.found.meet(depth, to_f64(frame.state.time), label);
            self.found.last = self.found.last.max(depth);
        }
        self.start(frame);
    }
}
