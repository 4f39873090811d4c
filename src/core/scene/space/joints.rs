//! Joints, springs and motions in space as scene files write them: drawn in the fixed frame, where the bodies start.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::SpaceSpec;
use crate::registry::Registry;
use crate::scalar::{Scalar, lit};
use crate::scene::build::AnyLaw;
use crate::scene::joints::{Motor, limits_of};
use crate::scene::{InterfaceSpec, MotorSpec, PlannedRun, SceneError};
use crate::system::{Bodies, BodyId, Signal, SpatialBodiesBuilder, SpatialRelative};

/// What a joint in space holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SpaceJointKind {
    /// A point of the body on a point of the other.
    Ball,
    /// A point, and an axis through it: the body turns about the axis.
    Hinge,
    /// Everything but the way along an axis.
    Slider,
    /// Everything.
    Weld,
    /// The distance of two points: a rod without mass.
    Rod,
}

/// A joint of two bodies in space, or of a body and an obstacle or the ground, as they stand at the start.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpaceJointSpec {
    /// Name, for errors and limits.
    pub name: String,
    /// What it holds: `ball`, `hinge`, `slider`, `weld` or `rod`.
    pub kind: SpaceJointKind,
    /// The body.
    pub body: String,
    /// The other body, or an obstacle; the ground where absent.
    pub to: Option<String>,
    /// Where the joint is at the start, in the fixed frame (m): its point; of a rod the end on the body.
    pub point: Option<[f64; 3]>,
    /// The end of a rod on the other, at the start and in the fixed frame (m).
    pub on: Option<[f64; 3]>,
    /// Direction at the start, in the fixed frame (dimensionless), of any length: the axis of a hinge or a slider; it goes with
    /// the other body.
    pub axis: Option<[f64; 3]>,
    /// Least and largest value of what the joint leaves free, 0 at the start (m or rad): the way along the axis of a slider, the
    /// angle of a hinge, from −π to π. Reaching one is an impact under the law of the run.
    pub limits: Option<[f64; 2]>,
    /// Parameters of the law at the limits by name (of each parameter its own); a law takes those it has.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
    /// Dry friction of at most this force or torque (N or N m).
    #[serde(default)]
    pub friction: f64,
    /// A motor.
    pub motor: Option<MotorSpec>,
}

/// A spring with a damper in space: between two points, along an axis, or in rotation about one. Its potential is
/// ½ k (x − rest)², x the distance of the points, the offset along the axis or the angle.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpaceSpringSpec {
    /// Name, for errors.
    pub name: String,
    /// The body.
    pub body: String,
    /// The other body, or an obstacle; the ground where absent.
    pub to: Option<String>,
    /// Its end on the body, at the start and in the fixed frame (m); not of an angular spring.
    pub point: Option<[f64; 3]>,
    /// Its end on the other, at the start and in the fixed frame (m); not of an angular spring.
    pub on: Option<[f64; 3]>,
    /// Direction at the start, in the fixed frame (dimensionless), of any length: x is the offset along it, or the angle about it.
    pub axis: Option<[f64; 3]>,
    /// Whether x is the angle about the axis, from −π to π and 0 at the start (rad).
    #[serde(default)]
    pub angular: bool,
    /// Stiffness k (N/m or N m/rad).
    #[serde(default)]
    pub stiffness: f64,
    /// Damping (N s/m or N m s).
    #[serde(default)]
    pub damping: f64,
    /// The x without force (m or rad); that of the start where absent.
    pub rest: Option<f64>,
}

/// A displacement in space that varies in time.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpaceMotionSpec {
    /// Displacement of the origin of the frame along the fixed axes (m), times the signal.
    #[serde(default)]
    pub displacement: [f64; 3],
    /// Rotation about the `motion_axis` of the obstacle (rad), times the signal.
    #[serde(default)]
    pub angle: f64,
    /// Signal; a belt or a drum has a linear one.
    pub signal: Signal<f64>,
}

/// Bodies by name, and how a joint or a spring finds them.
pub(super) struct Ids<'a> {
    pub(super) scene: &'a SpaceSpec,
    pub(super) bodies: &'a [BodyId],
    /// Of the obstacles, those that move as told.
    pub(super) movers: &'a [Option<BodyId>],
}

impl Ids<'_> {
    fn find(&self, place: &str, body: &str, to: Option<&str>) -> Result<Bodies, SceneError> {
        let SpaceSpec { bodies, obstacles, .. } = self.scene;
        let unknown = |name: &str| {
            let names = bodies.iter().map(|body| body.name.as_str());
            let known: Vec<_> =
                names.chain(obstacles.iter().map(|obstacle| obstacle.name.as_str())).collect();
            SceneError::UnknownName { place: place.into(), name: name.into(), known: known.join(", ") }
        };
        let id = |name: &str| bodies.iter().position(|body| body.name == name).map(|i| self.bodies[i]);
        let body = id(body).ok_or_else(|| unknown(body))?;
        let Some(to) = to else { return Ok((body, None)) };
        if let Some(other) = id(to) {
            return Ok((body, Some(other)));
        }
        let other = obstacles.iter().position(|obstacle| obstacle.name == to).ok_or_else(|| unknown(to))?;
        Ok((body, self.movers[other]))
    }
}

impl SpaceJointSpec {
    /// What the kind of joint wants, in the fixed frame.
    fn given(&self, what: &'static str, place: Option<[f64; 3]>) -> Result<[f64; 3], SceneError> {
        place.ok_or_else(|| SceneError::JointWants { joint: self.name.clone(), what })
    }

    /// Adds the joint, drawn in configuration q; the law of its limits, if any, goes to `laws`.
    pub(super) fn build<T: Scalar, const D: usize>(
        &self,
        (run, registry): (&PlannedRun, &Registry),
        (builder, ids, q): (&mut SpatialBodiesBuilder<T>, &Ids<'_>, &[T]),
        laws: &mut Vec<AnyLaw<T, D>>,
    ) -> Result<(), SceneError> {
        let name = &self.name;
        let bodies = ids.find(&format!("joint `{name}`"), &self.body, self.to.as_deref())?;
        let point = || self.given("point", self.point).map(|x| x.map(lit::<T>));
        let axis = || self.given("axis", self.axis).map(|x| x.map(lit::<T>));
        let unused = match self.kind {
            SpaceJointKind::Ball => self.axis.map(|_| "axis").or(self.on.map(|_| "on")),
            SpaceJointKind::Hinge | SpaceJointKind::Slider => self.on.map(|_| "on"),
            SpaceJointKind::Weld => {
                self.axis.map(|_| "axis").or(self.on.map(|_| "on")).or(self.point.map(|_| "point"))
            }
            SpaceJointKind::Rod => self.axis.map(|_| "axis"),
        };
        if let Some(what) = unused {
            return Err(SceneError::JointTakes { joint: name.clone(), what });
        }
        let free = match self.kind {
            SpaceJointKind::Ball => {
                builder.ball(name, bodies, point()?, q)?;
                None
            }
            SpaceJointKind::Hinge => Some(builder.hinge(name, bodies, (point()?, axis()?), q)?),
            SpaceJointKind::Slider => Some(builder.slider(name, bodies, (point()?, axis()?), q)?),
            SpaceJointKind::Weld => {
                builder.weld(name, bodies, q)?;
                None
            }
            SpaceJointKind::Rod => {
                let other = self.given("on", self.on)?.map(lit::<T>);
                builder.rod(name, bodies, [point()?, other], q)?;
                None
            }
        };
        let acts = self.limits.is_some() || self.friction != 0.0 || self.motor.is_some();
        let Some(free) = free else {
            return if acts { Err(SceneError::NothingFreeInSpace { joint: name.clone() }) } else { Ok(()) };
        };
        if let Some(limits) = self.limits {
            builder.limit(name, free, limits.map(lit))?;
            laws.push(self.interface().law(run, registry)?);
        }
        if self.friction != 0.0 {
            builder.rub(&format!("{name}.friction"), free, lit(self.friction))?;
        }
        if let Some(spec) = &self.motor {
            let label = format!("{name}.motor");
            match spec.motor(name)? {
                Motor::Speed(speed, most) => {
                    builder.drive(&label, free, (lit(speed), most.map(lit)), spec.signal.cast())?;
                }
                Motor::Force(force) => builder.push(&label, free, lit(force), spec.signal.cast())?,
            }
        }
        Ok(())
    }

    /// The limits as an interface, for its law and parameters.
    pub(in crate::scene) fn interface(&self) -> InterfaceSpec {
        limits_of(&self.name, &self.parameters)
    }
}

impl SpaceSpringSpec {
    /// Adds the spring, drawn in configuration q.
    pub(super) fn build<T: Scalar>(
        &self,
        (builder, ids, q): (&mut SpatialBodiesBuilder<T>, &Ids<'_>, &[T]),
    ) -> Result<(), SceneError> {
        let name = &self.name;
        let bodies = ids.find(&format!("spring `{name}`"), &self.body, self.to.as_deref())?;
        let given = |what: &'static str, place: Option<[f64; 3]>| {
            let wants = || SceneError::SpringWants { spring: name.clone(), what };
            place.map(|x| x.map(lit::<T>)).ok_or_else(wants)
        };
        let points = || Ok::<_, SceneError>([given("point", self.point)?, given("on", self.on)?]);
        let axis = self.axis.map(|axis| axis.map(lit::<T>));
        let along: SpatialRelative<T> = match (axis, self.angular) {
            (None, false) => builder.distance(name, bodies, points()?, q)?,
            (Some(axis), false) => builder.offset(name, bodies, (points()?, axis), q)?,
            (_, true) => builder.angle(name, bodies, given("axis", self.axis)?, q)?,
        };
        let rest = self.rest.map_or_else(|| along.value(q), lit);
        builder.spring(name, along, (lit(self.stiffness), lit(self.damping)), rest)?;
        Ok(())
    }
}
