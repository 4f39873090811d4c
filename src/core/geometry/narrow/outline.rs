//! Two convex outlines seen along a normal: all corners of what they share.
//!
//! The corners of the intersection of two convex polygons are vertices of one inside the other, and crossings of sides. All
//! are found, in the order vertices of the first, vertices of the second, crossings. Where corners coincide within the
//! tolerance, the first in that order stands for all: rounding does not choose. A segment is an outline of two corners
//! and one side.

use nalgebra::Vector3;

use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::real::{infinity, max};
use crate::scalar::Scalar;

/// An outline in the plane, counterclockwise.
#[derive(Debug, Clone)]
pub(super) struct Outline<T: Scalar> {
    points: Vec<[T; 2]>,
    /// Outward normals of the sides, from each corner to the next, shorter than 1 where the plane of the outline is oblique.
    normals: Vec<[T; 2]>,
    /// Largest offset of a corner along each normal: short sides lean, and no corner is outside of its own outline.
    offsets: Vec<T>,
    vertices: Vec<u32>,
    edges: Vec<u32>,
}

/// The border of a face: corners, and the sides from each to the next.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ring<'a, T: Scalar> {
    pub(super) vertices: &'a [u32],
    pub(super) edges: &'a [u32],
    pub(super) inverse_lengths: &'a [T],
}

impl<'a, T: Scalar> Ring<'a, T> {
    pub(super) fn of(hull: &'a Polyhedron<T>, face: usize) -> Self {
        let inverse_lengths = hull.inverse_lengths(face);
        Self { vertices: hull.corners(face), edges: hull.sides(face), inverse_lengths }
    }
}

/// What meets at a corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Corner {
    /// A vertex of the first outline inside the second.
    First(u32),
    /// A vertex of the second inside the first.
    Second(u32),
    /// Edges of both that cross.
    Crossing(u32, u32),
}

impl<T: Scalar> Outline<T> {
    pub(super) fn new() -> Self {
        Self { points: vec![], normals: vec![], offsets: vec![], vertices: vec![], edges: vec![] }
    }

    /// Sets the outline to `ring`, placed in the plane by `flat`; run backwards where it is clockwise there.
    pub(super) fn set(&mut self, ring: Ring<'_, T>, backwards: bool, mut flat: impl FnMut(u32) -> [T; 2]) {
        self.vertices.clear();
        self.edges.clear();
        self.points.clear();
        self.normals.clear();
        self.offsets.clear();
        let (count, sides) = (ring.vertices.len(), ring.edges.len());
        for k in 0..count {
            let vertex = ring.vertices[if backwards { count - 1 - k } else { k }];
            self.vertices.push(vertex);
            self.points.push(flat(vertex));
        }
        for k in 0..sides {
            // Backwards, the side from the last corner but one to the last comes first.
            let side = if backwards { (2 * sides - 2 - k) % sides } else { k };
            let next = if k + 1 == count { 0 } else { k + 1 };
            let ([x, y], [to_x, to_y]) = (self.points[k], self.points[next]);
            let inverse = ring.inverse_lengths[side];
            let normal = [(to_y - y) * inverse, (x - to_x) * inverse];
            let along = |p: &[T; 2]| normal[0] * p[0] + normal[1] * p[1];
            self.edges.push(ring.edges[side]);
            self.normals.push(normal);
            self.offsets.push(self.points.iter().fold(-infinity::<T>(), |far, p| max(far, along(p))));
        }
    }

    /// Distances of the corners of `self` from the sides of `other`, by corner and then side.
    fn distances(&self, other: &Self, out: &mut Vec<T>) {
        out.clear();
        for p in &self.points {
            let sides = other.normals.iter().zip(&other.offsets);
            out.extend(sides.map(|(n, &offset)| n[0] * p[0] + n[1] * p[1] - offset));
        }
    }

    fn is_area(&self) -> bool {
        self.edges.len() >= 3
    }
}

/// Calls `meet` for every corner of what `first` and `second` share, within `tolerance`.
pub(super) fn corners<T: Scalar>(
    first: &Outline<T>,
    second: &Outline<T>,
    tolerance: T,
    [of_first, of_second]: &mut [Vec<T>; 2],
    mut meet: impl FnMut(Corner),
) {
    first.distances(second, of_first);
    second.distances(first, of_second);
    let (m, n) = (first.edges.len(), second.edges.len());
    let inside = |row: &[T]| row.iter().all(|&d| d <= tolerance);
    // An outline inside of the other crosses none of its sides.
    let mut within = false;
    if second.is_area() {
        within = true;
        for (i, row) in of_first.chunks_exact(n).enumerate() {
            if inside(row) {
                meet(Corner::First(first.vertices[i]));
            } else {
                within = false;
            }
        }
    }
    if first.is_area() {
        let mut all = true;
        let near = (tolerance + tolerance) * (tolerance + tolerance);
        for (j, row) in of_second.chunks_exact(m).enumerate() {
            let q = second.points[j];
            let taken = || {
                second.is_area()
                    && first.points.iter().zip(of_first.chunks_exact(n)).any(|(p, row)| {
                        let (x, y) = (p[0] - q[0], p[1] - q[1]);
                        x * x + y * y <= near && inside(row)
                    })
            };
            if !inside(row) {
                all = false;
            } else if !taken() {
                meet(Corner::Second(second.vertices[j]));
            }
        }
        within |= all;
    }
    if within {
        return;
    }
    // Sides that cross between their ends.
    let apart = |x: T, y: T| (x > tolerance && y < -tolerance) || (x < -tolerance && y > tolerance);
    for i in 0..m {
        let next = (i + 1) % first.points.len();
        for j in 0..n {
            if !apart(of_first[i * n + j], of_first[next * n + j]) {
                continue;
            }
            let after = (j + 1) % second.points.len();
            if apart(of_second[j * m + i], of_second[after * m + i]) {
                meet(Corner::Crossing(first.edges[i], second.edges[j]));
            }
        }
    }
}

/// Two unit vectors that make a right-handed frame with `normal`, at the least cost (T. Duff et al., 2017,
/// jcgt.org/published/0006/01/01): nothing of a contact depends on which.
#[inline]
pub(super) fn tangents<T: Scalar>(n: &Vector3<T>) -> [Vector3<T>; 2] {
    let sign = if n.z < T::zero() { -T::one() } else { T::one() };
    let a = -T::one() / (sign + n.z);
    let b = n.x * n.y * a;
    let first = Vector3::new(T::one() + sign * n.x * n.x * a, sign * b, -sign * n.x);
    [first, Vector3::new(b, sign + n.y * n.y * a, -n.y)]
}
