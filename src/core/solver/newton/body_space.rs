//! The Newton system in body space: W is never formed.

use nalgebra::{SMatrix, SVector};

use super::maps::{Linear, State};
use crate::cone::{FactoredDelassus, Workspace};
use crate::linalg::{Multifrontal, NoPivot, SolveBuffers};
use crate::scalar::Scalar;

/// With dv = M̂⁻¹Hᵀ dr the system C W dr + (A + aC) dr = −f becomes, G = (A + aC)⁻¹C and y = (A + aC)⁻¹f,
///
/// ```text
///   (M̂ + Hᵀ G H) dv = −Hᵀ y,      dr = −y − G H dv
/// ```
///
/// the same step from a matrix over the velocities; H is scaled by S. Open contacts have G = 0.
#[derive(Debug, Clone)]
pub(super) struct BodySpace<T: Scalar, const D: usize> {
    /// H and M̂ as last seen, with H scaled.
    factors: Option<FactoredDelassus<T, D>>,
    scale: Vec<T>,
    /// Pattern of M̂ + Hᵀ G H over the blocks of velocities.
    starts: Vec<usize>,
    columns: Vec<usize>,
    /// Entry of every block of M̂, and of every pair of blocks of a contact, in that pattern.
    mass_place: Vec<usize>,
    pair_place: Vec<usize>,
    values: Vec<T>,
    active: Vec<bool>,
    rhs: Vec<T>,
    lu: Multifrontal<T>,
    buffers: SolveBuffers<T>,
    product: Workspace<T>,
    scaled: Vec<SVector<T, D>>,
    /// (A + aC)⁻¹ and G of every contact, and G times the columns of H of one.
    inverse: Vec<SMatrix<T, D, D>>,
    gain: Vec<SMatrix<T, D, D>>,
    weighted: Vec<SVector<T, D>>,
    analysed: bool,
}

impl<T: Scalar, const D: usize> BodySpace<T, D> {
    pub(super) fn new() -> Self {
        Self {
            factors: None,
            scale: Vec::new(),
            starts: Vec::new(),
            columns: Vec::new(),
            mass_place: Vec::new(),
            pair_place: Vec::new(),
            values: Vec::new(),
            active: Vec::new(),
            rhs: Vec::new(),
            lu: Multifrontal::new(),
            buffers: SolveBuffers::default(),
            product: Workspace::default(),
            scaled: Vec::new(),
            inverse: Vec::new(),
            gain: Vec::new(),
            weighted: Vec::new(),
            analysed: false,
        }
    }

    /// Takes H and M̂; the pattern is analysed again only where it has changed.
    pub(super) fn prepare(&mut self, factors: &FactoredDelassus<T, D>, scale: &[T]) {
        let same = self.factors.as_ref().is_some_and(|old| old.same_pattern(factors));
        match &mut self.factors {
            Some(old) => old.take(factors),
            none => *none = Some(factors.clone()),
        }
        self.scale.clear();
        self.scale.extend_from_slice(scale);
        self.analysed &= same;
    }

    fn analyse(&mut self) -> Result<(), NoPivot> {
        let Some(factors) = &self.factors else { return Ok(()) };
        let (h, mass, nodes) = (&factors.jacobian, &factors.mass, factors.nodes());
        let mut rows: Vec<Vec<usize>> =
            (0..nodes).map(|i| mass.columns[mass.starts[i]..mass.starts[i + 1]].to_vec()).collect();
        for touched in h.starts.windows(2).map(|range| &h.nodes[range[0]..range[1]]) {
            for &i in touched {
                rows[i].extend_from_slice(touched);
            }
        }
        self.starts.clear();
        self.starts.push(0);
        self.columns.clear();
        for row in &mut rows {
            row.sort_unstable();
            row.dedup();
            self.columns.extend_from_slice(row);
            self.starts.push(self.columns.len());
        }
        let (starts, columns) = (&self.starts, &self.columns);
        let place =
            |i: usize, j: usize| starts[i] + columns[starts[i]..starts[i + 1]].partition_point(|&c| c < j);
        self.mass_place.clear();
        for i in 0..nodes {
            let row = &mass.columns[mass.starts[i]..mass.starts[i + 1]];
            self.mass_place.extend(row.iter().map(|&j| place(i, j)));
        }
        self.pair_place.clear();
        for touched in h.starts.windows(2).map(|range| &h.nodes[range[0]..range[1]]) {
            for &i in touched {
                self.pair_place.extend(touched.iter().map(|&j| place(i, j)));
            }
        }
        self.lu
            .analyse(&self.starts, &self.columns, factors.dofs())
            .map_err(|error| NoPivot { node: error.row })?;
        self.active.clear();
        self.active.resize(nodes, true);
        self.analysed = true;
        Ok(())
    }

    /// out = S H M̂⁻¹ Hᵀ S r.
    pub(super) fn apply(&mut self, r: &[SVector<T, D>], out: &mut [SVector<T, D>]) {
        let Some(factors) = &self.factors else { return };
        self.scaled.clear();
        self.scaled.extend(r.iter().zip(&self.scale).map(|(r, &s)| r * s));
        factors.apply(&self.scaled, out, &mut self.product);
        out.iter_mut().zip(&self.scale).for_each(|(out, &s)| *out *= s);
    }

    /// Factors the matrix of `linear`.
    ///
    /// # Errors
    /// The contact whose A + aC, or the block of velocities whose pivots, cannot be inverted.
    pub(super) fn factor(&mut self, linear: &[Linear<T, D>], proximal: T) -> Result<(), NoPivot> {
        if !self.analysed {
            self.analyse()?;
        }
        let Some(factors) = &self.factors else { return Ok(()) };
        let (d, h) = (factors.dofs(), &factors.jacobian);
        self.values.clear();
        self.values.resize(self.columns.len() * d * d, T::zero());
        for (&place, block) in self.mass_place.iter().zip(factors.mass.values.chunks_exact(d * d)) {
            self.values[place * d * d..(place + 1) * d * d].copy_from_slice(block);
        }
        self.inverse.clear();
        self.gain.clear();
        let mut pairs = self.pair_place.as_slice();
        for (i, x) in linear.iter().enumerate() {
            let touched = h.starts[i + 1] - h.starts[i];
            let (own, rest) = pairs.split_at(touched * touched);
            pairs = rest;
            let s = self.scale[i];
            let (inverse, gain) = match x.state {
                State::Open => (SMatrix::identity(), SMatrix::zeros()),
                State::Stick => (SMatrix::identity() / proximal, SMatrix::identity() / proximal),
                State::Slide => {
                    let inverse = (x.a + x.c * proximal).try_inverse().ok_or(NoPivot { node: i })?;
                    (inverse, inverse * x.c)
                }
            };
            self.inverse.push(inverse);
            self.gain.push(gain);
            if x.state == State::Open {
                continue;
            }
            let columns = &h.columns[h.starts[i] * d..h.starts[i + 1] * d];
            self.weighted.clear();
            self.weighted.extend(columns.iter().map(|column| gain * column * (s * s)));
            for (pair, &place) in own.iter().enumerate() {
                let (p, q) = (pair / touched, pair % touched);
                let block = &mut self.values[place * d * d..(place + 1) * d * d];
                for (column, right) in block.chunks_exact_mut(d).zip(&self.weighted[q * d..]) {
                    column
                        .iter_mut()
                        .zip(&columns[p * d..])
                        .for_each(|(value, left)| *value += left.dot(right));
                }
            }
        }
        self.lu.factor(&self.values, &self.active)
    }

    /// The Newton step `dr` by the factors of the same derivatives.
    pub(super) fn step(&mut self, linear: &[Linear<T, D>], dr: &mut [SVector<T, D>]) {
        dr.iter_mut().zip(linear).for_each(|(dr, x)| *dr = -x.f);
        self.solve_regularised(dr);
    }

    /// `x` ← (C W + A + a C)⁻¹ x.
    pub(super) fn solve_regularised(&mut self, x: &mut [SVector<T, D>]) {
        let Some(factors) = &self.factors else { return };
        let (d, h) = (factors.dofs(), &factors.jacobian);
        self.rhs.clear();
        self.rhs.resize(factors.nodes() * d, T::zero());
        for (i, (x, inverse)) in x.iter_mut().zip(&self.inverse).enumerate() {
            *x = inverse * *x;
            h.add_transpose(i, d, &(*x * self.scale[i]), &mut self.rhs);
        }
        self.lu.solve(&mut self.rhs, &mut self.buffers);
        for (i, x) in x.iter_mut().enumerate() {
            let velocity = h.velocity(i, d, &self.rhs) * self.scale[i];
            *x -= self.gain[i] * velocity;
        }
    }
}
