//! Where two shapes meet, as a function of their two poses alone.

mod capsule;
mod nearest;
mod outline;
mod polyhedra;
mod resolve;
mod separate;
mod terrain;

use nalgebra::Vector3;

use self::capsule::{ball_and_polyhedron, capsules};
use self::outline::Outline;
use self::resolve::Pair;
use self::separate::Placed;
use super::feature::{Carrier, Contact, Feature, Meeting};
use super::pose::Pose;
use super::round::Round;
use super::shape::{Kind, Shape};
use crate::scalar::{Scalar, lit};

pub use resolve::resolve;

/// Finds the contacts of two shapes; keeps nothing from call to call but memory, so that warm calls allocate nothing.
#[derive(Debug, Clone)]
pub struct NarrowPhase<T: Scalar> {
    placed: [Placed<T>; 2],
    outlines: [Outline<T>; 2],
    distances: [Vec<T>; 2],
    near: terrain::Near,
    points: Vec<Vector3<T>>,
}

impl<T: Scalar> Default for NarrowPhase<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Scalar> NarrowPhase<T> {
    /// A narrow phase without memory.
    pub fn new() -> Self {
        Self {
            placed: [Placed::new(), Placed::new()],
            outlines: [Outline::new(), Outline::new()],
            distances: [Vec::new(), Vec::new()],
            near: terrain::Near::default(),
            points: Vec::new(),
        }
    }

    /// Appends the contacts of `first` and `second` with a gap of at most `reach` (m) to `out`; none where a pose is not finite.
    ///
    /// Normals lead from the first shape, the obstacle, to the second, the body; in the other order the same contacts are
    /// found with their roles exchanged, to rounding. Half-spaces and terrain have none with each other.
    pub fn contacts(
        &mut self,
        first: (&Shape<T>, &Pose<T>),
        second: (&Shape<T>, &Pose<T>),
        reach: T,
        out: &mut Vec<Contact<T>>,
    ) {
        if rank(&first.0.kind) <= rank(&second.0.kind) {
            return self.ordered(&Pair::new(first, second), reach, out);
        }
        let start = out.len();
        self.ordered(&Pair::new(second, first), reach, out);
        for contact in &mut out[start..] {
            *contact = contact.swapped();
        }
    }

    fn ordered(&mut self, pair: &Pair<'_, T>, reach: T, out: &mut Vec<Contact<T>>) {
        if matches!(pair.a.kind, Kind::HalfSpace) {
            return half_space(pair, reach, out);
        }
        if let Kind::Terrain(terrain) = &pair.a.kind {
            return self.terrain(pair, terrain, reach, out);
        }
        // Polyhedra alone have their centre elsewhere.
        let centre = |shape: &Shape<T>, pose: &Pose<T>| match &shape.kind {
            Kind::Polyhedron(hull) => pose.turn(hull.centre()),
            _ => Vector3::zeros(),
        };
        let centres = pair.between + centre(pair.b, pair.bt) - centre(pair.a, pair.at);
        let far = pair.a.radius + pair.b.radius + reach;
        if !(centres.dot(&centres) <= far * far && far >= T::zero()) {
            return;
        }
        let hull = pair.a.as_polyhedron();
        match (&pair.a.kind, hull, &pair.b.kind) {
            (Kind::Round(round), _, Kind::Ball { .. }) => round_and_ball(pair, round, reach, out),
            (_, Some(hull), Kind::Ball { .. }) => ball_and_polyhedron(pair, hull, reach, out),
            (_, Some(hull), Kind::Capsule { .. }) => self.polyhedron_and_capsule(pair, hull, reach, out),
            (_, Some(hull), _) => {
                if let Some(other) = pair.b.as_polyhedron() {
                    self.polyhedra(pair, (hull, other), reach, out);
                }
            }
            (Kind::Ball { .. }, None, Kind::Ball { .. }) => {
                let meeting =
                    Meeting { first: Feature::Vertex(0), second: Feature::Vertex(0), carrier: Carrier::Line };
                pair.push(meeting, reach, out);
            }
            (_, None, _) => capsules(pair, reach, out),
        }
    }
}

/// Pairs are looked at with the lower rank first.
fn rank<T: Scalar>(kind: &Kind<T>) -> u8 {
    match kind {
        Kind::HalfSpace | Kind::Terrain(_) => 0,
        Kind::Cuboid(_) | Kind::Polyhedron(_) | Kind::Round(_) => 1,
        Kind::Capsule { .. } => 2,
        Kind::Ball { .. } => 3,
    }
}

/// All vertices of b over half-space a, and the lowest points of its rims.
fn half_space<T: Scalar>(pair: &Pair<'_, T>, reach: T, out: &mut Vec<Contact<T>>) {
    let on_face = |second| Meeting { first: Feature::Face(0), second, carrier: Carrier::First(0) };
    let vertices = match &pair.b.kind {
        Kind::HalfSpace | Kind::Terrain(_) => return,
        Kind::Ball { .. } => 1,
        Kind::Capsule { .. } => 2,
        Kind::Cuboid(hull) | Kind::Polyhedron(hull) => hull.vertices.len(),
        Kind::Round(round) => {
            let down = pair.bt.turn_back(&pair.at.rotation().column(2).into_owned());
            for rim in 0..round.rims.len() {
                // A level rim has no lowest point, and a tip is a vertex.
                let tilted = round.lowest(rim, &down).is_some_and(|(_, steep)| steep > lit(1e-9));
                if tilted && round.rims[rim][0] > T::zero() {
                    pair.push(on_face(Feature::Rim(rim as u32)), reach, out);
                }
            }
            round.facets.vertices.len()
        }
    };
    for vertex in 0..vertices {
        pair.push(on_face(Feature::Vertex(vertex as u32)), reach, out);
    }
}

/// The centre of ball b and the round a.
fn round_and_ball<T: Scalar>(pair: &Pair<'_, T>, round: &Round<T>, reach: T, out: &mut Vec<Contact<T>>) {
    let centre = pair.at.turn_back(&pair.between);
    let first = round.nearest(&centre);
    let carrier = match first {
        Feature::Face(face) => Carrier::First(face),
        _ => Carrier::Line,
    };
    pair.push(Meeting { first, second: Feature::Vertex(0), carrier }, reach, out);
}
