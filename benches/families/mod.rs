//! Two families of problems that grow, with fixed seeds: masonry walls and settled packings of spheres.
//!
//! Both give H, M̂ (diagonal, six velocities per body), b = H v_free and μ: the bodies fall under gravity for one step
//! and are shaken at random.

use nalgebra::{SVector, Vector3};
use nonsmooth::cone::{ConeProblem, FactoredDelassus, Form};
use nonsmooth::linalg::{BlockRows, Symmetric};

/// xorshift64*.
pub(crate) struct Random(u64);

impl Random {
    /// A generator that gives the same numbers everywhere.
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed ^ 0x9e37_79b9_7f4a_7c15)
    }

    /// Uniform on [−1, 1[.
    pub(crate) fn symmetric(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        2.0 * (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64 - 1.0
    }
}

/// A body: centre (m), mass (kg), principal moments of inertia (kg m²) along the axes.
struct Body {
    centre: Vector3<f64>,
    mass: f64,
    inertia: Vector3<f64>,
}

/// A contact at `point` with normal `normal` from body `below` (none: the ground) to body `above`.
struct Contact {
    above: usize,
    below: Option<usize>,
    point: Vector3<f64>,
    normal: Vector3<f64>,
}

/// The data of a problem, before a form is chosen.
pub(crate) struct Family {
    bodies: Vec<Body>,
    contacts: Vec<Contact>,
    free: Vec<f64>,
    friction: f64,
}

/// Duration of the step (s) and gravity (m/s²).
const STEP: f64 = 1e-2;
const GRAVITY: f64 = 9.81;

/// A wall in running bond, `courses` high and `bricks` long, of 0.2×0.1×0.1 m bricks: four points per bed joint.
pub(crate) fn wall(courses: usize, bricks: usize, seed: u64) -> Family {
    let mut random = Random::new(seed);
    let (length, side) = (0.2, 0.1);
    let (mut bodies, mut contacts) = (Vec::new(), Vec::new());
    for course in 0..courses {
        for k in 0..bricks {
            let x = (k as f64 + 0.5 * (course % 2) as f64) * length;
            let z = (course as f64 + 0.5) * side;
            let mass = 2000.0 * length * side * side * (1.0 + 0.2 * random.symmetric());
            let (long, short) = (length * length, side * side);
            let inertia = Vector3::new(2.0 * short, long + short, long + short) * (mass / 12.0);
            let above = bodies.len();
            bodies.push(Body { centre: Vector3::new(x, 0.0, z), mass, inertia });
            for half in [-1.0, 1.0] {
                // The brick under this half, in the course below.
                let shift = if course % 2 == 0 { half < 0.0 } else { half > 0.0 };
                let under = match (course % 2 == 0, shift) {
                    (true, true) => k.checked_sub(1),
                    (false, true) => Some(k + 1).filter(|&k| k < bricks),
                    _ => Some(k),
                };
                let below = if course == 0 { None } else { under.map(|u| (course - 1) * bricks + u) };
                if course > 0 && below.is_none() {
                    continue;
                }
                for (i, j) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                    let point = Vector3::new(
                        x + half * 0.25 * length + i * 0.22 * length,
                        j * 0.45 * side,
                        course as f64 * side,
                    );
                    contacts.push(Contact { above, below, point, normal: Vector3::z() });
                }
            }
        }
    }
    Family::shaken(bodies, contacts, 0.6, &mut random)
}

/// About `layers`·`across`² spheres of 0.1 m in hexagonal layers on a floor, slightly disordered.
pub(crate) fn packing(layers: usize, across: usize, seed: u64) -> Family {
    let mut random = Random::new(seed);
    let radius = 0.05;
    let (row, layer) = (3f64.sqrt(), (8.0 / 3.0f64).sqrt());
    let mut bodies = Vec::new();
    for l in 0..layers {
        for j in 0..across {
            for i in 0..across {
                let odd = (l % 2) as f64;
                let x = 2.0 * i as f64 + (j % 2) as f64 + odd;
                let y = row * (j as f64 + odd / 3.0);
                let z = 1.0 + layer * l as f64;
                let noise = Vector3::from_fn(|_, _| 0.01 * random.symmetric());
                let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius;
                let inertia = Vector3::repeat(0.4 * mass * radius * radius);
                bodies.push(Body { centre: (Vector3::new(x, y, z) + noise) * radius, mass, inertia });
            }
        }
    }
    let mut contacts = Vec::new();
    let index = |l: usize, j: usize, i: usize| (l * across + j) * across + i;
    for l in 0..layers {
        for j in 0..across {
            for i in 0..across {
                let above = index(l, j, i);
                if l == 0 {
                    let point = bodies[above].centre - Vector3::z() * radius;
                    contacts.push(Contact { above, below: None, point, normal: Vector3::z() });
                }
                for below_l in [l, l.wrapping_sub(1)].into_iter().filter(|&l| l < layers) {
                    for jj in j.saturating_sub(1)..(j + 2).min(across) {
                        for ii in i.saturating_sub(1)..(i + 2).min(across) {
                            let below = index(below_l, jj, ii);
                            let between = bodies[above].centre - bodies[below].centre;
                            if below < above && between.norm() < 2.03 * radius {
                                let normal = between.normalize();
                                let point = bodies[below].centre + normal * radius;
                                contacts.push(Contact { above, below: Some(below), point, normal });
                            }
                        }
                    }
                }
            }
        }
    }
    Family::shaken(bodies, contacts, 0.3, &mut random)
}

impl Family {
    fn shaken(bodies: Vec<Body>, contacts: Vec<Contact>, friction: f64, random: &mut Random) -> Self {
        let impulse = GRAVITY * STEP;
        let mut free = Vec::new();
        for _ in &bodies {
            let shake: [f64; 6] = std::array::from_fn(|_| random.symmetric() * impulse);
            free.extend([0.5 * shake[0], 0.2 * shake[1], -impulse + 0.1 * shake[2]]);
            free.extend(shake[3..].iter().map(|x| 2.0 * x));
        }
        Self { bodies, contacts, free, friction }
    }

    /// The same bodies with about this share of the contacts.
    pub(crate) fn thinned(mut self, share: f64) -> Self {
        let mut random = Random::new(23);
        self.contacts.retain(|_| 0.5 + 0.5 * random.symmetric() < share);
        self
    }

    /// Velocities per scalar percussion.
    pub(crate) fn ratio(&self) -> f64 {
        2.0 * self.bodies.len() as f64 / self.contacts.len() as f64
    }

    /// Number of contacts.
    pub(crate) fn contacts(&self) -> usize {
        self.contacts.len()
    }

    fn jacobian(&self) -> BlockRows<f64, 3> {
        let mut h = BlockRows::new();
        for contact in &self.contacts {
            let n = contact.normal;
            let helper = if n.z.abs() > 0.9 { Vector3::x() } else { Vector3::z() };
            let t1 = (helper - n * helper.dot(&n)).normalize();
            let frame = [n, t1, n.cross(&t1)];
            h.start_row();
            for (sign, body) in [(1.0, Some(contact.above)), (-1.0, contact.below)] {
                let Some(body) = body else { continue };
                let arm = contact.point - self.bodies[body].centre;
                for k in 0..3 {
                    h.push(6 * body + k, SVector::from(frame.map(|axis| sign * axis[k])));
                }
                for k in 0..3 {
                    h.push(6 * body + 3 + k, SVector::from(frame.map(|axis| sign * arm.cross(&axis)[k])));
                }
            }
        }
        h
    }

    /// The problem in the given form; the free velocities are changed at random such that ‖δb‖ = `perturbation` ‖b‖.
    pub(crate) fn problem(&self, form: Form, perturbation: f64) -> ConeProblem<f64, 3> {
        let h = self.jacobian();
        let mass =
            self.bodies.iter().flat_map(|b| [b.mass, b.mass, b.mass, b.inertia.x, b.inertia.y, b.inertia.z]);
        let mass = Symmetric::diagonal(mass.collect()).expect("positive masses");
        let operator = FactoredDelassus::new(&h, &mass, 6).expect("a body has six velocities");
        let mut random = Random::new(17);
        let change: Vec<f64> = self.free.iter().map(|v| v.abs() * random.symmetric()).collect();
        let local = |v: &[f64]| -> Vec<SVector<f64, 3>> {
            (0..self.contacts.len()).map(|i| h.velocity(i, v)).collect()
        };
        let norm = |b: &[SVector<f64, 3>]| b.iter().map(SVector::norm_squared).sum::<f64>().sqrt();
        let (mut b, change) = (local(&self.free), local(&change));
        let scale = perturbation * norm(&b) / norm(&change);
        b.iter_mut().zip(&change).for_each(|(b, change)| *b += change * scale);
        ConeProblem::factored(operator, form, b, vec![self.friction; self.contacts.len()]).expect("a problem")
    }
}
