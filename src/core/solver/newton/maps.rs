//! The cone inclusion as a nonsmooth equation per contact, with an element of its generalised Jacobian.

use nalgebra::{SMatrix, SVector};

use crate::cone::cones::{Shape, blocks};
use crate::cone::{Cone, de_saxce, project};
use crate::scalar::Scalar;

/// The nonsmooth equation f(r, w) = 0 of a contact that is equivalent to the cone problem, both with step length ρ = 1 on
/// the scaled problem.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Formulation {
    /// z = r − w, R = μ max(z_N, 0): f_N = r_N − max(z_N, 0), f_T = r_T − proj_{B(0,R)}(z_T) (default).
    /// Alart & Curnier (1991), doi:10.1016/0045-7825(91)90022-X.
    #[default]
    AlartCurnier,
    /// f = r − proj_K(r − Φ(w)), the residual itself. Acary, Brémond & Huber (2018),
    /// doi:10.1007/978-3-319-75972-2_10.
    NaturalMap,
}

/// State of a contact at a point of the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    /// f = r: A = I and C = 0.
    Open,
    /// f = w: A = 0 and C = I.
    Stick,
    /// Anything else.
    Slide,
}

/// f and its derivatives A in r and C in w, at z = r − w.
#[derive(Debug, Clone, Copy)]
pub(super) struct Linear<T: Scalar, const D: usize> {
    pub(super) state: State,
    pub(super) f: SVector<T, D>,
    pub(super) a: SMatrix<T, D, D>,
    pub(super) c: SMatrix<T, D, D>,
}

impl<T: Scalar, const D: usize> Linear<T, D> {
    /// f with A = 0 and C = I.
    pub(super) fn sticking(f: SVector<T, D>) -> Self {
        Self { state: State::Stick, f, a: SMatrix::zeros(), c: SMatrix::identity() }
    }
}

/// τ and the norm of z_T; τ = 0 where the norm is.
fn direction<T: Scalar, const D: usize>(z: &SVector<T, D>) -> (SVector<T, D>, T) {
    let mut tangent = *z;
    tangent[0] = T::zero();
    let norm = tangent.norm();
    if norm > T::zero() { (tangent / norm, norm) } else { (SVector::zeros(), norm) }
}

/// f alone: z_N ≤ 0: f = r; else f_N = w_N and, with R = μ z_N, τ = z_T/‖z_T‖, f_T = w_T where ‖z_T‖ ≤ R,
/// r_T − R τ beyond.
#[inline]
fn alart_curnier<T: Scalar, const D: usize>(r: &SVector<T, D>, w: &SVector<T, D>, mu: T) -> SVector<T, D> {
    let z = r - w;
    if z[0] <= T::zero() {
        return *r;
    }
    let (tau, norm) = direction(&z);
    let radius = mu * z[0];
    if D == 1 || (mu > T::zero() && norm <= radius) {
        return *w;
    }
    let mut f = r - tau * radius;
    f[0] = w[0];
    f
}

/// f, A, C. Slide: A_TT = I − P, A_TN = −μτ, C_TT = P, C_TN = μτ, C_N = e_N, P = (R/‖z_T‖)(I − ττᵀ).
#[inline]
fn linearise_alart_curnier<T: Scalar, const D: usize>(
    r: &SVector<T, D>,
    w: &SVector<T, D>,
    mu: T,
) -> Linear<T, D> {
    let z = r - w;
    let identity = SMatrix::identity();
    if z[0] <= T::zero() {
        return Linear { state: State::Open, f: *r, a: identity, c: SMatrix::zeros() };
    }
    let (tau, norm) = direction(&z);
    let radius = mu * z[0];
    if D == 1 || (mu > T::zero() && norm <= radius) {
        return Linear::sticking(*w);
    }
    let mut f = r - tau * radius;
    f[0] = w[0];
    let mut p = (identity - tau * tau.transpose()) * ratio(radius, norm);
    // Rows and columns of N: P has none.
    p.row_mut(0).fill(T::zero());
    p.column_mut(0).fill(T::zero());
    let mut a = identity - p;
    let mut c = p;
    for i in 0..D {
        (a[(i, 0)], c[(i, 0)]) = (-mu * tau[i], mu * tau[i]);
    }
    (a[(0, 0)], c[(0, 0)]) = (T::zero(), T::one());
    Linear { state: State::Slide, f, a, c }
}

/// f = r − proj_K(r − Φ(w)); with y = r − Φ(w) and p = proj_K(y): A = I − p′(y), C = p′(y) Φ′(w).
#[inline]
fn linearise_natural<T: Scalar, const D: usize>(r: &SVector<T, D>, w: &SVector<T, D>, mu: T) -> Linear<T, D> {
    let y = r - de_saxce(w, mu);
    let p = project(&y, mu);
    let f = r - p;
    let identity = SMatrix::identity();
    if p[0] <= T::zero() {
        return Linear { state: State::Open, f, a: identity, c: SMatrix::zeros() };
    }
    let (tau_w, _) = direction(w);
    let mut phi = identity;
    (1..D).for_each(|j| phi[(0, j)] = mu * tau_w[j]);
    let (tau, norm) = direction(&y);
    if D == 1 || (mu > T::zero() && norm <= mu * y[0]) {
        return Linear { state: State::Slide, f, a: SMatrix::zeros(), c: phi };
    }
    // p_N = (y_N + μ‖y_T‖)/(1 + μ²), p_T = μ p_N τ.
    let mut along = tau * mu;
    along[0] = T::one();
    let mut across = identity - tau * tau.transpose();
    across.row_mut(0).fill(T::zero());
    across.column_mut(0).fill(T::zero());
    let slope = along * along.transpose() / (T::one() + mu * mu) + across * ratio(mu * p[0], norm);
    Linear { state: State::Slide, f, a: identity - slope, c: slope * phi }
}

/// Either map of a cone with a ball per block: with the slope P of the projection, A = I − P, and C = P, times Φ′(w) for the
/// natural map.
fn linearise_blocks<T: Scalar, const D: usize>(
    formulation: Formulation,
    r: &SVector<T, D>,
    w: &SVector<T, D>,
    coefficients: [T; 3],
) -> Linear<T, D> {
    let identity = SMatrix::identity();
    let (f, slope, change) = match formulation {
        Formulation::AlartCurnier => {
            let f = blocks::alart_curnier(r, w, coefficients);
            match blocks::ball_slope(&(r - w), coefficients) {
                Some((_, true)) => return Linear::sticking(f),
                slope => (f, slope.map(|(slope, _)| slope), identity),
            }
        }
        Formulation::NaturalMap => {
            let y = r - blocks::de_saxce(w, coefficients);
            let f = r - blocks::project(&y, coefficients);
            (f, blocks::slope(&y, coefficients), blocks::de_saxce_slope(w, coefficients))
        }
    };
    match slope {
        None => Linear { state: State::Open, f, a: identity, c: SMatrix::zeros() },
        Some(slope) => Linear { state: State::Slide, f, a: identity - slope, c: slope * change },
    }
}

/// x/y of sizes, 0 where y is.
fn ratio<T: Scalar>(x: T, y: T) -> T {
    if y > T::zero() { x / y } else { T::zero() }
}

impl Formulation {
    /// The equation that is not this one.
    pub(in crate::solver) fn other(self) -> Self {
        match self {
            Self::AlartCurnier => Self::NaturalMap,
            Self::NaturalMap => Self::AlartCurnier,
        }
    }

    /// f.
    #[inline]
    pub(super) fn value<T: Scalar, const D: usize>(
        self,
        r: &SVector<T, D>,
        w: &SVector<T, D>,
        cone: impl Into<Cone<T>>,
    ) -> SVector<T, D> {
        let cone = cone.into();
        match (self, Shape::of::<D>(cone)) {
            (Self::AlartCurnier, Shape::Disc(mu)) => alart_curnier(r, w, mu),
            (Self::AlartCurnier, Shape::Blocks(coefficients)) => blocks::alart_curnier(r, w, coefficients),
            (Self::NaturalMap, _) => r - project(&(r - de_saxce(w, cone)), cone),
        }
    }

    /// f, A, C.
    #[inline]
    pub(super) fn linearise<T: Scalar, const D: usize>(
        self,
        r: &SVector<T, D>,
        w: &SVector<T, D>,
        cone: impl Into<Cone<T>>,
    ) -> Linear<T, D> {
        match (self, Shape::of::<D>(cone.into())) {
            (Self::AlartCurnier, Shape::Disc(mu)) => linearise_alart_curnier(r, w, mu),
            (Self::NaturalMap, Shape::Disc(mu)) => linearise_natural(r, w, mu),
            (_, Shape::Blocks(coefficients)) => linearise_blocks(self, r, w, coefficients),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cone::{dual_gauge, project};
    use proptest::prelude::*;

    /// The derivative against central differences, where the two sides of the point agree (away from the kinks).
    fn check<const D: usize>(formulation: Formulation, entries: &[f64], cone: impl Into<Cone<f64>>) {
        let cone = cone.into();
        let friction = cone.coefficients().iter().sum::<f64>();
        let r = SVector::<f64, D>::from_column_slice(&entries[..D]);
        let w = SVector::<f64, D>::from_column_slice(&entries[D..2 * D]);
        let linear = formulation.linearise(&r, &w, cone);
        assert_eq!(linear.f, formulation.value(&r, &w, cone));
        let step = 1e-6;
        for d in 0..D {
            let e = SVector::<f64, D>::from_fn(|i, _| if i == d { step } else { 0.0 });
            for (column, at) in [
                (linear.a.column(d), [(r + e, w), (r - e, w)]),
                (linear.c.column(d), [(r, w + e), (r, w - e)]),
            ] {
                let [up, down] = at.map(|(r, w)| formulation.linearise(&r, &w, cone));
                // A kink between the two sides changes the derivative by more than the curvature, 1/‖w_T‖ or
                // 1/‖z_T‖ ≤ 1e2 here, can over the step.
                if (up.c - down.c).norm() > 1e3 * step * (1.0 + friction) {
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

        /// The same with moments among the components.
        #[test]
        fn derivatives_of_rolling_contacts_are_those_of_the_value(
            entries in proptest::collection::vec(-2.0..2.0f64, 12),
            friction in prop_oneof![Just(0.0), 0.05..3.0f64],
            rolling in prop_oneof![Just(0.0), 0.05..3.0f64],
            spinning in prop_oneof![Just(0.0), 0.05..3.0f64],
        ) {
            for formulation in [Formulation::AlartCurnier, Formulation::NaturalMap] {
                let cone = Cone::Rolling { friction, rolling, spinning };
                check::<3>(formulation, &entries, cone);
                check::<6>(formulation, &entries, cone);
            }
        }

        /// Without friction r_T = 0 is where the map is used, and no place to stick.
        #[test]
        fn derivatives_are_those_of_the_value_where_nothing_slides(normal in -2.0..2.0f64, w in -2.0..2.0f64) {
            for formulation in [Formulation::AlartCurnier, Formulation::NaturalMap] {
                check::<2>(formulation, &[normal, 0.0, w, 0.0], 0.0);
                check::<3>(formulation, &[normal, 0.0, 0.0, w, 0.0, 0.0], 0.0);
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
            w[0] -= dual_gauge(&w, friction);
            for formulation in [Formulation::AlartCurnier, Formulation::NaturalMap] {
                // Both are a few operations on numbers of size 10.
                prop_assert!(formulation.value(&r, &w, friction).norm() <= 1e-13 * (1.0 + friction * friction));
            }
        }
    }
}
