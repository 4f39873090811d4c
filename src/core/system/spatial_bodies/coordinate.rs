//! Coordinates of one body relative to another in space: offsets, distances, products of directions, angles.
//!
//! Each is a number x(q) with a row Ḡ(q, s) that is its discrete derivative along q ⊕ s, x(q ⊕ s) − x(q) = Ḡ(q, s) s exactly.
//! A body goes from (x₀, R₀) to x₁ = x₀ + s_x and R₁ = R₀ cay(A), A = [s_ω]×. Since R₁ − R₀ = R̄A with
//! R̄ = ½ (R₀ + R₁) = R₀ (1 − A/2)⁻¹ and A s_ω = 0, a vector b of the body changes by
//!
//! ```text
//!   R₁b − R₀b = (R₀ s_ω) × R̄b                                                                          (1)
//! ```
//!
//! and products by the mean of one factor times the change of the other. A row of the coordinate is then a system of forces f
//! and torques t in the fixed frame, of sum and moment zero, which acts on s_ω by R₀ᵀ t; it is given the columns
//!
//! ```text
//!   f for ẋ,     (1 − A/2) R₀ᵀ t for ω
//! ```
//!
//! which is the same along s, as A s_ω = 0, and makes the angular momentum R J ω grow by exactly t: with the gyroscopic
//! torque of the step, J (ω₁ − ω₀) + h ω_½ × J ω_½ = (1 − A/2) R₀ᵀ t ⇔ R₁Jω₁ − R₀Jω₀ = t for θ = ½. Joints, springs and
//! motors thus keep energy and momentum alike. In the derivative of x at the end of the step, ∂x(q ⊕ s)/∂s, the columns
//! for ω are those divided by 1 + |s_ω|²/4.

use nalgebra::{Matrix3, Vector3};

use super::flight::turned;
use super::shape::{COORDINATES, DOFS, body_pose, parts};
use crate::scalar::{Scalar, lit};
use crate::system::element::Coordinate;

/// A turn along the step (rad) below which the rate of an angle is its difference to rounding.
const SMALL: f64 = 1e-6;

/// A point of a body in its principal frame (m), or of the ground.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side<T: Scalar> {
    pub(super) body: Option<usize>,
    pub(super) point: Vector3<T>,
}

/// What a coordinate is; directions of the first body, a, and of the second, b, are unit vectors of their frames.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind<T: Scalar> {
    /// Offset of a's point from b's along a fixed axis.
    Offset(usize),
    /// Offset of a's point from b's along a direction of b.
    Along(Vector3<T>),
    /// Product of a direction of a and one of b.
    Product(Vector3<T>, Vector3<T>),
    /// Distance of the points.
    Distance,
    /// Angle in (−π, π] from a direction of b to one of a, seen along an axis of b: `zero` and `quarter` are the directions
    /// of b at 0 and at π/2.
    Angle { of: Vector3<T>, zero: Vector3<T>, quarter: Vector3<T> },
}

/// A coordinate of body a relative to body b, or to the ground.
#[derive(Debug, Clone, Copy)]
pub(super) struct Relation<T: Scalar> {
    pub(super) sides: [Side<T>; 2],
    pub(super) kind: Kind<T>,
}

/// Where a body starts, where it ends, and what torques in the fixed frame do to its ω.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way<T: Scalar> {
    body: Option<usize>,
    places: [Vector3<T>; 2],
    turns: [Matrix3<T>; 2],
    pull: Matrix3<T>,
    /// s_ω, in the fixed frame.
    turn: Vector3<T>,
}

impl<T: Scalar> Way<T> {
    /// From q along s.
    pub(super) fn along(body: Option<usize>, q: &[T], s: &[T]) -> Self {
        let Some(of) = body else {
            let (zero, one) = (Vector3::zeros(), Matrix3::identity());
            return Self { body, places: [zero; 2], turns: [one; 2], pull: one, turn: zero };
        };
        let (x, orientation) = parts(&q[COORDINATES * of..]);
        let s = &s[DOFS * of..];
        let (shift, turn) = (Vector3::new(s[0], s[1], s[2]), Vector3::new(s[3], s[4], s[5]));
        let start = orientation.to_rotation_matrix().into_inner();
        let end = turned(&orientation, &turn).to_rotation_matrix().into_inner();
        let back = start.transpose();
        let pull = back - turn.cross_matrix() * back * lit::<T>(0.5);
        Self { body, places: [x, x + shift], turns: [start, end], pull, turn: start * turn }
    }

    /// At `end` = q ⊕ s, with the derivative by s.
    pub(super) fn at_end(body: Option<usize>, q: &[T], s: &[T], end: &[T]) -> Self {
        let way = Self::along(body, q, s);
        let Some(of) = body else { return way };
        let (x, orientation) = parts(&end[COORDINATES * of..]);
        let turns = [orientation.to_rotation_matrix().into_inner(); 2];
        let square = way.turn.norm_squared() * lit::<T>(0.25);
        Self { places: [x; 2], turns, pull: way.pull / (T::one() + square), turn: Vector3::zeros(), ..way }
    }

    fn point(&self, at: &Vector3<T>, end: usize) -> Vector3<T> {
        self.places[end] + self.turns[end] * at
    }

    /// R̄b.
    fn mean(&self, b: &Vector3<T>) -> Vector3<T> {
        (self.turns[0] * b + self.turns[1] * b) * lit::<T>(0.5)
    }

    /// The columns of a force and a torque.
    fn push(&self, force: &Vector3<T>, torque: &Vector3<T>, push: &mut impl FnMut(usize, T)) {
        let Some(body) = self.body else { return };
        let turning = self.pull * torque;
        (0..3).for_each(|k| push(DOFS * body + k, force[k]));
        (0..3).for_each(|k| push(DOFS * body + 3 + k, turning[k]));
    }
}

impl<T: Scalar> Relation<T> {
    /// The row between two ways; columns go up.
    pub(super) fn between(&self, ways: [&Way<T>; 2], mut push: impl FnMut(usize, T)) {
        let half = lit::<T>(0.5);
        let ([a, b], [one, other]) = (ways, &self.sides);
        let offset = |end: usize| a.point(&one.point, end) - b.point(&other.point, end);
        // A force f on a, at its point, and −f on b at the arm.
        let pull = |force: Vector3<T>, arm: &Vector3<T>| {
            [(force, a.mean(&one.point).cross(&force)), (-force, force.cross(arm))]
        };
        let twist = |torque: Vector3<T>| [(Vector3::zeros(), torque), (Vector3::zeros(), -torque)];
        let wrenches = match &self.kind {
            Kind::Offset(axis) => pull(Vector3::ith(*axis, T::one()), &b.mean(&other.point)),
            Kind::Along(axis) => {
                // b's own turn moves the axis at the mean offset.
                let arm = b.mean(&other.point) + (offset(0) + offset(1)) * half;
                pull(b.mean(axis), &arm)
            }
            Kind::Distance => {
                let (before, after) = (offset(0), offset(1));
                let sum = before.norm() + after.norm();
                // Where the points coincide there is no direction, and nothing acts.
                let normal = if sum > T::zero() { (before + after) / sum } else { Vector3::zeros() };
                pull(normal, &b.mean(&other.point))
            }
            Kind::Product(of, on) => twist(a.mean(of).cross(&b.mean(on))),
            Kind::Angle { of, zero, quarter } => {
                let axis = b.mean(&zero.cross(quarter));
                // Both turns about the mean axis, against the angle itself.
                let rate = axis.dot(&(a.turn - b.turn));
                let small = lit::<T>(SMALL);
                let share = if nalgebra::ComplexField::abs(rate) > small {
                    let angle = |end: usize| angle(&(a.turns[end] * of), &b.turns[end], zero, quarter);
                    wrapped(angle(1) - angle(0)) / rate
                } else {
                    T::one()
                };
                twist(axis * share)
            }
        };
        let mut sides = [(a, wrenches[0]), (b, wrenches[1])];
        sides.sort_by_key(|(way, _)| way.body);
        for (way, (force, torque)) in sides {
            way.push(&force, &torque, &mut push);
        }
    }

    /// Adds the larger part of ∂(Ḡᵀλ)_i/∂s_i for a multiplier λ, what a turn does to the arm of a force f = λ ∂x/∂d:
    /// ½ (r_i f_i − r·f) along the axes of the body.
    pub(super) fn curvature(&self, [a, b]: [&Way<T>; 2], multiplier: T, out: &mut [T]) {
        let half = lit::<T>(0.5);
        let [one, other] = &self.sides;
        let force = match &self.kind {
            Kind::Offset(axis) => Vector3::ith(*axis, multiplier),
            Kind::Along(axis) => b.mean(axis) * multiplier,
            Kind::Distance => {
                let offset = |end: usize| a.point(&one.point, end) - b.point(&other.point, end);
                let mean = offset(0) + offset(1);
                let length = mean.norm();
                if length > T::zero() { mean * (multiplier / length) } else { return }
            }
            Kind::Product(..) | Kind::Angle { .. } => return,
        };
        for (way, arm, sign) in [(a, &one.point, half), (b, &other.point, -half)] {
            let Some(body) = way.body else { continue };
            let force = way.turns[1].transpose() * force;
            let along = arm.dot(&force);
            (0..3).for_each(|k| out[DOFS * body + 3 + k] += sign * (arm[k] * force[k] - along));
        }
    }
}

/// The angle of a direction in the frame `turn`, from `zero` towards `quarter`.
fn angle<T: Scalar>(of: &Vector3<T>, turn: &Matrix3<T>, zero: &Vector3<T>, quarter: &Vector3<T>) -> T {
    let at = |axis: &Vector3<T>| of.dot(&(turn * axis));
    nalgebra::RealField::atan2(at(quarter), at(zero))
}

/// An angle brought into [−π, π].
fn wrapped<T: Scalar>(angle: T) -> T {
    angle - T::two_pi() * nalgebra::ComplexField::round(angle / T::two_pi())
}

impl<T: Scalar> Coordinate<T> for Relation<T> {
    fn value(&self, q: &[T]) -> T {
        let [a, b] = self.sides.map(|side| body_pose(side.body, q));
        let offset = || a.place(&self.sides[0].point) - b.place(&self.sides[1].point);
        match &self.kind {
            Kind::Offset(axis) => offset()[*axis],
            Kind::Along(axis) => offset().dot(&b.turn(axis)),
            Kind::Product(of, on) => a.turn(of).dot(&b.turn(on)),
            Kind::Distance => offset().norm(),
            Kind::Angle { of, zero, quarter } => {
                let of = a.turn(of);
                nalgebra::RealField::atan2(of.dot(&b.turn(quarter)), of.dot(&b.turn(zero)))
            }
        }
    }

    fn difference(&self, from: T, to: T) -> T {
        match self.kind {
            Kind::Angle { .. } => wrapped(to - from),
            _ => to - from,
        }
    }

    fn row(&self, q: &[T], s: &[T], push: impl FnMut(usize, T)) {
        let [a, b] = self.sides.map(|side| Way::along(side.body, q, s));
        self.between([&a, &b], push);
    }
}
