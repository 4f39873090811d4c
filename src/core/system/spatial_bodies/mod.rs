//! Rigid bodies in space: balls, capsules, boxes, cylinders, cones and convex polyhedra, unions of them on a body, against
//! half-spaces, fixed shapes and each other.
//!
//! A body owns q = (x, y, z, w, i, j, k), its centre of mass and the unit quaternion that turns its principal axes to the fixed
//! ones, and v = (ẋ, ω), ω along its principal axes: M = diag(m, m, m, J₁, J₂, J₃) is constant, W = H M⁻¹ Hᵀ symmetric, and
//! the gyroscopic torque ω × J ω is no term of the cone problem but part of the [free flight](Dynamics::fly).
//!
//! H of a contact with unit normal n from the first body to the second, tangents t₁, t₂ and arms r₁, r₂ has in the row of an
//! axis f the columns
//!
//! ```text
//!   second body   f,   R₂ᵀ (r₂ × f)          first body   −f,   −R₁ᵀ (r₁ × f)
//! ```
//!
//! so that u = H v is the velocity of the second point less that of the first. Two bodies have the point half way across the
//! gap in common: what one gains of the angular momentum the other loses. On a body over what is fixed it is its own point.

mod builder;
mod connect;
mod coordinate;
mod flight;
mod identity;
mod joints;
mod pictures;
mod shape;
mod told;

use nalgebra::{SVector, Vector3};

pub use builder::{SpatialBodiesBuilder, SpatialBody};
pub use connect::{Bodies, SpatialRelative};
pub use told::SpatialMotion;

use super::element::{Coordinate, Stop};
use super::interfaces::Interfaces;
use super::{ContactPlace, Contacts, Describe, Dynamics, Forces, Joints, Scales, Solid};
use crate::contact::{Candidate, ContactId};
use crate::geometry::{self, Bounds, BroadPhase, Meeting, NarrowPhase, Pose, frame, resolve};
use crate::linalg::{BlockRows, Symmetric, max_abs};
use crate::scalar::{Scalar, lit};
use coordinate::Relation;
use identity::{Packing, STOPS};
use joints::JointSet;
use shape::{COORDINATES, Contactor, DOFS, body_pose, parts, set_orientation};

/// A contact that [`Contacts::candidates`] named.
#[derive(Debug, Clone, Copy)]
struct Found<T: Scalar> {
    id: ContactId,
    interface: usize,
    /// The shapes, the obstacle first.
    first: usize,
    second: usize,
    contact: geometry::Contact<T>,
}

/// Rigid bodies in space.
#[derive(Debug)]
pub struct SpatialBodies<T: Scalar> {
    mass: Symmetric<T>,
    bodies: Vec<SpatialBody<T>>,
    forces: Forces<T>,
    /// Torques about fixed axes.
    torques: Option<Forces<T>>,
    names: Vec<String>,
    contactors: Vec<Contactor<T>>,
    /// The largest distance of a point of a body from its centre of mass (m).
    size: T,
    interfaces: Interfaces,
    packing: Packing,
    joints: JointSet<T>,
    stops: Vec<Stop<T, Relation<T>>>,
    /// No motion.
    still: Vec<T>,
    broad: BroadPhase<T>,
    narrow: NarrowPhase<T>,
    poses: Vec<Pose<T>>,
    bounds: Vec<Bounds<T>>,
    pairs: Vec<(usize, usize)>,
    meeting: Vec<geometry::Contact<T>>,
    /// Ordered by identity.
    found: Vec<Found<T>>,
}

impl<T: Scalar> SpatialBodies<T> {
    /// Starts a scene.
    pub fn builder() -> SpatialBodiesBuilder<T> {
        SpatialBodiesBuilder::default()
    }

    /// Number of bodies.
    pub fn bodies(&self) -> usize {
        self.bodies.len()
    }

    /// Angular momentum about the origin (kg m²/s): Σ m x × ẋ + R J ω.
    pub fn angular_momentum(&self, q: &[T], v: &[T]) -> [T; 3] {
        let mut sum = Vector3::zeros();
        for body in 0..self.bodies() {
            let (position, orientation) = parts(&q[COORDINATES * body..]);
            let v = &v[DOFS * body..];
            let (velocity, spin) = (Vector3::new(v[0], v[1], v[2]), Vector3::new(v[3], v[4], v[5]));
            let SpatialBody { mass, moments } = self.bodies[body];
            let momentum = velocity * mass;
            sum += position.cross(&momentum);
            sum += Pose::new(position, orientation).turn(&Vector3::from(moments).component_mul(&spin));
        }
        sum.into()
    }

    /// Finds the contacts with a gap of at most `reach` between bodies that do not both sleep.
    fn find(&mut self, q: &[T], reach: T, asleep: &[bool], out: &mut Vec<Candidate<T>>) {
        let Self {
            contactors, interfaces, packing, broad, narrow, poses, bounds, pairs, meeting, found, ..
        } = self;
        poses.clear();
        poses.extend(contactors.iter().map(|contactor| contactor.pose(q)));
        bounds.clear();
        bounds.extend(contactors.iter().zip(&*poses).map(|(c, pose)| c.shape.bounds(pose, reach)));
        let sleeps =
            |body: Option<usize>| body.is_none_or(|body| asleep.get(body).copied().unwrap_or_default());
        // What sleeps keeps its contacts, for whoever shows them.
        let rests = |of: &Found<T>| sleeps(contactors[of.first].body) && sleeps(contactors[of.second].body);
        if asleep.is_empty() {
            found.clear()
        } else {
            found.retain(rests)
        }
        pairs.clear();
        let meet = |i: usize, j: usize| {
            let (one, other) = (&contactors[i], &contactors[j]);
            one.body != other.body
                && interfaces.between(one.group, other.group).is_some()
                && !(sleeps(one.body) && sleeps(other.body))
        };
        broad.pairs(bounds, meet, pairs);
        let known = found.len();
        for &(i, j) in &*pairs {
            let Some(interface) = interfaces.between(contactors[i].group, contactors[j].group) else {
                continue;
            };
            // The obstacle stands first.
            let (i, j) = if contactors[j].body.is_none() { (j, i) } else { (i, j) };
            meeting.clear();
            let (one, other) = (&contactors[i].shape, &contactors[j].shape);
            narrow.contacts((one, &poses[i]), (other, &poses[j]), reach, meeting);
            for &contact in &*meeting {
                let id = packing.id(i, j, &contact.meeting);
                found.push(Found { id, interface, first: i, second: j, contact });
            }
        }
        let fresh = known..found.len();
        found.sort_unstable_by_key(|of| (of.id, of.first, of.second, of.contact.meeting));
        // Digests of two contacts may agree: the later one of the list takes the next number.
        let mut last = None;
        for of in &mut *found {
            if last.is_some_and(|last| of.id <= last) {
                of.id = ContactId::new(last.map_or(0, |last: ContactId| last.number().wrapping_add(1)));
            }
            last = Some(of.id);
        }
        if fresh.len() == found.len() {
            out.extend(found.iter().map(Found::candidate));
        } else {
            out.extend(found.iter().filter(|of| !rests(of)).map(Found::candidate));
        }
    }

    fn stop(&self, id: ContactId) -> Option<&Stop<T, Relation<T>>> {
        id.number().checked_sub(STOPS).and_then(|i| self.stops.get(usize::try_from(i).ok()?))
    }

    /// q ⊕ s of one body.
    fn move_body(&self, q: &[T], s: &[T], out: &mut [T]) {
        (0..3).for_each(|k| out[k] = q[k] + s[k]);
        let turn = Vector3::new(s[3], s[4], s[5]);
        set_orientation(out, &flight::turned(&parts(q).1, &turn));
    }

    /// Leads one body on without force; with its velocity as it is where it is in joints.
    fn fly_body(&self, body: usize, time: T, q: &mut [T], v: &mut [T]) {
        (0..3).for_each(|k| q[k] += time * v[k]);
        let (mut orientation, mut spin) = (parts(q).1, Vector3::new(v[3], v[4], v[5]));
        if self.joints.joins(body) {
            orientation = flight::turned(&orientation, &(spin * time));
        } else {
            flight::fly(&Vector3::from(self.bodies[body].moments), time, &mut orientation, &mut spin);
        }
        set_orientation(q, &orientation);
        v[3..6].copy_from_slice(spin.as_slice());
    }

    fn found(&self, id: ContactId) -> Option<&Found<T>> {
        self.found.binary_search_by_key(&id, |of| of.id).ok().map(|place| &self.found[place])
    }

    /// The contact in configuration q, with the poses of its bodies.
    fn place(&self, of: &Found<T>, q: &[T]) -> (geometry::Contact<T>, [Pose<T>; 2]) {
        let (one, other) = (&self.contactors[of.first], &self.contactors[of.second]);
        let bodies = [body_pose(one.body, q), body_pose(other.body, q)];
        let (at, bt) = (bodies[0].part(&one.local), bodies[1].part(&other.local));
        let meeting: &Meeting = &of.contact.meeting;
        // Features that have no contact where the bodies are now keep that in which they were found.
        let contact = resolve(meeting, (&one.shape, &at), (&other.shape, &bt)).unwrap_or(of.contact);
        (contact, bodies)
    }
}

impl<T: Scalar> Found<T> {
    fn candidate(&self) -> Candidate<T> {
        Candidate { id: self.id, interface: self.interface, gap: self.contact.gap }
    }
}

impl<T: Scalar> Dynamics<T> for SpatialBodies<T> {
    fn coordinates(&self) -> usize {
        COORDINATES * self.bodies()
    }

    fn advance(&self, q: &[T], s: &[T], out: &mut [T]) {
        for body in 0..self.bodies() {
            let of = COORDINATES * body..COORDINATES * (body + 1);
            self.move_body(&q[of.clone()], &s[DOFS * body..], &mut out[of]);
        }
    }

    fn difference(&self, from: &[T], to: &[T], out: &mut [T]) {
        for body in 0..self.bodies() {
            let (from, to) = (&from[COORDINATES * body..], &to[COORDINATES * body..]);
            let out = &mut out[DOFS * body..];
            let turn = flight::turn_between(&parts(from).1, &parts(to).1);
            for k in 0..3 {
                out[k] = to[k] - from[k];
                out[3 + k] = turn[k];
            }
        }
    }

    fn flies(&self) -> bool {
        true
    }

    fn fly(&self, times: &[T], q: &mut [T], v: &mut [T]) {
        for body in 0..self.bodies() {
            let (q, v) = (&mut q[COORDINATES * body..], &mut v[DOFS * body..]);
            self.fly_body(body, times[DOFS * body], q, v);
        }
    }

    fn land(&self, start: &[T], s: &[T], times: &[T], q: &mut [T], v: &mut [T]) {
        if self.joints.is_empty() {
            self.fly(times, q, v);
            return;
        }
        for body in 0..self.bodies() {
            let (of_q, of_v) = (COORDINATES * body..COORDINATES * (body + 1), DOFS * body..DOFS * (body + 1));
            if self.joints.joins(body) {
                self.move_body(&start[of_q.clone()], &s[of_v], &mut q[of_q]);
            } else {
                self.fly_body(body, times[of_v.start], &mut q[of_q], &mut v[of_v]);
            }
        }
    }

    fn joints(&self) -> Option<&dyn Joints<T>> {
        (!self.joints.is_empty()).then_some(&self.joints)
    }

    fn mass(&self) -> &Symmetric<T> {
        &self.mass
    }

    fn forces(&self) -> &Forces<T> {
        &self.forces
    }

    fn fixed_torques(&self) -> Option<&Forces<T>> {
        self.torques.as_ref()
    }

    fn pull_back(&self, q: &[T], torques: &[T], force: &mut [T]) {
        for body in 0..self.bodies() {
            let of = DOFS * body + 3..DOFS * (body + 1);
            let torque = Vector3::from_column_slice(&torques[of.clone()]);
            if torque != Vector3::zeros() {
                let turned = parts(&q[COORDINATES * body..]).1.inverse() * torque;
                force[of].iter_mut().zip(turned.iter()).for_each(|(force, &torque)| *force += torque);
            }
        }
    }

    /// −F₀·x: torques along the axes of a body have none.
    fn potential(&self, q: &[T]) -> T {
        let forces = self.forces.constant_part();
        let of = |body: usize| {
            let (f, x) = (&forces[DOFS * body..], &q[COORDINATES * body..]);
            f[0] * x[0] + f[1] * x[1] + f[2] * x[2]
        };
        -(0..self.bodies()).fold(T::zero(), |sum, body| sum + of(body))
    }

    fn body_dofs(&self) -> Option<usize> {
        Some(DOFS)
    }

    fn turns(&self, dof: usize) -> bool {
        dof % DOFS >= 3
    }

    fn scales(&self, q: &[T], v: &[T]) -> Scales<T> {
        let positive = |x: T, other: T| if x > T::zero() { x } else { other };
        let larger = nalgebra::RealField::max;
        let length = positive(self.size, positive(max_abs(q), T::one()));
        let norm = |x: &[T]| Vector3::new(x[0], x[1], x[2]).norm();
        let mut speed = T::zero();
        for (body, &SpatialBody { mass, moments }) in self.bodies.iter().enumerate() {
            let (v, f) = (&v[DOFS * body..], &self.forces.constant_part()[DOFS * body..]);
            let torque = Vector3::new(f[3], f[4], f[5]).component_div(&Vector3::from(moments)).norm();
            let acceleration = norm(f) / mass + torque * length;
            let fall = nalgebra::ComplexField::sqrt(acceleration * length);
            speed = larger(speed, larger(norm(v) + norm(&v[3..]) * length, fall));
        }
        Scales { length, speed: positive(speed, length) }
    }
}

impl<T: Scalar, const D: usize> Contacts<T, D> for SpatialBodies<T> {
    fn interfaces(&self) -> usize {
        self.interfaces.count
    }

    fn candidates(&mut self, q: &[T], reach: T, out: &mut Vec<Candidate<T>>) {
        self.find(q, reach, &[], out);
        Stop::near(&self.stops, q, reach, |i| ContactId::new(STOPS + i as u64), out);
    }

    fn awake_candidates(&mut self, q: &[T], reach: T, asleep: &[bool], out: &mut Vec<Candidate<T>>) {
        self.find(q, reach, asleep, out);
        Stop::near(&self.stops, q, reach, |i| ContactId::new(STOPS + i as u64), out);
    }

    fn jacobian(&self, contact: ContactId, q: &[T], out: &mut BlockRows<T, D>) {
        out.start_row();
        if let Some(stop) = self.stop(contact) {
            let at = |row: usize, x: T| if row == 0 { stop.sign * x } else { T::zero() };
            let push = |dof: usize, x: T| out.push(dof, SVector::from_fn(|row, _| at(row, x)));
            stop.measure.row(q, &self.still, push);
            return;
        }
        let Some(of) = self.found(contact) else { return };
        let (mut contact, poses) = self.place(of, q);
        let frame = frame(&contact.normal);
        let bodies = [self.contactors[of.first].body, self.contactors[of.second].body];
        if bodies[0].is_some() && bodies[1].is_some() {
            // Both are acted on at one point, half way across the gap, so that no angular momentum comes or goes.
            let half = contact.normal * (contact.gap * lit::<T>(0.5));
            contact.arms[0] += half;
            contact.arms[1] -= half;
        }
        // Rows (N, T₁, T₂), and where D = 6 the rotations (R₁, R₂, S) about T₁, T₂ and N.
        let axis = |row: usize| frame.column(if row < 3 { row } else { (row - 2) % 3 });
        let mut push = |side: usize, sign: T| {
            let Some(body) = bodies[side] else { return };
            for k in 0..3 {
                let shifts = |row: usize| if row < 3 { sign * axis(row)[k] } else { T::zero() };
                out.push(DOFS * body + k, SVector::from_fn(|row, _| shifts(row)));
            }
            let turning = SVector::<Vector3<T>, D>::from_fn(|row, _| {
                let f = axis(row).into_owned();
                poses[side].turn_back(&if row < 3 { contact.arms[side].cross(&f) } else { f }) * sign
            });
            for k in 0..3 {
                out.push(DOFS * body + 3 + k, SVector::from_fn(|row, _| turning[row][k]));
            }
        };
        // Columns go up in every row.
        if bodies[0] < bodies[1] {
            push(0, -T::one());
            push(1, T::one());
        } else {
            push(1, T::one());
            push(0, -T::one());
        }
    }

    fn gap(&self, contact: ContactId, q: &[T]) -> T {
        if let Some(stop) = self.stop(contact) {
            return stop.gap(q);
        }
        self.found(contact).map_or_else(T::infinity_impl, |of| self.place(of, q).0.gap)
    }
}

impl<T: Scalar> Describe<T> for SpatialBodies<T> {
    fn dof_label(&self, dof: usize) -> String {
        let name = ["x", "y", "z", "turn1", "turn2", "turn3"][dof % DOFS];
        format!("{}.{name}", self.names[dof / DOFS])
    }

    fn dof_unit(&self, dof: usize) -> &'static str {
        if dof % DOFS < 3 { "m" } else { "rad" }
    }

    fn coordinate_label(&self, coordinate: usize) -> String {
        let name = ["x", "y", "z", "qw", "qx", "qy", "qz"][coordinate % COORDINATES];
        format!("{}.{name}", self.names[coordinate / COORDINATES])
    }

    fn coordinate_of(&self, dof: usize) -> usize {
        COORDINATES * (dof / DOFS) + dof % DOFS
    }

    fn solids(&self) -> Vec<Solid> {
        self.pictures()
    }

    fn body_pose(&self, body: usize, q: &[T]) -> ([f64; 3], [f64; 4]) {
        self.pose_of(body, q)
    }

    fn body_velocity(&self, body: usize, q: &[T], v: &[T]) -> ([f64; 3], [f64; 3]) {
        self.velocity_of(body, q, v)
    }

    fn contact_place(&self, contact: ContactId, q: &[T]) -> Option<ContactPlace> {
        self.place_of(contact, q)
    }

    fn contact_label(&self, contact: ContactId) -> String {
        if let Some(stop) = self.stop(contact) {
            return stop.label.clone();
        }
        let Some(of) = self.found(contact) else { return contact.number().to_string() };
        let (one, other) = (&self.contactors[of.second], &self.contactors[of.first]);
        let point = feature(&of.contact.meeting);
        format!("{}|{}{point}", one.label, other.label)
    }
}

/// The features that meet, where a pair of shapes can have several contacts.
fn feature(meeting: &Meeting) -> String {
    use geometry::Feature::{Edge, Face, Mantle, Patch, Rim, Vertex};
    let name = |feature: geometry::Feature| match feature {
        Vertex(i) => format!("v{i}"),
        Edge(i) => format!("e{i}"),
        Face(i) => format!("f{i}"),
        Rim(i) => format!("r{i}"),
        Mantle(i) => format!("m{i}"),
        Patch(i) => format!("p{i}"),
    };
    format!(" {}-{}", name(meeting.second), name(meeting.first))
}
