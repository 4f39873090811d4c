//! Shapes as scene files write them.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use serde::Deserialize;

use super::format::upright;
use super::heights::HeightsSpec;
use crate::geometry::{Part, Polyhedron, Pose, Shape, ShapeError, Surface, SurfaceError, Terrain};
use crate::scalar::{Scalar, lit};
use crate::scene::SceneError;

/// Facets of cylinders and cones where they meet polyhedra.
const FACETS: usize = 32;

/// Vertices of a file that are one, in its size.
const MERGED: f64 = 1e-9;

/// A shape in space: one of `ball`, `box`, `capsule`, `cylinder`, `cone`, `hull` and `file`, or of an obstacle `terrain` or
/// `heights`.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShapeSpec {
    /// Name, unique in the body or obstacle; interfaces call it `body.name`. Its number from 1 where absent.
    pub name: Option<String>,
    /// Radius of a ball (m).
    pub ball: Option<f64>,
    /// Lengths of the edges of a box about its centre, along x, y and z (m).
    #[serde(rename = "box")]
    pub cuboid: Option<[f64; 3]>,
    /// Radius, and length of the axis between the centres of its ends, of a capsule along z about its centre (m).
    pub capsule: Option<[f64; 2]>,
    /// Radius and height of a cylinder along z about its centre (m).
    pub cylinder: Option<[f64; 2]>,
    /// Radius and height of a cone along z, about its centre of mass (m).
    pub cone: Option<[f64; 2]>,
    /// Points of which the shape is the convex hull (m).
    pub hull: Option<Vec<[f64; 3]>>,
    /// STL or OBJ file of a convex solid, relative to the folder of the scene.
    pub file: Option<PathBuf>,
    /// STL or OBJ file of the surface of an obstacle, open or closed, of any form: bodies stay on the side of its triangles that
    /// sees their corners counterclockwise.
    pub terrain: Option<PathBuf>,
    /// Heights of the surface of an obstacle over a grid; bodies stay above.
    pub heights: Option<HeightsSpec>,
    /// Factor on the numbers of the file (dimensionless).
    pub scale: Option<f64>,
    /// Position in the frame of the body (m).
    #[serde(default)]
    pub position: [f64; 3],
    /// Orientation in it, a quaternion (w, x, y, z) of any length (dimensionless).
    #[serde(default)]
    pub orientation: Option<[f64; 4]>,
}

impl ShapeSpec {
    /// Its name, as shape number `index` of its owner.
    pub(super) fn name(&self, index: usize) -> String {
        self.name.clone().unwrap_or_else(|| (index + 1).to_string())
    }

    /// The shape where it is on its body.
    pub(super) fn part<T: Scalar>(&self, label: &str, folder: &Path) -> Result<Part<T>, SceneError> {
        let error = |source| SceneError::Shape { shape: label.into(), source };
        let given: Vec<&'static str> = [
            ("ball", self.ball.is_some()),
            ("box", self.cuboid.is_some()),
            ("capsule", self.capsule.is_some()),
            ("cylinder", self.cylinder.is_some()),
            ("cone", self.cone.is_some()),
            ("hull", self.hull.is_some()),
            ("file", self.file.is_some()),
            ("terrain", self.terrain.is_some()),
            ("heights", self.heights.is_some()),
        ]
        .into_iter()
        .filter_map(|(name, is_given)| is_given.then_some(name))
        .collect();
        if given.len() != 1 {
            return Err(SceneError::OneShape { shape: label.into(), given: given.join(", ") });
        }
        if self.scale.is_some() && self.file.is_none() && self.terrain.is_none() {
            return Err(SceneError::NoFile { shape: label.into() });
        }
        let half = |x: f64| lit::<T>(0.5 * x);
        let shape = match self {
            Self { ball: Some(radius), .. } => Shape::ball(lit(*radius)),
            Self { cuboid: Some(edges), .. } => Shape::cuboid(Vector3::from(edges.map(half))),
            Self { capsule: Some([radius, length]), .. } => Shape::capsule(lit(*radius), half(*length)),
            Self { cylinder: Some([radius, height]), .. } => {
                Shape::cylinder(lit(*radius), half(*height), FACETS)
            }
            Self { cone: Some([radius, height]), .. } => Shape::cone(lit(*radius), lit(*height), FACETS),
            Self { hull: Some(points), .. } => {
                let points: Vec<Vector3<T>> = points.iter().map(|x| Vector3::from(x.map(lit))).collect();
                Polyhedron::hull(&points).map(Shape::polyhedron).map_err(ShapeError::from)
            }
            Self { terrain: Some(file), .. } => {
                let surface = self.surface(label, file, folder)?;
                let terrain = Terrain::new(&surface);
                return self.on_ground(label, file, terrain);
            }
            Self { heights: Some(heights), .. } => {
                let file = heights.file.clone().unwrap_or_default();
                return self.on_ground(label, &file, heights.terrain(label, folder)?);
            }
            _ => return self.of_file(label, folder),
        };
        Ok(Part { shape: shape.map_err(error)?, pose: self.pose(label)? })
    }

    fn of_file<T: Scalar>(&self, label: &str, folder: &Path) -> Result<Part<T>, SceneError> {
        let file = self.file.clone().unwrap_or_default();
        let hull = self.surface(label, &file, folder)?.into_convex(lit(MERGED));
        let hull = hull.map_err(|source| refuse(label, &file, source))?;
        Ok(Part { shape: Shape::polyhedron(hull), pose: self.pose(label)? })
    }

    /// The surface of a file, scaled.
    fn surface<T: Scalar>(&self, label: &str, file: &Path, folder: &Path) -> Result<Surface<T>, SceneError> {
        let read = read(label, &folder.join(file))?;
        let is_obj = file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("obj"));
        let surface = match is_obj {
            true => Surface::<T>::from_obj(&String::from_utf8_lossy(&read)),
            false => Surface::from_stl(&read),
        };
        let surface = surface.map_err(|source| refuse(label, file, source))?;
        Ok(surface.scaled(lit(self.scale.unwrap_or(1.0))))
    }

    fn on_ground<T: Scalar>(
        &self,
        label: &str,
        file: &Path,
        terrain: Result<Terrain<T>, SurfaceError>,
    ) -> Result<Part<T>, SceneError> {
        let terrain = terrain.map_err(|source| refuse(label, file, source))?;
        Ok(Part { shape: Shape::terrain(terrain), pose: self.pose(label)? })
    }

    /// Whether it is a surface that only obstacles have.
    pub(super) fn is_ground(&self) -> bool {
        self.terrain.is_some() || self.heights.is_some()
    }

    /// Files it is made from.
    pub(super) fn files(&self) -> impl Iterator<Item = &PathBuf> {
        let heights = self.heights.as_ref().and_then(|heights| heights.file.as_ref());
        self.file.iter().chain(&self.terrain).chain(heights)
    }

    fn pose<T: Scalar>(&self, label: &str) -> Result<Pose<T>, SceneError> {
        pose(label, self.position, self.orientation.unwrap_or_else(upright))
    }
}

/// A pose of the file.
pub(super) fn pose<T: Scalar>(
    label: &str,
    position: [f64; 3],
    orientation: [f64; 4],
) -> Result<Pose<T>, SceneError> {
    let place = Vector3::from(position.map(lit::<T>));
    Pose::from_parts(place, orientation.map(lit))
        .map_err(|source| SceneError::Pose { of: label.into(), source })
}

/// The error of a file that is no such surface.
pub(super) fn refuse(label: &str, file: &Path, source: SurfaceError) -> SceneError {
    SceneError::Surface { shape: label.into(), file: file.into(), source }
}

/// Reads the file of a shape.
pub(super) fn read(label: &str, path: &Path) -> Result<Vec<u8>, SceneError> {
    std::fs::read(path).map_err(|source| SceneError::ShapeFile {
        shape: label.into(),
        file: path.into(),
        source: source.into(),
    })
}
