//! The unit-free form of a cone problem, in which every projection step length is 1.

use nalgebra::{ComplexField, SVector};

use crate::cone::{BlockMatrix, Cone, ConeProblem, largest_eigenvalue, natural_map};
use crate::scalar::{Scalar, from_usize};

/// W′ = S W S, b′ = S b/β with S_αα = s_α I, s_α = (ρ/λ_max(sym W_αα))^½, β = ‖S b‖/√m, and r = β S r′.
///
/// Cones, symmetry and the De Saxcé term survive, λ_max(sym W′_αα) = ρ, and b′ has entries of order one. W is not
/// symmetrised. A step length 1 of a projection in these units is one of ρ/λ_max in those of the problem.
#[derive(Debug, Clone)]
pub(in crate::solver) struct Scaling<T> {
    scale: Vec<T>,
    /// √ρ.
    root: T,
    beta: T,
    b_norm: T,
}

impl<T: Scalar> Scaling<T> {
    pub(in crate::solver) fn new() -> Self {
        Self { scale: Vec::new(), root: T::one(), beta: T::one(), b_norm: T::one() }
    }

    /// The scaling of a checked problem with ρ = 1.
    pub(in crate::solver) fn of<const D: usize>(problem: &ConeProblem<T, D>) -> Self {
        let mut scaling = Self::new();
        scaling.prepare(problem, T::one());
        scaling
    }

    /// Takes the scaling of another problem, keeping the memory.
    pub(super) fn prepare<const D: usize>(&mut self, problem: &ConeProblem<T, D>, rho: T) {
        self.root = ComplexField::sqrt(rho);
        let m = problem.contacts();
        self.scale.clear();
        self.scale
            .extend((0..m).map(|i| self.root / ComplexField::sqrt(largest_eigenvalue(problem.diagonal(i)))));
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

    /// The scaled residual of the problem as given, from r′ and Φ(w′) of every contact: its projections have step length
    /// 1/λ_max.
    pub(super) fn residual<const D: usize>(
        &self,
        contacts: impl Iterator<Item = (SVector<T, D>, SVector<T, D>)>,
        cones: &[Cone<T>],
    ) -> T {
        let (root, inverse) = (self.root, T::one() / self.root);
        let mut square = T::zero();
        for (((r, force), &cone), &s) in contacts.zip(cones).zip(&self.scale) {
            square += (natural_map(&(r * root), &(force * inverse), cone) / s).norm_squared();
        }
        ComplexField::sqrt(square) * root * self.beta / self.b_norm
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
