//! Sections of the formats 2.0, 2.1 and 2.2.

use super::MeshError;
use super::content::{Content, Member, positive};
use super::kinds::Kind;
use super::sections::{Cursor, Encoding};

/// `$Nodes`, or `$ParametricNodes`, which say as well where each node is on its geometric entity.
pub(super) fn nodes(
    cursor: &mut Cursor<'_>,
    content: &mut Content,
    parametric: bool,
) -> Result<(), MeshError> {
    for _ in 0..cursor.text_count()? {
        let tag = positive(cursor.int()?, cursor)?;
        content.nodes.push((tag, [cursor.real()?, cursor.real()?, cursor.real()?]));
        if parametric {
            let (dimension, _) = (cursor.int()?, cursor.int()?);
            for _ in 0..if (1..=2).contains(&dimension) { dimension } else { 0 } {
                cursor.real()?;
            }
        }
    }
    Ok(())
}

pub(super) fn elements(cursor: &mut Cursor<'_>, content: &mut Content) -> Result<(), MeshError> {
    let total = cursor.text_count()?;
    let mut read = 0;
    while read < total {
        // Text says the type of each element; binary says it once for a run of elements.
        let text = cursor.encoding == Encoding::Text;
        let first = if text { cursor.int()? } else { 0 };
        let (kind, follow) = (cursor.int()?, if text { 1 } else { cursor.int()? });
        let tags = cursor.int()?;
        if follow < 1 || tags < 0 {
            return Err(cursor.error(format!("{follow} elements with {tags} tags each")));
        }
        for _ in 0..follow {
            let tag = if text { first } else { cursor.int()? };
            let tag = positive(tag, cursor)?;
            // The physical group and the geometric entity; partitions follow.
            let (mut physical, mut entity) = (Vec::new(), 0);
            for i in 0..tags {
                match (i, cursor.int()?) {
                    (0, group) if group != 0 => physical.push(group),
                    (1, tag) => entity = tag,
                    _ => {}
                }
            }
            let kind = Kind::of(tag, kind)?;
            let mut nodes = Vec::new();
            for _ in 0..kind.nodes {
                let node = cursor.int()?;
                nodes.push(positive(node, cursor)?);
            }
            let entity = (kind.dimension, entity);
            content.elements.push(Member { tag, kind, nodes, physical, entity });
            read += 1;
        }
    }
    Ok(())
}
