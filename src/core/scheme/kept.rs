//! The Delassus operator of all candidates, kept where H is constant.

use nalgebra::SMatrix;

use super::delassus::Assembler;
use super::{ContactStep, SetupError};
use crate::cone::BlockMatrix;
use crate::contact::ContactId;
use crate::linalg::{BlockRows, Factor};
use crate::scalar::{Scalar, all_finite};
use crate::system::System;

/// Most numbers W of all candidates may have (128 MiB in double precision); beyond, W is assembled at every step.
const LARGEST: usize = 1 << 24;

/// H of all candidates, ordered by identity.
#[derive(Clone)]
pub(super) struct ConstantRows<T: Scalar, const D: usize> {
    ids: Vec<ContactId>,
    rows: BlockRows<T, D>,
}

/// The rows of a system whose Jacobian is constant; `None` where W of all candidates would be too large to keep.
pub(super) fn constant_rows<T: Scalar, const D: usize>(
    system: &mut dyn System<T, D>,
    q: &[T],
) -> Result<Option<ConstantRows<T, D>>, SetupError> {
    let mut candidates = Vec::new();
    system.candidates(q, T::infinity_impl(), &mut candidates);
    let scalars = candidates.len().saturating_mul(D);
    if scalars.saturating_mul(scalars) > LARGEST {
        return Ok(None);
    }
    let mut ids: Vec<ContactId> = candidates.iter().map(|candidate| candidate.id).collect();
    ids.sort_unstable();
    let mut rows = BlockRows::new();
    for (row, &id) in ids.iter().enumerate() {
        system.jacobian(id, q, &mut rows);
        let inside = rows.largest_column(row).is_none_or(|column| column < system.dofs());
        if !(inside && rows.row(row).all(|(_, entry)| all_finite(entry.iter()))) {
            return Err(SetupError::ConstantRow { contact: system.contact_label(id), dofs: system.dofs() });
        }
    }
    Ok(Some(ConstantRows { ids, rows }))
}

impl<T: Scalar, const D: usize> ConstantRows<T, D> {
    /// The free degrees of freedom that contacts move.
    pub(super) fn dofs(&self, free: usize) -> Vec<usize> {
        let rows = 0..self.ids.len();
        let columns = rows.flat_map(|row| self.rows.row(row).map(|(dof, _)| dof));
        columns.filter(|&dof| dof < free).collect()
    }

    /// H itself.
    pub(super) fn rows(&self) -> &BlockRows<T, D> {
        &self.rows
    }

    /// W = H M̂⁻¹ Hᵀ, with the factors of M̂ over the first `free` degrees of freedom.
    pub(super) fn delassus(self, factor: &mut Factor<T>, free: usize) -> Kept<T, D> {
        let m = self.ids.len();
        let mut w: Vec<SMatrix<T, D, D>> = vec![SMatrix::zeros(); m * m];
        let dofs = (0..m).flat_map(|row| self.rows.row(row).map(|(dof, _)| dof + 1)).max().unwrap_or(0);
        if let Factor::Sparse(factor) = factor {
            // Percussions reach the last unknowns alone: the solve never leaves them.
            let mut column = vec![T::zero(); dofs.max(free)];
            for a in 0..m {
                for d in 0..D {
                    factor.clear();
                    for (dof, entry) in self.rows.row(a).filter(|&(dof, _)| dof < free) {
                        factor.add(dof, entry[d]);
                    }
                    factor.last_unknowns(&mut column[..free]);
                    for b in 0..=a {
                        w[b * m + a].set_column(d, &self.rows.velocity(b, &column));
                    }
                }
            }
            for a in 0..m {
                // Symmetric to the last digit.
                let block: SMatrix<T, D, D> = w[a * m + a];
                w[a * m + a] = (block + block.transpose()) * crate::scalar::lit::<T>(0.5);
                for b in 0..a {
                    w[a * m + b] = w[b * m + a].transpose();
                }
            }
        } else {
            let mut blocks = BlockMatrix::new();
            Assembler::new(dofs.max(free), free).assemble(&self.rows, factor, &mut blocks);
            for a in 0..m {
                blocks.row(a).for_each(|(b, block)| w[a * m + b] = *block);
            }
        }
        Kept { ids: self.ids, w, active: Vec::new(), selected: Vec::new() }
    }
}

/// W of all candidates.
#[derive(Debug)]
pub(super) struct Kept<T: Scalar, const D: usize> {
    ids: Vec<ContactId>,
    w: Vec<SMatrix<T, D, D>>,
    /// Places of the active contacts, and those that the problem holds the rows of.
    active: Vec<usize>,
    selected: Vec<usize>,
}

impl<T: Scalar, const D: usize> Kept<T, D> {
    /// Numbers kept.
    pub(super) fn numbers(&self) -> usize {
        self.w.len() * D * D
    }

    /// The problem holds the rows of another operator.
    pub(super) fn forget_selection(&mut self) {
        self.selected.clear();
    }

    /// w ← all of it.
    pub(super) fn all(&self, w: &mut BlockMatrix<T, D>) {
        let m = self.ids.len();
        w.clear();
        for a in 0..m {
            w.start_row();
            (0..m).for_each(|b| w.push(b, self.w[a * m + b]));
        }
    }

    /// w ← the rows and columns of the active contacts, which are ordered by identity; left alone where they are
    /// those of the last step.
    ///
    /// # Errors
    /// A contact that was not among the candidates of an infinite reach.
    pub(super) fn select(
        &mut self,
        contacts: &[ContactStep<T, D>],
        w: &mut BlockMatrix<T, D>,
    ) -> Result<(), ContactId> {
        let mut place = 0;
        self.active.clear();
        for contact in contacts {
            place += self.ids[place..].iter().take_while(|&&id| id < contact.id).count();
            if self.ids.get(place) != Some(&contact.id) {
                return Err(contact.id);
            }
            self.active.push(place);
        }
        if self.active == self.selected && w.rows() == self.active.len() {
            return Ok(());
        }
        self.selected.clone_from(&self.active);
        w.clear();
        let m = self.ids.len();
        for &a in &self.active {
            w.start_row();
            for (column, &b) in self.active.iter().enumerate() {
                w.push(column, self.w[a * m + b]);
            }
        }
        Ok(())
    }
}
