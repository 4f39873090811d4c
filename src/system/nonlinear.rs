//! Nonlinear Lagrangian systems M(q) v̇ + f(t, q, v) = F(t) + Hᵀ(q) r.

use std::fmt::{self, Debug};

use nalgebra::DMatrix;

use super::{Forces, MechanicalSystem, Scales, SmoothGap, SystemError};
use crate::contact::{Candidate, ContactId};
use crate::linalg::{BlockRows, Symmetric, max_abs};
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
pub trait Dynamics<T: Scalar>: Debug + Send + Sync {
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
    dynamics: Box<dyn Dynamics<T>>,
    reference_mass: Symmetric<T>,
    forces: Forces<T>,
    contacts: Vec<(usize, SmoothGap<T, D>)>,
    interfaces: usize,
    scales: Option<Scales<T>>,
}

impl<T: Scalar, const D: usize> NonlinearLagrangian<T, D> {
    /// The system with the given terms, as many degrees of freedom as `reference` has; M is looked at there once.
    ///
    /// # Errors
    /// [`SystemError::Operator`] if M(reference) is not a symmetric matrix.
    pub fn new(dynamics: impl Dynamics<T> + 'static, reference: &[T]) -> Result<Self, SystemError> {
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
        let (contacts, interfaces) = (Vec::new(), 0);
        Ok(Self { dynamics: Box::new(dynamics), reference_mass, forces, contacts, interfaces, scales: None })
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
        self.contacts.push((interface, gap));
        self.interfaces = self.interfaces.max(interface.saturating_add(1));
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

impl<T: Scalar, const D: usize> MechanicalSystem<T, D> for NonlinearLagrangian<T, D> {
    fn dofs(&self) -> usize {
        self.reference_mass.size()
    }

    /// M at the reference configuration; the steps take M(q).
    fn mass(&self) -> &Symmetric<T> {
        &self.reference_mass
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

    fn nonlinear(&self) -> Option<&dyn Dynamics<T>> {
        Some(&*self.dynamics)
    }

    fn scales(&self, q: &[T], v: &[T]) -> Scales<T> {
        let or_one = |x: T| if x > T::zero() { x } else { T::one() };
        self.scales.unwrap_or_else(|| Scales { length: or_one(max_abs(q)), speed: or_one(max_abs(v)) })
    }
}

impl<T: Scalar, const D: usize> fmt::Debug for NonlinearLagrangian<T, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("NonlinearLagrangian")
            .field("dynamics", &self.dynamics)
            .field("contacts", &self.contacts.len())
            .finish_non_exhaustive()
    }
}
