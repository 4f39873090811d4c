//! Assembly of the Delassus operator W = H M̂⁻¹ Hᵀ of the active contacts.

use nalgebra::SMatrix;

use crate::cone::BlockMatrix;
use crate::linalg::{BlockRows, Factor};
use crate::scalar::Scalar;

const NONE: usize = usize::MAX;

/// Assembles W in place; its buffers grow to the largest active set seen and then stay.
#[derive(Debug)]
pub(super) struct Assembler<T: Scalar, const D: usize> {
    /// First entry of H in the column of each degree of freedom, and for each entry the next one and its row.
    head: Vec<usize>,
    next: Vec<(usize, usize)>,
    /// Place in `row` of the block of each contact, while one block row is summed.
    place: Vec<usize>,
    row: Vec<(usize, SMatrix<T, D, D>)>,
    /// One column of M̂⁻¹ Hᵀ, and the upper triangle of a full W.
    column: Vec<T>,
    /// Degrees of freedom that M̂ has rows for, the first ones; the others are prescribed.
    free: usize,
    full: Vec<SMatrix<T, D, D>>,
}

impl<T: Scalar, const D: usize> Assembler<T, D> {
    pub(super) fn new(dofs: usize, free: usize) -> Self {
        Self {
            head: vec![NONE; dofs],
            next: Vec::new(),
            place: Vec::new(),
            row: Vec::new(),
            column: vec![T::zero(); dofs],
            free,
            full: Vec::new(),
        }
    }

    /// w ← H M̂⁻¹ Hᵀ.
    pub(super) fn assemble(
        &mut self,
        h: &BlockRows<T, D>,
        factor: &mut Factor<T>,
        w: &mut BlockMatrix<T, D>,
    ) {
        match factor {
            Factor::Diagonal(inverse) => {
                self.assemble_pair(h, h, inverse, w);
            }
            factor => {
                let free = self.free;
                let apply = |x: &mut [T]| {
                    factor.solve_in_place(&mut x[..free]);
                    x[free..].fill(T::zero());
                };
                self.assemble_with(h, apply, w);
            }
        }
    }

    /// w ← G A⁻¹ Hᵀ for rows G and H of one pattern and a diagonal A, given by its `inverse`: rows couple only through
    /// degrees of freedom they share.
    pub(super) fn assemble_pair(
        &mut self,
        g: &BlockRows<T, D>,
        h: &BlockRows<T, D>,
        inverse: &[T],
        w: &mut BlockMatrix<T, D>,
    ) {
        w.clear();
        self.next.clear();
        for row in 0..h.rows() {
            for (dof, _) in h.row(row) {
                let entry = self.next.len();
                self.next.push((std::mem::replace(&mut self.head[dof], entry), row));
            }
        }
        self.place.clear();
        self.place.resize(h.rows(), NONE);
        for row in 0..h.rows() {
            self.row.clear();
            for (dof, left) in g.row(row).filter(|&(dof, _)| dof < self.free) {
                let weighted = left * inverse[dof];
                let mut entry = self.head[dof];
                while entry != NONE {
                    let (next, other) = self.next[entry];
                    let block = weighted * h.entry(entry).transpose();
                    match self.place[other] {
                        NONE => {
                            self.place[other] = self.row.len();
                            self.row.push((other, block));
                        }
                        place => self.row[place].1 += block,
                    }
                    entry = next;
                }
            }
            self.row.iter().for_each(|&(other, _)| self.place[other] = NONE);
            self.row.sort_unstable_by_key(|&(other, _)| other);
            w.start_row();
            self.row.iter().for_each(|&(other, block)| w.push(other, block));
        }
        for row in 0..h.rows() {
            h.row(row).for_each(|(dof, _)| self.head[dof] = NONE);
        }
    }

    /// w ← H P Hᵀ for a symmetric operator `apply`: x ← P x.
    ///
    /// A coupled P makes W full: one product per scalar row of H, and the triangle is mirrored. Blocks that are zero
    /// to the last digit, between parts that do not touch, are left out.
    pub(super) fn assemble_with(
        &mut self,
        h: &BlockRows<T, D>,
        mut apply: impl FnMut(&mut [T]),
        w: &mut BlockMatrix<T, D>,
    ) {
        w.clear();
        let m = h.rows();
        self.full.clear();
        self.full.resize(m * m, SMatrix::zeros());
        for a in 0..m {
            for d in 0..D {
                self.column.fill(T::zero());
                h.row(a).for_each(|(dof, entry)| self.column[dof] += entry[d]);
                apply(&mut self.column);
                for b in 0..=a {
                    self.full[b * m + a].set_column(d, &h.velocity(b, &self.column));
                }
            }
        }
        for i in 0..m {
            w.start_row();
            for j in 0..m {
                let block = if i <= j { self.full[i * m + j] } else { self.full[j * m + i].transpose() };
                if i == j || block.iter().any(|&x| x != T::zero()) {
                    w.push(j, block);
                }
            }
        }
    }
}
