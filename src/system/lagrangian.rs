//! Lagrangian systems with constant M, optional C, K, F(t), and arbitrary smooth gaps.

use std::fmt;

use nalgebra::SVector;

use super::{Forces, MechanicalSystem, Scales, SystemError};
use crate::contact::{Candidate, ContactId};
use crate::linalg::{BlockRows, Symmetric, max_abs};
use crate::scalar::{Scalar, all_finite, to_f64};

type Gap<T> = Box<dyn Fn(&[T]) -> T + Send + Sync>;
type Row<T, const D: usize> = Box<dyn Fn(&[T], &mut dyn FnMut(usize, SVector<T, D>)) + Send + Sync>;

/// A smooth gap function g(q) (m) and the local-frame Jacobian H(q) of its contact.
pub struct SmoothGap<T: Scalar, const D: usize> {
    gap: Gap<T>,
    row: Row<T, D>,
}

impl<T: Scalar, const D: usize> SmoothGap<T, D> {
    /// A gap from g(q), and from H(q) given column by column: `row(q, push)` calls `push(j, ∂u/∂v_j)` for every
    /// degree of freedom j that moves the contact, with ∂u/∂v_j in the order (N, T1, T2).
    pub fn new(
        gap: impl Fn(&[T]) -> T + Send + Sync + 'static,
        row: impl Fn(&[T], &mut dyn FnMut(usize, SVector<T, D>)) + Send + Sync + 'static,
    ) -> Self {
        Self { gap: Box::new(gap), row: Box::new(row) }
    }

    /// g(q).
    pub(super) fn gap(&self, q: &[T]) -> T {
        (self.gap)(q)
    }

    /// Appends H(q).
    pub(super) fn jacobian(&self, q: &[T], out: &mut BlockRows<T, D>) {
        out.start_row();
        (self.row)(q, &mut |column, entry| out.push(column, entry));
    }
}

/// M v̇ + C v + K q = F(t) + Hᵀ(q) r with constant M, C, K.
pub struct Lagrangian<T: Scalar, const D: usize> {
    mass: Symmetric<T>,
    damping: Option<Symmetric<T>>,
    stiffness: Option<Symmetric<T>>,
    forces: Forces<T>,
    contacts: Vec<(usize, SmoothGap<T, D>)>,
    interfaces: usize,
    scales: Option<Scales<T>>,
}

impl<T: Scalar, const D: usize> Lagrangian<T, D> {
    /// A free system of mass `mass`; whether M is positive definite is checked when it is factored.
    pub fn new(mass: Symmetric<T>) -> Self {
        let forces = Forces::constant(vec![T::zero(); mass.size()]);
        let (contacts, interfaces) = (Vec::new(), 0);
        Self { mass, damping: None, stiffness: None, forces, contacts, interfaces, scales: None }
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
        self.contacts.push((interface, gap));
        self.interfaces = self.interfaces.max(interface.saturating_add(1));
        self
    }

    /// Sets the length (m) and the speed (m/s) that scale the tolerances of the active set; by default they are
    /// the largest initial |q| and |v|, or 1.
    #[must_use]
    pub fn with_scales(mut self, length: T, speed: T) -> Self {
        self.scales = Some(Scales { length, speed });
        self
    }

    fn check_size(&self, what: &'static str, given: usize) -> Result<(), SystemError> {
        let expected = self.mass.size();
        if given == expected { Ok(()) } else { Err(SystemError::Size { what, expected, given }) }
    }
}

impl<T: Scalar, const D: usize> MechanicalSystem<T, D> for Lagrangian<T, D> {
    fn dofs(&self) -> usize {
        self.mass.size()
    }

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

    fn interfaces(&self) -> usize {
        self.interfaces
    }

    fn candidates(&mut self, q: &[T], reach: T, out: &mut Vec<Candidate<T>>) {
        for (i, (interface, contact)) in self.contacts.iter().enumerate() {
            let gap = contact.gap(q);
            // Written so that a NaN gap is offered, and then refused by name.
            if !(gap > reach) {
                out.push(Candidate { id: ContactId(i as u64), interface: *interface, gap });
            }
        }
    }

    fn jacobian(&self, contact: ContactId, q: &[T], out: &mut BlockRows<T, D>) {
        self.contacts[contact.0 as usize].1.jacobian(q, out);
    }

    fn gap(&self, contact: ContactId, q: &[T]) -> T {
        self.contacts[contact.0 as usize].1.gap(q)
    }

    fn scales(&self, q: &[T], v: &[T]) -> Scales<T> {
        let or_one = |x: T| if x > T::zero() { x } else { T::one() };
        self.scales.unwrap_or_else(|| Scales { length: or_one(max_abs(q)), speed: or_one(max_abs(v)) })
    }
}

impl<T: Scalar, const D: usize> fmt::Debug for Lagrangian<T, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Lagrangian {{ dofs: {}, contacts: {} }}", self.mass.size(), self.contacts.len())
    }
}
