//! Convex hulls: quickhull with exact orientations (C. B. Barber, D. P. Dobkin, H. Huhdanpaa, 1996,
//! doi:10.1145/235815.235821).
//!
//! A point sees a triangle where it is strictly above its plane, decided exactly; so the triangles a point sees are connected,
//! their border is a ring none of whose edges is in line with the point, and the new triangles are never degenerate.

use nalgebra::Vector3;
use robust::{Coord3D, orient3d};

use super::feature::Meeting;
use super::merge;
use super::polyhedron::Polyhedron;
use super::real::max;
use crate::scalar::{Scalar, all_finite, epsilon, lit, to_f64};

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

/// A triangle of the hull under construction.
#[derive(Debug, Clone)]
pub(super) struct Triangle {
    /// Counterclockwise from outside.
    pub(super) corners: [u32; 3],
    /// The triangle across the side from each corner to the next.
    pub(super) across: [u32; 3],
    alive: bool,
    /// Points that see it and are not yet in the hull.
    above: Vec<u32>,
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

pub(super) fn build<T: Scalar>(points: &[Vector3<T>], tolerance: T) -> Result<Polyhedron<T>, HullError> {
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
