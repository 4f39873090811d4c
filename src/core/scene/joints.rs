//! Joints, motors and springs as scene files write them.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::build::AnyLaw;
use super::format::InterfaceSpec;
use super::obstacles::turned;
use super::{PlannedRun, Scene, SceneError};
use crate::registry::Registry;
use crate::scalar::{Scalar, lit};
use crate::system::{BodyId, Relative, RigidBodiesBuilder, Signal};

/// A joint: a point of a body held on a point of another, of an obstacle or of the ground, or on a line through it. A pin
/// turns, a weld does not (`angle`), a slider moves along its `axis`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointSpec {
    /// Name, for errors and limits.
    pub name: String,
    /// The body.
    pub body: String,
    /// Its point, in its frame (m).
    #[serde(default)]
    pub at: [f64; 2],
    /// The other body, or an obstacle; the ground where absent.
    pub to: Option<String>,
    /// The other body's point in its frame, or the point of the ground (m).
    #[serde(default)]
    pub on: [f64; 2],
    /// Direction in the frame of the other (dimensionless), of any length: the point moves along it, a slider.
    pub axis: Option<[f64; 2]>,
    /// Angle of the body less that of the other (rad), held as well where it is given: a weld, or a slider that does not turn.
    pub angle: Option<f64>,
    /// Least and largest value of what the joint leaves free (m or rad): the offset along `axis` of a slider, else the angle of
    /// the body less that of the other. Reaching one is an impact under the law of the run.
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

/// A motor in a joint, along what the joint leaves free: one of `speed` and `force`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotorSpec {
    /// Speed (m/s or rad/s), times the signal.
    pub speed: Option<f64>,
    /// Largest force or torque of a motor with a speed (N or N m); unlimited where absent.
    pub most: Option<f64>,
    /// Force or torque (N or N m), times the signal.
    pub force: Option<f64>,
    /// Signal; constant where absent.
    #[serde(default)]
    pub signal: Signal<f64>,
}

/// What a motor does.
pub(super) enum Motor {
    /// A speed, with at most a force.
    Speed(f64, Option<f64>),
    /// A force.
    Force(f64),
}

impl MotorSpec {
    /// What the motor of a joint does.
    pub(super) fn motor(&self, joint: &str) -> Result<Motor, SceneError> {
        match (self.speed, self.most, self.force) {
            (Some(speed), most, None) => Ok(Motor::Speed(speed, most)),
            (None, None, Some(force)) => Ok(Motor::Force(force)),
            _ => Err(SceneError::Motor { joint: joint.into() }),
        }
    }
}

/// The limits of a joint as an interface, for its law and parameters.
pub(super) fn limits_of(joint: &str, parameters: &BTreeMap<String, f64>) -> InterfaceSpec {
    let between = [joint.into(), "its limits".into()];
    InterfaceSpec { between, law: None, parameters: parameters.clone() }
}

/// A spring with a damper, between points of two bodies, along an axis, or in rotation. Its potential is ½ k (x − rest)², x the
/// distance of the points, the offset along the axis or the angle of the body less that of the other.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpringSpec {
    /// Name, for errors.
    pub name: String,
    /// The body.
    pub body: String,
    /// Its point, in its frame (m).
    #[serde(default)]
    pub at: [f64; 2],
    /// The other body, or an obstacle; the ground where absent.
    pub to: Option<String>,
    /// The other body's point in its frame, or the point of the ground (m).
    #[serde(default)]
    pub on: [f64; 2],
    /// Direction in the frame of the other (dimensionless), of any length: x is the offset along it.
    pub axis: Option<[f64; 2]>,
    /// Whether x is the angle.
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

/// The bodies of the scene, and those of its obstacles that move.
pub(super) type Ids<'a> = (&'a [BodyId], &'a [Option<BodyId>]);

/// A body of the scene, and what it is connected to.
struct Ends {
    bodies: (BodyId, Option<BodyId>),
    on: [f64; 2],
    axis: Option<[f64; 2]>,
    /// Angle of the other's frame where that is fixed.
    turned: f64,
}

/// Finds the ends of a connection; what is fixed is given in the fixed frame.
fn ends(
    scene: &Scene,
    (ids, movers): Ids<'_>,
    place: &dyn Fn() -> String,
    (body, to): (&str, Option<&str>),
    (on, axis): ([f64; 2], Option<[f64; 2]>),
) -> Result<Ends, SceneError> {
    let find = |name: &str| scene.bodies.iter().position(|body| body.name == name).map(|i| ids[i]);
    let unknown = |name: &str| {
        let bodies = scene.bodies.iter().map(|body| body.name.as_str());
        let known = bodies.chain(scene.obstacles.iter().map(|obstacle| obstacle.name.as_str()));
        let known = known.collect::<Vec<_>>().join(", ");
        SceneError::UnknownName { place: place(), name: name.into(), known }
    };
    let body = find(body).ok_or_else(|| unknown(body))?;
    let Some(to) = to else { return Ok(Ends { bodies: (body, None), on, axis, turned: 0.0 }) };
    if let Some(other) = find(to) {
        return Ok(Ends { bodies: (body, Some(other)), on, axis, turned: 0.0 });
    }
    let place = scene.obstacles.iter().position(|obstacle| obstacle.name == to).ok_or_else(|| unknown(to))?;
    if let Some(mover) = movers[place] {
        return Ok(Ends { bodies: (body, Some(mover)), on, axis, turned: 0.0 });
    }
    let obstacle = &scene.obstacles[place];
    let axis = axis.map(|axis| turned(axis, obstacle.angle));
    Ok(Ends { bodies: (body, None), on: obstacle.place(on), axis, turned: obstacle.angle })
}

impl JointSpec {
    /// Adds the joint; the law of its limits, if any, goes to `laws`.
    pub(super) fn build<T: Scalar, const D: usize>(
        &self,
        scene: &Scene,
        (run, registry): (&PlannedRun, &Registry),
        (builder, ids): (&mut RigidBodiesBuilder<T>, Ids<'_>),
        laws: &mut Vec<AnyLaw<T, D>>,
    ) -> Result<(), SceneError> {
        let name = &self.name;
        let place = || format!("joint `{name}`");
        let found = ends(scene, ids, &place, (&self.body, self.to.as_deref()), (self.on, self.axis))?;
        let Ends { bodies, on, axis, turned } = found;
        let (at, on) = (self.at.map(lit::<T>), on.map(lit::<T>));
        let angle = self.angle.map(|angle| lit::<T>(turned + angle));
        let free = match (axis, angle) {
            (None, None) => {
                builder.pin(name, bodies.0, at, bodies.1, on)?;
                Some(Relative::Angle)
            }
            (None, Some(angle)) => {
                builder.weld(name, bodies.0, at, bodies.1, on, angle)?;
                None
            }
            (Some(axis), angle) => {
                let axis = axis.map(lit::<T>);
                builder.slider(name, bodies, (at, on), axis, angle)?;
                Some(Relative::Along { at, on, axis })
            }
        };
        let acts = self.limits.is_some() || self.friction != 0.0 || self.motor.is_some();
        let Some(free) = free else {
            return if acts { Err(SceneError::NothingFree { joint: name.clone() }) } else { Ok(()) };
        };
        // Angles to an obstacle are those to its frame.
        let offset = if free == Relative::Angle { turned } else { 0.0 };
        if let Some(limits) = self.limits {
            builder.limit(name, bodies, free, limits.map(|limit| lit(offset + limit)))?;
            laws.push(self.interface().law(run, registry)?);
        }
        if self.friction != 0.0 {
            builder.rub(&format!("{name}.friction"), bodies, free, lit(self.friction))?;
        }
        if let Some(spec) = &self.motor {
            let label = format!("{name}.motor");
            match spec.motor(name)? {
                Motor::Speed(speed, most) => {
                    builder.drive(&label, bodies, free, (lit(speed), most.map(lit)), spec.signal.cast())?;
                }
                Motor::Force(force) => {
                    builder.push(&label, bodies, free, lit(force), spec.signal.cast())?;
                }
            }
        }
        Ok(())
    }

    /// The limits as an interface, for its law and parameters.
    pub(super) fn interface(&self) -> InterfaceSpec {
        limits_of(&self.name, &self.parameters)
    }
}

impl SpringSpec {
    /// Adds the spring.
    pub(super) fn build<T: Scalar>(
        &self,
        scene: &Scene,
        (builder, ids): (&mut RigidBodiesBuilder<T>, Ids<'_>),
        q: &[T],
    ) -> Result<(), SceneError> {
        let name = &self.name;
        let place = || format!("spring `{name}`");
        let found = ends(scene, ids, &place, (&self.body, self.to.as_deref()), (self.on, self.axis))?;
        let Ends { bodies, on, axis, turned } = found;
        let (at, on) = (self.at.map(lit::<T>), on.map(lit::<T>));
        let relative = match (axis, self.angular) {
            (None, false) => Relative::Distance { at, on },
            (Some(axis), false) => Relative::Along { at, on, axis: axis.map(lit) },
            (None, true) => Relative::Angle,
            (Some(_), true) => return Err(SceneError::AngularAxis { spring: name.clone() }),
        };
        let offset = if self.angular { turned } else { 0.0 };
        let constants = (lit(self.stiffness), lit(self.damping));
        match self.rest {
            Some(rest) => builder.spring_between(name, bodies, relative, constants, lit(offset + rest))?,
            None => builder.spring_from(name, bodies, relative, constants, q)?,
        }
        Ok(())
    }
}
