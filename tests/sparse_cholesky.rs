//! Sparse Cholesky factors solve to rounding, whole or with a pause before chosen unknowns, in both arithmetics.

use nonsmooth::linalg::{SparseCholesky, SparseSymmetric};
use nonsmooth::scalar::{Scalar, epsilon, lit, to_f64};
use proptest::prelude::*;

/// The stiffness of springs between neighbours of a `width` × `height` grid and a few more pairs, tied to the ground: a
/// positive definite operator whose factors fill in.
fn springs<T: Scalar>(
    (width, height): (usize, usize),
    stiffness: &[f64],
    pairs: &[(usize, usize)],
) -> SparseSymmetric<T> {
    let n = width * height;
    let mut bars: Vec<(usize, usize)> =
        (0..n).filter(|i| i % width + 1 < width).map(|i| (i, i + 1)).collect();
    bars.extend((0..n.saturating_sub(width)).map(|i| (i, i + width)));
    bars.extend(pairs.iter().map(|&(i, j)| (i % n, j % n)).filter(|(i, j)| i != j));
    let mut triplets: Vec<(usize, usize, T)> = (0..n).map(|i| (i, i, lit(0.1))).collect();
    for (bar, &(i, j)) in bars.iter().enumerate() {
        let k: T = lit(stiffness[bar % stiffness.len()]);
        triplets.extend([(i, i, k), (j, j, k), (i, j, -k), (j, i, -k)]);
    }
    SparseSymmetric::from_triplets(n, &triplets).expect("symmetric")
}

/// ‖A x − b‖∞ in units of ε n ‖A‖∞ ‖x‖∞.
fn residual<T: Scalar>(a: &SparseSymmetric<T>, x: &[T], b: &[T]) -> f64 {
    let mut left = vec![T::zero(); b.len()];
    a.multiply(x, &mut left);
    let worst = left.iter().zip(b).map(|(&l, &b)| to_f64(l - b).abs()).fold(0.0, f64::max);
    let mut rows = vec![0.0; b.len()];
    a.entries().for_each(|(i, _, entry)| rows[i] += to_f64(entry).abs());
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let norms = largest(&mut rows.into_iter()) * largest(&mut x.iter().map(|&x| to_f64(x).abs()));
    worst / (to_f64(epsilon::<T>()) * b.len() as f64 * norms)
}

/// The inverted diagonal blocks lose a factor of at most the root of the condition number (here ≤ 10³ with the factor
/// of the norm) beyond the n ε ‖A‖ ‖x‖ of the substitutions; what is measured stays below 1.
const ROUNDING: f64 = 4.0;

fn check<T: Scalar>(a: &SparseSymmetric<T>, last: &[usize], force: impl Fn(usize) -> f64) {
    let n = a.size();
    let mut factors = SparseCholesky::new(a, last).expect("positive definite");
    let b: Vec<T> = (0..n).map(|i| lit(force(i))).collect();
    let mut x = b.clone();
    factors.solve_in_place(&mut x);
    assert!(residual(a, &x, &b) <= ROUNDING, "{} {}", T::NAME, residual(a, &x, &b));

    // With a pause: the last unknowns are those of the whole solve, and take an addition along.
    let mut seen = vec![T::zero(); n];
    factors.load(&b);
    factors.last_unknowns(&mut seen);
    let scale = x.iter().fold(0.0, |max: f64, &x| max.max(to_f64(x).abs()));
    let rounding = ROUNDING * n as f64 * 1e3 * to_f64(epsilon::<T>()) * scale;
    for &unknown in last {
        let apart = to_f64(seen[unknown] - x[unknown]).abs();
        assert!(apart <= rounding, "{}: unknown {unknown} is {apart} apart", T::NAME);
    }
    let mut moved = b.clone();
    for &unknown in last {
        factors.add(unknown, lit(0.5));
        moved[unknown] += lit::<T>(0.5);
    }
    factors.finish(&mut x);
    assert!(residual(a, &x, &moved) <= ROUNDING, "{} {}", T::NAME, residual(a, &x, &moved));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn equilibria_of_spring_grids_are_found_to_rounding(
        width in 1_usize..15,
        height in 1_usize..15,
        stiffness in prop::collection::vec(0.1_f64..10.0, 1..9),
        pairs in prop::collection::vec((0_usize..225, 0_usize..225), 0..6),
        last in prop::collection::vec(0_usize..225, 0..20),
        wave in 0.1_f64..3.0,
    ) {
        let n = width * height;
        let mut last: Vec<usize> = last.into_iter().map(|unknown| unknown % n).collect();
        last.sort_unstable();
        last.dedup();
        let force = |i: usize| (wave * i as f64).cos();
        check(&springs::<f64>((width, height), &stiffness, &pairs), &last, force);
        check(&springs::<f32>((width, height), &stiffness, &pairs), &last, force);
    }
}

#[test]
fn an_operator_that_is_not_positive_definite_is_refused() {
    let a = SparseSymmetric::from_triplets(2, &[(0, 0, 1.0), (0, 1, 2.0), (1, 0, 2.0), (1, 1, 1.0)])
        .expect("symmetric");
    assert!(SparseCholesky::new(&a, &[]).is_err());
}

#[test]
fn nothing_to_solve_is_solved() {
    let a = SparseSymmetric::<f64>::from_triplets(0, &[]).expect("symmetric");
    SparseCholesky::new(&a, &[]).expect("empty").solve_in_place(&mut []);
}
