//! Bodies as pictures show them.

use nalgebra::Vector3;

use super::SpatialBodies;
use super::shape::Contactor;
use crate::contact::ContactId;
use crate::geometry::{Kind, Pose, Shape, frame};
use crate::scalar::{Scalar, lit, to_f64};
use crate::system::{ContactPlace, Solid, Surface};

/// Meridians and parallels of balls and of the ends of capsules.
const MERIDIANS: usize = 24;
const PARALLELS: usize = 12;

fn plain<T: Scalar>(x: &Vector3<T>) -> [f64; 3] {
    [to_f64(x.x), to_f64(x.y), to_f64(x.z)]
}

/// A ball of `radius`, its halves moved apart along z by `half` each.
fn globe(radius: f64, half: f64) -> Surface {
    use std::f64::consts::{PI, TAU};
    let mut points = vec![[0.0, 0.0, radius + half]];
    // The equator stands twice where the halves are apart.
    let mut rings = Vec::new();
    for k in 1..PARALLELS {
        let angle = PI * k as f64 / PARALLELS as f64;
        let shifts: &[f64] = match (2 * k).cmp(&PARALLELS) {
            std::cmp::Ordering::Less => &[1.0],
            std::cmp::Ordering::Greater => &[-1.0],
            std::cmp::Ordering::Equal if half > 0.0 => &[1.0, -1.0],
            std::cmp::Ordering::Equal => &[0.0],
        };
        rings.extend(shifts.iter().map(|shift| (angle, shift * half)));
    }
    for &(angle, shift) in &rings {
        let (sin, cos) = angle.sin_cos();
        points.extend((0..MERIDIANS).map(|m| {
            let (y, x) = (TAU * m as f64 / MERIDIANS as f64).sin_cos();
            [radius * sin * x, radius * sin * y, radius * cos + shift]
        }));
    }
    points.push([0.0, 0.0, -radius - half]);
    let last = points.len() as u32 - 1;
    let at = |ring: usize, m: usize| (1 + ring * MERIDIANS + m % MERIDIANS) as u32;
    let mut faces = Vec::new();
    for m in 0..MERIDIANS {
        faces.push(vec![0, at(0, m), at(0, m + 1)]);
        for ring in 1..rings.len() {
            faces.push(vec![at(ring - 1, m), at(ring, m), at(ring, m + 1), at(ring - 1, m + 1)]);
        }
        faces.push(vec![at(rings.len() - 1, m), last, at(rings.len() - 1, m + 1)]);
    }
    // A meridian shows how it turns.
    let meridian = std::iter::once(0).chain((0..rings.len()).map(|ring| at(ring, 0))).chain([last]).collect();
    Surface { points, faces, lines: vec![meridian], round: true }
}

fn surface<T: Scalar>(shape: &Shape<T>) -> Surface {
    match shape.kind() {
        &Kind::Ball { radius } => globe(to_f64(radius), 0.0),
        &Kind::Capsule { radius, half_length } => globe(to_f64(radius), to_f64(half_length)),
        Kind::HalfSpace => {
            let corner = |x: f64, y: f64| [x, y, 0.0];
            let points = vec![corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
            Surface { points, faces: vec![vec![0, 1, 2, 3]], ..Surface::default() }
        }
        Kind::Terrain(terrain) => Surface {
            points: terrain.points().iter().map(plain).collect(),
            faces: terrain.triangles().iter().map(|triangle| triangle.to_vec()).collect(),
            ..Surface::default()
        },
        kind => {
            let round = matches!(kind, Kind::Round(_));
            let Some(hull) = shape.as_polyhedron() else { return Surface::default() };
            let points = hull.vertices().iter().map(plain).collect();
            let faces = (0..hull.faces()).map(|face| hull.corners(face).to_vec()).collect();
            Surface { points, faces, lines: Vec::new(), round }
        }
    }
}

impl<T: Scalar> SpatialBodies<T> {
    /// The shapes; bodies without any are points.
    pub(super) fn pictures(&self) -> Vec<Solid> {
        let of = |contactor: &Contactor<T>| {
            let mut surface = surface(&contactor.shape);
            let place =
                |x: &mut [f64; 3]| *x = plain(&contactor.local.place(&Vector3::from(x.map(lit::<T>))));
            surface.points.iter_mut().for_each(place);
            let endless = matches!(contactor.shape.kind(), Kind::HalfSpace);
            Solid { name: contactor.label.clone(), body: contactor.body, surface, endless }
        };
        let shapes = self.contactors.iter().map(of);
        let mut has_shape = vec![false; self.bodies()];
        self.contactors.iter().filter_map(|c| c.body).for_each(|body| has_shape[body] = true);
        let bare = (0..self.bodies()).filter(|&body| !has_shape[body]);
        let point = |body: usize| {
            let surface = Surface { points: vec![[0.0; 3]], ..Surface::default() };
            Solid { name: self.names[body].clone(), body: Some(body), surface, endless: false }
        };
        shapes.chain(bare.map(point)).collect()
    }

    pub(super) fn pose_of(&self, body: usize, q: &[T]) -> ([f64; 3], [f64; 4]) {
        let pose: Pose<T> = super::body_pose(Some(body), q);
        let turn = pose.orientation();
        (plain(pose.position()), [turn.w, turn.i, turn.j, turn.k].map(to_f64))
    }

    /// Velocity and spin along the fixed axes.
    pub(super) fn velocity_of(&self, body: usize, q: &[T], v: &[T]) -> ([f64; 3], [f64; 3]) {
        let v = &v[super::DOFS * body..];
        let spin = super::body_pose(Some(body), q).turn(&Vector3::new(v[3], v[4], v[5]));
        ([0, 1, 2].map(|k| to_f64(v[k])), plain(&spin))
    }

    pub(super) fn place_of(&self, contact: ContactId, q: &[T]) -> Option<ContactPlace> {
        let (contact, poses) = self.place(self.found(contact)?, q);
        let frame = frame(&contact.normal);
        let axes = [0, 1, 2].map(|k| plain(&frame.column(k).into_owned()));
        Some(ContactPlace { point: plain(&(poses[1].position() + contact.arms[1])), axes })
    }
}
