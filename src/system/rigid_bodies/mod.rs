//! Planar rigid bodies (x, y, angle) with points and discs against fixed half-planes and each other.

mod builder;
mod sweep;

use nalgebra::{SVector, Vector2};

pub use builder::{Body, BodyId, ContactorId, GroupId, RigidBodiesBuilder};

use super::{Forces, MechanicalSystem, Scales};
use crate::contact::{Candidate, ContactId};
use crate::linalg::{BlockRows, Symmetric, max_abs};
use crate::scalar::Scalar;
use sweep::Sweep;

/// A disc fixed to a body; a contact point is a disc of radius 0. Other shapes join here, and answer where their
/// boundary is nearest to a half-plane or to another shape.
#[derive(Debug, Clone)]
struct Contactor<T> {
    label: String,
    body: usize,
    /// Centre in the frame of the body, from its centre of mass.
    centre: Vector2<T>,
    radius: T,
    group: usize,
}

impl<T: Scalar> Contactor<T> {
    /// Lever arm from the centre of mass of the body to the centre of the contactor, in the fixed frame.
    #[inline]
    fn lever(&self, q: &[T]) -> Vector2<T> {
        let c = self.centre;
        if c.x == T::zero() && c.y == T::zero() {
            return c;
        }
        let (sin, cos) = nalgebra::ComplexField::sin_cos(q[3 * self.body + 2]);
        Vector2::new(cos * c.x - sin * c.y, sin * c.x + cos * c.y)
    }

    /// Centre in the fixed frame.
    #[inline]
    fn position(&self, q: &[T]) -> Vector2<T> {
        let i = 3 * self.body;
        Vector2::new(q[i], q[i + 1]) + self.lever(q)
    }
}

/// The fixed half-plane n·x ≤ d; bodies live where n·x > d.
#[derive(Debug, Clone)]
struct HalfPlane<T> {
    label: String,
    normal: Vector2<T>,
    distance: T,
    group: usize,
}

/// Interfaces between groups, a symmetric table.
#[derive(Debug)]
struct Interfaces {
    groups: usize,
    table: Vec<Option<usize>>,
    count: usize,
}

impl Interfaces {
    fn new(groups: usize, pairs: &[(usize, usize)]) -> Self {
        let mut table = vec![None; groups * groups];
        for (interface, &(a, b)) in pairs.iter().enumerate() {
            table[a * groups + b] = Some(interface);
            table[b * groups + a] = Some(interface);
        }
        Self { groups, table, count: pairs.len() }
    }

    #[inline]
    fn between(&self, a: usize, b: usize) -> Option<usize> {
        self.table[a * self.groups + b]
    }
}

/// What a [`ContactId`] names.
enum Pair {
    /// Contactor against half-plane.
    Plane(usize, usize),
    /// Contactor against contactor.
    Discs(usize, usize),
}

/// Set in the id of a disc pair, so that the contacts with half-planes come first.
const DISC_PAIR: u64 = 1 << 63;

impl Pair {
    fn id(&self) -> ContactId {
        match *self {
            Self::Plane(contactor, plane) => ContactId((contactor as u64) << 32 | plane as u64),
            Self::Discs(a, b) => ContactId(DISC_PAIR | (a as u64) << 32 | b as u64),
        }
    }

    fn of(id: ContactId) -> Self {
        let (high, low) = (((id.0 & !DISC_PAIR) >> 32) as usize, (id.0 & 0xffff_ffff) as usize);
        if id.0 & DISC_PAIR == 0 { Self::Plane(high, low) } else { Self::Discs(high, low) }
    }
}

/// Planar rigid bodies; body i owns the coordinates q[3i..3i+3] = (x, y, angle), x and y those of its centre of
/// mass. M is diagonal, C and K are absent.
///
/// Local frames are (n, t) with t = (n_y, −n_x): above a floor with n = (0, 1) the tangent is +x.
#[derive(Debug)]
pub struct RigidBodies<T: Scalar> {
    mass: Symmetric<T>,
    forces: Forces<T>,
    labels: Vec<String>,
    contactors: Vec<Contactor<T>>,
    planes: Vec<HalfPlane<T>>,
    interfaces: Interfaces,
    sweep: Sweep<T>,
}

impl<T: Scalar> RigidBodies<T> {
    /// Starts a scene.
    pub fn builder() -> RigidBodiesBuilder<T> {
        RigidBodiesBuilder::default()
    }

    fn plane_candidates(&self, q: &[T], reach: T, out: &mut Vec<Candidate<T>>) {
        for (i, contactor) in self.contactors.iter().enumerate() {
            let mut centre = None;
            for (j, plane) in self.planes.iter().enumerate() {
                let Some(interface) = self.interfaces.between(contactor.group, plane.group) else { continue };
                let centre = centre.get_or_insert_with(|| contactor.position(q));
                let gap = plane.normal.dot(centre) - plane.distance - contactor.radius;
                if !(gap > reach) {
                    out.push(Candidate { id: Pair::Plane(i, j).id(), interface, gap });
                }
            }
        }
    }

    fn disc_candidates(&mut self, q: &[T], reach: T, out: &mut Vec<Candidate<T>>) {
        if self.sweep.is_empty() {
            return;
        }
        let Self { contactors, interfaces, sweep, .. } = self;
        sweep.update(|i| (contactors[i].position(q), contactors[i].radius));
        sweep.for_each_near_pair(reach, |i, j, (a, b)| {
            let (one, other) = (&contactors[i], &contactors[j]);
            let Some(interface) = interfaces.between(one.group, other.group) else { return };
            let gap = (a - b).norm() - one.radius - other.radius;
            if one.body != other.body && !(gap > reach) {
                out.push(Candidate { id: Pair::Discs(i, j).id(), interface, gap });
            }
        });
    }
}

/// The columns of one body in H: u = frame·(v + ω × arm), for a contact at `arm` from its centre of mass.
#[inline]
fn push_body<T: Scalar, const D: usize>(
    out: &mut BlockRows<T, D>,
    body: usize,
    sign: T,
    normal: &Vector2<T>,
    arm: &Vector2<T>,
) {
    const { assert!(D <= 2, "planar bodies have contacts of dimension 1 or 2") };
    let tangent = Vector2::new(normal.y, -normal.x);
    let spin = Vector2::new(-arm.y, arm.x);
    let column = |direction: &Vector2<T>| {
        SVector::<T, D>::from_fn(|row, _| sign * if row == 0 { normal } else { &tangent }.dot(direction))
    };
    out.push(3 * body, column(&Vector2::x()));
    out.push(3 * body + 1, column(&Vector2::y()));
    out.push(3 * body + 2, column(&spin));
}

impl<T: Scalar, const D: usize> MechanicalSystem<T, D> for RigidBodies<T> {
    fn dofs(&self) -> usize {
        self.mass.size()
    }

    fn mass(&self) -> &Symmetric<T> {
        &self.mass
    }

    fn forces(&self) -> &Forces<T> {
        &self.forces
    }

    fn interfaces(&self) -> usize {
        self.interfaces.count
    }

    fn candidates(&mut self, q: &[T], reach: T, out: &mut Vec<Candidate<T>>) {
        self.plane_candidates(q, reach, out);
        self.disc_candidates(q, reach, out);
    }

    fn jacobian(&self, contact: ContactId, q: &[T], out: &mut BlockRows<T, D>) {
        out.start_row();
        match Pair::of(contact) {
            Pair::Plane(i, j) => {
                let (contactor, plane) = (&self.contactors[i], &self.planes[j]);
                let arm = contactor.lever(q) - plane.normal * contactor.radius;
                push_body(out, contactor.body, T::one(), &plane.normal, &arm);
            }
            Pair::Discs(i, j) => {
                let (one, other) = (&self.contactors[i], &self.contactors[j]);
                let between = one.position(q) - other.position(q);
                let distance = between.norm();
                // Concentric discs have no normal; up is as good as any and keeps the step defined.
                let normal = if distance > T::zero() { between / distance } else { Vector2::y() };
                let arm = one.lever(q) - normal * one.radius;
                push_body(out, one.body, T::one(), &normal, &arm);
                let arm = other.lever(q) + normal * other.radius;
                push_body(out, other.body, -T::one(), &normal, &arm);
            }
        }
    }

    fn scales(&self, q: &[T], v: &[T]) -> Scales<T> {
        let positive = |x: T, other: T| if x > T::zero() { x } else { other };
        let larger = nalgebra::RealField::max;
        let size = self.contactors.iter().fold(T::zero(), |l, c| larger(l, c.centre.norm() + c.radius));
        let length = positive(size, positive(max_abs(q), T::one()));
        let mut weight = self.forces.constant_part().to_vec();
        if let Symmetric::Diagonal(mass) = &self.mass {
            weight.iter_mut().zip(mass).for_each(|(f, &m)| *f /= m);
        }
        let mut speed = T::zero();
        for (v, a) in v.chunks_exact(3).zip(weight.chunks_exact(3)) {
            let of = |x: &[T]| Vector2::new(x[0], x[1]).norm() + nalgebra::ComplexField::abs(x[2]) * length;
            let fall = nalgebra::ComplexField::sqrt(of(a) * length);
            speed = larger(speed, larger(of(v), fall));
        }
        Scales { length, speed: positive(speed, length) }
    }

    fn contact_label(&self, contact: ContactId) -> String {
        match Pair::of(contact) {
            Pair::Plane(i, j) => format!("{}|{}", self.contactors[i].label, self.planes[j].label),
            Pair::Discs(i, j) => format!("{}|{}", self.contactors[i].label, self.contactors[j].label),
        }
    }

    fn dof_label(&self, dof: usize) -> String {
        format!("{}.{}", self.labels[dof / 3], ["x", "y", "angle"][dof % 3])
    }

    fn dof_unit(&self, dof: usize) -> &'static str {
        if dof % 3 == 2 { "rad" } else { "m" }
    }
}
