//! Nonlinear Lagrangian systems M(q) v̇ + f(t, q, v) = F(t) + Hᵀ(q) r.

use std::fmt::{self, Debug};

use nalgebra::DMatrix;

use super::{Contacts, Describe, Dynamics, Forces, Scales, SmoothContacts, SmoothGap, SystemError};
use crate::contact::{Candidate, ContactId};
use crate::linalg::{BlockRows, Symmetric};
use crate::scalar::{Scalar, all_finite};

/// The terms of a nonlinear system: kinetic energy ½ v·M(q) v, potential V(q), and other forces.
///
/// ```text
///   d/dt (M(q) v) − ∂/∂q (½ v·M(q) v) + ∇V(q) + d(t, q, v) = F(t) + Hᵀ(q) r
/// ```
///
/// that is M(q) v̇ + f(t, q, v) = F + Hᵀ r, where f holds the inertial forces quadratic in v, ∇V and d. All arrays have
/// one component per degree of freedom, all matrices are square of that size; `out` comes in any state and is to be
/// overwritten.
pub trait NonlinearTerms<T: Scalar>: Debug + Send + Sync {
    /// out ← M(q), symmetric positive definite.
    fn mass(&self, q: &[T], out: &mut DMatrix<T>);

    /// out ← ∂M/∂q_i.
    fn mass_derivative(&self, q: &[T], i: usize, out: &mut DMatrix<T>);

    /// V(q) (J).
    fn potential(&self, _q: &[T]) -> T {
        T::zero()
    }

    /// out ← ∇V(q).
    fn potential_gradient(&self, _q: &[T], out: &mut [T]) {
        out.fill(T::zero());
    }

    /// out ← d(t, q, v): damping, actuators, whatever has no potential. Its work is booked as that of damping.
    fn other_forces(&self, _t: T, _q: &[T], _v: &[T], out: &mut [T]) {
        out.fill(T::zero());
    }
}

/// A nonlinear system with smooth gaps; the scheme's own documentation derives the balance of its steps.
pub struct NonlinearLagrangian<T: Scalar, const D: usize> {
    dynamics: Box<dyn NonlinearTerms<T>>,
    reference_mass: Symmetric<T>,
    forces: Forces<T>,
    contacts: SmoothContacts<T, D>,
    scales: Option<Scales<T>>,
}

impl<T: Scalar, const D: usize> NonlinearLagrangian<T, D> {
    /// The system with the given terms, as many degrees of freedom as `reference` has; M is looked at there once.
    ///
    /// # Errors
    /// [`SystemError::Operator`] if M(reference) is not a symmetric matrix.
    pub fn new(dynamics: impl NonlinearTerms<T> + 'static, reference: &[T]) -> Result<Self, SystemError> {
        let n = reference.len();
        let mut mass = DMatrix::zeros(n, n);
        dynamics.mass(reference, &mut mass);
        let reference_mass =
            Symmetric::dense(mass).map_err(|source| SystemError::Operator { what: "mass", source })?;
        if reference_mass.size() != n {
            let given = reference_mass.size();
            return Err(SystemError::Size { what: "mass", expected: n, given });
        }
        let forces = Forces::constant(vec![T::zero(); n]);
        let contacts = SmoothContacts::default();
        Ok(Self { dynamics: Box::new(dynamics), reference_mass, forces, contacts, scales: None })
    }

    /// Sets the external forces F(t).
    ///
    /// # Errors
    /// [`SystemError::Size`], [`SystemError::OutOfRange`] for a force that is not finite.
    pub fn with_forces(mut self, forces: Forces<T>) -> Result<Self, SystemError> {
        let (expected, given) = (self.reference_mass.size(), forces.constant_part().len());
        if given != expected {
            return Err(SystemError::Size { what: "force", expected, given });
        }
        if let Some(i) = forces.constant_part().iter().position(|f| !all_finite([f])) {
            let value = crate::scalar::to_f64(forces.constant_part()[i]);
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

    /// Sets the length (m) and the speed (m/s) that scale the tolerances of the active set; by default they are the
    /// largest initial |q| and |v|, or 1.
    #[must_use]
    pub fn with_scales(mut self, length: T, speed: T) -> Self {
        self.scales = Some(Scales { length, speed });
        self
    }
}

impl<T: Scalar, const D: usize> Dynamics<T> for NonlinearLagrangian<T, D> {
    /// M at the reference configuration; the steps take M(q).
    fn mass(&self) -> &Symmetric<T> {
        &self.reference_mass
    }

    fn forces(&self) -> &Forces<T> {
        &self.forces
    }

    fn nonlinear(&self) -> Option<&dyn NonlinearTerms<T>> {
        Some(&*self.dynamics)
    }

    fn scales(&self, q: &[T], v: &[T]) -> Scales<T> {
        self.scales.unwrap_or_else(|| Scales::of(q, v))
    }
}

impl<T: Scalar, const D: usize> Contacts<T, D> for NonlinearLagrangian<T, D> {
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

impl<T: Scalar, const D: usize> Describe<T> for NonlinearLagrangian<T, D> {}

impl<T: Scalar, const D: usize> fmt::Debug for NonlinearLagrangian<T, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("NonlinearLagrangian")
            .field("dynamics", &self.dynamics)
            .field("contacts", &self.contacts.count())
            .finish_non_exhaustive()
    }
}
