//! Contacts as systems offer them: who may touch, how far apart, under which law.

mod posing;

pub use posing::{ImproperResponse, check, pose};

use crate::scalar::Scalar;

/// Identity of a candidate contact, stable from step to step, so that percussions warm-start the next step.
///
/// It is a number the system chooses, and in an assembly the member of it that the contact belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "outputs", derive(serde::Serialize, serde::Deserialize))]
pub struct ContactId {
    /// Members from the outermost assembly in the low digits inwards, each counted from 1; 0 outside all of them.
    members: u64,
    number: u64,
}

/// Members of one assembly in the digits of an identity.
const MEMBER_BITS: u32 = 16;

impl ContactId {
    /// Most members of an assembly; assemblies of assemblies may be four deep.
    pub const MOST_MEMBERS: usize = (1 << MEMBER_BITS) - 1;

    /// Contact `number` of a system.
    pub const fn new(number: u64) -> Self {
        Self { members: 0, number }
    }

    /// The number its system knows it by.
    pub const fn number(self) -> u64 {
        self.number
    }

    /// A number that differs between contacts of one member, and hardly ever agrees for contacts of two.
    pub(crate) const fn digest(self) -> u64 {
        self.number ^ self.members.wrapping_mul(0x9e37_79b9_7f4a_7c15)
    }

    /// The identity in an assembly of a contact of its member `member`.
    pub const fn of_member(self, member: usize) -> Self {
        Self { members: self.members << MEMBER_BITS | (member as u64 + 1), ..self }
    }

    /// The member it belongs to and its identity there; `None` outside of all members.
    pub const fn in_member(self) -> Option<(usize, Self)> {
        match self.members & Self::MOST_MEMBERS as u64 {
            0 => None,
            member => Some((member as usize - 1, Self { members: self.members >> MEMBER_BITS, ..self })),
        }
    }
}

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
