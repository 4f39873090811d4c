//! How far a contact work can be positive for the tolerance of the cone solver alone.

use nalgebra::SVector;

use super::ThetaScheme;
use super::active_set::ActiveSet;
use super::cones::Cones;
use crate::cone::largest_eigenvalue;
use crate::scalar::{Scalar, epsilon, lit};
use crate::solver::{Accuracy, Solution};

/// Factor for the norms: the residual is one number for all contacts, and that of an island may be evaluated apart.
const MARGIN: f64 = 10.0;

/// Roundings of a sum of D products, and of the sums over the bodies that velocities are, in ε of the terms.
const ROUNDINGS: f64 = 64.0;

impl<T: Scalar, const D: usize> ThetaScheme<T, D> {
    /// Sets [`work_bound`](super::ContactStep::work_bound) of the contacts with a positive work.
    ///
    /// A scaled residual τ leaves velocities that are wrong by d = τ‖b‖₂ and percussions that are wrong by d/λ, λ =
    /// λ_max(W_αα): works that are wrong by d ‖p‖ + (d/λ)(‖u‖ + d), u the faster of u_k and u_{k+1}, and by the rounding of
    /// u = Σ_j H_j v_j, which is that of its terms: bodies that move together have a u of rounding alone.
    pub(super) fn set_work_bounds(&mut self, solution: Option<&Solution<T>>) {
        let Some(solution) = solution else { return };
        let Self {
            state,
            next,
            cones: Cones { problem, arms, .. },
            active: ActiveSet { jacobian, .. },
            solver,
            ..
        } = self;
        let zero = T::zero();
        let mut left = None;
        for (i, contact) in next.contacts.iter_mut().enumerate() {
            // Written so that no work of a contact at rest or in dissipation costs anything.
            if !(contact.normal_work > zero || contact.tangential_work > zero) {
                continue;
            }
            let left = *left.get_or_insert_with(|| {
                let floor = match solution.accuracy {
                    Accuracy::Tolerance => zero,
                    Accuracy::Rounding { floor } => floor,
                };
                let tolerance = nalgebra::RealField::max(solver.stopping().tolerance, floor);
                lit::<T>(MARGIN) * tolerance * problem.b_norm()
            });
            let [before, after] = [contact.before, contact.after].map(|u| arms.enter_velocity(i, &u).norm());
            let larger = nalgebra::RealField::max;
            let speed = larger(before, after);
            let abs = |x: T| nalgebra::ComplexField::abs(x);
            let term = |(dof, h): (usize, &SVector<T, D>)| {
                arms.enter_velocity(i, h).norm() * larger(abs(state.v[dof]), abs(next.v[dof]))
            };
            let terms = jacobian.row(i).map(term).fold(zero, |sum, term| sum + term);
            let percussion = arms.enter(i, &contact.percussion).norm();
            let lambda = largest_eigenvalue(problem.diagonal(i));
            contact.work_bound = left * (percussion + (speed + left) / lambda)
                + lit::<T>(ROUNDINGS) * epsilon::<T>() * terms * percussion;
        }
    }
}
