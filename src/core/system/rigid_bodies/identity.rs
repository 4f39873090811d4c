//! Identities of contacts: the pair and the features that meet, packed into 64 bits.

use crate::contact::ContactId;

/// What a [`ContactId`] names. An identity says all that is needed to find the contact again in another
/// configuration, and stays the same as long as the same features meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pair {
    /// Disc against half-plane.
    Plane {
        /// Contactor.
        disc: usize,
        /// Half-plane.
        plane: usize,
    },
    /// Vertex of a polygon against half-plane.
    Corner {
        /// Contactor.
        polygon: usize,
        /// Half-plane.
        plane: usize,
        /// Vertex of the polygon.
        vertex: usize,
    },
    /// Disc against disc.
    Discs(usize, usize),
    /// A limit of a joint.
    Stop(usize),
    /// Polygon `a` against the polygon or the disc `b`.
    Features {
        /// Contactor, a polygon.
        a: usize,
        /// Contactor.
        b: usize,
        /// What meets.
        features: Features,
    },
}

/// The features of two contactors that meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Features {
    /// Vertex of `a` on an edge of `b`.
    VertexEdge(usize, usize),
    /// An edge of `a` under a vertex of `b`: (vertex, edge).
    EdgeVertex(usize, usize),
    /// The disc `b` on an edge of `a`.
    EdgeDisc(usize),
    /// The disc `b` on a vertex of `a`.
    VertexDisc(usize),
}

/// Most contactors of a scene that has polygons, and most half-planes they may meet.
pub(super) const MOST_CONTACTORS: usize = 1 << 20;

/// Most vertices of a polygon.
pub(super) const MOST_VERTICES: usize = 1 << 10;

const CORNER: u64 = 1 << 62;
/// A corner has no such bit.
const STOP: u64 = CORNER | 1 << 61;
const DISCS: u64 = 2 << 62;
const FEATURES: u64 = 3 << 62;

impl Pair {
    pub(super) fn id(self) -> ContactId {
        let wide = |high: usize, low: usize| (high as u64) << 31 | low as u64;
        ContactId::new(match self {
            Self::Plane { disc, plane } => wide(disc, plane),
            Self::Corner { polygon, plane, vertex } => {
                CORNER | (polygon as u64) << 30 | (plane as u64) << 10 | vertex as u64
            }
            Self::Stop(stop) => STOP | stop as u64,
            Self::Discs(a, b) => DISCS | wide(a, b),
            Self::Features { a, b, features } => {
                let (kind, vertex, edge) = match features {
                    Features::VertexEdge(vertex, edge) => (0, vertex, edge),
                    Features::EdgeVertex(vertex, edge) => (1, vertex, edge),
                    Features::EdgeDisc(edge) => (2, 0, edge),
                    Features::VertexDisc(vertex) => (3, vertex, 0),
                };
                let features = kind << 20 | (vertex as u64) << 10 | edge as u64;
                FEATURES | (a as u64) << 42 | (b as u64) << 22 | features
            }
        })
    }

    pub(super) fn of(id: ContactId) -> Self {
        let bits = |from: u32, count: u32| (id.number() >> from & ((1 << count) - 1)) as usize;
        match id.number() & FEATURES {
            0 => Self::Plane { disc: bits(31, 31), plane: bits(0, 31) },
            CORNER if id.number() & STOP == STOP => Self::Stop(bits(0, 61)),
            CORNER => Self::Corner { polygon: bits(30, 20), plane: bits(10, 20), vertex: bits(0, 10) },
            DISCS => Self::Discs(bits(31, 31), bits(0, 31)),
            _ => {
                let (vertex, edge) = (bits(10, 10), bits(0, 10));
                let features = match bits(20, 2) {
                    0 => Features::VertexEdge(vertex, edge),
                    1 => Features::EdgeVertex(vertex, edge),
                    2 => Features::EdgeDisc(edge),
                    _ => Features::VertexDisc(vertex),
                };
                Self::Features { a: bits(42, 20), b: bits(22, 20), features }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_identity_names_its_pair() {
        let (most, last) = (MOST_CONTACTORS - 1, MOST_VERTICES - 1);
        let mut pairs = vec![
            Pair::Plane { disc: (1 << 31) - 1, plane: 3 },
            Pair::Plane { disc: 0, plane: (1 << 31) - 1 },
            Pair::Corner { polygon: most, plane: 0, vertex: last },
            Pair::Corner { polygon: 5, plane: most, vertex: 7 },
            Pair::Discs(4, (1 << 31) - 1),
            Pair::Stop(0),
            Pair::Stop((1 << 61) - 1),
        ];
        let features = [
            Features::VertexEdge(last, 3),
            Features::EdgeVertex(3, last),
            Features::EdgeDisc(last),
            Features::VertexDisc(last),
        ];
        pairs.extend(features.map(|features| Pair::Features { a: most, b: 9, features }));
        pairs.extend(features.map(|features| Pair::Features { a: 9, b: most, features }));
        for (i, pair) in pairs.iter().enumerate() {
            assert_eq!(Pair::of(pair.id()), *pair);
            assert!(pairs[..i].iter().all(|other| other.id() != pair.id()), "{pair:?}");
        }
    }
}
