//! A triangle of a hull under construction, and the side of it a point is on, exactly.

use nalgebra::Vector3;
use robust::{Coord3D, orient3d};

/// A triangle of the hull under construction.
#[derive(Debug, Clone)]
pub(super) struct Triangle {
    /// Counterclockwise from outside.
    pub(super) corners: [u32; 3],
    /// The triangle across the side from each corner to the next.
    pub(super) across: [u32; 3],
    pub(super) alive: bool,
    /// Points that see it and are not yet in the hull.
    pub(super) above: Vec<u32>,
}

/// Sign of the volume of (a, b, c, x): positive where x is on the side from which a, b, c is counterclockwise.
pub(super) fn side(points: &[Vector3<f64>], [a, b, c]: [u32; 3], x: u32) -> f64 {
    let at = |i: u32| {
        let p = &points[i as usize];
        Coord3D { x: p.x, y: p.y, z: p.z }
    };
    // `orient3d` is positive below a counterclockwise triangle.
    -orient3d(at(a), at(b), at(c), at(x))
}
