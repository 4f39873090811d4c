//! The cone inclusion as a nonsmooth equation per contact, with an element of its generalised Jacobian.

use nalgebra::{ComplexField, SMatrix, SVector};

use crate::cone::{de_saxce, project};
use crate::scalar::Scalar;

/// The nonsmooth equation F(r) = 0 that is equivalent to the cone problem; both with step length 1 on the scaled
/// problem.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Formulation {
    /// z = r − w, R = μ max(z_N, 0): F_N = r_N − max(z_N, 0), F_T = r_T − proj_{B(0,R)}(z_T) (default).
    /// Alart & Curnier (1991), doi:10.1016/0045-7825(91)90022-X.
    #[default]
    AlartCurnier,
    /// F = r − proj_K(r − Φ(w)), the residual itself. Acary, Brémond & Huber (2018),
    /// doi:10.1007/978-3-319-75972-2_10.
    NaturalMap,
}

impl Formulation {
    /// The other one.
    pub(super) fn other(self) -> Self {
        match self {
            Self::AlartCurnier => Self::NaturalMap,
            Self::NaturalMap => Self::AlartCurnier,
        }
    }
}

/// One contact's equation f(r, w) = 0 and its derivatives: df = A dr + C dw.
#[derive(Debug, Clone, Copy)]
pub(super) struct Linearised<T: Scalar, const D: usize> {
    pub(super) f: SVector<T, D>,
    pub(super) by_percussion: SMatrix<T, D, D>,
    pub(super) by_velocity: SMatrix<T, D, D>,
    /// f = r: the contact is open, A = I and C = 0.
    pub(super) open: bool,
}

/// ‖x_T‖.
#[inline]
pub(super) fn tangential_norm<T: Scalar, const D: usize>(x: &SVector<T, D>) -> T {
    match D {
        1 => T::zero(),
        2 => ComplexField::abs(x[1]),
        _ => ComplexField::sqrt(x.iter().skip(1).fold(T::zero(), |sum, &t| sum + t * t)),
    }
}

/// The value alone.
#[inline]
pub(super) fn value<T: Scalar, const D: usize>(
    formulation: Formulation,
    r: &SVector<T, D>,
    w: &SVector<T, D>,
    friction: T,
) -> SVector<T, D> {
    match formulation {
        Formulation::NaturalMap if friction > T::zero() => {
            r - project(&(r - de_saxce(w, friction)), friction)
        }
        // Without friction both are r_N = max(r_N − w_N, 0), r_T = 0.
        _ => {
            let mut z = r - w;
            if z[0] <= T::zero() {
                return *r;
            }
            let (radius, length) = (friction * z[0], tangential_norm(&z));
            if length > radius {
                let shrink = radius / length;
                z.iter_mut().skip(1).for_each(|t| *t *= shrink);
            }
            r - z
        }
    }
}

/// The value with its derivatives.
#[inline]
pub(super) fn linearise<T: Scalar, const D: usize>(
    formulation: Formulation,
    r: &SVector<T, D>,
    w: &SVector<T, D>,
    friction: T,
) -> Linearised<T, D> {
    let f = value(formulation, r, w, friction);
    let (jacobian, change) = if friction == T::zero() || formulation == Formulation::AlartCurnier {
        let z = r - w;
        if z[0] <= T::zero() {
            return open(f);
        }
        (disc_projection(&z, friction), SMatrix::identity())
    } else {
        let Some(jacobian) = cone_projection(&(r - de_saxce(w, friction)), friction) else {
            return open(f);
        };
        let mut change = SMatrix::<T, D, D>::identity();
        let slip = tangential_norm(w);
        if slip > T::zero() {
            (1..D).for_each(|j| change[(0, j)] = friction * w[j] / slip);
        }
        (jacobian, change)
    };
    Linearised {
        f,
        by_percussion: SMatrix::identity() - jacobian,
        by_velocity: jacobian * change,
        open: false,
    }
}

fn open<T: Scalar, const D: usize>(f: SVector<T, D>) -> Linearised<T, D> {
    Linearised { f, by_percussion: SMatrix::identity(), by_velocity: SMatrix::zeros(), open: true }
}

/// Derivative of z ↦ (z_N, proj_{B(0, μ z_N)}(z_T)) at z_N > 0.
#[inline]
fn disc_projection<T: Scalar, const D: usize>(z: &SVector<T, D>, friction: T) -> SMatrix<T, D, D> {
    let (radius, length) = (friction * z[0], tangential_norm(z));
    if friction > T::zero() && length <= radius {
        return SMatrix::identity();
    }
    let mut jacobian = SMatrix::zeros();
    jacobian[(0, 0)] = T::one();
    if length > T::zero() {
        let shrink = radius / length;
        for i in 1..D {
            let tau_i = z[i] / length;
            jacobian[(i, 0)] = friction * tau_i;
            for j in 1..D {
                let identity = if i == j { T::one() } else { T::zero() };
                jacobian[(i, j)] = shrink * (identity - tau_i * z[j] / length);
            }
        }
    }
    jacobian
}

/// Derivative of the projection on K at `y`, μ > 0; `None` where it is the apex.
#[inline]
fn cone_projection<T: Scalar, const D: usize>(y: &SVector<T, D>, friction: T) -> Option<SMatrix<T, D, D>> {
    let length = tangential_norm(y);
    if length <= friction * y[0] {
        return (y[0] > T::zero()).then(SMatrix::identity);
    }
    let along = y[0] + friction * length;
    if along <= T::zero() {
        return None;
    }
    let weight = T::one() / (T::one() + friction * friction);
    let normal = along * weight;
    let mut jacobian = SMatrix::zeros();
    jacobian[(0, 0)] = weight;
    for i in 1..D {
        let tau_i = y[i] / length;
        jacobian[(0, i)] = friction * weight * tau_i;
        jacobian[(i, 0)] = friction * weight * tau_i;
        for j in 1..D {
            let tau = tau_i * y[j] / length;
            let identity = if i == j { T::one() } else { T::zero() };
            let turn = friction * normal / length * (identity - tau);
            jacobian[(i, j)] = friction * friction * weight * tau + turn;
        }
    }
    Some(jacobian)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cone::project;
    use proptest::prelude::*;

    /// The derivative against central differences, where the two sides of the point agree (away from the kinks).
    fn check<const D: usize>(formulation: Formulation, entries: &[f64], friction: f64) {
        let r = SVector::<f64, D>::from_column_slice(&entries[..D]);
        let w = SVector::<f64, D>::from_column_slice(&entries[D..2 * D]);
        let linear = linearise(formulation, &r, &w, friction);
        assert_eq!(linear.f, value(formulation, &r, &w, friction));
        let step = 1e-6;
        for d in 0..D {
            let e = SVector::<f64, D>::from_fn(|i, _| if i == d { step } else { 0.0 });
            for (column, at) in [
                (linear.by_percussion.column(d), [(r + e, w), (r - e, w)]),
                (linear.by_velocity.column(d), [(r, w + e), (r, w - e)]),
            ] {
                let [up, down] = at.map(|(r, w)| linearise(formulation, &r, &w, friction));
                // A kink between the two sides changes the derivative by more than the curvature, 1/‖w_T‖ or
                // 1/‖z_T‖ ≤ 1e2 here, can over the step.
                if (up.by_velocity - down.by_velocity).norm() > 1e3 * step * (1.0 + friction) {
                    continue;
                }
                let difference = (up.f - down.f) / (2.0 * step);
                // Round-off ε‖r‖/step and curvature² step².
                assert!(
                    (difference - column).norm() <= 1e-7 * (1.0 + friction),
                    "{formulation:?} {difference} {column}"
                );
            }
        }
    }

    proptest! {
        #[test]
        fn derivatives_are_those_of_the_value(
            entries in proptest::collection::vec(-2.0..2.0f64, 6),
            friction in prop_oneof![Just(0.0), 0.05..3.0f64],
        ) {
            for formulation in [Formulation::AlartCurnier, Formulation::NaturalMap] {
                check::<1>(formulation, &entries, friction);
                check::<2>(formulation, &entries, friction);
                check::<3>(formulation, &entries, friction);
            }
        }

        /// r ∈ K, Φ(w) = (r' − r)-like pairs: with y = r − Φ(w), r = proj_K(y) solves, and both maps vanish there.
        #[test]
        fn both_maps_vanish_on_solutions(
            entries in proptest::collection::vec(-2.0..2.0f64, 3),
            friction in 0.05..3.0f64,
        ) {
            let y = SVector::<f64, 3>::from_column_slice(&entries);
            let r = project(&y, friction);
            // u = r − y ∈ K*, u ⟂ r; w = u − μ‖u_T‖ e_N has Φ(w) = u.
            let mut w = r - y;
            w[0] -= friction * tangential_norm(&w);
            for formulation in [Formulation::AlartCurnier, Formulation::NaturalMap] {
                // Both are a few operations on numbers of size 10.
                prop_assert!(value(formulation, &r, &w, friction).norm() <= 1e-13 * (1.0 + friction * friction));
            }
        }
    }
}
