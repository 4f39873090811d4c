//! Shapes that are no convex bodies: arcs, circles seen from inside, chains of segments.

use nalgebra::Vector2;

use super::body::{BodyId, check};
use super::builder::{ContactorId, RigidBodiesBuilder};
use super::shape::{Contactor, Outline, Window};
use crate::scalar::{Scalar, all_finite, lit, to_f64};
use crate::system::SystemError;
use crate::system::interfaces::{GroupId, known};

/// Slack of the ends of an arc (rad): what lies on them is on it.
const END: f64 = 1e-9;

/// Layer behind a chain, in the length of its shortest segment.
const LAYER: f64 = 0.5;

/// Share of what mitres leave of a segment at the back of the layer.
const LEFT: f64 = 0.5;

/// Largest turn (rad) of a chain at a point: it is not to turn back on itself.
const LARGEST_TURN: f64 = 3.0;

/// The side of a circle that is met.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "scene", derive(serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum RoundSide {
    /// Bodies are inside the circle, as in a bowl or a drum (default).
    #[default]
    Inside,
    /// Bodies are outside the circle, as on a hump.
    Outside,
}

impl<T: Scalar> RigidBodiesBuilder<T> {
    /// Adds a circle of radius `radius` > 0 (m), or its arc between two angles `[from, to]` (rad, from the x-axis of the
    /// body's frame, from < to): nothing meets it elsewhere, and its ends are no corners. What is inside a circle must be
    /// smaller than that.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`], [`SystemError::Unknown`].
    pub fn arc(
        &mut self,
        label: &str,
        body: BodyId,
        (centre, radius): ([T; 2], T),
        side: RoundSide,
        angles: Option<[T; 2]>,
        group: GroupId,
    ) -> Result<ContactorId, SystemError> {
        let body = self.owner(body)?;
        let group = known("group", group.0, self.groups)?;
        check(|| format!("radius of `{label}`"), &[radius], |x| x > T::zero(), "finite and > 0")?;
        check(|| format!("centre of `{label}`"), &centre, |_| true, "finite")?;
        let window = angles.map(|[from, to]| {
            check(|| format!("an angle of `{label}`"), &[from, to], |_| true, "finite")?;
            let opening = [to - from];
            let range = "> 0: an arc runs from the first angle to the second";
            check(|| format!("opening of `{label}`"), &opening, |x| x > T::zero(), range)?;
            let half = lit::<T>(0.5);
            let (sin, cos) = nalgebra::ComplexField::sin_cos((from + to) * half);
            let largest = lit::<T>(std::f64::consts::PI);
            let half = nalgebra::RealField::min(opening[0] * half + lit::<T>(END), largest);
            Ok(Window { middle: Vector2::new(cos, sin), least: nalgebra::ComplexField::cos(half) })
        });
        let window = window.transpose()?;
        let (outline, reach) = match side {
            RoundSide::Inside => (Outline::Hollow(radius), radius + radius),
            RoundSide::Outside => (Outline::Disc, radius),
        };
        let (label, centre) = (label.into(), centre.into());
        self.contactors.push(Contactor { label, body, centre, radius: reach, outline, window, group });
        Ok(ContactorId(self.contactors.len() - 1))
    }

    /// Adds a chain of segments through `points` (m, in the frame of the body), `closed` from the last to the first: bodies
    /// stay on its left, seen along it. Behind it is a layer half as thick as the shortest segment is long, or thinner
    /// where it bends sharply; segment i is the contactor `label/i`.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`] for fewer than two points (three of a closed chain), a point that is not finite or
    /// equal to the one before, a chain that turns back; [`SystemError::Unknown`].
    pub fn chain(
        &mut self,
        label: &str,
        body: BodyId,
        points: &[[T; 2]],
        closed: bool,
        group: GroupId,
    ) -> Result<(), SystemError> {
        for (i, quad) in layer(label, points, closed)?.into_iter().enumerate() {
            self.polygon(&format!("{label}/{i}"), body, &quad, group)?;
        }
        Ok(())
    }
}

/// A quadrilateral behind every segment of a chain, mitred where two meet.
fn layer<T: Scalar>(label: &str, points: &[[T; 2]], closed: bool) -> Result<Vec<[[T; 2]; 4]>, SystemError> {
    let refuse = |what: String, value: f64, range| Err(SystemError::OutOfRange { what, value, range });
    let n = points.len();
    let least = if closed { 3 } else { 2 };
    if n < least {
        let range = if closed { "at least 3, as it is closed" } else { "at least 2" };
        return refuse(format!("number of points of chain `{label}`"), n as f64, range);
    }
    let count = if closed { n } else { n - 1 };
    let point = |i: usize| Vector2::from(points[i % n]);
    let mut along = Vec::with_capacity(count);
    let mut lengths = Vec::with_capacity(count);
    for i in 0..count {
        let segment = point(i + 1) - point(i);
        let length = segment.norm();
        if !(length > T::zero() && all_finite([&length])) {
            let what = format!("length of segment {i} of chain `{label}`");
            return refuse(what, to_f64(length), "finite and > 0");
        }
        along.push(segment / length);
        lengths.push(length);
    }
    // Half the turn to the left at the start of segment i, its tangent: what the mitre there adds per unit of depth.
    let mut mitres = vec![T::zero(); count + 1];
    for i in 0..=count {
        if !closed && (i == 0 || i == count) {
            continue;
        }
        let (before, after) = (along[(i + count - 1) % count], along[i % count]);
        let turn = nalgebra::RealField::atan2(before.x * after.y - before.y * after.x, before.dot(&after));
        if !(nalgebra::ComplexField::abs(turn) <= lit(LARGEST_TURN)) {
            let what = format!("turn (rad) of chain `{label}` at point {}", i % n);
            return refuse(what, to_f64(turn), "between -3 and 3: a chain does not turn back on itself");
        }
        mitres[i] = nalgebra::ComplexField::tan(turn * lit::<T>(0.5));
    }
    let mut depth = lengths.iter().copied().reduce(nalgebra::RealField::min).unwrap_or_else(T::zero);
    depth *= lit::<T>(LAYER);
    for (i, &length) in lengths.iter().enumerate() {
        let lost = -(mitres[i] + mitres[i + 1]);
        if lost * depth > length * lit::<T>(LEFT) {
            depth = length * lit::<T>(LEFT) / lost;
        }
    }
    let quad = |i: usize| {
        let behind = Vector2::new(along[i].y, -along[i].x) * depth;
        let (from, to) = (point(i), point(i + 1));
        let back = [
            from + behind - along[i] * (mitres[i] * depth),
            to + behind + along[i] * (mitres[i + 1] * depth),
        ];
        [from, back[0], back[1], to].map(Into::into)
    };
    Ok((0..count).map(quad).collect())
}
