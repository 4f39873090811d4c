//! Lagrangian systems with constant M, optional C, K, F(t), and smooth gaps.

use std::fmt;

use super::{Contacts, Describe, Dynamics, Forces, Scales, SmoothContacts, SmoothGap, SystemError};
use crate::contact::{Candidate, ContactId};
use crate::linalg::{BlockRows, Symmetric};
use crate::scalar::{Scalar, all_finite, to_f64};

/// M v̇ + C v + K q = F(t) + Hᵀ(q) r with constant M, C, K.
pub struct Lagrangian<T: Scalar, const D: usize> {
    mass: Symmetric<T>,
    damping: Option<Symmetric<T>>,
    stiffness: Option<Symmetric<T>>,
    forces: Forces<T>,
    contacts: SmoothContacts<T, D>,
    scales: Option<Scales<T>>,
    /// Names of coordinates and contacts; by number where there are none.
    labels: [Vec<String>; 2],
}

impl<T: Scalar, const D: usize> Lagrangian<T, D> {
    /// A free system of mass `mass`; whether M is positive definite is checked when it is factored.
    pub fn new(mass: Symmetric<T>) -> Self {
        let forces = Forces::constant(vec![T::zero(); mass.size()]);
        let contacts = SmoothContacts::default();
        let labels = [Vec::new(), Vec::new()];
        Self { mass, damping: None, stiffness: None, forces, contacts, scales: None, labels }
    }

    /// Adds the damping C.
    ///
    /// # Errors
    /// [`SystemError::Size`].
    pub fn with_damping(mut self, damping: Symmetric<T>) -> Result<Self, SystemError> {
        self.check_size("damping", damping.size())?;
        self.damping = Some(damping);
        Ok(self)
    }

    /// Adds the stiffness K.
    ///
    /// # Errors
    /// [`SystemError::Size`].
    pub fn with_stiffness(mut self, stiffness: Symmetric<T>) -> Result<Self, SystemError> {
        self.check_size("stiffness", stiffness.size())?;
        self.stiffness = Some(stiffness);
        Ok(self)
    }

    /// Sets the external forces.
    ///
    /// # Errors
    /// [`SystemError::Size`], [`SystemError::OutOfRange`] for a force that is not finite.
    pub fn with_forces(mut self, forces: Forces<T>) -> Result<Self, SystemError> {
        self.check_size("force", forces.constant_part().len())?;
        if let Some(i) = forces.constant_part().iter().position(|f| !all_finite([f])) {
            let value = to_f64(forces.constant_part()[i]);
            return Err(SystemError::OutOfRange { what: format!("force {i}"), value, range: "finite" });
        }
        self.forces = forces;
        Ok(self)
    }

    /// Adds a contact of interface `interface`.
    #[must_use]
    pub fn with_contact(mut self, interface: usize, gap: SmoothGap<T, D>) -> Self {
        self.contacts.push(interface, gap);
        self
    }

    /// Sets the length (m) and the speed (m/s) that scale the tolerances of the active set; by default they are
    /// the largest initial |q| and |v|, or 1.
    #[must_use]
    pub fn with_scales(mut self, length: T, speed: T) -> Self {
        self.scales = Some(Scales { length, speed });
        self
    }

    /// Names the coordinates and the contacts, in their order.
    #[must_use]
    pub fn with_labels(mut self, coordinates: Vec<String>, contacts: Vec<String>) -> Self {
        self.labels = [coordinates, contacts];
        self
    }

    fn check_size(&self, what: &'static str, given: usize) -> Result<(), SystemError> {
        let expected = self.mass.size();
        if given == expected { Ok(()) } else { Err(SystemError::Size { what, expected, given }) }
    }
}

impl<T: Scalar, const D: usize> Dynamics<T> for Lagrangian<T, D> {
    fn mass(&self) -> &Symmetric<T> {
        &self.mass
    }

    fn damping(&self) -> Option<&Symmetric<T>> {
        self.damping.as_ref()
    }

    fn stiffness(&self) -> Option<&Symmetric<T>> {
        self.stiffness.as_ref()
    }

    fn forces(&self) -> &Forces<T> {
        &self.forces
    }

    fn scales(&self, q: &[T], v: &[T]) -> Scales<T> {
        self.scales.unwrap_or_else(|| Scales::of(q, v))
    }
}

impl<T: Scalar, const D: usize> Contacts<T, D> for Lagrangian<T, D> {
    fn interfaces(&self) -> usize {
        self.contacts.interfaces()
    }

    fn candidates(&mut self, q: &[T], reach: T, out: &mut Vec<Candidate<T>>) {
        self.contacts.candidates(q, reach, out);
    }

    fn jacobian(&self, contact: ContactId, q: &[T], out: &mut BlockRows<T, D>) {
        self.contacts.jacobian(contact, q, out);
    }

    fn gap(&self, contact: ContactId, q: &[T]) -> T {
        self.contacts.gap(contact, q)
    }
}

impl<T: Scalar, const D: usize> Describe<T> for Lagrangian<T, D> {
    fn dof_label(&self, dof: usize) -> String {
        self.labels[0].get(dof).cloned().unwrap_or_else(|| format!("q{dof}"))
    }

    fn contact_label(&self, contact: ContactId) -> String {
        let label = self.labels[1].get(contact.number() as usize);
        label.cloned().unwrap_or_else(|| contact.number().to_string())
    }
}

impl<T: Scalar, const D: usize> fmt::Debug for Lagrangian<T, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Lagrangian {{ dofs: {}, contacts: {} }}", self.mass.size(), self.contacts.count())
    }
}
