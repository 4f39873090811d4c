//! The Newton system in contact space, W formed block by block.

use nalgebra::{SMatrix, SVector};

use super::maps::{Linear, State};
use crate::cone::BlockMatrix;
use crate::linalg::{Multifrontal, NoPivot, SolveBuffers};
use crate::scalar::Scalar;

/// Σ_β C_α W_αβ dr_β + (A_α + a C_α) dr_α = −f_α with the scaled W; open contacts (dr = −r) leave the system.
#[derive(Debug, Clone)]
pub(super) struct ContactSpace<T: Scalar, const D: usize> {
    /// Pattern of the problem's W last seen.
    source: (Vec<usize>, Vec<usize>),
    /// Its symmetrised pattern, and where in W each entry comes from (`usize::MAX`: nowhere).
    starts: Vec<usize>,
    columns: Vec<usize>,
    from: Vec<usize>,
    blocks: Vec<SMatrix<T, D, D>>,
    values: Vec<T>,
    active: Vec<bool>,
    rhs: Vec<T>,
    lu: Multifrontal<T>,
    buffers: SolveBuffers<T>,
    analysed: bool,
}

impl<T: Scalar, const D: usize> ContactSpace<T, D> {
    pub(super) fn new() -> Self {
        Self {
            source: (Vec::new(), Vec::new()),
            starts: vec![0],
            columns: Vec::new(),
            from: Vec::new(),
            blocks: Vec::new(),
            values: Vec::new(),
            active: Vec::new(),
            rhs: Vec::new(),
            lu: Multifrontal::new(),
            buffers: SolveBuffers::default(),
            analysed: false,
        }
    }

    /// Takes S W S.
    pub(super) fn prepare(&mut self, w: &BlockMatrix<T, D>, scale: &[T]) {
        let (starts, columns) = w.pattern();
        if self.source.0 != starts || self.source.1 != columns {
            self.source.0.clear();
            self.source.0.extend_from_slice(starts);
            self.source.1.clear();
            self.source.1.extend_from_slice(columns);
            self.symmetrise();
            self.analysed = false;
        }
        self.blocks.clear();
        for (i, &s) in scale.iter().enumerate() {
            for entry in self.starts[i]..self.starts[i + 1] {
                let block = w.blocks().get(self.from[entry]);
                let factor = s * scale[self.columns[entry]];
                self.blocks.push(block.map_or_else(SMatrix::zeros, |block| block * factor));
            }
        }
    }

    fn symmetrise(&mut self) {
        let (starts, columns) = &self.source;
        let n = starts.len() - 1;
        let mut transposed: Vec<Vec<usize>> = vec![Vec::new(); n];
        for i in 0..n {
            columns[starts[i]..starts[i + 1]].iter().for_each(|&j| transposed[j].push(i));
        }
        self.starts.truncate(1);
        self.columns.clear();
        self.from.clear();
        for i in 0..n {
            let own = starts[i]..starts[i + 1];
            let (mut entry, mut other) = (own.start, transposed[i].iter().copied().peekable());
            loop {
                let column = (entry < own.end).then(|| columns[entry]);
                match (column, other.peek().copied()) {
                    (None, None) => break,
                    (Some(j), k) if k.is_none_or(|k| j <= k) => {
                        self.columns.push(j);
                        self.from.push(entry);
                        entry += 1;
                        if k == Some(j) {
                            other.next();
                        }
                    }
                    (_, Some(k)) => {
                        self.columns.push(k);
                        self.from.push(usize::MAX);
                        other.next();
                    }
                    (Some(_), None) => unreachable!("a column alone is taken above"),
                }
            }
            self.starts.push(self.columns.len());
        }
    }

    #[inline]
    fn row(&self, i: usize) -> impl Iterator<Item = (usize, &SMatrix<T, D, D>)> {
        let range = self.starts[i]..self.starts[i + 1];
        self.columns[range.clone()].iter().copied().zip(&self.blocks[range])
    }

    /// out = W r.
    pub(super) fn apply(&self, r: &[SVector<T, D>], out: &mut [SVector<T, D>]) {
        for (i, out) in out.iter_mut().enumerate() {
            *out = self.row(i).fold(SVector::zeros(), |sum, (j, block)| sum + block * r[j]);
        }
    }

    /// Factors the matrix of `linear`.
    ///
    /// # Errors
    /// The contact at which the factorisation found no pivot.
    pub(super) fn factor(&mut self, linear: &[Linear<T, D>], proximal: T) -> Result<(), NoPivot> {
        if !self.analysed {
            self.lu.analyse(&self.starts, &self.columns, D).map_err(|error| NoPivot { node: error.row })?;
            self.analysed = true;
        }
        self.active.clear();
        self.active.extend(linear.iter().map(|x| x.state != State::Open));
        self.values.resize(self.blocks.len() * D * D, T::zero());
        for (i, x) in linear.iter().enumerate().filter(|(_, x)| x.state != State::Open) {
            for entry in self.starts[i]..self.starts[i + 1] {
                let j = self.columns[entry];
                if !self.active[j] {
                    continue;
                }
                let block = &self.blocks[entry];
                let mut value = if x.state == State::Stick { *block } else { x.c * block };
                if i == j {
                    value += x.a + x.c * proximal;
                }
                self.values[entry * D * D..(entry + 1) * D * D].copy_from_slice(value.as_slice());
            }
        }
        self.lu.factor(&self.values, &self.active)
    }

    /// The Newton step `dr` by the factors of the same derivatives.
    pub(super) fn step(&mut self, linear: &[Linear<T, D>], dr: &mut [SVector<T, D>]) {
        // The step of an open contact is known, and goes to the right-hand side of the others.
        for (dr, x) in dr.iter_mut().zip(linear) {
            *dr = if x.state == State::Open { -x.f } else { SVector::zeros() };
        }
        self.rhs.resize(linear.len() * D, T::zero());
        for (i, x) in linear.iter().enumerate().filter(|(_, x)| x.state != State::Open) {
            let known = self.row(i).filter(|(j, _)| !self.active[*j]);
            let known = known.fold(SVector::<T, D>::zeros(), |sum, (j, block)| sum + block * dr[j]);
            self.rhs[i * D..(i + 1) * D].copy_from_slice((-x.f - x.c * known).as_slice());
        }
        self.lu.solve(&mut self.rhs, &mut self.buffers);
        for (i, dr) in dr.iter_mut().enumerate().filter(|&(i, _)| self.active[i]) {
            dr.copy_from_slice(&self.rhs[i * D..(i + 1) * D]);
        }
    }

    /// `x` ← K⁻¹ x, no contact being open.
    pub(super) fn solve_regularised(&mut self, x: &mut [SVector<T, D>]) {
        self.rhs.clear();
        x.iter().for_each(|x| self.rhs.extend_from_slice(x.as_slice()));
        self.lu.solve(&mut self.rhs, &mut self.buffers);
        x.iter_mut().zip(self.rhs.chunks_exact(D)).for_each(|(x, rhs)| x.copy_from_slice(rhs));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A band of blocks, which is ordered, and the same matrix with every block stored, which is one dense front.
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

    fn linear(state: State, f: SVector<f64, 2>) -> Linear<f64, 2> {
        let identity = SMatrix::identity();
        match state {
            State::Open => Linear { state, f, a: identity, c: SMatrix::zeros() },
            State::Stick => Linear::sticking(f),
            State::Slide => Linear { state, f, a: identity * 0.5, c: identity * 2.0 },
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        /// C W dr + (A + a C) dr = −f, whatever the storage of W.
        #[test]
        fn sparse_and_dense_systems_have_the_solution(
            contacts in 110usize..130,
            values in proptest::collection::vec(-1.0..1.0f64, 53),
        ) {
            let states = [State::Stick, State::Open, State::Slide];
            let linear: Vec<_> = (0..contacts)
                .map(|i| linear(states[i % 3], SVector::<f64, 2>::new(values[i % 53], 1.0)))
                .collect();
            let (scale, proximal) = (vec![1.0; contacts], 0.1);
            for w in &pair(contacts, &values) {
                let mut space = ContactSpace::new();
                let mut dr = vec![SVector::zeros(); contacts];
                // Twice, so that the kept ordering is used too.
                for _ in 0..2 {
                    space.prepare(w, &scale);
                    prop_assert_eq!(space.factor(&linear, proximal), Ok(()));
                    space.step(&linear, &mut dr);
                }
                for (i, x) in linear.iter().enumerate() {
                    let w_dr = w.row(i).fold(SVector::<f64, 2>::zeros(), |sum, (j, block)| sum + block * dr[j]);
                    let left = x.c * w_dr + (x.a + x.c * proximal) * dr[i];
                    // The matrix is diagonally dominant, condition ≤ 100.
                    prop_assert!((left + x.f).norm() <= 1e-12 * (1.0 + x.f.norm()));
                }
            }
        }
    }

    #[test]
    fn a_matrix_that_is_not_finite_or_singular_is_an_error() {
        for entry in [f64::NAN, 1.0] {
            let w = BlockMatrix::from_fn(2, |_, _| SMatrix::<f64, 1, 1>::new(entry));
            let mut space = ContactSpace::new();
            space.prepare(&w, &[1.0; 2]);
            let sticking = [Linear::sticking(SVector::<f64, 1>::new(1.0)); 2];
            let error = space.factor(&sticking, 0.0).expect_err("no pivot");
            assert!(error.node < 2, "{error}");
        }
    }
}
