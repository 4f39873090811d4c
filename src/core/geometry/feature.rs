//! What meets at a contact, and where.

use nalgebra::Vector3;

use super::pose::Pose;
use crate::scalar::Scalar;

/// A piece of the boundary of a shape.
///
/// A ball has the vertex 0, its centre; a capsule the vertices 0 and 1, the ends of its axis, and the edge 0 between them; a
/// half-space the face 0. The others are numbered by their polyhedron, and rounds also by their profile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Feature {
    /// A vertex.
    Vertex(u32),
    /// An edge.
    Edge(u32),
    /// A plane face.
    Face(u32),
    /// The circle of a round with this number, from below.
    Rim(u32),
    /// The curved surface of a round above the rim of this number.
    Mantle(u32),
    /// A plane patch of a terrain.
    Patch(u32),
}

/// What the normal of a contact turns with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Carrier {
    /// The face of the first shape with this number.
    First(u32),
    /// The face of the second shape with this number.
    Second(u32),
    /// Two edges, one of each shape: it is normal to both.
    Edges,
    /// The line between the two nearest points of the features.
    Line,
}

/// Which features meet, and what carries the normal: all that [`resolve`](super::resolve) needs to follow a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Meeting {
    /// Of the first shape.
    pub first: Feature,
    /// Of the second shape.
    pub second: Feature,
    /// What the normal turns with.
    pub carrier: Carrier,
}

impl Meeting {
    /// Bits of an index in [`id`](Self::id).
    const WIDTH: u32 = 31;

    /// Most vertices, edges or faces of a shape, so that identities hold them.
    pub const MOST_FEATURES: usize = 1 << (Self::WIDTH - 1);

    /// What meets as a number that differs between the contacts of one pair: the vertex of the first shape if one is
    /// there, else that of the second, else the two edges.
    ///
    /// On terrain it names the patch and the vertex. It names neither the face a vertex meets nor the face that carries the normal, which rounding chooses where two
    /// faces are as good: percussions find their contact again.
    pub const fn id(&self) -> u64 {
        match self.id_within(Self::WIDTH) {
            Some(id) => id,
            // No shape has that many features.
            None => 0,
        }
    }

    /// As [`id`](Self::id) in 2 + 2 `width` bits; `None` where an index needs more than `width` − 1 of them.
    pub const fn id_within(&self, width: u32) -> Option<u64> {
        if width == 0 || width > Self::WIDTH {
            return None;
        }
        let rim: u64 = 1 << (width - 1);
        let (kind, first, second, rim) = match (self.first, self.second) {
            // Patches that meet in a valley hold one vertex at once.
            (Feature::Patch(i), Feature::Vertex(j)) | (Feature::Vertex(j), Feature::Patch(i)) => {
                (0, i as u64, j as u64, 0)
            }
            (Feature::Vertex(i), _) => (1, i as u64, 0, 0),
            (Feature::Rim(i), _) => (1, i as u64, 0, rim << 2),
            (_, Feature::Vertex(i)) => (2, 0, i as u64, 0),
            (_, Feature::Rim(i)) => (2, 0, i as u64, rim << (2 + width)),
            (Feature::Edge(i), Feature::Edge(j)) => (3, i as u64, j as u64, 0),
            _ => (0, 0, 0, 0),
        };
        if first >> (width - 1) != 0 || second >> (width - 1) != 0 {
            return None;
        }
        Some(kind | first << 2 | second << (2 + width) | rim)
    }

    /// The same with the shapes in the other order.
    pub const fn swapped(self) -> Self {
        let carrier = match self.carrier {
            Carrier::First(face) => Carrier::Second(face),
            Carrier::Second(face) => Carrier::First(face),
            other => other,
        };
        Self { first: self.second, second: self.first, carrier }
    }
}

/// A place where two shapes touch, or come near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact<T: Scalar> {
    /// Which features meet.
    pub meeting: Meeting,
    /// Unit normal in fixed axes, from the first shape (the obstacle) to the second (the body): the second leaves along it.
    pub normal: Vector3<T>,
    /// Gap (m) along the normal, negative where the shapes overlap.
    pub gap: T,
    /// From the position of the first body, and of the second, to the point of its boundary that touches; in fixed axes (m).
    pub arms: [Vector3<T>; 2],
}

impl<T: Scalar> Contact<T> {
    /// The touching points of the first and of the second shape in space, given their poses.
    pub fn points(&self, first: &Pose<T>, second: &Pose<T>) -> [Vector3<T>; 2] {
        [first.position() + self.arms[0], second.position() + self.arms[1]]
    }

    /// The same contact with the shapes in the other order.
    #[must_use]
    pub fn swapped(self) -> Self {
        let [first, second] = self.arms;
        Self { meeting: self.meeting.swapped(), normal: -self.normal, gap: self.gap, arms: [second, first] }
    }
}
