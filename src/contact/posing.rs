//! From a law's answer to the terms of the cone problem, for everybody who asks a law: the step, the event-driven motion,
//! the suite.

use nalgebra::SVector;

use crate::laws::{Approach, ContactLaw, Response};
use crate::scalar::{Scalar, all_finite, to_f64};

/// A law's answer that no cone problem can be built with: γ must be positive, μ ≥ 0, all finite.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("law `{law}` gives γ = {gamma}, a normal shift of {shift} m/s and μ = {friction}")]
pub struct ImproperResponse {
    /// Name of the law.
    pub law: String,
    /// γ.
    pub gamma: f64,
    /// Normal component of the shift (m/s), or the first component that is not finite.
    pub shift: f64,
    /// μ.
    pub friction: f64,
}

/// (b, μ) of a contact in the cone problem w = W p + b: b = u_free + δ, δ = ((1−γ) u_k + s)/γ, with the answer of its law.
///
/// # Errors
/// [`ImproperResponse`] where the law gives no problem.
#[inline]
pub fn pose<T: Scalar, const D: usize>(
    law: &(impl ContactLaw<T, D> + ?Sized),
    at: &Approach<T, D>,
    free: &SVector<T, D>,
) -> Result<(SVector<T, D>, T), ImproperResponse> {
    let response = law.respond(at);
    let Response { gamma, shift, friction, .. } = &response;
    let valid = *gamma > T::zero() && *friction >= T::zero();
    if !(valid && all_finite([gamma, friction]) && all_finite(shift.iter())) {
        return Err(improper(law.name(), &response));
    }
    Ok((free + response.b_shift(&at.before), *friction))
}

#[cold]
fn improper<T: Scalar, const D: usize>(law: &str, response: &Response<T, D>) -> ImproperResponse {
    let shift = response.shift.iter().find(|x| !all_finite([*x])).unwrap_or(&response.shift[0]);
    ImproperResponse {
        law: law.into(),
        gamma: to_f64(response.gamma),
        shift: to_f64(*shift),
        friction: to_f64(response.friction),
    }
}
