//! Surfaces from files: points and faces, checked before they become a hull or a terrain.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::error::HullError;
use super::polyhedron::Polyhedron;
use super::real::{infinity, max, min};
use crate::scalar::{Scalar, all_finite, lit, to_f64};

/// Why a file, or the surface in it, makes no convex polyhedron.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A line of a text that is not what its format has there.
    #[error("line {line}: {message}")]
    Text {
        /// Line, from 1.
        line: usize,
        /// What is wrong there.
        message: String,
    },
    /// A binary file that ends too early or too late for the number of triangles it announces.
    #[error("a binary STL of {triangles} triangles has {expected} bytes, this one has {bytes}")]
    Length {
        /// Triangles announced.
        triangles: usize,
        /// Bytes these take.
        expected: usize,
        /// Bytes there are.
        bytes: usize,
    },
    /// No face at all.
    #[error("the surface has no face")]
    Empty,
    /// A side that belongs to one face alone.
    #[error("the surface is open: no face continues face {face} across the side from {from:?} to {to:?}")]
    Open {
        /// Face, from 0.
        face: usize,
        /// Start of the side (m).
        from: [f64; 3],
        /// Its end (m).
        to: [f64; 3],
    },
    /// Two faces that run along a side in the same direction: one is inverted, or a third meets there.
    #[error(
        "faces {first} and {second} run along the side from {from:?} to {to:?} in the same direction: one is inverted"
    )]
    Inconsistent {
        /// Face, from 0.
        first: usize,
        /// The other face.
        second: usize,
        /// Start of the side (m).
        from: [f64; 3],
        /// Its end (m).
        to: [f64; 3],
    },
    /// A triangle without area, for its rounding.
    #[error("triangle {face} is {height:e} m high, which is nothing beside the surface")]
    Sliver {
        /// Triangle, from 0.
        face: usize,
        /// Its least height (m).
        height: f64,
    },
    /// Heights that are no field.
    #[error("heights: {message}")]
    Heights {
        /// What is wrong with them.
        message: String,
    },
    /// All faces look inwards.
    #[error("the surface is inverted: it encloses a volume of {volume:e} m³")]
    Inverted {
        /// The volume.
        volume: f64,
    },
    /// A dent.
    #[error("the surface is not convex: {point:?} lies {depth:e} m inside of its hull")]
    Dent {
        /// A point of the surface (m).
        point: [f64; 3],
        /// How far inside (m).
        depth: f64,
    },
    /// Faces that are not those of the hull.
    #[error("the surface is not convex: it encloses {volume:e} m³, its hull {hull:e} m³")]
    NotConvex {
        /// Volume of the surface (m³).
        volume: f64,
        /// Volume of the hull (m³).
        hull: f64,
    },
    /// No hull.
    #[error(transparent)]
    Hull(#[from] HullError),
}

/// Points, and faces as rings of them, counterclockwise from outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface<T: Scalar> {
    pub(super) points: Vec<Vector3<T>>,
    pub(super) faces: Vec<Vec<u32>>,
}

/// Joins points that are equal to the last digit.
#[derive(Debug, Default)]
pub(super) struct Points {
    by_digits: HashMap<[u64; 3], u32>,
}

impl Points {
    /// The place of `x` in `points`, at the end if it is new.
    pub(super) fn place<T: Scalar>(&mut self, points: &mut Vec<Vector3<T>>, x: [f64; 3]) -> u32 {
        // −0 is 0.
        let digits = x.map(|c| (c + 0.0).to_bits());
        *self.by_digits.entry(digits).or_insert_with(|| {
            points.push(Vector3::from(x.map(lit)));
            (points.len() - 1) as u32
        })
    }
}

impl<T: Scalar> Surface<T> {
    /// Tolerance of [`into_convex`](Self::into_convex) for files, whose numbers are often single: 1e-6 of the extent.
    pub const TOLERANCE: f64 = 1e-6;

    /// Points (m).
    pub fn points(&self) -> &[Vector3<T>] {
        &self.points
    }

    /// Faces: places of their corners among the points.
    pub fn faces(&self) -> &[Vec<u32>] {
        &self.faces
    }

    /// The same, `factor` times as large: files are often in millimetres.
    #[must_use]
    pub fn scaled(mut self, factor: T) -> Self {
        for x in &mut self.points {
            *x *= factor;
        }
        self
    }

    fn at(&self, v: u32) -> [f64; 3] {
        self.points.get(v as usize).map_or([f64::NAN; 3], |x| [x.x, x.y, x.z].map(to_f64))
    }

    /// The volume it encloses (m³), with its sign.
    fn volume(&self) -> T {
        let origin = self.points.first().copied().unwrap_or_else(Vector3::zeros);
        let corner = |v: u32| self.points.get(v as usize).map_or_else(Vector3::zeros, |x| x - origin);
        let of_face = |face: &Vec<u32>| {
            face.windows(2).fold(T::zero(), |sum, side| {
                sum + corner(face[0]).dot(&corner(side[0]).cross(&corner(side[1])))
            })
        };
        self.faces.iter().map(of_face).fold(T::zero(), |sum, six| sum + six) / lit::<T>(6.0)
    }

    /// Checks that it is closed and that its faces look outwards.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Empty`], [`SurfaceError::Hull`] for what is not finite, [`SurfaceError::Open`], [`SurfaceError::Inconsistent`] and [`SurfaceError::Inverted`].
    pub fn check(&self) -> Result<(), SurfaceError> {
        if self.faces.is_empty() {
            return Err(SurfaceError::Empty);
        }
        if let Some(point) = self.points.iter().position(|x| !all_finite(x.iter())) {
            return Err(HullError::NotFinite { point }.into());
        }
        let mut sides = HashMap::new();
        let around = |face: &Vec<u32>| -> Vec<(u32, u32)> {
            (0..face.len()).map(|k| (face[k], face[(k + 1) % face.len()])).filter(|(a, b)| a != b).collect()
        };
        for (second, face) in self.faces.iter().enumerate() {
            for (from, to) in around(face) {
                if let Some(first) = sides.insert((from, to), second) {
                    let (from, to) = (self.at(from), self.at(to));
                    return Err(SurfaceError::Inconsistent { first, second, from, to });
                }
            }
        }
        for (face, corners) in self.faces.iter().enumerate() {
            for (from, to) in around(corners) {
                if !sides.contains_key(&(to, from)) {
                    return Err(SurfaceError::Open { face, from: self.at(from), to: self.at(to) });
                }
            }
        }
        let volume = self.volume();
        if volume > T::zero() { Ok(()) } else { Err(SurfaceError::Inverted { volume: to_f64(volume) }) }
    }

    /// The convex polyhedron it is the surface of, within `tolerance` of its extent, see
    /// [`Polyhedron::hull_within`]; the volumes must agree to six times as much.
    ///
    /// # Errors
    ///
    /// Those of [`check`](Self::check), [`SurfaceError::Dent`] and [`SurfaceError::NotConvex`] where it is not convex, and
    /// [`SurfaceError::Hull`].
    pub fn into_convex(self, tolerance: T) -> Result<Polyhedron<T>, SurfaceError> {
        self.check()?;
        let hull = Polyhedron::hull_within(&self.points, tolerance)?;
        let allowed = tolerance * (hull.radius() + hull.radius());
        for x in &self.points {
            let heights = (0..hull.faces()).filter_map(|face| hull.plane(face)).map(|(n, d)| n.dot(x) - d);
            let depth = -heights.fold(-infinity::<T>(), max);
            if depth > allowed {
                return Err(SurfaceError::Dent { point: [x.x, x.y, x.z].map(to_f64), depth: to_f64(depth) });
            }
        }
        let (volume, whole) = (self.volume(), hull.mass_properties(T::one()).mass);
        // The tolerance bounds a length: over the least thickness it is a share of the volume.
        let thickness = min(whole / (hull.radius() * hull.radius()), hull.radius());
        if !(super::real::abs(volume - whole) <= lit::<T>(6.0) * max(allowed / thickness, lit(1e-12)) * whole)
        {
            return Err(SurfaceError::NotConvex { volume: to_f64(volume), hull: to_f64(whole) });
        }
        Ok(hull)
    }
}
