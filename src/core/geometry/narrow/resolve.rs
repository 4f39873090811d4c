//! From what meets to where, exactly: every contact is written by this file alone.

use nalgebra::Vector3;

use crate::geometry::feature::{Carrier, Contact, Feature, Meeting};
use crate::geometry::pose::{Pose, frame};
use crate::geometry::real::{direction, infinity, sqrt};
use crate::geometry::shape::{Kind, Shape};
use crate::scalar::Scalar;

/// Two shapes where they are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair<'a, T: Scalar> {
    pub(super) a: &'a Shape<T>,
    pub(super) at: &'a Pose<T>,
    pub(super) b: &'a Shape<T>,
    pub(super) bt: &'a Pose<T>,
    /// From the origin of a's frame to that of b's, in fixed axes.
    pub(super) between: Vector3<T>,
}

/// The contact of the features of `meeting`, between `first` and `second` where these are now: points, normal and gap, as
/// functions of the two poses that are smooth near those at which the meeting was found.
///
/// The gap is n·((x_B − x_A) + R_B b − R_A a), less the radii of balls and capsules. Along any motion of the two bodies its
/// derivative is n·(velocity of the second point − velocity of the first), exactly, for all meetings but those of two edges
/// with a face as carrier (edges within 6° of parallel), where it errs by the tilt of the faces.
///
/// `None` where the shapes have no such features, or the features no such contact.
pub fn resolve<T: Scalar>(
    meeting: &Meeting,
    first: (&Shape<T>, &Pose<T>),
    second: (&Shape<T>, &Pose<T>),
) -> Option<Contact<T>> {
    Pair::new(first, second).resolve(meeting)
}

impl<T: Scalar> Shape<T> {
    /// The vertex of that number.
    #[inline]
    pub(super) fn vertex(&self, i: u32) -> Option<Vector3<T>> {
        match &self.kind {
            Kind::Ball { .. } => (i == 0).then(Vector3::zeros),
            &Kind::Capsule { half_length, .. } => match i {
                0 => Some(Vector3::new(T::zero(), T::zero(), -half_length)),
                1 => Some(Vector3::new(T::zero(), T::zero(), half_length)),
                _ => None,
            },
            Kind::HalfSpace => None,
            Kind::Terrain(terrain) => terrain.points.get(i as usize).copied(),
            Kind::Cuboid(hull) | Kind::Polyhedron(hull) => hull.vertices.get(i as usize).copied(),
            Kind::Round(round) => round.facets.vertices.get(i as usize).copied(),
        }
    }

    /// The ends of an edge, and the sum of the normals beside it: 0 for the axis of a capsule.
    #[inline]
    pub(super) fn edge(&self, i: u32) -> Option<([Vector3<T>; 2], Vector3<T>)> {
        if matches!(self.kind, Kind::Capsule { .. }) {
            return (i == 0).then_some(([self.vertex(0)?, self.vertex(1)?], Vector3::zeros()));
        }
        if let Kind::Terrain(terrain) = &self.kind {
            let ridge = terrain.ridges.get(i as usize)?;
            return Some((ridge.ends.map(|v| terrain.points[v as usize]), ridge.beside));
        }
        let hull = self.as_polyhedron()?;
        let edge = hull.edges.get(i as usize)?;
        let [from, to] = edge.vertices.map(|v| hull.vertices[v as usize]);
        let [left, right] = edge.faces.map(|f| hull.normals[f as usize]);
        Some(([from, to], left + right))
    }

    /// Outward normal and offset of a face or patch, of the inscribed polyhedron of a round.
    #[inline]
    pub(super) fn face(&self, i: u32) -> Option<(Vector3<T>, T)> {
        if matches!(self.kind, Kind::HalfSpace) {
            return (i == 0).then(|| (Vector3::z(), T::zero()));
        }
        if let Kind::Terrain(terrain) = &self.kind {
            return terrain.planes.get(i as usize).copied();
        }
        let hull = self.as_polyhedron()?;
        Some((*hull.normals.get(i as usize)?, *hull.offsets.get(i as usize)?))
    }

    /// Radius around vertices and edges.
    #[inline]
    pub(super) fn skin(&self) -> T {
        match self.kind {
            Kind::Ball { radius } | Kind::Capsule { radius, .. } => radius,
            _ => T::zero(),
        }
    }
}

impl<'a, T: Scalar> Pair<'a, T> {
    #[inline]
    pub(super) fn new((a, at): (&'a Shape<T>, &'a Pose<T>), (b, bt): (&'a Shape<T>, &'a Pose<T>)) -> Self {
        Self { a, at, b, bt, between: at.to(bt) }
    }

    /// Appends the contact of `meeting` if its gap is within `reach`.
    #[inline]
    pub(super) fn push(&self, meeting: Meeting, reach: T, out: &mut Vec<Contact<T>>) {
        if let Some(contact) = self.resolve(&meeting)
            && contact.gap <= reach
        {
            out.push(contact);
        }
    }

    #[inline]
    pub(super) fn swapped(&self) -> Self {
        Self { a: self.b, at: self.bt, b: self.a, bt: self.at, between: -self.between }
    }

    /// The contact at points `a` and `b`, from the origins of the frames in fixed axes, of the skinless shapes at a `gap`.
    #[inline]
    fn contact(&self, meeting: &Meeting, normal: Vector3<T>, gap: T, [a, b]: [Vector3<T>; 2]) -> Contact<T> {
        let (thick, thin) = (self.a.skin(), self.b.skin());
        let arms = [self.at.arm() + a + normal * thick, self.bt.arm() + b - normal * thin];
        Contact { meeting: *meeting, normal, gap: gap - (thick + thin), arms }
    }

    #[inline]
    pub(super) fn resolve(&self, meeting: &Meeting) -> Option<Contact<T>> {
        use Carrier::{Edges, First, Line, Second};
        use Feature::{Edge, Face, Mantle, Patch, Rim, Vertex};
        let round = |shape: &Shape<T>| matches!(shape.kind, Kind::Round(_));
        let ball = |shape: &Shape<T>| matches!(shape.kind, Kind::Ball { .. });
        match (meeting.first, meeting.second, meeting.carrier) {
            (Vertex(0), Vertex(0), Line) if ball(self.a) && ball(self.b) => {
                self.on_line(meeting, Vector3::zeros(), Vector3::zeros(), Vector3::z)
            }
            (feature, Vertex(0), _) if round(self.a) && ball(self.b) => self.round_ball(meeting, feature),
            (Vertex(0), _, _) if ball(self.a) && round(self.b) => self.flipped(meeting),
            (Face(face) | Patch(face), Vertex(vertex), First(_)) => {
                self.on_face(meeting, face, self.b.vertex(vertex)?)
            }
            (Face(face), Rim(rim), First(_)) => {
                let Kind::Round(round) = &self.b.kind else { return None };
                let (normal, _) = self.a.face(face)?;
                let down = self.bt.turn_back(&self.at.turn(&normal));
                self.on_face(meeting, face, round.lowest(rim as usize, &down)?.0)
            }
            (Vertex(_) | Rim(_), Face(_) | Patch(_), Second(_)) | (Vertex(_), Edge(_), Line) => {
                self.flipped(meeting)
            }
            (Vertex(first), Vertex(second), Line) => {
                let a = self.at.turn(&self.a.vertex(first)?);
                let b = self.bt.turn(&self.b.vertex(second)?);
                self.on_line(meeting, a, b, Vector3::z)
            }
            (Edge(edge), Vertex(vertex), Line) => {
                let ([from, to], beside) = self.a.edge(edge)?;
                let (from, along) = (self.at.turn(&from), self.at.turn(&(to - from)));
                let b = self.bt.turn(&self.b.vertex(vertex)?);
                let share = along.dot(&(self.between + b - from)) / along.dot(&along);
                let aside = || self.aside(&along, &beside);
                self.on_line(meeting, from + along * share, b, aside)
            }
            (Edge(first), Edge(second), Line | Edges | First(_) | Second(_)) => {
                self.across(meeting, first, second)
            }
            (Face(_) | Mantle(_) | Rim(_) | Vertex(_) | Edge(_) | Patch(_), _, _) => None,
        }
    }

    fn flipped(&self, meeting: &Meeting) -> Option<Contact<T>> {
        self.swapped().resolve(&meeting.swapped()).map(Contact::swapped)
    }

    /// The point `b` of the second frame on a face of the first.
    #[inline]
    fn on_face(&self, meeting: &Meeting, face: u32, b: Vector3<T>) -> Option<Contact<T>> {
        let (normal, offset) = self.a.face(face)?;
        let ball = matches!(self.b.kind, Kind::Ball { .. });
        let (normal, b) = (self.at.turn(&normal), if ball { b } else { self.bt.turn(&b) });
        let height = normal.dot(&self.between) + normal.dot(&b) - offset;
        let foot = self.between + b - normal * height;
        Some(self.contact(meeting, normal, height, [foot, b]))
    }

    /// Two points at a distance; `aside` where they coincide.
    #[inline]
    fn on_line(
        &self,
        meeting: &Meeting,
        a: Vector3<T>,
        b: Vector3<T>,
        aside: impl FnOnce() -> Vector3<T>,
    ) -> Option<Contact<T>> {
        let apart = self.between + b - a;
        let square = apart.dot(&apart);
        // The plain way where squares neither vanish nor overflow.
        let (normal, distance) = if square > crate::scalar::lit(1e-30) && square < crate::scalar::lit(1e30) {
            let distance = sqrt(square);
            (apart / distance, distance)
        } else {
            match direction(&apart) {
                Some(normal) => (normal, normal.dot(&apart)),
                None => (aside(), T::zero()),
            }
        };
        Some(self.contact(meeting, normal, distance, [a, b]))
    }

    /// A normal of an edge of the first shape, outwards where it has an outside; of a capsule's axis any.
    fn aside(&self, along: &Vector3<T>, beside: &Vector3<T>) -> Vector3<T> {
        let out = direction(&self.at.turn(beside));
        out.or_else(|| Some(frame(&direction(along)?).column(1).into_owned())).unwrap_or_else(Vector3::z)
    }

    /// Two edges: the points that are nearest, or that cross as seen along the normal of a face.
    fn across(&self, meeting: &Meeting, first: u32, second: u32) -> Option<Contact<T>> {
        let ([a, a_end], a_beside) = self.a.edge(first)?;
        let ([b, b_end], b_beside) = self.b.edge(second)?;
        let (a, along) = (self.at.turn(&a), self.at.turn(&(a_end - a)));
        let (b, other) = (self.bt.turn(&b), self.bt.turn(&(b_end - b)));
        let apart = self.between + b - a;
        let seen = |normal: Option<Vector3<T>>| {
            let flat = |v: Vector3<T>| normal.map_or(v, |n| v - n * n.dot(&v));
            nearest_on_lines(flat(along), flat(other), flat(apart))
        };
        let normal = match meeting.carrier {
            Carrier::First(face) => self.at.turn(&self.a.face(face)?.0),
            Carrier::Second(face) => -self.bt.turn(&self.b.face(face)?.0),
            Carrier::Edges | Carrier::Line => {
                let [s, t] = seen(None)?;
                let normal = direction(&along.cross(&other))?;
                let out = match meeting.carrier {
                    Carrier::Edges => self.at.turn(&a_beside) - self.bt.turn(&b_beside),
                    _ => apart,
                };
                let normal = if normal.dot(&out) < T::zero() { -normal } else { normal };
                let points = [a + along * s, b + other * t];
                return Some(self.contact(meeting, normal, normal.dot(&apart), points));
            }
        };
        let [s, t] = seen(Some(normal))?;
        let points = [a + along * s, b + other * t];
        let gap = normal.dot(&(self.between + points[1] - points[0]));
        Some(self.contact(meeting, normal, gap, points))
    }

    /// A round against the centre of a ball.
    fn round_ball(&self, meeting: &Meeting, feature: Feature) -> Option<Contact<T>> {
        let Kind::Round(round) = &self.a.kind else { return None };
        let centre = self.at.turn_back(&self.between);
        let (normal, distance) = round.at_feature(feature, &centre)?;
        let normal = self.at.turn(&normal);
        let foot = self.between - normal * distance;
        Some(self.contact(meeting, normal, distance, [foot, Vector3::zeros()]))
    }
}

/// Shares s and t of the two lines at the points that are nearest: minimises |r + t v − s u|. `None` for parallel lines.
pub(super) fn nearest_on_lines<T: Scalar>(u: Vector3<T>, v: Vector3<T>, r: Vector3<T>) -> Option<[T; 2]> {
    let (uu, uv, vv) = (u.dot(&u), u.dot(&v), v.dot(&v));
    let (ur, vr) = (u.dot(&r), v.dot(&r));
    // uu·vv − uv² without its cancellation.
    let cross = u.cross(&v);
    let square = cross.dot(&cross);
    let shares = [(ur * vv - uv * vr) / square, (uv * ur - uu * vr) / square];
    shares.iter().all(|&x| x < infinity() && x > -infinity::<T>()).then_some(shares)
}
