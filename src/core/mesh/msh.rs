//! Gmsh MSH files, formats 4.1 and 2.2, as text and binary: <https://gmsh.info/doc/texinfo/gmsh.html#File-formats>.
//!
//! `mshio` 0.4 reads 4.1 alone and drops the names of physical groups, which boundary conditions need.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;

use super::sections::{Cursor, Encoding};
use super::{Element, Mesh, MeshError, Node, Shape};

/// What the sections of a file say.
#[derive(Default)]
struct Content {
    /// Names of physical groups by (dimension, number).
    names: HashMap<(usize, i64), String>,
    /// Physical groups of geometric entities by (dimension, number); format 4.1.
    entities: HashMap<(usize, i64), Vec<i64>>,
    nodes: Vec<(u64, [f64; 3])>,
    elements: Vec<Member>,
}

/// An element with the tags of its nodes and its physical groups.
struct Member {
    tag: u64,
    nodes: Vec<u64>,
    physical: Vec<i64>,
}

impl Mesh {
    /// Reads a Gmsh file, format 4.1 or 2.2, text or binary. Physical groups become groups; one without a name is
    /// called `dimension:number`. Triangles must lie in a plane z = const, run counter-clockwise, and make the
    /// body; where there are none, lines on the x axis do.
    ///
    /// # Errors
    /// [`MeshError`] with the line, or naming the element, node or group at fault.
    pub fn read(path: &Path) -> Result<Self, MeshError> {
        let read = |message: String| MeshError::Read { path: path.display().to_string(), message };
        let bytes = std::fs::read(path).map_err(|error| read(error.to_string()))?;
        Self::parse(&bytes)
    }

    /// Reads the bytes of a Gmsh file.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn parse(bytes: &[u8]) -> Result<Self, MeshError> {
        let mut cursor = Cursor::new(bytes);
        let mut content = Content::default();
        let mut version = None;
        while let Some(section) = cursor.next_section()? {
            match (section, version) {
                ("MeshFormat", None) => version = Some(format(&mut cursor)?),
                (_, None) => return Err(cursor.error("`$MeshFormat` must come first")),
                ("PhysicalNames", _) => physical_names(&mut cursor, &mut content)?,
                ("Entities", Some(Version::V4)) => entities(&mut cursor, &mut content)?,
                ("PartitionedEntities", Some(Version::V4)) => {
                    return Err(cursor.error("partitioned meshes are not read: save the mesh unpartitioned"));
                }
                ("Nodes", Some(Version::V4)) => nodes_4(&mut cursor, &mut content)?,
                ("Nodes", Some(Version::V2)) => nodes_2(&mut cursor, &mut content)?,
                ("Elements", Some(Version::V4)) => elements_4(&mut cursor, &mut content)?,
                ("Elements", Some(Version::V2)) => elements_2(&mut cursor, &mut content)?,
                (other, _) => {
                    cursor.skip_section(other)?;
                    continue;
                }
            }
            cursor.end_section(section)?;
        }
        if version.is_none() {
            return Err(cursor.error("not a mesh: `$MeshFormat` is missing"));
        }
        content.into_mesh()
    }
}

#[derive(Clone, Copy)]
enum Version {
    V2,
    V4,
}

fn format(cursor: &mut Cursor<'_>) -> Result<Version, MeshError> {
    let line = cursor.line()?;
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let &[version, kind, size] = words.as_slice() else {
        return Err(cursor.error(format!("`{line}` is not `version type size`")));
    };
    let version = match version {
        "4.1" => Version::V4,
        "2.2" | "2.1" | "2" => Version::V2,
        other => return Err(cursor.error(format!("MSH format {other} is not read; 4.1 and 2.2 are"))),
    };
    if size != "8" {
        return Err(cursor.error(format!("numbers of {size} bytes are not read; 8 are")));
    }
    match kind {
        "0" => {}
        "1" => cursor.detect_order()?,
        other => return Err(cursor.error(format!("file type {other} is neither text (0) nor binary (1)"))),
    }
    Ok(version)
}

fn physical_names(cursor: &mut Cursor<'_>, content: &mut Content) -> Result<(), MeshError> {
    // Text in binary files as well.
    for _ in 0..cursor.text_count()? {
        let line = cursor.line()?;
        let mut words = line.splitn(3, ' ');
        let mut number = || words.next()?.parse::<i64>().ok();
        let (dimension, tag) = (number(), number());
        let name = words.next().map(|name| name.trim().trim_matches('"').to_string());
        let (Some(dimension @ 0..=3), Some(tag), Some(name)) = (dimension, tag, name) else {
            return Err(cursor.error(format!("`{line}` is not `dimension number \"name\"`")));
        };
        content.names.insert((dimension as usize, tag), name);
    }
    Ok(())
}

fn entities(cursor: &mut Cursor<'_>, content: &mut Content) -> Result<(), MeshError> {
    let counts = [cursor.size()?, cursor.size()?, cursor.size()?, cursor.size()?];
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let tag = cursor.int()?;
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
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

fn nodes_4(cursor: &mut Cursor<'_>, content: &mut Content) -> Result<(), MeshError> {
    let blocks = cursor.size()?;
    // How many in all, and the range of their tags, which the blocks tell as well.
    for _ in 0..3 {
        cursor.size()?;
    }
    for _ in 0..blocks {
        let (dimension, _entity, parametric) = (cursor.int()?, cursor.int()?, cursor.int()?);
        let count = cursor.size()?;
        let mut tags = Vec::new();
        for _ in 0..count {
            tags.push(cursor.size()?);
        }
        for tag in tags {
            let position = [cursor.real()?, cursor.real()?, cursor.real()?];
            // Parameters of the node on its entity.
            for _ in 0..if parametric != 0 { dimension.clamp(0, 3) } else { 0 } {
                cursor.real()?;
            }
            content.nodes.push((tag, position));
        }
    }
    Ok(())
}

fn nodes_2(cursor: &mut Cursor<'_>, content: &mut Content) -> Result<(), MeshError> {
    for _ in 0..cursor.text_count()? {
        let tag = positive(cursor.int()?, cursor)?;
        content.nodes.push((tag, [cursor.real()?, cursor.real()?, cursor.real()?]));
    }
    Ok(())
}

fn positive(tag: i64, cursor: &Cursor<'_>) -> Result<u64, MeshError> {
    u64::try_from(tag).map_err(|_| cursor.error(format!("the number {tag} is negative")))
}

/// Number of nodes of an element type of Gmsh.
fn node_count(element: u64, kind: i64) -> Result<usize, MeshError> {
    match kind {
        15 => Ok(1),
        1 => Ok(2),
        2 => Ok(3),
        other => Err(MeshError::ElementType { element, kind: other.unsigned_abs() }),
    }
}

fn elements_4(cursor: &mut Cursor<'_>, content: &mut Content) -> Result<(), MeshError> {
    let blocks = cursor.size()?;
    // How many in all, and the range of their tags, which the blocks tell as well.
    for _ in 0..3 {
        cursor.size()?;
    }
    for _ in 0..blocks {
        let (dimension, entity, kind) = (cursor.int()?, cursor.int()?, cursor.int()?);
        let count = cursor.size()?;
        let key = (positive(dimension, cursor)? as usize, entity);
        let physical = content.entities.get(&key).cloned().unwrap_or_default();
        for _ in 0..count {
            let tag = cursor.size()?;
            let mut nodes = Vec::new();
            for _ in 0..node_count(tag, kind)? {
                nodes.push(cursor.size()?);
            }
            content.elements.push(Member { tag, nodes, physical: physical.clone() });
        }
    }
    Ok(())
}

fn elements_2(cursor: &mut Cursor<'_>, content: &mut Content) -> Result<(), MeshError> {
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
            let mut physical = Vec::new();
            for i in 0..tags {
                let value = cursor.int()?;
                if i == 0 && value != 0 {
                    physical.push(value);
                }
            }
            let mut nodes = Vec::new();
            for _ in 0..node_count(tag, kind)? {
                let node = cursor.int()?;
                nodes.push(positive(node, cursor)?);
            }
            content.elements.push(Member { tag, nodes, physical });
            read += 1;
        }
    }
    Ok(())
}

impl Content {
    fn into_mesh(self) -> Result<Mesh, MeshError> {
        let mut index = HashMap::new();
        for (i, &(tag, position)) in self.nodes.iter().enumerate() {
            if index.insert(tag, i).is_some() {
                return Err(MeshError::Duplicate { what: "node", tag });
            }
            if let Some(axis) = (0..3).find(|&axis| !position[axis].is_finite()) {
                let (value, axis) = (position[axis], ['x', 'y', 'z'][axis]);
                return Err(MeshError::Coordinate { node: tag, axis, value, range: "finite" });
            }
        }
        let (mut elements, mut tags) = (Vec::new(), HashSet::new());
        let mut groups: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for member in &self.elements {
            if !tags.insert(member.tag) {
                return Err(MeshError::Duplicate { what: "element", tag: member.tag });
            }
            let place = |&node: &u64| {
                index.get(&node).copied().ok_or(MeshError::UnknownNode { element: member.tag, node })
            };
            let nodes = member.nodes.iter().map(place).collect::<Result<Vec<_>, _>>()?;
            let shape = match *nodes.as_slice() {
                [a] => Shape::Point([a]),
                [a, b] => Shape::Segment([a, b]),
                [a, b, c] => Shape::Triangle([a, b, c]),
                _ => continue,
            };
            for &physical in &member.physical {
                // A negative number says that the entity runs backwards in the group.
                let key = (shape.dimension(), physical.abs());
                let name = self.names.get(&key).cloned().unwrap_or_else(|| format!("{}:{}", key.0, key.1));
                groups.entry(name).or_default().push(elements.len());
            }
            elements.push(Element { tag: member.tag, shape });
        }
        // A named group without elements exists, and is empty.
        for name in self.names.into_values() {
            groups.entry(name).or_default();
        }
        let plane = self.nodes.first().map_or(0.0, |(_, position)| position[2]);
        let off = |z: f64| (z - plane).abs() > 1e-12 * plane.abs().max(1.0);
        if let Some(&(node, [_, _, value])) = self.nodes.iter().find(|(_, position)| off(position[2])) {
            let range = "the same for all nodes: planar meshes are read";
            return Err(MeshError::Coordinate { node, axis: 'z', value, range });
        }
        let nodes = self.nodes.iter().map(|&(tag, [x, y, _])| Node { tag, position: [x, y] }).collect();
        Mesh::new(nodes, elements, groups)
    }
}
