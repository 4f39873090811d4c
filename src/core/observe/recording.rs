//! A run in memory, as arrays of numbers.

use nalgebra::SVector;

use super::{Frame, ObserveError, Observer, RunInfo};
use crate::contact::ContactId;
use crate::energy::Energies;
use crate::scalar::{Scalar, to_f64};
use crate::scheme::ContactStep;
use crate::system::System;

/// What an active contact did in a step, in numbers; vectors have a component per contact dimension, (N, T1, T2).
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ContactRecord {
    /// Identity, the same from step to step.
    pub id: ContactId,
    /// Name.
    pub contact: String,
    /// Interface, and so law, it belongs to.
    pub interface: usize,
    /// The gap the activation rule tested (m).
    pub gap: f64,
    /// Local velocity u_k (m/s).
    pub before: Vec<f64>,
    /// Local velocity u_{k+1} (m/s).
    pub after: Vec<f64>,
    /// Percussion p_{k+1} (N s).
    pub percussion: Vec<f64>,
    /// u_{N,k+θ} p_N (J).
    pub normal_work: f64,
    /// u_{T,k+θ}·p_T (J).
    pub tangential_work: f64,
}

impl ContactRecord {
    /// What a contact of a system did.
    pub fn new<T: Scalar, const D: usize>(
        system: &(impl System<T, D> + ?Sized),
        contact: &ContactStep<T, D>,
    ) -> Self {
        let components = |x: &SVector<T, D>| x.iter().map(|&x| to_f64(x)).collect();
        Self {
            id: contact.id,
            contact: system.contact_label(contact.id),
            interface: contact.interface,
            gap: to_f64(contact.gap),
            before: components(&contact.before),
            after: components(&contact.after),
            percussion: components(&contact.percussion),
            normal_work: to_f64(contact.normal_work),
            tangential_work: to_f64(contact.tangential_work),
        }
    }
}

/// A run as arrays: entry k of each list belongs to `times[k]`, the first to the start.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Recording {
    /// Law of the run.
    pub law: String,
    /// Cone solver.
    pub solver: String,
    /// Names of the components of q.
    pub coordinates: Vec<String>,
    /// Names of the components of v.
    pub dofs: Vec<String>,
    /// Times (s).
    pub times: Vec<f64>,
    /// Configurations.
    pub q: Vec<Vec<f64>>,
    /// Velocities.
    pub v: Vec<Vec<f64>>,
    /// Energies (J).
    pub energies: Vec<Energies<f64>>,
    /// The active contacts of the step that ends at the time; none at the start.
    pub contacts: Vec<Vec<ContactRecord>>,
}

/// Records a [`Recording`].
#[derive(Debug, Default)]
pub struct Recorder {
    every: usize,
    last: Option<usize>,
    recording: Recording,
}

impl Recorder {
    /// Records the first state, that after every `every` steps, and the last.
    pub fn new(every: usize) -> Self {
        Self { every: every.max(1), ..Self::default() }
    }

    /// What was recorded.
    pub fn finish(self) -> Recording {
        self.recording
    }

    fn record<T: Scalar, const D: usize>(&mut self, frame: Frame<'_, T, D>) {
        let (state, step) = (frame.state, frame.step);
        let plain = |values: &[T]| values.iter().map(|&x| to_f64(x)).collect();
        let Energies { kinetic, elastic, potential } = step.energies;
        self.last = Some(state.index);
        self.recording.times.push(to_f64(state.time));
        self.recording.q.push(plain(&state.q));
        self.recording.v.push(plain(&state.v));
        self.recording.energies.push(Energies {
            kinetic: to_f64(kinetic),
            elastic: to_f64(elastic),
            potential: to_f64(potential),
        });
        let record = |contact| ContactRecord::new(frame.system, contact);
        self.recording.contacts.push(step.contacts.iter().map(record).collect());
    }
}

impl<T: Scalar, const D: usize> Observer<T, D> for Recorder {
    fn begin(&mut self, run: &RunInfo, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        self.recording = Recording {
            law: run.law.clone(),
            solver: run.solver.clone(),
            coordinates: (0..frame.state.q.len()).map(|i| frame.system.coordinate_label(i)).collect(),
            dofs: (0..frame.state.v.len()).map(|i| frame.system.dof_label(i)).collect(),
            ..Recording::default()
        };
        self.record(frame);
        Ok(())
    }

    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        if frame.state.index.is_multiple_of(self.every) {
            self.record(frame);
        }
        Ok(())
    }

    fn end(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        if self.last != Some(frame.state.index) {
            self.record(frame);
        }
        Ok(())
    }
}
