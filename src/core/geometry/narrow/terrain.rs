//! Balls, capsules and polyhedra over terrain.
//!
//! Contacts are the places where the distance of the two surfaces is least near there: points of the shape over patches,
//! sharp corners of the terrain under the shape, sharp sides that an edge of the shape crosses. A normal lies in the cones of
//! normals of both features, so that the sides between triangles of one plane, and valleys, have none of their own.

use nalgebra::Vector3;

use super::NarrowPhase;
use super::nearest::segments;
use super::resolve::{Pair, nearest_on_lines};
use crate::geometry::bounds::Bounds;
use crate::geometry::feature::{Carrier, Contact, Feature, Meeting};
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::real::{abs, direction, infinity, max, min};
use crate::geometry::shape::Kind;
use crate::geometry::terrain::{Ridge, Terrain};
use crate::scalar::{Scalar, epsilon, lit};

/// Sine of the angle that a normal may lie outside of a cone, for rounding.
fn aside<T: Scalar>() -> T {
    max(lit::<T>(1e-9), lit::<T>(16.0) * epsilon::<T>())
}

/// Memory of a search.
#[derive(Debug, Clone, Default)]
pub(super) struct Near {
    stack: Vec<u32>,
    triangles: Vec<u32>,
    ridges: Vec<u32>,
    corners: Vec<u32>,
}

impl Near {
    /// The triangles near a box, their sharp sides and corners.
    fn find<T: Scalar>(&mut self, terrain: &Terrain<T>, within: &Bounds<T>) {
        self.triangles.clear();
        self.ridges.clear();
        self.corners.clear();
        terrain.near(within, &mut self.stack, &mut self.triangles);
        // In an order that does not depend on the tree.
        self.triangles.sort_unstable();
        for &t in &self.triangles {
            let sides = terrain.sides[t as usize].iter();
            self.ridges.extend(sides.filter(|&&side| terrain.ridges[side as usize].is_sharp));
            let corners = terrain.triangles[t as usize].iter();
            self.corners.extend(corners.filter(|&&v| !terrain.around[v as usize].is_empty()));
        }
        for list in [&mut self.ridges, &mut self.corners] {
            list.sort_unstable();
            list.dedup();
        }
    }
}

impl<T: Scalar> Terrain<T> {
    /// Whether a direction that leads away from a side is in its cone of normals.
    fn leaves_ridge(&self, ridge: &Ridge<T>, away: &Vector3<T>, slack: T) -> bool {
        let inwards = ridge.inwards.iter().flatten();
        away.dot(&ridge.beside) > T::zero() && inwards.into_iter().all(|inward| away.dot(inward) <= slack)
    }

    /// Whether a direction that leads away from a corner is in its cone of normals.
    fn leaves_corner(&self, corner: u32, away: &Vector3<T>, slack: T) -> bool {
        let from = self.points[corner as usize];
        let along = |&other: &u32| {
            let side = self.points[other as usize] - from;
            away.dot(&side) <= slack * side.norm()
        };
        away.dot(&self.outward[corner as usize]) > T::zero() && self.around[corner as usize].iter().all(along)
    }
}

/// Appends the contact of a meeting, unless one is there with the same point and normal: where features end, two have it.
fn push<T: Scalar>(pair: &Pair<'_, T>, meeting: Meeting, reach: T, start: usize, out: &mut Vec<Contact<T>>) {
    if out[start..].iter().any(|known| known.meeting == meeting) {
        return;
    }
    let before = out.len();
    pair.push(meeting, reach, out);
    let Some(made) = out.get(before).copied() else { return };
    let near = aside::<T>() * (made.arms[1].norm() + abs(made.gap));
    let is_one = |known: &Contact<T>| {
        (known.arms[1] - made.arms[1]).norm() <= near
            && (known.normal - made.normal).norm() <= aside()
            && abs(known.gap - made.gap) <= near
    };
    if out[start..before].iter().any(is_one) {
        out.truncate(before);
    }
}

impl<T: Scalar> NarrowPhase<T> {
    /// Terrain a and any other shape b.
    pub(super) fn terrain(
        &mut self,
        pair: &Pair<'_, T>,
        terrain: &Terrain<T>,
        reach: T,
        out: &mut Vec<Contact<T>>,
    ) {
        let start = out.len();
        // A point of b in the frame of the terrain.
        let seen = |x: &Vector3<T>| pair.at.turn_back(&(pair.between + pair.bt.turn(x)));
        let near = &mut self.near;
        match &pair.b.kind {
            Kind::Ball { radius } => {
                let centre = seen(&Vector3::zeros());
                near.find(terrain, &Bounds::around(centre, Vector3::repeat(*radius + reach)));
                of_end(pair, (terrain, near), (0, &centre, *radius), reach, start, out);
            }
            &Kind::Capsule { radius, half_length } => {
                let end = |z: T| seen(&Vector3::new(T::zero(), T::zero(), z));
                let ends = [end(-half_length), end(half_length)];
                let grown = Vector3::repeat(radius + reach);
                let within =
                    Bounds { low: ends[0].inf(&ends[1]) - grown, high: ends[0].sup(&ends[1]) + grown };
                near.find(terrain, &within);
                for (number, end) in (0..).zip(&ends) {
                    of_end(pair, (terrain, near), (number, end, radius), reach, start, out);
                }
                of_axis(pair, (terrain, near), &ends, reach, start, out);
            }
            Kind::HalfSpace | Kind::Terrain(_) => {}
            Kind::Cuboid(_) | Kind::Polyhedron(_) | Kind::Round(_) => {
                let Some(hull) = pair.b.as_polyhedron() else { return };
                self.points.clear();
                self.points.extend(hull.vertices.iter().map(seen));
                let none = (Vector3::repeat(infinity::<T>()), Vector3::repeat(-infinity::<T>()));
                let (low, high) = self.points.iter().fold(none, |(low, high), x| (low.inf(x), high.sup(x)));
                let within = Bounds { low: low.add_scalar(-reach), high: high.add_scalar(reach) };
                near.find(terrain, &within);
                if !near.triangles.is_empty() {
                    of_hull(pair, (terrain, near), (hull, &self.points), reach, start, out);
                }
            }
        }
    }
}

/// A ball, or an end of a capsule, of `radius` about `centre`.
fn of_end<T: Scalar>(
    pair: &Pair<'_, T>,
    (terrain, near): (&Terrain<T>, &Near),
    (number, centre, radius): (u32, &Vector3<T>, T),
    reach: T,
    start: usize,
    out: &mut Vec<Contact<T>>,
) {
    let second = Feature::Vertex(number);
    let far = radius + reach;
    for &t in &near.triangles {
        if let Some(height) = terrain.over(t as usize, centre)
            && height >= -radius
            && height <= far
        {
            let patch = terrain.patch[t as usize];
            let meeting = Meeting { first: Feature::Patch(patch), second, carrier: Carrier::First(patch) };
            push(pair, meeting, reach, start, out);
        }
    }
    for &r in &near.ridges {
        let ridge = &terrain.ridges[r as usize];
        let [from, to] = ridge.ends.map(|v| terrain.points[v as usize]);
        let along = to - from;
        let share = along.dot(&(centre - from)) / along.dot(&along);
        if !(share >= T::zero() && share <= T::one()) {
            continue;
        }
        if terrain.leaves_ridge(ridge, &(centre - (from + along * share)), T::zero()) {
            let meeting = Meeting { first: Feature::Edge(r), second, carrier: Carrier::Line };
            push(pair, meeting, reach, start, out);
        }
    }
    for &v in &near.corners {
        if terrain.leaves_corner(v, &(centre - terrain.points[v as usize]), T::zero()) {
            let meeting = Meeting { first: Feature::Vertex(v), second, carrier: Carrier::Line };
            push(pair, meeting, reach, start, out);
        }
    }
}

/// The axis of a capsule between its ends, over sharp sides and corners.
fn of_axis<T: Scalar>(
    pair: &Pair<'_, T>,
    (terrain, near): (&Terrain<T>, &Near),
    ends: &[Vector3<T>; 2],
    reach: T,
    start: usize,
    out: &mut Vec<Contact<T>>,
) {
    let axis = ends[1] - ends[0];
    let inside = |share: T| share > T::zero() && share < T::one();
    for &r in &near.ridges {
        let ridge = &terrain.ridges[r as usize];
        let side = ridge.ends.map(|v| terrain.points[v as usize]);
        let ([s, t], _) = segments(side, *ends);
        let away = ends[0] + axis * t - (side[0] + (side[1] - side[0]) * s);
        if inside(s) && inside(t) && terrain.leaves_ridge(ridge, &away, aside::<T>() * away.norm()) {
            let meeting =
                Meeting { first: Feature::Edge(r), second: Feature::Edge(0), carrier: Carrier::Line };
            push(pair, meeting, reach, start, out);
        }
    }
    for &v in &near.corners {
        let apart = terrain.points[v as usize] - ends[0];
        let share = axis.dot(&apart) / axis.dot(&axis);
        let away = axis * share - apart;
        if inside(share) && terrain.leaves_corner(v, &away, T::zero()) {
            let meeting =
                Meeting { first: Feature::Vertex(v), second: Feature::Edge(0), carrier: Carrier::Line };
            push(pair, meeting, reach, start, out);
        }
    }
}

/// A polyhedron whose vertices are at `at`.
fn of_hull<T: Scalar>(
    pair: &Pair<'_, T>,
    (terrain, near): (&Terrain<T>, &Near),
    (hull, at): (&Polyhedron<T>, &[Vector3<T>]),
    reach: T,
    start: usize,
    out: &mut Vec<Contact<T>>,
) {
    let half = lit::<T>(0.5);
    // The least and the largest n·x of the polyhedron.
    let span = |n: &Vector3<T>| {
        at.iter()
            .map(|x| n.dot(x))
            .fold((infinity::<T>(), -infinity::<T>()), |(low, high), x| (min(low, x), max(high, x)))
    };
    for &t in &near.triangles {
        let patch = terrain.patch[t as usize];
        let (normal, offset) = &terrain.planes[patch as usize];
        let (low, high) = span(normal);
        // What is more than half below is on the other side.
        let middle = (low + high) * half;
        if middle < *offset || low > *offset + reach {
            continue;
        }
        for (vertex, x) in (0..).zip(at) {
            // The upper half does not look at the surface.
            if normal.dot(x) <= middle && terrain.over(t as usize, x).is_some_and(|height| height <= reach) {
                let first = Feature::Patch(patch);
                let meeting =
                    Meeting { first, second: Feature::Vertex(vertex), carrier: Carrier::First(patch) };
                push(pair, meeting, reach, start, out);
            }
        }
    }
    let slack = aside::<T>();
    let size = hull.radius();
    for &v in &near.corners {
        let p = pair.bt.turn_back(&(pair.at.turn(&terrain.points[v as usize]) - pair.between));
        let mut best = (0, -infinity::<T>());
        for (f, (normal, &offset)) in hull.normals.iter().zip(&hull.offsets).enumerate() {
            let height = normal.dot(&p) - offset;
            let seen = -pair.at.turn_back(&pair.bt.turn(normal));
            if height > best.1 && terrain.leaves_corner(v, &seen, slack) {
                best = (f, height);
            }
        }
        let (face, height) = best;
        if height <= reach && height >= -size && hull.is_over(face, &p, terrain.tolerance) {
            let second = Feature::Face(face as u32);
            let meeting =
                Meeting { first: Feature::Vertex(v), second, carrier: Carrier::Second(face as u32) };
            push(pair, meeting, reach, start, out);
        }
    }
    if near.ridges.is_empty() {
        return;
    }
    for (j, edge) in (0..).zip(&hull.edges) {
        let [from, to] = edge.vertices.map(|v| at[v as usize]);
        let along = to - from;
        let normals = edge.faces.map(|f| pair.at.turn_back(&pair.bt.turn(&hull.normals[f as usize])));
        // Into the faces beside the edge; the first face has the edge counterclockwise.
        let into = [normals[0].cross(&along), along.cross(&normals[1])]
            .map(|x| direction(&x).unwrap_or_else(Vector3::zeros));
        for &r in &near.ridges {
            let ridge = &terrain.ridges[r as usize];
            let [start_of, end_of] = ridge.ends.map(|v| terrain.points[v as usize]);
            let side = end_of - start_of;
            let cross = side.cross(&along);
            // Edges that are nearly parallel are met at their ends.
            if cross.norm() <= lit::<T>(1e-3) * side.norm() * along.norm() {
                continue;
            }
            let Some(normal) = direction(&cross) else { continue };
            let normal = if normal.dot(&ridge.beside) < T::zero() { -normal } else { normal };
            let faces_away = into.iter().all(|inward| -normal.dot(inward) <= slack)
                && normal.dot(&(normals[0] + normals[1])) < T::zero();
            if !faces_away || !terrain.leaves_ridge(ridge, &normal, slack) {
                continue;
            }
            let Some([s, t]) = nearest_on_lines(side, along, from - start_of) else { continue };
            let inside = |share: T| share > T::zero() && share < T::one();
            let gap = normal.dot(&(from - start_of));
            if inside(s) && inside(t) && gap <= reach && gap >= -size * half {
                let meeting =
                    Meeting { first: Feature::Edge(r), second: Feature::Edge(j), carrier: Carrier::Edges };
                push(pair, meeting, reach, start, out);
            }
        }
    }
}
