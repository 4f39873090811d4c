//! Separating axes of two convex polyhedra.
//!
//! The separation along the normal of a face is the least height of the other's vertices. Two edges give an axis where their
//! arcs on the Gauss map cross; an edge can do so for a better separation only where the other body reaches beyond it, which
//! is a bound that leaves few edges of each: along the arc from n₁ to n₂, n·(x − p) with p on the edge and any x of the other
//! body bounds the separation.

use nalgebra::{Matrix3, Vector3};

use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::real::{abs, infinity, min, sqrt};
use crate::scalar::{Scalar, lit};

/// Most vertices that are searched one by one for the farthest.
const FEW: usize = 24;

/// A polyhedron as the search sees it: in the frame of the first.
#[derive(Debug, Clone)]
pub(super) struct Placed<T: Scalar> {
    pub(super) vertices: Vec<Vector3<T>>,
    pub(super) normals: Vec<Vector3<T>>,
    pub(super) offsets: Vec<T>,
    /// By face: the other body's vertex that is lowest over it, and its height.
    pub(super) lowest: Vec<(u32, T)>,
    /// Edges that may be better than the faces.
    edges: Vec<u32>,
    /// Centre and half axes of a box.
    cuboid: Option<(Vector3<T>, Matrix3<T>)>,
}

impl<T: Scalar> Placed<T> {
    pub(super) fn new() -> Self {
        Self {
            vertices: vec![],
            normals: vec![],
            offsets: vec![],
            lowest: vec![],
            edges: vec![],
            cuboid: None,
        }
    }

    /// As it is.
    pub(super) fn set(&mut self, hull: &Polyhedron<T>) {
        self.vertices.clear();
        self.normals.clear();
        self.offsets.clear();
        self.vertices.extend_from_slice(&hull.vertices);
        self.normals.extend_from_slice(&hull.normals);
        self.offsets.extend_from_slice(&hull.offsets);
        self.cuboid = hull.half.map(|half| (Vector3::zeros(), Matrix3::from_diagonal(&half)));
    }

    /// Turned by `rotation` and moved by `shift`.
    pub(super) fn set_at(&mut self, hull: &Polyhedron<T>, rotation: &Matrix3<T>, shift: &Vector3<T>) {
        self.vertices.clear();
        self.normals.clear();
        self.offsets.clear();
        self.vertices.extend(hull.vertices.iter().map(|x| rotation * x + shift));
        self.normals.extend(hull.normals.iter().map(|n| rotation * n));
        self.offsets.extend(self.normals.iter().zip(&hull.offsets).map(|(n, &d)| d + n.dot(shift)));
        let axes = |half: Vector3<T>| {
            Matrix3::from_columns(&[
                rotation.column(0) * half.x,
                rotation.column(1) * half.y,
                rotation.column(2) * half.z,
            ])
        };
        self.cuboid = hull.half.map(|half| (*shift, axes(half)));
    }

    /// The face of largest separation from `other`, a later one only by more than `tolerance`; `None` where it exceeds `reach`.
    pub(super) fn best_face(
        &mut self,
        (hull, other): (&Polyhedron<T>, &Self),
        tolerance: T,
        reach: T,
    ) -> Option<(usize, T)> {
        self.lowest.clear();
        let (mut best, mut start) = ((0, -infinity::<T>()), 0);
        for (face, (normal, &offset)) in self.normals.iter().zip(&self.offsets).enumerate() {
            let (vertex, height) = match &other.cuboid {
                Some((centre, axes)) => lowest_of_box(centre, axes, normal),
                None if other.vertices.len() <= FEW => lowest_of_few(&other.vertices, normal),
                None => lowest(hull, &other.vertices, normal, start),
            };
            start = vertex;
            let separation = height - offset;
            if separation > reach {
                return None;
            }
            self.lowest.push((vertex, separation));
            if separation > best.1 + tolerance {
                best = (face, separation);
            }
        }
        Some(best)
    }

    /// Keeps the edges along whose arc the separation from `other` may exceed `least`.
    fn keep_edges(&mut self, hull: &Polyhedron<T>, other: &[Vector3<T>], least: T) {
        self.edges.clear();
        for (number, edge) in hull.edges.iter().enumerate() {
            let [f, g] = edge.faces.map(|face| face as usize);
            let ((x, from_f), (y, from_g)) = (self.lowest[f], self.lowest[g]);
            let height = |face: usize, vertex: u32| {
                self.normals[face].dot(&other[vertex as usize]) - self.offsets[face]
            };
            if arc_exceeds(from_f, height(g, x), edge.cosine, least)
                && arc_exceeds(height(f, y), from_g, edge.cosine, least)
            {
                self.edges.push(number as u32);
            }
        }
    }
}

/// Whether the largest n·d over the unit vectors n between n₁ and n₂ exceeds `least`, given n₁·d, n₂·d and n₁·n₂.
#[inline]
fn arc_exceeds<T: Scalar>(u: T, w: T, cosine: T, least: T) -> bool {
    if u > least || w > least {
        return true;
    }
    // Between the ends it is larger only where it falls towards neither; it is |d| in their plane there, and so positive.
    if w <= cosine * u || u <= cosine * w {
        return false;
    }
    let square = (u * u + w * w - (u + u) * w * cosine) / (T::one() - cosine * cosine);
    least < T::zero() || square > least * least
}

/// The vertex of least n·x of a box, and that value.
#[inline]
fn lowest_of_box<T: Scalar>(centre: &Vector3<T>, axes: &Matrix3<T>, normal: &Vector3<T>) -> (u32, T) {
    let (mut vertex, mut height) = (0, normal.dot(centre));
    for k in 0..3 {
        let along = normal.dot(&axes.column(k));
        height -= abs(along);
        vertex |= u32::from(along < T::zero()) << k;
    }
    (vertex, height)
}

/// The vertex of least n·x, the first of equals, and that value.
#[inline]
fn lowest_of_few<T: Scalar>(at: &[Vector3<T>], normal: &Vector3<T>) -> (u32, T) {
    let mut best = (0, infinity::<T>());
    for (i, x) in (0..).zip(at) {
        let height = normal.dot(x);
        if height < best.1 {
            best = (i, height);
        }
    }
    best
}

/// The same, downhill along edges: heights over a convex polyhedron have one valley.
fn lowest<T: Scalar>(hull: &Polyhedron<T>, at: &[Vector3<T>], normal: &Vector3<T>, start: u32) -> (u32, T) {
    let mut best = (start, normal.dot(&at[start as usize]));
    loop {
        let before = best.0;
        for &next in hull.neighbours(before as usize) {
            let height = normal.dot(&at[next as usize]);
            if height < best.1 {
                best = (next, height);
            }
        }
        if best.0 == before {
            return best;
        }
    }
}

/// The pair of edges of largest separation, that separation and the axis from the first body to the second.
pub(super) type EdgePair<T> = ((u32, u32), T, Vector3<T>);

/// The pair of edges that separates by more than `least`, the best one.
pub(super) fn best_edges<T: Scalar>(
    (a, pa): (&Polyhedron<T>, &mut Placed<T>),
    (b, pb): (&Polyhedron<T>, &mut Placed<T>),
    least: T,
) -> Option<EdgePair<T>> {
    pa.keep_edges(a, &pb.vertices, least);
    if pa.edges.is_empty() {
        return None;
    }
    pb.keep_edges(b, &pa.vertices, least);
    let mut best = None::<EdgePair<T>>;
    for &i in &pa.edges {
        let edge = &a.edges[i as usize];
        let [p, p_end] = edge.vertices.map(|v| pa.vertices[v as usize]);
        let [n, m] = edge.faces.map(|f| pa.normals[f as usize]);
        let (along, normals) = (p_end - p, n.cross(&m));
        for &j in &pb.edges {
            let other = &b.edges[j as usize];
            // The arcs cross, B's mirrored.
            let [s, t] = other.faces.map(|f| -pb.normals[f as usize]);
            let (cba, dba) = (s.dot(&normals), t.dot(&normals));
            if !(cba * dba < T::zero()) {
                continue;
            }
            let crossed = s.cross(&t);
            let (adc, bdc) = (-n.dot(&crossed), -m.dot(&crossed));
            if !(adc * bdc < T::zero() && cba * bdc < T::zero()) {
                continue;
            }
            let [q, q_end] = other.vertices.map(|v| pb.vertices[v as usize]);
            let axis = along.cross(&(q_end - q));
            let square = axis.dot(&axis);
            let scale = along.dot(&along) * (q_end - q).dot(&(q_end - q));
            if !(square > lit::<T>(1e-10) * scale) {
                continue;
            }
            let axis = axis / sqrt(square);
            let axis = if axis.dot(&(n + m)) < T::zero() { -axis } else { axis };
            let separation = axis.dot(&(q - p));
            if separation > best.map_or(least, |(_, largest, _)| largest) {
                best = Some(((i, j), separation, axis));
            }
        }
    }
    best
}

/// The face around vertex `vertex` of `hull` that looks most against `normal`, and the cosine.
pub(super) fn opposed<T: Scalar>(
    hull: &Polyhedron<T>,
    normals: &[Vector3<T>],
    vertex: u32,
    normal: &Vector3<T>,
) -> (usize, T) {
    let mut best = (0, infinity::<T>());
    for &face in hull.faces_around(vertex as usize) {
        let cosine = normal.dot(&normals[face as usize]);
        if cosine < best.1 {
            best = (face as usize, cosine);
        }
    }
    (best.0, min(best.1, T::one()))
}
