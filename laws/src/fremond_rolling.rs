//! Frémond's law with resistance against rolling and spinning.

use std::ops::RangeInclusive;

use nalgebra::SVector;

use nonsmooth_core::laws::{
    Approach, Cone, ContactLaw, Description, FRICTION, LawError, LawFamily, Parameter, RESTITUTION, Response,
    Rows, Scalar,
};

const ROLLING: Parameter = Parameter {
    name: "rolling",
    symbol: "μ_R",
    meaning: "coefficient of rolling resistance (m)",
    min: 0.0,
    max: f64::INFINITY,
    default: Some(0.0),
    draw: (0.0, 1.0),
};

const SPINNING: Parameter = Parameter {
    name: "spinning",
    symbol: "μ_S",
    meaning: "coefficient of spinning resistance, in space (m)",
    min: 0.0,
    max: f64::INFINITY,
    default: Some(0.0),
    draw: (0.0, 1.0),
};

/// Frémond's normal law in the cone ‖p_T‖ ≤ μ p_N, ‖m_R‖ ≤ μ_R p_N, |m_S| ≤ μ_S p_N: a moment resists rolling as friction
/// resists slip.
///
/// The inclusion is written at the same û = u_{k+θ} + (θ(1+e) − 1) u_{N,k} e_N, whose components now include the relative
/// angular velocity ω, so that
///
/// ```text
///   û·p = −p_N (μ‖û_T‖ + μ_R‖ω̂_R‖ + μ_S|ω̂_S|) ≤ 0
/// ```
///
/// for any state, and the law dissipates where [Frémond's](crate::Fremond) does, ½ ≤ θ ≤ 1/(1+e). A disc that rolls on a plane
/// slows down by (2/3) g μ_R/R and then stands still; on a slope it holds while tan a ≤ μ_R/R.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FremondRolling<T> {
    restitution: T,
    friction: T,
    rolling: T,
    spinning: T,
}

impl<T: Scalar> FremondRolling<T> {
    /// The law with restitution e ∈ [0, 1], friction μ ≥ 0, rolling resistance μ_R ≥ 0 (m) and spinning resistance
    /// μ_S ≥ 0 (m).
    ///
    /// # Errors
    /// [`LawError::OutOfRange`] with the value refused.
    pub fn new(restitution: T, friction: T, rolling: T, spinning: T) -> Result<Self, LawError> {
        Self::try_new(&[restitution, friction, rolling, spinning])
    }

    fn cone(&self) -> Cone<T> {
        Cone::Rolling { friction: self.friction, rolling: self.rolling, spinning: self.spinning }
    }
}

impl<T: Scalar> LawFamily<T> for FremondRolling<T> {
    const DESCRIPTION: Description = Description {
        name: "fremond-rolling",
        title: "Frémond impact with Coulomb friction and rolling resistance",
        equation: "û = θ u⁺ + (1−θ) u⁻ + (θ(1+e) − 1) u_N⁻ e_N, ‖m_R‖ ≤ μ_R p_N, |m_S| ≤ μ_S p_N",
        claim: "½ ≤ θ ≤ 1/(1+e)",
        reference: "Tasora & Anitescu (2013), doi:10.1007/s11012-013-9694-y",
        parameters: &[RESTITUTION, FRICTION, ROLLING, SPINNING],
    };

    fn from_values(values: &[T]) -> Self {
        Self { restitution: values[0], friction: values[1], rolling: values[2], spinning: values[3] }
    }
}

impl<T: Scalar, const D: usize> ContactLaw<T, D> for FremondRolling<T> {
    fn name(&self) -> &str {
        Self::DESCRIPTION.name
    }

    fn respond(&self, at: &Approach<T, D>) -> Response<T, D> {
        if at.lasting {
            return Response::lasting(at, self.cone());
        }
        let mut shift = SVector::zeros();
        if at.before[0] <= T::zero() {
            shift[0] = (at.theta * (T::one() + self.restitution) - T::one()) * at.before[0];
        }
        Response::new(at.theta, shift, self.cone())
    }

    fn rows(&self) -> Rows {
        let rolls = self.rolling > T::zero() || self.spinning > T::zero();
        if rolls { Rows::Rolling } else { Rows::rubbing(self.friction) }
    }

    fn dissipative_theta(&self) -> Option<RangeInclusive<T>> {
        Some(nalgebra::convert(0.5)..=(T::one() / (T::one() + self.restitution)))
    }

    fn lasting_theta(&self) -> Option<RangeInclusive<T>> {
        Some(nalgebra::convert(0.5)..=T::one())
    }
}
