//! The unit-free form of a cone problem, in which every projection step length is 1.

use nalgebra::{ComplexField, SVector};

use crate::cone::{BlockMatrix, ConeProblem, largest_eigenvalue};
use crate::scalar::{Scalar, lit};

/// W' = S W S, b' = S b/β with S_αα = s_α I, s_α = λ_max(sym W_αα)^(−1/2), β = ‖S b‖/√m, and r = β S r'.
///
/// Cones, symmetry and the De Saxcé term survive, λ_max(sym W'_αα) = 1, and b' has entries of order one.
#[derive(Debug, Clone)]
pub(super) struct Scaled<T: Scalar, const D: usize> {
    problem: ConeProblem<T, D>,
    /// W of a problem that comes in factored form.
    formed: BlockMatrix<T, D>,
    scale: Vec<T>,
    beta: T,
    b_norm: T,
}

impl<T: Scalar, const D: usize> Default for Scaled<T, D> {
    fn default() -> Self {
        Self {
            problem: ConeProblem::default(),
            formed: BlockMatrix::new(),
            scale: Vec::new(),
            beta: T::one(),
            b_norm: T::one(),
        }
    }
}

impl<T: Scalar, const D: usize> Scaled<T, D> {
    /// Takes over a checked problem, keeping the memory of the last one.
    pub(super) fn refill(&mut self, problem: &ConeProblem<T, D>) {
        let m = problem.contacts();
        self.scale.clear();
        let one = T::one();
        self.scale.extend((0..m).map(|i| one / ComplexField::sqrt(largest_eigenvalue(problem.diagonal(i)))));
        let scale = &self.scale;
        let square =
            problem.b().iter().zip(scale).fold(T::zero(), |sum, (b, &s)| sum + (b * s).norm_squared());
        let beta = ComplexField::sqrt(square / lit::<T>(m as f64));
        let w = problem.delassus().form_in(&mut self.formed);
        let (delassus, b, friction) = self.problem.parts_mut();
        delassus.clear();
        for i in 0..m {
            delassus.start_row();
            for (j, block) in w.row(i) {
                delassus.push(j, block * (scale[i] * scale[j]));
            }
        }
        b.clear();
        b.extend(problem.b().iter().zip(scale).map(|(b, &s)| b * (s / beta)));
        friction.clear();
        friction.extend_from_slice(problem.friction());
        self.beta = beta;
        self.b_norm = problem.b_norm();
    }

    /// W of the scaled problem.
    pub(super) fn delassus(&self) -> &BlockMatrix<T, D> {
        self.problem.delassus().formed().expect("refilled block by block")
    }

    /// The scaled problem.
    pub(super) fn problem(&self) -> &ConeProblem<T, D> {
        &self.problem
    }

    /// r' of r.
    pub(super) fn scale_into(&self, r: &[SVector<T, D>], x: &mut Vec<SVector<T, D>>) {
        x.clear();
        x.extend(r.iter().zip(&self.scale).map(|(r, &s)| r / (self.beta * s)));
    }

    /// r of r'.
    pub(super) fn unscale_into(&self, x: &[SVector<T, D>], r: &mut [SVector<T, D>]) {
        for ((r, x), &s) in r.iter_mut().zip(x).zip(&self.scale) {
            *r = x * (self.beta * s);
        }
    }

    /// Contribution of contact `contact` to the square of the unscaled problem's scaled residual, from its part
    /// of the natural map f' = r' − proj_K(r' − Φ(w')).
    #[inline]
    pub(super) fn residual_square(&self, contact: usize, f: &SVector<T, D>) -> T {
        (f * (self.beta / (self.scale[contact] * self.b_norm))).norm_squared()
    }
}
