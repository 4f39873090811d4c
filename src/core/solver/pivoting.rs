//! Lemke's complementary pivoting: a finite method for planar contacts, a start for spatial ones.

use std::time::Instant;

use nalgebra::{ComplexField, SVector};

use super::newton::Scaling;
use crate::cone::cones::Shape;
use crate::cone::{BlockMatrix, Cone, ConeProblem};
use crate::scalar::{Scalar, epsilon, lit};

/// Most rows of a tableau: it is dense, and a pivot costs its square.
const MOST_ROWS: usize = 1_200;

/// Pivots per row after which the path is given up: it is a few per row where the arithmetic holds.
const MOST_PIVOTS: usize = 20;

/// The fractional part of the golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Percussions near a solution of `problem`, by Lemke's method on the linear complementarity problem of Stewart & Trinkle
/// (1996, doi:10.1002/(SICI)1097-0207(19960815)39:15<2673::AID-NME972>3.0.CO;2-I): with D_k the tangents ±T and r = r_N e_N +
/// Σ_k d_k D_k,
///
/// ```text
///   0 ≤ w_N ⟂ r_N ≥ 0,   0 ≤ D_k·w_T + λ ⟂ d_k ≥ 0,   0 ≤ μ r_N − Σ_k d_k ⟂ λ ≥ 0.
/// ```
///
/// For D ≤ 2 that is the cone problem, and its matrix is copositive: the path ends in a solution whenever δ·r ≥ 0 for every
/// r ∈ K with W r = 0, in particular for W > 0. For D = 3 the cone is replaced by the pyramid within it. b is perturbed by
/// ε^0.6 so that no two ratios tie. `None` with rolling resistance, where the tableau would be too large, the path ends in a ray, or time is up.
pub(super) fn pivot<T: Scalar, const D: usize>(
    problem: &ConeProblem<T, D>,
    deadline: Option<Instant>,
) -> Option<Vec<SVector<T, D>>> {
    let m = problem.contacts();
    if problem.cones().iter().any(|&cone| matches!(Shape::of::<D>(cone), Shape::Blocks(_))) {
        return None;
    }
    if m.saturating_mul(2 * D) > 2 * MOST_ROWS {
        return None;
    }
    let scaling = Scaling::of(problem);
    let mut tableau = Tableau::of(&scaling.scaled(problem))?;
    let solved = tableau.run(deadline);
    let x = tableau.percussions::<D>(problem.cones());
    let mut r = x.clone();
    scaling.leave(&x, &mut r);
    let finite = r.iter().all(|r| crate::scalar::all_finite(r.iter()));
    (solved && finite).then_some(r)
}

/// Unknowns of a contact: r_N, and with friction d_k and λ.
fn unknowns<T: Scalar, const D: usize>(friction: T) -> usize {
    if D == 1 || friction == T::zero() { 1 } else { 2 * D }
}

/// Component and sign of unknown `k` of a contact in r: r_N, then ±T1, ±T2; none for λ.
fn along<const D: usize>(k: usize) -> Option<(usize, f64)> {
    match k {
        0 => Some((0, 1.0)),
        k if k < 2 * D - 1 => Some((k.div_ceil(2), if k % 2 == 1 { 1.0 } else { -1.0 })),
        _ => None,
    }
}

/// The dictionary basic = A nonbasic + q over the n pairs (x, y) and the artificial variable z₀. Variable k < n is x_k,
/// n + k is y_k, 2n is z₀.
struct Tableau<T> {
    n: usize,
    /// Rows of n + 2 numbers: the nonbasic variables' columns, and q.
    entries: Vec<T>,
    basic: Vec<usize>,
    nonbasic: Vec<usize>,
}

impl<T: Scalar> Tableau<T> {
    fn of<const D: usize>(problem: &ConeProblem<T, D>) -> Option<Self> {
        let mut first = Vec::with_capacity(problem.contacts() + 1);
        let mut n = 0;
        for cone in problem.cones() {
            first.push(n);
            n += unknowns::<T, D>(cone.friction());
        }
        first.push(n);
        if n > MOST_ROWS {
            return None;
        }
        let width = n + 2;
        let mut entries = vec![T::zero(); n * width];
        let perturbation = ComplexField::powf(epsilon::<T>(), lit(0.6));
        let mut own = BlockMatrix::new();
        let w = problem.delassus().form_in(&mut own);
        for (i, cone) in problem.cones().iter().enumerate() {
            let size = first[i + 1] - first[i];
            for k in 0..size {
                let row = first[i] + k;
                let entries = &mut entries[row * width..(row + 1) * width];
                // A quadratic Weyl sequence: ties of a chain of equal contacts are broken all differently.
                let n = (row + 1) as f64;
                entries[width - 1] = perturbation * lit::<T>((GOLDEN * n * n).fract());
                entries[width - 2] = T::one();
                let Some((component, sign)) = along::<D>(k) else {
                    entries[first[i]] = cone.friction();
                    (1..size - 1).for_each(|k| entries[first[i] + k] = -T::one());
                    continue;
                };
                entries[width - 1] += problem.b()[i][component] * lit::<T>(sign);
                for (j, block) in w.row(i) {
                    for (k, entry) in entries[first[j]..first[j + 1]].iter_mut().enumerate() {
                        if let Some((other, factor)) = along::<D>(k) {
                            *entry += block[(component, other)] * lit::<T>(sign * factor);
                        }
                    }
                }
                if k > 0 {
                    entries[first[i] + size - 1] = T::one();
                }
            }
        }
        Some(Self { n, entries, basic: (n..2 * n).collect(), nonbasic: (0..n).chain([2 * n]).collect() })
    }

    fn at(&self, row: usize, column: usize) -> T {
        self.entries[row * (self.n + 2) + column]
    }

    fn constant(&self, row: usize) -> T {
        self.at(row, self.n + 1)
    }

    /// Follows the path; whether it ends in a solution.
    fn run(&mut self, deadline: Option<Instant>) -> bool {
        let n = self.n;
        let Some(row) = (0..n).min_by(|&a, &b| {
            self.constant(a).partial_cmp(&self.constant(b)).unwrap_or(std::cmp::Ordering::Equal)
        }) else {
            return true;
        };
        if self.constant(row) >= T::zero() {
            return true;
        }
        let mut left = self.exchange(row, n);
        for _ in 0..MOST_PIVOTS * n {
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                return false;
            }
            let entering = if left < n { left + n } else { left - n };
            let Some(column) = self.nonbasic.iter().position(|&k| k == entering) else { return false };
            let Some(row) = self.leaving_row(column) else { return false };
            left = self.exchange(row, column);
            if left == 2 * n {
                return true;
            }
        }
        false
    }

    /// The row whose variable reaches zero first as that of `column` grows: z₀'s among equals, else the largest pivot.
    fn leaving_row(&self, column: usize) -> Option<usize> {
        let tiny = ComplexField::powf(epsilon::<T>(), lit(0.7));
        let mut least = None::<(usize, T)>;
        for row in 0..self.n {
            let slope = -self.at(row, column);
            if !(slope > tiny) {
                continue;
            }
            let ratio = self.constant(row).max(T::zero()) / slope;
            let Some((best, smallest)) = least else {
                least = Some((row, ratio));
                continue;
            };
            let slack = smallest.abs() * lit::<T>(16.0) * epsilon::<T>();
            let tie = (ratio - smallest).abs() <= slack;
            let better = if tie {
                self.basic[best] != 2 * self.n
                    && (self.basic[row] == 2 * self.n || slope > -self.at(best, column))
            } else {
                ratio < smallest
            };
            if better {
                least = Some((row, ratio));
            }
        }
        least.map(|(row, _)| row)
    }

    /// Exchanges the basic variable of `row` with the nonbasic one of `column`; returns the one that left.
    fn exchange(&mut self, row: usize, column: usize) -> usize {
        let width = self.n + 2;
        let inverse = T::one() / self.at(row, column);
        let (before, rest) = self.entries.split_at_mut(row * width);
        let (pivot, after) = rest.split_at_mut(width);
        pivot.iter_mut().for_each(|x| *x *= -inverse);
        pivot[column] = inverse;
        for other in before.chunks_exact_mut(width).chain(after.chunks_exact_mut(width)) {
            let factor = other[column];
            if factor == T::zero() {
                continue;
            }
            other[column] = T::zero();
            other.iter_mut().zip(&*pivot).for_each(|(x, &p)| *x += factor * p);
        }
        std::mem::swap(&mut self.basic[row], &mut self.nonbasic[column]);
        self.nonbasic[column]
    }

    /// r of the basic x.
    fn percussions<const D: usize>(&self, cones: &[Cone<T>]) -> Vec<SVector<T, D>> {
        let mut x = vec![T::zero(); self.n];
        for (row, &k) in self.basic.iter().enumerate().filter(|&(_, &k)| k < self.n) {
            x[k] = self.constant(row).max(T::zero());
        }
        let mut first = 0;
        let contact = |cone: &Cone<T>| {
            let size = unknowns::<T, D>(cone.friction());
            let mut r = SVector::zeros();
            for k in 0..size {
                if let Some((component, sign)) = along::<D>(k) {
                    r[component] += x[first + k] * lit::<T>(sign);
                }
            }
            first += size;
            r
        };
        cones.iter().map(contact).collect()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{matrix, vector};

    use super::*;

    /// Painlevé's rod in its inconsistent case: sliding on is impossible, the unique solution is an impact without collision
    /// that sticks, p = (0.30085, −0.4003) N s.
    #[test]
    fn the_path_ends_in_the_impact_without_collision() {
        let w = BlockMatrix::from_fn(1, |_, _| matrix![1.6, 1.2; 1.2, 3.4]);
        let problem = ConeProblem::<f64, 2>::new(w, vec![vector![-1e-3, 1.0]], vec![2.0]).expect("a problem");
        let r = pivot(&problem, None).expect("a solution");
        // b is changed by ε^0.6 = 4e-10, and the smallest eigenvalue of W is 1.
        assert!((r[0] - vector![0.30085, -0.4003]).norm() <= 1e-8, "{r:?}");
    }

    #[test]
    fn a_squeezed_body_has_no_end_of_the_path_and_a_deadline_ends_it() {
        let w = BlockMatrix::from_fn(2, |i, j| matrix![if i == j { 1.0 } else { -1.0 }]);
        let squeezed =
            ConeProblem::<f64, 1>::new(w, vec![vector![-1.0]; 2], vec![0.0; 2]).expect("a problem");
        assert_eq!(pivot(&squeezed, None), None);
        let w = BlockMatrix::from_fn(2, |i, j| matrix![if i == j { 2.0 } else { 1.0 }]);
        let loose = ConeProblem::<f64, 1>::new(w, vec![vector![-1.0]; 2], vec![0.0; 2]).expect("a problem");
        assert!(pivot(&loose, None).is_some());
        assert_eq!(pivot(&loose, Some(Instant::now())), None);
    }
}
