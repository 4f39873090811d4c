//! Outlines of contactors: discs, points, arcs, convex polygons, and circles seen from inside.

use nalgebra::Vector2;

use crate::scalar::Scalar;

/// A shape fixed to a body. Other shapes join here, and answer where their boundary is nearest to a half-plane or to
/// another shape.
#[derive(Debug, Clone)]
pub(super) struct Contactor<T> {
    pub(super) label: String,
    pub(super) body: usize,
    /// Centre of the bounding circle in the frame of the body, from its centre of mass.
    pub(super) centre: Vector2<T>,
    /// Radius of the bounding circle.
    pub(super) radius: T,
    pub(super) outline: Outline<T>,
    /// The part of a circle that is there; all of it where absent.
    pub(super) window: Option<Window<T>>,
    pub(super) group: usize,
}

/// The body of shapes that are fixed: it has no degree of freedom.
pub(super) const GROUND: usize = usize::MAX;

/// The boundary of a contactor.
#[derive(Debug, Clone)]
pub(super) enum Outline<T> {
    /// The bounding circle itself; a contact point is a disc of radius 0.
    Disc,
    /// A circle of this radius that others are inside of; the bounding circle reaches as far behind it.
    Hollow(T),
    /// A strictly convex polygon, counterclockwise, in the frame of the body.
    Polygon(Polygon<T>),
}

/// An arc of a circle: the directions from its centre within some angle of a middle one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window<T> {
    /// Unit vector in the frame of the body.
    pub(super) middle: Vector2<T>,
    /// Cosine of half the opening.
    pub(super) least: T,
}

/// Vertices, and the outward normal of the edge that starts at each.
#[derive(Debug, Clone)]
pub(super) struct Polygon<T> {
    pub(super) vertices: Vec<Vector2<T>>,
    pub(super) normals: Vec<Vector2<T>>,
}

impl<T: Scalar> Polygon<T> {
    pub(super) fn new(vertices: Vec<Vector2<T>>) -> Self {
        let next = |i: usize| vertices[(i + 1) % vertices.len()];
        let normals = (0..vertices.len()).map(|i| {
            let edge = next(i) - vertices[i];
            Vector2::new(edge.y, -edge.x) / edge.norm()
        });
        Self { normals: normals.collect(), vertices }
    }
}

/// Position and orientation of a body.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pose<T> {
    pub(super) origin: Vector2<T>,
    sin: T,
    cos: T,
}

impl<T: Scalar> Pose<T> {
    #[inline]
    pub(super) fn of(body: usize, q: &[T]) -> Self {
        if body == GROUND {
            return Self { origin: Vector2::zeros(), sin: T::zero(), cos: T::one() };
        }
        let (sin, cos) = nalgebra::ComplexField::sin_cos(q[3 * body + 2]);
        Self { origin: Vector2::new(q[3 * body], q[3 * body + 1]), sin, cos }
    }

    /// A vector of the body's frame in the fixed frame.
    #[inline]
    pub(super) fn turn(&self, x: &Vector2<T>) -> Vector2<T> {
        Vector2::new(self.cos * x.x - self.sin * x.y, self.sin * x.x + self.cos * x.y)
    }

    /// A vector of the fixed frame in the body's frame.
    #[inline]
    pub(super) fn turn_back(&self, x: &Vector2<T>) -> Vector2<T> {
        Vector2::new(self.cos * x.x + self.sin * x.y, self.cos * x.y - self.sin * x.x)
    }

    /// A point of the body in the fixed frame.
    #[inline]
    pub(super) fn place(&self, x: &Vector2<T>) -> Vector2<T> {
        self.origin + self.turn(x)
    }
}

impl<T: Scalar> Contactor<T> {
    /// Lever arm from the centre of mass of the body to the centre of the contactor, in the fixed frame.
    #[inline]
    pub(super) fn lever(&self, q: &[T]) -> Vector2<T> {
        let c = self.centre;
        if self.body == GROUND || c.x == T::zero() && c.y == T::zero() {
            return c;
        }
        Pose::of(self.body, q).turn(&c)
    }

    /// Centre in the fixed frame.
    #[inline]
    pub(super) fn position(&self, q: &[T]) -> Vector2<T> {
        if self.body == GROUND {
            return self.centre;
        }
        let i = 3 * self.body;
        Vector2::new(q[i], q[i + 1]) + self.lever(q)
    }

    /// The polygon, `None` for a disc.
    #[inline]
    pub(super) fn polygon(&self) -> Option<&Polygon<T>> {
        match &self.outline {
            Outline::Disc | Outline::Hollow(_) => None,
            Outline::Polygon(polygon) => Some(polygon),
        }
    }

    /// Whether others are inside.
    #[inline]
    pub(super) fn is_hollow(&self) -> bool {
        matches!(self.outline, Outline::Hollow(_))
    }

    /// Radius of curvature of a circle, positive where its outside is met.
    #[inline]
    pub(super) fn curvature(&self) -> T {
        match self.outline {
            Outline::Hollow(radius) => -radius,
            _ => self.radius,
        }
    }

    /// Whether the arc is there where a contact has the normal `normal` (fixed frame) that points from it.
    pub(super) fn shows(&self, normal: &Vector2<T>, q: &[T]) -> bool {
        let Some(window) = &self.window else { return true };
        let outward = if self.is_hollow() { -normal } else { *normal };
        Pose::of(self.body, q).turn_back(&outward).dot(&window.middle) >= window.least
    }
}

/// The half-plane n·x ≤ d of the ground or of a body that moves as told, in its frame; bodies live where n·x > d.
#[derive(Debug, Clone)]
pub(super) struct HalfPlane<T> {
    pub(super) label: String,
    pub(super) body: usize,
    pub(super) normal: Vector2<T>,
    pub(super) distance: T,
    pub(super) group: usize,
}

impl<T: Scalar> HalfPlane<T> {
    /// n and d in the fixed frame.
    #[inline]
    pub(super) fn placed(&self, q: &[T]) -> (Vector2<T>, T) {
        if self.body == GROUND {
            return (self.normal, self.distance);
        }
        let pose = Pose::of(self.body, q);
        let normal = pose.turn(&self.normal);
        (normal, self.distance + normal.dot(&pose.origin))
    }
}
