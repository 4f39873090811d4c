//! The trait of a contact law and its vocabulary.

use std::fmt::Debug;
use std::ops::RangeInclusive;

use nalgebra::SVector;

use super::{Cone, Rows, Scalar};

/// What a law is asked: a contact that enters a step.
///
/// Made by [`Approach::impact`] and what follows it, so that it can grow without breaking the laws there are.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Approach<'a, T, const D: usize> {
    /// Local velocity u_k at the start of the step, ordered (N, T1, T2) (m/s).
    pub before: SVector<T, D>,
    /// θ of the step, at this contact: bodies at rest may have one of their own.
    pub theta: T,
    /// Gap g(q_k) at the start of the step (m), negative where the bodies overlap; 0 at an instantaneous impact.
    pub gap: T,
    /// Length h of the step (s); 0 at an instantaneous impact.
    pub step: T,
    /// The contact carried a percussion in the last step and is slow, |u_{N,k}| of the order of what the forces make of
    /// rest in one step: it lasts, and is no impact.
    pub lasting: bool,
    /// What the law [remembers](ContactLaw::remember) of the contact: [`ContactLaw::memory`] numbers, 0 at first.
    pub memory: &'a [T],
    /// The components of the contact.
    pub rows: Rows,
}

impl<'a, T: Scalar, const D: usize> Approach<'a, T, D> {
    /// An impact that begins with local velocity `before`, under the θ-scheme.
    pub fn impact(before: SVector<T, D>, theta: T) -> Self {
        let rows = match D {
            1 => Rows::Normal,
            2 | 3 => Rows::Tangent,
            _ => Rows::Rolling,
        };
        Self { before, theta, gap: T::zero(), step: T::zero(), lasting: false, memory: &[], rows }
    }

    /// The same contact, with the gap it has at the start of a step of length `step`; `lasting` where it is no impact.
    pub fn with_gap(self, gap: T, step: T, lasting: bool) -> Self {
        Self { gap, step, lasting, ..self }
    }

    /// The same contact, of which the law remembers `memory`.
    pub fn with_memory(self, memory: &'a [T]) -> Self {
        Self { memory, ..self }
    }

    /// The same contact, with these components: [`Rows::Rolling`] tells a contact of the plane that can roll, D = 3, from
    /// one in space that can not.
    pub fn with_rows(self, rows: Rows) -> Self {
        Self { rows, ..self }
    }
}

/// What happened at a contact in a step that was accepted, for a law that [remembers](ContactLaw::remember).
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Passage<T, const D: usize> {
    /// Local velocity u_k at the start of the step (m/s).
    pub before: SVector<T, D>,
    /// Local velocity u_{k+1} at its end (m/s).
    pub after: SVector<T, D>,
    /// Percussion p of the step (N s).
    pub percussion: SVector<T, D>,
    /// Gap that made the contact active (m).
    pub gap: T,
    /// Length h of the step (s); 0 at an instantaneous impact.
    pub step: T,
    /// θ of the step at the contact: its velocity over the step is u_{k+θ} = (1−θ) u_k + θ u_{k+1}.
    pub theta: T,
    /// The contact [lasts](Approach::lasting), and this was no impact.
    pub lasting: bool,
}

impl<T: Scalar, const D: usize> Passage<T, D> {
    /// An impact from `before` to `after` by `percussion`, under the θ-scheme.
    pub fn impact(before: SVector<T, D>, after: SVector<T, D>, percussion: SVector<T, D>, theta: T) -> Self {
        let (gap, step) = (T::zero(), T::zero());
        Self { before, after, percussion, gap, step, theta, lasting: false }
    }

    /// The same, with the gap it had in a step of length `step`; `lasting` where it was no impact.
    pub fn with_gap(self, gap: T, step: T, lasting: bool) -> Self {
        Self { gap, step, lasting, ..self }
    }

    /// u_{k+θ}, the velocity that moves the bodies over the step (m/s).
    pub fn mean_velocity(&self) -> SVector<T, D> {
        self.before * (T::one() - self.theta) + self.after * self.theta
    }
}

/// What a law answers: where it writes the Coulomb inclusion, û = γ u_{k+1} + (1−γ) u_k + s, and in which cone.
///
/// γ is one number per contact: a component-wise weight would change the aperture of the cone.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Response<T, const D: usize> {
    /// Weight γ > 0 of the velocity at the end of the step (dimensionless).
    pub gamma: T,
    /// Shift s, a velocity in the local frame (N, T1, T2).
    pub shift: SVector<T, D>,
    /// The cone K of percussions.
    pub cone: Cone<T>,
}

impl<T: Scalar, const D: usize> Response<T, D> {
    /// The inclusion at û = γ u_{k+1} + (1−γ) u_k + s, in a cone; a number is Coulomb's cone of that friction.
    pub fn new(gamma: T, shift: SVector<T, D>, cone: impl Into<Cone<T>>) -> Self {
        Self { gamma, shift, cone: cone.into() }
    }

    /// The answer to a contact that lasts: û = u_{k+θ} + (2θ−1) (g⁺/h) e_N, g⁺ = max(g, 0).
    ///
    /// In the terms of an impact law it is the restitution e* = (1−θ)/θ of all components, and no e: the contact work is
    ///
    /// ```text
    ///   u_{k+θ}·p = −μ‖û_T‖ p_N − (2θ−1) (g⁺/h) p_N ≤ 0
    /// ```
    ///
    /// (with Φ's further terms where the contact rolls) for every θ ∈ [½, 1], every gap, every u_k, and so for any active set. A closed contact keeps its gap,
    /// h u_{N,k+θ} ≥ 0, where an impact law with e < e* would let it sink by h u_{N,k} (e* − e) θ; an open one closes, all of
    /// it in one step at θ = 1, none at θ = ½, where a contact that is pulled shut bounces.
    pub fn lasting(at: &Approach<T, D>, cone: impl Into<Cone<T>>) -> Self {
        let mut shift = SVector::zeros();
        if at.gap > T::zero() && at.step > T::zero() {
            shift[0] = (at.theta + at.theta - T::one()) * (at.gap / at.step);
        }
        Self { gamma: at.theta, shift, cone: cone.into() }
    }

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

/// A contact law with impact and friction, in contact dimension `D`: 1 (frictionless), 2 (planar) or 3, and with rolling
/// resistance 3 (planar) or 6.
///
/// Velocities are local, ordered (N, T1, T2), where the contact rolls (N, T, R) or (N, T1, T2, R1, R2, S); the normal points from the obstacle to the body, so `u_N < 0`
/// closes the gap. A complete law, with a coefficient of restitution that falls with the speed of the impact:
///
/// ```
/// use nalgebra::SVector;
/// use nonsmooth::laws::{Approach, ContactLaw, Response, Scalar};
/// use std::ops::RangeInclusive;
///
/// #[derive(Debug)]
/// struct Viscous<T> { speed: T, friction: T }
///
/// impl<T: Scalar, const D: usize> ContactLaw<T, D> for Viscous<T> {
///     fn name(&self) -> &str { "viscous" }
///     fn respond(&self, at: &Approach<T, D>) -> Response<T, D> {
///         if at.lasting {
///             return Response::lasting(at, self.friction);
///         }
///         let closing = -at.before[0];
///         let mut shift = SVector::zeros();
///         if closing >= T::zero() {
///             let e = self.speed / (self.speed + closing);
///             shift[0] = (at.theta * (T::one() + e) - T::one()) * at.before[0];
///         }
///         Response::new(at.theta, shift, self.friction)
///     }
///     fn lasting_theta(&self) -> Option<RangeInclusive<T>> {
///         Some(nalgebra::convert(0.5)..=T::one())
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

    /// The evaluation point and the cone for a contact that enters a step as `at` tells. Must be positively homogeneous in
    /// u_k only if the law is; γ must be positive, the coefficients of the cone ≥ 0. They may depend on anything `at` tells.
    ///
    /// A contact that [lasts](Approach::lasting) is no impact: [`Response::lasting`] is the answer that neither sinks nor
    /// gains energy. A law may say otherwise.
    fn respond(&self, at: &Approach<T, D>) -> Response<T, D>;

    /// The components the law needs: a scene in which no law rubs has no tangents, and one with a law that rolls has the
    /// relative rotation among the rows of its contacts.
    fn rows(&self) -> Rows {
        Rows::Tangent
    }

    /// How many numbers the law remembers of each contact. They are 0 where a contact begins, and are kept by the identity
    /// of the contact, through flights as well.
    fn memory(&self) -> usize {
        0
    }

    /// Takes note of a step that was accepted, in which the contact was active: wear, damage, the number of impacts. A step
    /// that is rejected leaves no trace.
    fn remember(&self, _done: &Passage<T, D>, _memory: &mut [T]) {}

    /// The interval of θ in which contact work and numerical dissipation are both proved non-positive for any
    /// state, or `None` where no such interval exists. A claim is tested by the property suite, and a law that
    /// claims nothing must be shown to create energy.
    fn dissipative_theta(&self) -> Option<RangeInclusive<T>> {
        None
    }

    /// The interval of θ in which the same is proved of contacts that [last](Approach::lasting); by default that of all
    /// contacts. Islands at rest take a θ of their own where every law in them claims it.
    fn lasting_theta(&self) -> Option<RangeInclusive<T>> {
        self.dissipative_theta()
    }
}
