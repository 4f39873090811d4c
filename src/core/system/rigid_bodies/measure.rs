//! Coordinates of one body relative to another: distances, offsets along an axis, angles.
//!
//! Each is a number x(q) with rows Ḡ(q, s) that are its discrete derivative, x(q + s) − x(q) = Ḡ(q, s) s, exactly. With
//! d = x_a + R(γ_a) ā − x_b − R(γ_b) b̄, whose own derivative over a step is that of a pin (`joint.rs`), d₀ and d₁ its values
//! at the ends of the step and n = R(γ_b) n̄ an axis of the second body,
//!
//! ```text
//!   |d₁| − |d₀|       = (d₁ + d₀)/(|d₁| + |d₀|) · (d₁ − d₀)
//!   n₁·d₁ − n₀·d₀     = ½ (n₀ + n₁) · (d₁ − d₀) + ½ (d₀ + d₁) · (n₁ − n₀)
//! ```
//!
//! so that a force with a potential in x changes the energy by exactly what the potential loses (Gonzalez 1996,
//! doi:10.1007/BF02440162).

use nalgebra::Vector2;

use super::side::Side;
use crate::scalar::{Scalar, lit};
use crate::system::element::Coordinate;

/// A coordinate of body a relative to body b, or to the ground.
#[derive(Debug, Clone, Copy)]
pub(super) enum Measure<T> {
    /// Distance of two points.
    Distance(Side<T>, Side<T>),
    /// Offset of the first point from the second along a unit vector in the frame of the second body.
    Along(Side<T>, Side<T>, Vector2<T>),
    /// Angle of the first body less that of the second.
    Angle(Side<T>, Side<T>),
}

fn across<T: Scalar>(x: &Vector2<T>) -> Vector2<T> {
    Vector2::new(-x.y, x.x)
}

impl<T: Scalar> Measure<T> {
    fn sides(&self) -> [&Side<T>; 2] {
        match self {
            Self::Distance(a, b) | Self::Along(a, b, _) | Self::Angle(a, b) => [a, b],
        }
    }
}

impl<T: Scalar> Coordinate<T> for Measure<T> {
    fn value(&self, q: &[T]) -> T {
        match self {
            Self::Distance(a, b) => (a.position(q) - b.position(q)).norm(),
            Self::Along(a, b, axis) => b.turned(axis, q).dot(&(a.position(q) - b.position(q))),
            Self::Angle(a, b) => a.angle(q) - b.angle(q),
        }
    }

    fn difference(&self, from: T, to: T) -> T {
        to - from
    }

    fn row(&self, q: &[T], s: &[T], mut push: impl FnMut(usize, T)) {
        let [a, b] = self.sides();
        if let Self::Angle(..) = self {
            a.body.into_iter().for_each(|body| push(3 * body + 2, T::one()));
            b.body.into_iter().for_each(|body| push(3 * body + 2, -T::one()));
            return;
        }
        let half = lit::<T>(0.5);
        let ((lever_a, shift_a, turn_a), (lever_b, shift_b, turn_b)) = (a.motion(q, s), b.motion(q, s));
        let before = a.position(q) - b.position(q);
        let change = shift_a + lever_a * turn_a - shift_b - lever_b * turn_b;
        let after = before + change;
        // What a turn of b does to the axis, at the mean offset.
        let mut swing = T::zero();
        let normal = match self {
            Self::Along(_, _, axis) => {
                let carried = Side { point: *axis, ..*b };
                let (rate, ..) = carried.motion(q, s);
                swing = rate.dot(&(before + after)) * half;
                let start = b.turned(axis, q);
                start + rate * (turn_b * half)
            }
            _ => {
                let sum = before.norm() + after.norm();
                if sum > T::zero() { (before + after) / sum } else { Vector2::zeros() }
            }
        };
        if let Some(body) = a.body {
            push(3 * body, normal.x);
            push(3 * body + 1, normal.y);
            push(3 * body + 2, normal.dot(&lever_a));
        }
        if let Some(body) = b.body {
            push(3 * body, -normal.x);
            push(3 * body + 1, -normal.y);
            push(3 * body + 2, swing - normal.dot(&lever_b));
        }
    }
}

impl<T: Scalar> Side<T> {
    /// A vector of the side's frame in the fixed frame.
    fn turned(&self, x: &Vector2<T>, q: &[T]) -> Vector2<T> {
        match self.body {
            None => *x,
            Some(_) => super::side::turned(x, self.angle(q)),
        }
    }

    /// What moves the point over a step: its displacement per turn, the shift of its body, and the turn.
    fn motion(&self, q: &[T], s: &[T]) -> (Vector2<T>, Vector2<T>, T) {
        let Some(body) = self.body else { return (Vector2::zeros(), Vector2::zeros(), T::zero()) };
        let i = 3 * body;
        let lever = across(&self.mean_arm(q[i + 2], s[i + 2]));
        (lever, Vector2::new(s[i], s[i + 1]), s[i + 2])
    }
}
