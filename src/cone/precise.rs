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

use super::{ConeProblem, Residual};
use crate::linalg::{BlockRows, Compensated};
use crate::scalar::{Scalar, epsilon, lit};

/// H and the reciprocals of a diagonal M̂, beside the W formed of them; empty while their owner has them.
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
        visit: &mut dyn FnMut(usize, SVector<T, D>),
    ) {
        if self.factors().is_some() {
            // Summed over the bodies as it is.
            return self.visit_velocities(r, visit);
        }
        let Bodies { rows, inverse } = &self.bodies;
        if inverse.is_empty() || rows.rows() != r.len() {
            for (i, b) in self.b().iter().enumerate() {
                let mut sums = b.map(Compensated::new);
                for (j, block) in self.delassus().row(i) {
                    for k in 0..D {
                        (0..D).for_each(|l| sums[k].add_product(block[(k, l)], r[j][l]));
                    }
                }
                visit(i, sums.map(|sum| sum.value()));
            }
            return;
        }
        let mut product = self.scratch.take();
        product.impulses.resize(inverse.len(), Compensated::new(T::zero()));
        let impulses = &mut product.impulses;
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
        self.scratch.give_back(product);
    }

    /// [`residual`](Self::residual), with w rounded about once: the same number, for the price of several, and the one
    /// to believe where W r and b cancel.
    ///
    /// # Panics
    /// If `r` has not one block per contact.
    pub fn precise_residual(&self, r: &[SVector<T, D>]) -> Residual<T> {
        assert_eq!(r.len(), self.contacts(), "one percussion per contact");
        self.measure(r, |visit| self.precise_velocities(r, visit))
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
        if self.factors().is_some() {
            return T::zero();
        }
        let mut square = T::zero();
        for (i, b) in self.b().iter().enumerate() {
            let mut size = b.abs();
            self.delassus().row(i).for_each(|(j, block)| size += block.abs() * r[j].abs());
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
    pub(crate) fn solved_to_rounding(&self, r: &[SVector<T, D>], residual: T) -> bool {
        let floor = self.floor(r);
        Self::is_near_floor(residual, floor) && self.precise_residual(r).scaled <= floor
    }

    /// Takes the H and the reciprocals of the diagonal M̂ that W was formed of, or gives them back: in exchange for none.
    pub(crate) fn exchange_bodies(&mut self, jacobian: &mut BlockRows<T, D>, inverse: &mut Vec<T>) {
        std::mem::swap(&mut self.bodies.rows, jacobian);
        std::mem::swap(&mut self.bodies.inverse, inverse);
    }

    /// Takes M̂ of `whole`, or gives it back: a part of a problem has it while it is solved.
    pub(crate) fn exchange_masses(&mut self, whole: &mut Self) {
        std::mem::swap(&mut self.bodies.inverse, &mut whole.bodies.inverse);
    }

    /// Takes the rows of H of the contacts `contacts` of `whole`, of which this problem is a part; M̂ is exchanged apart.
    pub(crate) fn take_rows(&mut self, whole: &Self, contacts: &[usize]) {
        let (own, rows) = (&mut self.bodies.rows, &whole.bodies.rows);
        own.clear();
        for &contact in contacts.iter().filter(|&&contact| contact < rows.rows()) {
            own.start_row();
            rows.row(contact).for_each(|(dof, &h)| own.push(dof, h));
        }
    }
}
