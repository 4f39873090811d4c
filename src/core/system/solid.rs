//! Shapes of bodies and places of contacts, for pictures alone.

/// A surface in the frame of its body. What no face and no line uses of its points is drawn as points.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Surface {
    /// Points (m).
    pub points: Vec<[f64; 3]>,
    /// Flat polygons as indices of points, counterclockwise seen from outside; they may be concave.
    pub faces: Vec<Vec<u32>>,
    /// Polylines as indices of points, drawn beside the faces.
    pub lines: Vec<Vec<u32>>,
    /// Whether the faces approximate a round surface: its edges are none of the shape.
    pub round: bool,
}

/// A shape that is fixed to a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// Name.
    pub name: String,
    /// The body, `None` for what is fixed.
    pub body: Option<usize>,
    /// The surface in the frame of the body.
    pub surface: Surface,
    /// Whether the surface stands for an endless plane, which pictures stretch to their size. It then is one face of about
    /// 1 m whose normal points to where bodies are, or in the plane one segment with bodies on its left.
    pub endless: bool,
}

/// Where a contact is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPlace {
    /// Point (m) in the fixed frame.
    pub point: [f64; 3],
    /// Normal and tangents in the fixed frame, along which the first three components of a percussion act; zero where the
    /// component is no force or there is none.
    pub axes: [[f64; 3]; 3],
}
