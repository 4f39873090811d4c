//! Terrain: surfaces of triangles, open or closed, that are solid on their inner side.

mod tree;

use std::collections::HashMap;

use nalgebra::Vector3;

use self::tree::Tree;
use super::bounds::Bounds;
use super::error::HullError;
use super::feature::Meeting;
use super::real::{abs, direction, max};
use super::surface::{Surface, SurfaceError};
use crate::scalar::{Scalar, all_finite, epsilon, lit, to_f64};

/// Absent neighbour.
const NONE: u32 = u32::MAX;

/// A side of triangles.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ridge<T: Scalar> {
    pub(super) ends: [u32; 2],
    /// Into the triangles on either side, in their planes and normal to the side; one on the border.
    pub(super) inwards: [Option<Vector3<T>>; 2],
    /// Sum of the normals of the triangles.
    pub(super) beside: Vector3<T>,
    /// Whether things can touch it: the surface bends away from there, or ends.
    pub(super) is_sharp: bool,
}

/// A surface of triangles that stands still, solid below: what its normals, right-handed around the corners, point to is
/// free.
///
/// Triangles that share a side and lie in one plane within [`TOLERANCE`](Self::TOLERANCE) of the extent are one patch with the
/// plane of its first triangle: things that slide or roll over the sides within a patch meet that one plane, and nothing else.
/// Sides between patches are met where the surface bends away there or ends, corners where three patches meet or its border
/// turns. A shape touches the surface while no more than half of it is below.
#[derive(Debug, Clone, PartialEq)]
pub struct Terrain<T: Scalar> {
    pub(super) points: Vec<Vector3<T>>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Patch of each triangle.
    pub(super) patch: Vec<u32>,
    /// Normal and offset of each patch.
    pub(super) planes: Vec<(Vector3<T>, T)>,
    /// Outward normals of the sides of each triangle in the plane of its patch, and their offsets.
    borders: Vec<[(Vector3<T>, T); 3]>,
    /// Sides of each triangle, from its corner of the same number.
    pub(super) sides: Vec<[u32; 3]>,
    pub(super) ridges: Vec<Ridge<T>>,
    /// Neighbours of the corners that things can touch; empty for all others.
    pub(super) around: Vec<Vec<u32>>,
    /// Sum of the normals around each corner.
    pub(super) outward: Vec<Vector3<T>>,
    tree: Tree<T>,
    bounds: Bounds<T>,
    /// Lengths below this are rounding (m).
    pub(super) tolerance: T,
}

impl<T: Scalar> Terrain<T> {
    /// Planes that differ by less are one, in the extent; 64 ε of the arithmetic where that is more.
    pub const TOLERANCE: f64 = 1e-9;

    /// A height field: `rows` of heights (m) over points `cell` (m) apart along x in a row, and along y from row to row; the
    /// first stands at `origin` (x, y). Every cell is two triangles.
    ///
    /// # Errors
    /// [`SurfaceError::Heights`] where rows differ in length, or there are fewer than two by two heights or cells without
    /// extent, and those of [`new`](Self::new).
    pub fn heights(rows: &[Vec<T>], cell: [T; 2], origin: [T; 2]) -> Result<Self, SurfaceError> {
        let across = rows.first().map_or(0, Vec::len);
        let wrong = |message: String| Err(SurfaceError::Heights { message });
        if rows.len() < 2 || across < 2 {
            return wrong(format!("{} rows of {across} heights: there must be 2 by 2 at least", rows.len()));
        }
        if let Some(row) = rows.iter().position(|row| row.len() != across) {
            return wrong(format!("row {} has {} heights, the first has {across}", row + 1, rows[row].len()));
        }
        if let Some(&size) = cell.iter().find(|&&size| !(size > T::zero() && all_finite(&[size]))) {
            return wrong(format!("a cell is {:e} m wide, it must be positive and finite", to_f64(size)));
        }
        let at = |i: usize, step: T, from: T| from + crate::scalar::from_usize::<T>(i) * step;
        let points = rows.iter().enumerate().flat_map(|(j, row)| {
            let place = move |(i, &z): (usize, &T)| {
                Vector3::new(at(i, cell[0], origin[0]), at(j, cell[1], origin[1]), z)
            };
            row.iter().enumerate().map(place)
        });
        let points = points.collect();
        let number = |i: usize, j: usize| (j * across + i) as u32;
        let cells = (0..rows.len() - 1).flat_map(|j| (0..across - 1).map(move |i| (i, j)));
        let faces = cells.flat_map(|(i, j)| {
            let [a, b] = [number(i, j), number(i + 1, j)];
            let [c, d] = [number(i + 1, j + 1), number(i, j + 1)];
            [vec![a, b, c], vec![a, c, d]]
        });
        let faces = faces.collect();
        Self::new(&Surface { points, faces })
    }

    /// The terrain of a surface, whose faces are split into triangles around their first corners.
    ///
    /// # Errors
    /// [`SurfaceError::Empty`], [`SurfaceError::Hull`] for what is not finite or too many, [`SurfaceError::Sliver`] for a
    /// triangle without area, and [`SurfaceError::Inconsistent`] for two triangles that run along a side in the same
    /// direction.
    pub fn new(surface: &Surface<T>) -> Result<Self, SurfaceError> {
        let points = surface.points().to_vec();
        if let Some(point) = points.iter().position(|x| !all_finite(x.iter())) {
            return Err(HullError::NotFinite { point }.into());
        }
        if points.len() > Meeting::MOST_FEATURES / 8 || surface.faces().len() > Meeting::MOST_FEATURES / 8 {
            return Err(HullError::TooMany { points: points.len().max(surface.faces().len()) }.into());
        }
        let fan = |face: &Vec<u32>| -> Vec<[u32; 3]> {
            (1..face.len().saturating_sub(1)).map(|k| [face[0], face[k], face[k + 1]]).collect()
        };
        let triangles: Vec<[u32; 3]> = surface.faces().iter().flat_map(fan).collect();
        let Some(&first) = points.first().filter(|_| !triangles.is_empty()) else {
            return Err(SurfaceError::Empty);
        };
        let mut box_of = Bounds { low: first, high: first };
        for x in &points {
            box_of = Bounds { low: box_of.low.inf(x), high: box_of.high.sup(x) };
        }
        let share = max(lit::<T>(Self::TOLERANCE), lit::<T>(64.0) * epsilon::<T>());
        let tolerance = (box_of.high - box_of.low).norm() * share;
        let corners = |t: usize| triangles[t].map(|v| points[v as usize]);
        let mut normals = Vec::with_capacity(triangles.len());
        for t in 0..triangles.len() {
            let [a, b, c] = corners(t);
            let area = (b - a).cross(&(c - a));
            let longest = max(max((b - a).norm(), (c - b).norm()), (a - c).norm());
            let height = area.norm() / longest;
            match direction(&area).filter(|_| height > tolerance) {
                Some(normal) => normals.push(normal),
                None => return Err(SurfaceError::Sliver { face: t, height: to_f64(height) }),
            }
        }
        let (sides, mut ridges, across) = join(&triangles, &points)?;
        let (patch, planes) = patches(&triangles, &points, &normals, &across, tolerance);
        let mut borders = Vec::with_capacity(triangles.len());
        for (t, &normal) in normals.iter().enumerate() {
            let x = corners(t);
            borders.push([0, 1, 2].map(|k| {
                let along = x[(k + 1) % 3] - x[k];
                let out = direction(&along.cross(&normal)).unwrap_or_else(Vector3::zeros);
                let ridge = &mut ridges[sides[t][k] as usize];
                let side = usize::from(ridge.inwards[0].is_some());
                ridge.inwards[side] = Some(-out);
                ridge.beside += normal;
                (out, out.dot(&x[k]))
            }));
        }
        for t in 0..triangles.len() {
            for k in 0..3 {
                let other = across[t][k];
                let ridge = &mut ridges[sides[t][k] as usize];
                // A side bends away where the far corner of the next triangle is below this one.
                ridge.is_sharp = other == NONE
                    || (patch[t] != patch[other as usize] && {
                        let far = triangles[other as usize].iter().find(|v| !triangles[t].contains(v));
                        let height = |&v: &u32| {
                            normals[t].dot(&(points[v as usize] - points[triangles[t][0] as usize]))
                        };
                        far.is_none_or(|v| height(v) < T::zero())
                    });
            }
        }
        let mut outward = vec![Vector3::zeros(); points.len()];
        let mut of_corner: Vec<Vec<u32>> = vec![Vec::new(); points.len()];
        for (t, triangle) in triangles.iter().enumerate() {
            for &v in triangle {
                outward[v as usize] += normals[t];
                if !of_corner[v as usize].contains(&patch[t]) {
                    of_corner[v as usize].push(patch[t]);
                }
            }
        }
        let mut around: Vec<Vec<u32>> = vec![Vec::new(); points.len()];
        let mut border: Vec<Vec<u32>> = vec![Vec::new(); points.len()];
        for ridge in &ridges {
            let [a, b] = ridge.ends;
            around[a as usize].push(b);
            around[b as usize].push(a);
            if ridge.inwards[1].is_none() {
                border[a as usize].push(b);
                border[b as usize].push(a);
            }
        }
        for (v, around) in around.iter_mut().enumerate() {
            let is_straight = match border[v][..] {
                [] => of_corner[v].len() < 3,
                [a, b] => {
                    let [a, b] = [a, b].map(|end| points[end as usize] - points[v]);
                    of_corner[v].len() < 2 && a.cross(&b).norm() <= tolerance * (a - b).norm()
                }
                _ => false,
            };
            if is_straight {
                around.clear();
            }
        }
        let boxes: Vec<Bounds<T>> = (0..triangles.len())
            .map(|t| {
                let [a, b, c] = corners(t);
                Bounds { low: a.inf(&b).inf(&c), high: a.sup(&b).sup(&c) }
            })
            .collect();
        let tree = Tree::new(&boxes);
        Ok(Self {
            points,
            triangles,
            patch,
            planes,
            borders,
            sides,
            ridges,
            around,
            outward,
            tree,
            bounds: box_of,
            tolerance,
        })
    }

    /// Corners of the triangles (m).
    pub fn points(&self) -> &[Vector3<T>] {
        &self.points
    }

    /// Triangles: places of their corners among the points, counterclockwise from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Number of plane patches.
    pub fn patches(&self) -> usize {
        self.planes.len()
    }

    /// The box around it.
    pub fn bounds(&self) -> &Bounds<T> {
        &self.bounds
    }

    /// Appends the triangles whose boxes meet `within`, in the frame of the terrain.
    pub(super) fn near(&self, within: &Bounds<T>, stack: &mut Vec<u32>, out: &mut Vec<u32>) {
        self.tree.find(within, stack, out);
    }

    /// Height of `p` over the plane of triangle `t`, where it is above or below the triangle within the tolerance.
    pub(super) fn over(&self, t: usize, p: &Vector3<T>) -> Option<T> {
        let inside = self.borders[t].iter().all(|(out, offset)| out.dot(p) - *offset <= self.tolerance);
        let (normal, offset) = &self.planes[self.patch[t] as usize];
        inside.then(|| normal.dot(p) - *offset)
    }
}

/// By triangle its sides, the sides, and the triangles across.
type Joined<T> = (Vec<[u32; 3]>, Vec<Ridge<T>>, Vec<[u32; 3]>);

/// Finds out which triangles share a side.
fn join<T: Scalar>(triangles: &[[u32; 3]], points: &[Vector3<T>]) -> Result<Joined<T>, SurfaceError> {
    let mut directed: HashMap<(u32, u32), (usize, usize)> = HashMap::new();
    let place = |v: u32| [0, 1, 2].map(|i| to_f64(points[v as usize][i]));
    for (second, triangle) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (from, to) = (triangle[k], triangle[(k + 1) % 3]);
            if let Some((first, _)) = directed.insert((from, to), (second, k)) {
                let (from, to) = (place(from), place(to));
                return Err(SurfaceError::Inconsistent { first, second, from, to });
            }
        }
    }
    let (mut sides, mut across) = (vec![[NONE; 3]; triangles.len()], vec![[NONE; 3]; triangles.len()]);
    let mut ridges = Vec::new();
    for (t, triangle) in triangles.iter().enumerate() {
        for k in 0..3 {
            if sides[t][k] != NONE {
                continue;
            }
            let ends = [triangle[k], triangle[(k + 1) % 3]];
            sides[t][k] = ridges.len() as u32;
            if let Some(&(other, j)) = directed.get(&(ends[1], ends[0])) {
                sides[other][j] = ridges.len() as u32;
                (across[t][k], across[other][j]) = (other as u32, t as u32);
            }
            ridges.push(Ridge { ends, inwards: [None, None], beside: Vector3::zeros(), is_sharp: false });
        }
    }
    Ok((sides, ridges, across))
}

/// The patch of each triangle, and the planes of the patches.
fn patches<T: Scalar>(
    triangles: &[[u32; 3]],
    points: &[Vector3<T>],
    normals: &[Vector3<T>],
    across: &[[u32; 3]],
    tolerance: T,
) -> (Vec<u32>, Vec<(Vector3<T>, T)>) {
    let (mut patch, mut planes, mut open) = (vec![NONE; triangles.len()], Vec::new(), Vec::new());
    for seed in 0..triangles.len() {
        if patch[seed] != NONE {
            continue;
        }
        let (normal, origin) = (normals[seed], points[triangles[seed][0] as usize]);
        let number = planes.len() as u32;
        planes.push((normal, normal.dot(&origin)));
        patch[seed] = number;
        open.push(seed);
        while let Some(t) = open.pop() {
            for other in across[t].into_iter().filter(|&other| other != NONE).map(|other| other as usize) {
                let flat = |&v: &u32| abs(normal.dot(&(points[v as usize] - origin))) <= tolerance;
                let facing = normal.dot(&normals[other]) > T::zero();
                if patch[other] == NONE && facing && triangles[other].iter().all(flat) {
                    patch[other] = number;
                    open.push(other);
                }
            }
        }
    }
    (patch, planes)
}
