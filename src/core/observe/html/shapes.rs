//! The shapes of a scene: each geometry once, and the box that the first view shows.

use std::collections::HashMap;

use serde::Serialize;

use super::Film;
use crate::system::{Solid, Surface};

/// Length of an endless plane, in the size of the scene, and thickness of its band in the plane.
const FAR: f64 = 40.0;
const BAND: f64 = 0.03;

/// Share of the places of bodies, at either end, that the first view may leave out.
const OUTSIDE: f64 = 0.01;

/// Frames that are looked at for the first view.
const LOOKS: usize = 60;

/// Digits that tell two geometries apart.
const SAME: f64 = 1e5;

/// A geometry, its largest coordinate 1.
#[derive(Debug, Serialize)]
pub(super) struct Mesh {
    points: Vec<f32>,
    faces: Vec<Vec<u32>>,
    lines: Vec<Vec<u32>>,
    round: bool,
}

/// A shape: point ↦ offset + scale · point in the frame of a body, the number of a body of the film, −1 for the ground.
#[derive(Debug, Serialize)]
pub(super) struct Part {
    name: String,
    body: i64,
    mesh: usize,
    scale: f32,
    offset: [f32; 3],
    endless: bool,
}

/// The geometries and shapes, the box of the first view, and whether all is in the plane.
#[derive(Debug, Serialize)]
pub(super) struct Shapes {
    meshes: Vec<Mesh>,
    parts: Vec<Part>,
    low: [f64; 3],
    high: [f64; 3],
    planar: bool,
}

/// What two geometries are compared by.
type Key = (Vec<i64>, Vec<Vec<u32>>, Vec<Vec<u32>>, bool);

/// An axis-parallel box.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    low: [f64; 3],
    high: [f64; 3],
}

impl Bounds {
    const EMPTY: Self = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    fn add(&mut self, point: [f64; 3]) {
        for (i, x) in point.into_iter().enumerate().filter(|(_, x)| x.is_finite()) {
            self.low[i] = self.low[i].min(x);
            self.high[i] = self.high[i].max(x);
        }
    }

    /// The box grown by a share of its size.
    fn grown(&self, share: f64) -> Self {
        self.around(share * self.size())
    }

    /// The box grown by a length; an empty one is about the origin.
    fn around(&self, by: f64) -> Self {
        let sound = |i: usize| self.low[i] <= self.high[i];
        Self {
            low: std::array::from_fn(|i| if sound(i) { self.low[i] - by } else { -by }),
            high: std::array::from_fn(|i| if sound(i) { self.high[i] + by } else { by }),
        }
    }

    /// Length of the diagonal, 0 of an empty box.
    pub(super) fn size(&self) -> f64 {
        let sides = self.low.iter().zip(&self.high).map(|(low, high)| (high - low).max(0.0));
        sides.map(|side| side * side).sum::<f64>().sqrt()
    }

    fn middle(&self) -> [f64; 3] {
        std::array::from_fn(|i| 0.5 * (self.low[i] + self.high[i]))
    }

    fn clamp(&self, point: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| point[i].clamp(self.low[i], self.high[i]))
    }
}

/// A point of a frame at `pose` in the fixed frame.
fn place(pose: &[f32; 7], x: [f64; 3]) -> [f64; 3] {
    let [px, py, pz, w, a, b, c] = pose.map(f64::from);
    let [x, y, z] = x;
    // x + 2 u × (u × x + w x) of the quaternion (w, u).
    let t = [b * z - c * y + w * x, c * x - a * z + w * y, a * y - b * x + w * z];
    [
        px + x + 2.0 * (b * t[2] - c * t[1]),
        py + y + 2.0 * (c * t[0] - a * t[2]),
        pz + z + 2.0 * (a * t[1] - b * t[0]),
    ]
}

const STILL: [f32; 7] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

impl Film {
    /// The number of a body in the film.
    fn number(&self, body: usize) -> Option<usize> {
        self.bodies.binary_search(&(body as u64)).ok()
    }

    fn first_pose(&self, body: Option<usize>) -> [f32; 7] {
        let found = body.and_then(|body| self.stills.first()?.poses.get(self.number(body)?));
        *found.unwrap_or(&STILL)
    }

    fn is_planar(&self, solids: &[Solid]) -> bool {
        let mut poses = self.stills.iter().flat_map(|still| &still.poses);
        solids.iter().flat_map(|solid| &solid.surface.points).all(|point| point[2] == 0.0)
            && poses.all(|pose| pose[2] == 0.0 && pose[4] == 0.0 && pose[5] == 0.0)
    }

    /// The box of the first view: bodies where they are at the start, and where they are nearly all of the time.
    pub(super) fn bounds(&self, solids: &[Solid]) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        let every = self.stills.len().div_ceil(LOOKS).max(1);
        let (mut lows, mut highs): ([Vec<f64>; 3], [Vec<f64>; 3]) = Default::default();
        for solid in solids.iter().filter(|solid| !solid.endless) {
            let Some(body) = solid.body.and_then(|body| self.number(body)) else { continue };
            for (k, still) in self.stills.iter().step_by(every).enumerate() {
                let Some(pose) = still.poses.get(body) else { continue };
                let mut own = Bounds::EMPTY;
                solid.surface.points.iter().for_each(|&point| own.add(place(pose, point)));
                for axis in (0..3).filter(|&axis| own.low[axis] <= own.high[axis]) {
                    lows[axis].push(own.low[axis]);
                    highs[axis].push(own.high[axis]);
                    if k == 0 {
                        bounds.low[axis] = bounds.low[axis].min(own.low[axis]);
                        bounds.high[axis] = bounds.high[axis].max(own.high[axis]);
                    }
                }
            }
        }
        for axis in 0..3 {
            for all in [&mut lows[axis], &mut highs[axis]] {
                all.sort_by(f64::total_cmp);
            }
            let last = lows[axis].len().saturating_sub(1);
            let outside = (OUTSIDE * last as f64) as usize;
            if let (Some(&low), Some(&high)) = (lows[axis].get(outside), highs[axis].get(last - outside)) {
                bounds.low[axis] = bounds.low[axis].min(low);
                bounds.high[axis] = bounds.high[axis].max(high);
            }
        }
        // Fixed shapes as far as they are near.
        let near = bounds.grown(0.3);
        for solid in solids.iter().filter(|solid| solid.body.is_none() && !solid.endless) {
            solid.surface.points.iter().for_each(|&point| bounds.add(near.clamp(point)));
        }
        if bounds.size() > 0.0 { bounds } else { bounds.around(0.5) }
    }

    /// The shapes of the solids in a scene with these bounds.
    pub(super) fn shapes(&self, solids: &[Solid], bounds: Bounds) -> Shapes {
        let planar = self.is_planar(solids);
        let (mut known, mut meshes, mut parts) = (HashMap::<Key, usize>::new(), Vec::new(), Vec::new());
        for solid in solids {
            let stretched;
            let mut surface = &solid.surface;
            if solid.endless {
                stretched = stretch(surface, &bounds, &self.first_pose(solid.body));
                surface = &stretched;
            }
            let mut own = Bounds::EMPTY;
            surface.points.iter().for_each(|&point| own.add(point));
            let (offset, half) = (own.around(0.0).middle(), 0.5 * own.size());
            let scale = if half > 0.0 { half } else { 1.0 };
            let unit: Vec<f64> = surface
                .points
                .iter()
                .flat_map(|point| (0..3).map(|i| (point[i] - offset[i]) / scale))
                .map(|x| if x.is_finite() { x } else { 0.0 })
                .collect();
            let rounded = unit.iter().map(|x| (x * SAME).round() as i64).collect();
            let key = (rounded, surface.faces.clone(), surface.lines.clone(), surface.round);
            let mesh = *known.entry(key).or_insert_with(|| {
                let points = unit.iter().map(|&x| ((x * 1e6).round() / 1e6) as f32).collect();
                let (faces, lines) = (surface.faces.clone(), surface.lines.clone());
                meshes.push(Mesh { points, faces, lines, round: surface.round });
                meshes.len() - 1
            });
            parts.push(Part {
                name: solid.name.clone(),
                body: solid.body.and_then(|body| self.number(body)).map_or(-1, |body| body as i64),
                mesh,
                scale: scale as f32,
                offset: offset.map(|x| x as f32),
                endless: solid.endless,
            });
        }
        let Bounds { low, high } = bounds.grown(0.05);
        Shapes { meshes, parts, low, high, planar }
    }
}

/// An endless plane as large as the scene: the given surface about the point that is nearest to the middle of the scene, and
/// in the plane a band on its right.
fn stretch(surface: &Surface, bounds: &Bounds, pose: &[f32; 7]) -> Surface {
    let size = bounds.size();
    let count = surface.points.len().max(1) as f64;
    let middle: [f64; 3] = std::array::from_fn(|i| surface.points.iter().map(|p| p[i]).sum::<f64>() / count);
    // The middle of the scene in the frame of the body.
    let [px, py, pz, w, a, b, c] = *pose;
    let seen = bounds.middle();
    let away = [seen[0] - f64::from(px), seen[1] - f64::from(py), seen[2] - f64::from(pz)];
    let seen = place(&[0.0, 0.0, 0.0, w, -a, -b, -c], away);
    // Along the edges that leave the first point, made orthogonal.
    let mut foot = middle;
    let mut axes: Vec<[f64; 3]> = Vec::new();
    for point in surface.points.iter().skip(1) {
        let mut axis: [f64; 3] = std::array::from_fn(|i| point[i] - surface.points[0][i]);
        for other in &axes {
            let along: f64 = (0..3).map(|i| axis[i] * other[i]).sum();
            axis = std::array::from_fn(|i| axis[i] - along * other[i]);
        }
        let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length > 1e-9 && axes.len() < 2 {
            axes.push(axis.map(|x| x / length));
        }
    }
    for axis in &axes {
        let along: f64 = (0..3).map(|i| axis[i] * (seen[i] - middle[i])).sum();
        foot = std::array::from_fn(|i| foot[i] + along * axis[i]);
    }
    let far = if axes.len() == 1 { FAR } else { FAR / 10.0 };
    let mut stretched = surface.clone();
    for point in &mut stretched.points {
        *point = std::array::from_fn(|i| foot[i] + far * size * (point[i] - middle[i]));
    }
    if let ([axis], [first, second]) = (axes.as_slice(), stretched.points.clone().as_slice()) {
        let right = [axis[1] * BAND * size, -axis[0] * BAND * size, 0.0];
        let below = |point: &[f64; 3]| std::array::from_fn(|i| point[i] + right[i]);
        stretched.points.extend([below(second), below(first)]);
        stretched.faces.push(vec![0, 1, 2, 3]);
    }
    stretched
}
