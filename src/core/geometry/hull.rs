//! Convex hulls: quickhull with exact orientations (C. B. Barber, D. P. Dobkin, H. Huhdanpaa, 1996,
//! doi:10.1145/235815.235821).
//!
//! A point sees a triangle where it is strictly above its plane, decided exactly; so the triangles a point sees are connected,
//! their border is a ring none of whose edges is in line with the point, and the new triangles are never degenerate.

use nalgebra::Vector3;

use super::error::HullError;
use super::feature::Meeting;
use super::merge;
use super::polyhedron::Polyhedron;
use super::real::max;
use super::triangle::{Triangle, side};
use crate::scalar::{Scalar, all_finite, epsilon, lit, to_f64};

impl<T: Scalar> Polyhedron<T> {
    /// The convex hull of `points` (m), with faces that are plane within [`TOLERANCE`](Self::TOLERANCE) of their extent.
    ///
    /// # Errors
    ///
    /// [`HullError`], see [`hull_within`](Self::hull_within).
    pub fn hull(points: &[Vector3<T>]) -> Result<Self, HullError> {
        Self::hull_within(points, lit(Self::TOLERANCE))
    }

    /// The convex hull of `points` (m): triangles that are coplanar within `tolerance` times the largest extent become one
    /// face, and points within as much of a face or an edge are no vertices.
    ///
    /// Orientations are decided exactly, by adaptive predicates (J. R. Shewchuk, 1997, doi:10.1007/PL00009321) on the points
    /// rounded to `f64`; points that lie in a plane exactly, inside or outside of triangles, in any number, are met. The
    /// tolerance is at least 64 ε. Worst case quadratic in the number of points, N log N in practice.
    ///
    /// # Errors
    ///
    /// [`HullError`] for fewer than four points, points that are not finite, that lie on a point, line or plane within the
    /// tolerance, or for a tolerance outside of [0, 0.01].
    pub fn hull_within(points: &[Vector3<T>], tolerance: T) -> Result<Self, HullError> {
        build(points, tolerance)
    }
}

fn build<T: Scalar>(points: &[Vector3<T>], tolerance: T) -> Result<Polyhedron<T>, HullError> {
    if !(tolerance >= T::zero() && tolerance <= lit(0.01)) {
        return Err(HullError::Tolerance { tolerance: to_f64(tolerance) });
    }
    if let Some(point) = points.iter().position(|x| !all_finite(x.iter())) {
        return Err(HullError::NotFinite { point });
    }
    if points.len() < 4 {
        return Err(HullError::TooFew { points: points.len() });
    }
    if points.len() > Meeting::MOST_FEATURES / 4 {
        return Err(HullError::TooMany { points: points.len() });
    }
    // In units of the extent around the first point: the predicates neither overflow nor underflow, nor lose digits, as the
    // unit is a power of two.
    let exact: Vec<Vector3<f64>> = points.iter().map(|x| x.map(to_f64)).collect();
    let low = exact.iter().fold(exact[0], |low, x| low.inf(x));
    let high = exact.iter().fold(exact[0], |high, x| high.sup(x));
    let extent = (high * 0.5 - low * 0.5).amax() * 2.0;
    let reach = high.amax().max(low.amax());
    if !(extent > 0.0 && extent.is_finite()) {
        return Err(HullError::Flat { thickness: 0.0 });
    }
    let unit = 2f64.powi(reach.log2().ceil().clamp(-1000.0, 1000.0) as i32);
    let exact: Vec<Vector3<f64>> = exact.into_iter().map(|x| x / unit).collect();
    let tolerance = to_f64(max(tolerance, lit::<T>(64.0) * epsilon::<T>())) * (extent / unit);
    let triangles =
        triangles(&exact, tolerance).map_err(|thickness| HullError::Flat { thickness: thickness * unit })?;
    // With ever less tolerance, down to what is coplanar exactly.
    for tolerance in [tolerance, tolerance / 64.0, 0.0] {
        let Some((kept, faces)) = merge::faces(&exact, &triangles, tolerance) else { continue };
        let vertices = kept.iter().map(|&v| points[v as usize]).collect();
        if let Some(made) = Polyhedron::from_faces(vertices, faces) {
            return Ok(made);
        }
    }
    Err(HullError::Unresolved)
}

/// Four points that span the most: along the longest axis, farthest from that line, farthest from that plane; or the thickness
/// they lie within.
fn simplex(points: &[Vector3<f64>], tolerance: f64) -> Result<[u32; 4], f64> {
    let farthest = |of: &dyn Fn(&Vector3<f64>) -> f64| {
        let start = (0, f64::NEG_INFINITY);
        points.iter().enumerate().fold(start, |best, (i, x)| if of(x) > best.1 { (i, of(x)) } else { best })
    };
    let low = points.iter().fold(points[0], |low, x| low.inf(x));
    let high = points.iter().fold(points[0], |high, x| high.sup(x));
    let axis = (high - low).imax();
    let (a, b) = (farthest(&|x| -x[axis]).0, farthest(&|x| x[axis]).0);
    let along = points[b] - points[a];
    let (c, from_line) = farthest(&|x| along.cross(&(x - points[a])).norm() / along.norm());
    if !(from_line > tolerance) {
        return Err(from_line.max(0.0));
    }
    let normal = along.cross(&(points[c] - points[a])).normalize();
    let (d, from_plane) = farthest(&|x| normal.dot(&(x - points[a])).abs());
    let ids = [a as u32, b as u32, c as u32, d as u32];
    match side(points, [ids[0], ids[1], ids[2]], ids[3]) {
        side if !(from_plane > tolerance) || side == 0.0 => Err(from_plane.max(0.0)),
        side if side > 0.0 => Ok([ids[0], ids[2], ids[1], ids[3]]),
        _ => Ok(ids),
    }
}

/// The triangles of the hull, or the thickness of a flat one.
fn triangles(points: &[Vector3<f64>], tolerance: f64) -> Result<Vec<Triangle>, f64> {
    let [a, b, c, d] = simplex(points, tolerance)?;
    let triangle = |corners, across| Triangle { corners, across, alive: true, above: Vec::new() };
    // d is below (a, b, c).
    let mut hull = vec![
        triangle([a, b, c], [1, 2, 3]),
        triangle([b, a, d], [0, 3, 2]),
        triangle([c, b, d], [0, 1, 3]),
        triangle([a, c, d], [0, 2, 1]),
    ];
    let assign = |hull: &mut [Triangle], among: std::ops::Range<usize>, x: u32| {
        let seen = among.into_iter().find(|&t| side(points, hull[t].corners, x) > 0.0);
        if let Some(t) = seen {
            hull[t].above.push(x);
        }
    };
    for x in 0..points.len() as u32 {
        assign(&mut hull, 0..4, x);
    }
    let (mut next, mut seen, mut border) = (0, Vec::new(), Vec::new());
    while next < hull.len() {
        if !hull[next].alive || hull[next].above.is_empty() {
            next += 1;
            continue;
        }
        let [p, q, r] = hull[next].corners.map(|v| points[v as usize]);
        let normal = (q - p).cross(&(r - p));
        let height = |x: u32| normal.dot(&(points[x as usize] - p));
        let apex = hull[next]
            .above
            .iter()
            .copied()
            .reduce(|best, x| if height(x) > height(best) { x } else { best });
        let Some(apex) = apex else { break };
        // The triangles the apex sees.
        seen.clear();
        border.clear();
        seen.push(next as u32);
        hull[next].alive = false;
        let mut at = 0;
        while at < seen.len() {
            let t = seen[at] as usize;
            at += 1;
            for k in 0..3 {
                let other = hull[t].across[k] as usize;
                if !hull[other].alive {
                    continue;
                }
                if side(points, hull[other].corners, apex) > 0.0 {
                    hull[other].alive = false;
                    seen.push(other as u32);
                }
            }
        }
        for &t in &seen {
            for k in 0..3 {
                let Triangle { corners, across, .. } = &hull[t as usize];
                if hull[across[k] as usize].alive {
                    border.push((corners[k], corners[(k + 1) % 3], across[k]));
                }
            }
        }
        let first = hull.len();
        for (i, &(from, to, outside)) in border.iter().enumerate() {
            let made = (first + i) as u32;
            // The new neighbours share `to` and `from` with this triangle.
            let after = border.iter().position(|side| side.0 == to).map_or(made, |i| (first + i) as u32);
            let before = border.iter().position(|side| side.1 == from).map_or(made, |i| (first + i) as u32);
            hull.push(triangle([from, to, apex], [outside, after, before]));
            let beyond = &mut hull[outside as usize];
            for k in 0..3 {
                if beyond.corners[k] == to && beyond.corners[(k + 1) % 3] == from {
                    beyond.across[k] = made;
                }
            }
        }
        for &t in &seen {
            for x in std::mem::take(&mut hull[t as usize].above) {
                if x != apex {
                    let made = first..hull.len();
                    assign(&mut hull, made, x);
                }
            }
        }
    }
    // Renumbered without the dead.
    let mut number = vec![0; hull.len()];
    let mut alive = 0;
    for (t, triangle) in hull.iter().enumerate() {
        number[t] = alive;
        alive += u32::from(triangle.alive);
    }
    let mut kept: Vec<_> = hull.into_iter().filter(|t| t.alive).collect();
    for triangle in &mut kept {
        triangle.across = triangle.across.map(|t| number[t as usize]);
    }
    Ok(kept)
}
