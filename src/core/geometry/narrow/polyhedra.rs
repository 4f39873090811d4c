//! Two convex polyhedra.

use nalgebra::Vector3;

use super::NarrowPhase;
use super::nearest::segments;
use super::outline::{Corner, Ring, corners, tangents};
use super::resolve::Pair;
use super::separate::{Placed, best_edges, opposed};
use crate::geometry::feature::{Carrier, Contact, Feature, Meeting};
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::real::{max, min, sqrt};
use crate::scalar::{Scalar, epsilon, lit};

/// Cosine and sine of 6°: edges nearer to a face, or to parallel, leave the normal to the face.
pub(super) const COSINE: f64 = 0.994_521_895_368_273_3;
pub(super) const SINE: f64 = 0.104_528_463_267_653_47;

/// Cosine of 60°: what leans more from the normal of the face carries no normal of its own.
pub(super) const LEANING: f64 = 0.5;

/// Lengths that coincide, the advantage an edge needs over a face, and that of a face over another.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tolerances<T> {
    /// 1e-9 of the smaller shape, and 64 ε of the larger.
    pub(super) length: T,
    /// 1e-8 of the smaller shape, and 512 ε of the larger.
    pub(super) edge: T,
    /// 32 ε of the larger.
    pub(super) tie: T,
}

impl<T: Scalar> Tolerances<T> {
    pub(super) fn of(a: T, b: T) -> Self {
        let (small, large) = (min(a, b), max(a, b) * epsilon::<T>());
        Self {
            length: small * lit::<T>(1e-9) + large * lit::<T>(64.0),
            edge: small * lit::<T>(1e-8) + large * lit::<T>(512.0),
            tie: large * lit::<T>(32.0),
        }
    }
}

impl<T: Scalar> NarrowPhase<T> {
    /// Appends the contacts of polyhedra `a` and `b`, those of the shapes of `pair`.
    pub(super) fn polyhedra(
        &mut self,
        pair: &Pair<'_, T>,
        (a, b): (&Polyhedron<T>, &Polyhedron<T>),
        reach: T,
        out: &mut Vec<Contact<T>>,
    ) {
        let tolerances = Tolerances::of(a.radius(), b.radius());
        let rotation = pair.at.rotation().tr_mul(pair.bt.rotation());
        let shift = pair.at.turn_back(&pair.between);
        let [pa, pb] = &mut self.placed;
        pa.set(a);
        pb.set_at(b, &rotation, &shift);
        let Some((face_a, from_a)) = pa.best_face((b, &*pb), tolerances.tie, reach) else { return };
        let Some((face_b, from_b)) = pb.best_face((a, &*pa), tolerances.tie, reach) else { return };
        let by_b = from_b > from_a + tolerances.tie;
        let separation = if by_b { from_b } else { from_a };
        // Outwards from a.
        let normal = if by_b { -pb.normals[face_b] } else { pa.normals[face_a] };
        let pair_of_edges = best_edges((a, &mut *pa), (b, &mut *pb), separation + tolerances.edge);
        let crossing = |(i, j): (u32, u32), carrier| Meeting {
            first: Feature::Edge(i),
            second: Feature::Edge(j),
            carrier,
        };
        let mut emit = |meeting| pair.push(meeting, reach, out);
        let mut also = None;
        if let Some((edges, from_edges, axis)) = pair_of_edges {
            if from_edges > reach {
                return;
            }
            if axis.dot(&normal) < lit(COSINE) {
                emit(crossing(edges, Carrier::Edges));
                return;
            }
            also = Some(edges);
        }
        // The face of the other body that looks against it, among those at the vertex that is lowest over it.
        let (face_a, face_b, cosine, vertex) = if by_b {
            let vertex = pb.lowest[face_b].0;
            let (face, cosine) = opposed(a, &pa.normals, vertex, &-normal);
            (face, face_b, cosine, vertex)
        } else {
            let vertex = pa.lowest[face_a].0;
            let (face, cosine) = opposed(b, &pb.normals, vertex, &normal);
            (face_a, face, cosine, vertex)
        };
        let [u, v] = tangents(&normal);
        let flat = |x: &Vector3<T>| [u.dot(x), v.dot(x)];
        let [outline_a, outline_b] = &mut self.outlines;
        outline_a.set(Ring::of(a, face_a), false, |i| flat(&pa.vertices[i as usize]));
        outline_b.set(Ring::of(b, face_b), true, |i| flat(&pb.vertices[i as usize]));
        let (on_a, on_b) = (Carrier::First(face_a as u32), Carrier::Second(face_b as u32));
        let reference = if by_b { on_b } else { on_a };
        // A face that is steep to the normal carries no normal of its own.
        let steep = cosine > lit(-LEANING);
        let mut any = false;
        corners(outline_a, outline_b, tolerances.length, &mut self.distances, |corner| {
            let meeting = match corner {
                Corner::First(i) if by_b || !steep => {
                    Meeting { first: Feature::Vertex(i), second: Feature::Face(face_b as u32), carrier: on_b }
                }
                Corner::Second(j) if !by_b || !steep => {
                    Meeting { first: Feature::Face(face_a as u32), second: Feature::Vertex(j), carrier: on_a }
                }
                Corner::First(_) | Corner::Second(_) => return,
                Corner::Crossing(i, j) => {
                    if also == Some((i, j)) {
                        also = None;
                    }
                    crossing((i, j), crossing_carrier((a, i, pa), (b, j, pb), &normal, reference))
                }
            };
            any = true;
            emit(meeting);
        });
        if let Some(edges) = also {
            emit(crossing(edges, Carrier::Edges));
        } else if !any {
            emit(if separation > T::zero() {
                nearest_of_faces((a, face_a, &pa.vertices), (b, face_b, &pb.vertices), tolerances.length)
            } else if by_b {
                Meeting {
                    first: Feature::Vertex(vertex),
                    second: Feature::Face(face_b as u32),
                    carrier: on_b,
                }
            } else {
                Meeting {
                    first: Feature::Face(face_a as u32),
                    second: Feature::Vertex(vertex),
                    carrier: on_a,
                }
            });
        }
    }
}

/// What carries the normal of two edges that cross as seen along the `normal` of a face: the edges, unless they are nearly
/// parallel or their own normal leans far from that one.
fn crossing_carrier<T: Scalar>(
    (a, i, at): (&Polyhedron<T>, u32, &Placed<T>),
    (b, j, bt): (&Polyhedron<T>, u32, &Placed<T>),
    normal: &Vector3<T>,
    reference: Carrier,
) -> Carrier {
    let along = |hull: &Polyhedron<T>, i: u32, placed: &Placed<T>| {
        let edge = &hull.edges[i as usize];
        let [from, to] = edge.vertices.map(|v| placed.vertices[v as usize]);
        let [left, right] = edge.faces.map(|f| placed.normals[f as usize]);
        (to - from, left + right)
    };
    let ((u, out), (v, inward)) = (along(a, i, at), along(b, j, bt));
    let cross = u.cross(&v);
    let cross = if cross.dot(&(out - inward)) < T::zero() { -cross } else { cross };
    let square = cross.dot(&cross);
    let parallel = square <= lit::<T>(SINE * SINE) * u.dot(&u) * v.dot(&v);
    if parallel || !(cross.dot(normal) > lit::<T>(LEANING) * sqrt(square)) {
        reference
    } else {
        Carrier::Edges
    }
}

/// The nearest points of two faces whose outlines share nothing: corner to corner, corner to side or side to side.
fn nearest_of_faces<T: Scalar>(
    (a, face_a, at): (&Polyhedron<T>, usize, &[Vector3<T>]),
    (b, face_b, bt): (&Polyhedron<T>, usize, &[Vector3<T>]),
    tolerance: T,
) -> Meeting {
    let mut best = None::<(T, Meeting)>;
    for &i in a.sides(face_a) {
        let one = a.edges[i as usize].vertices;
        let first = one.map(|v| at[v as usize]);
        for &j in b.sides(face_b) {
            let two = b.edges[j as usize].vertices;
            let second = two.map(|v| bt[v as usize]);
            let ([s, t], distance) = segments(first, second);
            if best.is_none_or(|(least, _)| distance < least - tolerance) {
                let snap = |share: T, length: T, ends: [u32; 2], edge: u32| {
                    if share * length <= tolerance {
                        Feature::Vertex(ends[0])
                    } else if (T::one() - share) * length <= tolerance {
                        Feature::Vertex(ends[1])
                    } else {
                        Feature::Edge(edge)
                    }
                };
                let first = snap(s, (first[1] - first[0]).norm(), one, i);
                let second = snap(t, (second[1] - second[0]).norm(), two, j);
                let both = matches!((first, second), (Feature::Edge(_), Feature::Edge(_)));
                let carrier = if both { Carrier::Edges } else { Carrier::Line };
                best = Some((distance, Meeting { first, second, carrier }));
            }
        }
    }
    // A face has sides.
    best.map_or(
        Meeting { first: Feature::Vertex(0), second: Feature::Vertex(0), carrier: Carrier::Line },
        |(_, meeting)| meeting,
    )
}
