//! Moreau's law on the averaged velocity.

use std::ops::RangeInclusive;

use nalgebra::SVector;

use nonsmooth_core::laws::{
    Approach, ContactLaw, Description, FRICTION, LawError, LawFamily, Parameter, RESTITUTION, Response, Rows,
    Scalar,
};

const DISSIPATION_INDEX: Parameter =
    Parameter { symbol: "ρ", meaning: "restitution of all components (dimensionless)", ..RESTITUTION };

/// Moreau's averaged-velocity law: the Coulomb inclusion at û = (u_{k+1} + ρ u_k)/(1 + ρ).
///
/// γ = 1/(1+ρ) and s = 0, so δ = ρ u_k: the same restitution ρ for the normal and the tangential velocity. The
/// contact work is û·p at θ = 1/(1+ρ), the one θ at which dissipation is proved; Frémond's law at that θ with
/// e = ρ is this law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MoreauAveraged<T> {
    restitution: T,
    friction: T,
}

impl<T: Scalar> MoreauAveraged<T> {
    /// The law with restitution ρ ∈ [0, 1] and friction μ ≥ 0.
    ///
    /// # Errors
    /// [`LawError::OutOfRange`] with the value refused.
    pub fn new(restitution: T, friction: T) -> Result<Self, LawError> {
        Self::try_new(&[restitution, friction])
    }
}

impl<T: Scalar> LawFamily<T> for MoreauAveraged<T> {
    const DESCRIPTION: Description = Description {
        name: "moreau",
        title: "Moreau's averaged-velocity law with Coulomb friction",
        equation: "û = (u⁺ + ρ u⁻)/(1 + ρ)",
        claim: "θ = 1/(1+ρ)",
        reference: "Moreau (1988), doi:10.1007/978-3-7091-2624-0_1",
        parameters: &[DISSIPATION_INDEX, FRICTION],
    };

    fn from_values(values: &[T]) -> Self {
        Self { restitution: values[0], friction: values[1] }
    }
}

impl<T: Scalar, const D: usize> ContactLaw<T, D> for MoreauAveraged<T> {
    fn name(&self) -> &str {
        Self::DESCRIPTION.name
    }

    fn respond(&self, at: &Approach<T, D>) -> Response<T, D> {
        if at.lasting {
            return Response::lasting(at, self.friction);
        }
        Response::new(T::one() / (T::one() + self.restitution), SVector::zeros(), self.friction)
    }

    fn rows(&self) -> Rows {
        Rows::rubbing(self.friction)
    }

    fn dissipative_theta(&self) -> Option<RangeInclusive<T>> {
        let theta = T::one() / (T::one() + self.restitution);
        Some(theta..=theta)
    }

    fn lasting_theta(&self) -> Option<RangeInclusive<T>> {
        Some(nalgebra::convert(0.5)..=T::one())
    }
}
