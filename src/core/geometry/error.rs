//! Why points make no solid.

/// Why points have no hull that is a solid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HullError {
    /// A coordinate that is NaN or infinite.
    #[error("point {point} is not finite")]
    NotFinite {
        /// Index of the point.
        point: usize,
    },
    /// Fewer than four points.
    #[error("{points} points hold no volume; a polyhedron has at least 4 vertices")]
    TooFew {
        /// Number of points.
        points: usize,
    },
    /// All points in one place, on a line or in a plane.
    #[error("the points lie in a plane, or nearly: their hull is {thickness:e} m thick")]
    Flat {
        /// Largest distance from that plane (m).
        thickness: f64,
    },
    /// A tolerance that is negative, or too large to leave a shape.
    #[error("the tolerance is {tolerance:e} of the size, it must be in [0, 0.01]")]
    Tolerance {
        /// The tolerance.
        tolerance: f64,
    },
    /// More vertices than identities of contacts can name.
    #[error("{points} points are more than identities can name")]
    TooMany {
        /// Number of points.
        points: usize,
    },
    /// Triangles that could not be joined to faces in any way that closes.
    #[error("the hull does not close; its points are too close to each other for their number format")]
    Unresolved,
}
