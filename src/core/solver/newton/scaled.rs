//! The scaled problem as the Newton methods use it: velocities, residual, equation and Newton system.

use nalgebra::{ComplexField, SVector};

use super::body_space::BodySpace;
use super::contact_space::ContactSpace;
use super::maps::{Formulation, Linear};
use super::scaling::Scaling;
use crate::cone::{Cone, ConeProblem, Delassus, de_saxce, project};
use crate::linalg::NoPivot;
use crate::scalar::Scalar;

/// The problem in the units of [`Scaling`], with W as the problem holds it: formed, or as H and M̂.
#[derive(Debug, Clone)]
pub(in crate::solver) struct ScaledProblem<T: Scalar, const D: usize> {
    scaling: Scaling<T>,
    b: Vec<SVector<T, D>>,
    cones: Vec<Cone<T>>,
    system: System<T, D>,
}

/// Where the Newton systems are solved: over the contacts with W formed, over the bodies with H and M̂.
#[derive(Debug, Clone)]
enum System<T: Scalar, const D: usize> {
    Contact(Box<ContactSpace<T, D>>),
    Body(Box<BodySpace<T, D>>),
}

impl<T: Scalar, const D: usize> ScaledProblem<T, D> {
    pub(in crate::solver) fn new() -> Self {
        Self {
            scaling: Scaling::new(),
            b: Vec::new(),
            cones: Vec::new(),
            system: System::Contact(Box::new(ContactSpace::new())),
        }
    }

    /// Takes over a checked problem, keeping the memory and the orderings of the last one.
    pub(in crate::solver) fn prepare(&mut self, problem: &ConeProblem<T, D>) {
        self.scaling.prepare(problem);
        self.scaling.enter_velocities(problem.b(), &mut self.b);
        self.cones.clear();
        self.cones.extend_from_slice(problem.cones());
        let scale = self.scaling.scale();
        match (&mut self.system, problem.delassus()) {
            (System::Contact(system), Delassus::Formed(w)) => system.prepare(w, scale),
            (System::Body(system), Delassus::Factored(factors)) => system.prepare(factors, scale),
            (system, Delassus::Formed(w)) => {
                let mut contact = ContactSpace::new();
                contact.prepare(w, scale);
                *system = System::Contact(Box::new(contact));
            }
            (system, Delassus::Factored(factors)) => {
                let mut body = BodySpace::new();
                body.prepare(factors, scale);
                *system = System::Body(Box::new(body));
            }
        }
    }

    pub(in crate::solver) fn contacts(&self) -> usize {
        self.b.len()
    }

    pub(in crate::solver) fn cones(&self) -> &[Cone<T>] {
        &self.cones
    }

    pub(in crate::solver) fn b(&self) -> &[SVector<T, D>] {
        &self.b
    }

    /// r′ of r, on the cones.
    pub(in crate::solver) fn enter(&self, r: &[SVector<T, D>], x: &mut Vec<SVector<T, D>>) {
        self.scaling.enter(r, x);
        self.project_in_place(x);
    }

    /// r of r′, on the cones.
    pub(in crate::solver) fn leave(&self, x: &[SVector<T, D>], r: &mut [SVector<T, D>]) {
        self.project(x, r);
        r.iter_mut().enumerate().for_each(|(i, r)| *r *= self.scaling.unit(i));
    }

    /// N s of a scaled percussion 1 of contact `contact`.
    pub(super) fn unit(&self, contact: usize) -> T {
        self.scaling.unit(contact)
    }

    /// w′ of w.
    pub(super) fn enter_velocities(&self, w: &[SVector<T, D>], x: &mut Vec<SVector<T, D>>) {
        self.scaling.enter_velocities(w, x);
    }

    /// `onto` ← the projection of r on the cones.
    pub(in crate::solver) fn project(&self, r: &[SVector<T, D>], onto: &mut [SVector<T, D>]) {
        onto.iter_mut().zip(r).zip(&self.cones).for_each(|((onto, r), &cone)| *onto = project(r, cone));
    }

    /// w = W r + b.
    pub(in crate::solver) fn velocity(&mut self, r: &[SVector<T, D>], w: &mut [SVector<T, D>]) {
        self.apply(r, w);
        w.iter_mut().zip(&self.b).for_each(|(w, b)| *w += b);
    }

    /// out = W x.
    pub(super) fn apply(&mut self, x: &[SVector<T, D>], out: &mut [SVector<T, D>]) {
        match &mut self.system {
            System::Contact(system) => system.apply(x, out),
            System::Body(system) => system.apply(x, out),
        }
    }

    /// `x` ← its projection on the cones.
    pub(in crate::solver) fn project_in_place(&self, x: &mut [SVector<T, D>]) {
        x.iter_mut().zip(&self.cones).for_each(|(x, &cone)| *x = project(x, cone));
    }

    /// F(r) = Φ(W r + b).
    pub(in crate::solver) fn force(&mut self, r: &[SVector<T, D>], force: &mut [SVector<T, D>]) {
        self.velocity(r, force);
        force.iter_mut().zip(&self.cones).for_each(|(w, &cone)| *w = de_saxce(w, cone));
    }

    /// The scaled residual of the problem as given at (r, w).
    pub(in crate::solver) fn residual(&self, r: &[SVector<T, D>], w: &[SVector<T, D>]) -> T {
        let contacts = r.iter().zip(w).zip(&self.cones);
        self.scaling.residual(contacts.map(|((r, w), &cone)| r - project(&(r - de_saxce(w, cone)), cone)))
    }

    /// The same with F = Φ(w) at hand.
    pub(in crate::solver) fn residual_of_force(&self, r: &[SVector<T, D>], force: &[SVector<T, D>]) -> T {
        let contacts = r.iter().zip(force).zip(&self.cones);
        self.scaling.residual(contacts.map(|((r, f), &cone)| r - project(&(r - f), cone)))
    }

    /// f and its derivatives at r with w + a (r − centre).
    pub(super) fn linearise(
        &self,
        formulation: Formulation,
        (r, w): (&[SVector<T, D>], &[SVector<T, D>]),
        (a, centre): (T, &[SVector<T, D>]),
        linear: &mut Vec<Linear<T, D>>,
    ) {
        linear.clear();
        linear.extend(
            r.iter()
                .zip(w)
                .zip(centre)
                .zip(&self.cones)
                .map(|(((r, w), centre), &cone)| formulation.linearise(r, &(w + (r - centre) * a), cone)),
        );
    }

    /// ‖f‖ at the same point.
    pub(super) fn merit(
        &self,
        formulation: Formulation,
        (r, w): (&[SVector<T, D>], &[SVector<T, D>]),
        (a, centre): (T, &[SVector<T, D>]),
    ) -> T {
        let mut sum = T::zero();
        for (((r, w), centre), &cone) in r.iter().zip(w).zip(centre).zip(&self.cones) {
            sum += formulation.value(r, &(w + (r - centre) * a), cone).norm_squared();
        }
        ComplexField::sqrt(sum)
    }

    /// Factors the Newton matrix C W + A + a C.
    ///
    /// # Errors
    /// The contact, or the block of velocities, at which the factorisation found no pivot.
    pub(super) fn factor(&mut self, linear: &[Linear<T, D>], a: T) -> Result<(), NoPivot> {
        match &mut self.system {
            System::Contact(system) => system.factor(linear, a),
            System::Body(system) => system.factor(linear, a),
        }
    }

    /// The Newton step: dr of C W dr + (A + a C) dr = −f by the factors of the same A, C and a.
    pub(super) fn step(&mut self, linear: &[Linear<T, D>], dr: &mut [SVector<T, D>]) {
        match &mut self.system {
            System::Contact(system) => system.step(linear, dr),
            System::Body(system) => system.step(linear, dr),
        }
    }

    /// Factors W + ρ I, for [`solve_regularised`](Self::solve_regularised).
    ///
    /// # Errors
    /// As [`factor`](Self::factor).
    pub(in crate::solver) fn factor_regularised(&mut self, rho: T) -> Result<(), NoPivot> {
        let linear = vec![Linear::sticking(SVector::zeros()); self.contacts()];
        self.factor(&linear, rho)
    }

    /// `x` ← (W + ρ I)⁻¹ x.
    pub(in crate::solver) fn solve_regularised(&mut self, x: &mut [SVector<T, D>]) {
        match &mut self.system {
            System::Contact(system) => system.solve_regularised(x),
            System::Body(system) => system.solve_regularised(x),
        }
    }
}
