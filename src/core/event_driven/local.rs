//! The problem of the closed contacts, w = W p + b with K* ∋ Φ(w) ⟂ p ∈ K: solved by the cone solver, then to the last
//! digit.
//!
//! The solver tells which contacts open, stick and slide; with these modes the problem is a linear system, whose solution
//! does not carry the tolerance of the solver. The same problem is met with velocities (impacts: p are percussions) and
//! with accelerations (persistent contacts: p are forces).

use nalgebra::{DMatrix, DVector, SVector};

use super::complementarity::lemke;
use super::least_norm::LeastNorm;
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

/// Directions in which W is below this share of its largest are those of redundant contacts.
const REDUNDANT: f64 = 1e-12;

/// How far a mode may miss its inequality, relative to the terms of its row: rounding of W and b.
const CONSISTENT: f64 = 1e-11;

/// Forces nearer to the edge of their cone than this share of them are as good as outside: they soon are.
const MARGIN: f64 = 1e-6;

/// How far it may where nothing better is found: some tolerances of solvers.
const TOLERABLE: f64 = 1e-8;

/// A percussion below this share of b/W is none: some tolerances of solvers.
const NOTHING: f64 = 1e-9;

/// Solution with given modes.
pub(super) struct WithModes<const D: usize> {
    pub(super) p: Vec<SVector<f64, D>>,
    /// Whether p is one of many.
    pub(super) redundant: bool,
}

/// Percussions, or forces, and the modes they belong to.
pub(super) type Solved<const D: usize> = (Vec<SVector<f64, D>>, Vec<Mode>);

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
        let decomposed = LeastNorm::new(scaled, REDUNDANT);
        let redundant = decomposed.redundant();
        let mut x = start;
        // The second pass takes the rounding of the first away.
        for _ in 0..2 {
            let left = DVector::from_fn(n, |r, _| -self.b[rows[r].0 * D + rows[r].1]) - &a * &x;
            x += decomposed.solve(left)?.component_mul(&scale);
        }
        for (&(i, d), &x) in rows.iter().zip(&x) {
            p[i][d] = x;
            if d == 0 && lean(i) != 0.0 {
                p[i][1] = lean(i) * x;
            }
        }
        p.iter().all(|p| p.iter().all(|x| x.is_finite())).then_some(WithModes { p, redundant })
    }

    /// [`with_modes`](Self::with_modes), of many the one whose forces differ from `reference` in proportion to the normal
    /// forces there; without reference, contacts share what is not determined in proportion to their normal forces, and
    /// those of equal friction and direction begin to slide together, when their sum reaches the sum of the cones.
    pub(super) fn shared(&self, modes: &[Mode], reference: &[SVector<f64, D>]) -> Option<WithModes<D>> {
        let zeros = vec![SVector::zeros(); modes.len()];
        let solution = self.with_modes(modes, &zeros, &vec![1.0; modes.len()])?;
        if !solution.redundant {
            return Some(solution);
        }
        let known = reference.iter().any(|p| p[0] > 0.0);
        let (from, normal) = if known { (reference, reference) } else { (&*zeros, &*solution.p) };
        let largest = normal.iter().fold(0.0_f64, |largest, p| largest.max(p[0]));
        let weight = |p: &SVector<f64, D>| p[0].max(1e-9 * largest).max(f64::MIN_POSITIVE);
        self.with_modes(modes, from, &normal.iter().map(weight).collect::<Vec<f64>>())
    }

    /// Whether the sharing without reference of redundant contacts leaves the cone of one that sticks, or is about to.
    pub(super) fn shares_badly(&self, modes: &[Mode]) -> bool {
        let zeros = vec![SVector::zeros(); modes.len()];
        let Some(WithModes { p, redundant: true }) = self.shared(modes, &zeros) else { return false };
        self.outside(modes, &p) > -MARGIN
    }

    /// Whether the sharing near `reference` stays in the cones.
    pub(super) fn holds(&self, modes: &[Mode], reference: &[SVector<f64, D>]) -> bool {
        self.shared(modes, reference).is_some_and(|found| self.outside(modes, &found.p) <= CONSISTENT)
    }

    /// How far the forces leave their cones, in shares of the largest; negative inside.
    fn outside(&self, modes: &[Mode], p: &[SVector<f64, D>]) -> f64 {
        let size = p.iter().map(|p| p.amax()).fold(0.0, f64::max);
        let over = |(i, p): (usize, &SVector<f64, D>)| {
            let over = if modes[i] == Mode::Stick { p[D - 1].abs() - self.friction[i] * p[0] } else { -p[0] };
            over.max(-p[0])
        };
        p.iter().enumerate().map(over).fold(f64::NEG_INFINITY, f64::max) / size
    }

    /// The forces furthest inside the cones of the contacts that stick: those that the least friction sustains, by bisection.
    pub(super) fn inmost(&self, slip: &[Option<f64>], modes: &[Mode]) -> Option<Vec<SVector<f64, D>>> {
        let size = self.b.amax();
        let (mut low, mut high, mut best) = (0.0, 1.0, None);
        for trial in 0..12 {
            let share = if trial == 0 { 1.0 } else { 0.5 * (low + high) };
            let scaled = |(mu, mode): (&f64, &Mode)| if *mode == Mode::Stick { share * mu } else { *mu };
            let friction = self.friction.iter().zip(modes).map(scaled).collect();
            let eased = Self { w: self.w.clone(), b: self.b.clone(), friction };
            let holds = |p: &Vec<SVector<f64, D>>| {
                let still = |(w, mode): (&SVector<f64, D>, &Mode)| match mode {
                    Mode::Open => true,
                    Mode::Slide(_) => w[0].abs() <= TOLERABLE * size,
                    Mode::Stick => w.amax() <= TOLERABLE * size,
                };
                self.shifted(p).iter().zip(modes).all(still)
            };
            match eased.vertex(slip, slip).map(|(p, _)| p).filter(holds) {
                Some(p) => (high, best) = (share, Some(p)),
                None => low = share,
            }
        }
        best
    }

    /// The solution and its modes; contact i with `slip[i]` = ±1 slides that way if it stays closed, whatever b_T says.
    ///
    /// `None` where no such slide exists (Painlevé's paradox), or none is found.
    pub(super) fn solve(
        &self,
        solver: &mut dyn ConeSolver<f64, D>,
        slip: &[Option<f64>],
    ) -> Result<Option<Solved<D>>, EventFailure> {
        let m = self.contacts();
        let zero = vec![SVector::<f64, D>::zeros(); m];
        let normal = (0..m).map(|i| self.b[i * D].abs()).fold(0.0, f64::max);
        let size = if slip.iter().any(Option::is_some) { self.b.amax() } else { normal };
        if size == 0.0 && (0..m).all(|i| self.b[i * D] >= 0.0) {
            return Ok(Some((zero, vec![Mode::Open; m])));
        }
        let block = |i: usize, j: usize| self.w.fixed_view::<D, D>(i * D, j * D).into_owned();
        // A sliding contact has moved on by u_T/dt, dt → 0: as far as it takes for the slip to keep its sign. A slip that
        // is far larger than what the forces can stop is cut to that, or the solver's tolerance would hide the normal part.
        let steep = |i: usize| 1.0 + self.diagonal(i, D - 1) / self.diagonal(i, 0) + self.friction[i];
        let mut far = 4.0 * size * (0..m).map(steep).fold(1.0, f64::max);
        for _ in 0..20 {
            let mut kept = vec![None; m];
            let mut b = Vec::with_capacity(m);
            for i in 0..m {
                let mut at = SVector::<f64, D>::from_fn(|d, _| self.b[i * D + d]);
                if self.rubs(i) {
                    let tangential = &mut at[D - 1];
                    if let Some(s) = slip[i] {
                        kept[i] = Some(s);
                        *tangential += s * far;
                    } else if tangential.abs() > far {
                        kept[i] = Some(tangential.signum());
                        *tangential = tangential.signum() * far;
                    }
                }
                b.push(at);
            }
            let problem = ConeProblem::new(BlockMatrix::from_fn(m, block), b, self.friction.clone())
                .map_err(|source| EventFailure::Solver(source.into()))?;
            let mut p = zero.clone();
            if solver.solve(&problem, &zero, &mut p).is_err() {
                let found = self.vertex(&kept, slip);
                // Slips that were cut, and kept, may have to stop.
                if found.is_none() && kept != slip && far <= 1e10 * size {
                    far *= 10.0;
                    continue;
                }
                return Ok(found);
            }
            let modes: Vec<Mode> = (0..m).map(|i| self.mode(i, &p[i], size)).collect();
            let turned =
                |i: usize| kept[i].is_some_and(|s| modes[i] != Mode::Open && modes[i] != Mode::Slide(s));
            if !(0..m).any(turned) {
                return Ok(self.refine(&p, modes, slip).or_else(|| self.vertex(&kept, slip)));
            }
            far *= 10.0;
        }
        Ok(None)
    }

    /// The solution as a vertex of the linear complementarity problem, contact i with `kept[i]` sliding that way.
    fn vertex(&self, kept: &[Option<f64>], slip: &[Option<f64>]) -> Option<Solved<D>> {
        let m = self.contacts();
        let free = |i: usize| self.rubs(i) && kept[i].is_none();
        let used =
            |i: usize| self.b[i * D].abs().max(if free(i) { self.b[i * D + D - 1].abs() } else { 0.0 });
        let size = (0..m).map(used).fold(0.0, f64::max);
        let mobility = (0..m * D).map(|k| self.w[(k, k)]).fold(0.0, f64::max);
        if !(size > 0.0 && mobility > 0.0) {
            return None;
        }
        // Unknown k is p_N with its p_T where that is given, or β₊, β₋; λ has no column in w = W p + b.
        let mut unknowns: Vec<Vec<(usize, f64)>> = Vec::new();
        let mut rows: Vec<(Option<(usize, f64)>, usize)> = Vec::new();
        let mut first = Vec::with_capacity(m);
        for (i, direction) in kept.iter().enumerate() {
            first.push(unknowns.len());
            let (normal, tangent) = (i * D, i * D + D - 1);
            rows.push((Some((normal, 1.0)), i));
            match (self.rubs(i), *direction) {
                (true, None) => {
                    unknowns.extend([
                        vec![(normal, 1.0)],
                        vec![(tangent, 1.0)],
                        vec![(tangent, -1.0)],
                        vec![],
                    ]);
                    rows.extend([(Some((tangent, 1.0)), i), (Some((tangent, -1.0)), i), (None, i)]);
                }
                (true, Some(s)) => unknowns.push(vec![(normal, 1.0), (tangent, -self.friction[i] * s)]),
                (false, _) => unknowns.push(vec![(normal, 1.0)]),
            }
        }
        let n = unknowns.len();
        let matrix = DMatrix::from_fn(n, n, |r, c| match rows[r] {
            (Some((k, sign)), i) => {
                let slack = if c == first[i] + 3 && r != first[i] && k == i * D + D - 1 { 1.0 } else { 0.0 };
                slack + unknowns[c].iter().map(|&(l, x)| sign * self.w[(k, l)] * x).sum::<f64>() / mobility
            }
            (None, i) if c == first[i] => self.friction[i],
            (None, i) if c == first[i] + 1 || c == first[i] + 2 => -1.0,
            (None, _) => 0.0,
        });
        let q = DVector::from_fn(n, |r, _| rows[r].0.map_or(0.0, |(k, sign)| sign * self.b[k] / size));
        let z = lemke(&matrix, &q)?;
        let mut p = vec![SVector::<f64, D>::zeros(); m];
        for (unknown, z) in unknowns.iter().zip(&z) {
            unknown.iter().for_each(|&(k, x)| p[k / D][k % D] += x * z * size / mobility);
        }
        let modes = (0..m).map(|i| self.mode(i, &p[i], size)).collect();
        self.refine(&p, modes, slip)
    }

    /// Modes that leave the forces of redundant contacts free: a contact at the edge of its cone that is not going to slip,
    /// where the solution could as well have another force, sticks.
    pub(super) fn freest(&self, p: &[SVector<f64, D>], modes: Vec<Mode>, slip: &[Option<f64>]) -> Vec<Mode> {
        let w = self.shifted(p);
        let rounding = 64.0 * f64::EPSILON * self.b.amax();
        let still = |i: usize| {
            let slides = matches!(modes[i], Mode::Slide(_)) && self.rubs(i) && slip[i].is_none();
            slides && w[i][D - 1].abs() <= rounding + CONSISTENT * self.terms(i * D + D - 1, p)
        };
        let free: Vec<Mode> =
            (0..modes.len()).map(|i| if still(i) { Mode::Stick } else { modes[i] }).collect();
        if free == modes {
            return modes;
        }
        match self.with_modes(&free, p, &vec![1.0; free.len()]) {
            Some(WithModes { redundant: true, .. }) => free,
            _ => modes,
        }
    }

    /// |b_r| + Σ |W_rs p_s|, the size of the terms of w_r.
    fn terms(&self, row: usize, p: &[SVector<f64, D>]) -> f64 {
        let term = |(j, p): (usize, &SVector<f64, D>)| {
            (0..D).map(|e| (self.w[(row, j * D + e)] * p[e]).abs()).sum::<f64>()
        };
        self.b[row].abs() + p.iter().enumerate().map(term).sum::<f64>()
    }

    fn diagonal(&self, i: usize, d: usize) -> f64 {
        self.w[(i * D + d, i * D + d)]
    }

    /// The mode of contact `i` with percussion `p` in a problem of velocities of this size.
    fn mode(&self, i: usize, p: &SVector<f64, D>, size: f64) -> Mode {
        if p[0] * self.diagonal(i, 0) <= NOTHING * size {
            return Mode::Open;
        }
        if !self.rubs(i) {
            return Mode::Slide(1.0);
        }
        let tangential = p[D - 1];
        let sticks = tangential.abs() < self.friction[i] * p[0] * (1.0 - 1e-7);
        if sticks { Mode::Stick } else { Mode::Slide(-tangential.signum()) }
    }

    /// The exact solution near `p`, by correcting the modes one at a time. Where that does not end, the exact solution
    /// of the modes that were given, if it misses their inequalities by no more than a solver may.
    fn refine(&self, p: &[SVector<f64, D>], modes: Vec<Mode>, slip: &[Option<f64>]) -> Option<Solved<D>> {
        let first = modes.clone();
        let mut modes = modes;
        for _ in 0..8 * modes.len() + 8 {
            let Some((exact, flip)) = self.examine(p, &modes, slip, CONSISTENT) else { break };
            match flip {
                None => return Some((exact, modes)),
                Some((i, mode)) => modes[i] = mode,
            }
        }
        match self.examine(p, &first, slip, TOLERABLE) {
            Some((exact, None)) => Some((exact, first)),
            _ => None,
        }
    }

    /// The solution with these modes, and the contact that misses its inequality worst with the mode it should have;
    /// misses are relative to the terms of the row, w_r = b_r + Σ W_rs p_s. `None` where the modes have no solution.
    #[expect(clippy::type_complexity, reason = "a solution and a contact to change")]
    fn examine(
        &self,
        p: &[SVector<f64, D>],
        modes: &[Mode],
        slip: &[Option<f64>],
        tolerance: f64,
    ) -> Option<(Vec<SVector<f64, D>>, Option<(usize, Mode)>)> {
        let exact = self.with_modes(modes, p, &vec![1.0; modes.len()])?.p;
        let w = self.shifted(&exact);
        let size = |i: usize, d: usize| self.terms(i * D + d, &exact);
        // b itself is a difference of larger numbers.
        let rounding = 64.0 * f64::EPSILON * self.b.amax();
        let (mut worst, mut flip) = (tolerance, None);
        let mut consider = |miss: f64, size: f64, i: usize, mode: Mode| {
            if miss > rounding + worst * size {
                (worst, flip) = ((miss - rounding) / size, Some((i, mode)));
            }
        };
        for i in 0..modes.len() {
            let rubs = self.rubs(i);
            let oriented = if rubs { slip[i] } else { None };
            let (normal, tangential) = (size(i, 0), size(i, D - 1));
            let (weight, drag) =
                (exact[i][0] * self.diagonal(i, 0), exact[i][D - 1] * self.diagonal(i, D - 1));
            if modes[i] != Mode::Open && w[i][0].abs() > rounding + TOLERABLE * normal {
                return None;
            }
            match modes[i] {
                Mode::Open => {
                    let closed = match oriented {
                        Some(s) => Mode::Slide(s),
                        None if rubs => Mode::Stick,
                        None => Mode::Slide(1.0),
                    };
                    consider(-w[i][0], normal, i, closed);
                }
                Mode::Stick => {
                    if w[i][D - 1].abs() > rounding + TOLERABLE * tangential {
                        return None;
                    }
                    let limit = self.friction[i] * exact[i][0] * self.diagonal(i, D - 1);
                    consider(drag.abs() - limit, tangential, i, Mode::Slide(-drag.signum()));
                    consider(-weight, normal, i, Mode::Open);
                }
                Mode::Slide(s) => {
                    if rubs && oriented.is_none() {
                        consider(-s * w[i][D - 1], tangential, i, Mode::Stick);
                    }
                    consider(-weight, normal, i, Mode::Open);
                }
            }
        }
        Some((exact, flip))
    }
}
