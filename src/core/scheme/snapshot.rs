//! The state of a scheme as plain numbers, to go on from in another process.

use nalgebra::SVector;

use super::clock::Clock;
use super::lasting::{Lasting, LastingMark};
use super::memory::MemoryMark;
use super::nonlinear::Nonlinear;
use super::rest::{Rest, RestMark};
use super::{ContactStep, Settings, ThetaScheme};
use crate::contact::ContactId;
use crate::scalar::{Scalar, all_finite, lit, to_f64};

/// All that the next steps depend on, beside what the scheme was set up with: the state, and the percussions that
/// warm-start the cone solver. Exact for `f32` and `f64`.
///
/// Solvers keep buffers, no memory: what they return depends on the problem and the start alone.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "outputs", derive(serde::Serialize, serde::Deserialize))]
pub struct Snapshot {
    index: u64,
    /// Where the clock starts: its two parts, and the step it starts at.
    clock: [f64; 2],
    clock_index: u64,
    q: Vec<f64>,
    v: Vec<f64>,
    energies: [f64; 3],
    contacts: Vec<(ContactId, Vec<f64>)>,
    older: Vec<(ContactId, Vec<f64>)>,
    rest: Option<RestMark>,
    lasting: Option<LastingMark>,
    #[cfg_attr(feature = "outputs", serde(default))]
    memories: MemoryMark,
    /// Degrees of freedom that fly with θ of rest.
    #[cfg_attr(feature = "outputs", serde(default))]
    resting: Vec<u64>,
}

/// A snapshot that is not one of this scheme.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the snapshot does not fit: {what}")]
pub struct RestoreError {
    /// What does not fit.
    pub what: String,
}

impl Snapshot {
    /// Steps made.
    pub fn index(&self) -> usize {
        self.index as usize
    }
}

impl<T: Scalar, const D: usize> ThetaScheme<T, D> {
    /// The state reached, as plain numbers.
    pub fn snapshot(&self) -> Snapshot {
        let plain = |x: &[T]| x.iter().map(|&x| to_f64(x)).collect();
        let energies = &self.last.energies;
        let percussion = |contact: &ContactStep<T, D>| (contact.id, plain(contact.percussion.as_slice()));
        Snapshot {
            index: self.state.index as u64,
            clock: [self.clock.origin, self.clock.low].map(to_f64),
            clock_index: self.clock.index as u64,
            q: plain(&self.state.q),
            v: plain(&self.state.v),
            energies: [energies.kinetic, energies.elastic, energies.potential].map(to_f64),
            contacts: self.last.contacts.iter().map(percussion).collect(),
            older: self.warm.contacts.iter().map(percussion).collect(),
            rest: self.rest.as_ref().map(Rest::mark),
            lasting: self.lasting.as_ref().map(Lasting::mark),
            memories: self.memories.mark(),
            resting: self.flight.as_ref().map(|flight| flight.mark(self.settings.theta)).unwrap_or_default(),
        }
    }

    /// Goes to the state of a snapshot of a scheme set up as this one was; the steps from there are the same, digit
    /// by digit. Of the last step only the percussions and the energies are known.
    ///
    /// # Errors
    /// [`RestoreError`] where sizes differ or a number is not finite; the scheme is then unchanged.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), RestoreError> {
        let (coordinates, n) = (self.system.coordinates(), self.system.dofs());
        let refuse = |what: &str| Err(RestoreError { what: what.into() });
        if snapshot.q.len() != coordinates || snapshot.v.len() != n {
            return refuse(&format!("{} degrees of freedom for {n}", snapshot.v.len()));
        }
        let percussions = snapshot.contacts.iter().chain(&snapshot.older).map(|(_, p)| p);
        if percussions.clone().any(|p| p.len() != D) {
            return refuse("percussions of another dimension");
        }
        if snapshot.clock_index > snapshot.index || !all_finite(&snapshot.clock) {
            return refuse("its clock is none");
        }
        if !all_finite(snapshot.q.iter().chain(&snapshot.v).chain(percussions.flatten())) {
            return refuse("a number is not finite");
        }
        if let Some(rest) = &mut self.rest {
            let awake = RestMark::awake(rest.bodies());
            let mark = snapshot.rest.as_ref().unwrap_or(&awake);
            if rest.restore(mark, self.laws.len(), &snapshot.contacts).is_none() {
                return refuse("its bodies at rest are others");
            }
        }
        if let (Some(lasting), Some(mark)) = (&mut self.lasting, &snapshot.lasting)
            && lasting.restore(mark).is_none()
        {
            return refuse("its lasting contacts are others");
        }
        let Settings { theta, theta_rest, .. } = self.settings;
        if let Some(flight) = &mut self.flight
            && flight.restore(&snapshot.resting, theta, theta_rest).is_none()
        {
            return refuse("its bodies at rest are others");
        }
        if self.memories.restore(&snapshot.memories).is_none() {
            return refuse("its laws remember something else");
        }
        self.state.index = snapshot.index();
        self.warm.length = self.settings.step;
        let [origin, low] = snapshot.clock.map(lit);
        self.clock = Clock { origin, low, index: snapshot.clock_index as usize };
        self.state.time = self.clock.at(self.state.index, self.settings.step);
        self.state.q.iter_mut().zip(&snapshot.q).for_each(|(x, &y)| *x = lit(y));
        self.state.v.iter_mut().zip(&snapshot.v).for_each(|(x, &y)| *x = lit(y));
        self.system.mass().multiply(&self.state.v, &mut self.next.momentum[0]);
        if let Some(stiffness) = self.system.stiffness() {
            stiffness.multiply(&self.state.q, &mut self.next.elastic_force[0]);
        }
        if let Some(dynamics) = self.system.nonlinear() {
            self.equations.nonlinear = Some(Box::new(Nonlinear::new(dynamics, &self.state.q)));
        }
        let energies = &mut self.last.energies;
        [energies.kinetic, energies.elastic, energies.potential] = snapshot.energies.map(lit);
        for (list, numbers) in
            [(&mut self.last.contacts, &snapshot.contacts), (&mut self.warm.contacts, &snapshot.older)]
        {
            list.clear();
            list.extend(
                numbers.iter().map(|(id, p)| {
                    ContactStep::resting(*id, 0, T::zero(), SVector::from_fn(|i, _| lit(p[i])))
                }),
            );
        }
        Ok(())
    }
}
