//! Anderson acceleration of a fixed point x = g(x) of plain numbers, which lie on no cone.

use nalgebra::ComplexField;

use crate::scalar::{Scalar, lit};

/// Anderson acceleration, type II: x⁺ = g_k − ΔG γ with γ = argmin ‖f_k − ΔF γ‖, f = g(x) − x.
///
/// The normal equations carry a Tikhonov term of 1e-12 of their largest diagonal entry; a step with Σ|γ| > 1e4 is
/// replaced by the plain one, and the memory is cleared when ‖f‖ more than doubles. Walker & Ni (2011),
/// doi:10.1137/10078356X.
#[derive(Debug, Clone)]
pub(super) struct Anderson<T> {
    depth: usize,
    columns: usize,
    oldest: usize,
    /// ΔF and ΔG, one column per step kept.
    change_f: Vec<Vec<T>>,
    change_g: Vec<Vec<T>>,
    last_f: Vec<T>,
    last_g: Vec<T>,
    last_norm: T,
    started: bool,
    gram: Vec<T>,
    gamma: Vec<T>,
}

impl<T: Scalar> Anderson<T> {
    /// An accelerator that remembers `depth` steps; 0 is the plain iteration.
    pub(super) fn new(depth: usize) -> Self {
        Self {
            depth,
            columns: 0,
            oldest: 0,
            change_f: vec![Vec::new(); depth],
            change_g: vec![Vec::new(); depth],
            last_f: Vec::new(),
            last_g: Vec::new(),
            last_norm: T::zero(),
            started: false,
            gram: Vec::new(),
            gamma: Vec::new(),
        }
    }

    /// Forgets the steps and keeps the memory.
    pub(super) fn clear(&mut self) {
        (self.columns, self.oldest, self.started) = (0, 0, false);
    }

    /// Replaces x by its successor, given g = g(x).
    pub(super) fn advance(&mut self, x: &mut [T], g: &[T]) {
        let f = |i: usize, x: &[T]| g[i] - x[i];
        let norm = ComplexField::sqrt((0..g.len()).fold(T::zero(), |sum, i| sum + f(i, x) * f(i, x)));
        if self.started && norm > lit::<T>(2.0) * self.last_norm {
            self.clear();
        }
        if self.started && self.depth > 0 {
            let slot = self.oldest;
            self.oldest = (slot + 1) % self.depth;
            self.columns = (self.columns + 1).min(self.depth);
            self.change_f[slot].clear();
            self.change_f[slot].extend((0..g.len()).map(|i| f(i, x) - self.last_f[i]));
            self.change_g[slot].clear();
            self.change_g[slot].extend(g.iter().zip(&self.last_g).map(|(&g, &last)| g - last));
        }
        self.last_f.clear();
        self.last_f.extend((0..g.len()).map(|i| f(i, x)));
        self.last_g.clear();
        self.last_g.extend_from_slice(g);
        (self.last_norm, self.started) = (norm, true);
        x.copy_from_slice(g);
        if self.columns > 0 && self.fit() {
            for (gamma, change) in self.gamma.iter().zip(&self.change_g) {
                x.iter_mut().zip(change).for_each(|(x, &change)| *x -= *gamma * change);
            }
        }
    }

    /// γ by Cholesky of the regularised normal equations; whether it can be trusted.
    fn fit(&mut self) -> bool {
        let n = self.columns;
        let dot = |a: &[T], b: &[T]| a.iter().zip(b).fold(T::zero(), |sum, (&a, &b)| sum + a * b);
        self.gram.clear();
        for i in 0..n {
            let row = (0..n).map(|j| dot(&self.change_f[i], &self.change_f[j]));
            self.gram.extend(row);
        }
        let largest = (0..n).fold(T::zero(), |largest: T, i| largest.max(self.gram[i * n + i]));
        let shift = lit::<T>(1e-12).max(crate::scalar::epsilon::<T>()) * largest;
        (0..n).for_each(|i| self.gram[i * n + i] += shift);
        self.gamma.clear();
        self.gamma.extend((0..n).map(|i| dot(&self.change_f[i], &self.last_f)));
        let (gram, gamma) = (&mut self.gram, &mut self.gamma);
        for i in 0..n {
            for j in 0..=i {
                let sum = (0..j).fold(gram[i * n + j], |sum, k| sum - gram[i * n + k] * gram[j * n + k]);
                if i > j {
                    gram[i * n + j] = sum / gram[j * n + j];
                } else if sum > T::zero() {
                    gram[i * n + i] = ComplexField::sqrt(sum);
                } else {
                    return false;
                }
            }
        }
        for i in 0..n {
            let sum = (0..i).fold(gamma[i], |sum, k| sum - gram[i * n + k] * gamma[k]);
            gamma[i] = sum / gram[i * n + i];
        }
        for i in (0..n).rev() {
            let sum = (i + 1..n).fold(gamma[i], |sum, k| sum - gram[k * n + i] * gamma[k]);
            gamma[i] = sum / gram[i * n + i];
        }
        gamma.iter().fold(T::zero(), |sum, &g| sum + ComplexField::abs(g)) <= lit(1e4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a linear map of n unknowns with enough memory the method is GMRES and ends in n + 1 evaluations.
    #[test]
    fn a_linear_fixed_point_is_found_in_as_many_steps_as_unknowns() {
        let slopes = [0.9, -0.5, 0.3, 0.99];
        let mut x = [1.0, 2.0, -1.0, 0.5];
        let mut anderson = Anderson::new(4);
        for _ in 0..slopes.len() + 2 {
            let g: Vec<f64> = x.iter().zip(slopes).map(|(x, slope)| slope * x + 1.0).collect();
            anderson.advance(&mut x, &g);
        }
        for (x, slope) in x.iter().zip(slopes) {
            let fixed = 1.0 / (1.0 - slope);
            // The Tikhonov term leaves 1e-12 of the Gram matrix, whose condition is that of the slopes.
            assert!((x - fixed).abs() <= 1e-5 * fixed, "{x} {fixed}");
        }
    }

    #[test]
    fn no_memory_is_the_plain_iteration() {
        let mut x = [1.0];
        let mut anderson = Anderson::new(0);
        for _ in 0..3 {
            let g = [0.5 * x[0]];
            anderson.advance(&mut x, &g);
        }
        assert_eq!(x, [0.125]);
    }
}
