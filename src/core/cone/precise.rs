//! The shifted velocity where its terms cancel, and what rounding leaves of it.
//!
//! Under a load the terms of w = W r + b are large and w is small. Three roundings stand between the data and w:
//!
//! - that of r, half a unit in the last place of every percussion, moves w by up to ½ε |W||r|. No solver can do better
//!   with percussions of this precision: this is the [`floor`](ConeProblem::floor).
//! - that of the product, some n ε |W||r| for sums of n terms. It is avoided by summing in twice the precision.
//! - that of W itself, which is H M̂⁻¹ Hᵀ rounded. A light body between heavy ones couples their contacts by entries of
//!   the order 1/m_light, whose rounding acts like mobility ε/m_light of the heavy ones: with a ratio of masses of 10⁸ it
//!   changes forces by 1e-7. It is avoided by summing body by body, w = H (M̂⁻¹ (Hᵀ r)) + b: what acts on a body cancels
//!   there, and action equals reaction to the last digit.

use nalgebra::SVector;

use super::{ConeProblem, Residual, Workspace};
use crate::linalg::{BlockRows, Compensated};
use crate::scalar::{Scalar, epsilon, lit};

/// H and the reciprocals of a diagonal M̂, beside the W formed of them; empty where W was formed of something else.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bodies<T: Scalar, const D: usize> {
    rows: BlockRows<T, D>,
    inverse: Vec<T>,
}

impl<T: Scalar, const D: usize> Default for Bodies<T, D> {
    fn default() -> Self {
        Self { rows: BlockRows::new(), inverse: Vec::new() }
    }
}

impl<T: Scalar, const D: usize> Bodies<T, D> {
    /// Forgets H, and keeps M̂ and the memory: without rows nothing is summed over bodies.
    pub(super) fn clear(&mut self) {
        self.rows.clear();
    }
}

/// Multiple of the floor below which the evaluation of a residual is in doubt: sums of as many terms lose that.
const NEAR_FLOOR: f64 = 256.0;

/// Largest floor a solution may be excused by: two fifths of the digits must stand, or r has run away from a problem
/// without solution.
fn largest_floor<T: Scalar>() -> T {
    nalgebra::ComplexField::powf(epsilon::<T>(), lit(0.4))
}

impl<T: Scalar, const D: usize> ConeProblem<T, D> {
    /// The shifted velocities of `r`, rounded about once: compensated sums over the rows of W or, where the problem has
    /// them, over the bodies.
    pub(crate) fn precise_velocities(
        &self,
        r: &[SVector<T, D>],
        workspace: &mut Workspace<T>,
        visit: &mut dyn FnMut(usize, SVector<T, D>),
    ) {
        let Some(w) = self.delassus().formed() else {
            // Summed over the bodies as it is.
            return self.velocities(r, workspace, visit);
        };
        let Bodies { rows, inverse } = &self.bodies;
        if inverse.is_empty() || rows.rows() != r.len() {
            for (i, b) in self.b().iter().enumerate() {
                let mut sums = b.map(Compensated::new);
                for (j, block) in w.row(i) {
                    for k in 0..D {
                        (0..D).for_each(|l| sums[k].add_product(block[(k, l)], r[j][l]));
                    }
                }
                visit(i, sums.map(|sum| sum.value()));
            }
            return;
        }
        let impulses = &mut workspace.impulses;
        impulses.resize(inverse.len(), Compensated::new(T::zero()));
        for (i, r) in r.iter().enumerate() {
            for (dof, h) in rows.row(i).filter(|&(dof, _)| dof < inverse.len()) {
                h.iter().zip(r.iter()).for_each(|(&h, &r)| impulses[dof].add_product(h, r));
            }
        }
        for (i, b) in self.b().iter().enumerate() {
            let mut sums = b.map(Compensated::new);
            for (dof, h) in rows.row(i).filter(|&(dof, _)| dof < inverse.len()) {
                let v = impulses[dof].value() * inverse[dof];
                sums.iter_mut().zip(h.iter()).for_each(|(sum, &h)| sum.add_product(h, v));
            }
            visit(i, sums.map(|sum| sum.value()));
        }
        // Left as found: only what was touched is cleared.
        for (dof, _) in (0..r.len()).flat_map(|i| rows.row(i)).filter(|&(dof, _)| dof < inverse.len()) {
            impulses[dof] = Compensated::new(T::zero());
        }
    }

    /// [`residual`](Self::residual), with w rounded about once: the same number, for the price of several, and the one
    /// to believe where W r and b cancel.
    ///
    /// # Panics
    /// If `r` has not one block per contact.
    pub fn precise_residual(&self, r: &[SVector<T, D>]) -> Residual<T> {
        self.precise_residual_in(r, &mut Workspace::default())
    }

    /// [`precise_residual`](Self::precise_residual) in a workspace that the caller keeps.
    ///
    /// # Panics
    /// If `r` has not one block per contact.
    pub fn precise_residual_in(&self, r: &[SVector<T, D>], workspace: &mut Workspace<T>) -> Residual<T> {
        assert_eq!(r.len(), self.contacts(), "one percussion per contact");
        self.measure(r, |visit| self.precise_velocities(r, workspace, visit))
    }

    /// Both residuals of `r` with its shifted velocities `w`.
    pub(crate) fn residual_at(&self, r: &[SVector<T, D>], w: &[SVector<T, D>]) -> Residual<T> {
        self.measure(r, |visit| w.iter().enumerate().for_each(|(i, &w)| visit(i, w)))
    }

    /// The scaled residual that the rounding of percussions like `r` explains, ε ‖|W||r| + |b|‖₂ / ‖b‖₂: twice
    /// what half a unit in the last place of every number can make. Below it no solver can be asked to go.
    ///
    /// It is 0, an excuse for nothing, where it would exceed ε^⅖ (5e-7, in single precision 2e-3), and in factored form.
    pub fn floor(&self, r: &[SVector<T, D>]) -> T {
        let Some(w) = self.delassus().formed() else { return T::zero() };
        let mut square = T::zero();
        for (i, b) in self.b().iter().enumerate() {
            let mut size = b.abs();
            w.row(i).for_each(|(j, block)| size += block.abs() * r[j].abs());
            square += size.norm_squared();
        }
        let floor = epsilon::<T>() * nalgebra::ComplexField::sqrt(square) / self.b_norm();
        if floor <= largest_floor() { floor } else { T::zero() }
    }

    /// Whether a scaled residual evaluated in working precision is in doubt beside the floor.
    pub(crate) fn is_near_floor(residual: T, floor: T) -> bool {
        residual <= floor * lit::<T>(NEAR_FLOOR)
    }

    /// Whether rounding explains what `r` leaves, the scaled residual `residual` as evaluated in working precision.
    #[cfg(feature = "clarabel")]
    pub(crate) fn solved_to_rounding(
        &self,
        r: &[SVector<T, D>],
        residual: T,
        workspace: &mut Workspace<T>,
    ) -> bool {
        let floor = self.floor(r);
        Self::is_near_floor(residual, floor) && self.precise_residual_in(r, workspace).scaled <= floor
    }

    /// Copies the H and the reciprocals of the diagonal M̂ that W was formed of; [`parts_mut`](Self::parts_mut) forgets
    /// H again. A copy of H costs a small part of forming W of it.
    pub(crate) fn copy_bodies(&mut self, jacobian: &BlockRows<T, D>, inverse: &[T]) {
        self.bodies.rows.copy_from(jacobian);
        self.copy_masses(inverse);
    }

    /// Copies M̂ of `whole`, of which this problem is to be a part, or forgets the last one.
    pub(crate) fn copy_masses_of(&mut self, whole: &Self) {
        self.copy_masses(&whole.bodies.inverse);
    }

    fn copy_masses(&mut self, inverse: &[T]) {
        self.bodies.inverse.clear();
        self.bodies.inverse.extend_from_slice(inverse);
    }

    /// Copies the rows of H of the contacts `contacts` of `whole`, of which this problem is a part.
    pub(crate) fn copy_rows(&mut self, whole: &Self, contacts: &[usize]) {
        let (own, rows) = (&mut self.bodies.rows, &whole.bodies.rows);
        own.clear();
        for &contact in contacts.iter().filter(|&&contact| contact < rows.rows()) {
            own.start_row();
            rows.row(contact).for_each(|(dof, &h)| own.push(dof, h));
        }
    }
}
