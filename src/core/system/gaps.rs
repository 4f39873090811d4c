//! Contacts with smooth gaps, given by functions.

use std::fmt;

use nalgebra::SVector;

use super::Contacts;
use crate::contact::{Candidate, ContactId};
use crate::linalg::BlockRows;
use crate::scalar::Scalar;

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
    fn gap(&self, q: &[T]) -> T {
        (self.gap)(q)
    }

    /// Appends H(q).
    fn jacobian(&self, q: &[T], out: &mut BlockRows<T, D>) {
        out.start_row();
        (self.row)(q, &mut |column, entry| out.push(column, entry));
    }
}

/// Contacts with smooth gaps: those of [`Lagrangian`](super::Lagrangian) and of
/// [`NonlinearLagrangian`](super::NonlinearLagrangian), or those across the members of an assembly.
/// Contact i, in the order they are given, has the identity i.
pub struct SmoothContacts<T: Scalar, const D: usize> {
    contacts: Vec<(usize, SmoothGap<T, D>)>,
    interfaces: usize,
}

impl<T: Scalar, const D: usize> SmoothContacts<T, D> {
    /// Adds a contact of interface `interface`.
    pub fn push(&mut self, interface: usize, gap: SmoothGap<T, D>) {
        self.contacts.push((interface, gap));
        self.interfaces = self.interfaces.max(interface.saturating_add(1));
    }

    /// Number of contacts.
    pub fn count(&self) -> usize {
        self.contacts.len()
    }
}

impl<T: Scalar, const D: usize> Default for SmoothContacts<T, D> {
    fn default() -> Self {
        Self { contacts: Vec::new(), interfaces: 0 }
    }
}

impl<T: Scalar, const D: usize> Contacts<T, D> for SmoothContacts<T, D> {
    fn interfaces(&self) -> usize {
        self.interfaces
    }

    fn candidates(&mut self, q: &[T], reach: T, out: &mut Vec<Candidate<T>>) {
        for (i, (interface, contact)) in self.contacts.iter().enumerate() {
            let gap = contact.gap(q);
            // Written so that a NaN gap is offered, and then refused by name.
            if !(gap > reach) {
                out.push(Candidate { id: ContactId::new(i as u64), interface: *interface, gap });
            }
        }
    }

    fn jacobian(&self, contact: ContactId, q: &[T], out: &mut BlockRows<T, D>) {
        self.contacts[contact.number() as usize].1.jacobian(q, out);
    }

    fn gap(&self, contact: ContactId, q: &[T]) -> T {
        self.contacts[contact.number() as usize].1.gap(q)
    }
}

impl<T: Scalar, const D: usize> fmt::Debug for SmoothContacts<T, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SmoothContacts {{ contacts: {} }}", self.contacts.len())
    }
}
