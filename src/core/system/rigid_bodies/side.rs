//! A point of a body, as joints and springs hold it, and its mean lever arm over a step.

use nalgebra::Vector2;

use crate::scalar::{Scalar, lit};

/// A point of a body, or of the ground.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side<T> {
    pub(super) body: Option<usize>,
    pub(super) point: Vector2<T>,
}

/// R(γ) x.
pub(super) fn turned<T: Scalar>(x: &Vector2<T>, angle: T) -> Vector2<T> {
    let (sin, cos) = nalgebra::ComplexField::sin_cos(angle);
    Vector2::new(cos * x.x - sin * x.y, sin * x.x + cos * x.y)
}

impl<T: Scalar> Side<T> {
    pub(super) fn position(&self, q: &[T]) -> Vector2<T> {
        match self.body {
            None => self.point,
            Some(body) => Vector2::new(q[3 * body], q[3 * body + 1]) + turned(&self.point, q[3 * body + 2]),
        }
    }

    pub(super) fn angle(&self, q: &[T]) -> T {
        self.body.map_or_else(T::zero, |body| q[3 * body + 2])
    }

    /// The mean lever arm over a turn from γ to γ + `turn`.
    pub(super) fn mean_arm(&self, angle: T, turn: T) -> Vector2<T> {
        let half = turn * lit::<T>(0.5);
        let middle = turned(&self.point, angle + half);
        // sin x / x = 1 − x²/6 + …: below √ε the quotient is 1 to rounding.
        let tiny = nalgebra::ComplexField::abs(half) <= lit(1e-9);
        if tiny { middle } else { middle * (nalgebra::ComplexField::sin(half) / half) }
    }

    /// Derivative of the mean lever arm with respect to the turn.
    pub(super) fn mean_arm_rate(&self, angle: T, turn: T) -> Vector2<T> {
        let half = turn * lit::<T>(0.5);
        let middle = turned(&self.point, angle + half);
        let across = Vector2::new(-middle.y, middle.x);
        let (sin, cos) = nalgebra::ComplexField::sin_cos(half);
        // (cos x − sin x / x)/x = −x/3 + x³/30 − …: the quotient cancels where x is small.
        let small = nalgebra::ComplexField::abs(half) <= lit(1e-2);
        let (sinc, slope) = if small {
            let square = half * half;
            (T::one() - square / lit::<T>(6.0), half * (square / lit::<T>(10.0) - T::one()) / lit::<T>(3.0))
        } else {
            (sin / half, (cos - sin / half) / half)
        };
        (middle * slope + across * sinc) * lit::<T>(0.5)
    }
}
