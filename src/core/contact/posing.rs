//! From a law's answer to the terms of the cone problem, for everybody who asks a law: the step, the event-driven motion,
//! the suite.

use nalgebra::SVector;

use crate::laws::{Approach, Cone, ContactLaw, Response};
use crate::scalar::{Scalar, all_finite, to_f64};

/// A law's answer that no cone problem can be built with: γ must be positive, the coefficients of the cone ≥ 0, all finite.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "law `{law}` gives γ = {gamma}, a normal shift of {shift} m/s and μ = {}{}", coefficients[0],
    if coefficients[1..] == [0.0; 2] { String::new() }
    else { format!(", μ_R = {} m, μ_S = {} m", coefficients[1], coefficients[2]) }
)]
pub struct ImproperResponse {
    /// Name of the law.
    pub law: String,
    /// γ.
    pub gamma: f64,
    /// Normal component of the shift (m/s), or the first component that is not finite.
    pub shift: f64,
    /// μ, μ_R (m) and μ_S (m).
    pub coefficients: [f64; 3],
}

/// b and the cone of a contact in the cone problem w = W p + b: b = u_free + δ, δ = ((1−γ) u_k + s)/γ, with the answer of
/// its law.
///
/// # Errors
/// [`ImproperResponse`] where the law gives no problem.
#[inline]
pub fn pose<T: Scalar, const D: usize>(
    law: &(impl ContactLaw<T, D> + ?Sized),
    at: &Approach<'_, T, D>,
    free: &SVector<T, D>,
) -> Result<(SVector<T, D>, Cone<T>), ImproperResponse> {
    let response = law.respond(at);
    check(law.name(), &response)?;
    Ok((free + response.b_shift(&at.before), response.cone.on(at.rows)))
}

/// Whether a cone problem can be built with the answer of the law called `law`.
///
/// # Errors
/// [`ImproperResponse`].
#[inline]
pub fn check<T: Scalar, const D: usize>(
    law: &str,
    response: &Response<T, D>,
) -> Result<(), ImproperResponse> {
    let coefficients = response.cone.coefficients();
    let proper = response.gamma > T::zero() && coefficients.iter().all(|&c| c >= T::zero());
    if proper
        && all_finite([&response.gamma])
        && all_finite(&coefficients)
        && all_finite(response.shift.iter())
    {
        return Ok(());
    }
    Err(improper(law, response))
}

#[cold]
fn improper<T: Scalar, const D: usize>(law: &str, response: &Response<T, D>) -> ImproperResponse {
    let shift = response.shift.iter().find(|x| !all_finite([*x])).unwrap_or(&response.shift[0]);
    ImproperResponse {
        law: law.into(),
        gamma: to_f64(response.gamma),
        shift: to_f64(*shift),
        coefficients: response.cone.coefficients().map(to_f64),
    }
}
