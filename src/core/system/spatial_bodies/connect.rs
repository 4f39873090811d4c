//! Joints, springs and motors between bodies in space, drawn where the bodies stand.

use nalgebra::Vector3;

use super::builder::SpatialBodiesBuilder;
use super::coordinate::{Kind, Relation, Side};
use super::shape::{COORDINATES, body_pose, index};
use crate::geometry::{Pose, frame};
use crate::scalar::Scalar;
use crate::system::element::{Acts, Coordinate, Element, Stop};
use crate::system::interfaces::known;
use crate::system::rigid_bodies::check;
use crate::system::{BodyId, Signal, SystemError};

/// A coordinate of a body relative to another, or to the ground: what springs, motors, friction and limits act along.
#[derive(Debug, Clone, Copy)]
pub struct SpatialRelative<T: Scalar>(Relation<T>);

impl<T: Scalar> SpatialRelative<T> {
    /// Its value in configuration q (m or rad).
    pub fn value(&self, q: &[T]) -> T {
        self.0.value(q)
    }
}

/// A body and another, or the ground.
pub type Bodies = (BodyId, Option<BodyId>);

/// Two bodies as they stand, and what they are called in errors.
pub(super) struct Ends<T: Scalar> {
    pub(super) bodies: [Option<usize>; 2],
    pub(super) poses: [Pose<T>; 2],
}

impl<T: Scalar> Ends<T> {
    fn side(&self, which: usize, point: &Vector3<T>) -> Side<T> {
        let pose = &self.poses[which];
        Side { body: self.bodies[which], point: pose.turn_back(&(point - pose.position())) }
    }

    /// Both sides at one point.
    pub(super) fn at(&self, point: &Vector3<T>) -> [Side<T>; 2] {
        [self.side(0, point), self.side(1, point)]
    }

    /// Directions along and across an axis of any length, in the frame of one body.
    pub(super) fn axes(&self, which: usize, axis: &Vector3<T>) -> [Vector3<T>; 3] {
        let axes = frame(&axis.normalize());
        [0, 1, 2].map(|k| self.poses[which].turn_back(&axes.column(k).into_owned()))
    }
}

impl<T: Scalar> SpatialBodiesBuilder<T> {
    pub(super) fn ends(&self, label: &str, (body, other): Bodies, q: &[T]) -> Result<Ends<T>, SystemError> {
        let count = self.bodies.len();
        let expected = COORDINATES * count;
        if q.len() < expected {
            let what = "the configuration that a joint is drawn in";
            return Err(SystemError::Size { what, expected, given: q.len() });
        }
        let body = known("body", body.index(), count)?;
        let other = other.and_then(index).map(|other| known("body", other, count)).transpose()?;
        if other == Some(body) {
            let body = self.bodies[body].0.clone();
            return Err(SystemError::OneBody { what: format!("`{label}`"), body });
        }
        let bodies = [Some(body), other];
        Ok(Ends { bodies, poses: bodies.map(|body| body_pose(body, q)) })
    }

    fn point(label: &str, point: [T; 3]) -> Result<Vector3<T>, SystemError> {
        check(|| format!("point of `{label}`"), &point, |_| true, "finite")?;
        Ok(point.into())
    }

    pub(super) fn axis(label: &str, axis: [T; 3]) -> Result<Vector3<T>, SystemError> {
        let axis = Vector3::from(axis);
        let range = "finite and > 0";
        check(|| format!("length of the axis of `{label}`"), &[axis.norm()], |x| x > T::zero(), range)?;
        Ok(axis)
    }

    pub(super) fn act(&mut self, label: &str, sides: [Side<T>; 2], kind: Kind<T>, acts: Acts<T>) {
        self.elements.push(Element { label: label.into(), measure: Relation { sides, kind }, acts });
    }

    pub(super) fn hold(
        &mut self,
        label: &str,
        sides: [Side<T>; 2],
        kinds: impl IntoIterator<Item = Kind<T>>,
    ) {
        for kind in kinds {
            self.act(label, sides, kind, Acts::Holds { at: T::zero() });
        }
    }

    /// Holds a point of a body, `point` of the fixed frame (m) in the configuration `q` of the bodies defined so far, on the
    /// same point of the other or of the ground: three bilateral rows.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`], [`SystemError::OneBody`], [`SystemError::Size`].
    pub fn ball(&mut self, label: &str, bodies: Bodies, point: [T; 3], q: &[T]) -> Result<(), SystemError> {
        let sides = self.ends(label, bodies, q)?.at(&Self::point(label, point)?);
        self.hold(label, sides, (0..3).map(Kind::Offset));
        Ok(())
    }

    /// As [`ball`](Self::ball), and holds the axis through the point, of any length: five rows. What is free is the angle
    /// (rad) of the body about the axis against the other, from −π to π and 0 in the configuration `q`.
    ///
    /// # Errors
    /// As [`ball`](Self::ball).
    pub fn hinge(
        &mut self,
        label: &str,
        bodies: Bodies,
        (point, axis): ([T; 3], [T; 3]),
        q: &[T],
    ) -> Result<SpatialRelative<T>, SystemError> {
        let (point, axis) = (Self::point(label, point)?, Self::axis(label, axis)?);
        let ends = self.ends(label, bodies, q)?;
        let ([along, ..], [_, one, two]) = (ends.axes(0, &axis), ends.axes(1, &axis));
        let sides = ends.at(&point);
        self.hold(label, sides, (0..3).map(Kind::Offset));
        self.hold(label, sides, [Kind::Product(along, one), Kind::Product(along, two)]);
        self.angle(label, bodies, axis.into(), q)
    }

    /// Lets a body move along an axis, of any length, in the frame of the other, without turning against it: five rows. What
    /// is free is the way (m) along the axis, 0 in the configuration `q`.
    ///
    /// # Errors
    /// As [`ball`](Self::ball).
    pub fn slider(
        &mut self,
        label: &str,
        bodies: Bodies,
        (point, axis): ([T; 3], [T; 3]),
        q: &[T],
    ) -> Result<SpatialRelative<T>, SystemError> {
        let ends = self.ends(label, bodies, q)?;
        let sides = ends.at(&Self::point(label, point)?);
        let [along, one, two] = ends.axes(1, &Self::axis(label, axis)?);
        self.hold(label, sides, [Kind::Along(one), Kind::Along(two)]);
        self.hold_orientation(label, &ends, sides);
        Ok(SpatialRelative(Relation { sides, kind: Kind::Along(along) }))
    }

    /// Holds a body on another, or on the ground, as both stand: six rows.
    ///
    /// # Errors
    /// As [`ball`](Self::ball).
    pub fn weld(&mut self, label: &str, bodies: Bodies, q: &[T]) -> Result<(), SystemError> {
        let ends = self.ends(label, bodies, q)?;
        let middle = match ends.bodies[1] {
            Some(_) => (ends.poses[0].position() + ends.poses[1].position()) / (T::one() + T::one()),
            None => *ends.poses[0].position(),
        };
        let sides = ends.at(&middle);
        self.hold(label, sides, (0..3).map(Kind::Offset));
        self.hold_orientation(label, &ends, sides);
        Ok(())
    }

    pub(super) fn hold_orientation(&mut self, label: &str, ends: &Ends<T>, sides: [Side<T>; 2]) {
        let [[x, _, z], [on_x, on_y, _]] = [0, 1].map(|which| ends.axes(which, &Vector3::x()));
        let kinds = [Kind::Product(z, on_x), Kind::Product(z, on_y), Kind::Product(x, on_y)];
        self.hold(label, sides, kinds);
    }

    /// A rod without mass: holds the distance of a point of the body from one of the other, both (m) in the fixed frame and
    /// the configuration `q`. One row.
    ///
    /// # Errors
    /// As [`ball`](Self::ball), and [`SystemError::OutOfRange`] where the points coincide.
    pub fn rod(
        &mut self,
        label: &str,
        bodies: Bodies,
        points: [[T; 3]; 2],
        q: &[T],
    ) -> Result<(), SystemError> {
        let SpatialRelative(measure) = self.distance(label, bodies, points, q)?;
        let at = measure.value(q);
        check(|| format!("length of `{label}`"), &[at], |x| x > T::zero(), "finite and > 0")?;
        self.elements.push(Element { label: label.into(), measure, acts: Acts::Holds { at } });
        Ok(())
    }

    /// The distance (m) of a point of the body from one of the other, both in the fixed frame and the configuration `q`. Where
    /// they coincide it has no direction, and nothing acts.
    ///
    /// # Errors
    /// As [`ball`](Self::ball).
    pub fn distance(
        &self,
        label: &str,
        bodies: Bodies,
        points: [[T; 3]; 2],
        q: &[T],
    ) -> Result<SpatialRelative<T>, SystemError> {
        let ends = self.ends(label, bodies, q)?;
        let [one, other] = [Self::point(label, points[0])?, Self::point(label, points[1])?];
        let sides = [ends.side(0, &one), ends.side(1, &other)];
        Ok(SpatialRelative(Relation { sides, kind: Kind::Distance }))
    }

    /// The offset (m) of a point of the body from one of the other, both (m) in the fixed frame and the configuration `q`, along
    /// an axis (of any length) that goes with the other.
    ///
    /// # Errors
    /// As [`ball`](Self::ball).
    pub fn offset(
        &self,
        label: &str,
        bodies: Bodies,
        (points, axis): ([[T; 3]; 2], [T; 3]),
        q: &[T],
    ) -> Result<SpatialRelative<T>, SystemError> {
        let axis = Self::axis(label, axis)?;
        let ends = self.ends(label, bodies, q)?;
        let SpatialRelative(relation) = self.distance(label, bodies, points, q)?;
        let [along, ..] = ends.axes(1, &axis);
        Ok(SpatialRelative(Relation { kind: Kind::Along(along), ..relation }))
    }

    /// The angle (rad, from −π to π) by which a body has turned against another about an axis (of any length) that goes with the
    /// other, 0 in the configuration `q`.
    ///
    /// # Errors
    /// As [`ball`](Self::ball).
    pub fn angle(
        &self,
        label: &str,
        bodies: Bodies,
        axis: [T; 3],
        q: &[T],
    ) -> Result<SpatialRelative<T>, SystemError> {
        let axis = Self::axis(label, axis)?;
        let ends = self.ends(label, bodies, q)?;
        let ([_, of, _], [_, zero, quarter]) = (ends.axes(0, &axis), ends.axes(1, &axis));
        let sides = ends.bodies.map(|body| Side { body, point: Vector3::zeros() });
        Ok(SpatialRelative(Relation { sides, kind: Kind::Angle { of, zero, quarter } }))
    }

    /// A spring of stiffness k ≥ 0 (N/m or N m/rad), without force where the coordinate is `rest`, with a damper c ≥ 0
    /// (N s/m or N m s) beside it. The work of the spring is the change of ½ k (x − rest)² for any θ, that of the damper
    /// −c ẋ² h.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], also where k and c are both 0.
    pub fn spring(
        &mut self,
        label: &str,
        relative: SpatialRelative<T>,
        constants: (T, T),
        rest: T,
    ) -> Result<(), SystemError> {
        let acts = Acts::springs(label, constants, rest)?;
        self.along(label, relative, acts);
        Ok(())
    }

    pub(super) fn along(&mut self, label: &str, SpatialRelative(measure): SpatialRelative<T>, acts: Acts<T>) {
        self.elements.push(Element { label: label.into(), measure, acts });
    }

    /// A motor that moves the coordinate at a speed (m/s or rad/s) times a signal, with a force of at most `most`
    /// (N or N m, unlimited where absent).
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`].
    pub fn drive(
        &mut self,
        label: &str,
        relative: SpatialRelative<T>,
        motor: (T, Option<T>),
        signal: Signal<T>,
    ) -> Result<(), SystemError> {
        let acts = Acts::drives(label, motor, signal)?;
        self.along(label, relative, acts);
        Ok(())
    }

    /// A motor that acts along the coordinate with a force (N or N m) times a signal.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`].
    pub fn push(
        &mut self,
        label: &str,
        relative: SpatialRelative<T>,
        force: T,
        signal: Signal<T>,
    ) -> Result<(), SystemError> {
        let acts = Acts::pushes(label, force, signal)?;
        self.along(label, relative, acts);
        Ok(())
    }

    /// Dry friction along the coordinate, of at most `most` ≥ 0 (N or N m).
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`].
    pub fn rub(&mut self, label: &str, relative: SpatialRelative<T>, most: T) -> Result<(), SystemError> {
        let acts = Acts::rubs(label, most)?;
        self.along(label, relative, acts);
        Ok(())
    }

    /// Keeps the coordinate between two limits, each a unilateral contact without tangent under the law of the interface
    /// returned.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`].
    pub fn limit(
        &mut self,
        label: &str,
        SpatialRelative(measure): SpatialRelative<T>,
        limits: [T; 2],
    ) -> Result<usize, SystemError> {
        let group = self.group();
        let interface = self.interface(group, group)?;
        self.stops.extend(Stop::pair(label, measure, limits, interface)?);
        Ok(interface)
    }
}
