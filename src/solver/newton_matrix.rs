//! Linear systems C W + A of contacts: dense LU of the closed contacts, or sparse LU on the graph of W.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::perm::PermRef;
use faer::sparse::linalg::lu::{LuRef, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, MatRef, Par, Spec};
use nalgebra::{SMatrix, SVector};

use crate::cone::BlockMatrix;
use crate::scalar::{Scalar, all_finite};

/// Systems of up to this many scalar rows are dense whatever the graph of W.
const SMALL: usize = 200;

/// Scratch memory of the factorisations.
#[derive(Default)]
struct Scratch {
    memory: Option<MemBuffer>,
    bytes: usize,
}

impl std::fmt::Debug for Scratch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Scratch").field("bytes", &self.bytes).finish_non_exhaustive()
    }
}

impl Scratch {
    /// A stack of at least `need`, grown when it is too small.
    fn reserve(&mut self, need: StackReq) -> Result<&mut MemStack, String> {
        let bytes = need.unaligned_bytes_required();
        if self.memory.is_none() || self.bytes < bytes {
            self.memory = Some(MemBuffer::try_new(need).map_err(|_| "out of memory".to_string())?);
            self.bytes = bytes;
        }
        self.stack()
    }

    fn stack(&mut self) -> Result<&mut MemStack, String> {
        Ok(MemStack::new(self.memory.as_mut().ok_or("the matrix was not factored")?))
    }
}

/// The linear system of a Newton step, factored in buffers that are kept.
#[derive(Debug)]
pub(super) struct NewtonMatrix<T: Scalar, const D: usize> {
    rows: Vec<Option<(SMatrix<T, D, D>, SMatrix<T, D, D>)>>,
    /// Place of each contact's block among the unknowns; `usize::MAX` for one that was eliminated.
    place: Vec<usize>,
    size: usize,
    values: Vec<T>,
    forward: Vec<usize>,
    inverse: Vec<usize>,
    rhs: Vec<T>,
    scratch: Scratch,
    graph: Graph,
    symbolic: Option<SymbolicLu<usize>>,
    numeric: NumericLu<usize, T>,
    dense: bool,
}

/// The graph of W as compressed scalar columns.
#[derive(Debug, Default)]
struct Graph {
    starts: Vec<usize>,
    rows: Vec<usize>,
    /// Place of the first scalar of each stored block, in the order of W's rows, and the stride of its columns.
    blocks: Vec<(usize, usize)>,
}

impl<T: Scalar, const D: usize> Default for NewtonMatrix<T, D> {
    fn default() -> Self {
        Self {
            rows: Vec::new(),
            place: Vec::new(),
            size: 0,
            values: Vec::new(),
            forward: Vec::new(),
            inverse: Vec::new(),
            rhs: Vec::new(),
            scratch: Scratch::default(),
            graph: Graph::default(),
            symbolic: None,
            numeric: NumericLu::new(),
            dense: true,
        }
    }
}

impl<T: Scalar, const D: usize> NewtonMatrix<T, D> {
    /// Chooses dense or sparse for the graph of `w`, and orders it if it differs from the last one.
    ///
    /// # Errors
    /// The words of the ordering that failed (out of memory).
    pub(super) fn analyse(&mut self, w: &BlockMatrix<T, D>) -> Result<(), String> {
        let m = w.rows();
        // A quarter of the blocks fills in to nearly all of them.
        self.dense = m * D <= SMALL || w.stored_blocks() * 4 >= m * m;
        if self.dense {
            return Ok(());
        }
        if self.symbolic.is_some() && self.graph.is_of(w) {
            return Ok(());
        }
        self.graph = Graph::new(w);
        let n = m * D;
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &self.graph.starts, None, &self.graph.rows);
        self.symbolic =
            Some(factorize_symbolic_lu(pattern, Default::default()).map_err(|e| format!("{e:?}"))?);
        Ok(())
    }

    /// Factors the matrix with rows left_α W_α· + diagonal_α, where `row(α)` gives (left, diagonal), or `None`
    /// for a contact whose unknown is known and is eliminated.
    ///
    /// # Errors
    /// In words, where the factorisation fails.
    pub(super) fn factor(
        &mut self,
        w: &BlockMatrix<T, D>,
        mut row: impl FnMut(usize) -> Option<(SMatrix<T, D, D>, SMatrix<T, D, D>)>,
    ) -> Result<(), String> {
        self.place.clear();
        self.rows.clear();
        self.rows.extend((0..w.rows()).map(&mut row));
        let mut next = 0;
        for row in &self.rows {
            let keep = row.is_some() || !self.dense;
            self.place.push(if keep { next } else { usize::MAX });
            next += if keep { D } else { 0 };
        }
        self.size = next;
        let n = next;
        self.values.clear();
        self.values.resize(if self.dense { n * n } else { self.graph.rows.len() }, T::zero());
        let mut stored = 0;
        for (i, row) in self.rows.iter().enumerate() {
            for (j, block) in w.row(i) {
                let (first, stride) = if self.dense {
                    (self.place[j].wrapping_mul(n).wrapping_add(self.place[i]), n)
                } else {
                    self.graph.blocks[stored]
                };
                stored += 1;
                let entries = match (row, &self.rows[j]) {
                    (Some((left, diagonal)), Some(_)) => {
                        let product = left * block;
                        if i == j { product + diagonal } else { product }
                    }
                    (None, None) if i == j && !self.dense => SMatrix::identity(),
                    _ => continue,
                };
                for c in 0..D {
                    for r in 0..D {
                        self.values[first + c * stride + r] = entries[(r, c)];
                    }
                }
            }
        }
        if !all_finite(&self.values) {
            return Err("the Newton matrix is not finite".into());
        }
        self.factor_values()
    }

    fn factor_values(&mut self) -> Result<(), String> {
        let n = self.size;
        self.forward.resize(n, 0);
        self.inverse.resize(n, 0);
        if n == 0 {
            return Ok(());
        }
        if self.dense {
            let need = factor::lu_in_place_scratch::<usize, T>(n, n, Par::Seq, Spec::default())
                .or(solve::solve_in_place_scratch::<usize, T>(n, 1, Par::Seq));
            let stack = self.scratch.reserve(need)?;
            factor::lu_in_place(
                MatMut::from_column_major_slice_mut(&mut self.values, n, n),
                &mut self.forward,
                &mut self.inverse,
                Par::Seq,
                stack,
                Spec::default(),
            );
            return Ok(());
        }
        let symbolic = self.symbolic.as_ref().ok_or("the matrix was not analysed")?;
        let need = symbolic
            .factorize_numeric_lu_scratch::<T>(Par::Seq, Spec::default())
            .or(symbolic.solve_in_place_scratch::<T>(1, Par::Seq));
        let stack = self.scratch.reserve(need)?;
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &self.graph.starts, None, &self.graph.rows);
        let matrix = SparseColMatRef::new(pattern, &self.values);
        symbolic
            .factorize_numeric_lu(&mut self.numeric, matrix, Par::Seq, stack, Spec::default())
            .map(|_| ())
            .map_err(|e| format!("{e:?}"))
    }

    /// Solves for the kept contacts: `x` holds the right-hand side and receives the solution; the entries of
    /// eliminated contacts are left alone.
    ///
    /// # Errors
    /// In words, where a pivot was so small that the solution is not finite.
    pub(super) fn solve(&mut self, x: &mut [SVector<T, D>]) -> Result<(), String> {
        let n = self.size;
        if n == 0 {
            return Ok(());
        }
        self.rhs.resize(n, T::zero());
        for (&place, x) in self.place.iter().zip(x.iter()).filter(|(place, _)| **place != usize::MAX) {
            self.rhs[place..place + D].copy_from_slice(x.as_slice());
        }
        let stack = self.scratch.stack()?;
        let rhs = MatMut::from_column_major_slice_mut(&mut self.rhs, n, 1);
        if self.dense {
            let factors = MatRef::from_column_major_slice(&self.values, n, n);
            let rows = PermRef::new_checked(&self.forward, &self.inverse, n);
            solve::solve_in_place_with_conj(factors, factors, rows, Conj::No, rhs, Par::Seq, stack);
        } else {
            let symbolic = self.symbolic.as_ref().ok_or("the matrix was not analysed")?;
            LuRef::new_unchecked(symbolic, &self.numeric).solve_in_place_with_conj(
                Conj::No,
                rhs,
                Par::Seq,
                stack,
            );
        }
        if !all_finite(&self.rhs) {
            return Err("the Newton matrix is singular".into());
        }
        for (&place, x) in self.place.iter().zip(x.iter_mut()).filter(|(place, _)| **place != usize::MAX) {
            x.copy_from_slice(&self.rhs[place..place + D]);
        }
        Ok(())
    }
}

impl Graph {
    /// Whether this is the graph of `w`.
    fn is_of<T: Scalar, const D: usize>(&self, w: &BlockMatrix<T, D>) -> bool {
        if self.starts.len() != w.rows() * D + 1 || self.blocks.len() != w.stored_blocks() {
            return false;
        }
        let entries = (0..w.rows()).flat_map(|i| w.row(i).map(move |(j, _)| (i, j)));
        entries.zip(&self.blocks).all(|((i, j), &(first, _))| {
            (self.starts[j * D]..self.starts[j * D + 1]).contains(&first) && self.rows[first] == i * D
        })
    }

    fn new<T: Scalar, const D: usize>(w: &BlockMatrix<T, D>) -> Self {
        let m = w.rows();
        let mut counts = vec![0; m];
        for i in 0..m {
            w.row(i).for_each(|(j, _)| counts[j] += 1);
        }
        let mut starts = vec![0];
        for &count in &counts {
            for _ in 0..D {
                starts.push(starts[starts.len() - 1] + count * D);
            }
        }
        let mut rows = vec![0; starts[m * D]];
        let mut blocks = Vec::with_capacity(w.stored_blocks());
        let mut filled = vec![0; m];
        for i in 0..m {
            for (j, _) in w.row(i) {
                let (first, stride) = (starts[j * D] + filled[j] * D, counts[j] * D);
                filled[j] += 1;
                blocks.push((first, stride));
                for c in 0..D {
                    for r in 0..D {
                        rows[first + c * stride + r] = i * D + r;
                    }
                }
            }
        }
        Self { starts, rows, blocks }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;
    use proptest::prelude::*;

    /// A band of blocks wide enough to be sparse, and the same matrix with every block stored, which is dense.
    fn pair(contacts: usize, values: &[f64]) -> [BlockMatrix<f64, 2>; 2] {
        let entry = |i: usize, j: usize| {
            let near = i.abs_diff(j) <= 1;
            SMatrix::<f64, 2, 2>::from_fn(|r, c| {
                let diagonal = if (i, r) == (j, c) { 6.0 } else { 0.0 };
                if near { diagonal + values[(7 * i + 3 * j + 2 * r + c) % values.len()] } else { 0.0 }
            })
        };
        let mut band = BlockMatrix::new();
        for i in 0..contacts {
            band.start_row();
            (0..contacts).filter(|j| i.abs_diff(*j) <= 1).for_each(|j| band.push(j, entry(i, j)));
        }
        [band, BlockMatrix::from_fn(contacts, entry)]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn sparse_and_dense_systems_have_the_solution(
            contacts in 110usize..130,
            values in proptest::collection::vec(-1.0..1.0f64, 53),
        ) {
            let row = |i: usize| (i % 3 != 1).then(|| {
                (SMatrix::<f64, 2, 2>::identity() * (1.0 + (i % 5) as f64), SMatrix::identity())
            });
            let rhs: Vec<_> = (0..contacts).map(|i| SVector::<f64, 2>::new(values[i % 53], 1.0)).collect();
            let mut solutions = Vec::new();
            for (w, dense) in pair(contacts, &values).iter().zip([false, true]) {
                let mut matrix = NewtonMatrix::default();
                // Twice, so that the kept ordering is used too.
                for _ in 0..2 {
                    prop_assert!(matrix.analyse(w).is_ok());
                    prop_assert_eq!(matrix.dense, dense);
                    prop_assert_eq!(matrix.factor(w, row), Ok(()));
                }
                let mut x = rhs.clone();
                prop_assert_eq!(matrix.solve(&mut x), Ok(()));
                for (i, b) in rhs.iter().enumerate() {
                    let Some((left, diagonal)) = row(i) else {
                        prop_assert_eq!(x[i], *b);
                        continue;
                    };
                    let kept = w.row(i).filter(|(j, _)| row(*j).is_some());
                    let product = kept.fold(diagonal * x[i], |sum, (j, block)| sum + left * block * x[j]);
                    // The matrix is diagonally dominant, condition ≤ 100.
                    prop_assert!((product - b).norm() <= 1e-12 * (1.0 + b.norm()));
                }
                solutions.push(DMatrix::from_fn(contacts, 2, |i, d| x[i][d]));
            }
            prop_assert!((&solutions[0] - &solutions[1]).norm() <= 1e-12 * solutions[0].norm());
        }
    }

    #[test]
    fn a_matrix_that_is_not_finite_is_refused() {
        let w = BlockMatrix::from_fn(2, |_, _| SMatrix::<f64, 1, 1>::new(f64::NAN));
        let mut matrix = NewtonMatrix::default();
        assert_eq!(matrix.analyse(&w), Ok(()));
        assert!(matrix.factor(&w, |_| Some((SMatrix::identity(), SMatrix::identity()))).is_err());
    }

    #[test]
    fn a_singular_matrix_is_an_error() {
        let w = BlockMatrix::from_fn(2, |_, _| SMatrix::<f64, 1, 1>::new(1.0));
        let mut matrix = NewtonMatrix::default();
        assert_eq!(matrix.analyse(&w), Ok(()));
        assert_eq!(matrix.factor(&w, |_| Some((SMatrix::identity(), SMatrix::zeros()))), Ok(()));
        assert!(matrix.solve(&mut [SVector::<f64, 1>::new(1.0), SVector::<f64, 1>::new(2.0)]).is_err());
    }
}
