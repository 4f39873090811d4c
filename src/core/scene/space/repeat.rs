//! Copies of a body on a grid.

use serde::Deserialize;

use super::SpaceBodySpec;

/// Most copies of one body: more is a slip of the keyboard.
const MOST_COPIES: usize = 1_000_000;

/// Copies of a body on a grid, called `name.1`, `name.2` and so on, the first axis fastest. They answer to `name` as well.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RepeatSpec {
    /// Number of copies along each axis (dimensionless).
    pub count: [usize; 3],
    /// Distance between copies along each axis (m).
    pub spacing: [f64; 3],
    /// Copies are shifted along each axis by up to this, at random (m).
    #[serde(default)]
    pub jitter: f64,
    /// Copies are turned about a random axis by up to this (rad).
    #[serde(default)]
    pub turn: f64,
    /// Start of the random numbers (dimensionless): the same gives the same scene.
    #[serde(default)]
    pub seed: u64,
}

/// Numbers as good as random (SplitMix64; Steele, Lea and Flood 2014, doi:10.1145/2660193.2660195).
struct Stream(u64);

impl Stream {
    /// Uniform in [−1, 1).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

impl RepeatSpec {
    /// Number of copies; `None` for none, or for too many.
    pub(super) fn copies(&self) -> Option<usize> {
        let [x, y, z] = self.count;
        let all = x.checked_mul(y).and_then(|xy| xy.checked_mul(z))?;
        (1..=MOST_COPIES).contains(&all).then_some(all)
    }
}

impl SpaceBodySpec {
    /// The copies of the body, or the body alone. A grid of none or of too many is left as it is, for
    /// [`check`](super::build) to refuse.
    pub(super) fn copies(self) -> Vec<Self> {
        let Some((repeat, _)) = self.repeat.clone().and_then(|repeat| repeat.copies().map(|n| (repeat, n)))
        else {
            return vec![self];
        };
        let mut stream = Stream(repeat.seed);
        let mut all = Vec::new();
        let [nx, ny, nz] = repeat.count;
        for (k, j, i) in (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (k, j, i)))) {
            let place = [i, j, k];
            let mut copy = Self { repeat: None, ..self.clone() };
            copy.name = format!("{}.{}", self.name, all.len() + 1);
            copy.groups.push(self.name.clone());
            for (x, (k, spacing)) in copy.position.iter_mut().zip(place.into_iter().zip(repeat.spacing)) {
                *x += k as f64 * spacing + stream.next() * repeat.jitter;
            }
            let axis = [stream.next(), stream.next(), stream.next()];
            let angle = stream.next() * repeat.turn;
            copy.orientation = turned(axis, angle, copy.orientation);
            all.push(copy);
        }
        all
    }
}

/// `orientation` after a turn by `angle` about a fixed `axis` of any length.
fn turned(axis: [f64; 3], angle: f64, orientation: [f64; 4]) -> [f64; 4] {
    let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
    if angle == 0.0 || !(length > 0.0) {
        return orientation;
    }
    let (sin, cos) = (0.5 * angle).sin_cos();
    let turn = nalgebra::Quaternion::new(
        cos,
        sin * axis[0] / length,
        sin * axis[1] / length,
        sin * axis[2] / length,
    );
    let [w, x, y, z] = orientation;
    let product = turn * nalgebra::Quaternion::new(w, x, y, z);
    [product.w, product.i, product.j, product.k]
}
