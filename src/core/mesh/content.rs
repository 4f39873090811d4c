//! What the sections of a Gmsh file say, before it is a mesh.

use std::collections::HashMap;

use super::MeshError;
use super::kinds::Kind;
use super::sections::Cursor;

/// What the sections of a file say.
#[derive(Default)]
pub(super) struct Content {
    /// Names of physical groups by (dimension, number); those of format 2.0 have no dimension.
    pub(super) names: HashMap<(Option<usize>, i64), String>,
    /// Physical groups of geometric entities by (dimension, number); formats 4.
    pub(super) entities: HashMap<(usize, i64), Vec<i64>>,
    /// The entity that a partitioned one is a part of, of the same dimension.
    pub(super) parents: HashMap<(usize, i64), i64>,
    pub(super) nodes: Vec<(u64, [f64; 3])>,
    pub(super) elements: Vec<Member>,
}

/// An element with the tags of its nodes, its physical groups, and dimension and number of its geometric entity.
pub(super) struct Member {
    pub(super) tag: u64,
    pub(super) kind: Kind,
    pub(super) nodes: Vec<u64>,
    pub(super) physical: Vec<i64>,
    pub(super) entity: (usize, i64),
}

/// Formats that differ in more than their number.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Version {
    V20,
    V22,
    V40,
    V41,
}

pub(super) fn positive(tag: i64, cursor: &Cursor<'_>) -> Result<u64, MeshError> {
    u64::try_from(tag).map_err(|_| cursor.error(format!("the number {tag} is negative")))
}
