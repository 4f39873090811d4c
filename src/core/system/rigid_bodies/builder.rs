//! Building a scene of planar rigid bodies, every number checked where it enters.

use nalgebra::Vector2;

use super::RigidBodies;
use super::body::{Body, BodyId, check};
use super::identity::MOST_CONTACTORS;
use super::joint::{Joint, JointSet};
use super::measure::Measure;
use super::moved::Moved;
use super::polygon::check_polygon;
use super::shape::{Contactor, GROUND, HalfPlane, Outline, Polygon};
use super::side::Side;
use super::sweep::Sweep;
use super::swept::Crossings;
use crate::linalg::Symmetric;
use crate::scalar::{Scalar, lit};
use crate::system::element::{Element, Stop};
use crate::system::forces::Load;
use crate::system::interfaces::{GroupId, Interfaces, declare, known};
use crate::system::{Forces, Signal, SystemError};

/// A disc or point of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ContactorId(pub(super) usize);

/// Builder of [`RigidBodies`].
#[derive(Debug, Clone)]
pub struct RigidBodiesBuilder<T: Scalar> {
    pub(super) bodies: Vec<(String, Body<T>)>,
    pub(super) force: Vec<T>,
    pub(super) loads: Vec<Load<T>>,
    /// Diagonals of K and C; empty while no body has a spring, no body a damper.
    pub(super) stiffness: Vec<T>,
    pub(super) damping: Vec<T>,
    pub(super) contactors: Vec<Contactor<T>>,
    pub(super) planes: Vec<HalfPlane<T>>,
    pub(super) groups: usize,
    pub(super) interfaces: Vec<(usize, usize)>,
    pub(super) joints: Vec<Joint<T>>,
    pub(super) elements: Vec<Element<T, Measure<T>>>,
    pub(super) stops: Vec<Stop<T, Measure<T>>>,
    pub(super) moved: Vec<Moved<T>>,
}

impl<T: Scalar> Default for RigidBodiesBuilder<T> {
    fn default() -> Self {
        let (contactors, planes, interfaces) = (Vec::new(), Vec::new(), Vec::new());
        let (bodies, force, joints) = (Vec::new(), Vec::new(), Vec::new());
        let (loads, stiffness, damping) = (Vec::new(), Vec::new(), Vec::new());
        let (elements, stops, groups) = (Vec::new(), Vec::new(), 0);
        let moved = Vec::new();
        Self {
            bodies,
            force,
            loads,
            stiffness,
            damping,
            contactors,
            planes,
            groups,
            interfaces,
            joints,
            elements,
            stops,
            moved,
        }
    }
}

/// diagonal[first..first + 3] += entries, the diagonal growing as needed; all zeros are nothing to add.
fn add_entries<T: Scalar>(diagonal: &mut Vec<T>, first: usize, entries: [T; 3]) {
    if entries != [T::zero(); 3] {
        diagonal.resize(diagonal.len().max(first + 3), T::zero());
        diagonal[first..].iter_mut().zip(entries).for_each(|(x, entry)| *x += entry);
    }
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
        if !self.moved.is_empty() {
            let (what, value) = (format!("place of body `{name}`"), self.bodies.len() as f64);
            return Err(SystemError::OutOfRange { what, value, range: "before those that move as told" });
        }
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

    /// Adds a force (N) and torque (N m) times a signal to a body.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn load(
        &mut self,
        body: BodyId,
        force: [T; 2],
        torque: T,
        signal: Signal<T>,
    ) -> Result<(), SystemError> {
        signal.check()?;
        if signal == Signal::Constant {
            return self.force(body, force, torque);
        }
        let i = 3 * known("body", body.0, self.bodies.len())?;
        let load = [force[0], force[1], torque];
        check(|| format!("load on `{}`", self.bodies[i / 3].0), &load, |_| true, "finite")?;
        let entries = load.into_iter().enumerate().map(|(axis, x)| (i + axis, x));
        self.loads.push((signal, entries.filter(|&(_, x)| x != T::zero()).collect()));
        Ok(())
    }

    /// Holds a body by springs to the ground, −k·(x, y, angle): without force where all three are 0.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`] for a stiffness (N/m, N/m, N m/rad) that is not finite and ≥ 0;
    /// [`SystemError::Unknown`].
    pub fn spring(&mut self, body: BodyId, stiffness: [T; 3]) -> Result<(), SystemError> {
        let i = 3 * known("body", body.0, self.bodies.len())?;
        check(
            || format!("stiffness of `{}`", self.bodies[i / 3].0),
            &stiffness,
            |k| k >= T::zero(),
            "finite and ≥ 0",
        )?;
        add_entries(&mut self.stiffness, i, stiffness);
        Ok(())
    }

    /// Damps the motion of a body, −c·(ẋ, ẏ, angular velocity).
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`] for a damping (N s/m, N s/m, N m s) that is not finite and ≥ 0;
    /// [`SystemError::Unknown`].
    pub fn damper(&mut self, body: BodyId, damping: [T; 3]) -> Result<(), SystemError> {
        let i = 3 * known("body", body.0, self.bodies.len())?;
        check(
            || format!("damping of `{}`", self.bodies[i / 3].0),
            &damping,
            |c| c >= T::zero(),
            "finite and ≥ 0",
        )?;
        add_entries(&mut self.damping, i, damping);
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

    /// Adds a disc of radius `radius` ≥ 0 (m), a point if 0, centred at `centre` (m) in the frame of the body, or of the
    /// [ground](BodyId::GROUND).
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
        let body = self.owner(body)?;
        let group = known("group", group.0, self.groups)?;
        check(|| format!("radius of `{label}`"), &[radius], |x| x >= T::zero(), "finite and ≥ 0")?;
        check(|| format!("centre of `{label}`"), &centre, |_| true, "finite")?;
        let (label, centre) = (label.into(), Vector2::from(centre));
        self.contactors.push(Contactor {
            label,
            body,
            centre,
            radius,
            outline: Outline::Disc,
            window: None,
            group,
        });
        Ok(ContactorId(self.contactors.len() - 1))
    }

    /// The body a shape is added to, or the ground.
    pub(super) fn owner(&self, body: BodyId) -> Result<usize, SystemError> {
        if body == BodyId::GROUND { Ok(GROUND) } else { known("body", body.0, self.bodies.len()) }
    }

    /// Adds a strictly convex polygon with `vertices` (m) in the frame of the body, from its centre of mass, in
    /// counterclockwise order; [`polygon_body`](super::polygon_body) gives the mass and the inertia of a homogeneous one.
    ///
    /// # Errors
    /// [`SystemError::Polygon`] for fewer than 3 or more than 1024 vertices, and for a vertex that is not finite or at
    /// which the outline does not turn left; [`SystemError::Unknown`].
    pub fn polygon(
        &mut self,
        label: &str,
        body: BodyId,
        vertices: &[[T; 2]],
        group: GroupId,
    ) -> Result<ContactorId, SystemError> {
        let body = self.owner(body)?;
        let group = known("group", group.0, self.groups)?;
        check_polygon(label, vertices)?;
        let vertices: Vec<Vector2<T>> = vertices.iter().map(|&x| x.into()).collect();
        let (least, most) =
            (vertices.iter()).fold((vertices[0], vertices[0]), |(a, b), x| (a.inf(x), b.sup(x)));
        let centre = (least + most) * lit::<T>(0.5);
        let larger = nalgebra::RealField::max;
        let radius = vertices.iter().fold(T::zero(), |r, x| larger(r, (x - centre).norm()));
        let outline = Outline::Polygon(Polygon::new(vertices));
        self.contactors.push(Contactor {
            label: label.into(),
            body,
            centre,
            radius,
            outline,
            window: None,
            group,
        });
        Ok(ContactorId(self.contactors.len() - 1))
    }

    /// Pins the point `at` (m, in the frame of `body`) to the point `on` of `other`, or of the ground where `other` is
    /// `None` (fixed frame): two bilateral rows of the cone problem.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn pin(
        &mut self,
        label: &str,
        body: BodyId,
        at: [T; 2],
        other: Option<BodyId>,
        on: [T; 2],
    ) -> Result<(), SystemError> {
        self.joint(label, (body, at), (other, on), None)
    }

    /// Pins two points and holds the angle (rad) of `body` less that of `other` as well: three bilateral rows.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn weld(
        &mut self,
        label: &str,
        body: BodyId,
        at: [T; 2],
        other: Option<BodyId>,
        on: [T; 2],
        angle: T,
    ) -> Result<(), SystemError> {
        self.joint(label, (body, at), (other, on), Some(angle))
    }

    /// The ends of what connects a body to another or to the ground; one of the two moves under forces.
    pub(super) fn connected(
        &self,
        what: &str,
        (body, at): (BodyId, [T; 2]),
        (other, on): (Option<BodyId>, [T; 2]),
    ) -> Result<(Side<T>, Side<T>), SystemError> {
        let body = known("body", body.0, self.bodies.len())?;
        let other = other.filter(|&other| other != BodyId::GROUND);
        let other = other.map(|other| known("body", other.0, self.bodies.len())).transpose()?;
        let name = |body: usize| self.bodies[body].0.clone();
        if other == Some(body) {
            return Err(SystemError::OneBody { what: what.into(), body: name(body) });
        }
        let free = self.free_bodies();
        if body >= free && other.is_none_or(|other| other >= free) {
            let other = other.map_or("the ground".into(), |other| format!("`{}`", name(other)));
            let bodies = format!("`{}` with {other}", name(body));
            return Err(SystemError::NoneFree { what: what.into(), bodies });
        }
        Ok((Side { body: Some(body), point: at.into() }, Side { body: other, point: on.into() }))
    }

    /// Number of bodies that move under forces.
    fn free_bodies(&self) -> usize {
        self.bodies.len() - self.moved.len()
    }

    fn joint(
        &mut self,
        label: &str,
        (body, at): (BodyId, [T; 2]),
        (other, on): (Option<BodyId>, [T; 2]),
        angle: Option<T>,
    ) -> Result<(), SystemError> {
        let (a, b) = self.connected(&format!("joint `{label}`"), (body, at), (other, on))?;
        let numbers = [at[0], at[1], on[0], on[1], angle.unwrap_or_else(T::zero)];
        check(|| format!("point or angle of joint `{label}`"), &numbers, |_| true, "finite")?;
        self.joints.push(Joint { label: label.into(), a, b, angle });
        Ok(())
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
        self.half_plane_of(label, BodyId::GROUND, point, normal, group)
    }

    /// As [`half_plane`](Self::half_plane), in the frame of a body that moves as told, or of the ground.
    ///
    /// # Errors
    /// As there, and [`SystemError::OutOfRange`] for a body that moves under forces.
    pub fn half_plane_of(
        &mut self,
        label: &str,
        body: BodyId,
        point: [T; 2],
        normal: [T; 2],
        group: GroupId,
    ) -> Result<(), SystemError> {
        let body = self.owner(body)?;
        if body < self.free_bodies() {
            let (what, range) = (format!("body of half-plane `{label}`"), "one that moves as told");
            return Err(SystemError::OutOfRange { what, value: body as f64, range });
        }
        let group = known("group", group.0, self.groups)?;
        check(|| format!("point of `{label}`"), &point, |_| true, "finite")?;
        let normal = Vector2::from(normal);
        let length = [normal.norm()];
        let range = "finite and > 0";
        check(|| format!("length of the normal of `{label}`"), &length, |x| x > T::zero(), range)?;
        let normal = normal / length[0];
        let distance = normal.dot(&Vector2::from(point));
        self.planes.push(HalfPlane { label: label.into(), body, normal, distance, group });
        Ok(())
    }

    /// Declares that the contactors and half-planes of two groups touch, and returns the index of the interface;
    /// the same pair of groups is the same interface.
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
    /// [`SystemError::Size`] without any body, [`SystemError::OutOfRange`] for more than 2²⁰ contactors or half-planes
    /// in a scene with polygons.
    pub fn build(self) -> Result<RigidBodies<T>, SystemError> {
        let polygons = self.contactors.iter().any(|contactor| contactor.polygon().is_some());
        for (what, count) in [("contactors", self.contactors.len()), ("half-planes", self.planes.len())] {
            if polygons && count > MOST_CONTACTORS {
                let what = format!("number of {what} in a scene with polygons");
                let range = "at most 2^20";
                return Err(SystemError::OutOfRange { what, value: count as f64, range });
            }
        }
        if self.bodies.is_empty() {
            return Err(SystemError::Size { what: "the scene without bodies", expected: 1, given: 0 });
        }
        let diagonal: Vec<T> = self.bodies.iter().flat_map(|(_, b)| [b.mass, b.mass, b.inertia]).collect();
        let dofs = diagonal.len();
        let free = self.free_bodies();
        let prescribed = Moved::prescribed(3 * free, self.moved)?;
        let interfaces = Interfaces::new(self.groups, &self.interfaces);
        // Only contactors of groups that meet other contactors are swept.
        let meets = |group: usize| {
            self.contactors.iter().any(|other| interfaces.between(group, other.group).is_some())
        };
        let meeting: Vec<bool> = (0..self.groups).map(meets).collect();
        let swept = (0..self.contactors.len()).filter(|&i| meeting[self.contactors[i].group]);
        let sweep = Sweep::new(swept);
        let operator = |mut entries: Vec<T>| {
            entries.resize(diagonal.len(), T::zero());
            Symmetric::Diagonal(entries)
        };
        let present = |entries: Vec<T>| (!entries.is_empty()).then(|| operator(entries));
        let constant = Forces::constant(self.force);
        let loads = self.loads.into_iter();
        Ok(RigidBodies {
            stiffness: present(self.stiffness),
            damping: present(self.damping),
            mass: Symmetric::Diagonal(diagonal),
            forces: loads.fold(constant, |sum, (signal, entries)| sum.with_load(signal, entries)),
            labels: self.bodies.into_iter().map(|(name, _)| name).collect(),
            polygons: self.contactors.iter().filter(|contactor| contactor.polygon().is_some()).count(),
            touches: Vec::new(),
            ghosts: Vec::new(),
            crossings: Crossings::new(&self.contactors, dofs),
            contactors: self.contactors,
            planes: self.planes,
            interfaces,
            sweep,
            joints: JointSet::new(self.joints, self.elements),
            stops: self.stops,
            still: vec![T::zero(); dofs],
            free,
            prescribed,
        })
    }
}

impl<T: Scalar> RigidBodiesBuilder<T> {
    /// Adds a body that moves as told, after all that move under forces: x, y (m) and the angle (rad) are those of `origin`
    /// and the displacements, each times its signal. It has no mass; the work of what moves it is booked as that of prescribed
    /// motion.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`].
    pub fn moved_body(
        &mut self,
        name: &str,
        origin: [T; 3],
        motion: [(T, Signal<T>); 3],
    ) -> Result<BodyId, SystemError> {
        check(|| format!("position or angle of `{name}`"), &origin, |_| true, "finite")?;
        for (displacement, signal) in &motion {
            check(|| format!("displacement of `{name}`"), &[*displacement], |_| true, "finite")?;
            signal.check()?;
        }
        self.bodies.push((name.into(), Body { mass: T::zero(), inertia: T::zero() }));
        self.force.extend([T::zero(); 3]);
        self.moved.push(Moved { origin, motion });
        Ok(BodyId(self.bodies.len() - 1))
    }
}
