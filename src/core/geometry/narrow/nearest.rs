//! Nearest points: a point and a polyhedron, two segments.

use nalgebra::Vector3;

use super::resolve::nearest_on_lines;
use crate::geometry::feature::Feature;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::real::{infinity, sqrt};
use crate::scalar::Scalar;

/// The feature of `hull` nearest to the point `p` of its frame, and its distance, negative inside; a face wins within
/// `tolerance`, over an edge to rounding is over a face.
///
/// Inside, the nearest face. Outside, faces are looked at while their plane is nearer than what was found: exact.
pub(super) fn to_polyhedron<T: Scalar>(hull: &Polyhedron<T>, p: &Vector3<T>, tolerance: T) -> (Feature, T) {
    let mut highest = (0, -infinity::<T>());
    for (f, (normal, &offset)) in hull.normals.iter().zip(&hull.offsets).enumerate() {
        let height = normal.dot(p) - offset;
        if height > highest.1 + tolerance {
            highest = (f, height);
        }
    }
    let (face, height) = highest;
    if !(height > T::zero()) || hull.is_over(face, p, tolerance) {
        return (Feature::Face(face as u32), height);
    }
    let mut best = (Feature::Face(face as u32), infinity::<T>());
    for (f, (normal, &offset)) in hull.normals.iter().zip(&hull.offsets).enumerate() {
        let height = normal.dot(p) - offset;
        if !(height > T::zero() && height < best.1) {
            continue;
        }
        if hull.is_over(f, p, tolerance) {
            best = (Feature::Face(f as u32), height);
            continue;
        }
        for &edge in hull.sides(f) {
            let [from, to] = hull.edges[edge as usize].vertices;
            let (start, end) = (hull.vertices[from as usize], hull.vertices[to as usize]);
            let along = end - start;
            let length = sqrt(along.dot(&along));
            let at = along.dot(&(p - start)) / length;
            let (feature, foot) = if at <= tolerance {
                (Feature::Vertex(from), start)
            } else if at >= length - tolerance {
                (Feature::Vertex(to), end)
            } else {
                (Feature::Edge(edge), start + along * (at / length))
            };
            let distance = (p - foot).norm();
            // An edge is met twice, and so is a vertex: the first time counts.
            if distance < best.1 - tolerance {
                best = (feature, distance);
            }
        }
    }
    // On an edge or a vertex to rounding there is no direction to it.
    if best.1 > tolerance { best } else { (Feature::Face(face as u32), height) }
}

/// Where along segment 0 and segment 1 their nearest points are, shares in [0, 1], and the distance.
pub(super) fn segments<T: Scalar>([a, a_end]: [Vector3<T>; 2], [b, b_end]: [Vector3<T>; 2]) -> ([T; 2], T) {
    let (u, v, r) = (a_end - a, b_end - b, b - a);
    let distance = |[s, t]: [T; 2]| (r + v * t - u * s).norm();
    if let Some([s, t]) = nearest_on_lines(u, v, r)
        && s >= T::zero()
        && s <= T::one()
        && t >= T::zero()
        && t <= T::one()
    {
        return ([s, t], distance([s, t]));
    }
    // Else one of the four ends is nearest.
    let clamp = crate::geometry::real::unit_interval;
    let onto = |x: Vector3<T>, along: &Vector3<T>| clamp(along.dot(&x) / along.dot(along));
    let ends = [
        [T::zero(), onto(-r, &v)],
        [T::one(), onto(u - r, &v)],
        [onto(r, &u), T::zero()],
        [onto(r + v, &u), T::one()],
    ];
    let first = (ends[0], distance(ends[0]));
    ends[1..].iter().fold(first, |best, &shares| {
        let found = distance(shares);
        if found < best.1 { (shares, found) } else { best }
    })
}
