//! Anderson acceleration of a fixed point r = g(r) on the cones.

use nalgebra::{ComplexField, SVector};

use crate::cone::project;
use crate::scalar::{Scalar, lit};

/// Largest depth of the memory.
pub(super) const MAX_DEPTH: usize = 10;

/// Type II acceleration: with f = g(r) − r, minimise ‖f_k − Σ γ_j Δf_j‖ over the last differences and go to
/// g(r_k) − Σ γ_j Δg_j, projected on K (Walker and Ni 2011, doi:10.1137/10078356X).
///
/// The norm weights contact α by λ_max(W_αα), so that the iterates do not depend on the units. The normal equations
/// carry a Tikhonov term of 1e-12 of their largest diagonal; weights of Σ|γ| > 1e4 are refused.
#[derive(Debug, Clone)]
pub(super) struct Anderson<T: Scalar, const D: usize> {
    depth: usize,
    /// Columns in use, and the one to overwrite next.
    filled: usize,
    next: usize,
    /// Whether `f` and `g` hold the last iterate.
    started: bool,
    f: Vec<SVector<T, D>>,
    g: Vec<SVector<T, D>>,
    df: Vec<SVector<T, D>>,
    dg: Vec<SVector<T, D>>,
    gram: [[T; MAX_DEPTH]; MAX_DEPTH],
    last_size: T,
}

impl<T: Scalar, const D: usize> Anderson<T, D> {
    pub(super) fn new(depth: usize) -> Self {
        let (f, g, df, dg) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let gram = [[T::zero(); MAX_DEPTH]; MAX_DEPTH];
        let depth = depth.min(MAX_DEPTH);
        Self { depth, filled: 0, next: 0, started: false, f, g, df, dg, gram, last_size: T::zero() }
    }

    /// Forgets everything and takes the size of a problem; allocates only where it is larger than any before.
    pub(super) fn prepare(&mut self, contacts: usize) {
        self.forget();
        self.started = false;
        for (buffer, columns) in
            [(&mut self.f, 1), (&mut self.g, 1), (&mut self.df, self.depth), (&mut self.dg, self.depth)]
        {
            buffer.resize(contacts * columns, SVector::zeros());
        }
    }

    fn forget(&mut self) {
        self.filled = 0;
        self.next = 0;
    }

    /// Replaces `r` = g(`from`) by the accelerated iterate.
    pub(super) fn accelerate(
        &mut self,
        from: &[SVector<T, D>],
        r: &mut [SVector<T, D>],
        weights: &[T],
        friction: &[T],
    ) {
        if self.depth == 0 {
            return;
        }
        let m = r.len();
        let column = self.next * m..(self.next + 1) * m;
        let mut size = T::zero();
        let columns = self.df[column.clone()].iter_mut().zip(&mut self.dg[column]);
        let state = self.f.iter_mut().zip(&mut self.g);
        for ((((df, dg), (f, g)), (x, r)), &weight) in
            columns.zip(state).zip(from.iter().zip(&*r)).zip(weights)
        {
            let new = r - x;
            *df = new - *f;
            *dg = r - *g;
            *f = new;
            *g = *r;
            size += weight * new.norm_squared();
        }
        // ‖f‖ has doubled: the model is of no use here.
        let diverged = self.started && size > lit::<T>(4.0) * self.last_size;
        self.last_size = size;
        if !self.started || diverged {
            self.started = true;
            self.forget();
            return;
        }
        self.update_gram(weights);
        if let Some(gamma) = self.weights(weights) {
            for (j, &gamma) in gamma[..self.filled].iter().enumerate() {
                let dg = &self.dg[j * m..(j + 1) * m];
                r.iter_mut().zip(dg).for_each(|(r, dg)| *r -= dg * gamma);
            }
            r.iter_mut().zip(friction).for_each(|(r, &mu)| *r = project(r, mu));
        }
    }

    /// Takes the column just written into the normal equations.
    fn update_gram(&mut self, weights: &[T]) {
        let (m, new) = (self.f.len(), self.next);
        self.filled = (self.filled + 1).min(self.depth);
        self.next = (self.next + 1) % self.depth;
        for j in 0..self.filled {
            let product = dot(&self.df[j * m..(j + 1) * m], &self.df[new * m..(new + 1) * m], weights);
            self.gram[j][new] = product;
            self.gram[new][j] = product;
        }
    }

    /// γ by Cholesky, `None` where it is refused.
    fn weights(&self, weights: &[T]) -> Option<[T; MAX_DEPTH]> {
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
            let mut sum = dot(&self.df[i * m..(i + 1) * m], &self.f, weights);
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

fn dot<T: Scalar, const D: usize>(x: &[SVector<T, D>], y: &[SVector<T, D>], weights: &[T]) -> T {
    x.iter().zip(y).zip(weights).fold(T::zero(), |sum, ((x, y), &weight)| sum + weight * x.dot(y))
}
