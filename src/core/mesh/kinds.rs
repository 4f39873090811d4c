//! The element types of Gmsh: names, dimensions and numbers of nodes.

use super::MeshError;

/// An element type as Gmsh numbers it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Kind {
    /// Gmsh's number.
    pub(super) number: u64,
    /// What it is called.
    pub(super) name: &'static str,
    /// Dimension.
    pub(super) dimension: usize,
    /// Number of nodes.
    pub(super) nodes: usize,
}

/// The element types with a fixed number of nodes, up to third order: (number, name, dimension, nodes).
const KINDS: [(u64, &str, usize, usize); 24] = [
    (1, "two-node line", 1, 2),
    (2, "three-node triangle", 2, 3),
    (3, "four-node quadrangle", 2, 4),
    (4, "four-node tetrahedron", 3, 4),
    (5, "eight-node hexahedron", 3, 8),
    (6, "six-node prism", 3, 6),
    (7, "five-node pyramid", 3, 5),
    (8, "three-node line", 1, 3),
    (9, "six-node triangle", 2, 6),
    (10, "nine-node quadrangle", 2, 9),
    (11, "ten-node tetrahedron", 3, 10),
    (12, "27-node hexahedron", 3, 27),
    (13, "18-node prism", 3, 18),
    (14, "14-node pyramid", 3, 14),
    (15, "point", 0, 1),
    (16, "eight-node quadrangle", 2, 8),
    (17, "20-node hexahedron", 3, 20),
    (18, "15-node prism", 3, 15),
    (19, "13-node pyramid", 3, 13),
    (20, "nine-node triangle", 2, 9),
    (21, "ten-node triangle", 2, 10),
    (26, "four-node line", 1, 4),
    (29, "20-node tetrahedron", 3, 20),
    (36, "16-node quadrangle", 2, 16),
];

impl Kind {
    /// The type of an element.
    ///
    /// # Errors
    /// [`MeshError::ElementType`] for a number whose elements have nobody knows how many nodes.
    pub(super) fn of(element: u64, number: i64) -> Result<Self, MeshError> {
        let number = number.unsigned_abs();
        let found = KINDS.iter().find(|kind| kind.0 == number);
        let &(number, name, dimension, nodes) =
            found.ok_or(MeshError::ElementType { element, kind: number })?;
        Ok(Self { number, name, dimension, nodes })
    }

    /// Whether elements of this type are computed with.
    pub(super) fn is_used(self) -> bool {
        matches!(self.number, 1 | 2 | 15)
    }
}
