//! Why a mesh cannot be used, and what was done to one that can.

/// Why a mesh cannot be used; every variant names the element, node, group or line at fault.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The file cannot be read.
    #[error("cannot read the mesh {path}: {message}")]
    Read {
        /// The file.
        path: String,
        /// What the system says.
        message: String,
    },
    /// The text is not a mesh in the MSH format.
    #[error("{}{message}", at_line(*line))]
    Format {
        /// Line, from 1; 0 where the fault has no place.
        line: usize,
        /// What is wrong there.
        message: String,
    },
    /// An element type whose number of nodes is not known.
    #[error(
        "element {element} has the Gmsh type {kind}, which is not known; points (15), two-node lines (1) and \
         three-node triangles (2) are read"
    )]
    ElementType {
        /// Tag of the element.
        element: u64,
        /// Gmsh's number of the type.
        kind: u64,
    },
    /// Elements of a type that nothing is computed with.
    #[error(
        "the mesh has {count} elements of the type {name} (Gmsh type {kind}; the first is element {element}); planar \
         meshes of three-node triangles, two-node lines and points are read: in Gmsh, Mesh.ElementOrder = 1 and \
         Mesh.RecombineAll = 0 make them"
    )]
    ElementKind {
        /// What the type is called.
        name: &'static str,
        /// Gmsh's number of the type.
        kind: u64,
        /// How many there are.
        count: usize,
        /// Tag of the first.
        element: u64,
    },
    /// An element names a node that is not there.
    #[error("element {element} names node {node}, which does not exist")]
    UnknownNode {
        /// Tag of the element.
        element: u64,
        /// Tag of the node.
        node: u64,
    },
    /// Two nodes, or two elements, share a tag.
    #[error("{what} {tag} is defined twice")]
    Duplicate {
        /// `node` or `element`.
        what: &'static str,
        /// The tag.
        tag: u64,
    },
    /// One element occurs twice: its mass and stiffness, or the load on it, would count twice.
    #[error("element {second} is element {first} once more (nodes {nodes:?}): leave one of them out")]
    Doubled {
        /// Tag of the first.
        first: u64,
        /// Tag of the second.
        second: u64,
        /// Tags of their nodes.
        nodes: Vec<u64>,
    },
    /// Two elements of the body lie on the same side of an edge they share.
    #[error("elements {first} and {second} overlap: both lie on the same side of their edge {edge:?}")]
    Overlap {
        /// Tag of the first.
        first: u64,
        /// Tag of the second.
        second: u64,
        /// Tags of the nodes of the edge.
        edge: [u64; 2],
    },
    /// A coordinate is NaN, infinite, or leaves the plane or line of the mesh.
    #[error("node {node}: coordinate {axis} is {value}, it must be {range}")]
    Coordinate {
        /// Tag of the node.
        node: u64,
        /// `x`, `y` or `z`.
        axis: char,
        /// The value refused.
        value: f64,
        /// The range in words.
        range: &'static str,
    },
    /// An element without measure: its nodes coincide or line up.
    #[error("element {element} (nodes {nodes:?}) is degenerate: its {measure} is {value:e}, it must be > 0")]
    Degenerate {
        /// Tag of the element.
        element: u64,
        /// Tags of its nodes.
        nodes: Vec<u64>,
        /// `area` or `length`.
        measure: &'static str,
        /// The measure.
        value: f64,
    },
    /// No elements that could make a body.
    #[error("the mesh has no triangle and no line: there is no body")]
    Empty,
    /// A group that does not exist, and is no selector.
    #[error(
        "the mesh has no group `{name}` (known: {known}); parts of the boundary are selected by `left`, `right`, \
         `bottom`, `top`, `boundary`, a comparison as `x < 1e-6`, or the outward normal as `normal -y`"
    )]
    UnknownGroup {
        /// The name asked for.
        name: String,
        /// The groups that exist.
        known: String,
    },
    /// A group without elements, or a selector that selects nothing.
    #[error("`{name}` has no element: the body reaches from ({x0}, {y0}) to ({x1}, {y1})")]
    EmptyGroup {
        /// The group or the selector.
        name: String,
        /// Smallest x of the body.
        x0: f64,
        /// Smallest y.
        y0: f64,
        /// Largest x.
        x1: f64,
        /// Largest y.
        y1: f64,
    },
    /// A group none of whose elements has the dimension that its use needs.
    #[error("group `{name}` has element {element} of dimension {given}, {wanted} needed")]
    GroupDimension {
        /// The group.
        name: String,
        /// Tag of the first element that does not fit.
        element: u64,
        /// Its dimension.
        given: usize,
        /// The dimension needed.
        wanted: usize,
    },
    /// Two groups would have one name.
    #[error("the mesh has a group `{name}` already: `{old}` cannot be called so")]
    GroupExists {
        /// The name.
        name: String,
        /// What should be called so.
        old: String,
    },
    /// A size or a count of a built-in mesh is out of range.
    #[error("{what} is {value}, it must be {range}")]
    OutOfRange {
        /// What it is.
        what: &'static str,
        /// The value refused.
        value: f64,
        /// The range in words.
        range: &'static str,
    },
}

/// `line n: `, or nothing for a fault without a place.
fn at_line(line: usize) -> String {
    if line == 0 { String::new() } else { format!("line {line}: ") }
}

/// What a reader of a mesh should know of it: it is used, but perhaps not as its author meant.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum MeshNote {
    /// Nodes that belong to no element of the body were left out.
    LeftOut {
        /// How many.
        count: usize,
        /// Tag of the first.
        node: u64,
        /// Where it is (m).
        position: [f64; 2],
    },
    /// Triangles whose nodes run clockwise were turned.
    Turned {
        /// How many.
        count: usize,
        /// Tag of the first.
        element: u64,
    },
    /// The body falls into parts that no element connects.
    Parts {
        /// How many.
        count: usize,
    },
}

impl std::fmt::Display for MeshNote {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Self::LeftOut { count, node, position: [x, y] } => write!(
                f,
                "nodes of the mesh that belong to no element of the body are left out: {count}, the first is node \
                 {node} at ({x}, {y})"
            ),
            Self::Turned { count, element } => {
                write!(
                    f,
                    "triangles of the mesh that run clockwise are turned: {count}, the first is element {element}"
                )
            }
            Self::Parts { count } => write!(
                f,
                "the mesh falls into {count} parts without a common node: nothing holds them together, and they do \
                 not feel each other"
            ),
        }
    }
}
