//! Why a mesh cannot be used.

/// Why a mesh cannot be used; every variant names the element, node, group or line at fault.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
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
    #[error("line {line}: {message}")]
    Format {
        /// Line, from 1; 0 where the fault has no place.
        line: usize,
        /// What is wrong there.
        message: String,
    },
    /// An element type that is not read.
    #[error(
        "element {element} has the Gmsh type {kind}; points (15), two-node lines (1) and three-node triangles (2) are read"
    )]
    ElementType {
        /// Tag of the element.
        element: u64,
        /// Gmsh's number of the type.
        kind: u64,
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
    /// An element without positive measure: its nodes coincide, line up, or run clockwise.
    #[error(
        "element {element} (nodes {nodes:?}) is inverted or degenerate: its {measure} is {value:e}, it must be > 0 \
         (nodes of a triangle run counter-clockwise)"
    )]
    Inverted {
        /// Tag of the element.
        element: u64,
        /// Tags of its nodes.
        nodes: Vec<u64>,
        /// `area` or `length`.
        measure: &'static str,
        /// The measure.
        value: f64,
    },
    /// A node that no element of the body uses: nothing would hold it.
    #[error("node {node} at ({x}, {y}) belongs to no element of the body")]
    DanglingNode {
        /// Tag of the node.
        node: u64,
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
    },
    /// No elements that could make a body.
    #[error("the mesh has no triangle and no line: there is no body")]
    Empty,
    /// A group that does not exist.
    #[error("the mesh has no group `{name}` (known: {known})")]
    UnknownGroup {
        /// The name asked for.
        name: String,
        /// The groups that exist.
        known: String,
    },
    /// A group whose elements have the wrong dimension for their use.
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
