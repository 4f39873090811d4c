//! Shapes as scene files write them.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use serde::Deserialize;

use super::format::upright;
use crate::geometry::{Part, Polyhedron, Pose, Shape, ShapeError, Surface, SurfaceError};
use crate::scalar::{Scalar, lit};
use crate::scene::SceneError;

/// Facets of cylinders and cones where they meet polyhedra.
const FACETS: usize = 32;

/// Vertices of a file that are one, in its size.
const MERGED: f64 = 1e-9;

/// A shape in space: one of `ball`, `box`, `capsule`, `cylinder`, `cone`, `hull` and `file`.
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
        ]
        .into_iter()
        .filter_map(|(name, is_given)| is_given.then_some(name))
        .collect();
        if given.len() != 1 {
            return Err(SceneError::OneShape { shape: label.into(), given: given.join(", ") });
        }
        if self.scale.is_some() && self.file.is_none() {
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
            _ => return self.of_file(label, folder),
        };
        Ok(Part { shape: shape.map_err(error)?, pose: self.pose(label)? })
    }

    fn of_file<T: Scalar>(&self, label: &str, folder: &Path) -> Result<Part<T>, SceneError> {
        let file = self.file.clone().unwrap_or_default();
        let path = folder.join(&file);
        let refuse =
            |source: SurfaceError| SceneError::Surface { shape: label.into(), file: file.clone(), source };
        let read = std::fs::read(&path).map_err(|source| SceneError::ShapeFile {
            shape: label.into(),
            file: path.clone(),
            source: source.into(),
        })?;
        let is_obj = file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("obj"));
        let surface = match is_obj {
            true => Surface::<T>::from_obj(&String::from_utf8_lossy(&read)),
            false => Surface::from_stl(&read),
        };
        let surface = surface.map_err(refuse)?;
        let surface = surface.scaled(lit(self.scale.unwrap_or(1.0)));
        let hull = surface.into_convex(lit(MERGED)).map_err(refuse)?;
        Ok(Part { shape: Shape::polyhedron(hull), pose: self.pose(label)? })
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
