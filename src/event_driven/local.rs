//! The problem of the closed contacts, w = W p + b with K* ∋ Φ(w) ⟂ p ∈ K: solved by the cone solver, then to the last
//! digit.
//!
//! The solver tells which contacts open, stick and slide; with these modes the problem is a linear system, whose solution
//! does not carry the tolerance of the solver. The same problem is met with velocities (impacts: p are percussions) and
//! with accelerations (persistent contacts: p are forces).

use nalgebra::{DMatrix, DVector, SVector};

use super::{EventFailure, Mode};
use crate::cone::{BlockMatrix, ConeProblem};
use crate::solver::ConeSolver;

/// W, b and μ of the closed contacts, contact α in rows αD … αD + D − 1.
#[derive(Debug)]
pub(super) struct Local<const D: usize> {
    pub(super) w: DMatrix<f64>,
    pub(super) b: DVector<f64>,
    pub(super) friction: Vec<f64>,
}

/// Singular values below this share of the largest are those of redundant contacts.
const REDUNDANT: f64 = 1e-12;

/// How far a mode may miss its inequality, relative to b: rounding of W and b.
const CONSISTENT: f64 = 1e-11;

/// A percussion below this share of b/W is none: above the tolerances of solvers.
const NOTHING: f64 = 1e-9;

/// Solution with given modes.
pub(super) struct WithModes<const D: usize> {
    pub(super) p: Vec<SVector<f64, D>>,
    /// Whether p is one of many.
    pub(super) redundant: bool,
}

impl<const D: usize> Local<D> {
    /// Number of contacts.
    pub(super) fn contacts(&self) -> usize {
        self.friction.len()
    }

    /// Whether contact `i` has a tangent with friction.
    fn rubs(&self, i: usize) -> bool {
        D == 2 && self.friction[i] > 0.0
    }

    /// w = W p + b.
    pub(super) fn shifted(&self, p: &[SVector<f64, D>]) -> Vec<SVector<f64, D>> {
        let flat = DVector::from_iterator(self.b.len(), p.iter().flat_map(|p| p.iter().copied()));
        let w = &self.w * flat + &self.b;
        (0..p.len()).map(|i| SVector::from_fn(|d, _| w[i * D + d])).collect()
    }

    /// The solution in which every contact keeps its mode, inequalities aside: w_N = 0, w_T = 0 where it sticks,
    /// p_T = −μ s p_N where it slides in direction s. Of many, the one nearest to `from`, distances being measured in
    /// units of √`weights`.
    pub(super) fn with_modes(
        &self,
        modes: &[Mode],
        from: &[SVector<f64, D>],
        weights: &[f64],
    ) -> Option<WithModes<D>> {
        let mut rows = Vec::new();
        for (i, mode) in modes.iter().enumerate() {
            if *mode != Mode::Open {
                rows.push((i, 0));
            }
            if *mode == Mode::Stick && self.rubs(i) {
                rows.push((i, 1));
            }
        }
        let mut p = vec![SVector::<f64, D>::zeros(); modes.len()];
        if rows.is_empty() {
            return Some(WithModes { p, redundant: false });
        }
        // p_T = lean · p_N of a sliding contact.
        let lean = |i: usize| match modes[i] {
            Mode::Slide(s) if self.rubs(i) => -self.friction[i] * s,
            _ => 0.0,
        };
        let entry = |row: usize, (i, d): (usize, usize)| {
            let own = self.w[(row, i * D + d)];
            if d == 0 && lean(i) != 0.0 { own + lean(i) * self.w[(row, i * D + 1)] } else { own }
        };
        let n = rows.len();
        let a = DMatrix::from_fn(n, n, |r, c| entry(rows[r].0 * D + rows[r].1, rows[c]));
        let start = DVector::from_fn(n, |c, _| from[rows[c].0][rows[c].1]);
        let scale = DVector::from_fn(n, |c, _| weights[rows[c].0].sqrt());
        let scaled = DMatrix::from_fn(n, n, |r, c| a[(r, c)] * scale[c]);
        let svd = scaled.svd(true, true);
        let threshold = REDUNDANT * svd.singular_values.max();
        let redundant = svd.singular_values.min() <= threshold;
        let mut x = start;
        // The second pass takes the rounding of the first away.
        for _ in 0..2 {
            let left = DVector::from_fn(n, |r, _| -self.b[rows[r].0 * D + rows[r].1]) - &a * &x;
            x += svd.solve(&left, threshold).ok()?.component_mul(&scale);
        }
        for (&(i, d), &x) in rows.iter().zip(&x) {
            p[i][d] = x;
            if d == 0 && lean(i) != 0.0 {
                p[i][1] = lean(i) * x;
            }
        }
        p.iter().all(|p| p.iter().all(|x| x.is_finite())).then_some(WithModes { p, redundant })
    }

    /// The solution and its modes; contact i with `slip[i]` = ±1 slides that way if it stays closed.
    ///
    /// `None` where no such slide exists (Painlevé's paradox).
    pub(super) fn solve<V: ConeSolver<f64, D>>(
        &self,
        solver: &mut V,
        slip: &[Option<f64>],
    ) -> Result<Option<(Vec<SVector<f64, D>>, Vec<Mode>)>, EventFailure> {
        let m = self.contacts();
        let size = self.b.amax();
        let zero = vec![SVector::<f64, D>::zeros(); m];
        if size == 0.0 {
            return Ok(Some((zero, vec![Mode::Open; m])));
        }
        let oriented = |i: usize| if self.rubs(i) { slip[i] } else { None };
        let block = |i: usize, j: usize| self.w.fixed_view::<D, D>(i * D, j * D).into_owned();
        let diagonal = |i: usize, d: usize| self.w[(i * D + d, i * D + d)];
        // A sliding contact has moved on by u_T/dt, dt → 0: as far as it takes for the slip to keep its sign.
        let steep = |i: usize| 1.0 + diagonal(i, D - 1) / diagonal(i, 0) + self.friction[i];
        let mut far = 4.0 * size * (0..m).map(steep).fold(1.0, f64::max);
        for _ in 0..7 {
            let b = (0..m).map(|i| {
                let moved = oriented(i).map_or(0.0, |s| s * far);
                SVector::from_fn(|d, _| self.b[i * D + d] + if d == 1 { moved } else { 0.0 })
            });
            let problem =
                ConeProblem::new(BlockMatrix::from_fn(m, block), b.collect(), self.friction.clone())
                    .map_err(|source| EventFailure::Solver(source.into()))?;
            let mut p = zero.clone();
            solver.solve(&problem, &zero, &mut p).map_err(EventFailure::Solver)?;
            let mode = |i: usize| {
                let (normal, mu) = (p[i][0], self.friction[i]);
                if normal * diagonal(i, 0) <= NOTHING * size {
                    return Mode::Open;
                }
                if !self.rubs(i) {
                    return Mode::Slide(1.0);
                }
                let tangential = p[i][1];
                if tangential.abs() < mu * normal * (1.0 - 1e-7) {
                    Mode::Stick
                } else {
                    Mode::Slide(-tangential.signum())
                }
            };
            let modes: Vec<Mode> = (0..m).map(mode).collect();
            let turned =
                |i: usize| oriented(i).is_some_and(|s| modes[i] != Mode::Open && modes[i] != Mode::Slide(s));
            if !(0..m).any(turned) {
                return Ok(self.refine(&p, modes, &oriented));
            }
            far *= 10.0;
        }
        Ok(None)
    }

    /// The exact solution near `p`, by correcting the modes one at a time; `p` itself where no set of modes is consistent
    /// (many contacts that are redundant) and nothing is oriented.
    fn refine(
        &self,
        p: &[SVector<f64, D>],
        mut modes: Vec<Mode>,
        oriented: &dyn Fn(usize) -> Option<f64>,
    ) -> Option<(Vec<SVector<f64, D>>, Vec<Mode>)> {
        let m = self.contacts();
        let size = self.b.amax();
        let first = modes.clone();
        let ones = vec![1.0; m];
        let diagonal = |i: usize, d: usize| self.w[(i * D + d, i * D + d)];
        for _ in 0..4 * m + 4 {
            let Some(WithModes { p: exact, .. }) = self.with_modes(&modes, p, &ones) else { break };
            let w = self.shifted(&exact);
            let (mut worst, mut flip) = (CONSISTENT * size, None);
            let mut consider = |miss: f64, i: usize, mode: Mode| {
                if miss > worst {
                    (worst, flip) = (miss, Some((i, mode)));
                }
            };
            for i in 0..m {
                let tangential = if self.rubs(i) { exact[i][D - 1] } else { 0.0 };
                match modes[i] {
                    Mode::Open => {
                        let closed = match oriented(i) {
                            Some(s) => Mode::Slide(s),
                            None if self.rubs(i) => Mode::Stick,
                            None => Mode::Slide(1.0),
                        };
                        consider(-w[i][0], i, closed);
                    }
                    Mode::Stick => {
                        let over = tangential.abs() - self.friction[i] * exact[i][0];
                        consider(over * diagonal(i, D - 1), i, Mode::Slide(-tangential.signum()));
                        consider(-exact[i][0] * diagonal(i, 0), i, Mode::Open);
                    }
                    Mode::Slide(s) => {
                        if self.rubs(i) && oriented(i).is_none() {
                            consider(-s * w[i][D - 1], i, Mode::Stick);
                        }
                        consider(-exact[i][0] * diagonal(i, 0), i, Mode::Open);
                    }
                }
            }
            match flip {
                None => return Some((exact, modes)),
                Some((i, mode)) => modes[i] = mode,
            }
        }
        (0..m).all(|i| oriented(i).is_none()).then(|| (p.to_vec(), first))
    }
}
