//! Gmsh MSH files, formats 2.0 to 4.1, as text and binary: <https://gmsh.info/doc/texinfo/gmsh.html#File-formats>.
//!
//! `mshio` 0.4 reads 4.1 alone and drops the names of physical groups, which boundary conditions need.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;

use super::content::{Content, Version};
use super::kinds::Kind;
use super::sections::Cursor;
use super::{Element, Mesh, MeshError, Node, Shape, msh_2, msh_4};

impl Mesh {
    /// Reads a Gmsh file, format 2.0, 2.1, 2.2, 4.0 or 4.1, text or binary. Physical groups become groups; one without
    /// a name is called `dimension:number`. Geometric entities are groups as well: `point 1`, `curve 3`, `surface 2`.
    /// Three-node triangles must lie in a plane z = const and make the body; where there are none, lines on the x axis
    /// do. Partitions and sections that say nothing of nodes and elements are passed over.
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
                ("NOD" | "ELM", _) => {
                    return Err(cursor.error("MSH format 1 is not read; save it as format 2.2 or 4.1"));
                }
                ("PhysicalNames" | "Entities" | "PartitionedEntities" | "Nodes" | "Elements", None) => {
                    return Err(cursor.error("`$MeshFormat` must come before it"));
                }
                ("PhysicalNames", Some(version)) => physical_names(&mut cursor, &mut content, version)?,
                ("Entities", Some(version @ (Version::V40 | Version::V41))) => {
                    msh_4::entities(&mut cursor, &mut content, (version, false))?;
                }
                ("PartitionedEntities", Some(version @ (Version::V40 | Version::V41))) => {
                    msh_4::entities(&mut cursor, &mut content, (version, true))?;
                }
                ("Nodes", Some(version @ (Version::V40 | Version::V41))) => {
                    msh_4::nodes(&mut cursor, &mut content, version)?;
                }
                ("Elements", Some(version @ (Version::V40 | Version::V41))) => {
                    msh_4::elements(&mut cursor, &mut content, version)?;
                }
                ("Nodes", Some(_)) => msh_2::nodes(&mut cursor, &mut content, false)?,
                ("ParametricNodes", Some(_)) => msh_2::nodes(&mut cursor, &mut content, true)?,
                ("Elements", Some(_)) => msh_2::elements(&mut cursor, &mut content)?,
                (other, _) => {
                    cursor.skip_section(other)?;
                    continue;
                }
            }
            cursor.end_section(section)?;
        }
        if version.is_none() {
            return Err(cursor.error("not a Gmsh mesh: `$MeshFormat` is missing"));
        }
        content.into_mesh()
    }
}

fn format(cursor: &mut Cursor<'_>) -> Result<Version, MeshError> {
    let line = cursor.line()?;
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let &[version, kind, size] = words.as_slice() else {
        return Err(cursor.error(format!("`{line}` is not `version type size`")));
    };
    let version = match version {
        "4.1" => Version::V41,
        "4" | "4.0" => Version::V40,
        "2.2" | "2.1" => Version::V22,
        "2" | "2.0" => Version::V20,
        other => {
            let message = format!("MSH format {other} is not read; 2.0, 2.1, 2.2, 4.0 and 4.1 are");
            return Err(cursor.error(message));
        }
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

fn physical_names(cursor: &mut Cursor<'_>, content: &mut Content, version: Version) -> Result<(), MeshError> {
    // Text in binary files as well.
    for _ in 0..cursor.text_count()? {
        let line = cursor.line()?;
        let mut rest = line;
        let mut number = || {
            let (word, after) = rest.split_once(|c: char| c.is_ascii_whitespace())?;
            rest = after.trim_start();
            word.parse::<i64>().ok()
        };
        let dimension = if version == Version::V20 { Some(None) } else { number().map(Some) };
        let tag = number();
        let dimension = dimension.and_then(|given| match given {
            None => Some(None),
            Some(dimension @ 0..=3) => Some(Some(dimension as usize)),
            Some(_) => None,
        });
        let (Some(dimension), Some(tag)) = (dimension, tag) else {
            return Err(cursor.error(format!("`{line}` is not `dimension number \"name\"`")));
        };
        content.names.insert((dimension, tag), rest.trim().trim_matches('"').to_string());
    }
    Ok(())
}

impl Content {
    /// The types of element that nothing is computed with, if there are any: name, how many, tag of the first.
    fn unused_kinds(&self) -> Result<(), MeshError> {
        let mut kinds: BTreeMap<u64, (Kind, usize, u64)> = BTreeMap::new();
        for member in self.elements.iter().filter(|member| !member.kind.is_used()) {
            kinds.entry(member.kind.number).or_insert((member.kind, 0, member.tag)).1 += 1;
        }
        // The body's before those of its boundary.
        match kinds.into_values().max_by_key(|(kind, ..)| kind.dimension) {
            Some((kind, count, element)) => {
                let Kind { name, number, .. } = kind;
                Err(MeshError::ElementKind { name, kind: number, count, element })
            }
            None => Ok(()),
        }
    }

    fn into_mesh(self) -> Result<Mesh, MeshError> {
        self.unused_kinds()?;
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
        let (mut elements, mut tags) = (Vec::<Element>::new(), HashSet::new());
        let mut groups: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        // Elements by their nodes, with their groups: in formats 2 one that is in two groups is written twice.
        let mut known: HashMap<Vec<usize>, (usize, Vec<i64>)> = HashMap::new();
        let body = self.elements.iter().map(|member| member.kind.dimension).max().unwrap_or(0);
        for member in &self.elements {
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
            let mut sorted = nodes;
            sorted.sort_unstable();
            let is_new = tags.insert(member.tag);
            let at = match known.get_mut(&sorted) {
                Some((first, physical)) => {
                    let nameless = member.physical.is_empty() || physical.is_empty();
                    let again = member.physical.iter().any(|group| physical.contains(group));
                    if again || (nameless && shape.dimension() == body) {
                        let (first, second, nodes) = (elements[*first].tag, member.tag, member.nodes.clone());
                        return Err(MeshError::Doubled { first, second, nodes });
                    }
                    physical.extend(&member.physical);
                    *first
                }
                None if !is_new => return Err(MeshError::Duplicate { what: "element", tag: member.tag }),
                None => {
                    known.insert(sorted, (elements.len(), member.physical.clone()));
                    elements.push(Element { tag: member.tag, shape });
                    elements.len() - 1
                }
            };
            let (dimension, entity) = member.entity;
            let name = format!("{} {entity}", ["point", "curve", "surface", "volume"][dimension.min(3)]);
            // A physical group of that name is meant in its place.
            if entity > 0 && !self.names.values().any(|known| *known == name) {
                let group = groups.entry(name).or_default();
                if group.last() != Some(&at) {
                    group.push(at);
                }
            }
            for &physical in &member.physical {
                // A negative number says that the entity runs backwards in the group.
                let key = (shape.dimension(), physical.abs());
                let name = self.names.get(&(Some(key.0), key.1)).or_else(|| self.names.get(&(None, key.1)));
                let name = name.cloned().unwrap_or_else(|| format!("{}:{}", key.0, key.1));
                groups.entry(name).or_default().push(at);
            }
        }
        // A named group without elements exists, and is empty.
        for name in self.names.into_values() {
            groups.entry(name).or_default();
        }
        check_plane(&self.nodes, &elements)?;
        let nodes = self.nodes.iter().map(|&(tag, [x, y, _])| Node { tag, position: [x, y] }).collect();
        Mesh::new(nodes, elements, groups)
    }
}

/// Checks that the nodes of the body have one z, but for rounding.
fn check_plane(nodes: &[(u64, [f64; 3])], elements: &[Element]) -> Result<(), MeshError> {
    let dimension = elements.iter().map(|element| element.shape.dimension()).max().unwrap_or(0);
    let body = elements.iter().filter(|element| element.shape.dimension() == dimension);
    let mut of_body = body.flat_map(|element| element.shape.nodes()).map(|&node| nodes[node]);
    let Some((_, [x, y, plane])) = of_body.next() else { return Ok(()) };
    let (mut extent, mut farthest) = (0.0_f64, (0.0_f64, 0));
    for (tag, at) in of_body {
        extent = extent.max((at[0] - x).abs()).max((at[1] - y).abs());
        let off = (at[2] - plane).abs();
        if off > farthest.0 {
            farthest = (off, tag);
        }
    }
    let node = nodes.iter().find(|(tag, _)| *tag == farthest.1);
    match node {
        Some(&(node, [_, _, value])) if farthest.0 > 1e-9 * extent => {
            let range = "the same for all nodes: the body must lie in a plane z = const";
            Err(MeshError::Coordinate { node, axis: 'z', value, range })
        }
        _ => Ok(()),
    }
}
