//! Building a scene of planar rigid bodies, every number checked where it enters.

use nalgebra::Vector2;

use super::sweep::Sweep;
use super::{Contactor, HalfPlane, Interfaces, RigidBodies};
use crate::linalg::Symmetric;
use crate::scalar::{Scalar, all_finite, to_f64};
use crate::system::{Forces, SystemError};

/// Mass (kg) and moment of inertia about the centre of mass (kg m²) of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body<T> {
    /// Mass m > 0.
    pub mass: T,
    /// Moment of inertia I > 0.
    pub inertia: T,
}

/// A body of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BodyId(usize);

impl BodyId {
    /// Index i of the body: it owns q[3i..3i+3].
    pub fn index(self) -> usize {
        self.0
    }
}

/// A disc or point of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ContactorId(usize);

/// A group of contactors and half-planes: interfaces are declared between groups.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GroupId(usize);

/// Builder of [`RigidBodies`].
#[derive(Debug, Clone)]
pub struct RigidBodiesBuilder<T: Scalar> {
    bodies: Vec<(String, Body<T>)>,
    force: Vec<T>,
    contactors: Vec<Contactor<T>>,
    planes: Vec<HalfPlane<T>>,
    groups: usize,
    interfaces: Vec<(usize, usize)>,
}

impl<T: Scalar> Default for RigidBodiesBuilder<T> {
    fn default() -> Self {
        let (contactors, planes, interfaces) = (Vec::new(), Vec::new(), Vec::new());
        Self { bodies: Vec::new(), force: Vec::new(), contactors, planes, groups: 0, interfaces }
    }
}

fn check<T: Scalar>(
    what: impl FnOnce() -> String,
    values: &[T],
    ok: impl Fn(T) -> bool,
    range: &'static str,
) -> Result<(), SystemError> {
    match values.iter().find(|&&x| !all_finite([&x]) || !ok(x)) {
        Some(&x) => Err(SystemError::OutOfRange { what: what(), value: to_f64(x), range }),
        None => Ok(()),
    }
}

fn known(what: &'static str, index: usize, count: usize) -> Result<usize, SystemError> {
    if index < count { Ok(index) } else { Err(SystemError::Unknown { what, index, count }) }
}

impl<T: Scalar> RigidBodiesBuilder<T> {
    /// Adds a body.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`] for a mass or an inertia that is not finite and positive.
    pub fn body(&mut self, name: &str, body: Body<T>) -> Result<BodyId, SystemError> {
        let positive = |x| x > T::zero();
        check(|| format!("mass of `{name}`"), &[body.mass], positive, "finite and > 0")?;
        check(|| format!("inertia of `{name}`"), &[body.inertia], positive, "finite and > 0")?;
        self.bodies.push((name.into(), body));
        self.force.extend([T::zero(); 3]);
        Ok(BodyId(self.bodies.len() - 1))
    }

    /// Adds a constant force (N) and torque (N m) to a body.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn force(&mut self, body: BodyId, force: [T; 2], torque: T) -> Result<(), SystemError> {
        let i = 3 * known("body", body.0, self.bodies.len())?;
        let load = [force[0], force[1], torque];
        check(|| format!("force on `{}`", self.bodies[i / 3].0), &load, |_| true, "finite")?;
        self.force[i..i + 3].iter_mut().zip(load).for_each(|(f, load)| *f += load);
        Ok(())
    }

    /// Adds the weight m·g of every body defined so far, for the acceleration of gravity `g` (m/s²).
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`].
    pub fn gravity(&mut self, g: [T; 2]) -> Result<(), SystemError> {
        for i in 0..self.bodies.len() {
            let mass = self.bodies[i].1.mass;
            self.force(BodyId(i), [mass * g[0], mass * g[1]], T::zero())?;
        }
        Ok(())
    }

    /// A new group.
    pub fn group(&mut self) -> GroupId {
        self.groups += 1;
        GroupId(self.groups - 1)
    }

    /// Adds a disc of radius `radius` ≥ 0 (m), a point if 0, centred at `centre` (m) in the frame of the body.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn disc(
        &mut self,
        label: &str,
        body: BodyId,
        centre: [T; 2],
        radius: T,
        group: GroupId,
    ) -> Result<ContactorId, SystemError> {
        let body = known("body", body.0, self.bodies.len())?;
        let group = known("group", group.0, self.groups)?;
        check(|| format!("radius of `{label}`"), &[radius], |x| x >= T::zero(), "finite and ≥ 0")?;
        check(|| format!("centre of `{label}`"), &centre, |_| true, "finite")?;
        let (label, centre) = (label.into(), Vector2::from(centre));
        self.contactors.push(Contactor { label, body, centre, radius, group });
        Ok(ContactorId(self.contactors.len() - 1))
    }

    /// Adds the fixed half-plane through `point` with outward `normal` (any length > 0): bodies stay on the side
    /// the normal points to.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn half_plane(
        &mut self,
        label: &str,
        point: [T; 2],
        normal: [T; 2],
        group: GroupId,
    ) -> Result<(), SystemError> {
        let group = known("group", group.0, self.groups)?;
        check(|| format!("point of `{label}`"), &point, |_| true, "finite")?;
        let normal = Vector2::from(normal);
        let length = [normal.norm()];
        let range = "finite and > 0";
        check(|| format!("length of the normal of `{label}`"), &length, |x| x > T::zero(), range)?;
        let normal = normal / length[0];
        let distance = normal.dot(&Vector2::from(point));
        self.planes.push(HalfPlane { label: label.into(), normal, distance, group });
        Ok(())
    }

    /// Declares that the contactors and half-planes of two groups touch, and returns the index of the interface;
    /// the same pair of groups is the same interface.
    ///
    /// # Errors
    /// [`SystemError::Unknown`].
    pub fn interface(&mut self, a: GroupId, b: GroupId) -> Result<usize, SystemError> {
        let (a, b) = (known("group", a.0, self.groups)?, known("group", b.0, self.groups)?);
        let pair = (a.min(b), a.max(b));
        Ok(self.interfaces.iter().position(|&p| p == pair).unwrap_or_else(|| {
            self.interfaces.push(pair);
            self.interfaces.len() - 1
        }))
    }

    /// The system.
    ///
    /// # Errors
    /// [`SystemError::Size`] without any body.
    pub fn build(self) -> Result<RigidBodies<T>, SystemError> {
        if self.bodies.is_empty() {
            return Err(SystemError::Size { what: "the scene without bodies", expected: 1, given: 0 });
        }
        let diagonal = self.bodies.iter().flat_map(|(_, b)| [b.mass, b.mass, b.inertia]).collect();
        let interfaces = Interfaces::new(self.groups, &self.interfaces);
        // Only discs of groups that meet other discs are swept.
        let meets = |group: usize| {
            self.contactors.iter().any(|other| interfaces.between(group, other.group).is_some())
        };
        let meeting: Vec<bool> = (0..self.groups).map(meets).collect();
        let swept = (0..self.contactors.len()).filter(|&i| meeting[self.contactors[i].group]);
        let sweep = Sweep::new(swept);
        Ok(RigidBodies {
            mass: Symmetric::Diagonal(diagonal),
            forces: Forces::constant(self.force),
            labels: self.bodies.into_iter().map(|(name, _)| name).collect(),
            contactors: self.contactors,
            planes: self.planes,
            interfaces,
            sweep,
        })
    }
}
