//! Adding what acts between two bodies, every number checked where it enters.

use nalgebra::Vector2;

use super::body::{BodyId, check};
use super::builder::RigidBodiesBuilder;
use super::measure::Measure;
use crate::scalar::Scalar;
use crate::system::element::{Acts, Coordinate, Element, Stop};
use crate::system::{Signal, SystemError};

/// A coordinate of a body relative to another, or to the ground: what springs, motors, friction and limits act along.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Relative<T> {
    /// Distance (m) of two points. Where they coincide it has no direction, and nothing acts.
    Distance {
        /// Point of the body in its frame (m).
        at: [T; 2],
        /// Point of the other in its frame, or of the ground (m).
        on: [T; 2],
    },
    /// Offset (m) of the first point from the second along an axis.
    Along {
        /// Point of the body in its frame (m).
        at: [T; 2],
        /// Point of the other in its frame, or of the ground (m).
        on: [T; 2],
        /// Direction in the frame of the other, of any length > 0.
        axis: [T; 2],
    },
    /// Angle (rad) of the body less that of the other.
    Angle,
}

impl<T: Scalar> RigidBodiesBuilder<T> {
    fn measure(
        &self,
        label: &str,
        (body, other): (BodyId, Option<BodyId>),
        relative: Relative<T>,
    ) -> Result<Measure<T>, SystemError> {
        let (at, on) = match relative {
            Relative::Distance { at, on } | Relative::Along { at, on, .. } => (at, on),
            Relative::Angle => ([T::zero(); 2], [T::zero(); 2]),
        };
        let (a, b) = self.connected(&format!("`{label}`"), (body, at), (other, on))?;
        check(|| format!("point of `{label}`"), &[at[0], at[1], on[0], on[1]], |_| true, "finite")?;
        Ok(match relative {
            Relative::Distance { .. } => Measure::Distance(a, b),
            Relative::Angle => Measure::Angle(a, b),
            Relative::Along { axis, .. } => {
                let axis = Vector2::from(axis);
                let length = [axis.norm()];
                let range = "finite and > 0";
                check(|| format!("length of the axis of `{label}`"), &length, |x| x > T::zero(), range)?;
                Measure::Along(a, b, axis / length[0])
            }
        })
    }

    fn element(
        &mut self,
        label: &str,
        bodies: (BodyId, Option<BodyId>),
        relative: Relative<T>,
        acts: Acts<T>,
    ) -> Result<(), SystemError> {
        let measure = self.measure(label, bodies, relative)?;
        self.elements.push(Element { label: label.into(), measure, acts });
        Ok(())
    }

    /// Lets the point `at` of `body` (m, in its frame) move along the line through the point `on` of `other`, or of the
    /// ground, in the direction `axis` of its frame: one bilateral row, and another one where the angle (rad) of `body` less
    /// that of `other` is held.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn slider(
        &mut self,
        label: &str,
        bodies: (BodyId, Option<BodyId>),
        (at, on): ([T; 2], [T; 2]),
        axis: [T; 2],
        angle: Option<T>,
    ) -> Result<(), SystemError> {
        let across = Relative::Along { at, on, axis: [-axis[1], axis[0]] };
        self.element(label, bodies, across, Acts::Holds { at: T::zero() })?;
        if let Some(at) = angle {
            check(|| format!("angle of joint `{label}`"), &[at], |_| true, "finite")?;
            self.element(label, bodies, Relative::Angle, Acts::Holds { at })?;
        }
        Ok(())
    }

    /// A spring of stiffness k ≥ 0 (N/m or N m/rad), without force where the coordinate is `rest`, with a damper c ≥ 0
    /// (N s/m or N m s) beside it. The work of the spring is the change of ½ k (x − rest)² for any θ, that of the damper
    /// −c ẋ² h.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], also where k and c are both 0; [`SystemError::Unknown`].
    pub fn spring_between(
        &mut self,
        label: &str,
        bodies: (BodyId, Option<BodyId>),
        relative: Relative<T>,
        constants: (T, T),
        rest: T,
    ) -> Result<(), SystemError> {
        self.element(label, bodies, relative, Acts::springs(label, constants, rest)?)
    }

    /// As [`spring_between`](Self::spring_between), without force in the configuration `q` of the bodies defined so far.
    ///
    /// # Errors
    /// As there, and [`SystemError::Size`].
    pub fn spring_from(
        &mut self,
        label: &str,
        bodies: (BodyId, Option<BodyId>),
        relative: Relative<T>,
        constants: (T, T),
        q: &[T],
    ) -> Result<(), SystemError> {
        let expected = 3 * self.bodies.len();
        if q.len() < expected {
            return Err(SystemError::Size {
                what: "the configuration of a spring",
                expected,
                given: q.len(),
            });
        }
        let rest = self.measure(label, bodies, relative)?.value(q);
        self.spring_between(label, bodies, relative, constants, rest)
    }

    /// A motor that moves the coordinate at a speed (m/s or rad/s) times a signal, with a force of at most `most`
    /// (N or N m, unlimited where absent).
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn drive(
        &mut self,
        label: &str,
        bodies: (BodyId, Option<BodyId>),
        relative: Relative<T>,
        motor: (T, Option<T>),
        signal: Signal<T>,
    ) -> Result<(), SystemError> {
        self.element(label, bodies, relative, Acts::drives(label, motor, signal)?)
    }

    /// A motor that acts along the coordinate with a force (N or N m) times a signal.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn push(
        &mut self,
        label: &str,
        bodies: (BodyId, Option<BodyId>),
        relative: Relative<T>,
        force: T,
        signal: Signal<T>,
    ) -> Result<(), SystemError> {
        self.element(label, bodies, relative, Acts::pushes(label, force, signal)?)
    }

    /// Dry friction along the coordinate, of at most `most` ≥ 0 (N or N m): what a clutch or a rusty pin does.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn rub(
        &mut self,
        label: &str,
        bodies: (BodyId, Option<BodyId>),
        relative: Relative<T>,
        most: T,
    ) -> Result<(), SystemError> {
        self.element(label, bodies, relative, Acts::rubs(label, most)?)
    }

    /// Keeps the coordinate between two limits, each a unilateral contact without tangent under the law of the interface
    /// returned.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn limit(
        &mut self,
        label: &str,
        bodies: (BodyId, Option<BodyId>),
        relative: Relative<T>,
        limits: [T; 2],
    ) -> Result<usize, SystemError> {
        let measure = self.measure(label, bodies, relative)?;
        let group = self.group();
        let interface = self.interface(group, group)?;
        self.stops.extend(Stop::pair(label, measure, limits, interface)?);
        Ok(interface)
    }
}
