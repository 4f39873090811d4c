//! Bodies that move as told: rows that are driven whatever it takes.

use nalgebra::{Unit, UnitQuaternion, Vector3};

use super::builder::SpatialBodiesBuilder;
use super::coordinate::{Kind, Relation};
use super::shape::{parts, set_orientation};
use crate::scalar::{Scalar, lit};
use crate::system::element::{Acts, Coordinate};
use crate::system::interfaces::known;
use crate::system::rigid_bodies::check;
use crate::system::{BodyId, Signal, SystemError};

/// How a body moves that moves as told.
#[derive(Debug, Clone, PartialEq)]
pub struct SpatialMotion<T> {
    /// Displacements (m) along the fixed axes, each times its signal.
    pub displacements: Vec<([T; 3], Signal<T>)>,
    /// Axis through the centre of the body, of any length, along the fixed axes.
    pub axis: [T; 3],
    /// Angles (rad) about it, each times its signal.
    pub angles: Vec<(T, Signal<T>)>,
}

impl<T: Scalar> SpatialMotion<T> {
    /// Leads a body from where it stands without its motion, q (7 numbers), to where it is at time 0, and gives it the velocity
    /// v (6 numbers) it has there: means and differences over the step of length `step` around the start, as in the steps that
    /// follow.
    pub fn start(&self, step: T, q: &mut [T], v: &mut [T]) {
        let half = lit::<T>(0.5);
        let ends = |signal: &Signal<T>| [-half, half].map(|share| signal.at(share * step));
        v[..6].fill(T::zero());
        for (displacement, signal) in &self.displacements {
            let [before, after] = ends(signal);
            for k in 0..3 {
                q[k] += displacement[k] * (before + after) * half;
                v[k] += displacement[k] * (after - before) / step;
            }
        }
        let Some(axis) = Unit::try_new(Vector3::from(self.axis), T::zero()) else { return };
        let (mut angle, mut turn) = (T::zero(), T::zero());
        for (by, signal) in &self.angles {
            let [before, after] = ends(signal);
            angle += *by * (before + after) * half;
            turn += *by * (after - before);
        }
        // q ⊕ s turns by 2 atan(|s|/2); what turns too far for that in a step turns as it can.
        let reach = turn * half;
        let size = if nalgebra::ComplexField::abs(reach) < T::one() {
            nalgebra::ComplexField::tan(reach) * lit::<T>(2.0)
        } else {
            turn
        };
        let orientation = UnitQuaternion::from_axis_angle(&axis, angle) * parts(q).1;
        let spin = orientation.inverse() * (axis.into_inner() * (size / step));
        set_orientation(q, &orientation);
        v[3..6].copy_from_slice(spin.as_slice());
    }
}

impl<T: Scalar> SpatialBodiesBuilder<T> {
    /// Moves a body as told from where it would stand without its motion, in configuration `q`. Its reactions work in the
    /// balance as those of motors do, and its mass counts in the kinetic energy alone.
    ///
    /// # Errors
    /// As [`ball`](Self::ball).
    pub fn told(&mut self, body: BodyId, motion: &SpatialMotion<T>, q: &[T]) -> Result<(), SystemError> {
        let SpatialMotion { displacements, axis, angles } = motion;
        let body_index = known("body", body.index(), self.bodies.len())?;
        let label = format!("{}.motion", self.bodies[body_index].0);
        let bodies = (body, None);
        let ends = self.ends(&label, bodies, q)?;
        let sides = ends.at(ends.poses[0].position());
        for (displacement, signal) in displacements {
            signal.check()?;
            check(|| format!("displacement of `{label}`"), displacement, |_| true, "finite")?;
        }
        for (angle, signal) in angles {
            signal.check()?;
            check(|| format!("angle of `{label}`"), &[*angle], |_| true, "finite")?;
        }
        for axis in 0..3 {
            let of = |(by, signal): &([T; 3], Signal<T>)| (by[axis], signal.clone());
            let parts = displacements.iter().map(of).filter(|(by, _)| *by != T::zero()).collect();
            let kind = Kind::Offset(axis);
            let from = Relation { sides, kind }.value(q);
            self.act(&label, sides, kind, Acts::Moves { from, parts });
        }
        if angles.is_empty() {
            self.hold_orientation(&label, &ends, sides);
            return Ok(());
        }
        let axis = Self::axis(&label, *axis)?;
        let ([along, ..], [_, one, two]) = (ends.axes(0, &axis), ends.axes(1, &axis));
        self.hold(&label, sides, [Kind::Product(along, one), Kind::Product(along, two)]);
        let turns = self.angle(&label, bodies, axis.into(), q)?;
        self.along(&label, turns, Acts::Moves { from: T::zero(), parts: angles.clone() });
        Ok(())
    }
}
