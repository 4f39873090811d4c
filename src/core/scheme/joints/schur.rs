//! Matrices over the rows of the joints.

use nalgebra::SVector;

use crate::cone::BlockMatrix;
use crate::linalg::{BlockRows, Factor, Multifrontal, SolveBuffers};
use crate::scalar::Scalar;
use crate::scheme::delassus::Assembler;

/// A matrix over the rows of the joints, and its factors.
#[derive(Debug)]
pub(super) struct Schur<T: Scalar> {
    matrix: BlockMatrix<T, 1>,
    values: Vec<T>,
    active: Vec<bool>,
    factor: Multifrontal<T>,
    buffers: SolveBuffers<T>,
}

impl<T: Scalar> Schur<T> {
    pub(super) fn new(rows: usize) -> Self {
        Self {
            matrix: BlockMatrix::new(),
            values: Vec::new(),
            active: vec![true; rows],
            factor: Multifrontal::new(),
            buffers: SolveBuffers::default(),
        }
    }

    /// Factors G K̂⁻¹ Ḡᵀ, K̂ diagonal where an `inverse` is given.
    pub(super) fn factor(
        &mut self,
        assembler: &mut Assembler<T, 1>,
        (left, right): (&BlockRows<T, 1>, &BlockRows<T, 1>),
        mass: &mut Factor<T>,
        inverse: &[T],
        column: &mut [T],
    ) -> Result<(), usize> {
        if matches!(mass, Factor::Diagonal(_)) {
            assembler.assemble_pair(left, right, inverse, &mut self.matrix);
            self.values.clear();
            self.values.extend(self.matrix.blocks().iter().map(|block| block[(0, 0)]));
        } else {
            let (rows, one) = (right.rows(), SVector::<T, 1>::new(T::one()));
            self.matrix.clear();
            for _ in 0..rows {
                self.matrix.start_row();
                (0..rows).for_each(|j| self.matrix.push(j, one));
            }
            self.values.resize(rows * rows, T::zero());
            for j in 0..rows {
                column.fill(T::zero());
                right.add_transpose(j, &one, column);
                solve(mass, inverse, column);
                for i in 0..rows {
                    self.values[i * rows + j] = left.velocity(i, column)[0];
                }
            }
        }
        let (starts, columns) = self.matrix.pattern();
        self.factor.analyse(starts, columns, 1).map_err(|error| error.row)?;
        self.factor.factor(&self.values, &self.active).map_err(|error| error.node)
    }

    pub(super) fn solve(&mut self, x: &mut [T]) {
        self.factor.solve(x, &mut self.buffers);
    }
}

/// x ← K̂⁻¹ x over the free degrees of freedom, zero elsewhere.
pub(super) fn solve<T: Scalar>(mass: &mut Factor<T>, inverse: &[T], x: &mut [T]) {
    let free = mass.size();
    x[free..].fill(T::zero());
    match mass {
        Factor::Diagonal(_) => x.iter_mut().zip(inverse).for_each(|(x, &inverse)| *x *= inverse),
        mass => mass.solve_in_place(&mut x[..free]),
    }
}
