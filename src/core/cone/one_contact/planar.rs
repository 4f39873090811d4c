//! The exact solution in the plane: r_T(α) keeps the sign of −β and r_N(α)/|r_T(α)| is affine in α, no iteration.

use nalgebra::{ComplexField, SMatrix, SVector};

use super::{floor, vector};
use crate::scalar::Scalar;

/// The block of one contact with r_N eliminated, whatever b.
#[derive(Debug, Clone)]
pub(super) struct Planar<T> {
    /// 1/W_NN, W_NT and W_TN/W_NN.
    inverse: T,
    coupling: T,
    lever: T,
    /// S and 1/S (0 where S is).
    s: T,
    compliance: T,
    /// W_NN ± μ W_NT, the stiffness of the slides r_T = ±μ r_N, and its inverse.
    stiffness: [T; 2],
    give: [T; 2],
    friction: T,
    /// ±μ.
    side: [T; 2],
}

impl<T: Scalar> Planar<T> {
    #[inline(always)]
    pub(super) fn new<const D: usize>(w: &SMatrix<T, D, D>, friction: T) -> Self {
        let (nn, nt, tn, tt) = (w[(0, 0)], w[(0, 1)], w[(1, 0)], w[(1, 1)]);
        let inverse = T::one() / nn;
        let s = tt - tn * nt * inverse;
        let s = if s > floor(tt) { s } else { floor(tt) };
        // S = 0 only where W_TT is: no percussion changes w_T.
        let compliance = if s > T::zero() { T::one() / s } else { T::zero() };
        let stiffness = [nn + friction * nt, nn - friction * nt];
        let give = [T::one() / stiffness[0], T::one() / stiffness[1]];
        Self {
            inverse,
            coupling: nt,
            lever: tn * inverse,
            s,
            compliance,
            stiffness,
            give,
            friction,
            side: [friction, -friction],
        }
    }

    /// r for the velocity `b` without it; take-off, stick and slide are all computed and one is taken: in a sweep the
    /// statuses follow no pattern a processor could predict.
    #[inline(always)]
    pub(super) fn solve<const D: usize>(&self, b: &SVector<T, D>) -> SVector<T, D> {
        let beta = b[1] - self.lever * b[0];
        let down = usize::from(beta > T::zero());
        // |r_T| ≤ μ r_N at α = 0, multiplied out.
        let slides = ComplexField::abs(beta) * self.stiffness[down] > -self.friction * b[0] * self.s;
        let stuck = -beta * self.compliance;
        let sliding = -b[0] * self.give[down];
        let outcomes = [
            [T::zero(); 2],
            [-(b[0] + self.coupling * stuck) * self.inverse, stuck],
            [sliding, self.side[down] * sliding],
        ];
        let closed = b[0] < T::zero();
        let [normal, tangential] = outcomes[usize::from(closed) * (1 + usize::from(slides))];
        vector(normal, [tangential, T::zero()])
    }
}
