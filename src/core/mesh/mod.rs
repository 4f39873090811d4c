//! Meshes with named groups: read from Gmsh files or built in, and checked before anything is computed on them.

mod content;
mod error;
mod kinds;
mod msh;
mod msh_2;
mod msh_4;
mod rectangle;
mod sections;
mod select;
mod sound;

use std::collections::BTreeMap;

pub use error::{MeshError, MeshNote};
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
/// Every mesh in hand is sound: elements of the body have positive measure, do not overlap their neighbours, and every
/// node belongs to one.
///
/// Where a group is asked for, a part of the boundary may be selected in its place: `left`, `right`, `bottom`, `top`
/// (within 1e-6 of the body's extent), `boundary`, `x < 1e-6` (or `<=`, `>`, `>=`, `=`, of x or y; all nodes of an edge),
/// `normal -y` (outward normals within 45° of a direction of an axis), and several of these joined by `and`. A group of
/// that name comes first.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    dimension: usize,
    nodes: Vec<Node>,
    elements: Vec<Element>,
    groups: BTreeMap<String, Vec<usize>>,
    notes: Vec<MeshNote>,
}

impl Mesh {
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

    /// What a reader of the mesh should know of it.
    pub fn notes(&self) -> &[MeshNote] {
        &self.notes
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

    /// Lower left and upper right corner of the bounding box.
    pub fn corners(&self) -> [[f64; 2]; 2] {
        let along = |axis: usize| self.nodes.iter().map(move |node| node.position[axis]);
        [
            std::array::from_fn(|axis| along(axis).fold(f64::INFINITY, f64::min)),
            std::array::from_fn(|axis| along(axis).fold(f64::NEG_INFINITY, f64::max)),
        ]
    }

    /// Extents of the bounding box along x and y.
    pub fn extent(&self) -> [f64; 2] {
        let [low, high] = self.corners();
        std::array::from_fn(|axis| high[axis] - low[axis])
    }
}

/// Most elements of a built-in mesh.
const LARGEST: usize = 10_000_000;
