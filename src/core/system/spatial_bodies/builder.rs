//! Building a scene of rigid bodies in space, every number checked where it enters.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::SpatialBodies;
use super::coordinate::Relation;
use super::identity::Packing;
use super::joints::JointSet;
use super::shape::{Contactor, DOFS, index};
use crate::geometry::{BroadPhase, Kind, NarrowPhase, Pose, Principal, Shape};
use crate::linalg::Symmetric;
use crate::scalar::{Scalar, from_usize, lit};
use crate::system::element::{Element, Stop};
use crate::system::forces::Load;
use crate::system::interfaces::{GroupId, Interfaces, declare, known};
use crate::system::rigid_bodies::check;
use crate::system::{BodyId, Forces, Signal, SystemError};

/// Mass (kg) and principal moments of inertia (kg m²) about the centre of mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpatialBody<T> {
    /// Mass m > 0.
    pub mass: T,
    /// J₁, J₂, J₃ > 0, each at most the sum of the others.
    pub moments: [T; 3],
}

/// Builder of [`SpatialBodies`].
#[derive(Debug, Clone)]
pub struct SpatialBodiesBuilder<T: Scalar> {
    pub(super) bodies: Vec<(String, SpatialBody<T>)>,
    force: Vec<T>,
    loads: Vec<Load<T>>,
    torque: Vec<T>,
    torque_loads: Vec<Load<T>>,
    contactors: Vec<Contactor<T>>,
    groups: usize,
    interfaces: Vec<(usize, usize)>,
    pub(super) elements: Vec<Element<T, Relation<T>>>,
    pub(super) stops: Vec<Stop<T, Relation<T>>>,
}

impl<T: Scalar> Default for SpatialBodiesBuilder<T> {
    fn default() -> Self {
        let (bodies, force, loads) = (Vec::new(), Vec::new(), Vec::new());
        let (torque, torque_loads) = (Vec::new(), Vec::new());
        let (contactors, interfaces) = (Vec::new(), Vec::new());
        let (elements, stops) = (Vec::new(), Vec::new());
        Self {
            bodies,
            force,
            loads,
            torque,
            torque_loads,
            contactors,
            groups: 0,
            interfaces,
            elements,
            stops,
        }
    }
}

impl<T: Scalar> SpatialBodiesBuilder<T> {
    /// Adds a body whose frame is that of its principal axes, at its centre of mass.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`] for a mass or a moment that is not finite and positive, [`SystemError::Inertia`] for
    /// moments that no body has.
    pub fn body(&mut self, name: &str, body: SpatialBody<T>) -> Result<BodyId, SystemError> {
        let positive = |x| x > T::zero();
        check(|| format!("mass of `{name}`"), &[body.mass], positive, "finite and > 0")?;
        check(|| format!("moment of inertia of `{name}`"), &body.moments, positive, "finite and > 0")?;
        Principal::of(&Matrix3::from_diagonal(&body.moments.into()))
            .map_err(|source| SystemError::Inertia { body: name.into(), source })?;
        self.bodies.push((name.into(), body));
        self.force.extend([T::zero(); DOFS]);
        self.torque.extend([T::zero(); DOFS]);
        Ok(BodyId(self.bodies.len() - 1))
    }

    /// A ball of the mean mass and the mean moments of the bodies there are, of 1 kg and 1 kg m² without any: what a body that
    /// [moves as told](Self::told) may weigh.
    pub fn mean_body(&self) -> SpatialBody<T> {
        let (mut mass, mut moment) = (T::zero(), T::zero());
        for (_, body) in &self.bodies {
            mass += body.mass;
            moment += body.moments.iter().fold(T::zero(), |sum, &moment| sum + moment) / lit::<T>(3.0);
        }
        if self.bodies.is_empty() {
            return SpatialBody { mass: T::one(), moments: [T::one(); 3] };
        }
        let count = from_usize::<T>(self.bodies.len());
        SpatialBody { mass: mass / count, moments: [moment / count; 3] }
    }

    /// Adds a constant force (N) along the fixed axes at the centre of mass, and a torque (N m) along the axes of the body.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn force(&mut self, body: BodyId, force: [T; 3], torque: [T; 3]) -> Result<(), SystemError> {
        for (dof, load) in self.load_entries(body, force, torque)? {
            self.force[dof] += load;
        }
        Ok(())
    }

    /// Adds a [force and torque](Self::force) times a signal.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn load(
        &mut self,
        body: BodyId,
        force: [T; 3],
        torque: [T; 3],
        signal: Signal<T>,
    ) -> Result<(), SystemError> {
        signal.check()?;
        if signal == Signal::Constant {
            return self.force(body, force, torque);
        }
        let entries = self.load_entries(body, force, torque)?;
        self.loads.push((signal, entries));
        Ok(())
    }

    /// Adds a torque (N m) about the fixed axes, times a signal.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn torque(&mut self, body: BodyId, torque: [T; 3], signal: Signal<T>) -> Result<(), SystemError> {
        signal.check()?;
        let entries = self.load_entries(body, [T::zero(); 3], torque)?;
        if signal == Signal::Constant {
            entries.into_iter().for_each(|(dof, load)| self.torque[dof] += load);
        } else {
            self.torque_loads.push((signal, entries));
        }
        Ok(())
    }

    fn load_entries(
        &self,
        body: BodyId,
        force: [T; 3],
        torque: [T; 3],
    ) -> Result<Vec<(usize, T)>, SystemError> {
        let i = known("body", body.0, self.bodies.len())?;
        let load = [force, torque].concat();
        check(|| format!("force on `{}`", self.bodies[i].0), &load, |_| true, "finite")?;
        Ok(load.into_iter().enumerate().map(|(k, load)| (DOFS * i + k, load)).collect())
    }

    /// Adds the weight of all bodies there are (m/s²).
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`].
    pub fn gravity(&mut self, gravity: [T; 3]) -> Result<(), SystemError> {
        for i in 0..self.bodies.len() {
            let mass = self.bodies[i].1.mass;
            self.force(BodyId(i), gravity.map(|g| mass * g), [T::zero(); 3])?;
        }
        Ok(())
    }

    /// Adds a group of shapes.
    pub fn group(&mut self) -> GroupId {
        self.groups += 1;
        GroupId(self.groups - 1)
    }

    /// Adds a shape at `local` in the frame of a body, or in the fixed one of [`BodyId::GROUND`].
    ///
    /// # Errors
    /// [`SystemError::Unknown`]; [`SystemError::OutOfRange`] for a half-space or a terrain on a body.
    pub fn shape(
        &mut self,
        label: &str,
        body: BodyId,
        shape: Shape<T>,
        local: Pose<T>,
        group: GroupId,
    ) -> Result<(), SystemError> {
        let body = index(body).map(|body| known("body", body, self.bodies.len())).transpose()?;
        let group = known("group", group.0, self.groups)?;
        let place = [local.position(), local.arm()];
        let numbers = place.iter().flat_map(|x| x.iter()).chain(local.orientation().coords.iter());
        let numbers: Vec<T> = numbers.copied().collect();
        check(|| format!("place of `{label}`"), &numbers, |_| true, "finite")?;
        if let (Some(body), Kind::HalfSpace | Kind::Terrain(_)) = (body, shape.kind()) {
            let what = format!("body of half-space or terrain `{label}`");
            return Err(SystemError::OutOfRange { what, value: body as f64, range: "the ground" });
        }
        self.contactors.push(Contactor { label: label.into(), body, shape, local, group });
        Ok(())
    }

    /// Adds the fixed half-space through `point` with outward `normal` (any length > 0): bodies stay on the side the normal
    /// points to.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn half_space(
        &mut self,
        label: &str,
        point: [T; 3],
        normal: [T; 3],
        group: GroupId,
    ) -> Result<(), SystemError> {
        check(|| format!("point of `{label}`"), &point, |_| true, "finite")?;
        let normal = Vector3::from(normal);
        let length = normal.norm();
        let range = "finite and > 0";
        check(|| format!("length of the normal of `{label}`"), &[length], |x| x > T::zero(), range)?;
        // Near −z any half turn about a horizontal axis serves.
        let about_x = || UnitQuaternion::from_quaternion(Quaternion::from_parts(T::zero(), Vector3::x()));
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), &normal).unwrap_or_else(about_x);
        self.shape(label, BodyId::GROUND, Shape::half_space(), Pose::new(point.into(), turn), group)
    }

    /// Declares that the shapes of two groups touch, and returns the index of the interface; the same pair of groups is the
    /// same interface.
    ///
    /// # Errors
    /// [`SystemError::Unknown`].
    pub fn interface(&mut self, a: GroupId, b: GroupId) -> Result<usize, SystemError> {
        let (a, b) = (known("group", a.0, self.groups)?, known("group", b.0, self.groups)?);
        Ok(declare(&mut self.interfaces, a, b))
    }

    /// The system.
    ///
    /// # Errors
    /// [`SystemError::Size`] without any body.
    pub fn build(self) -> Result<SpatialBodies<T>, SystemError> {
        if self.bodies.is_empty() {
            return Err(SystemError::Size { what: "the scene without bodies", expected: 1, given: 0 });
        }
        let diagonal = |(_, body): &(String, SpatialBody<T>)| {
            let [one, two, three] = body.moments;
            [body.mass, body.mass, body.mass, one, two, three]
        };
        let mass: Vec<T> = self.bodies.iter().flat_map(diagonal).collect();
        let constant = Forces::constant(self.force);
        let forces = self.loads.into_iter().fold(constant, |sum, (signal, of)| sum.with_load(signal, of));
        let any = !self.torque_loads.is_empty() || self.torque.iter().any(|&torque| torque != T::zero());
        let add = |sum: Forces<T>, (signal, of)| sum.with_load(signal, of);
        let torques = any.then(|| self.torque_loads.into_iter().fold(Forces::constant(self.torque), add));
        let size = |contactor: &Contactor<T>| {
            let arm = contactor.local.position().norm();
            contactor.body.map_or_else(T::zero, |_| arm + contactor.shape.size())
        };
        let larger = nalgebra::RealField::max;
        let moments: Vec<[T; 3]> = self.bodies.iter().map(|(_, body)| body.moments).collect();
        let (names, bodies) = self.bodies.into_iter().unzip();
        Ok(SpatialBodies {
            names,
            bodies,
            mass: Symmetric::Diagonal(mass),
            forces,
            torques,
            size: self.contactors.iter().fold(T::zero(), |most, contactor| larger(most, size(contactor))),
            interfaces: Interfaces::new(self.groups, &self.interfaces),
            packing: Packing::new(self.contactors.len()),
            contactors: self.contactors,
            joints: JointSet::new(self.elements, &moments),
            stops: self.stops,
            still: vec![T::zero(); DOFS * moments.len()],
            broad: BroadPhase::new(),
            narrow: NarrowPhase::new(),
            poses: Vec::new(),
            bounds: Vec::new(),
            pairs: Vec::new(),
            meeting: Vec::new(),
            found: Vec::new(),
        })
    }
}
