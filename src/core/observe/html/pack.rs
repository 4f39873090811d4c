//! The data of a page: a header and numbers of 16 bits, compressed.
//!
//! Little endian: the length of the header (u32), the header (JSON), and the numbers behind it. F frames of B bodies have
//!
//! ```text
//!   times          F × f64
//!   energies       3 × F × f64, kinetic, elastic, potential
//!   grids          B × 4 × f64: the corner (x, y, z) and the quantum (m) of the positions of a body
//!   modes          7 B bytes, one for each stream of numbers
//!   low, high      the low and the high bytes of all streams, one after another
//!   counts         F × u32, forces of a frame
//!   left out       F × u32, forces that are not there
//!   force scales   F × f32 (N s)
//!   names          for each force the number of its contact, the difference to the one before in its frame (u32)
//!   low, high      the low and the high bytes of 6 numbers for each force
//! ```
//!
//! A body has seven streams: x, y, z on its grid, the three smallest components of its quaternion as
//! [−1/√2, 1/√2] ↦ [0, 65535], and which component is left out, the largest, made positive. A stream of mode 0 is one number
//! that never changes, of mode 1 its first differences, of mode 2 its second differences; differences are taken modulo 2¹⁶ and
//! stored as 0, −1, 1, −2, 2, … ↦ 0, 1, 2, 3, 4, ….
//!
//! A force has its point in the box of all forces, and its percussion since the frame before in units of the scale of its
//! frame: six numbers, less those of the same contact in the frame before where it is there.

use std::collections::HashMap;
use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;

use super::shapes::Shapes;
use super::{Film, Pose, Units};
use crate::contact::ContactId;
use crate::system::Solid;

/// Share of the size of the scene that the positions of a body are told apart by at least, in 2¹⁶.
const SPAN: f64 = 0.25;

const LARGEST: f64 = u16::MAX as f64;

#[derive(Serialize)]
struct Header<'a> {
    format: u32,
    title: &'a str,
    law: &'a str,
    solver: &'a str,
    time_unit: &'a str,
    energy_unit: &'a str,
    frames: usize,
    bodies: usize,
    up: [f64; 3],
    /// The box of the points of forces.
    force_low: [f64; 3],
    force_high: [f64; 3],
    forces: usize,
    shapes: Shapes,
}

/// The numbers of a film, compressed.
pub(super) fn pack(
    film: &Film,
    (title, units): (&str, Units),
    solids: &[Solid],
    up: [f64; 3],
) -> std::io::Result<Vec<u8>> {
    let stills = &film.stills;
    let pushes = || stills.iter().flat_map(|still| still.pushes.values());
    let mut force_low = [f64::INFINITY; 3];
    let mut force_high = [f64::NEG_INFINITY; 3];
    for (i, x) in pushes().flat_map(|push| push.point.into_iter().enumerate()) {
        force_low[i] = force_low[i].min(f64::from(x));
        force_high[i] = force_high[i].max(f64::from(x));
    }
    let forces = pushes().count();
    if forces == 0 {
        (force_low, force_high) = ([0.0; 3], [0.0; 3]);
    }
    let bounds = film.bounds(solids);
    let (shapes, size) = (film.shapes(solids, bounds), bounds.size());
    let (frames, bodies) = (stills.len(), film.bodies.len());
    let Film { law, solver, .. } = film;
    let header = Header {
        format: 1,
        title,
        law,
        solver,
        time_unit: units.time,
        energy_unit: units.energy,
        frames,
        bodies,
        up,
        force_low,
        force_high,
        forces,
        shapes,
    };
    let header = serde_json::to_vec(&header).map_err(std::io::Error::other)?;
    let mut out = ZlibEncoder::new(Vec::new(), Compression::best());
    out.write_all(&(header.len() as u32).to_le_bytes())?;
    out.write_all(&header)?;
    write_floats(stills.iter().map(|still| still.time), &mut out)?;
    for kind in 0..3 {
        write_floats(stills.iter().map(|still| still.energies[kind]), &mut out)?;
    }
    let (mut modes, mut numbers) = (Vec::with_capacity(7 * bodies), Vec::new());
    for body in 0..bodies {
        let (grid, streams) = streams(stills.iter().map(|still| &still.poses[body]), SPAN * size);
        write_floats(grid.into_iter(), &mut out)?;
        streams.iter().for_each(|stream| modes.push(difference(stream, &mut numbers)));
    }
    out.write_all(&modes)?;
    write_halves(&numbers, &mut out)?;
    write_forces(film, (force_low, force_high), &mut out)?;
    out.finish()
}

fn write_floats(mut values: impl Iterator<Item = f64>, out: &mut impl std::io::Write) -> std::io::Result<()> {
    values.try_for_each(|x| out.write_all(&x.to_le_bytes()))
}

fn write_halves(numbers: &[u16], out: &mut impl std::io::Write) -> std::io::Result<()> {
    let half = |byte: usize| numbers.iter().map(|x| x.to_le_bytes()[byte]).collect::<Vec<u8>>();
    out.write_all(&half(0))?;
    out.write_all(&half(1))
}

/// x in [low, low + 65535 quantum] on its grid.
fn on_grid(x: f64, low: f64, quantum: f64) -> u16 {
    if quantum > 0.0 { ((x - low) / quantum).round().clamp(0.0, LARGEST) as u16 } else { 0 }
}

/// The grid and the streams of a body that spans at least `span` (m).
fn streams<'a>(poses: impl Iterator<Item = &'a Pose> + Clone, span: f64) -> ([f64; 4], [Vec<u16>; 7]) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for (i, &x) in poses.clone().flat_map(|pose| pose[..3].iter().enumerate()) {
        low[i] = low[i].min(f64::from(x));
        high[i] = high[i].max(f64::from(x));
    }
    let widest = (0..3).map(|i| high[i] - low[i]).fold(span, f64::max);
    let quantum = widest / LARGEST;
    let mut streams: [Vec<u16>; 7] = Default::default();
    for pose in poses {
        for axis in 0..3 {
            streams[axis].push(on_grid(f64::from(pose[axis]), low[axis], quantum));
        }
        let turn: [f64; 4] = std::array::from_fn(|i| f64::from(pose[3 + i]));
        let (most, smallest) = smallest_three(turn);
        let quantum = std::f64::consts::SQRT_2 / LARGEST;
        for (stream, x) in streams[3..6].iter_mut().zip(smallest) {
            stream.push(on_grid(x, -std::f64::consts::FRAC_1_SQRT_2, quantum));
        }
        streams[6].push(most);
    }
    ([low[0], low[1], low[2], quantum], streams)
}

/// Which component of a unit quaternion is the largest, and the others of the one of ±q where it is positive.
fn smallest_three(q: [f64; 4]) -> (u16, [f64; 3]) {
    let larger = |best: usize, i: usize| if q[i].abs() > q[best].abs() { i } else { best };
    let most = (1..4).fold(0, larger);
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let sign = if q[most] < 0.0 { -1.0 } else { 1.0 };
    let scale = if length > 0.0 { sign / length } else { 0.0 };
    (most as u16, std::array::from_fn(|i| scale * q[if i < most { i } else { i + 1 }]))
}

/// A difference modulo 2¹⁶, small ones as small numbers.
fn folded(difference: u16) -> u16 {
    let signed = difference as i16;
    ((signed << 1) ^ (signed >> 15)) as u16
}

/// Appends a stream in the mode that makes its numbers smallest.
fn difference(stream: &[u16], out: &mut Vec<u16>) -> u8 {
    if stream.windows(2).all(|pair| pair[0] == pair[1]) {
        out.extend(stream.first());
        return 0;
    }
    let before = |k: usize, by: usize| if k >= by { stream[k - by] } else { 0 };
    let first = |k: usize| folded(stream[k].wrapping_sub(before(k, 1)));
    // A stream that begins is taken to have stood still.
    let second = |k: usize| match k {
        0 | 1 => first(k),
        _ => folded(stream[k].wrapping_sub(before(k, 1).wrapping_mul(2)).wrapping_add(before(k, 2))),
    };
    let cost = |of: &dyn Fn(usize) -> u16| (0..stream.len()).map(|k| u64::from(of(k))).sum::<u64>();
    if cost(&second) < cost(&first) {
        out.extend((0..stream.len()).map(second));
        2
    } else {
        out.extend((0..stream.len()).map(first));
        1
    }
}

fn write_forces(
    film: &Film,
    (low, high): ([f64; 3], [f64; 3]),
    out: &mut impl std::io::Write,
) -> std::io::Result<()> {
    let mut names: HashMap<ContactId, u32> = HashMap::new();
    let mut last: HashMap<u32, [u16; 6]> = HashMap::new();
    let (mut gaps, mut numbers, mut scales) = (Vec::new(), Vec::new(), Vec::new());
    for still in &film.stills {
        let all = still.pushes.values().flat_map(|push| push.impulse);
        let scale = all.fold(0.0_f32, |most, x| most.max(x.abs()));
        scales.push(scale);
        let mut forces: Vec<(u32, [u16; 6])> = Vec::with_capacity(still.pushes.len());
        for (&id, push) in &still.pushes {
            let next = names.len() as u32;
            let name = *names.entry(id).or_insert(next);
            let point = |i: usize| on_grid(f64::from(push.point[i]), low[i], (high[i] - low[i]) / LARGEST);
            // In [−1, 1], 0 on the grid.
            let part = |i: usize| ((push.impulse[i] / scale * 32767.0).round() + 32768.0) as u16;
            forces.push((name, std::array::from_fn(|i| if i < 3 { point(i) } else { part(i - 3) })));
        }
        forces.sort_unstable_by_key(|&(name, _)| name);
        let mut before = 0;
        for &(name, values) in &forces {
            gaps.push(name - before);
            before = name;
            let old = last.get(&name).copied().unwrap_or_default();
            numbers.extend((0..6).map(|i| folded(values[i].wrapping_sub(old[i]))));
        }
        last = forces.into_iter().collect();
    }
    for count in film.stills.iter().map(|still| still.pushes.len() as u64) {
        out.write_all(&(count as u32).to_le_bytes())?;
    }
    for left in film.stills.iter().map(|still| still.left_out) {
        out.write_all(&u32::try_from(left).unwrap_or(u32::MAX).to_le_bytes())?;
    }
    scales.iter().try_for_each(|scale| out.write_all(&scale.to_le_bytes()))?;
    gaps.iter().try_for_each(|gap| out.write_all(&gap.to_le_bytes()))?;
    // Like numbers together.
    let by_kind: Vec<u16> = (0..6).flat_map(|i| numbers.iter().skip(i).step_by(6).copied()).collect();
    write_halves(&by_kind, out)
}
