//! Free flight of a body that turns: J ω̇ + ω × J ω = 0 in the body's frame, solved so that nothing is lost.
//!
//! ```text
//!   J (ω' − ω) + τ ω̄ × J ω̄ = 0,   ω̄ = ½ (ω + ω'),   R' = R cay(τ ω̄)
//! ```
//!
//! keeps the energy, since ω̄·(ω̄ × Jω̄) = 0, and with the Cayley map (as a quaternion (1, ½ τ ω̄), normalised) the angular
//! momentum R J ω as well, for any τ (Austin, Krishnaprasad and Wang 1993, doi:10.1006/jcph.1993.1128). With d = ω̄ − ω the
//! equation reads 2 J d = −τ (ω+d) × J (ω+d), so that rounding is that of the change. Bodies that turn far in τ fly in
//! several equal parts.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use crate::scalar::{Scalar, all_finite, epsilon, lit, to_f64};

/// Turn within one part of a flight (rad), weighted by how far the moments of inertia differ.
const TURN: f64 = 0.25;
/// Parts of one flight at most: 1e4 of ¼ rad are hundreds of revolutions within a step, which resolves nothing else either.
const MOST_PARTS: f64 = 1e4;
/// Newton steps: the error squares from below 0.1.
const NEWTON_STEPS: usize = 8;

/// q ∘ (1, ½ s)/|·|: the orientation `q` turned by s, a vector of the body's frame.
#[inline]
pub(super) fn turned<T: Scalar>(q: &UnitQuaternion<T>, s: &Vector3<T>) -> UnitQuaternion<T> {
    if *s == Vector3::zeros() {
        return *q;
    }
    let half = s * lit::<T>(0.5);
    let product = q.into_inner() * Quaternion::from_parts(T::one(), half);
    UnitQuaternion::new_normalize(product)
}

/// The s of `to` = `from` ∘ (1, ½ s)/|·|; of half a turn, which no such s makes, one beyond 1/ε.
#[inline]
pub(super) fn turn_between<T: Scalar>(from: &UnitQuaternion<T>, to: &UnitQuaternion<T>) -> Vector3<T> {
    let between = from.inverse().into_inner() * to.into_inner();
    let least = epsilon::<T>();
    let real = if nalgebra::ComplexField::abs(between.w) < least { least } else { between.w };
    between.vector() * (lit::<T>(2.0) / real)
}

/// Whether moments of inertia are equal, so that the velocity of a free body does not change.
pub(super) fn is_isotropic<T: Scalar>(moments: &Vector3<T>) -> bool {
    moments.x == moments.y && moments.y == moments.z
}

/// Flies for `time` (s).
#[inline]
pub(super) fn fly<T: Scalar>(
    moments: &Vector3<T>,
    time: T,
    orientation: &mut UnitQuaternion<T>,
    spin: &mut Vector3<T>,
) {
    if *spin == Vector3::zeros() || time == T::zero() {
        return;
    }
    if is_isotropic(moments) {
        *orientation = turned(orientation, &(*spin * time));
        return;
    }
    let (least, most) = (moments.min(), moments.max());
    // The largest moment that a gyroscopic torque is divided by is the least.
    let turn = to_f64(spin.norm() * time * ((most - least) / least));
    let parts = (turn / TURN).ceil().clamp(1.0, MOST_PARTS);
    let part = time / lit::<T>(parts);
    for _ in 0..parts as usize {
        let change = half_change(moments, part, spin);
        *orientation = turned(orientation, &((*spin + change) * part));
        *spin += change * lit::<T>(2.0);
    }
}

/// d = ω̄ − ω.
#[inline]
fn half_change<T: Scalar>(moments: &Vector3<T>, time: T, spin: &Vector3<T>) -> Vector3<T> {
    let two = lit::<T>(2.0);
    let mut d = Vector3::zeros();
    for _ in 0..NEWTON_STEPS {
        let mean = spin + d;
        let momentum = moments.component_mul(&mean);
        let residual = moments.component_mul(&d) * two + mean.cross(&momentum) * time;
        let tangent = Matrix3::from_diagonal(&(moments * two))
            + (mean.cross_matrix() * Matrix3::from_diagonal(moments) - momentum.cross_matrix()) * time;
        let Some(step) = tangent.lu().solve(&residual).filter(|step| all_finite(step.iter())) else { break };
        d -= step;
        if step.norm() <= lit::<T>(2.0) * epsilon::<T>() * d.norm() {
            break;
        }
    }
    d
}
