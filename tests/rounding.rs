//! Where rounding of the percussions leaves more than the tolerance, a solution says so, and is as good as can be.

use nalgebra::{SMatrix, SVector};
use nonsmooth::cone::{BlockMatrix, ConeProblem};
use nonsmooth::solver::{Accuracy, Stopping, build, default_tolerance};

/// A body of 1 kg on the floor under one of `ratio` kg, both falling at −1 m/s: w₁ = p₁ − p₂ − 1, w₂ = −p₁ + W₂₂ p₂.
fn loaded(ratio: f64) -> ConeProblem<f64, 1> {
    let w = [[1.0, -1.0], [-1.0, 1.0 + 1.0 / ratio]];
    let w = BlockMatrix::from_fn(2, |i, j| SMatrix::<f64, 1, 1>::new(w[i][j]));
    let b = vec![SVector::<f64, 1>::new(-1.0), SVector::<f64, 1>::new(0.0)];
    ConeProblem::new(w, b, vec![0.0; 2]).expect("a problem")
}

#[test]
fn a_solution_at_the_floor_is_told_apart_and_has_its_forces_right() {
    for solver in ["hybrid", "proximal-newton", "newton"] {
        for ratio in [1e2, 1e4, 1e6, 1e8] {
            let problem = loaded(ratio);
            let (start, mut r) = (vec![SVector::zeros(); 2], vec![SVector::zeros(); 2]);
            let mut solver = build::<f64, 1>(solver, Stopping::default()).expect("registered");
            let name = solver.name();
            let solution = solver.solve(&problem, &start, &mut r).expect("solved");
            // The last digit of p, ε·ratio, against b = 1.
            let floor = problem.floor(&r);
            assert!(floor <= 8.0 * f64::EPSILON * ratio, "{ratio:e}: {floor:e}");
            match solution.accuracy {
                Accuracy::Tolerance => assert!(solution.residual.scaled <= default_tolerance::<f64>()),
                Accuracy::Rounding { floor: told } => {
                    assert!(ratio >= 1e6, "{name} excuses itself at {ratio:e}: {solution:?}");
                    assert_eq!(told, floor);
                    assert_eq!(solution.residual, problem.precise_residual(&r));
                    assert!(solution.residual.scaled <= floor, "{name}, {ratio:e}: {solution:?}");
                }
            }
            // Of W as it is rounded: p₂ = 1/(W₂₂ − 1), a difference without rounding.
            let heavy = problem.delassus().formed().expect("formed").diagonal(1).expect("full")[(0, 0)] - 1.0;
            let error = (r[1][0] * heavy - 1.0).abs();
            // W r is some 3 ratio, and W shrinks p₂ along (1, 1) to 1/ratio of itself: what is left of w there.
            let bound = if name == "newton" { 4.0 * floor } else { f64::max(floor, 1e-10) };
            assert!(error <= bound, "{name}, {ratio:e}: {error:e}");
        }
    }
}

#[test]
fn a_precise_residual_sees_what_a_plain_one_rounds_away() {
    let problem = loaded(1e8);
    let exact = 1.0 / (problem.delassus().formed().expect("formed").diagonal(1).expect("full")[(0, 0)] - 1.0);
    let r = [SVector::<f64, 1>::new(exact + 1.0), SVector::<f64, 1>::new(exact)];
    // w₂ = p₂ (W₂₂ − 1) − (p₁ − p₂): with p₁ − p₂ without rounding.
    let w = [
        (r[0][0] - r[1][0]) - 1.0,
        r[1][0] * (problem.delassus().formed().expect("formed").diagonal(1).expect("full")[(0, 0)] - 1.0),
    ];
    let expected = w[0].hypot(w[1] - (r[0][0] - r[1][0]));
    let precise = problem.precise_residual(&r).scaled;
    // W₂₂ − 1 is exact, the product with p₂ rounds once.
    assert!((precise * 1.0 - expected).abs() <= 4.0 * f64::EPSILON, "{precise:e}, {expected:e}");
}

#[test]
fn percussions_that_run_away_are_excused_by_nothing() {
    // Two walls that close in on a body: w₁ + w₂ = −2 whatever p.
    let w = BlockMatrix::from_fn(2, |i, j| SMatrix::<f64, 1, 1>::new(if i == j { 1.0 } else { -1.0 }));
    let problem =
        ConeProblem::new(w, vec![SVector::<f64, 1>::new(-1.0); 2], vec![0.0; 2]).expect("a problem");
    let mut size = 1.0;
    while size < 1e30 {
        let r = [SVector::<f64, 1>::new(size), SVector::<f64, 1>::new(size)];
        assert!(problem.floor(&r) < 1e-6, "{size:e}: {:e}", problem.floor(&r));
        assert!(problem.precise_residual(&r).scaled >= 0.9, "{size:e}");
        size *= 10.0;
    }
}
