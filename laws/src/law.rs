//! The trait of a contact law and its vocabulary.

use std::fmt::Debug;
use std::ops::RangeInclusive;

use nalgebra::{RealField, SVector};

/// The arithmetic a law needs: a real number that nalgebra computes with and that an error can print.
pub trait Scalar: RealField + Copy + num_traits::ToPrimitive {}
impl<T: RealField + Copy + num_traits::ToPrimitive> Scalar for T {}

/// Where a law writes the Coulomb inclusion: û = γ u_{k+1} + (1−γ) u_k + s.
///
/// γ is one number per contact: a component-wise weight would change the aperture of the cone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evaluation<T, const D: usize> {
    /// Weight γ > 0 of the velocity at the end of the step (dimensionless).
    pub gamma: T,
    /// Shift s, a velocity in the local frame (N, T1, T2).
    pub shift: SVector<T, D>,
}

impl<T: Scalar, const D: usize> Evaluation<T, D> {
    /// The velocity û = γ u_{k+1} + (1−γ) u_k + s at which the inclusion is written.
    pub fn velocity(&self, before: &SVector<T, D>, after: &SVector<T, D>) -> SVector<T, D> {
        after * self.gamma + before * (T::one() - self.gamma) + self.shift
    }

    /// The b-shift δ = ((1−γ) u_k + s)/γ of the cone problem `w = W p + u_free + δ`.
    ///
    /// Φ is positively homogeneous and N_K(p) is a cone, so dividing û by γ > 0 leaves the inclusion as it is,
    /// and the Delassus operator W is never scaled.
    pub fn b_shift(&self, before: &SVector<T, D>) -> SVector<T, D> {
        (before * (T::one() - self.gamma) + self.shift) / self.gamma
    }
}

/// A contact law with impact and friction, in contact dimension `D`: 1 (frictionless), 2 (planar) or 3.
///
/// Velocities are local, ordered (N, T1, T2); the normal points from the obstacle to the body, so `u_N < 0`
/// closes the gap. A complete law, with a coefficient of restitution that falls with the speed of the impact:
///
/// ```
/// use nalgebra::SVector;
/// use nonsmooth_laws::{ContactLaw, Evaluation, Scalar};
/// use std::ops::RangeInclusive;
///
/// #[derive(Debug)]
/// struct Viscous<T> { speed: T, friction: T }
///
/// impl<T: Scalar, const D: usize> ContactLaw<T, D> for Viscous<T> {
///     fn name(&self) -> &str { "viscous" }
///     fn friction(&self) -> T { self.friction }
///     fn evaluate(&self, before: &SVector<T, D>, theta: T) -> Evaluation<T, D> {
///         let closing = -before[0];
///         let mut shift = SVector::zeros();
///         if closing >= T::zero() {
///             let e = self.speed / (self.speed + closing);
///             shift[0] = (theta * (T::one() + e) - T::one()) * before[0];
///         }
///         Evaluation { gamma: theta, shift }
///     }
///     fn dissipative_theta(&self) -> Option<RangeInclusive<T>> {
///         let half = nalgebra::convert(0.5);
///         Some(half..=half)
///     }
/// }
/// ```
pub trait ContactLaw<T: Scalar, const D: usize>: Debug + Send + Sync {
    /// The name errors and outputs call the law by.
    fn name(&self) -> &str;

    /// Coefficient of friction μ ≥ 0 (dimensionless) of the cone K = {‖r_T‖ ≤ μ r_N}.
    fn friction(&self) -> T;

    /// The evaluation point for a contact that enters the step with local velocity `before` (u_k), under the
    /// θ-scheme. Must be positively homogeneous in `before` only if the law is; γ must be positive.
    fn evaluate(&self, before: &SVector<T, D>, theta: T) -> Evaluation<T, D>;

    /// The interval of θ in which contact work and numerical dissipation are both proved non-positive for any
    /// state, or `None` where no such interval exists. A claim is tested by the property suite, and a law that
    /// claims nothing must be shown to create energy.
    fn dissipative_theta(&self) -> Option<RangeInclusive<T>> {
        None
    }
}

impl<T: Scalar, const D: usize, L: ContactLaw<T, D> + ?Sized> ContactLaw<T, D> for Box<L> {
    fn name(&self) -> &str {
        (**self).name()
    }
    fn friction(&self) -> T {
        (**self).friction()
    }
    fn evaluate(&self, before: &SVector<T, D>, theta: T) -> Evaluation<T, D> {
        (**self).evaluate(before, theta)
    }
    fn dissipative_theta(&self) -> Option<RangeInclusive<T>> {
        (**self).dissipative_theta()
    }
}
