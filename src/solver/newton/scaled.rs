//! The problem in its own units: r = β S r′, W′ = S W S, b′ = S b/β.

use nalgebra::{ComplexField, SVector};

use super::body_space::BodySpace;
use super::contact_space::ContactSpace;
use super::maps::{Linear, Map};
use crate::cone::{ConeProblem, Delassus, de_saxce, largest_eigenvalue, project};
use crate::scalar::{Scalar, from_usize};

/// The scaled problem, s_α = λ_max(sym W_αα)^(−1/2), β = ‖S b‖/√m: cones, symmetry and De Saxcé's term survive, every
/// ρ becomes 1. W is not symmetrised.
#[derive(Debug, Clone)]
pub(in crate::solver) struct Scaled<T: Scalar, const D: usize> {
    scale: Vec<T>,
    beta: T,
    b: Vec<SVector<T, D>>,
    b_norm: T,
    friction: Vec<T>,
    system: System<T, D>,
    pub(in crate::solver) map: Map,
    /// Newton systems factored since the last preparation.
    pub(in crate::solver) factored: usize,
}

/// Where the Newton systems are solved: over the contacts with W formed, over the bodies with H and M̂.
#[derive(Debug, Clone)]
enum System<T: Scalar, const D: usize> {
    Contact(Box<ContactSpace<T, D>>),
    Body(Box<BodySpace<T, D>>),
}

impl<T: Scalar, const D: usize> Scaled<T, D> {
    pub(in crate::solver) fn new() -> Self {
        Self {
            scale: Vec::new(),
            beta: T::one(),
            b: Vec::new(),
            b_norm: T::one(),
            friction: Vec::new(),
            system: System::Contact(Box::new(ContactSpace::new())),
            map: Map::default(),
            factored: 0,
        }
    }

    pub(in crate::solver) fn prepare(&mut self, problem: &ConeProblem<T, D>) {
        let m = problem.contacts();
        self.scale.clear();
        self.scale
            .extend((0..m).map(|i| T::one() / ComplexField::sqrt(largest_eigenvalue(problem.diagonal(i)))));
        let square =
            problem.b().iter().zip(&self.scale).fold(T::zero(), |sum, (b, &s)| sum + (b * s).norm_squared());
        self.beta = ComplexField::sqrt(square / from_usize::<T>(m));
        self.b_norm = problem.b_norm();
        self.b.clear();
        self.b.extend(problem.b().iter().zip(&self.scale).map(|(b, &s)| b * (s / self.beta)));
        self.friction.clear();
        self.friction.extend_from_slice(problem.friction());
        match (&mut self.system, problem.delassus()) {
            (System::Contact(system), Delassus::Formed(w)) => system.prepare(w, &self.scale),
            (System::Body(system), Delassus::Factored(factors)) => system.prepare(factors, &self.scale),
            (system, Delassus::Formed(w)) => {
                let mut contact = ContactSpace::new();
                contact.prepare(w, &self.scale);
                *system = System::Contact(Box::new(contact));
            }
            (system, Delassus::Factored(factors)) => {
                let mut body = BodySpace::new();
                body.prepare(factors, &self.scale);
                *system = System::Body(Box::new(body));
            }
        }
        self.factored = 0;
    }

    pub(in crate::solver) fn contacts(&self) -> usize {
        self.b.len()
    }

    pub(super) fn friction(&self) -> &[T] {
        &self.friction
    }

    /// r′ of r, on the cones.
    pub(in crate::solver) fn enter(&self, r: &[SVector<T, D>], scaled: &mut Vec<SVector<T, D>>) {
        scaled.clear();
        let units = self.scale.iter().zip(&self.friction);
        scaled.extend(r.iter().zip(units).map(|(r, (&s, &mu))| project(&(r / (self.beta * s)), mu)));
    }

    /// r of r′, on the cones.
    pub(in crate::solver) fn leave(&self, scaled: &[SVector<T, D>], r: &mut [SVector<T, D>]) {
        for (((r, x), &s), &mu) in r.iter_mut().zip(scaled).zip(&self.scale).zip(&self.friction) {
            *r = project(x, mu) * (self.beta * s);
        }
    }

    /// N s of a scaled percussion 1 of contact `contact`.
    pub(super) fn unit(&self, contact: usize) -> T {
        self.beta * self.scale[contact]
    }

    /// w′ = S w/β of w.
    pub(super) fn enter_velocities(&self, w: &[SVector<T, D>], scaled: &mut Vec<SVector<T, D>>) {
        scaled.clear();
        scaled.extend(w.iter().zip(&self.scale).map(|(w, &s)| w * (s / self.beta)));
    }

    /// `onto` ← the projection of r on the cones.
    pub(super) fn project(&self, r: &[SVector<T, D>], onto: &mut [SVector<T, D>]) {
        onto.iter_mut().zip(r).zip(&self.friction).for_each(|((onto, r), &mu)| *onto = project(r, mu));
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

    /// The scaled residual of the problem at (r, w).
    pub(in crate::solver) fn residual(&self, r: &[SVector<T, D>], w: &[SVector<T, D>]) -> T {
        let mut sum = T::zero();
        for (((r, w), &mu), &s) in r.iter().zip(w).zip(&self.friction).zip(&self.scale) {
            sum += ((r - project(&(r - de_saxce(w, mu)), mu)) / s).norm_squared();
        }
        ComplexField::sqrt(sum) * self.beta / self.b_norm
    }

    /// ‖f‖ of the map at r with w + a (r − centre).
    pub(super) fn merit(
        &self,
        r: &[SVector<T, D>],
        w: &[SVector<T, D>],
        a: T,
        centre: &[SVector<T, D>],
    ) -> T {
        let mut sum = T::zero();
        for (((r, w), centre), &mu) in r.iter().zip(w).zip(centre).zip(&self.friction) {
            sum += self.map.value(r, &(w + (r - centre) * a), mu).norm_squared();
        }
        ComplexField::sqrt(sum)
    }

    /// Derivatives at the same point.
    pub(super) fn linearise(
        &self,
        r: &[SVector<T, D>],
        w: &[SVector<T, D>],
        a: T,
        centre: &[SVector<T, D>],
        linear: &mut Vec<Linear<T, D>>,
    ) {
        linear.clear();
        linear.extend(
            r.iter()
                .zip(w)
                .zip(centre)
                .zip(&self.friction)
                .map(|(((r, w), centre), &mu)| self.map.linearise(r, &(w + (r - centre) * a), mu)),
        );
    }

    /// The Newton step.
    ///
    /// # Errors
    /// The contact at which the factorisation found no pivot.
    pub(super) fn step(
        &mut self,
        linear: &[Linear<T, D>],
        a: T,
        dr: &mut [SVector<T, D>],
    ) -> Result<(), usize> {
        self.factored += 1;
        match &mut self.system {
            System::Contact(system) => system.step(linear, a, dr),
            System::Body(system) => system.step(linear, a, dr),
        }
    }
}
