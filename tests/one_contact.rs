//! The one-contact solution satisfies the inclusion to rounding, whatever the block, the friction and the units.

use nalgebra::{SMatrix, SVector};
use nonsmooth::cone::{de_saxce, largest_eigenvalue, project, solve_one_contact, solve_one_contact_from};
use nonsmooth::scalar::{Scalar, epsilon, lit, to_f64};

/// xorshift64*: the tests draw the same problems on every machine.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    }
    fn symmetric(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }
    fn pick<X: Copy>(&mut self, from: &[X]) -> X {
        from[(self.unit() * from.len() as f64) as usize]
    }
    fn vector<const D: usize>(&mut self) -> SVector<f64, D> {
        SVector::from_fn(|_, _| self.symmetric())
    }
    /// W = G Gᵀ of the given rank, its columns and then its rows and columns (units) spread over `spread` decades.
    fn block<const D: usize>(&mut self, rank: usize, spread: f64) -> SMatrix<f64, D, D> {
        let mut w = SMatrix::zeros();
        for _ in 0..rank {
            let g = self.vector::<D>() * 10f64.powf(spread * self.symmetric());
            w += g * g.transpose();
        }
        let units = SVector::<f64, D>::from_fn(|_, _| 10f64.powf(0.5 * spread * self.symmetric()));
        SMatrix::from_fn(|i, j| w[(i, j)] * units[i] * units[j])
    }
}

const FRICTION: [f64; 9] = [0.0, 1e-8, 1e-3, 0.1, 0.3, 0.7, 1.0, 3.0, 10.0];

/// The velocity by which r misses the inclusion, over (1 + μ)(‖b‖ + ‖W‖‖r‖), in units of ε: De Saxcé's shift
/// multiplies the rounding of w_T by μ.
fn miss<T: Scalar, const D: usize>(w: &SMatrix<T, D, D>, b: &SVector<T, D>, mu: T, r: &SVector<T, D>) -> f64 {
    let size = w.norm();
    let velocity = w * r + b;
    let rho = T::one() / largest_eigenvalue(w);
    let map = (r - project(&(r - de_saxce(&velocity, mu) * rho), mu)) / rho;
    to_f64(map.norm() / ((b.norm() + size * r.norm()) * (T::one() + mu) * epsilon::<T>()))
}

fn convert<T: Scalar, const R: usize, const C: usize>(x: &SMatrix<f64, R, C>) -> SMatrix<T, R, C> {
    x.map(lit::<T>)
}

/// Worst miss over `draws` problems drawn by `draw`.
fn worst<T: Scalar, const D: usize>(
    draws: usize,
    mut draw: impl FnMut(&mut Random) -> (SMatrix<f64, D, D>, SVector<f64, D>, f64),
) -> f64 {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut worst = 0.0f64;
    for k in 0..draws {
        let (w, b, mu) = draw(&mut random);
        if w[(0, 0)] <= 0.0 {
            continue;
        }
        let (w, b, mu) = (convert::<T, D, D>(&w), convert::<T, D, 1>(&b), lit::<T>(mu));
        let mut alpha = lit::<T>(random.unit());
        for r in [solve_one_contact(&w, &b, mu), solve_one_contact_from(&w, &b, mu, &mut alpha)] {
            let miss = miss(&w, &b, mu, &r);
            assert!(miss.is_finite(), "draw {k}: W {w} b {b} μ {mu} gives {r}");
            if miss > worst {
                worst = miss;
            }
            if miss > LIMIT {
                println!("draw {k}: miss {miss} W {w:?} b {b:?} μ {mu} r {r:?}");
            }
        }
    }
    worst
}

/// b such that some (r, w) with K* ∋ Φ(w) ⟂ r ∈ K solves the problem: of take-off, stick or slide in turn.
fn solvable<const D: usize>(random: &mut Random, w: &SMatrix<f64, D, D>, mu: f64) -> SVector<f64, D> {
    let mut tangent = random.vector::<D>();
    tangent[0] = 0.0;
    let tangent = if D == 1 { tangent } else { tangent.normalize() };
    let unit = SVector::<f64, D>::from_fn(|i, _| if i == 0 { 1.0 } else { 0.0 });
    let size = w.norm();
    match random.pick(&[0, 1, 2]) {
        0 => unit * random.unit() + tangent * random.symmetric(),
        1 => -w * (unit + tangent * (mu * random.unit())) / size,
        _ => -w * (unit - tangent * mu) / size + tangent * random.unit(),
    }
}

// 100 ε: some 30 operations, blocks of condition number up to 14 by their explicit inverse, and the rounding of the
// test's own W r + b.
const LIMIT: f64 = 100.0;

fn definite<T: Scalar, const D: usize>(spread: f64) -> f64 {
    worst::<T, D>(200_000, |random| {
        let w = random.block(D + 1, spread);
        (w, random.vector(), random.pick(&FRICTION))
    })
}

#[test]
fn a_definite_block_is_solved_to_rounding() {
    for (name, miss) in [
        ("D=1", definite::<f64, 1>(0.0)),
        ("D=2", definite::<f64, 2>(0.0)),
        ("D=3", definite::<f64, 3>(0.0)),
        ("D=2 f32", definite::<f32, 2>(0.0)),
        ("D=3 f32", definite::<f32, 3>(0.0)),
        ("D=2 ill-conditioned", definite::<f64, 2>(2.0)),
        ("D=3 ill-conditioned", definite::<f64, 3>(2.0)),
    ] {
        println!("{name}: {miss:.1} ε");
        assert!(miss <= LIMIT, "{name}: {miss} ε");
    }
}

fn singular<T: Scalar, const D: usize>(rank: usize) -> f64 {
    worst::<T, D>(200_000, |random| {
        let w = random.block(rank, 0.0);
        let mu = random.pick(&FRICTION);
        let b = solvable(random, &w, mu);
        (w, b, mu)
    })
}

#[test]
fn a_singular_block_is_solved_to_rounding_where_a_solution_exists() {
    for (name, miss) in [
        ("D=2 rank 1", singular::<f64, 2>(1)),
        ("D=3 rank 1", singular::<f64, 3>(1)),
        ("D=3 rank 2", singular::<f64, 3>(2)),
        ("D=3 rank 3", singular::<f64, 3>(3)),
    ] {
        println!("{name}: {miss:.1} ε");
        assert!(miss <= LIMIT, "{name}: {miss} ε");
    }
}

#[test]
fn units_and_asymmetry_leave_the_accuracy() {
    for decades in [-12, -6, 6, 12] {
        let scale = 10f64.powi(decades);
        let miss = worst::<f64, 3>(20_000, |random| {
            let mut w = random.block::<3>(4, 0.5);
            // Published problems are asymmetric by up to 2e-3.
            let skew = random.vector::<3>().cross_matrix() * 2e-3;
            w += SMatrix::<f64, 3, 3>::from_fn(|i, j| skew[(i, j)] * (w[(i, i)] * w[(j, j)]).sqrt());
            (w * scale, random.vector() / scale.sqrt(), random.pick(&FRICTION))
        });
        println!("1e{decades}: {miss:.1} ε");
        assert!(miss <= LIMIT, "1e{decades}: {miss} ε");
    }
}

#[test]
fn enormous_and_tiny_friction_are_solved() {
    for mu in [1e-300, 1e-30, 1e-12, 1e3, 1e6, 1e12] {
        let miss = worst::<f64, 3>(20_000, |random| (random.block(4, 0.0), random.vector(), mu));
        println!("μ = {mu:e}: {miss:.1} ε");
        assert!(miss <= LIMIT, "μ = {mu}: {miss} ε");
    }
}

#[test]
fn a_diagonal_block_gives_the_textbook_answers() {
    let w = SMatrix::<f64, 3, 3>::from_diagonal(&SVector::from([2.0, 0.5, 0.5]));
    let solve = |b: [f64; 3]| solve_one_contact(&w, &SVector::from(b), 0.5);
    // Separating: nothing. Approaching without slip: r_N = −b_N/W_NN alone.
    assert_eq!(solve([1.0, 3.0, 0.0]), SVector::from([0.0; 3]));
    assert_eq!(solve([-1.0, 0.0, 0.0]), SVector::from([0.5, 0.0, 0.0]));
    // r_T = −b_T/W_TT within μ r_N sticks; beyond, friction μ r_N opposes the slip.
    assert!((solve([-1.0, 0.1, 0.0]) - SVector::from([0.5, -0.2, 0.0])).norm() < 1e-15);
    assert!((solve([-1.0, 3.0, -4.0]) - SVector::from([0.5, -0.15, 0.2])).norm() < 1e-15);
}

#[test]
fn the_first_guess_does_not_change_the_answer() {
    let mut random = Random(7);
    for _ in 0..20_000 {
        let (w, b) = (random.block::<3>(4, 0.0), random.vector());
        let cold = solve_one_contact(&w, &b, 0.4);
        let mut alpha = 10f64.powf(6.0 * random.symmetric());
        let warm = solve_one_contact_from(&w, &b, 0.4, &mut alpha);
        // Both satisfy the inclusion to 100 ε; with W ≻ 0 and W_NN > μ‖W_NT‖ the answer is unique and the
        // distance is that times the condition number of W.
        if w[(0, 0)] > 0.4 * w.fixed_view::<1, 2>(0, 1).norm() {
            let condition = w.symmetric_eigenvalues().min().recip() * w.norm();
            let distance = (cold - warm).norm() / (cold.norm() + f64::MIN_POSITIVE);
            assert!(distance <= LIMIT * f64::EPSILON * condition * condition, "{cold} {warm} {condition}");
        }
    }
}
