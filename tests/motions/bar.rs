//! An elastic bar in finite elements against a wall, e = 0: exact in the modes of the free and of the held bar.
//!
//! The motion is that of the semi-discrete system, which is what a tolerance on the time integration speaks of.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use nonsmooth::linalg::Symmetric;
use nonsmooth::scene::Scene;

use super::{Motion, example};

const ELEMENTS: usize = 20;
/// Distance to the wall (m).
const GAP: f64 = 0.5;
/// Steps of the search for events (s): the fastest mode has 200 rad/s.
const SEARCH: f64 = 2e-5;

/// `examples/impacting_bar.toml` of 20 elements, at half a metre from the wall.
pub(super) fn scene() -> Scene {
    let mut scene = example::scene("impacting_bar");
    scene.solid.as_mut().expect("a solid").mesh.elements = Some(ELEMENTS);
    scene.half_planes[0].point = [-GAP, 0.0];
    scene
}

fn dense(operator: &Symmetric<f64>) -> DMatrix<f64> {
    let n = operator.size();
    let mut dense = DMatrix::zeros(n, n);
    operator.entries().for_each(|(i, j, x)| dense[(i, j)] = x);
    dense
}

/// M ẍ + K x = 0 with the components before `first` held: x = Σ φ (z cos ωτ + ż sin ωτ/ω).
struct Modes {
    first: usize,
    shapes: DMatrix<f64>,
    to_modes: DMatrix<f64>,
    frequencies: Vec<f64>,
}

impl Modes {
    fn new(mass: &DMatrix<f64>, stiffness: &DMatrix<f64>, first: usize) -> Self {
        let n = mass.nrows() - first;
        let part = |a: &DMatrix<f64>| a.view((first, first), (n, n)).into_owned();
        let lower = part(mass).cholesky().expect("M ≻ 0").l();
        let inverse = lower.clone().try_inverse().expect("M ≻ 0");
        let eigen = SymmetricEigen::new(&inverse * part(stiffness) * inverse.transpose());
        let shapes = inverse.transpose() * &eigen.eigenvectors;
        let to_modes = eigen.eigenvectors.transpose() * lower.transpose();
        // The rigid motion has the frequency 0, but for rounding.
        let frequencies = eigen.eigenvalues.iter().map(|&x| if x < 1e-6 { 0.0 } else { x.sqrt() }).collect();
        Self { first, shapes, to_modes, frequencies }
    }
}

/// A stretch of the motion between two events.
struct Stretch {
    start: f64,
    held: bool,
    z: DVector<f64>,
    rate: DVector<f64>,
}

struct Bar {
    free: Modes,
    held: Modes,
    stretches: Vec<Stretch>,
}

impl Bar {
    fn begin(&mut self, start: f64, held: bool, q: &DVector<f64>, v: &DVector<f64>) {
        let modes = if held { &self.held } else { &self.free };
        let mut rest = q.clone();
        if held {
            rest.add_scalar_mut(GAP);
        }
        let n = rest.len() - modes.first;
        let z = &modes.to_modes * rest.rows(modes.first, n);
        let rate = &modes.to_modes * v.rows(modes.first, n);
        self.stretches.push(Stretch { start, held, z, rate });
    }

    fn along(&self, stretch: &Stretch, time: f64) -> (DVector<f64>, DVector<f64>) {
        let modes = if stretch.held { &self.held } else { &self.free };
        let tau = time - stretch.start;
        let (mut z, mut rate) = (stretch.z.clone(), stretch.rate.clone());
        for (i, &w) in modes.frequencies.iter().enumerate() {
            let (a, b) = (stretch.z[i], stretch.rate[i]);
            let (sin, cos) = (w * tau).sin_cos();
            z[i] = a * cos + if w > 0.0 { b * sin / w } else { b * tau };
            rate[i] = b * cos - a * w * sin;
        }
        let (moved, velocity) = (&modes.shapes * z, &modes.shapes * rate);
        if stretch.held {
            // The held bar is seen from its held end; a rigid shift stretches nothing.
            let full = |x: DVector<f64>, shift: f64| x.insert_row(0, 0.0).add_scalar(-shift);
            (full(moved, GAP), full(velocity, 0.0))
        } else {
            (moved, velocity)
        }
    }
}

pub(super) fn motion(scene: &Scene) -> Motion {
    let (scheme, _) = example::scheme::<f64, 1>(scene, "fremond", "nsgs");
    let system = scheme.system();
    let (mass, stiffness) = (dense(system.mass()), dense(system.stiffness().expect("elastic")));
    let row = stiffness.row(0).into_owned();
    let inverse = mass.clone().try_inverse().expect("M ≻ 0");
    let mass_row = mass.row(0).into_owned();
    let modes = |first| Modes::new(&mass, &stiffness, first);
    let mut bar = Bar { free: modes(0), held: modes(1), stretches: Vec::new() };
    let column = |x: &[f64]| DVector::from_column_slice(x);
    bar.begin(0.0, false, &column(&scheme.state().q), &column(&scheme.state().v));
    // Positive while the state of contact lasts: the gap, or the reaction M₀ ẍ + K₀ x with ẍ = −ω² x in the modes.
    let lasts = |bar: &Bar, stretch: &Stretch, time: f64| {
        let (q, _) = bar.along(stretch, time);
        if !stretch.held {
            return q[0] + GAP;
        }
        let tau = time - stretch.start;
        let modes = &bar.held;
        let z = DVector::from_fn(stretch.z.len(), |i, _| {
            let w = modes.frequencies[i];
            let (sin, cos) = (w * tau).sin_cos();
            -w * w * (stretch.z[i] * cos + stretch.rate[i] * sin / w)
        });
        let acceleration = (&modes.shapes * z).insert_row(0, 0.0);
        (row.clone() * q)[0] + (mass_row.clone() * acceleration)[0]
    };
    let mut time = SEARCH;
    while time < scene.time.end {
        let stretch = &bar.stretches[bar.stretches.len() - 1];
        if lasts(&bar, stretch, time) > 0.0 {
            time += SEARCH;
            continue;
        }
        let (mut before, mut after) = ((time - SEARCH).max(stretch.start), time);
        for _ in 0..60 {
            let middle = 0.5 * (before + after);
            if lasts(&bar, stretch, middle) > 0.0 { before = middle } else { after = middle }
        }
        let (q, mut v) = bar.along(stretch, after);
        let held = !stretch.held;
        if held {
            let percussion = -v[0] / inverse[(0, 0)];
            v += inverse.column(0) * percussion;
        }
        bar.begin(after, held, &q, &v);
        time = after + SEARCH;
    }
    Box::new(move |time, q, v| {
        let stretch = bar.stretches.iter().rfind(|stretch| stretch.start < time);
        let (at, velocity) = bar.along(stretch.unwrap_or(&bar.stretches[0]), time);
        q.copy_from_slice(at.as_slice());
        v.copy_from_slice(velocity.as_slice());
    })
}
