//! Where circles meet: discs, arcs, and circles that others are inside of.
//!
//! A circle seen from inside is a disc of negative radius of curvature with the distance of centres reversed. With centres
//! x and y, σ = −1 where one of the two is hollow, else 1, and signed radii ρ (−R of a hollow circle),
//!
//! ```text
//!   g = σ ‖x − y‖ − ρ_x − ρ_y,     n = σ (x − y)/‖x − y‖,     contact at x − ρ_x n = y + ρ_y n   where g = 0
//! ```
//!
//! and a vertex is a disc of radius 0. An arc has the contacts of its circle whose points are on it; its ends are no corners.

use nalgebra::Vector2;

use super::direction;
use super::identity::{Features, Pair};
use super::shape::{Contactor, Outline, Polygon, Pose, Window};
use crate::scalar::{Scalar, lit};

/// σ of a pair.
pub(super) fn sign<T: Scalar>(one: &Contactor<T>, other: &Contactor<T>) -> T {
    if one.is_hollow() || other.is_hollow() { -T::one() } else { T::one() }
}

/// g of two circles whose centres are `apart`.
pub(super) fn gap<T: Scalar>(one: &Contactor<T>, other: &Contactor<T>, apart: &Vector2<T>) -> T {
    sign(one, other) * apart.norm() - one.curvature() - other.curvature()
}

/// Calls `meet` for the contacts of two circles, or of a hollow circle and the vertices of a polygon.
pub(super) fn contacts<T: Scalar>(
    (i, one): (usize, &Contactor<T>),
    (j, other): (usize, &Contactor<T>),
    (x, y): (Vector2<T>, Vector2<T>),
    q: &[T],
    mut meet: impl FnMut(Pair, T),
) {
    match (one.polygon(), other.polygon()) {
        (None, None) if one.is_hollow() && other.is_hollow() => {}
        (None, None) => {
            let normal = direction(x - y, Vector2::y) * sign(one, other);
            if one.shows(&-normal, q) && other.shows(&normal, q) {
                meet(Pair::Discs(i, j), gap(one, other, &(x - y)));
            }
        }
        (Some(polygon), None) => vertices((i, one, polygon), (j, other, &y), q, meet),
        (None, Some(polygon)) => vertices((j, other, polygon), (i, one, &x), q, meet),
        (Some(_), Some(_)) => {}
    }
}

/// The vertices of a polygon inside a hollow circle.
fn vertices<T: Scalar>(
    (a, contactor, polygon): (usize, &Contactor<T>, &Polygon<T>),
    (b, circle, centre): (usize, &Contactor<T>, &Vector2<T>),
    q: &[T],
    mut meet: impl FnMut(Pair, T),
) {
    let pose = Pose::of(contactor.body, q);
    for (v, vertex) in polygon.vertices.iter().enumerate() {
        let apart = centre - pose.place(vertex);
        if circle.shows(&direction(apart, Vector2::y), q) {
            let features = Features::VertexDisc(v);
            meet(Pair::Features { a, b, features }, -apart.norm() - circle.curvature());
        }
    }
}

/// Whether the arc of a disc at `centre` is there where it meets a polygon.
pub(super) fn shows<T: Scalar>(
    (polygon, pose): (&Polygon<T>, &Pose<T>),
    (disc, centre): (&Contactor<T>, &Vector2<T>),
    features: Features,
    q: &[T],
) -> bool {
    if disc.window.is_none() {
        return true;
    }
    let normal = match features {
        Features::VertexDisc(vertex) => direction(centre - pose.place(&polygon.vertices[vertex]), Vector2::y),
        Features::EdgeDisc(edge) | Features::VertexEdge(_, edge) | Features::EdgeVertex(_, edge) => {
            pose.turn(&polygon.normals[edge])
        }
    };
    disc.shows(&-normal, q)
}

impl<T: Scalar> Contactor<T> {
    /// Whether it is a disc, a point or an arc.
    pub(super) fn is_round(&self) -> bool {
        !matches!(self.outline, Outline::Polygon(_))
    }

    /// The outline in configuration q, as [`points`](Self::points).
    pub(super) fn placed(&self, sides: usize, q: &[T]) -> Vec<[T; 2]> {
        let pose = Pose::of(self.body, q);
        self.points(sides).iter().map(|x| pose.place(x).into()).collect()
    }

    /// The outline in the frame of the body, a closed one with its first point repeated; a full circle has `sides` sides.
    pub(super) fn points(&self, sides: usize) -> Vec<Vector2<T>> {
        if let Some(polygon) = self.polygon() {
            let mut points = polygon.vertices.clone();
            points.extend(points.first().copied());
            return points;
        }
        let radius = nalgebra::ComplexField::abs(self.curvature());
        if radius == T::zero() {
            return vec![self.centre];
        }
        let whole = lit::<T>(std::f64::consts::TAU);
        let (first, opening) = match &self.window {
            None => (T::zero(), whole),
            Some(Window { middle, least }) => {
                let half =
                    nalgebra::ComplexField::acos(nalgebra::RealField::clamp(*least, -T::one(), T::one()));
                (nalgebra::RealField::atan2(middle.y, middle.x) - half, half + half)
            }
        };
        let at = |i: usize| {
            let angle = first + opening * lit::<T>(i as f64 / sides as f64);
            let (sin, cos) = nalgebra::ComplexField::sin_cos(angle);
            self.centre + Vector2::new(cos, sin) * radius
        };
        let mut points: Vec<Vector2<T>> = (0..sides).map(at).collect();
        // A circle closes where it began, without the rounding of a turn.
        points.push(if self.window.is_none() { points[0] } else { at(sides) });
        points
    }
}
