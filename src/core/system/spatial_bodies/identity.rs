//! Identities of contacts: the two shapes and the features that meet, packed into one number.

use crate::contact::ContactId;
use crate::geometry::Meeting;

/// The first identity of a limit of a joint: meetings have at most 62 bits, or are digests, which hardly ever get here.
pub(super) const STOPS: u64 = 0xffff_ffff_0000_0000;

/// Bits of a shape's index and of a feature's.
#[derive(Debug, Clone, Copy)]
pub(super) struct Packing {
    shape: u32,
    feature: u32,
}

impl Packing {
    /// As many bits for the features as `shapes` shapes leave.
    pub(super) fn new(shapes: usize) -> Self {
        let shape = usize::BITS - shapes.max(2).leading_zeros();
        Self { shape, feature: (62_u32.saturating_sub(2 * shape) / 2).min(31) }
    }

    /// The identity of a meeting of two shapes. Where shapes have more features than there are bits it is a digest, which
    /// hardly ever agrees for two meetings; whoever lists contacts makes them differ.
    pub(super) fn id(self, first: usize, second: usize, meeting: &Meeting) -> ContactId {
        let pair = (first as u64) << self.shape | second as u64;
        let number = match meeting.id_within(self.feature) {
            Some(features) => pair << (2 + 2 * self.feature) | features,
            None => mix(mix(pair) ^ meeting.id()),
        };
        ContactId::new(number)
    }
}

/// A number as good as random (the finaliser of SplitMix64, Steele, Lea and Flood 2014, doi:10.1145/2660193.2660195).
fn mix(x: u64) -> u64 {
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}
