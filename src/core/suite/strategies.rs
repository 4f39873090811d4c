//! Random mechanical systems with contacts, for which a solution of the cone problem exists.

use nalgebra::{SMatrix, SVector};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::cone::{BlockMatrix, Cone, ConeProblem};
use crate::laws::{Approach, ContactLaw, Rows};
use crate::linalg::BlockRows;

/// A system of diagonal mass at an impact: M, H, v_k and v_free.
///
/// The first degree of freedom lifts every contact at once and moves none sideways, so that a velocity with
/// u_N > 0, u_T = 0 at all contacts exists and the cone problem has a solution for any b and μ. Where m D exceeds
/// the number of degrees of freedom, W is singular.
#[derive(Debug, Clone)]
pub struct RandomSystem<const D: usize> {
    /// Diagonal of M, n entries.
    pub mass: Vec<f64>,
    /// H, m block rows over n columns.
    pub jacobian: BlockRows<f64, D>,
    /// v_k.
    pub before: Vec<f64>,
    /// v_free.
    pub free: Vec<f64>,
}

impl<const D: usize> RandomSystem<D> {
    /// Number of contacts m.
    pub fn contacts(&self) -> usize {
        self.jacobian.rows()
    }

    /// u_k = H v_k.
    pub fn local_before(&self) -> Vec<SVector<f64, D>> {
        (0..self.contacts()).map(|i| self.jacobian.velocity(i, &self.before)).collect()
    }

    /// H v_free.
    pub fn local_free(&self) -> Vec<SVector<f64, D>> {
        (0..self.contacts()).map(|i| self.jacobian.velocity(i, &self.free)).collect()
    }

    /// W = H M⁻¹ Hᵀ.
    pub fn delassus(&self) -> BlockMatrix<f64, D> {
        let n = self.mass.len();
        let dense = |row: usize| {
            let mut columns = vec![SVector::<f64, D>::zeros(); n];
            self.jacobian.row(row).for_each(|(j, h)| columns[j] += h);
            columns
        };
        let rows: Vec<_> = (0..self.contacts()).map(dense).collect();
        BlockMatrix::from_fn(rows.len(), |a, b| {
            let product = |j: usize| rows[a][j] * rows[b][j].transpose() / self.mass[j];
            (0..n).map(product).sum::<SMatrix<f64, D, D>>()
        })
    }

    /// The cone problem with b = H v_free + δ.
    ///
    /// # Panics
    /// If `shifts` or `cones` have not one entry per contact, or are out of range.
    pub fn problem(
        &self,
        shifts: &[SVector<f64, D>],
        cones: Vec<impl Into<Cone<f64>>>,
    ) -> ConeProblem<f64, D> {
        let b = self.local_free().iter().zip(shifts).map(|(u, shift)| u + shift).collect();
        ConeProblem::new(self.delassus(), b, cones).expect("H M⁻¹ Hᵀ is symmetric and semidefinite")
    }
}

/// Systems of 1 to `most` contacts; about half of the Delassus operators are singular.
pub fn random_system<const D: usize>(most: usize) -> impl Strategy<Value = RandomSystem<D>> {
    let sizes = (1..=most).prop_flat_map(|m| (Just(m), 1..=2 * m * D));
    sizes.prop_flat_map(|(m, n)| {
        let entries = vec(-1.0..1.0, m * n * D);
        let lift = vec(0.2..1.0, m);
        let mass = vec(0.1..10.0, n + 1);
        let state = (vec(-1.0..1.0, n + 1), vec(-0.3..0.3, n + 1));
        (entries, lift, mass, state).prop_map(move |(entries, lift, mass, (before, change))| {
            let mut jacobian = BlockRows::new();
            for (row, lift) in lift.iter().enumerate() {
                jacobian.start_row();
                jacobian.push(0, SVector::from_fn(|i, _| if i == 0 { *lift } else { 0.0 }));
                for column in 0..n {
                    let at = (row * n + column) * D;
                    jacobian.push(column + 1, SVector::from_column_slice(&entries[at..at + D]));
                }
            }
            let free = before.iter().zip(change).map(|(v, change): (&f64, f64)| v + change).collect();
            RandomSystem { mass, jacobian, before, free }
        })
    })
}

/// What a law is asked of a contact with the rows that it needs.
pub(super) fn asked<'a, const D: usize>(
    law: &dyn ContactLaw<f64, D>,
    at: Approach<'a, f64, D>,
) -> Approach<'a, f64, D> {
    if D > 2 && law.rows() == Rows::Rolling { at.with_rows(Rows::Rolling) } else { at }
}
