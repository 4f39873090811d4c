//! Anderson acceleration of a fixed point x = g(x), of plain numbers or of vectors that weigh differently.

use std::ops::{Mul, Sub, SubAssign};

use nalgebra::{ComplexField, SVector};
use num_traits::Zero;

use crate::scalar::{Scalar, lit};

/// Largest depth of the memory.
pub(crate) const MAX_DEPTH: usize = 10;

/// What x is made of: numbers, or the vectors of the contacts.
pub(crate) trait Entry<T>:
    Copy + Zero + Sub<Output = Self> + SubAssign + Mul<T, Output = Self>
{
    /// The inner product.
    fn inner(&self, other: &Self) -> T;
}

impl<T: Scalar> Entry<T> for T {
    fn inner(&self, other: &Self) -> T {
        *self * *other
    }
}

impl<T: Scalar, const D: usize> Entry<T> for SVector<T, D> {
    fn inner(&self, other: &Self) -> T {
        self.dot(other)
    }
}

/// Type II acceleration: with f = g(x) − x, minimise ‖f_k − Σ γ_j Δf_j‖ over the last differences and go to
/// g(x_k) − Σ γ_j Δg_j (Walker and Ni 2011, doi:10.1137/10078356X).
///
/// The norm weights every entry of x, so that the iterates need not depend on the units. The normal equations carry a
/// Tikhonov term of 1e-12 of their largest diagonal; weights of Σ|γ| > 1e4 are refused, and the memory is cleared when
/// ‖f‖ more than doubles.
#[derive(Debug, Clone)]
pub(crate) struct Anderson<T, V> {
    depth: usize,
    /// Columns in use, and the one to overwrite next.
    filled: usize,
    next: usize,
    /// Whether `f` and `g` hold the last iterate.
    started: bool,
    f: Vec<V>,
    g: Vec<V>,
    df: Vec<V>,
    dg: Vec<V>,
    gram: [[T; MAX_DEPTH]; MAX_DEPTH],
    last_size: T,
}

impl<T: Scalar, V: Entry<T>> Anderson<T, V> {
    /// An accelerator that remembers `depth` steps, [`MAX_DEPTH`] at most; 0 is the plain iteration.
    pub(crate) fn new(depth: usize) -> Self {
        let (f, g, df, dg) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let gram = [[T::zero(); MAX_DEPTH]; MAX_DEPTH];
        let depth = depth.min(MAX_DEPTH);
        Self { depth, filled: 0, next: 0, started: false, f, g, df, dg, gram, last_size: T::zero() }
    }

    /// Forgets everything and takes the length of x; allocates only where it is larger than any before.
    pub(crate) fn prepare(&mut self, length: usize) {
        self.forget();
        for (buffer, columns) in
            [(&mut self.f, 1), (&mut self.g, 1), (&mut self.df, self.depth), (&mut self.dg, self.depth)]
        {
            buffer.resize(length * columns, V::zero());
        }
    }

    /// Forgets the steps and keeps the length of x.
    pub(crate) fn forget(&mut self) {
        (self.filled, self.next, self.started) = (0, 0, false);
    }

    /// Replaces `x` = g(`from`) by the accelerated iterate; whether it differs, and may have left the set x lies in.
    pub(crate) fn accelerate(
        &mut self,
        from: &[V],
        x: &mut [V],
        weights: impl Iterator<Item = T> + Clone,
    ) -> bool {
        if self.depth == 0 {
            return false;
        }
        let m = x.len();
        let column = self.next * m..(self.next + 1) * m;
        let mut size = T::zero();
        let columns = self.df[column.clone()].iter_mut().zip(&mut self.dg[column]);
        let state = self.f.iter_mut().zip(&mut self.g);
        for ((((df, dg), (f, g)), (&from, &x)), weight) in
            columns.zip(state).zip(from.iter().zip(&*x)).zip(weights.clone())
        {
            let new = x - from;
            *df = new - *f;
            *dg = x - *g;
            *f = new;
            *g = x;
            size += weight * new.inner(&new);
        }
        // ‖f‖ has doubled: the model is of no use here.
        let diverged = self.started && size > lit::<T>(4.0) * self.last_size;
        self.last_size = size;
        if !self.started || diverged {
            self.forget();
            self.started = true;
            return false;
        }
        self.update_gram(weights.clone());
        let Some(gamma) = self.fit(weights) else { return false };
        for (j, &gamma) in gamma[..self.filled].iter().enumerate() {
            let dg = &self.dg[j * m..(j + 1) * m];
            x.iter_mut().zip(dg).for_each(|(x, &dg)| *x -= dg * gamma);
        }
        true
    }

    /// Takes the column just written into the normal equations.
    fn update_gram(&mut self, weights: impl Iterator<Item = T> + Clone) {
        let (m, new) = (self.f.len(), self.next);
        self.filled = (self.filled + 1).min(self.depth);
        self.next = (self.next + 1) % self.depth;
        for j in 0..self.filled {
            let product =
                dot(&self.df[j * m..(j + 1) * m], &self.df[new * m..(new + 1) * m], weights.clone());
            self.gram[j][new] = product;
            self.gram[new][j] = product;
        }
    }

    /// γ by Cholesky, `None` where it is refused.
    fn fit(&self, weights: impl Iterator<Item = T> + Clone) -> Option<[T; MAX_DEPTH]> {
        let (m, k) = (self.f.len(), self.filled);
        let largest = (0..k).fold(T::zero(), |x, i| x.max(self.gram[i][i]));
        let tikhonov = largest * lit::<T>(1e-12).max(crate::scalar::epsilon::<T>());
        let mut factor = [[T::zero(); MAX_DEPTH]; MAX_DEPTH];
        let mut gamma = [T::zero(); MAX_DEPTH];
        for i in 0..k {
            for j in 0..=i {
                let shift = if i == j { tikhonov } else { T::zero() };
                let mut sum = self.gram[i][j] + shift;
                (0..j).for_each(|l| sum -= factor[i][l] * factor[j][l]);
                if i > j {
                    factor[i][j] = sum / factor[j][j];
                } else if sum > T::zero() {
                    factor[i][i] = ComplexField::sqrt(sum);
                } else {
                    return None;
                }
            }
            let mut sum = dot(&self.df[i * m..(i + 1) * m], &self.f, weights.clone());
            (0..i).for_each(|l| sum -= factor[i][l] * gamma[l]);
            gamma[i] = sum / factor[i][i];
        }
        for i in (0..k).rev() {
            let mut sum = gamma[i];
            (i + 1..k).for_each(|l| sum -= factor[l][i] * gamma[l]);
            gamma[i] = sum / factor[i][i];
        }
        let total = gamma.iter().fold(T::zero(), |sum, &g| sum + ComplexField::abs(g));
        (total <= lit::<T>(1e4)).then_some(gamma)
    }
}

fn dot<T: Scalar, V: Entry<T>>(x: &[V], y: &[V], weights: impl Iterator<Item = T>) -> T {
    x.iter().zip(y).zip(weights).fold(T::zero(), |sum, ((x, y), weight)| sum + weight * x.inner(y))
}

#[cfg(test)]
mod tests {
    use std::iter::repeat;

    use super::*;

    /// On a linear map of n unknowns with enough memory the method is GMRES and ends in n + 1 evaluations.
    #[test]
    fn a_linear_fixed_point_is_found_in_as_many_steps_as_unknowns() {
        let slopes = [0.9, -0.5, 0.3, 0.99];
        let mut x = [1.0, 2.0, -1.0, 0.5];
        let mut anderson = Anderson::new(4);
        anderson.prepare(slopes.len());
        for _ in 0..slopes.len() + 2 {
            let from = x;
            x.iter_mut().zip(slopes).for_each(|(x, slope)| *x = slope * *x + 1.0);
            anderson.accelerate(&from, &mut x, repeat(1.0));
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
        anderson.prepare(x.len());
        for _ in 0..3 {
            let from = x;
            x = [0.5 * x[0]];
            assert!(!anderson.accelerate(&from, &mut x, repeat(1.0)));
        }
        assert_eq!(x, [0.125]);
    }
}
