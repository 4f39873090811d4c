//! Obstacles as scene files write them: shapes that are fixed, or move as told.

use serde::Deserialize;

use super::{DiscSpec, HalfPlaneSpec, PolygonSpec, Scene, SceneError};
use crate::scalar::{Scalar, lit};
use crate::system::{BodyId, GroupId, RigidBodiesBuilder, RoundSide, Signal};

/// Fixed shapes of any kind, under one name; or, with a `motion`, shapes that move as told: a belt, a shaker, a piston.
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
    /// Displacements of the frame, each times a signal; fixed where there are none. Every component may have one.
    #[serde(default)]
    pub motion: Vec<MotionSpec>,
    /// Half-planes, in the frame of the obstacle.
    #[serde(default)]
    pub half_planes: Vec<HalfPlaneSpec>,
    /// Discs and points.
    #[serde(default)]
    pub discs: Vec<DiscSpec>,
    /// Polygons.
    #[serde(default)]
    pub polygons: Vec<PolygonSpec>,
    /// Chains of segments: profiles, channels, boxes.
    #[serde(default)]
    pub chains: Vec<ChainSpec>,
    /// Circles and arcs, met from inside or from outside.
    #[serde(default)]
    pub arcs: Vec<ArcSpec>,
}

/// A displacement that varies in time. The velocity of a step is that of the signal over it, wherever it jumps or bends.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotionSpec {
    /// Displacement of the origin of the frame (m), times the signal.
    #[serde(default)]
    pub displacement: [f64; 2],
    /// Rotation of the frame (rad), times the signal.
    #[serde(default)]
    pub angle: f64,
    /// Signal; a belt or a drum has a linear one.
    pub signal: Signal<f64>,
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

/// A vector turned by an angle (rad).
pub(super) fn turned([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

impl ObstacleSpec {
    /// Names of the shapes, in the order in which they are built.
    pub(super) fn shapes(&self) -> impl Iterator<Item = &String> {
        let discs = self.discs.iter().map(|disc| &disc.name);
        let polygons = self.polygons.iter().map(|polygon| &polygon.name);
        let chains = self.chains.iter().map(|chain| &chain.name);
        let round = self.arcs.iter().map(|arc| &arc.name);
        discs
            .chain(polygons)
            .chain(chains)
            .chain(round)
            .chain(self.half_planes.iter().map(|plane| &plane.name))
    }

    /// A point of its frame in the fixed frame.
    pub(super) fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [x, y] = turned([x, y], self.angle);
        [self.position[0] + x, self.position[1] + y]
    }

    /// Adds the shapes, each in its group.
    pub(super) fn build<T: Scalar>(
        &self,
        builder: &mut RigidBodiesBuilder<T>,
        groups: &[GroupId],
    ) -> Result<Option<BodyId>, SceneError> {
        let id = self.body(builder)?;
        let mut groups = groups.iter().copied();
        let label = |name: &String| format!("{}.{name}", self.name);
        // What is fixed is given in the fixed frame, what moves in its own.
        let (ground, by) = (id.unwrap_or(BodyId::GROUND), if id.is_some() { 0.0 } else { self.angle });
        let place = |x: &[f64; 2]| if id.is_some() { *x } else { self.place(*x) }.map(lit::<T>);
        for (disc, group) in self.discs.iter().zip(groups.by_ref().take(self.discs.len())) {
            builder.disc(&label(&disc.name), ground, place(&disc.centre), lit(disc.radius), group)?;
        }
        for (polygon, group) in self.polygons.iter().zip(groups.by_ref().take(self.polygons.len())) {
            for (label, part) in polygon.parts(&label(&polygon.name))? {
                let vertices: Vec<[T; 2]> = part.iter().map(place).collect();
                builder.polygon(&label, ground, &vertices, group)?;
            }
        }
        for (chain, group) in self.chains.iter().zip(groups.by_ref().take(self.chains.len())) {
            let points: Vec<[T; 2]> = chain.points.iter().map(place).collect();
            builder.chain(&label(&chain.name), ground, &points, chain.closed, group)?;
        }
        for (arc, group) in self.arcs.iter().zip(groups.by_ref().take(self.arcs.len())) {
            let angles = match (arc.from, arc.to) {
                (None, None) => None,
                (Some(from), Some(to)) => Some([from, to].map(|angle| lit(by + angle))),
                _ => return Err(SceneError::HalfArc { arc: label(&arc.name) }),
            };
            let circle = (place(&arc.centre), lit(arc.radius));
            builder.arc(&label(&arc.name), ground, circle, arc.side, angles, group)?;
        }
        for (plane, group) in self.half_planes.iter().zip(groups) {
            let normal = turned(plane.normal, by).map(lit::<T>);
            builder.half_plane_of(&label(&plane.name), ground, place(&plane.point), normal, group)?;
        }
        Ok(id)
    }

    /// The body of an obstacle that moves.
    fn body<T: Scalar>(&self, builder: &mut RigidBodiesBuilder<T>) -> Result<Option<BodyId>, SceneError> {
        if self.motion.is_empty() {
            return Ok(None);
        }
        let mut motion: [(T, Signal<T>); 3] = std::array::from_fn(|_| (T::zero(), Signal::Constant));
        for spec in &self.motion {
            let by = [spec.displacement[0], spec.displacement[1], spec.angle];
            for (component, &by) in by.iter().enumerate().filter(|&(_, &by)| by != 0.0) {
                if motion[component].0 != T::zero() {
                    let component = ["x", "y", "angle"][component];
                    return Err(SceneError::TwoMotions { obstacle: self.name.clone(), component });
                }
                motion[component] = (lit(by), spec.signal.cast());
            }
        }
        let origin = [self.position[0], self.position[1], self.angle].map(lit);
        Ok(Some(builder.moved_body(&self.name, origin, motion)?))
    }

    /// Its configuration at the start, where it moves.
    pub(super) fn start(&self) -> Option<[f64; 3]> {
        let mut q = [self.position[0], self.position[1], self.angle];
        for MotionSpec { displacement: [x, y], angle, signal } in &self.motion {
            let by = [x, y, angle];
            q.iter_mut().zip(by).for_each(|(q, by)| *q += by * signal.at(0.0));
        }
        (!self.motion.is_empty()).then_some(q)
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
