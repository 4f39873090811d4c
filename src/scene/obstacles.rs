//! Obstacles as scene files write them: shapes that are fixed.

use serde::Deserialize;

use super::{DiscSpec, PolygonSpec, Scene, SceneError};
use crate::scalar::{Scalar, lit};
use crate::system::{BodyId, GroupId, RigidBodiesBuilder, RoundSide};

/// Fixed shapes of any kind, under one name.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObstacleSpec {
    /// Name, unique among bodies, obstacles and half-planes.
    pub name: String,
    /// Groups the obstacle belongs to, for interfaces.
    #[serde(default)]
    pub groups: Vec<String>,
    /// Position of the origin of its frame (m).
    #[serde(default)]
    pub position: [f64; 2],
    /// Angle of its frame (rad).
    #[serde(default)]
    pub angle: f64,
    /// Discs and points.
    #[serde(default)]
    pub discs: Vec<DiscSpec>,
    /// Convex polygons.
    #[serde(default)]
    pub polygons: Vec<PolygonSpec>,
    /// Chains of segments: profiles, channels, boxes.
    #[serde(default)]
    pub chains: Vec<ChainSpec>,
    /// Circles and arcs, met from inside or from outside.
    #[serde(default)]
    pub arcs: Vec<ArcSpec>,
}

/// A chain of segments, with a thin solid layer behind it: half as thick as the shortest segment is long, or thinner where the
/// chain bends sharply.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChainSpec {
    /// Name, unique in the obstacle; interfaces call it `obstacle.chain`.
    pub name: String,
    /// Points in the frame of the obstacle (m), at least two. Bodies stay on the left of the chain, seen from its first point
    /// to its last.
    pub points: Vec<[f64; 2]>,
    /// Whether the chain closes from its last point to the first: counterclockwise it is a box that bodies are in, clockwise a
    /// block that they are around.
    #[serde(default)]
    pub closed: bool,
}

/// A circle or an arc of one. The ends of an arc are no corners: what passes an end leaves the arc.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArcSpec {
    /// Name, unique in the obstacle; interfaces call it `obstacle.arc`.
    pub name: String,
    /// Centre in the frame of the obstacle (m).
    #[serde(default)]
    pub centre: [f64; 2],
    /// Radius (m).
    pub radius: f64,
    /// The side that bodies are on.
    #[serde(default)]
    pub side: RoundSide,
    /// First angle of an arc from the x-axis (rad); a whole circle where both are absent.
    pub from: Option<f64>,
    /// Last angle of an arc (rad), larger than the first: an arc runs counterclockwise.
    pub to: Option<f64>,
}

impl ObstacleSpec {
    /// Names of the shapes, in the order in which they are built.
    pub(super) fn shapes(&self) -> impl Iterator<Item = &String> {
        let discs = self.discs.iter().map(|disc| &disc.name);
        let polygons = self.polygons.iter().map(|polygon| &polygon.name);
        let chains = self.chains.iter().map(|chain| &chain.name);
        discs.chain(polygons).chain(chains).chain(self.arcs.iter().map(|arc| &arc.name))
    }

    /// A point of its frame in the fixed frame.
    pub(super) fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle.sin_cos();
        [self.position[0] + cos * x - sin * y, self.position[1] + sin * x + cos * y]
    }

    /// Adds the shapes, each in its group.
    pub(super) fn build<T: Scalar>(
        &self,
        builder: &mut RigidBodiesBuilder<T>,
        groups: &[GroupId],
    ) -> Result<(), SceneError> {
        let mut groups = groups.iter().copied();
        let label = |name: &String| format!("{}.{name}", self.name);
        let place = |x: &[f64; 2]| self.place(*x).map(lit::<T>);
        let ground = BodyId::GROUND;
        for (disc, group) in self.discs.iter().zip(groups.by_ref().take(self.discs.len())) {
            builder.disc(&label(&disc.name), ground, place(&disc.centre), lit(disc.radius), group)?;
        }
        for (polygon, group) in self.polygons.iter().zip(groups.by_ref().take(self.polygons.len())) {
            let vertices: Vec<[T; 2]> = polygon.vertices.iter().map(place).collect();
            builder.polygon(&label(&polygon.name), ground, &vertices, group)?;
        }
        for (chain, group) in self.chains.iter().zip(groups.by_ref().take(self.chains.len())) {
            let points: Vec<[T; 2]> = chain.points.iter().map(place).collect();
            builder.chain(&label(&chain.name), ground, &points, chain.closed, group)?;
        }
        for (arc, group) in self.arcs.iter().zip(groups) {
            let angles = match (arc.from, arc.to) {
                (None, None) => None,
                (Some(from), Some(to)) => Some([from, to].map(|angle| lit(self.angle + angle))),
                _ => return Err(SceneError::HalfArc { arc: label(&arc.name) }),
            };
            let circle = (place(&arc.centre), lit(arc.radius));
            builder.arc(&label(&arc.name), ground, circle, arc.side, angles, group)?;
        }
        Ok(())
    }
}

/// Checks the numbers that place obstacles.
pub(super) fn check_obstacles(scene: &Scene) -> Result<(), SceneError> {
    for obstacle in &scene.obstacles {
        let numbers = [obstacle.position[0], obstacle.position[1], obstacle.angle];
        if let Some(&value) = numbers.iter().find(|x| !x.is_finite()) {
            let what = format!("position or angle of `{}`", obstacle.name);
            return Err(SceneError::OutOfRange { what, value, range: "finite" });
        }
    }
    Ok(())
}
