//! Bodies that would pass through others within a step, found along their paths.
//!
//! The candidates of a step are those of one configuration. A body that moves further in the step than the other is thick
//! is beyond it in that configuration, or nearer to its far side. Where a pair may move that far, the time of its first
//! meeting on the straight path q + t s, 0 ≤ t ≤ 1, is found by conservative advancement along separating axes: with a
//! separation d > 0 along a fixed axis n, the pair cannot meet before
//!
//! ```text
//!   t + d / (−n·(s_i − s_j) + |Δφ_i| ρ_i + |Δφ_j| ρ_j)
//! ```
//!
//! where ρ is the largest distance of a body's outline from its centre of mass. Without rotation that is Newton's iteration
//! for a convex function, exact for faces in one step. Of what one body meets, later meetings count only where the first
//! may leave it enough speed to come there. Half-planes need none of this: their gap has a sign at any depth.

use nalgebra::Vector2;

use super::RigidBodies;
use super::identity::{Features, Pair};
use super::narrow;
use super::round;
use super::shape::{Contactor, GROUND, Pose};
use crate::contact::{Candidate, ContactId};
use crate::linalg::Symmetric;
use crate::scalar::{Scalar, epsilon, lit};

/// Share of half the thickness of both bodies that a pair may move, or overlap at the end, and be left to the candidates of
/// one configuration.
const SHALLOW: f64 = 0.5;

/// Share of that thickness by which bodies are moved at least, where they slide along each other without meeting.
const COARSEST: f64 = 0.25;

/// Advances up to which the least one is still small: it doubles up to there.
const FINE: i32 = 40;

/// Most advances of a pair; what is not decided then counts as meeting.
const MOST_ADVANCES: usize = 100_000;

/// Sizes for the swept test, and its buffers.
#[derive(Debug)]
pub(super) struct Crossings<T: Scalar> {
    /// Half the least width of every contactor (m), 0 of a point.
    halves: Vec<T>,
    /// Largest distance from the centre of mass that a rotation moves (m).
    levers: Vec<T>,
    /// The least of `halves` that is positive.
    least: T,
    moved: Vec<T>,
    fast: Vec<usize>,
    point: Vec<T>,
    met: Vec<Meeting<T>>,
}

/// A pair that meets on its path, in one or two points.
#[derive(Debug, Clone, Copy)]
struct Meeting<T: Scalar> {
    time: T,
    contactors: [usize; 2],
    candidates: [Option<Candidate<T>>; 2],
    /// Share of the approach of either body that an impact which does not rebound leaves it.
    left: [T; 2],
    dropped: bool,
}

fn abs<T: Scalar>(x: T) -> T {
    nalgebra::ComplexField::abs(x)
}

fn larger<T: Scalar>(x: T, y: T) -> T {
    nalgebra::RealField::max(x, y)
}

fn smaller<T: Scalar>(x: T, y: T) -> T {
    nalgebra::RealField::min(x, y)
}

impl<T: Scalar> Crossings<T> {
    pub(super) fn new(contactors: &[Contactor<T>], dofs: usize) -> Self {
        let half_width = |contactor: &Contactor<T>| -> T {
            // Behind a circle that others are inside of, its gap keeps its sign as far as its radius.
            let Some(polygon) = contactor.polygon() else { return abs(contactor.curvature()) };
            let depth = |(start, normal): (&Vector2<T>, &Vector2<T>)| {
                let depths = polygon.vertices.iter().map(|x| normal.dot(&(start - x)));
                depths.fold(T::zero(), larger)
            };
            let widths = polygon.vertices.iter().zip(&polygon.normals).map(depth);
            widths.reduce(smaller).unwrap_or_else(T::zero) * lit::<T>(0.5)
        };
        let lever = |contactor: &Contactor<T>| {
            if contactor.body == GROUND {
                return T::zero();
            }
            let centre = contactor.centre.norm();
            if contactor.polygon().is_some() { centre + contactor.radius } else { centre }
        };
        let halves: Vec<T> = contactors.iter().map(half_width).collect();
        let positive = halves.iter().copied().filter(|&half| half > T::zero());
        Self {
            levers: contactors.iter().map(lever).collect(),
            least: positive.reduce(smaller).unwrap_or_else(T::infinity_impl),
            halves,
            moved: vec![T::zero(); contactors.len()],
            fast: Vec::with_capacity(contactors.len()),
            point: vec![T::zero(); dofs],
            met: Vec::with_capacity(contactors.len()),
        }
    }
}

/// The three components of a body, `None` of what is fixed.
fn of_body<T>(x: &[T], body: usize) -> Option<&[T]> {
    if body == GROUND { None } else { x.get(3 * body..3 * body + 3) }
}

/// What moves the centre of mass of a body.
fn shift<T: Scalar>(x: &[T], body: usize) -> Vector2<T> {
    of_body(x, body).map_or_else(Vector2::zeros, |x| Vector2::new(x[0], x[1]))
}

/// Centre of mass of the body of a contactor, centre of a fixed one.
fn origin<T: Scalar>(q: &[T], contactor: &Contactor<T>) -> Vector2<T> {
    of_body(q, contactor.body).map_or(contactor.centre, |q| Vector2::new(q[0], q[1]))
}

/// The two contactors of a pair of bodies, the lower first.
fn contactors_of(id: ContactId) -> Option<[usize; 2]> {
    match Pair::of(id) {
        Pair::Discs(a, b) | Pair::Features { a, b, .. } => Some([a.min(b), a.max(b)]),
        Pair::Plane { .. } | Pair::Corner { .. } | Pair::Stop(_) => None,
    }
}

impl<T: Scalar> RigidBodies<T> {
    /// Puts the pairs that meet on the path q + t h v in place of their candidates at its end, and the times t ∈ [0, 1] of
    /// these into `times`.
    pub(super) fn cross(
        &mut self,
        q: &[T],
        (h, v): (T, &[T]),
        asleep: &[bool],
        found: &mut Vec<Candidate<T>>,
        times: &mut Vec<(ContactId, T)>,
    ) {
        if self.sweep.is_empty() {
            return;
        }
        let Self { contactors, crossings: Crossings { moved, levers, least, .. }, .. } = self;
        let mut most = T::zero();
        for ((contactor, moved), &lever) in contactors.iter().zip(moved).zip(&*levers) {
            let Some(v) = of_body(v, contactor.body) else { continue };
            *moved = h * (abs(v[0]) + abs(v[1]) + abs(v[2]) * lever);
            most = larger(most, *moved);
        }
        let none_is_fast = !(most + most > *least * lit::<T>(SHALLOW));
        if none_is_fast || !crate::scalar::all_finite([&most]) {
            return;
        }
        let mut met = std::mem::take(&mut self.crossings.met);
        let mut fast = std::mem::take(&mut self.crossings.fast);
        let mut point = std::mem::take(&mut self.crossings.point);
        self.meetings(q, (h, v), asleep, (&mut fast, &mut point), &mut met);
        met.sort_unstable_by(|a, b| a.time.partial_cmp(&b.time).unwrap_or(std::cmp::Ordering::Equal));
        for i in 0..met.len() {
            met[i].dropped = self.stopped_before(&met[..i], &met[i]);
        }
        for meeting in met.iter().filter(|meeting| !meeting.dropped) {
            let ids = meeting.candidates.iter().flatten().map(|candidate| candidate.id);
            let known = |id: ContactId| found.iter().any(|candidate| candidate.id == id);
            // What touches already and is found at the end by the same features is an ordinary contact.
            if meeting.time == T::zero() && ids.clone().all(known) {
                continue;
            }
            found.retain(|candidate| contactors_of(candidate.id) != Some(meeting.contactors));
            found.extend(meeting.candidates.iter().flatten());
            times.extend(ids.map(|id| (id, meeting.time)));
        }
        met.clear();
        (self.crossings.met, self.crossings.fast, self.crossings.point) = (met, fast, point);
    }

    /// The meetings of all pairs that may move far enough.
    fn meetings(
        &self,
        q: &[T],
        (h, v): (T, &[T]),
        asleep: &[bool],
        (fast, point): (&mut Vec<usize>, &mut Vec<T>),
        met: &mut Vec<Meeting<T>>,
    ) {
        let Crossings { moved, levers, halves, least, .. } = &self.crossings;
        let share = lit::<T>(SHALLOW);
        fast.clear();
        // Of a pair that moves by more than this together, one body moves by more than half of it.
        let quick = |i: usize| moved[i] + moved[i] > *least * share;
        fast.extend((0..moved.len()).filter(|&i| quick(i)));
        point.copy_from_slice(q);
        let sleeps = |body: usize| body == GROUND || asleep.get(body) == Some(&true);
        for &i in &*fast {
            for j in 0..self.contactors.len() {
                let (one, other) = (&self.contactors[i], &self.contactors[j]);
                if one.body == other.body || (quick(j) && j <= i) || sleeps(one.body) && sleeps(other.body) {
                    continue;
                }
                if !self.is_free(one.body) && !self.is_free(other.body) {
                    continue;
                }
                let Some(interface) = self.interfaces.between(one.group, other.group) else { continue };
                let thin = halves[i] + halves[j];
                if !(moved[i] + moved[j] > thin * share) || thin == T::zero() {
                    continue;
                }
                // Circles about the centres of mass, or about what is fixed, on a straight path.
                let between = origin(q, one) - origin(q, other);
                let path = (shift(v, one.body) - shift(v, other.body)) * h;
                let length = path.norm_squared();
                let nearest = if length > T::zero() { -between.dot(&path) / length } else { T::zero() };
                let nearest = between + path * smaller(larger(nearest, T::zero()), T::one());
                let size = |i: usize| {
                    let contactor = &self.contactors[i];
                    let fixed = contactor.body == GROUND;
                    let centre = if fixed { T::zero() } else { contactor.centre.norm() };
                    larger(levers[i], centre + contactor.radius)
                };
                if nearest.norm() > (size(i) + size(j)) * lit::<T>(1.001) {
                    continue;
                }
                let (a, b) = (i.min(j), i.max(j));
                met.extend(self.meeting([a, b], interface, q, (h, v), point));
                for body in [one.body, other.body].into_iter().filter(|&body| body != GROUND) {
                    point[3 * body..3 * body + 3].copy_from_slice(&q[3 * body..3 * body + 3]);
                }
            }
        }
    }

    /// Where a pair first meets on its path and would overlap by more than what is shallow at its end.
    fn meeting(
        &self,
        [i, j]: [usize; 2],
        interface: usize,
        q: &[T],
        (h, v): (T, &[T]),
        point: &mut [T],
    ) -> Option<Meeting<T>> {
        let Crossings { halves, levers, .. } = &self.crossings;
        let (one, other) = (self.contactors[i].body, self.contactors[j].body);
        let thin = halves[i] + halves[j];
        let (first, second) = (&self.contactors[i], &self.contactors[j]);
        let size = levers[i] + levers[j] + origin(q, first).norm() + origin(q, second).norm();
        let close = larger(thin * lit::<T>(1e-9), size * epsilon::<T>() * lit::<T>(64.0));
        let path = (shift(v, one) - shift(v, other)) * h;
        let turn = |body: usize| of_body(v, body).map_or_else(T::zero, |v| abs(v[2]));
        let spin = h * (turn(one) * levers[i] + turn(other) * levers[j]);
        let mut time = T::zero();
        for advance in 0..=MOST_ADVANCES {
            for body in [one, other].into_iter().filter(|&body| body != GROUND) {
                for dof in 3 * body..3 * body + 3 {
                    point[dof] = q[dof] + time * h * v[dof];
                }
            }
            let (normal, separation) = self.separation(i, j, point);
            let meets = separation <= close || advance == MOST_ADVANCES;
            if meets {
                let mut candidates = [None; 2];
                let mut left = [T::zero(); 2];
                self.features(i, j, point, larger(separation, T::zero()) + close, |pair, gap| {
                    let (rate, shares) = self.approach(pair, one, point, (h, v));
                    let end = gap + rate * (T::one() - time);
                    if rate < T::zero() && end < -thin * lit::<T>(SHALLOW) {
                        let place = usize::from(candidates[0].is_some());
                        candidates[place] = Some(Candidate { id: pair.id(), interface, gap: end });
                        left = [larger(left[0], shares[0]), larger(left[1], shares[1])];
                    }
                });
                if candidates[0].is_some() {
                    return Some(Meeting { time, contactors: [i, j], candidates, left, dropped: false });
                }
            }
            let closing = spin - normal.dot(&path);
            if !(closing > T::zero()) {
                return None;
            }
            let halvings = if meets { 0 } else { (FINE - advance.min(FINE as usize) as i32).max(0) };
            let floor = thin * lit::<T>(COARSEST * 0.5_f64.powi(halvings));
            time += larger(separation, floor) / closing;
            if !(time < T::one()) {
                return None;
            }
        }
        None
    }

    /// An axis from the second contactor to the first, and their separation along it, negative where they overlap.
    fn separation(&self, i: usize, j: usize, q: &[T]) -> (Vector2<T>, T) {
        let (one, other) = (&self.contactors[i], &self.contactors[j]);
        let poses = || (Pose::of(one.body, q), Pose::of(other.body, q));
        let to_disc = |polygon, pose: &Pose<T>, disc: &Contactor<T>| {
            let centre = disc.position(q);
            let (features, gap) = narrow::disc((polygon, pose), &centre, disc.radius);
            let axis = match features {
                Features::VertexDisc(vertex) => {
                    super::direction(centre - pose.place(&polygon.vertices[vertex]), Vector2::y)
                }
                Features::EdgeDisc(edge) | Features::VertexEdge(_, edge) | Features::EdgeVertex(_, edge) => {
                    pose.turn(&polygon.normals[edge])
                }
            };
            (axis, gap)
        };
        match (one.polygon(), other.polygon()) {
            (None, None) => {
                let between = one.position(q) - other.position(q);
                (super::direction(between, Vector2::y), between.norm() - one.radius - other.radius)
            }
            (Some(a), None) => {
                let (axis, gap) = to_disc(a, &poses().0, other);
                (-axis, gap)
            }
            (None, Some(b)) => to_disc(b, &poses().1, one),
            (Some(a), Some(b)) => {
                let (at, bt) = poses();
                let (edge_a, from_a) = narrow::largest_separation((a, &at), (b, &bt));
                let (edge_b, from_b) = narrow::largest_separation((b, &bt), (a, &at));
                if from_b > from_a {
                    (bt.turn(&b.normals[edge_b]), from_b)
                } else {
                    (-at.turn(&a.normals[edge_a]), from_a)
                }
            }
        }
    }

    /// Calls `meet` for the features of a pair that are within `reach`.
    fn features(&self, i: usize, j: usize, q: &[T], reach: T, mut meet: impl FnMut(Pair, T)) {
        let (one, other) = (&self.contactors[i], &self.contactors[j]);
        let (at, bt) = (Pose::of(one.body, q), Pose::of(other.body, q));
        match (one.polygon(), other.polygon()) {
            (None, None) => {
                round::contacts((i, one), (j, other), (one.position(q), other.position(q)), q, meet);
            }
            (Some(a), Some(b)) => {
                let size = one.radius + other.radius;
                narrow::polygons((a, &at), (b, &bt), size, reach, |features, gap| {
                    meet(Pair::Features { a: i, b: j, features }, gap);
                });
            }
            (Some(a), None) => {
                let centre = other.position(q);
                let (features, gap) = narrow::disc((a, &at), &centre, other.radius);
                if round::shows((a, &at), (other, &centre), features, q) {
                    meet(Pair::Features { a: i, b: j, features }, gap);
                }
            }
            (None, Some(b)) => {
                let centre = one.position(q);
                let (features, gap) = narrow::disc((b, &bt), &centre, one.radius);
                if round::shows((b, &bt), (one, &centre), features, q) {
                    meet(Pair::Features { a: j, b: i, features }, gap);
                }
            }
        }
    }

    /// Change of the gap over the whole path at its present rate, and the shares of it that an impact without rebound
    /// leaves either body, `first` that of the first contactor.
    fn approach(&self, pair: Pair, first: usize, q: &[T], (h, v): (T, &[T])) -> (T, [T; 2]) {
        let (sides, normal) = self.sides(pair, q);
        let mut rate = T::zero();
        let mut mobility = [T::zero(); 2];
        for (side, (body, arm)) in sides.iter().enumerate() {
            let Some(v) = of_body(v, *body) else { continue };
            let velocity = Vector2::new(v[0] - v[2] * arm.y, v[1] + v[2] * arm.x).dot(&normal);
            rate += if side == 0 { velocity } else { -velocity };
            if let (Symmetric::Diagonal(mass), true) = (&self.mass, self.is_free(*body)) {
                let turn = arm.x * normal.y - arm.y * normal.x;
                mobility[side] = T::one() / mass[3 * body] + turn * turn / mass[3 * body + 2];
            }
        }
        let sum = mobility[0] + mobility[1];
        let [one, other] = [mobility[1] / sum, mobility[0] / sum];
        (rate * h, if sides[0].0 == first { [one, other] } else { [other, one] })
    }

    /// Whether the bodies that would make a meeting have been stopped by earlier ones.
    fn stopped_before(&self, earlier: &[Meeting<T>], meeting: &Meeting<T>) -> bool {
        let moved = &self.crossings.moved;
        let [a, b] = meeting.contactors;
        let most = larger(moved[a], moved[b]);
        let stops = |contactor: usize| {
            let body = self.contactors[contactor].body;
            earlier.iter().filter(|earlier| !earlier.dropped).any(|earlier| {
                let side = earlier.contactors.iter().position(|&other| self.contactors[other].body == body);
                let rest = T::one() - earlier.time;
                side.is_some_and(|side| earlier.left[side] * rest < meeting.time - earlier.time)
            })
        };
        [a, b].into_iter().all(|i| moved[i] < most * lit::<T>(0.25) || stops(i))
    }
}
