//! Planar rigid bodies (x, y, angle) of points, discs, arcs and convex polygons against half-planes, fixed shapes and each
//! other, held together by joints.

mod body;
mod builder;
mod curves;
mod identity;
mod joint;
mod measure;
mod moved;
mod narrow;
mod polygon;
mod relative;
mod round;
mod seams;
mod shape;
mod side;
mod solids;
mod sweep;
mod swept;

use nalgebra::{SVector, Vector2};

pub(super) use body::check;
pub use body::{Body, BodyId};
pub use builder::{ContactorId, RigidBodiesBuilder};
pub use curves::RoundSide;
pub use polygon::polygon_body;
pub use relative::Relative;

use super::element::{Coordinate, Stop};
use super::interfaces::Interfaces;
use super::{ContactPlace, Contacts, Describe, Dynamics, Forces, Joints, Prescribed, Scales, Solid};
use crate::contact::{Candidate, ContactId};
use crate::linalg::{BlockRows, Symmetric, max_abs};
use crate::scalar::{Scalar, to_f64};
use identity::{Features, Pair};
use joint::JointSet;
use measure::Measure;
use seams::Touch;
use shape::{Contactor, GROUND, HalfPlane, Pose};
use sweep::Sweep;
use swept::Crossings;

/// Planar rigid bodies; body i owns the coordinates q[3i..3i+3] = (x, y, angle), x and y those of its centre of
/// mass. M is diagonal; K and C are too, or absent where no body has a spring or a damper.
///
/// Local frames are (n, t) with t = (n_y, −n_x): above a floor with n = (0, 1) the tangent is +x.
#[derive(Debug)]
pub struct RigidBodies<T: Scalar> {
    mass: Symmetric<T>,
    stiffness: Option<Symmetric<T>>,
    damping: Option<Symmetric<T>>,
    forces: Forces<T>,
    labels: Vec<String>,
    contactors: Vec<Contactor<T>>,
    planes: Vec<HalfPlane<T>>,
    interfaces: Interfaces,
    sweep: Sweep<T>,
    /// Number of polygons, and buffers of the search for ghosts at seams.
    polygons: usize,
    touches: Vec<Touch<T>>,
    ghosts: Vec<usize>,
    crossings: Crossings<T>,
    joints: JointSet<T>,
    stops: Vec<Stop<T, Measure<T>>>,
    /// Bodies that move under forces, the first ones, and how the others move.
    free: usize,
    prescribed: Option<Prescribed<T>>,
    /// No motion.
    still: Vec<T>,
}

impl<T: Scalar> RigidBodies<T> {
    /// Starts a scene.
    pub fn builder() -> RigidBodiesBuilder<T> {
        RigidBodiesBuilder::default()
    }

    /// Candidates with half-planes of the bodies that do not sleep; `asleep` is empty where none does.
    fn plane_candidates(&self, q: &[T], reach: T, asleep: &[bool], out: &mut Vec<Candidate<T>>) {
        for (i, contactor) in self.contactors.iter().enumerate() {
            if asleep.get(contactor.body) == Some(&true) || !self.is_free(contactor.body) {
                continue;
            }
            let mut centre = None;
            for (j, plane) in self.planes.iter().enumerate() {
                let Some(interface) = self.interfaces.between(contactor.group, plane.group) else { continue };
                let centre = centre.get_or_insert_with(|| contactor.position(q));
                let (normal, distance) = plane.placed(q);
                let gap = normal.dot(centre) - distance - contactor.radius;
                if gap > reach {
                    continue;
                }
                match contactor.polygon() {
                    None => {
                        if contactor.is_hollow() || !contactor.shows(&-normal, q) {
                            continue;
                        }
                        let id = Pair::Plane { disc: i, plane: j }.id();
                        out.push(Candidate { id, interface, gap });
                    }
                    Some(polygon) => {
                        let pose = Pose::of(contactor.body, q);
                        for (vertex, x) in polygon.vertices.iter().enumerate() {
                            let gap = normal.dot(&pose.place(x)) - distance;
                            if !(gap > reach) {
                                let id = Pair::Corner { polygon: i, plane: j, vertex }.id();
                                out.push(Candidate { id, interface, gap });
                            }
                        }
                    }
                }
            }
        }
    }

    /// Candidates between bodies of which one is awake.
    fn pair_candidates(&mut self, q: &[T], reach: T, asleep: &[bool], out: &mut Vec<Candidate<T>>) {
        if self.sweep.is_empty() {
            return;
        }
        let first = out.len();
        let Self { contactors, interfaces, sweep, free: bodies, .. } = self;
        sweep.update(|i| (contactors[i].position(q), contactors[i].radius));
        sweep.for_each_near_pair(reach, |i, j, (x, y)| {
            let (one, other) = (&contactors[i], &contactors[j]);
            let sleeps = |body: usize| body == GROUND || asleep.get(body) == Some(&true);
            let free = |body: usize| body < *bodies;
            if one.body == other.body || sleeps(one.body) && sleeps(other.body) {
                return;
            }
            if !free(one.body) && !free(other.body) {
                return;
            }
            let Some(interface) = interfaces.between(one.group, other.group) else { return };
            let circles = (x - y).norm() - one.radius - other.radius;
            if circles > reach {
                return;
            }
            let mut meet = |pair: Pair, gap: T| {
                if !(gap > reach) {
                    out.push(Candidate { id: pair.id(), interface, gap });
                }
            };
            if one.is_round() && other.is_round() || one.is_hollow() || other.is_hollow() {
                round::contacts((i, one), (j, other), (x, y), q, meet);
                return;
            }
            let poses = || (Pose::of(one.body, q), Pose::of(other.body, q));
            match (one.polygon(), other.polygon()) {
                (None, None) => {}
                (Some(a), Some(b)) => {
                    let (at, bt) = poses();
                    let size = one.radius + other.radius;
                    narrow::polygons((a, &at), (b, &bt), size, reach, |features, gap| {
                        meet(Pair::Features { a: i, b: j, features }, gap);
                    });
                }
                (Some(a), None) => {
                    let (features, gap) = narrow::disc((a, &poses().0), &y, other.radius);
                    if round::shows((a, &poses().0), (other, &y), features, q) {
                        meet(Pair::Features { a: i, b: j, features }, gap);
                    }
                }
                (None, Some(b)) => {
                    let (features, gap) = narrow::disc((b, &poses().1), &x, one.radius);
                    if round::shows((b, &poses().1), (one, &x), features, q) {
                        meet(Pair::Features { a: j, b: i, features }, gap);
                    }
                }
            }
        });
        self.drop_ghosts(q, first, out);
    }

    /// Both sides of a contact between two bodies: (body, arm) each, and the normal from the second to the first.
    fn sides(&self, pair: Pair, q: &[T]) -> ([(usize, Vector2<T>); 2], Vector2<T>) {
        let pose = |contactor: usize| Pose::of(self.contactors[contactor].body, q);
        let vertex = |contactor: usize, vertex: usize| -> Vector2<T> {
            let polygon = self.contactors[contactor].polygon();
            polygon.map_or_else(Vector2::zeros, |polygon| polygon.vertices[vertex])
        };
        let normal = |contactor: usize, edge: usize| -> Vector2<T> {
            let polygon = self.contactors[contactor].polygon();
            pose(contactor).turn(&polygon.map_or_else(Vector2::y, |polygon| polygon.normals[edge]))
        };
        // A contact at `point` (fixed frame) of the bodies of two contactors.
        let at = |a: usize, b: usize, arm: Vector2<T>, normal: Vector2<T>| {
            let (one, other) = (self.contactors[a].body, self.contactors[b].body);
            let offset = Pose::of(one, q).origin - Pose::of(other, q).origin;
            ([(one, arm), (other, arm + offset)], normal)
        };
        match pair {
            Pair::Discs(i, j) => {
                let (one, other) = (&self.contactors[i], &self.contactors[j]);
                let between = direction(one.position(q) - other.position(q), Vector2::y);
                let normal = between * round::sign(one, other);
                let arms =
                    (one.lever(q) - normal * one.curvature(), other.lever(q) + normal * other.curvature());
                ([(one.body, arms.0), (other.body, arms.1)], normal)
            }
            Pair::Features { a, b, features: Features::VertexEdge(v, edge) } => {
                at(a, b, pose(a).turn(&vertex(a, v)), normal(b, edge))
            }
            Pair::Features { a, b, features: Features::EdgeVertex(v, edge) } => {
                at(b, a, pose(b).turn(&vertex(b, v)), normal(a, edge))
            }
            Pair::Features { a, b, features: Features::EdgeDisc(edge) } => {
                let normal = normal(a, edge);
                let disc = &self.contactors[b];
                at(b, a, disc.lever(q) - normal * disc.radius, normal)
            }
            Pair::Features { a, b, features: Features::VertexDisc(v) } => {
                let disc = &self.contactors[b];
                let between = disc.position(q) - pose(a).place(&vertex(a, v));
                let outside = if disc.is_hollow() { -T::one() } else { T::one() };
                let normal = direction(between, || normal(a, v)) * outside;
                at(b, a, disc.lever(q) - normal * disc.curvature(), normal)
            }
            Pair::Plane { .. } | Pair::Corner { .. } | Pair::Stop(_) => {
                unreachable!("half-planes and stops are no bodies")
            }
        }
    }
}

/// x/‖x‖; concentric shapes have no normal, and any keeps the step defined.
fn direction<T: Scalar>(x: Vector2<T>, otherwise: impl FnOnce() -> Vector2<T>) -> Vector2<T> {
    let length = x.norm();
    if length > T::zero() { x / length } else { otherwise() }
}

/// The columns of one body in H: u = frame·(v + ω × arm), for a contact at `arm` from its centre of mass; where D = 3 the
/// third row is the rotation ω. What is fixed has none.
#[inline]
fn push_body<T: Scalar, const D: usize>(
    out: &mut BlockRows<T, D>,
    body: usize,
    sign: T,
    normal: &Vector2<T>,
    arm: &Vector2<T>,
) {
    const { assert!(D <= 3, "planar bodies have contacts of dimension 1, 2, or 3 where they roll") };
    if body == GROUND {
        return;
    }
    let tangent = Vector2::new(normal.y, -normal.x);
    let spin = Vector2::new(-arm.y, arm.x);
    let column = |direction: &Vector2<T>, turns: T| {
        SVector::<T, D>::from_fn(|row, _| {
            sign * match row {
                0 => normal.dot(direction),
                1 => tangent.dot(direction),
                _ => turns,
            }
        })
    };
    out.push(3 * body, column(&Vector2::x(), T::zero()));
    out.push(3 * body + 1, column(&Vector2::y(), T::zero()));
    out.push(3 * body + 2, column(&spin, T::one()));
}

impl<T: Scalar> Dynamics<T> for RigidBodies<T> {
    fn mass(&self) -> &Symmetric<T> {
        &self.mass
    }

    fn stiffness(&self) -> Option<&Symmetric<T>> {
        self.stiffness.as_ref()
    }

    fn damping(&self) -> Option<&Symmetric<T>> {
        self.damping.as_ref()
    }

    fn forces(&self) -> &Forces<T> {
        &self.forces
    }

    fn body_dofs(&self) -> Option<usize> {
        Some(3)
    }

    fn joints(&self) -> Option<&dyn Joints<T>> {
        (!self.joints.is_empty()).then_some(&self.joints)
    }

    fn prescribed(&self) -> Option<&Prescribed<T>> {
        self.prescribed.as_ref()
    }

    fn turns(&self, dof: usize) -> bool {
        dof % 3 == 2
    }

    fn scales(&self, q: &[T], v: &[T]) -> Scales<T> {
        let positive = |x: T, other: T| if x > T::zero() { x } else { other };
        let larger = nalgebra::RealField::max;
        let moving = self.contactors.iter().filter(|contactor| contactor.body != GROUND);
        let size = moving.fold(T::zero(), |l, c| larger(l, c.centre.norm() + c.radius));
        let length = positive(size, positive(max_abs(q), T::one()));
        let mut weight = self.forces.constant_part().to_vec();
        if let Symmetric::Diagonal(mass) = &self.mass {
            let massive = weight.iter_mut().zip(mass).filter(|&(_, &m)| m > T::zero());
            massive.for_each(|(f, &m)| *f /= m);
        }
        let mut speed = T::zero();
        for (v, a) in v.chunks_exact(3).zip(weight.chunks_exact(3)) {
            let of = |x: &[T]| Vector2::new(x[0], x[1]).norm() + nalgebra::ComplexField::abs(x[2]) * length;
            let fall = nalgebra::ComplexField::sqrt(of(a) * length);
            speed = larger(speed, larger(of(v), fall));
        }
        Scales { length, speed: positive(speed, length) }
    }
}

impl<T: Scalar, const D: usize> Contacts<T, D> for RigidBodies<T> {
    fn interfaces(&self) -> usize {
        self.interfaces.count
    }

    fn candidates(&mut self, q: &[T], reach: T, out: &mut Vec<Candidate<T>>) {
        Stop::near(&self.stops, q, reach, |i| Pair::Stop(i).id(), out);
        self.plane_candidates(q, reach, &[], out);
        self.pair_candidates(q, reach, &[], out);
    }

    fn awake_candidates(&mut self, q: &[T], reach: T, asleep: &[bool], out: &mut Vec<Candidate<T>>) {
        Stop::near(&self.stops, q, reach, |i| Pair::Stop(i).id(), out);
        self.plane_candidates(q, reach, asleep, out);
        self.pair_candidates(q, reach, asleep, out);
    }

    fn swept_candidates(
        &mut self,
        q: &[T],
        path: (T, &[T]),
        asleep: &[bool],
        out: &mut Vec<Candidate<T>>,
        times: &mut Vec<(ContactId, T)>,
    ) {
        self.cross(q, path, asleep, out, times);
    }

    fn jacobian(&self, contact: ContactId, q: &[T], out: &mut BlockRows<T, D>) {
        out.start_row();
        match Pair::of(contact) {
            Pair::Plane { disc, plane } => {
                let (contactor, plane) = (&self.contactors[disc], &self.planes[plane]);
                let normal = plane.placed(q).0;
                let arm = contactor.lever(q) - normal * contactor.radius;
                push_body(out, contactor.body, T::one(), &normal, &arm);
                self.push_plane(out, plane.body, &normal, (contactor.body, &arm), q);
            }
            Pair::Corner { polygon, plane, vertex } => {
                let (contactor, plane) = (&self.contactors[polygon], &self.planes[plane]);
                let Some(polygon) = contactor.polygon() else { return };
                let normal = plane.placed(q).0;
                let arm = Pose::of(contactor.body, q).turn(&polygon.vertices[vertex]);
                push_body(out, contactor.body, T::one(), &normal, &arm);
                self.push_plane(out, plane.body, &normal, (contactor.body, &arm), q);
            }
            Pair::Stop(i) => {
                let stop = &self.stops[i];
                let at = |row: usize, x: T| if row == 0 { stop.sign * x } else { T::zero() };
                stop.measure
                    .row(q, &self.still, |dof, x| out.push(dof, SVector::from_fn(|row, _| at(row, x))));
            }
            pair => {
                let ([(one, arm), (other, other_arm)], normal) = self.sides(pair, q);
                push_body(out, one, T::one(), &normal, &arm);
                push_body(out, other, -T::one(), &normal, &other_arm);
            }
        }
    }

    fn gap(&self, contact: ContactId, q: &[T]) -> T {
        let place = |contactor: usize| Pose::of(self.contactors[contactor].body, q);
        let outline = |contactor: usize| self.contactors[contactor].polygon().map(|x| (x, place(contactor)));
        let on_edge = |a: usize, vertex: usize, b: usize, edge: usize| {
            let (Some((one, at)), Some((other, bt))) = (outline(a), outline(b)) else { return T::zero() };
            narrow::vertex_gap(vertex, (one, &at), edge, (other, &bt))
        };
        match Pair::of(contact) {
            Pair::Plane { disc, plane } => {
                let (contactor, plane) = (&self.contactors[disc], &self.planes[plane]);
                let (normal, distance) = plane.placed(q);
                normal.dot(&contactor.position(q)) - distance - contactor.radius
            }
            Pair::Corner { polygon, plane, vertex } => {
                let (Some((polygon, at)), plane) = (outline(polygon), &self.planes[plane]) else {
                    return T::zero();
                };
                let (normal, distance) = plane.placed(q);
                normal.dot(&at.place(&polygon.vertices[vertex])) - distance
            }
            Pair::Stop(i) => self.stops[i].gap(q),
            Pair::Discs(i, j) => {
                let (one, other) = (&self.contactors[i], &self.contactors[j]);
                round::gap(one, other, &(one.position(q) - other.position(q)))
            }
            Pair::Features { a, b, features: Features::VertexEdge(vertex, edge) } => {
                on_edge(a, vertex, b, edge)
            }
            Pair::Features { a, b, features: Features::EdgeVertex(vertex, edge) } => {
                on_edge(b, vertex, a, edge)
            }
            Pair::Features { a, b, features: Features::EdgeDisc(i) | Features::VertexDisc(i) } => {
                let (Some((polygon, at)), disc) = (outline(a), &self.contactors[b]) else { return T::zero() };
                let apart = disc.position(q) - at.place(&polygon.vertices[i]);
                let on_vertex =
                    matches!(Pair::of(contact), Pair::Features { features: Features::VertexDisc(_), .. });
                let distance = match on_vertex {
                    true if disc.is_hollow() => -apart.norm(),
                    true => apart.norm(),
                    false => at.turn(&polygon.normals[i]).dot(&apart),
                };
                distance - disc.curvature()
            }
        }
    }
}

impl<T: Scalar> Describe<T> for RigidBodies<T> {
    fn outlines(&self, q: &[T], sides: usize) -> Vec<Vec<[T; 2]>> {
        let outline = |contactor: &Contactor<T>| contactor.placed(sides, q);
        self.contactors.iter().map(outline).collect()
    }

    fn solids(&self) -> Vec<Solid> {
        self.pictures()
    }

    fn body_pose(&self, body: usize, q: &[T]) -> ([f64; 3], [f64; 4]) {
        self.pose_of(body, q)
    }

    fn body_velocity(&self, body: usize, _q: &[T], v: &[T]) -> ([f64; 3], [f64; 3]) {
        let [x, y, spin] = [0, 1, 2].map(|k| to_f64(v[3 * body + k]));
        ([x, y, 0.0], [0.0, 0.0, spin])
    }

    fn contact_place(&self, contact: ContactId, q: &[T]) -> Option<ContactPlace> {
        self.place_of(contact, q)
    }

    fn dof_label(&self, dof: usize) -> String {
        format!("{}.{}", self.labels[dof / 3], ["x", "y", "angle"][dof % 3])
    }

    fn dof_unit(&self, dof: usize) -> &'static str {
        if dof % 3 == 2 { "rad" } else { "m" }
    }

    fn contact_label(&self, contact: ContactId) -> String {
        let label = |contactor: usize| &self.contactors[contactor].label;
        match Pair::of(contact) {
            Pair::Plane { disc, plane } => format!("{}|{}", label(disc), self.planes[plane].label),
            Pair::Corner { polygon, plane, vertex } => {
                format!("{}/{vertex}|{}", label(polygon), self.planes[plane].label)
            }
            Pair::Stop(i) => self.stops[i].label.clone(),
            Pair::Discs(i, j) => format!("{}|{}", label(i), label(j)),
            Pair::Features { a, b, features } => match features {
                Features::VertexEdge(vertex, edge) => format!("{}/{vertex}|{}/{edge}", label(a), label(b)),
                Features::EdgeVertex(vertex, edge) => format!("{}/{vertex}|{}/{edge}", label(b), label(a)),
                Features::EdgeDisc(edge) => format!("{}|{}/{edge}", label(b), label(a)),
                Features::VertexDisc(vertex) => format!("{}|{}/{vertex}", label(b), label(a)),
            },
        }
    }
}
