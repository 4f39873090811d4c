//! The unit-free form of a cone problem, in which every projection step length is 1.

use nalgebra::{ComplexField, SVector};

use crate::cone::{BlockMatrix, ConeProblem, largest_eigenvalue};
use crate::scalar::{Scalar, from_usize};

/// W′ = S W S, b′ = S b/β with S_αα = s_α I, s_α = λ_max(sym W_αα)^(−1/2), β = ‖S b‖/√m, and r = β S r′.
///
/// Cones, symmetry and the De Saxcé term survive, λ_max(sym W′_αα) = 1, and b′ has entries of order one. W is not
/// symmetrised.
#[derive(Debug, Clone)]
pub(in crate::solver) struct Scaling<T> {
    scale: Vec<T>,
    beta: T,
    b_norm: T,
}

impl<T: Scalar> Scaling<T> {
    pub(in crate::solver) fn new() -> Self {
        Self { scale: Vec::new(), beta: T::one(), b_norm: T::one() }
    }

    /// The scaling of a checked problem.
    pub(in crate::solver) fn of<const D: usize>(problem: &ConeProblem<T, D>) -> Self {
        let mut scaling = Self::new();
        scaling.prepare(problem);
        scaling
    }

    /// Takes the scaling of another problem, keeping the memory.
    pub(super) fn prepare<const D: usize>(&mut self, problem: &ConeProblem<T, D>) {
        let m = problem.contacts();
        self.scale.clear();
        self.scale
            .extend((0..m).map(|i| T::one() / ComplexField::sqrt(largest_eigenvalue(problem.diagonal(i)))));
        let square =
            problem.b().iter().zip(&self.scale).fold(T::zero(), |sum, (b, &s)| sum + (b * s).norm_squared());
        self.beta = ComplexField::sqrt(square / from_usize::<T>(m));
        self.b_norm = problem.b_norm();
    }

    /// s_α of every contact.
    pub(super) fn scale(&self) -> &[T] {
        &self.scale
    }

    /// N s of a scaled percussion 1 of contact `contact`.
    pub(super) fn unit(&self, contact: usize) -> T {
        self.beta * self.scale[contact]
    }

    /// r′ of r.
    pub(in crate::solver) fn enter<const D: usize>(&self, r: &[SVector<T, D>], x: &mut Vec<SVector<T, D>>) {
        x.clear();
        x.extend(r.iter().zip(&self.scale).map(|(r, &s)| r / (self.beta * s)));
    }

    /// r of r′.
    pub(in crate::solver) fn leave<const D: usize>(&self, x: &[SVector<T, D>], r: &mut [SVector<T, D>]) {
        for ((r, x), &s) in r.iter_mut().zip(x).zip(&self.scale) {
            *r = x * (self.beta * s);
        }
    }

    /// w′ = S w/β of w, and b′ of b.
    pub(super) fn enter_velocities<const D: usize>(&self, w: &[SVector<T, D>], x: &mut Vec<SVector<T, D>>) {
        x.clear();
        x.extend(w.iter().zip(&self.scale).map(|(w, &s)| w * (s / self.beta)));
    }

    /// The scaled residual of the problem as given, from the parts f′ of the scaled problem's natural map.
    pub(super) fn residual<const D: usize>(&self, parts: impl Iterator<Item = SVector<T, D>>) -> T {
        let square = parts.zip(&self.scale).fold(T::zero(), |sum, (f, &s)| sum + (f / s).norm_squared());
        ComplexField::sqrt(square) * self.beta / self.b_norm
    }

    /// The scaled problem with W formed, for methods that read the entries of W.
    pub(in crate::solver) fn scaled<const D: usize>(&self, problem: &ConeProblem<T, D>) -> ConeProblem<T, D> {
        let mut scaled = ConeProblem::default();
        let (delassus, b, cones) = scaled.parts_mut();
        let mut own = BlockMatrix::new();
        let w = problem.delassus().form_in(&mut own);
        for (i, &s) in self.scale.iter().enumerate() {
            delassus.start_row();
            for (j, block) in w.row(i) {
                delassus.push(j, block * (s * self.scale[j]));
            }
        }
        self.enter_velocities(problem.b(), b);
        cones.extend_from_slice(problem.cones());
        scaled
    }
}
