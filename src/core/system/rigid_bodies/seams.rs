//! Seams: where two outlines that touch make one surface, its inner corners are none.
//!
//! The normals that the union of two convex outlines Y and C has at a point both hold are those of both, N_Y ∩ N_C. A
//! contact of a third body with Y at point P and normal n, found as if Y were alone, is a ghost where C holds P and reaches
//! beyond the plane of the contact, max_{c ∈ C} n·(c − P) > 0: the body would have to be inside C. It is left out where the
//! body has a contact with C (at Q, with normal m) whose plane Y stays behind, max_{y ∈ Y} m·(y − Q) ≤ 0: that one then stands
//! for both. A vertex of Y on a face of C that the body is over is left out as well.
//!
//! So a disc, a point or a polygon that slides over flush tiles meets neither the vertices nor the side faces at their
//! seams, while a step, a corner where the surface bends outwards, and a wall that rises from a floor are met as ever.
//! Outlines count as flush up to [`FLUSH`] of their size, fixed or moving.

use nalgebra::Vector2;

use super::RigidBodies;
use super::identity::{Features, Pair};
use super::shape::Pose;
use crate::contact::Candidate;
use crate::scalar::{Scalar, lit};

/// Offset of outlines that make one surface, in their size.
const FLUSH: f64 = 1e-6;

/// Ghosts are met near a corner: within this share of the size.
const NEAR_CORNER: f64 = 0.05;

/// One side of a contact: body X touches contactor Y at a point, with the normal from Y to X.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touch<T: Scalar> {
    /// The candidate's place.
    candidate: usize,
    body: usize,
    contactor: usize,
    point: Vector2<T>,
    normal: Vector2<T>,
    /// A disc on a vertex, or on a face.
    on: On,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum On {
    Vertex,
    Face,
    Else,
}

impl<T: Scalar> RigidBodies<T> {
    /// Drops the ghosts among the candidates between bodies, those from place `first` on.
    pub(super) fn drop_ghosts(&mut self, q: &[T], first: usize, out: &mut Vec<Candidate<T>>) {
        if self.polygons < 2 || out.len() < first + 2 {
            return;
        }
        let (mut touches, mut dropped) =
            (std::mem::take(&mut self.touches), std::mem::take(&mut self.ghosts));
        touches.clear();
        for (candidate, found) in out.iter().enumerate().skip(first) {
            self.push_touches(candidate, Pair::of(found.id), q, &mut touches);
        }
        // Together stand the touches of a body.
        touches.sort_unstable_by_key(|touch| (touch.body, touch.candidate));
        let ghost = |touches: &[Touch<T>], i: usize| {
            let touch = &touches[i];
            if !self.is_near_corner(touch, q) {
                return false;
            }
            let low = touches.partition_point(|other| other.body < touch.body);
            let others = touches[low..].iter().take_while(|other| other.body == touch.body);
            others
                .filter(|other| other.contactor != touch.contactor)
                .any(|other| self.covers(other, touch, q))
        };
        dropped.clear();
        dropped.extend((0..touches.len()).filter(|&i| ghost(&touches, i)).map(|i| touches[i].candidate));
        if !dropped.is_empty() {
            dropped.sort_unstable();
            let mut place = 0;
            out.retain(|_| {
                place += 1;
                dropped.binary_search(&(place - 1)).is_err()
            });
        }
        (self.touches, self.ghosts) = (touches, dropped);
    }

    /// Both sides of a candidate, where the other side is a polygon.
    fn push_touches(&self, candidate: usize, pair: Pair, q: &[T], out: &mut Vec<Touch<T>>) {
        let Pair::Features { a, b, features } = pair else { return };
        if self.contactors[b].is_hollow() {
            return;
        }
        let ([(one, arm), (other, other_arm)], normal) = self.sides(pair, q);
        let (first, second, on) = match features {
            Features::VertexEdge(..) => (a, b, On::Else),
            Features::EdgeVertex(..) => (b, a, On::Else),
            Features::EdgeDisc(_) => (b, a, On::Face),
            Features::VertexDisc(_) => (b, a, On::Vertex),
        };
        let point = |body: usize, arm: Vector2<T>| Pose::of(body, q).origin + arm;
        let second_side =
            Touch { candidate, body: one, contactor: second, point: point(other, other_arm), normal, on };
        out.push(second_side);
        if self.contactors[first].polygon().is_some() {
            out.push(Touch {
                candidate,
                body: other,
                contactor: first,
                point: point(one, arm),
                normal: -normal,
                on,
            });
        }
    }

    /// The largest of d·(x − p) over the vertices x of an outline.
    fn beyond(&self, contactor: usize, p: &Vector2<T>, d: &Vector2<T>, q: &[T]) -> T {
        let contactor = &self.contactors[contactor];
        let Some(polygon) = contactor.polygon() else { return T::zero() };
        let pose = Pose::of(contactor.body, q);
        let offset = pose.origin - p;
        let along = polygon.vertices.iter().map(|x| d.dot(&(pose.turn(x) + offset)));
        along.reduce(nalgebra::RealField::max).unwrap_or_else(T::zero)
    }

    fn is_near_corner(&self, touch: &Touch<T>, q: &[T]) -> bool {
        let contactor = &self.contactors[touch.contactor];
        let Some(polygon) = contactor.polygon() else { return false };
        let pose = Pose::of(contactor.body, q);
        let near = contactor.radius * lit::<T>(NEAR_CORNER);
        touch.on == On::Vertex
            || polygon.vertices.iter().any(|x| (pose.place(x) - touch.point).norm_squared() <= near * near)
    }

    /// Whether a contact of the same body makes `ghost` one.
    fn covers(&self, by: &Touch<T>, ghost: &Touch<T>, q: &[T]) -> bool {
        let (cover, covered) = (&self.contactors[by.contactor], &self.contactors[ghost.contactor]);
        let Some(polygon) = cover.polygon() else { return false };
        let flush = lit::<T>(FLUSH) * (cover.radius + covered.radius);
        // C holds P,
        let pose = Pose::of(cover.body, q);
        let local = pose.turn_back(&(ghost.point - pose.origin));
        if polygon.vertices.iter().zip(&polygon.normals).any(|(x, n)| n.dot(&(local - x)) > flush) {
            return false;
        }
        // Y stays behind the contact with C,
        if self.beyond(ghost.contactor, &by.point, &by.normal, q) > flush {
            return false;
        }
        // and C reaches beyond that with Y, or its face continues the vertex.
        let vertex = ghost.on == On::Vertex && by.on == On::Face;
        vertex || self.beyond(by.contactor, &ghost.point, &ghost.normal, q) > flush + flush
    }
}
