//! Bodies as pictures show them.

use nalgebra::Vector2;

use super::RigidBodies;
use super::identity::Pair;
use super::shape::{Contactor, GROUND, HalfPlane, Pose};
use crate::contact::ContactId;
use crate::scalar::{Scalar, to_f64};
use crate::system::{ContactPlace, Solid, Surface};

/// Sides of a circle.
const SIDES: usize = 72;

fn flat<T: Scalar>(x: &Vector2<T>) -> [f64; 3] {
    [to_f64(x.x), to_f64(x.y), 0.0]
}

/// The body that owns something, `None` for the ground.
fn owner(body: usize) -> Option<usize> {
    (body != GROUND).then_some(body)
}

/// A shape: a face where it has an inside, else its line; of a disc also a radius, which shows how it turns.
fn of_contactor<T: Scalar>(contactor: &Contactor<T>) -> Solid {
    let mut points: Vec<[f64; 3]> = contactor.points(SIDES).iter().map(flat).collect();
    let (mut faces, mut lines) = (Vec::new(), Vec::new());
    if points.len() > 1 {
        let around = 0..points.len() as u32 - 1;
        if contactor.is_hollow() || contactor.window.is_some() {
            lines.push((0..points.len() as u32).collect());
        } else {
            points.pop();
            faces.push(around.collect());
        }
        if contactor.is_round() && !contactor.is_hollow() && contactor.window.is_none() {
            lines.push(vec![points.len() as u32, 0]);
            points.push(flat(&contactor.centre));
        }
    }
    let surface = Surface { points, faces, lines, round: false };
    Solid { name: contactor.label.clone(), body: owner(contactor.body), surface, endless: false }
}

/// One metre of the edge of a half-plane, about the point nearest to the origin.
fn of_half_plane<T: Scalar>(plane: &HalfPlane<T>) -> Solid {
    let (normal, foot) = (flat(&plane.normal), flat(&(plane.normal * plane.distance)));
    let along = [normal[1], -normal[0]];
    let at = |x: f64| [foot[0] + x * along[0], foot[1] + x * along[1], 0.0];
    let surface = Surface { points: vec![at(-0.5), at(0.5)], lines: vec![vec![0, 1]], ..Surface::default() };
    Solid { name: plane.label.clone(), body: owner(plane.body), surface, endless: true }
}

impl<T: Scalar> RigidBodies<T> {
    /// The shapes, the half-planes and the joints; bodies that have neither are points.
    pub(super) fn pictures(&self) -> Vec<Solid> {
        let mut bare = vec![true; self.labels.len()];
        let bodies = self.contactors.iter().map(|c| c.body).chain(self.planes.iter().map(|plane| plane.body));
        bodies.filter(|&body| body != GROUND).for_each(|body| bare[body] = false);
        let mut all: Vec<Solid> = self.contactors.iter().map(of_contactor).collect();
        all.extend(self.planes.iter().map(of_half_plane));
        let solid = |name: &str, body: usize, surface| {
            let name = name.into();
            Solid { name, body: Some(body), surface, endless: false }
        };
        for (joint, body, point) in self.joints.held_points() {
            // Of a body without a shape the joints show where it is: they are tied to its centre.
            let mut surface = Surface { points: vec![flat(&point)], ..Surface::default() };
            if bare[body] {
                surface.points.push([0.0; 3]);
                surface.lines.push(vec![1, 0]);
            }
            all.push(solid(joint, body, surface));
        }
        let centres = bare.iter().enumerate().filter(|&(_, &bare)| bare);
        all.extend(centres.map(|(body, _)| {
            let surface = Surface { points: vec![[0.0; 3]], ..Surface::default() };
            solid(&self.labels[body], body, surface)
        }));
        all
    }

    pub(super) fn pose_of(&self, body: usize, q: &[T]) -> ([f64; 3], [f64; 4]) {
        let [x, y, angle] = [0, 1, 2].map(|i| to_f64(q[3 * body + i]));
        let (sin, cos) = (0.5 * angle).sin_cos();
        ([x, y, 0.0], [cos, 0.0, 0.0, sin])
    }

    /// Where a contact is, on the first of its shapes; limits of joints are nowhere.
    pub(super) fn place_of(&self, contact: ContactId, q: &[T]) -> Option<ContactPlace> {
        let (body, arm, normal) = match Pair::of(contact) {
            Pair::Plane { disc, plane } => {
                let (contactor, normal) = (&self.contactors[disc], self.planes[plane].placed(q).0);
                (contactor.body, contactor.lever(q) - normal * contactor.radius, normal)
            }
            Pair::Corner { polygon, plane, vertex } => {
                let (contactor, normal) = (&self.contactors[polygon], self.planes[plane].placed(q).0);
                let vertex = contactor.polygon()?.vertices[vertex];
                (contactor.body, Pose::of(contactor.body, q).turn(&vertex), normal)
            }
            Pair::Stop(_) => return None,
            pair @ (Pair::Discs(..) | Pair::Features { .. }) => {
                let ([(body, arm), _], normal) = self.sides(pair, q);
                (body, arm, normal)
            }
        };
        let point = flat(&(Pose::of(body, q).origin + arm));
        let [x, y, _] = flat(&normal);
        // A third component is a moment.
        Some(ContactPlace { point, axes: [[x, y, 0.0], [y, -x, 0.0], [0.0; 3]] })
    }
}
