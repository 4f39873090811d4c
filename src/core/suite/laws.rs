//! A law keeps its claim: no contact creates energy, and the balance (56) closes.

use std::cell::Cell;
use std::ops::RangeInclusive;

use nalgebra::{DMatrix, SVector};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{TestCaseError, TestError};

use super::strategies::asked;
use super::{RandomSystem, Suite, SuiteFailure, check_claim_is_sharp, random_system};
use crate::cone::{ConeProblem, largest_eigenvalue};
use crate::contact::pose;
use crate::laws::{Approach, ContactLaw, Rows};
use crate::linalg::Symmetric;
use crate::scheme::{Activation, ActivationRule, Settings, ThetaScheme};
use crate::solver::{self, ConeSolver, SOLVERS, SolveError, Stopping};
use crate::system::{Forces, Lagrangian, SmoothGap};

/// Share of the random problems a solver may report as not converged: such a report is honest, but says nothing of
/// the law.
const UNSOLVED: f64 = 0.05;

/// Steps of a balance run.
const STEPS: usize = 60;

/// Makes an instance of a law from numbers in [0, 1], one for each of its parameters.
pub type Draw<'a, const D: usize> = dyn Fn(&[f64]) -> Box<dyn ContactLaw<f64, D>> + 'a;

/// Tests a law in every dimension, D = 1, 2, 3, and 6 where it rolls, with every solver; `draw` makes an instance from `parameters` numbers in [0, 1].
///
/// # Errors
/// [`SuiteFailure`] with the smallest case found.
pub fn check_law<L>(suite: &Suite, parameters: usize, draw: impl Fn(&[f64]) -> L) -> Result<(), SuiteFailure>
where
    L: ContactLaw<f64, 1> + ContactLaw<f64, 2> + ContactLaw<f64, 3> + ContactLaw<f64, 6> + 'static,
{
    let one = |unit: &[f64]| -> Box<dyn ContactLaw<f64, 1>> { Box::new(draw(unit)) };
    let two = |unit: &[f64]| -> Box<dyn ContactLaw<f64, 2>> { Box::new(draw(unit)) };
    let three = |unit: &[f64]| -> Box<dyn ContactLaw<f64, 3>> { Box::new(draw(unit)) };
    let six = |unit: &[f64]| -> Box<dyn ContactLaw<f64, 6>> { Box::new(draw(unit)) };
    check_law_everywhere(suite, parameters, (&one, &two, &three, &six))
}

/// [`check_law`], compiled once for all laws: what an author waits for is the law itself.
fn check_law_everywhere(
    suite: &Suite,
    parameters: usize,
    (one, two, three, six): (&Draw<'_, 1>, &Draw<'_, 2>, &Draw<'_, 3>, &Draw<'_, 6>),
) -> Result<(), SuiteFailure> {
    check_law_in(suite, parameters, one)?;
    check_law_in(suite, parameters, two)?;
    check_law_in(suite, parameters, three)?;
    // Six rows are for laws that roll.
    let rolls = six(&vec![0.5; parameters]).rows() == Rows::Rolling;
    if rolls { check_law_in(suite, parameters, six) } else { Ok(()) }
}

/// [`check_law`] in one contact dimension.
///
/// # Errors
/// [`SuiteFailure`] with the smallest case found.
pub fn check_law_in<const D: usize>(
    suite: &Suite,
    parameters: usize,
    draw: &Draw<'_, D>,
) -> Result<(), SuiteFailure> {
    for description in SOLVERS {
        check_dissipation::<D>(suite, description.name, parameters, draw)?;
        check_lasting::<D>(suite, description.name, parameters, draw)?;
        check_balance::<D>(suite, description.name, parameters, draw)?;
    }
    check_claim_is_sharp::<D>(suite, parameters, draw)
}

/// The interval in which all laws claim dissipation, `None` where one claims nothing or there is none.
fn common_claim<const D: usize>(laws: &[Box<dyn ContactLaw<f64, D>>]) -> Option<RangeInclusive<f64>> {
    let mut common = 0.0_f64..=1.0;
    for law in laws {
        let claim = law.dissipative_theta()?;
        common = f64::max(*common.start(), *claim.start())..=f64::min(*common.end(), *claim.end());
    }
    (common.start() <= common.end()).then_some(common)
}

type Laws<const D: usize> = Vec<Box<dyn ContactLaw<f64, D>>>;

/// Instances for `contacts` contacts and a θ all of them claim: different ones where their intervals meet, else
/// the first everywhere.
fn instances<const D: usize>(
    draw: &Draw<'_, D>,
    unit: &[Vec<f64>],
    contacts: usize,
    share: f64,
) -> Option<(Laws<D>, f64)> {
    let different: Vec<Box<dyn ContactLaw<f64, D>>> =
        unit.iter().cycle().take(contacts).map(|unit| draw(unit)).collect();
    let same = || (0..contacts).map(|_| draw(&unit[0])).collect::<Vec<Box<dyn ContactLaw<f64, D>>>>();
    let laws = if common_claim(&different).is_some() { different } else { same() };
    let claim = common_claim(&laws)?;
    Some((laws, claim.start() + share * (claim.end() - claim.start())))
}

pub(super) fn failure<const D: usize, V: std::fmt::Debug>(
    property: &'static str,
    solver: &str,
) -> impl FnOnce(TestError<V>) -> SuiteFailure {
    let solver = solver.to_string();
    move |error| SuiteFailure { property, dimension: D, solver, case: error.to_string() }
}

/// Inside the claimed interval u_{k+θ}·p ≤ 0 at every contact, for random masses, Jacobians (half of them
/// rank-deficient), states and active sets: separating contacts are active too.
///
/// The bound on the works is that of [`work_bound`]. A law that claims nothing passes.
///
/// # Errors
/// [`SuiteFailure`] where a contact creates energy, or the solver leaves more than 2 % of the problems unsolved.
pub fn check_dissipation<const D: usize>(
    suite: &Suite,
    solver: &str,
    parameters: usize,
    draw: &Draw<'_, D>,
) -> Result<(), SuiteFailure> {
    let property = "contacts dissipate";
    let unsolved = Cell::new(0);
    let unit = vec(vec(0.0..=1.0, parameters), 4);
    let cases = (random_system::<D>(4), unit, 0.0..=1.0);
    let run = suite.runner().run(&cases, |(system, unit, share)| {
        let Some((laws, theta)) = instances(draw, &unit, system.contacts(), share) else { return Ok(()) };
        let mut solver = build::<D>(solver)?;
        let impact = |_, u| Approach::impact(u, theta);
        match works(&system, &laws, impact, &mut *solver)? {
            Ok((works, bound)) => {
                prop_assert!(
                    works.iter().all(|&w| w <= bound),
                    "works {works:?}, bound {bound:e}, θ {theta}"
                );
            }
            Err(SolveError::NotConverged { .. }) => unsolved.set(unsolved.get() + 1),
            Err(error) => return Err(TestCaseError::fail(error.to_string())),
        }
        Ok(())
    });
    run.map_err(failure::<D, _>(property, solver))?;
    if f64::from(unsolved.get()) > (UNSOLVED * f64::from(suite.cases)).max(1.0) {
        let case = format!("{} of {} problems were not solved", unsolved.get(), suite.cases);
        return Err(SuiteFailure {
            property: "problems are solved",
            dimension: D,
            solver: solver.into(),
            case,
        });
    }
    Ok(())
}

/// Contacts that last keep u_{k+θ}·p ≤ 0 at every θ of [`ContactLaw::lasting_theta`], whatever their gaps, open, closed or
/// overlapping, and velocities. A law that claims nothing passes.
///
/// # Errors
/// [`SuiteFailure`] where a contact creates energy.
pub fn check_lasting<const D: usize>(
    suite: &Suite,
    solver: &str,
    parameters: usize,
    draw: &Draw<'_, D>,
) -> Result<(), SuiteFailure> {
    let unit = vec(0.0..=1.0, parameters);
    let cases = (random_system::<D>(4), unit, 0.0..=1.0, vec(-1e-2..1e-2, 4));
    let run = suite.runner().run(&cases, |(system, unit, share, gaps)| {
        let laws: Vec<Box<dyn ContactLaw<f64, D>>> = (0..system.contacts()).map(|_| draw(&unit)).collect();
        let Some(claim) = laws[0].lasting_theta() else { return Ok(()) };
        let theta = claim.start() + share * (claim.end() - claim.start());
        let lasting = |i: usize, u| Approach::impact(u, theta).with_gap(gaps[i], 1e-2, true);
        // What is not solved says nothing of the law; `check_dissipation` counts it.
        let Ok((works, bound)) = works(&system, &laws, lasting, &mut *build::<D>(solver)?)? else {
            return Ok(());
        };
        prop_assert!(works.iter().all(|&w| w <= bound), "works {works:?}, bound {bound:e}, θ {theta}");
        Ok(())
    });
    run.map_err(failure::<D, _>("lasting contacts dissipate", solver))
}

fn build<const D: usize>(name: &str) -> Result<Box<dyn ConeSolver<f64, D>>, TestCaseError> {
    solver::build(name, Stopping::default()).map_err(|error| TestCaseError::fail(error.to_string()))
}

/// How far a contact work can be positive for the residual of the cone problem alone: a velocity of
/// tolerance × ‖b‖ on the percussions, and percussions of tolerance × ‖b‖/λ on velocities of size ‖b‖, both with a
/// factor 10 for the norms of several contacts.
pub fn work_bound<const D: usize>(
    problem: &ConeProblem<f64, D>,
    p: &[SVector<f64, D>],
    tolerance: f64,
) -> f64 {
    let norm = p.iter().map(SVector::norm_squared).sum::<f64>().sqrt();
    let lambda = (0..problem.contacts()).map(|i| largest_eigenvalue(problem.diagonal(i)));
    let b = problem.b_norm();
    10.0 * tolerance * b * (norm + b / lambda.fold(f64::INFINITY, f64::min))
}

/// Works of the contacts and their bound, or why they were not found.
type Works = Result<(Vec<f64>, f64), SolveError>;

/// u_{k+θ}·p of every contact, and their bound; `ask` is what the law of contact i is asked at velocity u_k.
fn works<const D: usize>(
    system: &RandomSystem<D>,
    laws: &[Box<dyn ContactLaw<f64, D>>],
    ask: impl Fn(usize, SVector<f64, D>) -> Approach<'static, f64, D>,
    solver: &mut dyn ConeSolver<f64, D>,
) -> Result<Works, TestCaseError> {
    let before = system.local_before();
    let (mut shifts, mut cones, mut thetas) = (Vec::new(), Vec::new(), Vec::new());
    for (i, (law, &u)) in laws.iter().zip(&before).enumerate() {
        let approach = asked(&**law, ask(i, u));
        let posed = pose(&**law, &approach, &SVector::zeros());
        let (shift, cone) = posed.map_err(|error| TestCaseError::fail(error.to_string()))?;
        shifts.push(shift);
        cones.push(cone);
        thetas.push(approach.theta);
    }
    let problem = system.problem(&shifts, cones);
    let zeros = vec![SVector::zeros(); laws.len()];
    let mut p = zeros.clone();
    if let Err(error) = solver.solve(&problem, &zeros, &mut p) {
        return Ok(Err(error));
    }
    // u_{k+1} = W p + H v_free: the shifted velocity less the shift.
    let after = |i: usize| problem.shifted_velocity(i, &p) - shifts[i];
    let work = |i: usize| (before[i] * (1.0 - thetas[i]) + after(i) * thetas[i]).dot(&p[i]);
    let bound = work_bound(&problem, &p, solver.stopping().tolerance);
    Ok(Ok(((0..laws.len()).map(work).collect(), bound)))
}

/// Over random systems with mass, damping, stiffness and three contacts, for many steps and any active set, the
/// balance (56) closes to round-off whatever the law, and no contact of a law that claims dissipation creates
/// energy.
///
/// Round-off is 1e-13 of the energy turned over in the step; the works are bounded by [`work_bound`].
///
/// # Errors
/// [`SuiteFailure`] with the step and the numbers.
pub fn check_balance<const D: usize>(
    suite: &Suite,
    solver: &str,
    parameters: usize,
    draw: &Draw<'_, D>,
) -> Result<(), SuiteFailure> {
    let unit = vec(vec(0.0..=1.0, parameters), 3);
    let cases = (random_system::<D>(3), unit, 0.0..=1.0, vec(0.0..0.05, 3), vec(0.0..3.0, 4));
    // A run of many steps weighs as much as many problems.
    let few = Suite { cases: suite.cases.div_ceil(8), ..suite.clone() };
    let run = few.runner().run(&cases, |(system, unit, share, gaps, weights)| {
        let contacts = system.contacts();
        let (laws, theta) = match instances(draw, &unit, contacts, share) {
            Some(claimed) => claimed,
            None => ((0..contacts).map(|_| draw(&unit[0])).collect(), 0.5 + 0.5 * share),
        };
        let claims = common_claim(&laws).is_some();
        let solver = build::<D>(solver)?;
        let tolerance = solver.stopping().tolerance;
        let mut settings = Settings::new(theta, 0.02);
        settings.activation = Activation::new(ActivationRule::PredictedGap);
        let n = system.mass.len();
        let lagrangian = lagrangian(&system, &gaps, &weights);
        let (q, v) = (vec![0.0; n], system.before.clone());
        let mut scheme = ThetaScheme::new(Box::new(lagrangian), laws, solver, settings, 0.0, q, v)
            .map_err(|error| TestCaseError::fail(error.to_string()))?;
        for _ in 0..STEPS {
            let Ok(step) = scheme.step().cloned() else { return Ok(()) };
            let balance = &step.balance;
            let turned_over = step.energies.mechanical()
                + balance.external_work.abs()
                + balance.normal_contact_work.abs()
                + balance.tangential_contact_work.abs();
            prop_assert!(
                balance.imbalance.abs() <= 1e-13 * turned_over,
                "imbalance {:e} of {turned_over:e}, step {}",
                balance.imbalance,
                scheme.state().index
            );
            let p: Vec<_> = step.contacts.iter().map(|contact| contact.percussion).collect();
            let bound = work_bound(scheme.cone_problem(), &p, tolerance);
            for contact in &step.contacts {
                let work = contact.normal_work + contact.tangential_work;
                prop_assert!(!claims || work <= bound, "work {work:e} > {bound:e}, θ {theta}");
            }
        }
        Ok(())
    });
    run.map_err(failure::<D, _>("the balance (56) closes and contacts dissipate", solver))
}

/// The random system with linear gaps g^α = H^α_N q + g₀ and random positive semidefinite C and K.
fn lagrangian<const D: usize>(system: &RandomSystem<D>, gaps: &[f64], weights: &[f64]) -> Lagrangian<f64, D> {
    let n = system.mass.len();
    let dense = |seed: f64, weight: f64| {
        let a = DMatrix::from_fn(n, n, |i, j| (seed + (3 * i + 7 * j) as f64).sin());
        Symmetric::dense(&a * a.transpose() * weight).expect("A Aᵀ is symmetric")
    };
    let mut lagrangian = Lagrangian::new(Symmetric::Diagonal(system.mass.clone()))
        .with_damping(dense(weights[0], 0.1 * weights[1]))
        .and_then(|l| l.with_stiffness(dense(weights[2], 5.0 * weights[3])))
        .and_then(|l| {
            l.with_forces(Forces::constant((0..n).map(|i| if i == 0 { -5.0 } else { 0.3 }).collect()))
        })
        .expect("the sizes agree")
        .with_scales(1.0, 1.0);
    for (i, &gap) in (0..system.contacts()).zip(gaps) {
        let row: Vec<(usize, SVector<f64, D>)> = system.jacobian.row(i).map(|(j, h)| (j, *h)).collect();
        let columns = row.clone();
        let value = move |q: &[f64]| gap + row.iter().map(|&(j, h)| h[0] * q[j]).sum::<f64>();
        let jacobian = move |_: &[f64], push: &mut dyn FnMut(usize, SVector<f64, D>)| {
            columns.iter().for_each(|&(j, h)| push(j, h));
        };
        lagrangian = lagrangian.with_contact(i, SmoothGap::new(value, jacobian));
    }
    lagrangian
}
