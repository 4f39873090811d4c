//! Matrices over the rows of the joints.

use nalgebra::SVector;

use super::laws::Laws;
use crate::cone::BlockMatrix;
use crate::linalg::{BlockRows, Factor, Multifrontal, SolveBuffers};
use crate::scalar::Scalar;
use crate::scheme::delassus::Assembler;

/// A matrix over the rows of the joints, and its factors.
#[derive(Debug)]
pub(super) struct Schur<T: Scalar> {
    matrix: BlockMatrix<T, 1>,
    values: Vec<T>,
    /// Whether it is the response to percussions.
    percussions: bool,
    /// Ridges on the diagonal.
    pub(super) ridges: Vec<T>,
    factor: Multifrontal<T>,
    buffers: SolveBuffers<T>,
}

impl<T: Scalar> Schur<T> {
    pub(super) fn new(rows: usize, percussions: bool) -> Self {
        Self {
            percussions,
            matrix: BlockMatrix::new(),
            values: Vec::new(),
            ridges: vec![T::zero(); rows],
            factor: Multifrontal::new(),
            buffers: SolveBuffers::default(),
        }
    }

    /// Factors G K̂⁻¹ Ḡᵀ over the active rows, with what their laws add to its diagonal at θ; K̂ is that of `inverse` where it
    /// is diagonal.
    pub(super) fn factor(
        &mut self,
        assembler: &mut Assembler<T, 1>,
        (left, right): (&BlockRows<T, 1>, &BlockRows<T, 1>),
        (mass, inverse): (&mut Factor<T>, &[T]),
        (laws, theta): (&Laws<T>, &impl Fn(usize) -> T),
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
        if laws.any || laws.redundant {
            for row in 0..right.rows() {
                let columns = &columns[starts[row]..starts[row + 1]];
                let Ok(place) = columns.binary_search(&row) else { continue };
                let theta = theta(right.row(row).next().map_or(0, |(dof, _)| dof));
                let entry = &mut self.values[starts[row] + place];
                let (gain, ridge) = laws.gain(row, *entry, theta, self.percussions);
                *entry += gain;
                self.ridges[row] = ridge;
            }
        } else {
            self.ridges.fill(T::zero());
        }
        self.factor.analyse(starts, columns, 1).map_err(|error| error.row)?;
        self.factor.factor(&self.values, &laws.active).map_err(|error| error.node)
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
