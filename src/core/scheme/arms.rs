//! Contacts that roll: moments are measured at a lever arm, so that all rows of a cone problem have one unit.
//!
//! A contact with rows (N, T, R) or (N, T1, T2, R1, R2, S) mixes N s with N m s, m/s with rad/s; the norms by which solvers
//! size steps and residuals would depend on the unit of length. With an arm ℓ_α the cone problem of the step holds m/ℓ_α in
//! the place of m, ℓ_α ω in that of ω and μ_R/ℓ_α in that of μ_R; everything else in the scheme has SI units.

use nalgebra::SVector;

use crate::cone::BlockMatrix;
use crate::linalg::{BlockRows, Symmetric};
use crate::scalar::Scalar;

/// The arms of the active contacts, ℓ_α² = (H_N diag(M)⁻¹ H_Nᵀ)/(H_R diag(M)⁻¹ H_Rᵀ): a percussion along the normal and a
/// moment divided by the arm are equally effective. For a disc it is its radius of gyration.
#[derive(Debug)]
pub(super) struct Arms<T> {
    /// 1/M_jj; empty where no law rolls.
    mobility: Vec<T>,
    lengths: Vec<T>,
}

/// The components that are moments.
const fn moments(dimension: usize) -> std::ops::Range<usize> {
    if dimension == 6 { 3..6 } else { 2..dimension }
}

impl<T: Scalar> Arms<T> {
    pub(super) fn new(rolls: bool, mass: &Symmetric<T>) -> Self {
        let mut mobility = Vec::new();
        if rolls {
            mobility.resize(mass.size(), T::zero());
            // What moves as told may have no mass.
            let diagonal = mass.entries().filter(|&(i, j, m)| i == j && m > T::zero());
            diagonal.for_each(|(i, _, m)| mobility[i] = T::one() / m);
        }
        Self { mobility, lengths: Vec::new() }
    }

    /// Whether a law rolls, and contacts have rows for moments.
    pub(super) fn rolls(&self) -> bool {
        !self.mobility.is_empty()
    }

    /// Takes the arms of the contacts with H in `rows`, and measures the moments of W at them.
    pub(super) fn measure<const D: usize>(&mut self, rows: &BlockRows<T, D>, w: &mut BlockMatrix<T, D>) {
        self.lengths.clear();
        for row in 0..rows.rows() {
            let (mut normal, mut turning) = (T::zero(), T::zero());
            for (dof, h) in rows.row(row) {
                normal += h[0] * h[0] * self.mobility[dof];
                moments(D).for_each(|k| turning += h[k] * h[k] * self.mobility[dof]);
            }
            // The mean over the moments; bodies that cannot turn have none.
            let square = normal * crate::scalar::from_usize::<T>(moments(D).len()) / turning;
            let sound = turning > T::zero() && square > T::zero() && crate::scalar::all_finite([&square]);
            self.lengths.push(if sound { nalgebra::ComplexField::sqrt(square) } else { T::one() });
        }
        let lengths = &self.lengths;
        w.for_each_block(|row, column, block| {
            for k in moments(D) {
                block.row_mut(k).iter_mut().for_each(|x| *x *= lengths[row]);
                block.column_mut(k).iter_mut().for_each(|x| *x *= lengths[column]);
            }
        });
    }

    /// The arm of a contact (m), 1 where nothing rolls.
    pub(super) fn length(&self, contact: usize) -> T {
        self.lengths.get(contact).copied().filter(|_| self.rolls()).unwrap_or_else(T::one)
    }

    /// A velocity as the cone problem has it.
    pub(super) fn enter_velocity<const D: usize>(&self, contact: usize, u: &SVector<T, D>) -> SVector<T, D> {
        self.scaled(u, self.length(contact))
    }

    /// A percussion as the cone problem has it.
    pub(super) fn enter<const D: usize>(&self, contact: usize, p: &SVector<T, D>) -> SVector<T, D> {
        self.scaled(p, T::one() / self.length(contact))
    }

    /// Percussions of the cone problem in SI units.
    pub(super) fn leave<const D: usize>(&self, percussions: &mut [SVector<T, D>]) {
        if self.rolls() {
            percussions.iter_mut().enumerate().for_each(|(i, p)| *p = self.scaled(p, self.length(i)));
        }
    }

    fn scaled<const D: usize>(&self, x: &SVector<T, D>, factor: T) -> SVector<T, D> {
        let mut x = *x;
        if self.rolls() {
            moments(D).for_each(|k| x[k] *= factor);
        }
        x
    }
}
