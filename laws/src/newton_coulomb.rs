//! Newton's impact law with Coulomb friction, the law Γ of the Moreau–Jean scheme.

use std::ops::RangeInclusive;

use nalgebra::SVector;

use nonsmooth_core::laws::{
    Approach, ContactLaw, Description, FRICTION, LawError, LawFamily, RESTITUTION, Response, Rows, Scalar,
};

/// Newton–Coulomb law: −Γ(u_{k+1}) ∈ N_K(p) with Γ(u) = u + (e u_{N,k} + μ‖u_T‖, 0, 0)   (53).
///
/// γ = 1 and s = (e u_{N,k}, 0): restitution acts on the normal velocity alone. Kinematically simple, and the
/// reference of the field, but friction that changes the direction of slip within an impact can create energy
/// (Kane & Levinson 1985). Dissipation is proved only for e = 0 at θ = 1, where it is Frémond's law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewtonCoulomb<T> {
    restitution: T,
    friction: T,
}

impl<T: Scalar> NewtonCoulomb<T> {
    /// The law with restitution e ∈ [0, 1] and friction μ ≥ 0.
    ///
    /// # Errors
    /// [`LawError::OutOfRange`] with the value refused.
    pub fn new(restitution: T, friction: T) -> Result<Self, LawError> {
        Self::try_new(&[restitution, friction])
    }
}

impl<T: Scalar> LawFamily<T> for NewtonCoulomb<T> {
    const DESCRIPTION: Description = Description {
        name: "newton",
        title: "Newton impact with Coulomb friction (Γ of the Moreau–Jean scheme)",
        equation: "û = u⁺ + e u_N⁻ e_N",
        claim: "none; θ = 1 if e = 0",
        reference: "Jean (1999), doi:10.1016/S0045-7825(98)00383-1; Acary & Collins-Craft (2024), eq. (53)",
        parameters: &[RESTITUTION, FRICTION],
    };

    fn from_values(values: &[T]) -> Self {
        Self { restitution: values[0], friction: values[1] }
    }
}

impl<T: Scalar, const D: usize> ContactLaw<T, D> for NewtonCoulomb<T> {
    fn name(&self) -> &str {
        Self::DESCRIPTION.name
    }

    fn respond(&self, at: &Approach<T, D>) -> Response<T, D> {
        let mut shift = SVector::zeros();
        if at.lasting {
            // e* in place of e, and the tangent as ever: û = u⁺ + (e* u_N⁻ + (2θ−1) g⁺/(θh)) e_N.
            shift[0] = Response::lasting(at, self.friction).b_shift(&at.before)[0];
        } else {
            shift[0] = self.restitution * at.before[0];
        }
        Response::new(T::one(), shift, self.friction)
    }

    fn rows(&self) -> Rows {
        Rows::rubbing(self.friction)
    }

    fn dissipative_theta(&self) -> Option<RangeInclusive<T>> {
        (self.restitution == T::zero()).then(|| T::one()..=T::one())
    }

    fn lasting_theta(&self) -> Option<RangeInclusive<T>> {
        Some(T::one()..=T::one())
    }
}
