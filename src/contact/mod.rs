//! Contacts as systems offer them: who may touch, how far apart, under which law.

mod posing;

pub use posing::{ImproperResponse, pose};

use crate::scalar::Scalar;

/// Identity of a candidate contact, stable from step to step, so that percussions warm-start the next step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ContactId(pub u64);

/// A pair that may touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate<T: Scalar> {
    /// Who.
    pub id: ContactId,
    /// Index of the interface the pair belongs to; the scheme holds one law per interface.
    pub interface: usize,
    /// Gap g (m), negative where the bodies overlap.
    pub gap: T,
}
