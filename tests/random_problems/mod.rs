//! Random cone problems that have a solution: W = H M⁻¹ Hᵀ with one velocity that separates every contact.

#[path = "../mechanics/stream.rs"]
mod stream;

use nalgebra::{DMatrix, SMatrix, SVector};
use nonsmooth::cone::{BlockMatrix, ConeProblem};
use nonsmooth::scalar::{Scalar, lit};
#[allow(unused_imports)]
pub(crate) use stream::Stream;

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
    let size = |stream: &mut Stream| 10f64.powf(decades * (stream.uniform(0.0, 1.0) - 0.5));
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
    mu.resize(m, lit::<T>(friction).into());
    // Symmetric semidefinite by construction, whatever an eigenvalue routine makes of it in single precision.
    problem.check().expect("H M⁻¹ Hᵀ has a positive diagonal");
    problem
}
