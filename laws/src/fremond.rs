//! Frémond's impact law, the law Θ of the Moreau–Jean–Frémond scheme.

use std::ops::RangeInclusive;

use nalgebra::SVector;

use nonsmooth_core::laws::{
    Approach, ContactLaw, Description, FRICTION, LawError, LawFamily, RESTITUTION, Response, Rows, Scalar,
};

/// Frémond law: −Θ(u_{k+θ}) ∈ N_K(p) with Θ(u) = u + ((θ(1+e) − 1) u_{N,k} + μ‖u_T‖, 0, 0)   (64).
///
/// γ = θ and s = ((θ(1+e) − 1) u_{N,k}, 0), that is, after division by θ, Newton's law with a tangential
/// restitution e* = (1−θ)/θ: δ = (e u_{N,k}, e* u_{T,k}). Proposition 1 (77–78) proves
/// E_{k+1} − E_k ≤ W_ext + W_damp for ½ ≤ θ ≤ 1/(1+e).
///
/// For a closed contact that separates (u_{N,k} > 0) the law takes e* in place of e, s = 0: the contact may not
/// close during the step, with no normal work, and the guarantee then holds for any active set. Under the
/// paper's active set (55) such a contact does not occur.
///
/// In persistent stick at θ = ½ the law makes u_T alternate, u_{T,k+1} = −u_{T,k}; for θ > ½ the alternation
/// decays like e*ᵏ. θ = 1 gives Newton's law back (75–76).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fremond<T> {
    restitution: T,
    friction: T,
}

impl<T: Scalar> Fremond<T> {
    /// The law with restitution e ∈ [0, 1] and friction μ ≥ 0.
    ///
    /// # Errors
    /// [`LawError::OutOfRange`] with the value refused.
    pub fn new(restitution: T, friction: T) -> Result<Self, LawError> {
        Self::try_new(&[restitution, friction])
    }
}

impl<T: Scalar> LawFamily<T> for Fremond<T> {
    const DESCRIPTION: Description = Description {
        name: "fremond",
        title: "Frémond impact with Coulomb friction (Θ of the Moreau–Jean–Frémond scheme)",
        equation: "û = θ u⁺ + (1−θ) u⁻ + (θ(1+e) − 1) u_N⁻ e_N",
        claim: "½ ≤ θ ≤ 1/(1+e)",
        reference: "Frémond (2002), doi:10.1007/978-3-662-04800-9; Acary & Collins-Craft (2024), eq. (64)",
        parameters: &[RESTITUTION, FRICTION],
    };

    fn from_values(values: &[T]) -> Self {
        Self { restitution: values[0], friction: values[1] }
    }
}

impl<T: Scalar, const D: usize> ContactLaw<T, D> for Fremond<T> {
    fn name(&self) -> &str {
        Self::DESCRIPTION.name
    }

    fn respond(&self, at: &Approach<T, D>) -> Response<T, D> {
        if at.lasting {
            return Response::lasting(at, self.friction);
        }
        let mut shift = SVector::zeros();
        if at.before[0] <= T::zero() {
            shift[0] = (at.theta * (T::one() + self.restitution) - T::one()) * at.before[0];
        }
        Response::new(at.theta, shift, self.friction)
    }

    fn rows(&self) -> Rows {
        Rows::rubbing(self.friction)
    }

    fn dissipative_theta(&self) -> Option<RangeInclusive<T>> {
        Some(nalgebra::convert(0.5)..=(T::one() / (T::one() + self.restitution)))
    }

    fn lasting_theta(&self) -> Option<RangeInclusive<T>> {
        Some(nalgebra::convert(0.5)..=T::one())
    }
}
