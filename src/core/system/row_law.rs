//! What holds a row of the joints.

use crate::scalar::Scalar;

/// What holds a row φ of the [joints](super::Joints) over a step of length h, with Δ = φ(q_{k+1}) − φ(q_k) and the percussion λ
/// that acts along Ḡᵀ.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum RowLaw<T> {
    /// φ stays where it was: Δ = 0, and λ does no work.
    Held,
    /// A spring and a damper, λ = −h k (x + ½ Δ) − c Δ: the spring loses ½ k (x + Δ)² − ½ k x², whatever θ.
    Spring {
        /// k ≥ 0 (N/m or N m/rad); k and c are not both 0.
        stiffness: T,
        /// c ≥ 0 (N s/m or N m s).
        damping: T,
        /// x, how far the spring is stretched at the start of the step (m or rad).
        stretch: T,
    },
    /// A motor: the coordinate has the speed `rate` at the end of the step, Δ = h ((1−θ) ẋ_k + θ rate), as long as
    /// |λ| ≤ h · most, else |λ| = h · most against the motion relative to the rate. Dry friction where the rate is 0 and `most`
    /// is given: Δ = 0, which dissipates for any θ.
    Driven {
        /// Speed (m/s or rad/s).
        rate: T,
        /// Largest force (N or N m), unlimited where absent.
        most: Option<T>,
    },
    /// λ = h · force.
    Given {
        /// Force (N or N m).
        force: T,
    },
}

impl<T: Scalar> RowLaw<T> {
    /// The mean speed Δ/h that a driven row asks for, from its speed at the start of the step; `None` for other rows.
    pub(crate) fn way(&self, start: T, theta: T) -> Option<T> {
        match *self {
            Self::Driven { rate, most: Some(_) } if rate == T::zero() => Some(rate),
            Self::Driven { rate, .. } => Some((T::one() - theta) * start + theta * rate),
            _ => None,
        }
    }
}
