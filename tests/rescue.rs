//! A cone problem that the chosen solver misses is tried otherwise before anything ends.

mod random_problems;

use nalgebra::{Matrix2, SVector, vector};
use nonsmooth::cone::{BlockMatrix, ConeProblem};
use nonsmooth::solver::{
    Accuracy, ConeSolver, Method, Nsgs, NsgsSettings, RESCUE_TIME, SolveError, Stopping, build,
    solve_or_rescue,
};
use random_problems::{Recipe, random};

/// Two contacts of a wedged body with friction 1.5: the percussions n = (1, −1.2, 1, 1.2), within the cones, move nothing but
/// for `opening` of the last row of H, and n·b = −`closing`. The solution has percussions of closing/(1.44 opening²).
fn wedge(opening: f64, closing: f64) -> ConeProblem<f64, 2> {
    let h = [[1.0, 0.0, 1.2, 0.0], [0.0, 1.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, opening]];
    let w = |i: usize, j: usize| (0..4).map(|k| h[i][k] * h[j][k]).sum::<f64>();
    let delassus = BlockMatrix::from_fn(2, |i, j| Matrix2::from_fn(|k, l| w(2 * i + k, 2 * j + l)));
    let b = vec![vector![-0.1, 0.05], vector![-0.1 - closing, 0.26 / 1.2]];
    ConeProblem::new(delassus, b, vec![1.5; 2]).expect("a problem")
}

/// Whether the chosen solver failed, so that there was something to rescue.
fn rescued<const D: usize>(recipe: &Recipe) -> bool {
    let problem = random::<f64, D>(recipe);
    let zero = vec![SVector::<f64, D>::zeros(); recipe.contacts];
    let mut r = zero.clone();
    // No time for more than one iteration.
    let mut solver =
        build::<f64, D>("extragradient", Stopping { max_seconds: Some(1e-9), ..Stopping::default() })
            .expect("registered");
    let first = solver.solve(&problem, &zero, &mut r);
    let failed = matches!(first, Err(SolveError::NotConverged { .. }));
    let error = first.err();
    let Some(error) = error.filter(|_| failed) else { return false };
    let solution = nonsmooth::solver::rescue(error, &Stopping::default(), &problem, &[], &mut r)
        .unwrap_or_else(|error| panic!("{recipe:?}: {error}"));
    assert!(solution.rescued_by.is_some());
    let residual = problem.residual(&r).scaled;
    let near = match solution.accuracy {
        Accuracy::Tolerance => 1e-10,
        Accuracy::Rounding { floor } => 256.0 * floor,
    };
    assert!(residual <= near, "{recipe:?}: residual {residual:e}");
    true
}

#[test]
fn solvable_problems_are_solved_after_a_failure() {
    let mut count = 0;
    for seed in 0..60 {
        let contacts = 2 + seed as usize % 9;
        let recipe = Recipe {
            seed,
            contacts,
            freedom: 2 + contacts,
            friction: [0.0, 0.3, 1.0, 7.0][seed as usize % 4],
            decades: 1.0,
        };
        count += usize::from(rescued::<1>(&recipe));
        count += usize::from(rescued::<2>(&recipe));
        count += usize::from(rescued::<3>(&recipe));
    }
    assert!(count > 90, "the chosen solver failed on {count} of 180 problems only");
}

#[test]
fn what_the_chosen_solver_solves_is_left_alone() {
    let recipe = Recipe { seed: 3, contacts: 4, freedom: 12, friction: 0.3, decades: 1.0 };
    let problem = random::<f64, 3>(&recipe);
    let zero = vec![SVector::<f64, 3>::zeros(); 4];
    let (mut r, mut same) = (zero.clone(), zero.clone());
    let mut solver = Nsgs::<f64, 3>::solver(Stopping::default(), NsgsSettings::default()).expect("in range");
    let alone = solver.solve(&problem, &zero, &mut r).expect("an easy problem");
    let door = solve_or_rescue(&mut solver, &problem, (&zero, &[]), &mut same).expect("an easy problem");
    assert_eq!((alone, r), (door, same));
    assert_eq!(door.rescued_by, None);
}

/// Two walls close in on a body: nothing opens both contacts.
fn squeezed() -> ConeProblem<f64, 1> {
    let delassus = BlockMatrix::from_fn(2, |i, j| nalgebra::matrix![if i == j { 1.0 } else { -1.0 }]);
    ConeProblem::new(delassus, vec![vector![-1.0], vector![-1.0]], vec![0.0; 2]).expect("a problem")
}

#[test]
fn a_problem_without_solution_ends_in_an_error_that_tells_what_was_tried() {
    let problem = squeezed();
    let zero = vec![SVector::<f64, 1>::zeros(); 2];
    let mut r = zero.clone();
    let mut solver = build::<f64, 1>("hybrid", Stopping::default()).expect("registered");
    let error = solve_or_rescue(&mut *solver, &problem, (&zero, &zero), &mut r).expect_err("no solution");
    let SolveError::Unsolved(attempts) = &error else { panic!("{error}") };
    assert!(matches!(&attempts.first, SolveError::NotConverged { solver: "hybrid", .. }), "{error}");
    assert!(attempts.others.len() >= 2, "{attempts:?}");
    // The best that two contacts can do is to share what is missing: residual ½ of b each.
    for attempt in &attempts.others {
        assert!(attempt.residual >= 0.5, "{attempt:?}");
    }
    assert!(error.to_string().contains("further attempts"), "{error}");
    #[cfg(feature = "clarabel")]
    assert!(attempts.margin.is_some_and(|margin| margin < 0.0), "{attempts:?}");
    // What is left in r is the best of all.
    let least = attempts.others.iter().map(|attempt| attempt.residual).fold(f64::INFINITY, f64::min);
    assert!(problem.residual(&r).scaled <= least * (1.0 + 1e-12), "{r:?}");
}

#[test]
fn a_rescue_keeps_to_a_multiple_of_the_time_limit() {
    // Many contacts without solution: every method would work to the end of its budget.
    let m = 120;
    let delassus = BlockMatrix::from_fn(m, |i, j| nalgebra::matrix![if i % 2 == j % 2 { 1.0 } else { -1.0 }]);
    let problem = ConeProblem::new(delassus, vec![vector![-1.0]; m], vec![0.0; m]).expect("a problem");
    let zero = vec![SVector::<f64, 1>::zeros(); m];
    let mut r = zero.clone();
    let limit = 0.2;
    let stopping = Stopping { max_seconds: Some(limit), ..Stopping::default() };
    let mut solver = build::<f64, 1>("hybrid", stopping).expect("registered");
    let clock = std::time::Instant::now();
    let error = solve_or_rescue(&mut *solver, &problem, (&zero, &[]), &mut r).expect_err("no solution");
    let seconds = clock.elapsed().as_secs_f64();
    assert!(matches!(error, SolveError::Unsolved(_)), "{error}");
    // The solve itself, the rescue, and a second for the certificate and an iteration begun before the end, on a machine
    // that others use.
    assert!(seconds <= limit * (1.0 + RESCUE_TIME) + 1.0, "{seconds} s");
}

#[test]
fn a_wedge_open_by_its_overlap_alone_is_solved_to_rounding() {
    // W has an eigenvalue of the order of opening², smaller than what a proximal step adds to it.
    for opening in [1e-3, 1e-5, 3e-7] {
        let problem = wedge(opening, 1e-6);
        let zero = vec![SVector::<f64, 2>::zeros(); 2];
        let mut r = zero.clone();
        let mut solver = build::<f64, 2>("hybrid", Stopping::default()).expect("registered");
        let solution = solve_or_rescue(&mut *solver, &problem, (&zero, &[]), &mut r)
            .unwrap_or_else(|error| panic!("opening {opening:e}: {error}"));
        assert!(solution.residual.scaled <= 1e-10_f64.max(problem.floor(&r)), "{solution:?}");
    }
}
