//! A page read back, and a run made up for one.

use std::io::Read as _;
use std::path::Path;

use base64::Engine as _;
use nalgebra::SVector;
use nonsmooth::contact::ContactId;
use nonsmooth::energy::{Balance, Energies};
use nonsmooth::linalg::Symmetric;
use nonsmooth::observe::{Frame, HtmlPage, Observer, RunInfo, Units};
use nonsmooth::scheme::{ContactStep, State, Step};
use nonsmooth::system::{ContactPlace, Contacts, Describe, Dynamics, Forces, Scales, Solid, Surface};
use serde_json::Value;

/// A page before its data, the data, and the page after it.
pub(crate) fn split(text: &str) -> (&str, &str, &str) {
    let (before, rest) =
        text.split_once("<script id=\"data\" type=\"text/plain\">").expect("a place for the data");
    let (data, after) = rest.split_once("</script>").expect("the end of the data");
    (before, data, after)
}

/// What is in a page.
pub(crate) struct Page {
    pub(crate) head: Value,
    pub(crate) frames: usize,
    pub(crate) bodies: usize,
    pub(crate) times: Vec<f64>,
    /// Kinetic, elastic, potential.
    pub(crate) energies: [Vec<f64>; 3],
    /// Corner and quantum of each body.
    pub(crate) grids: Vec<[f64; 4]>,
    /// Seven numbers for each frame, by body.
    poses: Vec<Vec<[u16; 7]>>,
    /// The point and the percussion of each force, by frame.
    pub(crate) forces: Vec<Vec<([f32; 3], [f32; 3])>>,
}

struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (taken, rest) = self.0.split_first_chunk().expect("more data");
        self.0 = rest;
        *taken
    }

    fn floats(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| f64::from_le_bytes(self.take())).collect()
    }

    fn counts(&mut self, count: usize) -> Vec<u32> {
        (0..count).map(|_| u32::from_le_bytes(self.take())).collect()
    }

    /// Numbers whose low bytes stand before their high bytes.
    fn numbers(&mut self, count: usize) -> Vec<u16> {
        let (low, rest) = self.0.split_at(count);
        let (high, rest) = rest.split_at(count);
        self.0 = rest;
        low.iter().zip(high).map(|(&low, &high)| u16::from_le_bytes([low, high])).collect()
    }
}

fn unfolded(x: u16) -> u16 {
    (x >> 1) ^ (x & 1).wrapping_neg()
}

impl Page {
    pub(crate) fn read(path: &Path) -> Self {
        let text =
            std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let packed = base64::engine::general_purpose::STANDARD.decode(split(&text).1).expect("base64");
        let mut all = Vec::new();
        flate2::read::ZlibDecoder::new(packed.as_slice()).read_to_end(&mut all).expect("deflated data");
        let mut bytes = Bytes(&all);
        let size = u32::from_le_bytes(bytes.take()) as usize;
        let (head, rest) = bytes.0.split_at(size);
        let head: Value = serde_json::from_slice(head).expect("a header");
        bytes.0 = rest;
        let count = |name: &str| head[name].as_u64().expect("a count") as usize;
        let (frames, bodies, forces) = (count("frames"), count("bodies"), count("forces"));
        let times = bytes.floats(frames);
        let energies = [0; 3].map(|_| bytes.floats(frames));
        let grids = (0..bodies).map(|_| bytes.floats(4).try_into().expect("four")).collect();
        let (modes, rest) = bytes.0.split_at(7 * bodies);
        bytes.0 = rest;
        let total = modes.iter().map(|&mode| if mode == 0 { 1 } else { frames }).sum();
        let mut numbers = bytes.numbers(total).into_iter();
        let mut poses = vec![vec![[0; 7]; frames]; bodies];
        for (stream, &mode) in modes.iter().enumerate() {
            let (mut one, mut two) = (0_u16, 0_u16);
            for (k, pose) in poses[stream / 7].iter_mut().enumerate() {
                // What never changes is there once, as it is.
                let x = match (mode, k) {
                    (0, 0) => numbers.next().expect("a number"),
                    (0, _) => one,
                    _ => {
                        let guess =
                            if mode == 2 && k > 1 { one.wrapping_mul(2).wrapping_sub(two) } else { one };
                        unfolded(numbers.next().expect("a number")).wrapping_add(guess)
                    }
                };
                (one, two) = (x, one);
                pose[stream % 7] = one;
            }
        }
        let of_frame = bytes.counts(frames);
        let left_out = bytes.counts(frames);
        assert!(left_out.iter().zip(&of_frame).all(|(&left, &count)| left == 0 || count <= 800));
        let scales: Vec<f32> = bytes.counts(frames).into_iter().map(f32::from_bits).collect();
        let gaps = bytes.counts(forces);
        let numbers = bytes.numbers(6 * forces);
        assert!(bytes.0.is_empty(), "nothing is left over");
        let corner = |name: &str, i: usize| head[name][i].as_f64().expect("a number");
        let (mut i, mut last) = (0, std::collections::HashMap::new());
        let mut all_forces = Vec::new();
        for (&count, scale) in of_frame.iter().zip(scales) {
            let (mut name, mut now) = (0, std::collections::HashMap::new());
            for _ in 0..count {
                name += gaps[i];
                let old = last.get(&name).copied().unwrap_or([0_u16; 6]);
                let values: [u16; 6] =
                    std::array::from_fn(|j| old[j].wrapping_add(unfolded(numbers[j * forces + i])));
                now.insert(name, values);
                i += 1;
            }
            let force = |values: &[u16; 6]| {
                let point = std::array::from_fn(|j| {
                    let (low, high) = (corner("force_low", j), corner("force_high", j));
                    (low + f64::from(values[j]) / 65535.0 * (high - low)) as f32
                });
                (point, std::array::from_fn(|j| (f32::from(values[3 + j]) - 32768.0) / 32767.0 * scale))
            };
            all_forces.push(now.values().map(force).collect());
            last = now;
        }
        Self { frames, bodies, times, energies, grids, poses, forces: all_forces, head }
    }

    /// Position and unit quaternion (w, x, y, z) of a body in a frame.
    pub(crate) fn pose(&self, frame: usize, body: usize) -> ([f64; 3], [f64; 4]) {
        let (pose, grid) = (self.poses[body][frame], self.grids[body]);
        let position = std::array::from_fn(|i| grid[i] + f64::from(pose[i]) * grid[3]);
        let mut turn: Vec<f64> =
            pose[3..6].iter().map(|&x| (f64::from(x) / 65535.0 - 0.5) * std::f64::consts::SQRT_2).collect();
        let rest = 1.0 - turn.iter().map(|x| x * x).sum::<f64>();
        turn.insert(usize::from(pose[6]), rest.max(0.0).sqrt());
        (position, turn.try_into().expect("four"))
    }
}

/// Where a marble is and how it is turned, by its number and the time.
type Seen = fn(usize, f64) -> ([f64; 3], [f64; 4]);

/// A number in [0, 1) of two others.
fn chance(body: usize, what: usize) -> f64 {
    let mut x = (body as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ (what as u64 + 1).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ x >> 29).wrapping_mul(0x94d0_49bb_1331_11eb);
    (x ^ x >> 32) as u32 as f64 / 4_294_967_296.0
}

/// A marble bounces on the floor, drifts, and spins about an axis of its own, another way after each bounce.
fn motion(body: usize, time: f64) -> ([f64; 3], [f64; 4]) {
    let rise = 0.2 + chance(body, 0);
    let flight = 2.0 * (2.0 * rise / 9.81).sqrt();
    let bounce = (time / flight + chance(body, 1)).floor();
    let t = (time / flight + chance(body, 1) - bounce) * flight;
    let height = 0.5 * 9.81 * t * (flight - t);
    let drift = |what: usize| {
        let x = chance(body, what) + 0.3 * (chance(body, what + 7) - 0.5) * time;
        // Back and forth between walls.
        4.0 * (x.rem_euclid(2.0) - 1.0).abs()
    };
    let kind = 20 + 4 * bounce as usize;
    let axis: [f64; 3] = std::array::from_fn(|i| chance(body, kind + i) - 0.5);
    let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (sin, cos) = (0.5 * (2.0 + 6.0 * chance(body, kind + 3)) * t).sin_cos();
    let [x, y, z] = axis.map(|x| x / length * sin);
    ([drift(2), drift(3), 0.05 + height], [cos, x, y, z])
}

/// Cubes of an edge of 0.1 m that say where they are; configuration: the time.
#[derive(Debug)]
struct Marbles {
    bodies: usize,
    mass: Symmetric<f64>,
    forces: Forces<f64>,
}

impl Dynamics<f64> for Marbles {
    fn mass(&self) -> &Symmetric<f64> {
        &self.mass
    }

    fn forces(&self) -> &Forces<f64> {
        &self.forces
    }

    fn scales(&self, q: &[f64], v: &[f64]) -> Scales<f64> {
        Scales::of(q, v)
    }
}

impl Contacts<f64, 3> for Marbles {}

impl Describe<f64> for Marbles {
    fn solids(&self) -> Vec<Solid> {
        let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(|x| 0.1 * (f64::from(x) - 0.5));
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let surface = Surface {
            points: (0..8).map(corner).collect(),
            faces: faces.map(Vec::from).into(),
            ..Surface::default()
        };
        let solid = |body| Solid {
            name: format!("marble {body}"),
            body: Some(body),
            surface: surface.clone(),
            endless: false,
        };
        let square = Surface {
            points: vec![[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]],
            faces: vec![vec![0, 1, 2, 3]],
            ..Surface::default()
        };
        let floor = Solid { name: "floor".into(), body: None, surface: square, endless: true };
        (0..self.bodies).map(solid).chain([floor]).collect()
    }

    fn body_pose(&self, body: usize, q: &[f64]) -> ([f64; 3], [f64; 4]) {
        motion(body, q[2])
    }

    fn contact_place(&self, contact: ContactId, q: &[f64]) -> Option<ContactPlace> {
        let ([x, y, z], _) = motion(contact.number() as usize % self.bodies, q[2]);
        let axes = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        Some(ContactPlace { point: [x, y, z - 0.05], axes })
    }
}

/// Writes the page of marbles that bounce for two seconds; the wall time (s) that took, and what they do.
pub(crate) fn marbles(bodies: usize, steps: usize, path: &Path) -> (f64, Seen) {
    let mass = Symmetric::diagonal(vec![1.0; 3]).expect("a mass");
    let system = Marbles { bodies, mass, forces: Forces::constant(vec![0.0, 0.0, -9.81]) };
    let step = 2.0 / steps as f64;
    let info = RunInfo {
        law: "none".into(),
        solver: "none".into(),
        interface_laws: Vec::new(),
        theta: 0.5,
        step,
        scalar: "f64",
        rows: Default::default(),
    };
    let mut page = HtmlPage::new(path, "Marbles", Units::SI);
    let clock = std::time::Instant::now();
    let mut outside = 0.0;
    for k in 0..=steps {
        let making = clock.elapsed();
        let time = k as f64 * step;
        let state = State { index: k, time, q: vec![0.0, 0.0, time], v: vec![0.0; 3] };
        // A tenth of all push, others in every step.
        let push = |i: usize| {
            let body = (i * 10 + k % 10) % bodies.max(1);
            let percussion = SVector::from([chance(body, k), chance(body, k + 1) - 0.5, 0.1]);
            ContactStep {
                id: ContactId::new(body as u64),
                interface: 0,
                gap: 0.0,
                before: SVector::zeros(),
                after: SVector::zeros(),
                percussion: percussion * step,
                normal_work: 0.0,
                tangential_work: 0.0,
                work_bound: 0.0,
                theta: 0.5,
                lasting: false,
            }
        };
        let contacts = if k == 0 { Vec::new() } else { (0..bodies / 10).map(push).collect() };
        let kinetic = 1.0 + (3.0 * time).sin();
        let energies = Energies { kinetic, elastic: 0.0, potential: 3.0 - kinetic - 0.2 * time };
        let step = Step { contacts, energies, balance: Balance::default(), solution: None };
        outside += (clock.elapsed() - making).as_secs_f64();
        let frame: Frame<'_, f64, 3> = Frame { system: &system, state: &state, step: &step };
        match k {
            0 => page.begin(&info, frame),
            _ => page.step(frame),
        }
        .expect("a frame");
        if k == steps {
            page.end(frame).expect("a page");
        }
    }
    assert_eq!(page.written(), Some(path));
    (clock.elapsed().as_secs_f64() - outside, motion)
}
