//! Meshes with named groups: read from Gmsh files or built in, and checked before anything is computed on them.

mod error;
mod msh;
mod rectangle;
mod sections;

use std::collections::{BTreeMap, BTreeSet};

pub use error::MeshError;
pub use rectangle::{Pattern, rectangle};

/// A node: the number it has in the file, and where it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Number in the file, for messages.
    pub tag: u64,
    /// Position (x, y); y = 0 in a mesh of dimension 1.
    pub position: [f64; 2],
}

/// Shape of an element with the indices of its nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// A point.
    Point([usize; 1]),
    /// A two-node line.
    Segment([usize; 2]),
    /// A three-node triangle, counter-clockwise.
    Triangle([usize; 3]),
}

impl Shape {
    /// Dimension of the shape.
    pub fn dimension(&self) -> usize {
        self.nodes().len() - 1
    }

    /// Indices of the nodes.
    pub fn nodes(&self) -> &[usize] {
        match self {
            Self::Point(nodes) => nodes,
            Self::Segment(nodes) => nodes,
            Self::Triangle(nodes) => nodes,
        }
    }
}

/// An element: the number it has in the file, and its shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Element {
    /// Number in the file, for messages.
    pub tag: u64,
    /// Shape and nodes.
    pub shape: Shape,
}

/// A mesh of triangles in the plane (dimension 2), or of lines on the x axis (dimension 1), with named groups of
/// elements of any dimension.
///
/// Every mesh in hand is sound: elements of the body have positive measure, and every node belongs to one.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    dimension: usize,
    nodes: Vec<Node>,
    elements: Vec<Element>,
    groups: BTreeMap<String, Vec<usize>>,
}

impl Mesh {
    /// A mesh from its parts; the body is made of the triangles, or of the lines where there are none. Groups hold
    /// indices of elements.
    ///
    /// # Errors
    /// [`MeshError`] naming the element, node or group at fault.
    pub fn new(
        nodes: Vec<Node>,
        elements: Vec<Element>,
        groups: BTreeMap<String, Vec<usize>>,
    ) -> Result<Self, MeshError> {
        let dimension = elements.iter().map(|element| element.shape.dimension()).max().unwrap_or(0);
        if dimension == 0 {
            return Err(MeshError::Empty);
        }
        let mesh = Self { dimension, nodes, elements, groups };
        mesh.check()?;
        Ok(mesh)
    }

    fn check(&self) -> Result<(), MeshError> {
        for node in &self.nodes {
            for (axis, &value) in ['x', 'y'].into_iter().zip(&node.position) {
                let on_line = self.dimension == 2 || axis == 'x' || value == 0.0;
                let range = if on_line { "finite" } else { "0 in a mesh of lines, which lies on the x axis" };
                if !value.is_finite() || !on_line {
                    return Err(MeshError::Coordinate { node: node.tag, axis, value, range });
                }
            }
        }
        let unknown = |element: &Element, node: usize| MeshError::UnknownNode {
            element: element.tag,
            node: node as u64,
        };
        for element in &self.elements {
            if let Some(&node) = element.shape.nodes().iter().find(|&&node| node >= self.nodes.len()) {
                return Err(unknown(element, node));
            }
        }
        let extent = self.extent();
        let extent = extent[0].max(extent[1]);
        let mut used = vec![false; self.nodes.len()];
        for element in self.body() {
            let (measure, value) = match element.shape {
                Shape::Triangle(_) => ("area", self.measure(element)),
                _ => ("length", self.measure(element)),
            };
            // Below round-off of the coordinates a measure says nothing.
            if !(value > 1e-14 * extent.powi(self.dimension as i32)) {
                let nodes = element.shape.nodes().iter().map(|&node| self.nodes[node].tag).collect();
                return Err(MeshError::Inverted { element: element.tag, nodes, measure, value });
            }
            element.shape.nodes().iter().for_each(|&node| used[node] = true);
        }
        if let Some(at) = used.iter().position(|&used| !used) {
            let Node { tag, position: [x, y] } = self.nodes[at];
            return Err(MeshError::DanglingNode { node: tag, x, y });
        }
        for (name, members) in &self.groups {
            if let Some(&index) = members.iter().find(|&&index| index >= self.elements.len()) {
                let message = format!("group `{name}` names element {index} of {}", self.elements.len());
                return Err(MeshError::Format { line: 0, message });
            }
        }
        Ok(())
    }

    /// A line of `elements` equal elements from x = 0 to `length`, with the groups `left` and `right` (points) and
    /// `body`.
    ///
    /// # Errors
    /// [`MeshError::OutOfRange`].
    pub fn interval(length: f64, elements: usize) -> Result<Self, MeshError> {
        if !(length.is_finite() && length > 0.0) {
            return Err(MeshError::OutOfRange { what: "the length", value: length, range: "finite and > 0" });
        }
        if !(1..=LARGEST).contains(&elements) {
            let (what, range) = ("the number of elements", "between 1 and 10⁷");
            return Err(MeshError::OutOfRange { what, value: elements as f64, range });
        }
        let position = |i: usize| [length * (i as f64 / elements as f64), 0.0];
        let nodes = (0..=elements).map(|i| Node { tag: i as u64 + 1, position: position(i) }).collect();
        let mut all: Vec<Shape> = (0..elements).map(|i| Shape::Segment([i, i + 1])).collect();
        all.extend([Shape::Point([0]), Shape::Point([elements])]);
        let list = all.iter().enumerate().map(|(i, &shape)| Element { tag: i as u64 + 1, shape }).collect();
        let groups = BTreeMap::from([
            ("body".to_string(), (0..elements).collect()),
            ("left".to_string(), vec![elements]),
            ("right".to_string(), vec![elements + 1]),
        ]);
        Self::new(nodes, list, groups)
    }

    /// Dimension of the body: 2 for triangles, 1 for lines.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// The nodes.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Every element, of the body and of its groups.
    pub fn elements(&self) -> &[Element] {
        &self.elements
    }

    /// The elements of the body.
    pub fn body(&self) -> impl Iterator<Item = &Element> {
        self.elements.iter().filter(|element| element.shape.dimension() == self.dimension)
    }

    /// Names of the groups.
    pub fn group_names(&self) -> impl Iterator<Item = &str> {
        self.groups.keys().map(String::as_str)
    }

    /// Renames groups: each (old, new) pair.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`].
    pub fn rename_groups<'a>(
        &mut self,
        names: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<(), MeshError> {
        for (old, new) in names {
            self.group(old)?;
            if let Some(members) = self.groups.remove(old) {
                self.groups.insert(new.to_string(), members);
            }
        }
        Ok(())
    }

    fn group(&self, name: &str) -> Result<&[usize], MeshError> {
        self.groups.get(name).map(Vec::as_slice).ok_or_else(|| MeshError::UnknownGroup {
            name: name.into(),
            known: self.group_names().collect::<Vec<_>>().join(", "),
        })
    }

    /// The nodes of a group, ascending.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`].
    pub fn group_nodes(&self, name: &str) -> Result<Vec<usize>, MeshError> {
        let members = self.group(name)?.iter().flat_map(|&index| self.elements[index].shape.nodes());
        Ok(members.copied().collect::<BTreeSet<_>>().into_iter().collect())
    }

    /// The elements of a group, which must all have dimension `wanted`.
    ///
    /// # Errors
    /// [`MeshError::UnknownGroup`], [`MeshError::GroupDimension`].
    pub fn group_elements(&self, name: &str, wanted: usize) -> Result<Vec<Element>, MeshError> {
        let members: Vec<Element> = self.group(name)?.iter().map(|&index| self.elements[index]).collect();
        match members.iter().find(|element| element.shape.dimension() != wanted) {
            Some(element) => Err(MeshError::GroupDimension {
                name: name.into(),
                element: element.tag,
                given: element.shape.dimension(),
                wanted,
            }),
            None => Ok(members),
        }
    }

    /// Length of a line, signed area of a triangle, 1 for a point.
    pub fn measure(&self, element: &Element) -> f64 {
        let at = |node: usize| self.nodes[node].position;
        match element.shape {
            Shape::Point(_) => 1.0,
            // Lines of the body run towards +x or −x alike.
            Shape::Segment([a, b]) => (at(b)[0] - at(a)[0]).hypot(at(b)[1] - at(a)[1]),
            Shape::Triangle([a, b, c]) => {
                let ([ax, ay], [bx, by], [cx, cy]) = (at(a), at(b), at(c));
                0.5 * ((bx - ax) * (cy - ay) - (cx - ax) * (by - ay))
            }
        }
    }

    /// Extents of the bounding box along x and y.
    pub fn extent(&self) -> [f64; 2] {
        std::array::from_fn(|axis| {
            let along = || self.nodes.iter().map(|node| node.position[axis]);
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        })
    }
}

/// Most elements of a built-in mesh.
const LARGEST: usize = 10_000_000;
