//! Where two convex outlines meet.
//!
//! A collision library would bring its own scalar, vectors and manifolds in a prediction distance; here a contact is
//! a smooth gap g(q) with its exact derivative H_N, generic over the scalar, named by the features that meet, and found
//! without allocating. In the plane that is little: a vertex against an edge is all there is.
//!
//! Two polygons meet along the axis of largest separation (separating axes over both sets of edges, which bound the
//! distance from below and are exact for overlap). The edge of that axis and the other polygon's edge most opposed to
//! it overlap along an interval; each of its two ends is a vertex of one polygon on the edge of the other, and these
//! are the contacts, each with the gap of that vertex from that edge.

use nalgebra::Vector2;

use super::identity::Features;
use super::shape::{Polygon, Pose};
use crate::scalar::{Scalar, epsilon, lit};

/// Lengths that coincide, relative to the size of the polygons: 4096 ε.
fn coincidence<T: Scalar>() -> T {
    lit::<T>(4096.0) * epsilon::<T>()
}

/// Edge of `a` from which all of `b` is furthest, with that separation; −∞ never appears as polygons have edges.
pub(super) fn largest_separation<T: Scalar>(
    (a, at): (&Polygon<T>, &Pose<T>),
    (b, bt): (&Polygon<T>, &Pose<T>),
) -> (usize, T) {
    let between = at.origin - bt.origin;
    let mut best = None::<(usize, T)>;
    for (edge, (start, normal)) in a.vertices.iter().zip(&a.normals).enumerate() {
        // n·(x − y) for the vertices x of b, summed in b's frame.
        let world = at.turn(normal);
        let local = bt.turn_back(&world);
        let nearest = b.vertices.iter().map(|x| local.dot(x));
        let nearest = nearest.reduce(|least, x| if x < least { x } else { least }).unwrap_or_else(T::zero);
        let separation = nearest - world.dot(&between) - normal.dot(start);
        if best.is_none_or(|(_, largest)| separation > largest) {
            best = Some((edge, separation));
        }
    }
    best.unwrap_or_else(|| (0, T::zero()))
}

/// Gap of vertex `vertex` of the first polygon from edge `edge` of the second.
#[inline]
pub(super) fn vertex_gap<T: Scalar>(
    vertex: usize,
    (a, at): (&Polygon<T>, &Pose<T>),
    edge: usize,
    (b, bt): (&Polygon<T>, &Pose<T>),
) -> T {
    let normal = bt.turn(&b.normals[edge]);
    // Differences of levers and of origins apart: nothing large is subtracted from something large.
    let lever = at.turn(&a.vertices[vertex]) - bt.turn(&b.vertices[edge]);
    normal.dot(&lever) + normal.dot(&(at.origin - bt.origin))
}

/// Calls `meet(features, gap)` for the one or two contacts of polygons `a` and `b` with a gap of at most `reach`;
/// `size` is a length of theirs.
pub(super) fn polygons<T: Scalar>(
    a: (&Polygon<T>, &Pose<T>),
    b: (&Polygon<T>, &Pose<T>),
    size: T,
    reach: T,
    mut meet: impl FnMut(Features, T),
) {
    let (edge_a, from_a) = largest_separation(a, b);
    if from_a > reach {
        return;
    }
    let (edge_b, from_b) = largest_separation(b, a);
    if from_b > reach {
        return;
    }
    let tolerance = coincidence::<T>() * size;
    // Faces that lie on each other separate equally along both normals: rounding must not choose.
    let swapped = from_b > from_a + tolerance;
    let (reference, other, edge) = if swapped { (b, a, edge_b) } else { (a, b, edge_a) };
    let normal = reference.1.turn(&reference.0.normals[edge]);
    let local = other.1.turn_back(&normal);
    let opposed = (0..other.0.normals.len()).map(|i| (i, local.dot(&other.0.normals[i])));
    let opposed = opposed.reduce(|best, next| if next.1 < best.1 { next } else { best });
    let incident = opposed.map_or(0, |(i, _)| i);

    // Ends of both edges along the tangent that runs with the reference edge.
    let tangent = Vector2::new(-normal.y, normal.x);
    let ends = |(polygon, pose): (&Polygon<T>, &Pose<T>), edge: usize| {
        let next = (edge + 1) % polygon.vertices.len();
        let along = |i: usize| {
            let lever = pose.turn(&polygon.vertices[i]);
            tangent.dot(&lever) + tangent.dot(&(pose.origin - reference.1.origin))
        };
        [(edge, along(edge)), (next, along(next))]
    };
    let [reference_low, reference_high] = ends(reference, edge);
    // The opposed edge runs the other way.
    let [other_high, other_low] = ends(other, incident);
    let mut emit = |own: bool, vertex: usize| {
        let (features, gap) = if own {
            let features = if swapped {
                Features::EdgeVertex(vertex, incident)
            } else {
                Features::VertexEdge(vertex, incident)
            };
            (features, vertex_gap(vertex, reference, incident, other))
        } else {
            let features =
                if swapped { Features::VertexEdge(vertex, edge) } else { Features::EdgeVertex(vertex, edge) };
            (features, vertex_gap(vertex, other, edge, reference))
        };
        if !(gap > reach) {
            meet(features, gap);
        }
    };
    // Where two vertices coincide, the other polygon's stands for both.
    let low =
        if reference_low.1 > other_low.1 + tolerance { (true, reference_low) } else { (false, other_low) };
    let high = if reference_high.1 < other_high.1 - tolerance {
        (true, reference_high)
    } else {
        (false, other_high)
    };
    let (from, to) = (low.1.1, high.1.1);
    if to - from > tolerance {
        emit(low.0, low.1.0);
        emit(high.0, high.1.0);
    } else {
        // Corner to corner: the vertex of the other polygon that is nearest.
        let nearest = if other_low.1 >= reference_high.1 - tolerance {
            other_low
        } else if other_high.1 <= reference_low.1 + tolerance {
            other_high
        } else {
            low.1
        };
        emit(low.0 && nearest == low.1, nearest.0);
    }
}

/// Where a disc at `centre` (fixed frame) meets a polygon: the features, the gap to the boundary less `radius`.
pub(super) fn disc<T: Scalar>(
    (polygon, pose): (&Polygon<T>, &Pose<T>),
    centre: &Vector2<T>,
    radius: T,
) -> (Features, T) {
    let local = pose.turn_back(&(centre - pose.origin));
    let mut best = (0, None::<T>);
    for (i, (vertex, normal)) in polygon.vertices.iter().zip(&polygon.normals).enumerate() {
        let height = normal.dot(&(local - vertex));
        if best.1.is_none_or(|largest| height > largest) {
            best = (i, Some(height));
        }
    }
    let (edge, height) = (best.0, best.1.unwrap_or_else(T::zero));
    if height > T::zero() {
        let next = (edge + 1) % polygon.vertices.len();
        let normal = polygon.normals[edge];
        let along = Vector2::new(-normal.y, normal.x);
        // Over a vertex to rounding is over the edge: a disc over a seam has a face under it.
        let rounding = coincidence::<T>() * polygon.vertices[edge].norm();
        for (vertex, beyond) in [
            (edge, along.dot(&(local - polygon.vertices[edge])) < -rounding),
            (next, along.dot(&(local - polygon.vertices[next])) > rounding),
        ] {
            if beyond {
                return (Features::VertexDisc(vertex), (local - polygon.vertices[vertex]).norm() - radius);
            }
        }
    }
    (Features::EdgeDisc(edge), height - radius)
}
