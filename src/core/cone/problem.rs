//! The cone problem (W, b, cones), checked once, and the two residuals it is judged by.

use nalgebra::SVector;

use super::cones::{de_saxce, natural_map};
use super::precise::Bodies;
use super::spectrum::largest_eigenvalue;
use super::status::{StatusCount, status};
use super::{BlockMatrix, Cone, Delassus, FactoredDelassus, Form, ProblemError, Workspace, one_contact};
use crate::scalar::{Scalar, lit, to_f64};

/// Find r with w = W r + b and K* ∋ Φ(w) ⟂ r ∈ K, for contacts of dimension D.
///
/// W maps percussions (N s) to velocities (m/s); b is the free velocity shifted by the laws. W may be singular,
/// and slightly asymmetric (it is solved as given).
#[derive(Debug, Clone, PartialEq)]
pub struct ConeProblem<T: Scalar, const D: usize> {
    delassus: Delassus<T, D>,
    /// H and a diagonal M̂ beside a formed W, for products that cancel.
    pub(super) bodies: Bodies<T, D>,
    b: Vec<SVector<T, D>>,
    cones: Vec<Cone<T>>,
}

/// Distance of a candidate r from a solution, in the two norms in use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual<T> {
    /// ‖r − proj_K(r − Φ(w))‖₂ / (1 + ‖b‖₂): the natural-map residual of the literature. It mixes impulses and
    /// velocities, so it changes with the units.
    pub natural: T,
    /// ‖ρ⁻¹(r − proj_K(r − ρ Φ(w)))‖₂ / ‖b‖₂ with ρ_α = 1/λ_max(W_αα): a velocity over a velocity, free of
    /// units. Solvers converge on this one.
    pub scaled: T,
}

fn into_cones<T>(cones: Vec<impl Into<Cone<T>>>) -> Vec<Cone<T>> {
    cones.into_iter().map(Into::into).collect()
}

impl<T: Scalar, const D: usize> Default for ConeProblem<T, D> {
    fn default() -> Self {
        Self { delassus: Delassus::default(), bodies: Bodies::default(), b: Vec::new(), cones: Vec::new() }
    }
}

impl<T: Scalar, const D: usize> ConeProblem<T, D> {
    /// A problem from data that are checked.
    ///
    /// # Errors
    /// Every [`ProblemError`].
    pub fn new(
        delassus: BlockMatrix<T, D>,
        b: Vec<SVector<T, D>>,
        cones: Vec<impl Into<Cone<T>>>,
    ) -> Result<Self, ProblemError> {
        let problem = Self { delassus: delassus.into(), b, cones: into_cones(cones), ..Self::default() };
        problem.check()?;
        problem.check_symmetric_semidefinite()?;
        Ok(problem)
    }

    /// A problem with W = H M̂⁻¹ Hᵀ in the given form: symmetric and positive semidefinite by construction.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn factored(
        delassus: FactoredDelassus<T, D>,
        form: Form,
        b: Vec<SVector<T, D>>,
        cones: Vec<impl Into<Cone<T>>>,
    ) -> Result<Self, ProblemError> {
        let delassus = match form {
            Form::Formed => Delassus::Formed(delassus.form()),
            Form::Factored => Delassus::Factored(Box::new(delassus)),
            Form::Auto => Delassus::where_it_pays(delassus),
        };
        let problem = Self { delassus, b, cones: into_cones(cones), ..Self::default() };
        problem.check()?;
        Ok(problem)
    }

    /// The problem in another arithmetic, with W formed; [`check`](Self::check) tells whether it still is one.
    pub fn cast<U: Scalar>(&self) -> ConeProblem<U, D> {
        ConeProblem {
            delassus: Delassus::Formed(self.delassus.form_in(&mut BlockMatrix::new()).cast()),
            b: self.b.iter().map(|b| b.map(|x| lit(to_f64(x)))).collect(),
            cones: self.cones.iter().map(|cone| cone.cast()).collect(),
            ..ConeProblem::default()
        }
    }

    /// W: block by block, or H and M̂.
    #[inline]
    pub fn delassus(&self) -> &Delassus<T, D> {
        &self.delassus
    }

    /// H and M̂, where the problem holds W in factored form.
    pub fn factors(&self) -> Option<&FactoredDelassus<T, D>> {
        self.delassus.factors()
    }

    /// Number of contacts m.
    pub fn contacts(&self) -> usize {
        self.b.len()
    }

    /// b, one block per contact, in the order (N, T1, T2).
    pub fn b(&self) -> &[SVector<T, D>] {
        &self.b
    }

    /// The cones, one per contact.
    #[inline]
    pub fn cones(&self) -> &[Cone<T>] {
        &self.cones
    }

    /// The parts, to refill them in place; [`check`](Self::check) tells whether they still are a problem.
    /// A problem in factored form becomes one with W formed; one that was told the bodies behind W forgets them.
    pub fn parts_mut(&mut self) -> (&mut BlockMatrix<T, D>, &mut Vec<SVector<T, D>>, &mut Vec<Cone<T>>) {
        self.bodies.clear();
        (self.delassus.formed_mut(), &mut self.b, &mut self.cones)
    }

    /// b and the cones, to change them under the same W.
    pub fn terms_mut(&mut self) -> (&mut [SVector<T, D>], &mut [Cone<T>]) {
        (&mut self.b, &mut self.cones)
    }

    /// W_αα.
    ///
    /// # Panics
    /// If the block is absent, which [`check`](Self::check) excludes.
    #[inline]
    pub fn diagonal(&self, contact: usize) -> &nalgebra::SMatrix<T, D, D> {
        self.delassus.diagonal(contact).expect("checked problems have every diagonal block")
    }

    /// (W r + b)_α. In factored form it is a product with all of W, and allocates: [`velocities`](Self::velocities) tells
    /// those of all contacts for the same price.
    #[inline]
    pub fn shifted_velocity(&self, contact: usize, r: &[SVector<T, D>]) -> SVector<T, D> {
        self.delassus.row_product(contact, r) + self.b[contact]
    }

    /// Calls `visit` with every α and (W r + b)_α: W is not formed for it.
    pub fn velocities(
        &self,
        r: &[SVector<T, D>],
        workspace: &mut Workspace<T>,
        mut visit: impl FnMut(usize, SVector<T, D>),
    ) {
        match &self.delassus {
            Delassus::Factored(factored) => {
                let velocities = factored.velocities(r, workspace);
                for (i, b) in self.b.iter().enumerate() {
                    visit(i, factored.jacobian.velocity(i, factored.dofs(), velocities) + b);
                }
            }
            Delassus::Formed(w) => {
                (0..r.len()).for_each(|i| visit(i, w.row_product(i, r) + self.b[i]));
            }
        }
    }

    /// ‖b‖₂.
    pub fn b_norm(&self) -> T {
        nalgebra::ComplexField::sqrt(self.b.iter().fold(T::zero(), |sum, b| sum + b.norm_squared()))
    }

    /// Whether r = 0 is a solution: every b_N ≥ 0.
    pub fn takes_off(&self) -> bool {
        self.b.iter().all(|b| b[0] >= T::zero())
    }

    /// Both residuals of `r`, measured on the problem.
    ///
    /// With b = 0 the scaled residual is 0 at r = 0 and infinite elsewhere.
    ///
    /// # Panics
    /// If `r` has not one block per contact.
    pub fn residual(&self, r: &[SVector<T, D>]) -> Residual<T> {
        // A formed W needs no workspace, and an empty one is no allocation.
        self.residual_in(r, &mut Workspace::default())
    }

    /// [`residual`](Self::residual) in a workspace that the caller keeps.
    ///
    /// # Panics
    /// If `r` has not one block per contact.
    pub fn residual_in(&self, r: &[SVector<T, D>], workspace: &mut Workspace<T>) -> Residual<T> {
        assert_eq!(r.len(), self.contacts(), "one percussion per contact");
        self.measure(r, |visit| self.velocities(r, workspace, visit))
    }

    /// Both residuals of `r` at the velocities that `velocities` tells.
    pub(super) fn measure(
        &self,
        r: &[SVector<T, D>],
        velocities: impl FnOnce(&mut dyn FnMut(usize, SVector<T, D>)),
    ) -> Residual<T> {
        let (mut natural, mut scaled) = (T::zero(), T::zero());
        velocities(&mut |i, w| {
            let phi = de_saxce(&w, self.cones[i]);
            natural += natural_map(&r[i], &phi, self.cones[i]).norm_squared();
            let size = largest_eigenvalue(self.diagonal(i));
            scaled += (natural_map(&r[i], &(phi / size), self.cones[i]) * size).norm_squared();
        });
        let (natural, scaled) = (nalgebra::ComplexField::sqrt(natural), nalgebra::ComplexField::sqrt(scaled));
        let b = self.b_norm();
        let scaled = if scaled == T::zero() { scaled } else { scaled / b };
        Residual { natural: natural / (T::one() + b), scaled }
    }

    /// The scaled residual alone, with `sizes` = λ_max(W_αα) at hand.
    pub(crate) fn scaled_residual(
        &self,
        r: &[SVector<T, D>],
        sizes: &[T],
        workspace: &mut Workspace<T>,
    ) -> T {
        let mut sum = T::zero();
        self.velocities(r, workspace, |i, w| {
            let (cone, size) = (self.cones[i], sizes[i]);
            let phi = de_saxce(&w, cone);
            sum += (natural_map(&r[i], &(phi / size), cone) * size).norm_squared();
        });
        if sum == T::zero() { sum } else { nalgebra::ComplexField::sqrt(sum) / self.b_norm() }
    }

    /// Status of every contact in the solution `r`, with the boundary of the cone taken to `tolerance`.
    pub fn count_status(&self, r: &[SVector<T, D>], tolerance: T) -> StatusCount {
        let mut count = StatusCount::default();
        r.iter().zip(&self.cones).for_each(|(r, &cone)| count.add(status(r, cone, tolerance)));
        count
    }

    /// The exact solution of contact `contact` alone, the percussions of the others held at `r`.
    #[inline]
    pub fn solve_contact(&self, contact: usize, r: &[SVector<T, D>]) -> SVector<T, D> {
        let block = self.diagonal(contact);
        let local = self.shifted_velocity(contact, r) - block * r[contact];
        one_contact::solve_one_contact(block, &local, self.cones[contact])
    }
}
