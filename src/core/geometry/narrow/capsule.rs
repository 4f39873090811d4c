//! Balls and capsules: with each other, and with polyhedra.

use nalgebra::Vector3;

use super::NarrowPhase;
use super::nearest::{segments, to_polyhedron};
use super::outline::{Corner, Ring, corners, tangents};
use super::polyhedra::{COSINE, LEANING, SINE, Tolerances};
use super::resolve::{Pair, nearest_on_lines};
use crate::geometry::feature::{Carrier, Contact, Feature, Meeting};
use crate::geometry::polyhedron::{Edge, Polyhedron};
use crate::geometry::real::{abs, infinity, min, sqrt};
use crate::scalar::{Scalar, lit};

fn line(first: Feature, second: Feature) -> Meeting {
    Meeting { first, second, carrier: Carrier::Line }
}

/// The centre of the ball b and polyhedron a.
pub(super) fn ball_and_polyhedron<T: Scalar>(
    pair: &Pair<'_, T>,
    hull: &Polyhedron<T>,
    reach: T,
    out: &mut Vec<Contact<T>>,
) {
    let tolerances = Tolerances::of(hull.radius(), pair.b.skin());
    let centre = pair.at.turn_back(&pair.between);
    pair.push(end_meeting(to_polyhedron(hull, &centre, tolerances.length).0, 0), reach, out);
}

/// A feature of the first shape met by end `vertex` of the second.
fn end_meeting(first: Feature, vertex: u32) -> Meeting {
    let carrier = if let Feature::Face(face) = first { Carrier::First(face) } else { Carrier::Line };
    Meeting { first, second: Feature::Vertex(vertex), carrier }
}

/// Two shapes that are points or segments with a skin: each end against the other's axis, and the axes where they cross.
pub(super) fn capsules<T: Scalar>(pair: &Pair<'_, T>, reach: T, out: &mut Vec<Contact<T>>) {
    let ends = |shape: &crate::geometry::Shape<T>, turn: &crate::geometry::Pose<T>, shift: Vector3<T>| {
        let first = shape.vertex(0).map(|x| turn.turn(&x) + shift);
        let last = shape.vertex(1).map(|x| turn.turn(&x) + shift);
        let first = first.unwrap_or(shift);
        [first, last.unwrap_or(first)]
    };
    let (a, b) = (ends(pair.a, pair.at, Vector3::zeros()), ends(pair.b, pair.bt, pair.between));
    let count = |shape: &crate::geometry::Shape<T>| if shape.vertex(1).is_some() { 2 } else { 1 };
    let (of_a, of_b) = (count(pair.a), count(pair.b));
    let length = Tolerances::of(pair.a.skin(), pair.b.skin()).length;
    // What of a segment is next to a point.
    let next_to = |[from, to]: [Vector3<T>; 2], ends: u32, x: &Vector3<T>| {
        if ends < 2 {
            return Feature::Vertex(0);
        }
        let along = to - from;
        let whole = along.norm();
        let at = along.dot(&(x - from)) / whole;
        if at <= length {
            Feature::Vertex(0)
        } else if at >= whole - length {
            Feature::Vertex(1)
        } else {
            Feature::Edge(0)
        }
    };
    for i in 0..of_a {
        let found = next_to(b, of_b, &a[i as usize]);
        // Two ends meet where each is next to the other.
        if let Feature::Vertex(j) = found
            && next_to(a, of_a, &b[j as usize]) != Feature::Vertex(i)
        {
            continue;
        }
        pair.push(line(Feature::Vertex(i), found), reach, out);
    }
    for j in 0..of_b {
        if next_to(a, of_a, &b[j as usize]) == Feature::Edge(0) {
            pair.push(line(Feature::Edge(0), Feature::Vertex(j)), reach, out);
        }
    }
    if of_a + of_b == 4
        && let (u, v) = (a[1] - a[0], b[1] - b[0])
        && u.cross(&v).norm_squared() > lit::<T>(1e-12) * u.norm_squared() * v.norm_squared()
        && let Some([s, t]) = nearest_on_lines(u, v, b[0] - a[0])
        && between_ends(s, u.norm(), length)
        && between_ends(t, v.norm(), length)
    {
        pair.push(line(Feature::Edge(0), Feature::Edge(0)), reach, out);
    }
}

fn between_ends<T: Scalar>(share: T, length: T, tolerance: T) -> bool {
    share * length > tolerance && (T::one() - share) * length > tolerance
}

impl<T: Scalar> NarrowPhase<T> {
    /// Polyhedron a and capsule b.
    pub(super) fn polyhedron_and_capsule(
        &mut self,
        pair: &Pair<'_, T>,
        hull: &Polyhedron<T>,
        reach: T,
        out: &mut Vec<Contact<T>>,
    ) {
        let tolerances = Tolerances::of(hull.radius(), pair.b.size());
        let end = |i| pair.b.vertex(i).unwrap_or_else(Vector3::zeros);
        let ends = [0, 1].map(|i| pair.at.turn_back(&(pair.between + pair.bt.turn(&end(i)))));
        let mut best = (0, -infinity::<T>());
        for (f, (normal, &offset)) in hull.normals.iter().zip(&hull.offsets).enumerate() {
            let separation = min(normal.dot(&ends[0]), normal.dot(&ends[1])) - offset;
            if separation > best.1 + tolerances.tie {
                best = (f, separation);
            }
        }
        let (face, separation) = best;
        if separation - pair.b.skin() > reach {
            return;
        }
        let found =
            if separation > T::zero() { None } else { best_edge(hull, &ends, separation + tolerances.edge) };
        let start = out.len();
        if let Some((edge, from_edge, axis)) = found
            && !(from_edge > T::zero())
        {
            // The axis is inside, and the shortest way out is along an edge, or next to along one.
            if !(axis.dot(&hull.normals[face]) < lit(COSINE)) {
                self.capsule_on_face(pair, (hull, face), &ends, tolerances.length, reach, out);
            }
            let second = Feature::Edge(0);
            let crossing = Meeting { first: Feature::Edge(edge), second, carrier: Carrier::Edges };
            if !out[start..].iter().any(|known| known.meeting.id() == crossing.id()) {
                pair.push(crossing, reach, out);
            }
            return;
        }
        self.capsule_on_face(pair, (hull, face), &ends, tolerances.length, reach, out);
        if found.is_none() && !(separation > T::zero()) {
            let height = |end: &Vector3<T>| hull.normals[face].dot(end);
            let lower = u32::from(height(&ends[1]) < height(&ends[0]));
            if out.len() == start && !hull.is_over(face, &ends[lower as usize], tolerances.length) {
                pair.push(end_meeting(Feature::Face(face as u32), lower), reach, out);
            }
            return;
        }
        // Outside, over that face where a point of the axis there is as near as its plane.
        let near = separation - pair.b.skin() + tolerances.edge;
        if !(separation > T::zero() && out[start..].iter().any(|contact| contact.gap <= near)) {
            out.truncate(start);
            outside(pair, hull, &ends, &tolerances, reach, out);
        }
    }

    /// The part of the axis over a face: its ends there, and where it crosses the sides.
    fn capsule_on_face(
        &mut self,
        pair: &Pair<'_, T>,
        (hull, face): (&Polyhedron<T>, usize),
        ends: &[Vector3<T>; 2],
        tolerance: T,
        reach: T,
        out: &mut Vec<Contact<T>>,
    ) {
        let [u, v] = tangents(&hull.normals[face]);
        let flat = |x: &Vector3<T>| [u.dot(x), v.dot(x)];
        let along = ends[1] - ends[0];
        let [outline, axis] = &mut self.outlines;
        outline.set(Ring::of(hull, face), false, |i| flat(&hull.vertices[i as usize]));
        let ring = Ring { vertices: &[0, 1], edges: &[0], inverse_lengths: &[T::one() / along.norm()] };
        axis.set(ring, false, |i| flat(&ends[i as usize]));
        let on_face = Carrier::First(face as u32);
        corners(outline, axis, tolerance, &mut self.distances, |corner| match corner {
            Corner::Second(end) => pair.push(end_meeting(Feature::Face(face as u32), end), reach, out),
            Corner::Crossing(edge, _) => {
                let [from, to] = hull.edges[edge as usize].vertices.map(|v| hull.vertices[v as usize]);
                let side = to - from;
                let cross = side.cross(&along);
                let size = sqrt(cross.norm_squared());
                let parallel = size <= lit::<T>(SINE) * side.norm() * along.norm();
                // Along a normal that leans far from that of the face the axis may be beside the edge, and far above the face.
                let leans = !(abs(cross.dot(&hull.normals[face])) > lit::<T>(LEANING) * size);
                let carrier = if parallel || leans { on_face } else { Carrier::Edges };
                let meeting = Meeting { first: Feature::Edge(edge), second: Feature::Edge(0), carrier };
                pair.push(meeting, reach, out);
            }
            Corner::First(_) => {}
        });
    }
}

/// The edge whose axis with that of a capsule separates by more than `least`, the best one.
fn best_edge<T: Scalar>(
    hull: &Polyhedron<T>,
    ends: &[Vector3<T>; 2],
    least: T,
) -> Option<(u32, T, Vector3<T>)> {
    let along = ends[1] - ends[0];
    let mut best = None::<(u32, T, Vector3<T>)>;
    for (i, edge) in hull.edges.iter().enumerate() {
        let [n, m] = edge.faces.map(|f| hull.normals[f as usize]);
        let (u, v) = (n.dot(&along), m.dot(&along));
        // The arc between the faces crosses the plane normal to the axis.
        if !(u * v < T::zero()) {
            continue;
        }
        let axis = n * abs(v) + m * abs(u);
        let axis = axis / axis.norm();
        let separation = axis.dot(&(ends[0] - hull.vertices[edge.vertices[0] as usize]));
        if separation > best.map_or(least, |(_, largest, _)| largest) {
            best = Some((i as u32, separation, axis));
        }
    }
    best
}

/// The contacts of a capsule's axis outside of `hull`: of its ends, and of what between them is nearest.
fn outside<T: Scalar>(
    pair: &Pair<'_, T>,
    hull: &Polyhedron<T>,
    ends: &[Vector3<T>; 2],
    tolerances: &Tolerances<T>,
    reach: T,
    out: &mut Vec<Contact<T>>,
) {
    let near = ends.map(|end| to_polyhedron(hull, &end, tolerances.length).0);
    let length = (ends[1] - ends[0]).norm();
    let inner = |(i, edge): (usize, &Edge<T>)| {
        let corners = edge.vertices.map(|v| hull.vertices[v as usize]);
        let ([s, t], distance) = segments(corners, *ends);
        if !between_ends(t, length, tolerances.length) {
            return None;
        }
        let size = (corners[1] - corners[0]).norm();
        Some(if between_ends(s, size, tolerances.length) {
            let first = Feature::Edge(i as u32);
            (distance, Meeting { first, second: Feature::Edge(0), carrier: Carrier::Edges })
        } else {
            let vertex = edge.vertices[usize::from(s > lit(0.5))];
            (distance, line(Feature::Vertex(vertex), Feature::Edge(0)))
        })
    };
    let distances = hull.edges.iter().enumerate().filter_map(inner).map(|(distance, _)| distance);
    let between = distances.fold(infinity(), min);
    for (end, feature) in (0..).zip(near) {
        pair.push(end_meeting(feature, end), reach, out);
    }
    // Several where the axis is parallel to an edge; a vertex belongs to several edges.
    let start = out.len();
    for (distance, meeting) in hull.edges.iter().enumerate().filter_map(inner) {
        let known = |found: &Contact<T>| found.meeting.id() == meeting.id();
        if distance <= between + tolerances.edge && !out[start..].iter().any(known) {
            pair.push(meeting, reach, out);
        }
    }
}
