//! A solver does what it says: its solutions are solutions, its failures are typed, and it fails seldom.

use std::cell::Cell;

use nalgebra::SVector;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

use super::laws::failure;
use super::{Suite, SuiteFailure, random_system};
use crate::cone::{Cone, ConeProblem, ProblemError, contains};
use crate::solver::{Accuracy, ConeSolver, SolveError, Stopping};

/// Share of the random problems a solver may leave unsolved, and say so.
const UNSOLVED: f64 = 0.05;

/// Relative distance from K that percussions of a solution may have: they are projected, up to rounding.
const OUTSIDE: f64 = 1e-9;

/// Makes the solver under test for contacts of dimension D.
pub type BuildSolver<'a, const D: usize> = dyn Fn(Stopping<f64>) -> Box<dyn ConeSolver<f64, D>> + 'a;

/// A solver in every contact dimension.
pub trait SolverFamily {
    /// The solver with a stopping rule.
    fn build<const D: usize>(&self, stopping: Stopping<f64>) -> Box<dyn ConeSolver<f64, D>>;
}

/// Tests a solver on random problems of 1 to 4 contacts, half of them with a singular W: frictionless ones (D = 1), Coulomb
/// friction (D = 2, 3), and rolling resistance in the plane (D = 3) and in space (D = 6).
///
/// - What it calls a solution has a scaled residual within the tolerance, measured again, and percussions in their cones.
/// - The same problem from the same start has the same solution, to the last bit.
/// - It leaves at most 5 % of the problems unsolved, with [`SolveError::NotConverged`].
/// - Data that are no problem, and starts of a wrong length, are refused by type; a start that is not finite is not.
///
/// ```
/// use nonsmooth::solver::{ConeSolver, Method, Nsgs, NsgsSettings, Stopping};
/// use nonsmooth::suite::{SolverFamily, Suite, check_solver};
///
/// struct Sweeps;
///
/// impl SolverFamily for Sweeps {
///     fn build<const D: usize>(&self, stopping: Stopping<f64>) -> Box<dyn ConeSolver<f64, D>> {
///         Box::new(Nsgs::solver(stopping, NsgsSettings::default()).expect("in range"))
///     }
/// }
///
/// check_solver(&Suite { cases: 8, ..Suite::default() }, &Sweeps).unwrap();
/// ```
///
/// # Errors
/// [`SuiteFailure`] with the smallest case found.
pub fn check_solver(suite: &Suite, family: &impl SolverFamily) -> Result<(), SuiteFailure> {
    check_solver_in::<1>(suite, false, &|stopping| family.build(stopping))?;
    check_solver_in::<2>(suite, false, &|stopping| family.build(stopping))?;
    check_solver_in::<3>(suite, false, &|stopping| family.build(stopping))?;
    check_solver_in::<3>(suite, true, &|stopping| family.build(stopping))?;
    check_solver_in::<6>(suite, true, &|stopping| family.build(stopping))
}

/// [`check_solver`] in one contact dimension, with Coulomb's cones or with cones that roll (D = 3, 6).
///
/// # Errors
/// [`SuiteFailure`] with the smallest case found.
pub fn check_solver_in<const D: usize>(
    suite: &Suite,
    rolling: bool,
    build: &BuildSolver<'_, D>,
) -> Result<(), SuiteFailure> {
    let stopping = Stopping::<f64>::default();
    let name = build(stopping.clone()).name();
    let (unsolved, solved) = (Cell::new(0), Cell::new(0));
    let coefficient = || prop_oneof![1 => Just(0.0), 6 => 0.0..1.0f64];
    let cases =
        (random_system::<D>(4), vec((coefficient(), coefficient(), coefficient()), 4), vec(-1.0..1.0f64, D));
    let run = suite.runner().run(&cases, |(system, coefficients, start)| {
        let cones = coefficients.iter().take(system.contacts()).map(|&(friction, rolling_, spinning)| {
            if rolling { Cone::Rolling { friction, rolling: rolling_, spinning } } else { friction.into() }
        });
        let shifts = vec![SVector::zeros(); system.contacts()];
        let problem = system.problem(&shifts, cones.collect());
        for start in [SVector::zeros(), SVector::<f64, D>::from_column_slice(&start)] {
            let start = vec![start; system.contacts()];
            let (mut r, mut again) = (start.clone(), start.clone());
            let result = build(stopping.clone()).solve(&problem, &start, &mut r);
            match result {
                Ok(solution) => {
                    solved.set(solved.get() + 1);
                    check_solution(&problem, &r, solution.accuracy, stopping.tolerance)?;
                }
                Err(SolveError::NotConverged { .. }) => {
                    unsolved.set(unsolved.get() + 1);
                    continue;
                }
                Err(error) => return Err(TestCaseError::fail(error.to_string())),
            }
            let repeated = build(stopping.clone()).solve(&problem, &start, &mut again);
            prop_assert!(repeated.is_ok() && r == again, "{r:?} once, {again:?} another time");
        }
        Ok(())
    });
    run.map_err(failure::<D, _>("solutions are solutions", name))?;
    let (unsolved, all) = (unsolved.get(), unsolved.get() + solved.get());
    if f64::from(unsolved) > (UNSOLVED * f64::from(all)).max(1.0) {
        let case = format!("{unsolved} of {all} problems were not solved");
        return Err(SuiteFailure {
            property: "problems are solved",
            dimension: D,
            solver: name.into(),
            case,
        });
    }
    check_refusals(build).map_err(|case| SuiteFailure {
        property: "bad data are refused by type",
        dimension: D,
        solver: name.into(),
        case,
    })
}

fn check_solution<const D: usize>(
    problem: &ConeProblem<f64, D>,
    r: &[SVector<f64, D>],
    accuracy: Accuracy<f64>,
    tolerance: f64,
) -> Result<(), TestCaseError> {
    let allowed = match accuracy {
        Accuracy::Tolerance => tolerance,
        Accuracy::Rounding { floor } => tolerance.max(floor),
    };
    let residual = match accuracy {
        Accuracy::Tolerance => problem.residual(r).scaled,
        Accuracy::Rounding { .. } => problem.precise_residual(r).scaled,
    };
    prop_assert!(residual <= allowed, "residual {residual:e}, allowed {allowed:e}");
    let size = r.iter().map(|r| r.norm()).fold(0.0, f64::max);
    for (r, &cone) in r.iter().zip(problem.cones()) {
        prop_assert!(contains(r, cone, OUTSIDE * size), "{r:?} lies outside of {cone:?}");
    }
    Ok(())
}

/// One contact with W = I, b = −e_N, in the arithmetic of the refusals.
fn check_refusals<const D: usize>(build: &BuildSolver<'_, D>) -> Result<(), String> {
    let solve = |problem: &ConeProblem<f64, D>, start: &[SVector<f64, D>], count: usize| {
        build(Stopping::default()).solve(problem, start, &mut vec![SVector::zeros(); count])
    };
    let mut down = SVector::<f64, D>::zeros();
    down[0] = -1.0;
    let w = || crate::cone::BlockMatrix::from_fn(1, |_, _| nalgebra::SMatrix::identity());
    let mut problem = ConeProblem::new(w(), vec![down], vec![0.5]).map_err(|error| error.to_string())?;
    let zero = [SVector::zeros()];
    match solve(&problem, &[], 1) {
        Err(SolveError::Shape { contacts: 1, given: 0 }) => {}
        other => return Err(format!("a start without percussions gives {other:?}")),
    }
    if let Err(error) = solve(&problem, &[SVector::repeat(f64::NAN)], 1) {
        return Err(format!("a start that is not finite gives {error}"));
    }
    problem.terms_mut().0[0][0] = f64::NAN;
    match solve(&problem, &zero, 1) {
        Err(SolveError::Problem(ProblemError::NotFinite { .. })) => Ok(()),
        other => Err(format!("b = NaN gives {other:?}")),
    }
}
