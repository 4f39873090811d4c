//! Every registered solver, on the same problems.

mod random_problems;

use nalgebra::{DMatrix, RealField, SMatrix, SVector};
use nonsmooth::cone::{BlockMatrix, ConeProblem, largest_eigenvalue, solve_one_contact};
use nonsmooth::scalar::{Scalar, to_f64};
use nonsmooth::solver::{
    Accuracy, Admm, AdmmSettings, Extragradient, ExtragradientSettings, Hybrid, HybridSettings, Method, Nsgs,
    NsgsSettings, ProximalNewton, ProximalNewtonSettings, SOLVERS, SemismoothNewton,
    SemismoothNewtonSettings, SettingsError, Solution, SolveError, Stopping, StoppingError, build,
    default_tolerance,
};
use proptest::prelude::*;
use random_problems::{Recipe, random};

/// Solvers that have to solve every small problem that has a solution: they restart elsewhere when they cycle. No
/// proof covers the others once friction couples redundant contacts; they may end without a solution, but must then
/// say so and return their best.
const ROBUST: &[&str] = &["newton", "hybrid", "proximal-newton"];

/// Solvers whose rate falls with the condition of W.
const LOCAL: &[&str] = &["nsgs", "admm", "extragradient"];

/// Up to this coefficient of friction well-conditioned problems have one solution, and every solver finds it.
const SMALL_FRICTION: f64 = 0.2;

fn shifted_velocities<T: Scalar, const D: usize>(
    problem: &ConeProblem<T, D>,
    r: &[SVector<T, D>],
) -> Vec<SVector<T, D>> {
    (0..r.len()).map(|i| problem.shifted_velocity(i, r)).collect()
}

/// ‖a − b‖₂ over all contacts.
fn distance<T: Scalar, const D: usize>(a: &[SVector<T, D>], b: &[SVector<T, D>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| to_f64((a - b).norm_squared())).sum::<f64>().sqrt()
}

/// What a solver calls a solution has the residual it says, within the tolerance or what rounding leaves.
fn assert_is_solution<T: Scalar, const D: usize>(
    name: &str,
    problem: &ConeProblem<T, D>,
    r: &[SVector<T, D>],
    solution: &Solution<T>,
) {
    let (measured, bound) = match solution.accuracy {
        Accuracy::Tolerance => (problem.residual(r), default_tolerance::<T>()),
        Accuracy::Rounding { floor } => {
            assert_eq!(floor, problem.floor(r), "{name}");
            (problem.precise_residual(r), RealField::max(default_tolerance::<T>(), floor))
        }
    };
    assert_eq!(solution.residual, measured, "{name} reports another residual than its result has");
    assert!(solution.residual.scaled <= bound, "{name} calls {solution:?} a solution");
}

/// Solves from rest; an error must be an honest one.
fn attempt<T: Scalar, const D: usize>(
    name: &str,
    problem: &ConeProblem<T, D>,
) -> Result<Vec<SVector<T, D>>, SolveError> {
    let start = vec![SVector::<T, D>::zeros(); problem.contacts()];
    let mut r = start.clone();
    let mut solver = build::<T, D>(name, Stopping::default()).expect("registered");
    let tolerance = default_tolerance::<T>();
    match solver.solve(problem, &start, &mut r) {
        Ok(solution) => {
            assert_is_solution(name, problem, &r, &solution);
            Ok(r)
        }
        Err(error @ SolveError::NotConverged { residual, natural, .. }) => {
            assert!(residual > to_f64(tolerance), "{name} refuses a solution of residual {residual:e}");
            let measured = problem.residual(&r);
            assert_eq!((residual, natural), (to_f64(measured.scaled), to_f64(measured.natural)), "{name}");
            let rest = to_f64(problem.residual(&start).scaled);
            assert!(
                residual <= rest,
                "{name} returns {residual:e}, worse than the rest it began with, {rest:e}"
            );
            Err(error)
        }
        Err(error) => panic!("{name} refuses a good problem: {error}"),
    }
}

/// λ_max/λ_min of W.
fn condition<const D: usize>(problem: &ConeProblem<f64, D>) -> f64 {
    let m = problem.contacts();
    let mut dense = DMatrix::zeros(m * D, m * D);
    for i in 0..m {
        problem
            .delassus()
            .formed()
            .expect("formed")
            .row(i)
            .for_each(|(j, block)| dense.view_mut((i * D, j * D), (D, D)).copy_from(block));
    }
    let eigenvalues = dense.symmetric_eigenvalues();
    eigenvalues.max() / eigenvalues.min().max(0.0)
}

fn recipes(contacts: std::ops::RangeInclusive<usize>, friction: f64) -> impl Strategy<Value = (Recipe, f64)> {
    let friction = prop_oneof![1 => Just(0.0), 4 => 0.0..=friction];
    (any::<u64>(), contacts, friction, 0.0..=1.0f64, 0.0..=2.0f64).prop_map(
        |(seed, contacts, friction, share, decades)| {
            (Recipe { seed, contacts, freedom: 0, friction, decades }, share)
        },
    )
}

/// Full rank: more freedom than contact directions.
fn regular<const D: usize>((recipe, share): (Recipe, f64)) -> ConeProblem<f64, D> {
    let directions = recipe.contacts * D;
    random(&Recipe { freedom: directions + 1 + (share * directions as f64) as usize, ..recipe })
}

/// Rank-deficient: fewer degrees of freedom than contact directions (two contacts in the dimension D at least).
fn redundant<T: Scalar, const D: usize>((recipe, share): (Recipe, f64)) -> ConeProblem<T, D> {
    let directions = recipe.contacts * D;
    random(&Recipe { freedom: 1 + (share * (directions - 1) as f64) as usize, ..recipe })
}

fn solved_or_honest<T: Scalar, const D: usize>(problem: &ConeProblem<T, D>) {
    for solver in SOLVERS {
        let outcome = attempt(solver.name, problem);
        assert!(outcome.is_ok() || !ROBUST.contains(&solver.name), "{:?}", outcome.err());
    }
}

/// At small friction and full rank F = Φ(W·+b) is strongly monotone with constant c ≥ λ_min − μ λ_max/2 or so and
/// Lipschitz with L ≤ (1 + μ) λ_max, so that ‖r − r*‖ ≤ (1 + L)/c times the natural map and w moves by λ_max times
/// that: κ(1 + κ) residuals, with a factor 10 for the constants and the differing scales of the contacts.
fn agree_on_velocities<const D: usize>(problem: &ConeProblem<f64, D>) -> Result<(), TestCaseError> {
    let kappa = condition(problem);
    prop_assume!(kappa < 1e4);
    let bound = 10.0 * kappa * (1.0 + kappa) * default_tolerance::<f64>() * problem.b_norm();
    let mut first: Option<Vec<SVector<f64, D>>> = None;
    for solver in SOLVERS {
        let r = match attempt(solver.name, problem) {
            Ok(r) => r,
            Err(_) if !ROBUST.contains(&solver.name) => continue,
            Err(error) => return Err(TestCaseError::fail(format!("condition {kappa:e}: {error}"))),
        };
        let w = shifted_velocities(problem, &r);
        let apart = first.as_ref().map_or(0.0, |first| distance(first, &w));
        prop_assert!(apart <= bound, "{}: w is {apart:e} away, bound {bound:e}", solver.name);
        first.get_or_insert(w);
    }
    Ok(())
}

/// Without friction the problem is a convex quadratic program: r may not be unique where W is singular, w is.
/// Two points of residual ε differ by O(√ε) in the energy norm, hence the square root of the tolerance, times 10.
fn frictionless_velocities_are_unique<const D: usize>(
    problem: &ConeProblem<f64, D>,
) -> Result<(), TestCaseError> {
    let largest =
        (0..problem.contacts()).map(|i| largest_eigenvalue(problem.diagonal(i))).fold(0.0, f64::max);
    let least =
        (0..problem.contacts()).map(|i| largest_eigenvalue(problem.diagonal(i))).fold(f64::MAX, f64::min);
    let bound = 10.0 * (largest / least * default_tolerance::<f64>()).sqrt() * problem.b_norm();
    let mut first: Option<Vec<SVector<f64, D>>> = None;
    for solver in SOLVERS {
        let Ok(r) = attempt(solver.name, problem) else {
            prop_assert!(!ROBUST.contains(&solver.name), "{}", solver.name);
            continue;
        };
        let w = shifted_velocities(problem, &r);
        let apart = first.as_ref().map_or(0.0, |first| distance(first, &w));
        prop_assert!(apart <= bound, "{}: w is {apart:e} away, bound {bound:e}", solver.name);
        first.get_or_insert(w);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_regular_problem_is_solved_or_reported(recipe in recipes(1..=6, 1.0)) {
        solved_or_honest(&regular::<1>(recipe));
        solved_or_honest(&regular::<2>(recipe));
        solved_or_honest(&regular::<3>(recipe));
    }

    #[test]
    fn a_redundant_problem_is_solved_or_reported(recipe in recipes(2..=6, 1.0)) {
        solved_or_honest(&redundant::<f64, 1>(recipe));
        solved_or_honest(&redundant::<f64, 2>(recipe));
        solved_or_honest(&redundant::<f64, 3>(recipe));
    }

    #[test]
    fn single_precision_is_solved_or_reported(recipe in recipes(2..=6, 0.5)) {
        for solver in SOLVERS {
            // Either outcome is checked inside.
            let _ = attempt(solver.name, &redundant::<f32, 2>(recipe));
            let _ = attempt(solver.name, &redundant::<f32, 3>(recipe));
        }
    }

    /// Units far from any mechanics: nothing panics, nothing hangs, and where the squares of the data are numbers
    /// what is called a solution is one.
    #[test]
    fn absurd_magnitudes_are_survived(
        recipe in recipes(2..=4, 1.0),
        (mobility, velocity, friction) in (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64),
        decades in prop_oneof![Just(60.0), Just(300.0)],
    ) {
        let mut problem = redundant::<f64, 3>(recipe);
        {
            let (w, b, mu) = problem.parts_mut();
            let scaled = BlockMatrix::from_fn(b.len(), |i, j| {
                w.row(i).nth(j).expect("stored in full").1 * 10f64.powf(decades * mobility)
            });
            *w = scaled;
            b.iter_mut().for_each(|b| *b *= 10f64.powf(decades * velocity));
            mu.iter_mut().for_each(|mu| *mu = mu.scaled(10f64.powf(decades * friction)));
        }
        let start = vec![SVector::<f64, 3>::zeros(); problem.contacts()];
        for solver in SOLVERS {
            let stopping = Stopping { max_iterations: Some(50), ..Stopping::default() };
            let mut r = start.clone();
            match build::<f64, 3>(solver.name, stopping).expect("registered").solve(&problem, &start, &mut r) {
                Ok(solution) if decades <= 60.0 => assert_is_solution(solver.name, &problem, &r, &solution),
                Ok(_) => {}
                Err(SolveError::NotConverged { .. } | SolveError::Problem(_)) => {}
                Err(error) => return Err(TestCaseError::fail(error.to_string())),
            }
        }
    }

    #[test]
    fn solvers_agree_at_small_friction(recipe in recipes(1..=4, SMALL_FRICTION)) {
        agree_on_velocities(&regular::<1>(recipe))?;
        agree_on_velocities(&regular::<2>(recipe))?;
        agree_on_velocities(&regular::<3>(recipe))?;
    }

    #[test]
    fn redundant_contacts_without_friction_have_one_velocity((recipe, share) in recipes(2..=5, 0.0)) {
        let recipe = (Recipe { friction: 0.0, ..recipe }, share);
        frictionless_velocities_are_unique(&redundant::<f64, 1>(recipe))?;
        frictionless_velocities_are_unique(&redundant::<f64, 2>(recipe))?;
        frictionless_velocities_are_unique(&redundant::<f64, 3>(recipe))?;
    }

    #[test]
    fn one_contact_has_its_exact_solution(recipe in recipes(1..=1, SMALL_FRICTION)) {
        let problem = regular::<3>(recipe);
        let exact = solve_one_contact(problem.diagonal(0), &problem.b()[0], problem.cones()[0]);
        let kappa = condition(&problem);
        let scale = problem.b_norm() / largest_eigenvalue(problem.diagonal(0));
        for solver in SOLVERS {
            let r = attempt(solver.name, &problem);
            prop_assert!(r.is_ok(), "{:?}", r.err());
            let apart = distance(&r.unwrap_or_default(), &[exact]);
            // ‖r − r*‖ ≤ (1 + L)/c residuals, as for the velocities.
            prop_assert!(apart <= 10.0 * (1.0 + kappa) * default_tolerance::<f64>() * scale, "{}", solver.name);
        }
    }

    /// A start ten times better than asked for stays a solution through the scalings of every solver.
    #[test]
    fn a_solution_is_a_good_start(recipe in recipes(1..=5, SMALL_FRICTION)) {
        let problem = regular::<3>(recipe);
        let rest = vec![SVector::<f64, 3>::zeros(); problem.contacts()];
        let mut start = rest.clone();
        let better = Stopping::to(0.1 * default_tolerance::<f64>());
        let found = build::<f64, 3>("newton", better).expect("registered").solve(&problem, &rest, &mut start);
        // The spread of the scales may put 1e-11 below the round-off of a problem.
        prop_assume!(found.is_ok());
        for solver in SOLVERS {
            let mut r = start.clone();
            let solution = build::<f64, 3>(solver.name, Stopping::default())
                .expect("registered")
                .solve(&problem, &start, &mut r);
            prop_assert!(solution.is_ok(), "{} leaves a solution: {:?}", solver.name, solution);
        }
    }
}

#[test]
fn a_cold_solve_is_a_solve_from_zero() {
    let recipe = Recipe { seed: 3, contacts: 4, freedom: 12, friction: 0.3, decades: 1.0 };
    let problem = random::<f64, 3>(&recipe);
    let zero = vec![SVector::<f64, 3>::zeros(); 4];
    let (mut r, mut cold) = (zero.clone(), vec![SVector::from([f64::NAN; 3]); 4]);
    for solver in SOLVERS {
        let mut solver = build::<f64, 3>(solver.name, Stopping::to(1e-8)).expect("registered");
        let given = solver.solve(&problem, &zero, &mut r).map_err(|error| error.to_string());
        assert_eq!(solver.solve_cold(&problem, &mut cold).map_err(|error| error.to_string()), given);
        assert_eq!(r, cold);
    }
    let mut solver = build::<f64, 3>("hybrid", Stopping::default()).expect("registered");
    let error = solver.solve_cold(&problem, &mut cold[1..]).expect_err("one percussion too few");
    assert_eq!(error, SolveError::Shape { contacts: 4, given: 3 });
}

#[test]
fn settings_out_of_range_are_refused_with_the_number() {
    let rule = Stopping::<f64>::default;
    let told = |error: SettingsError| match error {
        SettingsError::OutOfRange { setting, value, range } => (setting, value, range.contains(value)),
        other => panic!("{other}"),
    };
    for bad in [0.0, -1.0, 11.0, f64::NAN, f64::INFINITY] {
        let settings = ProximalNewtonSettings::default().with_proximal(Some(bad));
        let (setting, value, inside) =
            told(ProximalNewton::<f64, 3>::solver(rule(), settings).expect_err("out of range"));
        assert_eq!((setting, value.to_bits(), inside), ("proximal", bad.to_bits(), false));
        let settings = SemismoothNewtonSettings::default().with_proximal_weight(bad);
        let error = SemismoothNewton::<f64, 3>::solver(rule(), settings).expect_err("out of range");
        assert_eq!(told(error).0, "proximal_weight");
        let settings = AdmmSettings::default().with_relaxation(bad);
        assert_eq!(told(Admm::<f64, 3>::solver(rule(), settings).expect_err("out of range")).0, "relaxation");
        let settings = ExtragradientSettings::default().with_contraction(bad);
        let error = Extragradient::<f64, 3>::solver(rule(), settings).expect_err("out of range");
        assert_eq!(told(error).0, "contraction");
        if bad != 11.0 && bad != f64::INFINITY {
            let error = Hybrid::<f64, 3>::solver(Stopping::to(bad), HybridSettings::default());
            assert!(matches!(error, Err(SettingsError::Stopping(StoppingError::Tolerance { .. }))));
        }
    }
    let deep = NsgsSettings::default().with_acceleration(11);
    let error = Nsgs::<f64, 3>::solver(rule(), deep).expect_err("11 > 10");
    assert_eq!(error.to_string(), "`acceleration` is 11, it must be in [0, 10]");
}

#[test]
fn an_empty_problem_has_an_empty_solution() {
    let problem = ConeProblem::<f64, 3>::new(BlockMatrix::new(), vec![], Vec::<f64>::new()).expect("empty");
    for solver in SOLVERS {
        let solution = build::<f64, 3>(solver.name, Stopping::default())
            .expect("registered")
            .solve(&problem, &[], &mut [])
            .expect(solver.name);
        assert_eq!(solution.iterations, 0);
    }
}

#[test]
fn data_that_are_no_problem_are_refused() {
    let mut problem =
        random::<f64, 2>(&Recipe { seed: 1, contacts: 3, freedom: 8, friction: 0.3, decades: 1.0 });
    problem.parts_mut().1[1][1] = f64::NAN;
    let (start, mut r) = (vec![SVector::zeros(); 3], vec![SVector::zeros(); 3]);
    for solver in SOLVERS {
        let outcome = build::<f64, 2>(solver.name, Stopping::default())
            .expect("registered")
            .solve(&problem, &start, &mut r);
        assert!(matches!(outcome, Err(SolveError::Problem(_))), "{}: {outcome:?}", solver.name);
    }
}

/// The same problems on every run, so that the solvers nothing is proven for are held to them too.
#[test]
fn every_solver_solves_small_friction() {
    for seed in 0..100 {
        let recipe = Recipe { seed, contacts: 5, freedom: 20, friction: SMALL_FRICTION, decades: 1.0 };
        for solver in SOLVERS {
            let planar = attempt(solver.name, &random::<f64, 2>(&recipe));
            let spatial = attempt(solver.name, &random::<f64, 3>(&recipe));
            assert!(planar.is_ok() && spatial.is_ok(), "seed {seed}: {:?} {:?}", planar.err(), spatial.err());
        }
    }
}

/// A body that four legs carry: D = 3, rank 6 of 12. The legs share its weight in no unique way, but they carry it.
#[test]
fn four_legs_carry_the_weight_of_a_table() {
    let (mass, inertia) = (2.0, [0.3, 0.2, 0.4]);
    let feet = [[0.5, 0.4], [-0.5, 0.4], [-0.5, -0.4], [0.5, -0.4]];
    // Velocity of a foot at (x, y, −1) in the frame (N = z, T1 = x, T2 = y) by the twist (v, ω) of the body.
    let jacobian = |[x, y]: [f64; 2]| {
        let z = -1.0;
        SMatrix::<f64, 3, 6>::from_row_slice(&[
            0.0, 0.0, 1.0, y, -x, 0.0, //
            1.0, 0.0, 0.0, 0.0, z, -y, //
            0.0, 1.0, 0.0, -z, 0.0, x,
        ])
    };
    let inverse = SMatrix::<f64, 6, 6>::from_diagonal(&SVector::<f64, 6>::from_row_slice(&[
        1.0 / mass,
        1.0 / mass,
        1.0 / mass,
        1.0 / inertia[0],
        1.0 / inertia[1],
        1.0 / inertia[2],
    ]));
    let w = BlockMatrix::from_fn(4, |i, j| jacobian(feet[i]) * inverse * jacobian(feet[j]).transpose());
    let (gravity_step, push) = (9.81e-3, 1e-3);
    let free = SVector::<f64, 6>::from_row_slice(&[push, 0.0, -gravity_step, 0.0, 0.0, 0.0]);
    let b = feet.iter().map(|&foot| jacobian(foot) * free).collect();
    let problem = ConeProblem::new(w, b, vec![0.5; 4]).expect("a cone problem");
    for solver in SOLVERS {
        let r = attempt(solver.name, &problem).expect(solver.name);
        // The push is weaker than friction, μ g h > push: everything sticks, and r balances the free momentum.
        let normal: f64 = r.iter().map(|r| r[0]).sum();
        let tangential: f64 = r.iter().map(|r| r[1]).sum();
        let accuracy = 100.0 * default_tolerance::<f64>() * mass * gravity_step;
        assert!((normal - mass * gravity_step).abs() <= accuracy, "{}: {normal}", solver.name);
        assert!((tangential + mass * push).abs() <= accuracy, "{}: {tangential}", solver.name);
    }
}

/// Contacts in a row, each coupled to its neighbours and to a mobility of its own.
fn row_of_contacts<const D: usize>(contacts: usize, own: f64) -> BlockMatrix<f64, D> {
    let mut w = BlockMatrix::new();
    for i in 0..contacts {
        w.start_row();
        if i > 0 {
            w.push(i - 1, -SMatrix::identity());
        }
        let above = if i + 1 < contacts { 1.0 } else { 0.0 };
        // The lowest body of a stack rests on the ground: one mass only.
        let below = if i > 0 { 1.0 } else { 0.0 };
        w.push(i, SMatrix::identity() * (1.0 + own + if above + below > 1.0 { 1.0 } else { below }));
        if i + 1 < contacts {
            w.push(i + 1, -SMatrix::identity());
        }
    }
    w
}

#[test]
fn a_thousand_contacts_in_a_row() {
    let mut stream = random_problems::Stream(3);
    let b = (0..1000)
        .map(|_| SVector::<f64, 3>::from_fn(|d, _| stream.normal() - if d == 0 { 1.0 } else { 0.0 }));
    let problem =
        ConeProblem::new(row_of_contacts(1000, 1.0), b.collect(), vec![0.2; 1000]).expect("a problem");
    let mut first: Option<Vec<SVector<f64, 3>>> = None;
    for solver in SOLVERS {
        let w = shifted_velocities(&problem, &attempt(solver.name, &problem).expect(solver.name));
        // The spectrum of W lies in [1, 5]: the bound of `agree_on_velocities` with κ = 5.
        let bound = 300.0 * default_tolerance::<f64>() * problem.b_norm();
        let apart = first.as_ref().map_or(0.0, |first| distance(first, &w));
        assert!(apart <= bound, "{}: {apart:e}", solver.name);
        first.get_or_insert(w);
    }
}

/// A thousand unit masses on top of one another, at rest under gravity: contact i carries the masses from i up. The
/// condition of W is 4·10⁵, which is too much for the methods that see only their neighbours.
#[test]
fn a_stack_carries_its_weight() {
    let (masses, weight) = (1000, 9.81e-3);
    // Free velocities are all −g h: only the lowest contact approaches.
    let b = (0..masses).map(|i| SVector::<f64, 2>::new(if i == 0 { -weight } else { 0.0 }, 0.0)).collect();
    let problem = ConeProblem::new(row_of_contacts(masses, 0.0), b, vec![0.3; masses]).expect("a stack");
    for solver in SOLVERS.iter().filter(|solver| !LOCAL.contains(&solver.name)) {
        let r = attempt(solver.name, &problem).expect(solver.name);
        for (i, r) in r.iter().enumerate() {
            let above = (masses - i) as f64 * weight;
            // The residual b·1e-10 is a velocity, and W⁻¹ of a stack amplifies it by up to m² masses.
            let accuracy = default_tolerance::<f64>() * weight * (masses * masses) as f64;
            assert!(
                (r[0] - above).abs() <= accuracy,
                "{}: contact {i} carries {} of {above}",
                solver.name,
                r[0]
            );
        }
    }
}

/// Two walls that close on a rigid body: nothing satisfies both, and every solver says so.
#[test]
fn closing_walls_have_no_solution() {
    let w = BlockMatrix::from_fn(2, |i, j| SMatrix::<f64, 1, 1>::new(if i == j { 1.0 } else { -1.0 }));
    let problem =
        ConeProblem::new(w, vec![SVector::<f64, 1>::new(-1.0); 2], vec![0.0; 2]).expect("a problem");
    for solver in SOLVERS {
        assert!(attempt(solver.name, &problem).is_err(), "{}", solver.name);
    }
}

#[cfg(feature = "clarabel")]
mod certificates {
    use super::*;
    use nonsmooth::cone::project;
    use nonsmooth::solver::{Feasibility, feasibility};

    #[test]
    fn closing_walls_are_separated() {
        let w = BlockMatrix::from_fn(2, |i, j| SMatrix::<f64, 1, 1>::new(if i == j { 1.0 } else { -1.0 }));
        let b = vec![SVector::<f64, 1>::new(-1.0); 2];
        let problem = ConeProblem::new(w, b, vec![0.0; 2]).expect("a problem");
        let Ok(Feasibility::Separated { margin, direction }) = feasibility(&problem) else {
            panic!("feasible")
        };
        // d = (1, 1)/2 and t = d·b = −1, to the accuracy of the convex program.
        assert!((margin + 1.0).abs() < 1e-6, "{margin}");
        assert!(
            (direction[0][0] - 0.5).abs() < 1e-6 && (direction[1][0] - 0.5).abs() < 1e-6,
            "{direction:?}"
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn separable_contacts_are_strictly_feasible(recipe in recipes(2..=6, 2.0)) {
            let problem = redundant::<f64, 3>(recipe);
            let Ok(Feasibility::Strict { margin, percussion }) = feasibility(&problem) else {
                return Err(TestCaseError::fail(format!("{:?}", feasibility(&problem))));
            };
            prop_assert!(margin > 0.0);
            for (w, &mu) in shifted_velocities(&problem, &percussion).iter().zip(problem.cones()) {
                prop_assert!(w[0] > mu.friction() * w.rows(1, 2).norm());
            }
        }

        /// A contact doubled with the opposite normal, both approaching: d = the sum of both normals separates.
        #[test]
        fn a_closed_gap_is_never_feasible(recipe in recipes(1..=4, 1.0), speed in 0.1..2.0f64) {
            let open = regular::<2>(recipe);
            let m = open.contacts();
            let side = |i: usize| if i < m { 1.0 } else { -1.0 };
            let w = BlockMatrix::from_fn(2 * m, |i, j| {
                let block = open.delassus().formed().expect("formed").row(i % m).nth(j % m).expect("stored in full").1;
                block * (side(i) * side(j))
            });
            let mu = open.cones()[0].friction();
            let b = vec![SVector::<f64, 2>::new(-speed, 0.0); 2 * m];
            let problem = ConeProblem::new(w, b, vec![mu; 2 * m]).expect("a problem");
            let outcome = feasibility(&problem);
            let Ok(Feasibility::Separated { direction, .. }) = outcome else {
                return Err(TestCaseError::fail(format!("{outcome:?}")));
            };
            let along: f64 = direction.iter().zip(problem.b()).map(|(d, b)| d.dot(b)).sum();
            prop_assert!(along < 0.0);
            for (d, &mu) in direction.iter().zip(problem.cones()) {
                prop_assert!((d - project(d, mu)).norm() <= 1e-6 * d.norm().max(1.0));
            }
        }
    }
}

/// What a checkpoint relies on: buffers are kept from solve to solve, memory is not.
fn a_solve_does_not_depend_on_the_solves_before<const D: usize>() {
    for solver in SOLVERS {
        let build = || build::<f64, D>(solver.name, Stopping::to(1e-8)).expect("registered");
        let mut used = build();
        for seed in 0..12 {
            let contacts = [3, 17, 5, 60][seed % 4];
            let freedom = if seed % 3 == 0 { contacts * D - 1 } else { contacts * D + 3 };
            let recipe = Recipe { seed: seed as u64, contacts, freedom, friction: 0.3, decades: 1.0 };
            let problem = random::<f64, D>(&recipe);
            let start: Vec<SVector<f64, D>> = (0..contacts)
                .map(|i| SVector::from_fn(|row, _| if row == 0 && i % 3 == 0 { 0.1 } else { 0.0 }))
                .collect();
            let (mut once, mut again) = (start.clone(), start.clone());
            let fresh = build().solve(&problem, &start, &mut once);
            let warm = used.solve(&problem, &start, &mut again);
            assert_eq!(
                once, again,
                "{}, D = {D}, {recipe:?}: other digits after other problems",
                solver.name
            );
            assert_eq!(fresh.is_ok(), warm.is_ok());
        }
    }
}

#[test]
fn solvers_have_no_memory() {
    a_solve_does_not_depend_on_the_solves_before::<1>();
    a_solve_does_not_depend_on_the_solves_before::<2>();
    a_solve_does_not_depend_on_the_solves_before::<3>();
}
