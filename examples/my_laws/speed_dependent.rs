//! Restitution that falls with the speed of the impact: steel on steel bounces less the harder it hits.

use std::ops::RangeInclusive;

use nalgebra::SVector;
use nonsmooth::laws::{
    Approach, ContactLaw, Description, FRICTION, LawFamily, Parameter, Response, Rows, Scalar,
};

/// Frémond's law with, in place of a constant e, the restitution
///
/// ```text
///   e(u_N) = c / (c + |u_N|)
/// ```
///
/// in which c is the speed at which e has fallen to ½. Frémond's proof of dissipation asks for e ≤ e* = (1−θ)/θ; at θ = ½
/// e* = 1 and e(u_N) ≤ 1 whatever the speed, so the proof holds there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpeedDependent<T> {
    half_speed: T,
    friction: T,
}

/// The speed c.
const HALF_SPEED: Parameter = Parameter {
    name: "half_speed",
    symbol: "c",
    meaning: "speed of the impact at which e = ½ (m/s)",
    min: 1e-12,
    max: f64::INFINITY,
    default: Some(1.0),
    draw: (0.1, 1.1),
};

impl<T: Scalar> LawFamily<T> for SpeedDependent<T> {
    const DESCRIPTION: Description = Description {
        name: "speed-dependent",
        title: "restitution that falls with the speed of the impact, with Coulomb friction",
        equation: "û = θ u⁺ + (1−θ) u⁻ + (θ(1+e) − 1) u_N⁻ e_N, e = c/(c + |u_N⁻|)",
        claim: "θ = ½",
        reference: "examples/my_laws",
        parameters: &[HALF_SPEED, FRICTION],
    };

    fn from_values(values: &[T]) -> Self {
        Self { half_speed: values[0], friction: values[1] }
    }
}

impl<T: Scalar, const D: usize> ContactLaw<T, D> for SpeedDependent<T> {
    fn name(&self) -> &str {
        Self::DESCRIPTION.name
    }

    fn respond(&self, at: &Approach<T, D>) -> Response<T, D> {
        if at.lasting {
            return Response::lasting(at, self.friction);
        }
        let mut shift = SVector::zeros();
        if at.before[0] <= T::zero() {
            let restitution = self.half_speed / (self.half_speed - at.before[0]);
            shift[0] = (at.theta * (T::one() + restitution) - T::one()) * at.before[0];
        }
        Response::new(at.theta, shift, self.friction)
    }

    fn rows(&self) -> Rows {
        Rows::rubbing(self.friction)
    }

    // e reaches 1 at rest, so of the interval [½, 1/(1+e)] only θ = ½ is left for every state.
    fn dissipative_theta(&self) -> Option<RangeInclusive<T>> {
        let half = nalgebra::convert(0.5);
        Some(half..=half)
    }

    // Contacts that last have no restitution to lose.
    fn lasting_theta(&self) -> Option<RangeInclusive<T>> {
        Some(nalgebra::convert(0.5)..=T::one())
    }
}
