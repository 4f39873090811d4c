//! Sections of the formats 4.0 and 4.1, which differ in the widths of numbers and the order of the facts of a block.

use super::MeshError;
use super::content::{Content, Member, Version, positive};
use super::kinds::Kind;
use super::sections::Cursor;

/// Dimension and number of the geometric entity of a block, and the number in its third place.
fn block(cursor: &mut Cursor<'_>, version: Version) -> Result<(usize, i64, i64), MeshError> {
    let [a, b, third] = [cursor.int()?, cursor.int()?, cursor.int()?];
    let (dimension, entity) = if version == Version::V40 { (b, a) } else { (a, b) };
    match dimension {
        0..=3 => Ok((dimension as usize, entity, third)),
        _ => Err(cursor.error(format!("a geometric entity of dimension {dimension}"))),
    }
}

/// A tag of a node or an element.
fn tag(cursor: &mut Cursor<'_>, version: Version) -> Result<u64, MeshError> {
    if version == Version::V40 {
        let tag = cursor.int()?;
        positive(tag, cursor)
    } else {
        cursor.size()
    }
}

/// `$Entities`, or `$PartitionedEntities`, whose entities are parts of others.
pub(super) fn entities(
    cursor: &mut Cursor<'_>,
    content: &mut Content,
    (version, partitioned): (Version, bool),
) -> Result<(), MeshError> {
    if partitioned {
        let _partitions = cursor.size()?;
        for _ in 0..cursor.size()? {
            let _ghost = (cursor.int()?, cursor.int()?);
        }
    }
    let counts = [cursor.size()?, cursor.size()?, cursor.size()?, cursor.size()?];
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let tag = cursor.int()?;
            if partitioned {
                let parent = (cursor.int()?, cursor.int()?);
                for _ in 0..cursor.size()? {
                    cursor.int()?;
                }
                if usize::try_from(parent.0) == Ok(dimension) {
                    content.parents.insert((dimension, tag), parent.1);
                }
            }
            for _ in 0..if dimension == 0 && version == Version::V41 { 3 } else { 6 } {
                cursor.real()?;
            }
            let mut physical = Vec::new();
            for _ in 0..cursor.size()? {
                physical.push(cursor.int()?);
            }
            if dimension > 0 {
                for _ in 0..cursor.size()? {
                    cursor.int()?;
                }
            }
            content.entities.insert((dimension, tag), physical);
        }
    }
    Ok(())
}

/// The number of blocks; how many things in all, and the range of their tags, the blocks tell as well.
fn blocks(cursor: &mut Cursor<'_>, version: Version) -> Result<u64, MeshError> {
    let blocks = cursor.size()?;
    for _ in 0..if version == Version::V40 { 1 } else { 3 } {
        cursor.size()?;
    }
    Ok(blocks)
}

pub(super) fn nodes(
    cursor: &mut Cursor<'_>,
    content: &mut Content,
    version: Version,
) -> Result<(), MeshError> {
    for _ in 0..blocks(cursor, version)? {
        let (dimension, _, parametric) = block(cursor, version)?;
        let count = cursor.size()?;
        // Parameters of the node on its entity follow its coordinates.
        let parameters = if parametric != 0 { dimension } else { 0 };
        let mut place = |cursor: &mut Cursor<'_>, tag: u64| {
            content.nodes.push((tag, [cursor.real()?, cursor.real()?, cursor.real()?]));
            (0..parameters).try_for_each(|_| cursor.real().map(drop))
        };
        if version == Version::V40 {
            for _ in 0..count {
                let tag = tag(cursor, version)?;
                place(cursor, tag)?;
            }
            continue;
        }
        let mut tags = Vec::new();
        for _ in 0..count {
            tags.push(cursor.size()?);
        }
        for tag in tags {
            place(cursor, tag)?;
        }
    }
    Ok(())
}

pub(super) fn elements(
    cursor: &mut Cursor<'_>,
    content: &mut Content,
    version: Version,
) -> Result<(), MeshError> {
    for _ in 0..blocks(cursor, version)? {
        let (dimension, entity, number) = block(cursor, version)?;
        let count = cursor.size()?;
        let physical = content.entities.get(&(dimension, entity)).cloned().unwrap_or_default();
        // Parts of an entity go by the name of the whole.
        let whole = content.parents.get(&(dimension, entity)).copied().unwrap_or(entity);
        for _ in 0..count {
            let own = tag(cursor, version)?;
            let kind = Kind::of(own, number)?;
            let mut nodes = Vec::new();
            for _ in 0..kind.nodes {
                nodes.push(tag(cursor, version)?);
            }
            let (physical, entity) = (physical.clone(), (dimension, whole));
            content.elements.push(Member { tag: own, kind, nodes, physical, entity });
        }
    }
    Ok(())
}
