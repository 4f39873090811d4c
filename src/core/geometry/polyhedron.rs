//! Convex polyhedra: vertices, plane faces and edges, and what they are adjacent to.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::error::HullError;
use super::real::{direction, max, sqrt};
use crate::scalar::{Scalar, lit};

/// An edge between two faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge<T: Scalar> {
    /// Its ends; the boundary of the first face runs from the first to the second, counterclockwise from outside.
    pub vertices: [u32; 2],
    /// The faces it lies between.
    pub faces: [u32; 2],
    /// Cosine of the angle between their normals.
    pub cosine: T,
}

/// A convex polyhedron (m).
///
/// Made by [`hull`](Self::hull) or [`cuboid`](Self::cuboid). Every vertex meets at least three faces, no two adjacent faces are
/// coplanar within the tolerance of the hull, and the vertices of a face are counterclockwise from outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Polyhedron<T: Scalar> {
    pub(super) vertices: Vec<Vector3<T>>,
    pub(super) normals: Vec<Vector3<T>>,
    pub(super) offsets: Vec<T>,
    /// Corners of face f are those from `starts[f]` to `starts[f + 1]`.
    starts: Vec<u32>,
    corners: Vec<u32>,
    /// The edge from each corner to the next.
    sides: Vec<u32>,
    /// By corner: outward normal of the side from there, in the plane of the face, and its largest offset over all corners.
    borders: Vec<(Vector3<T>, T)>,
    /// 1/length of the side from each corner.
    inverse_lengths: Vec<T>,
    pub(super) edges: Vec<Edge<T>>,
    /// Faces around vertex v are those from `around_starts[v]` to `around_starts[v + 1]`.
    around_starts: Vec<u32>,
    around: Vec<u32>,
    /// Neighbours of vertex v, in the same ranges: as many edges as faces meet there.
    neighbours: Vec<u32>,
    centre: Vector3<T>,
    radius: T,
    /// Half extents of a box along its frame.
    pub(super) half: Option<Vector3<T>>,
}

impl<T: Scalar> Polyhedron<T> {
    /// Tolerance of [`hull`](Self::hull) in the size of the points.
    pub const TOLERANCE: f64 = 1e-9;

    /// The box |x_i| ≤ `half`_i (m): vertex i has the sign of bit 0, 1, 2 of i in x, y, z.
    ///
    /// # Errors
    ///
    /// [`HullError::Flat`] for an extent that is not positive, [`HullError::NotFinite`].
    pub fn cuboid(half: Vector3<T>) -> Result<Self, HullError> {
        if !crate::scalar::all_finite(half.iter()) {
            return Err(HullError::NotFinite { point: 0 });
        }
        if !half.iter().all(|&x| x > T::zero()) {
            return Err(HullError::Flat { thickness: crate::scalar::to_f64(half.min() + half.min()) });
        }
        let sign = |i: usize, bit: usize| if i >> bit & 1 == 1 { half[bit] } else { -half[bit] };
        let vertices = (0..8).map(|i| Vector3::new(sign(i, 0), sign(i, 1), sign(i, 2))).collect();
        let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
            .map(Vec::from);
        let made = Self::from_faces(vertices, faces.to_vec()).ok_or(HullError::Flat { thickness: 0.0 })?;
        Ok(Self { half: Some(half), ..made })
    }

    /// Made of faces with their corners counterclockwise; `None` where they do not close.
    pub(super) fn from_faces(vertices: Vec<Vector3<T>>, faces: Vec<Vec<u32>>) -> Option<Self> {
        let (mut normals, mut offsets) = (Vec::new(), Vec::new());
        let (mut starts, mut corners, mut sides) = (vec![0], Vec::new(), Vec::new());
        let mut edges = Vec::<Edge<T>>::new();
        let mut by_ends = HashMap::new();
        for (f, face) in faces.iter().enumerate() {
            let first = vertices[*face.first()? as usize];
            // Twice the area vector.
            let area = face.windows(2).fold(Vector3::zeros(), |sum: Vector3<T>, pair| {
                sum + (vertices[pair[0] as usize] - first).cross(&(vertices[pair[1] as usize] - first))
            });
            let normal = direction(&area)?;
            normals.push(normal);
            let offset = face.iter().map(|&v| normal.dot(&vertices[v as usize])).reduce(max)?;
            offsets.push(offset);
            for (k, &from) in face.iter().enumerate() {
                let to = face[(k + 1) % face.len()];
                let edge = match by_ends.remove(&(to, from)) {
                    Some(edge) => {
                        edges.get_mut::<usize>(edge)?.faces[1] = f as u32;
                        edge
                    }
                    None => {
                        by_ends.insert((from, to), edges.len());
                        edges.push(Edge { vertices: [from, to], faces: [f as u32; 2], cosine: T::one() });
                        edges.len() - 1
                    }
                };
                corners.push(from);
                sides.push(edge as u32);
            }
            starts.push(corners.len() as u32);
        }
        let euler = vertices.len() + faces.len() == edges.len() + 2;
        if !by_ends.is_empty() || !euler || 2 * edges.len() != corners.len() {
            return None;
        }
        for edge in &mut edges {
            edge.cosine = normals[edge.faces[0] as usize].dot(&normals[edge.faces[1] as usize]);
        }
        let mut around = vec![Vec::new(); vertices.len()];
        for f in 0..faces.len() {
            for k in starts[f]..starts[f + 1] {
                around[corners[k as usize] as usize].push(f as u32);
            }
        }
        let mut neighbours = vec![Vec::new(); vertices.len()];
        for edge in &edges {
            let [from, to] = edge.vertices;
            neighbours[from as usize].push(to);
            neighbours[to as usize].push(from);
        }
        if around
            .iter()
            .zip(&neighbours)
            .any(|(faces, vertices)| faces.len() != vertices.len() || faces.len() < 3)
        {
            return None;
        }
        let borders = (0..faces.len()).flat_map(|f| {
            let (face, vertices, normal) = (&faces[f], &vertices, &normals[f]);
            (0..face.len()).map(move |k| {
                let along = vertices[face[(k + 1) % face.len()] as usize] - vertices[face[k] as usize];
                let out = direction(&along.cross(normal)).unwrap_or_else(Vector3::zeros);
                let offset = face.iter().map(|&v| out.dot(&vertices[v as usize])).reduce(max);
                (out, offset.unwrap_or_else(T::zero))
            })
        });
        let borders = borders.collect();
        let length = |side: &u32| {
            let [from, to] = edges[*side as usize].vertices.map(|v| vertices[v as usize]);
            T::one() / (to - from).norm()
        };
        let inverse_lengths = sides.iter().map(length).collect();
        let ends = around.iter().scan(0, |sum, faces| {
            *sum += faces.len() as u32;
            Some(*sum)
        });
        let around_starts = std::iter::once(0).chain(ends).collect();
        let half = lit::<T>(0.5);
        let mut low = *vertices.first()?;
        let mut high = low;
        for x in &vertices {
            (low, high) = (low.inf(x), high.sup(x));
        }
        let centre = (low + high) * half;
        let radius = vertices.iter().map(|x| (x - centre).norm_squared()).reduce(max)?;
        Some(Self {
            vertices,
            normals,
            offsets,
            starts,
            corners,
            sides,
            borders,
            inverse_lengths,
            edges,
            around_starts,
            around: around.concat(),
            neighbours: neighbours.concat(),
            centre,
            radius: sqrt(radius),
            half: None,
        })
    }

    /// Vertices (m).
    pub fn vertices(&self) -> &[Vector3<T>] {
        &self.vertices
    }

    /// Number of faces.
    pub fn faces(&self) -> usize {
        self.normals.len()
    }

    /// Edges.
    pub fn edges(&self) -> &[Edge<T>] {
        &self.edges
    }

    /// The plane n·x = d of face `face`: outward unit normal n and offset d (m), the largest over its vertices; `None` where
    /// there is no such face.
    pub fn plane(&self, face: usize) -> Option<(&Vector3<T>, T)> {
        Some((self.normals.get(face)?, *self.offsets.get(face)?))
    }

    /// Vertices of face `face`, counterclockwise from outside, any number of them; empty where there is no such face.
    pub fn corners(&self, face: usize) -> &[u32] {
        self.range(&self.starts, face).map_or(&[], |range| &self.corners[range])
    }

    /// Edges of face `face`, each from the corner of the same place to the next.
    pub fn sides(&self, face: usize) -> &[u32] {
        self.range(&self.starts, face).map_or(&[], |range| &self.sides[range])
    }

    /// 1/length of the sides of face `face` (1/m).
    pub(super) fn inverse_lengths(&self, face: usize) -> &[T] {
        self.range(&self.starts, face).map_or(&[], |range| &self.inverse_lengths[range])
    }

    /// Whether `p` is above face `face` as seen along its normal, within `tolerance` (m) of its border.
    #[inline]
    pub(super) fn is_over(&self, face: usize, p: &Vector3<T>, tolerance: T) -> bool {
        let borders = self.range(&self.starts, face).map_or(&[][..], |range| &self.borders[range]);
        borders.iter().all(|(out, offset)| out.dot(p) - *offset <= tolerance)
    }

    /// Faces that meet at vertex `vertex`.
    pub fn faces_around(&self, vertex: usize) -> &[u32] {
        self.range(&self.around_starts, vertex).map_or(&[], |range| &self.around[range])
    }

    /// Vertices that an edge joins to vertex `vertex`.
    pub fn neighbours(&self, vertex: usize) -> &[u32] {
        self.range(&self.around_starts, vertex).map_or(&[], |range| &self.neighbours[range])
    }

    fn range(&self, starts: &[u32], i: usize) -> Option<std::ops::Range<usize>> {
        Some(*starts.get(i)? as usize..*starts.get(i + 1)? as usize)
    }

    /// Centre of the smallest axis-parallel box around it (m).
    pub fn centre(&self) -> &Vector3<T> {
        &self.centre
    }

    /// Radius of the sphere around [`centre`](Self::centre) that holds it (m).
    pub fn radius(&self) -> T {
        self.radius
    }
}
