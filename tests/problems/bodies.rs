//! Rigid boxes: masses, contact points, velocities, and the global problem they make.

use nonsmooth::fclib::{Data, Global, Info, Problem, SparseMatrix};

/// Half width, half depth, half height of a brick (m).
const HALF: [f64; 3] = [0.1, 0.05, 0.03];
/// Density (kg/m³, per metre of depth in the plane).
const DENSITY: f64 = 2000.0;
/// g h: the velocity gravity adds within a step (m/s).
const FALL: f64 = 9.81 * 5e-3;

/// Bodies and contacts; the third axis of space, the second of the plane, is vertical, and every normal points up.
pub(crate) struct Rig<const D: usize> {
    centres: Vec<[f64; 3]>,
    velocities: Vec<Vec<f64>>,
    contacts: Vec<Contact>,
}

struct Contact {
    point: [f64; 3],
    above: usize,
    below: Option<usize>,
    friction: f64,
}

/// Degrees of freedom of a body.
const fn freedoms(dimension: usize) -> usize {
    if dimension == 2 { 3 } else { 6 }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Directions (N, T) or (N, T1, T2) in space (x, y, z); the plane is (x, z), turning about −y.
fn frame(dimension: usize) -> &'static [[f64; 3]] {
    let axes: &[[f64; 3]] = &[[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    &axes[..dimension]
}

impl<const D: usize> Rig<D> {
    /// Generalised direction of `axis` at `point` for a body centred at `centre`: (e, (P − C) × e).
    fn direction(centre: [f64; 3], point: [f64; 3], axis: [f64; 3]) -> Vec<f64> {
        let arm = [point[0] - centre[0], point[1] - centre[1], point[2] - centre[2]];
        let moment = cross(arm, axis);
        if D == 2 { vec![axis[0], axis[2], -moment[1]] } else { axis.into_iter().chain(moment).collect() }
    }

    fn masses() -> Vec<f64> {
        let [a, b, c] = HALF;
        let square = |x: f64| x * x;
        if D == 2 {
            let mass = DENSITY * 4.0 * a * c;
            vec![mass, mass, mass * (square(a) + square(c)) / 3.0]
        } else {
            let mass = DENSITY * 8.0 * a * b * c;
            let inertia = |x: f64, y: f64| mass * (square(x) + square(y)) / 3.0;
            vec![mass, mass, mass, inertia(b, c), inertia(a, c), inertia(a, b)]
        }
    }

    /// M, H, f = M v, w = 0.
    pub(crate) fn problem(&self) -> Problem {
        let step = freedoms(D);
        let n = step * self.centres.len();
        let masses = Self::masses();
        let mass: Vec<_> = (0..n).map(|i| (i as u32, i as u32, masses[i % step])).collect();
        let force = (0..n).map(|i| masses[i % step] * self.velocities[i / step][i % step]).collect();
        let mut entries = Vec::new();
        for (k, contact) in self.contacts.iter().enumerate() {
            let sides = [(Some(contact.above), 1.0), (contact.below, -1.0)];
            for (body, sign) in sides.into_iter().filter_map(|(body, sign)| Some((body?, sign))) {
                for (j, &axis) in frame(D).iter().enumerate() {
                    let direction = Self::direction(self.centres[body], contact.point, axis);
                    entries.extend(
                        direction
                            .iter()
                            .enumerate()
                            .filter(|&(_, &x)| x != 0.0)
                            .map(|(i, x)| ((step * body + i) as u32, (D * k + j) as u32, sign * x)),
                    );
                }
            }
        }
        let local = D * self.contacts.len();
        let data = Data::Global(Global {
            mass: SparseMatrix::from_entries(n, n, &mass),
            directions: SparseMatrix::from_entries(n, local, &entries),
            force,
            velocity: vec![0.0; local],
            bilateral: None,
        });
        let friction = self.contacts.iter().map(|contact| contact.friction).collect();
        let info = Info {
            math_info: Some("lengths in m, masses in kg, velocities in m/s".into()),
            ..Info::default()
        };
        Problem { info, dimension: D, friction, data, guesses: Vec::new(), solution: None }
    }
}

/// One brick on `points` points of the plane, arriving with `velocity` (x, z, turn) or (x, y, z, turns).
///
/// One point lies under the centre, several are spread along x, and to both sides in depth.
pub(crate) fn box_on_plane<const D: usize>(points: usize, velocity: &[f64], friction: f64) -> Rig<D> {
    let place = |k: usize| match points {
        1 => [0.0; 3],
        _ => {
            let depth = if D == 2 { 0.0 } else { [-1.0, 1.0][k % 2] * HALF[1] };
            [HALF[0] * (2.0 * k as f64 / (points - 1) as f64 - 1.0), depth, 0.0]
        }
    };
    let contacts =
        (0..points).map(|k| Contact { point: place(k), above: 0, below: None, friction }).collect();
    Rig { centres: vec![[0.0, 0.0, HALF[2]]], velocities: vec![velocity.to_vec()], contacts }
}

/// The first `contacts` contacts of a stepped wall with `width` bricks in its lowest row and one less in each row above,
/// shaken from side to side; μ is a function of the contact.
///
/// A brick stands on two bricks (or on the ground at its two ends), in space on both edges of the overlap.
pub(crate) fn wall<const D: usize>(width: usize, contacts: usize, friction: &dyn Fn(usize) -> f64) -> Rig<D> {
    let [a, b, c] = HALF;
    let mut rig = Rig { centres: Vec::new(), velocities: Vec::new(), contacts: Vec::new() };
    let mut below: Vec<usize> = Vec::new();
    for row in 0..width {
        let mut bricks = Vec::new();
        for j in 0..width - row {
            let body = rig.centres.len();
            let centre = [a * (2 * j + row) as f64, 0.0, c * (2 * row + 1) as f64];
            // A different push for every brick, from a small multiplicative generator: in [−1, 1].
            let shake = |k: usize| ((body * 7 + k * 3 + 1) * 37 % 101) as f64 / 50.0 - 1.0;
            let velocity = match D {
                2 => vec![0.05 * shake(0), -FALL, 0.2 * shake(1)],
                _ => vec![
                    0.05 * shake(0),
                    0.05 * shake(1),
                    -FALL,
                    0.2 * shake(2),
                    0.2 * shake(3),
                    0.2 * shake(4),
                ],
            };
            for side in [-1.0, 1.0] {
                // The middle of the overlap with the brick below, or the end of a brick on the ground.
                let x = centre[0] + side * if row == 0 { a } else { 0.5 * a };
                let under = (row > 0).then(|| below[if side < 0.0 { j } else { j + 1 }]);
                let depths: &[f64] = if D == 2 { &[0.0] } else { &[-b, b] };
                for &y in depths {
                    let point = [x, y, centre[2] - c];
                    rig.contacts.push(Contact { point, above: body, below: under, friction: 0.0 });
                }
            }
            rig.centres.push(centre);
            rig.velocities.push(velocity);
            bricks.push(body);
        }
        below = bricks;
    }
    assert!(rig.contacts.len() >= contacts, "a wall {width} bricks wide has {} contacts", rig.contacts.len());
    rig.contacts.truncate(contacts);
    rig.contacts.iter_mut().enumerate().for_each(|(k, contact)| contact.friction = friction(k));
    rig
}
