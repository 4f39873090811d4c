//! Random cone problems that have a solution: W = H M⁻¹ Hᵀ with one velocity that separates every contact.

use nalgebra::{DMatrix, SMatrix, SVector};
use nonsmooth::cone::{BlockMatrix, ConeProblem};
use nonsmooth::scalar::{Scalar, lit};

/// A reproducible stream of numbers (SplitMix64; Steele, Lea & Flood 2014, doi:10.1145/2660193.2660195).
pub(crate) struct Stream(pub(crate) u64);

impl Stream {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Standard normal (Box–Muller).
    pub(crate) fn normal(&mut self) -> f64 {
        let (u, v) = (1.0 - self.uniform(), self.uniform());
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }
}

/// What a random problem looks like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Recipe {
    /// Seed of the stream.
    pub(crate) seed: u64,
    /// Contacts m.
    pub(crate) contacts: usize,
    /// Degrees of freedom n: below m D the Delassus operator is singular.
    pub(crate) freedom: usize,
    /// Coefficient of friction of every contact.
    pub(crate) friction: f64,
    /// Spread of the masses and of the contacts' sizes, in decades.
    pub(crate) decades: f64,
}

/// The problem of a recipe. The velocity e₀ = (1, 0, …) opens every contact without slip (H_N e₀ = 1, H_T e₀ = 0),
/// so that H v + δ ∈ int K* for some v whatever δ, which makes a solution exist (Acary, Cadoux, Lemaréchal & Malick
/// 2011, doi:10.1002/zamm.201000073); b is random and b_N of every contact leans towards impact.
pub(crate) fn random<T: Scalar, const D: usize>(recipe: &Recipe) -> ConeProblem<T, D> {
    let Recipe { seed, contacts: m, freedom: n, friction, decades } = *recipe;
    let mut stream = Stream(seed);
    let size = |stream: &mut Stream| 10f64.powf(decades * (stream.uniform() - 0.5));
    let inverse_mass: Vec<f64> = (0..n).map(|_| size(&mut stream)).collect();
    let mut h = DMatrix::<f64>::zeros(m * D, n);
    for i in 0..m {
        let lever = size(&mut stream);
        for d in 0..D {
            for c in 1..n {
                h[(i * D + d, c)] = lever * stream.normal();
            }
        }
        h[(i * D, 0)] = lever;
    }
    let w = DMatrix::from_fn(m * D, m * D, |i, j| {
        lit::<T>((0..n).map(|c| h[(i, c)] * inverse_mass[c] * h[(j, c)]).sum())
    });
    let mut problem = ConeProblem::default();
    let (delassus, b, mu) = problem.parts_mut();
    *delassus = BlockMatrix::from_fn(m, |i, j| SMatrix::from_fn(|r, c| w[(i * D + r, j * D + c)]));
    let lean = |d| if d == 0 { 0.5 } else { 0.0 };
    b.extend((0..m).map(|_| SVector::from_fn(|d, _| lit::<T>(stream.normal() - lean(d)))));
    mu.resize(m, lit(friction));
    // Symmetric semidefinite by construction, whatever an eigenvalue routine makes of it in single precision.
    problem.check().expect("H M⁻¹ Hᵀ has a positive diagonal");
    problem
}
