//! One contact with moments among its rows: enumeration in the plane, a safeguarded Newton method in space.
//!
//! In the plane every block is a number, so that a contact which carries a percussion is in one of nine modes: each block
//! sticks, w_B = 0, or sits at one of its ends, r_B = ± c_B r_N with w_B of the other sign; each mode is a linear system. In
//! space the blocks are discs, and Newton's method on Alart and Curnier's map finds the mode; where it fails, bisection on the
//! term of Φ leads near the solution.

use nalgebra::{ComplexField, SMatrix, SVector};

use crate::cone::cones::blocks::{self, Block};
use crate::cone::spectrum::largest_eigenvalue;
use crate::laws::Cone;
use crate::scalar::{Scalar, epsilon, lit};

/// Newton steps at most, and halvings of one.
const STEPS: usize = 40;
const HALVINGS: usize = 8;

/// Projected steps that look for another start where Newton's method fails, and how often.
const PROJECTED: usize = 60;
const RESTARTS: usize = 4;

/// A residual that Newton's method leaves where it has failed, in ε, and halvings of the interval of Φ's term then.
const FAILED: f64 = 1e4;
const BISECTIONS: usize = 60;

/// Steps on the convex problem of one term.
const CONVEX: usize = 300;

/// W of a contact in units in which its largest eigenvalue is 1.
#[derive(Debug, Clone)]
pub(super) struct Rolling<T: Scalar, const D: usize> {
    w: SMatrix<T, D, D>,
    size: T,
    coefficients: [T; 3],
    /// The last solution, where the next one starts.
    last: SVector<T, D>,
}

impl<T: Scalar, const D: usize> Rolling<T, D> {
    pub(super) fn new(w: &SMatrix<T, D, D>, cone: Cone<T>) -> Self {
        let size = largest_eigenvalue(w);
        Self { w: w / size, size, coefficients: cone.coefficients(), last: SVector::zeros() }
    }

    /// r for the velocity `b` without it.
    pub(super) fn solve(&mut self, b: &SVector<T, D>) -> SVector<T, D> {
        if b[0] >= T::zero() {
            return SVector::zeros();
        }
        // b of size 1: the map compares percussions with velocities.
        let unit = b.norm();
        let b = b / unit;
        let r = if D == 3 { self.enumerate(&b) } else { self.newton(&b) };
        self.last = r;
        r * (unit / self.size)
    }

    fn residual(&self, r: &SVector<T, D>, b: &SVector<T, D>) -> T {
        let w = self.w * r + b;
        let phi = blocks::de_saxce(&w, self.coefficients);
        blocks::natural_map(r, &phi, self.coefficients).norm()
    }

    /// The best of the nine modes.
    fn enumerate(&self, b: &SVector<T, D>) -> SVector<T, D> {
        let mut best = SVector::zeros();
        let mut least = self.residual(&best, b);
        for mode in 0..9 {
            let signs = [mode % 3, mode / 3];
            let mut matrix = self.w;
            let mut right = -b;
            for (block, sign) in blocks::of::<T, D>(self.coefficients).zip(signs) {
                // 0 sticks; 1 and 2 sit at an end.
                let end = [T::zero(), block.coefficient, -block.coefficient][sign];
                if sign > 0 {
                    set_row(&mut matrix, &mut right, &block, end);
                }
            }
            let Some(r) = solve_small(matrix, right) else { continue };
            // Rounding must not leave the cone.
            let r = blocks::project(&r, self.coefficients);
            let residual = self.residual(&r, b);
            if residual < least {
                (best, least) = (r, residual);
            }
            if least <= lit::<T>(8.0) * epsilon::<T>() {
                break;
            }
        }
        best
    }

    /// Newton's method from the last solution, from stick, and from where projected steps lead.
    fn newton(&self, b: &SVector<T, D>) -> SVector<T, D> {
        let enough = lit::<T>(16.0) * epsilon::<T>();
        let project = |r: &SVector<T, D>| blocks::project(r, self.coefficients);
        let stuck = solve_small(self.w, -b).map(|r| project(&r));
        let mut best = project(&self.last);
        let mut least = self.residual(&best, b);
        if let Some(stuck) = stuck {
            let residual = self.residual(&stuck, b);
            if residual < least {
                (best, least) = (stuck, residual);
            }
        }
        for start in 0..=RESTARTS {
            if least <= enough {
                break;
            }
            let mut r = best;
            if start > 0 {
                for _ in 0..PROJECTED << start {
                    let w = self.w * r + b;
                    r = project(&(r - blocks::de_saxce(&w, self.coefficients)));
                }
            }
            let found = project(&self.descend(r, b));
            let residual = self.residual(&found, b);
            if residual < least {
                (best, least) = (found, residual);
            }
        }
        if least > lit::<T>(FAILED) * epsilon::<T>() {
            let found = self.bisect(b, enough);
            if self.residual(&found, b) < least {
                best = found;
            }
        }
        best
    }

    /// The solution as a fixed point of one number, s = Σ c_B ‖w_B‖: with s given, r is the minimum of
    /// ½ r·W r + (b + s e_N)·r over K, a convex problem. At s = 0 the term is not less than s, and from
    /// s = Σ c_B ‖b_B‖ − b_N on r = 0 and it is less: between them it is met. Newton's method takes over from near by.
    fn bisect(&self, b: &SVector<T, D>, enough: T) -> SVector<T, D> {
        let half = lit::<T>(0.5);
        let term = |w: &SVector<T, D>| blocks::de_saxce(w, self.coefficients)[0] - w[0];
        let (mut low, mut high) = (T::zero(), term(b) - b[0]);
        let mut r = SVector::zeros();
        let (mut best, mut least) = (r, self.residual(&r, b));
        for _ in 0..BISECTIONS {
            let middle = (low + high) * half;
            let mut raised = *b;
            raised[0] += middle;
            r = self.minimise(r, &raised);
            if term(&(self.w * r + b)) > middle {
                low = middle;
            } else {
                high = middle;
            }
            for candidate in [r, blocks::project(&self.descend(r, b), self.coefficients)] {
                let residual = self.residual(&candidate, b);
                if residual < least {
                    (best, least) = (candidate, residual);
                }
            }
            if least <= enough {
                break;
            }
        }
        best
    }

    /// The minimum of ½ r·W r + b·r over K, by accelerated projected gradients that start anew where they turn back.
    fn minimise(&self, start: SVector<T, D>, b: &SVector<T, D>) -> SVector<T, D> {
        let (mut r, mut ahead, mut momentum) = (start, start, T::one());
        for _ in 0..CONVEX {
            let gradient = self.w * ahead + b;
            let next = blocks::project(&(ahead - gradient), self.coefficients);
            let change = next - r;
            if (ahead - next).dot(&change) > T::zero() {
                (ahead, momentum) = (r, T::one());
                continue;
            }
            let four = lit::<T>(4.0);
            let grown =
                (T::one() + ComplexField::sqrt(T::one() + four * momentum * momentum)) * lit::<T>(0.5);
            ahead = next + change * ((momentum - T::one()) / grown);
            let moved = change.norm();
            (r, momentum) = (next, grown);
            if moved <= epsilon::<T>() {
                break;
            }
        }
        r
    }

    fn descend(&self, mut r: SVector<T, D>, b: &SVector<T, D>) -> SVector<T, D> {
        let value = |r: &SVector<T, D>| blocks::alart_curnier(r, &(self.w * r + b), self.coefficients);
        let mut f = value(&r);
        for _ in 0..STEPS {
            let merit = f.norm();
            if merit <= epsilon::<T>() {
                break;
            }
            let w = self.w * r + b;
            let Some((slope, _)) = blocks::ball_slope(&(r - w), self.coefficients) else { break };
            // f = r − P(r − w), f′ = I − P′ (I − W).
            let identity = SMatrix::<T, D, D>::identity();
            let matrix = identity - slope * (identity - self.w);
            let shifted = matrix + identity * epsilon::<T>();
            let Some(step) = solve_small(shifted, -f) else { break };
            let mut length = T::one();
            let mut next = r + step;
            let mut at_next = value(&next);
            for _ in 0..HALVINGS {
                if at_next.norm() < merit * (T::one() - lit::<T>(1e-4) * length) {
                    break;
                }
                length *= lit::<T>(0.5);
                next = r + step * length;
                at_next = value(&next);
            }
            if !(at_next.norm() < merit) {
                break;
            }
            (r, f) = (next, at_next);
        }
        r
    }
}

/// The equation r_B = `end` r_N in the place of w_B = 0.
fn set_row<T: Scalar, const D: usize>(
    matrix: &mut SMatrix<T, D, D>,
    right: &mut SVector<T, D>,
    block: &Block<T>,
    end: T,
) {
    for i in block.components() {
        (0..D).for_each(|j| matrix[(i, j)] = T::zero());
        (matrix[(i, i)], matrix[(i, 0)], right[i]) = (T::one(), -end, T::zero());
    }
}

/// A x = b by elimination with row pivots; `None` where A is singular to working precision.
fn solve_small<T: Scalar, const D: usize>(
    mut a: SMatrix<T, D, D>,
    mut b: SVector<T, D>,
) -> Option<SVector<T, D>> {
    for k in 0..D {
        let pivot = (k..D)
            .fold(k, |p, i| if ComplexField::abs(a[(i, k)]) > ComplexField::abs(a[(p, k)]) { i } else { p });
        a.swap_rows(k, pivot);
        b.swap_rows(k, pivot);
        let inverse = T::one() / a[(k, k)];
        if !(ComplexField::abs(a[(k, k)]) > epsilon::<T>() * epsilon::<T>()) {
            return None;
        }
        for i in k + 1..D {
            let factor = a[(i, k)] * inverse;
            for j in k..D {
                let above = a[(k, j)];
                a[(i, j)] -= factor * above;
            }
            let above = b[k];
            b[i] -= factor * above;
        }
    }
    for k in (0..D).rev() {
        let sum = (k + 1..D).fold(b[k], |sum, j| sum - a[(k, j)] * b[j]);
        b[k] = sum / a[(k, k)];
    }
    crate::scalar::all_finite(b.iter()).then_some(b)
}
