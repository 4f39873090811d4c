//! What the cases share: choices, checks, and driving a scheme within a budget of time.

use std::time::Instant;

use nonsmooth::laws::{self, ContactLaw};
use nonsmooth::scalar::{Scalar, lit, to_f64};
use nonsmooth::scheme::{Activation, ActivationRule, Settings, ThetaScheme};
use nonsmooth::solver::{self, ConeSolver, Stopping};
use nonsmooth::system::System;

/// A law and a solver by their registered names, and how much to do.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Choice<'a> {
    pub(crate) law: &'a str,
    pub(crate) solver: &'a str,
    /// The sizes of the table; otherwise smaller ones, for every test run.
    pub(crate) full: bool,
}

/// A number, what it should be, and how far from it it may be.
#[derive(Debug, Clone)]
pub(crate) struct Check {
    pub(crate) what: String,
    pub(crate) measured: f64,
    pub(crate) expected: f64,
    pub(crate) bound: f64,
    /// `expected` is a least value.
    pub(crate) least: bool,
}

impl Check {
    pub(crate) fn holds(&self) -> bool {
        self.off() <= self.bound
    }

    /// How far the number is from what it should be.
    pub(crate) fn off(&self) -> f64 {
        let off = self.expected - self.measured;
        if self.least { off.max(0.0) } else { off.abs() }
    }
}

/// What a run of a case measured.
#[derive(Debug, Clone, Default)]
pub(crate) struct Outcome {
    pub(crate) checks: Vec<Check>,
    pub(crate) notes: Vec<String>,
    pub(crate) steps: usize,
    pub(crate) solves: usize,
    pub(crate) iterations: usize,
    /// Time in the steps (s).
    pub(crate) seconds: f64,
    /// More wall time than a run may take by default (s).
    pub(crate) budget: f64,
}

impl Outcome {
    /// |measured − expected| ≤ bound.
    pub(crate) fn near(&mut self, what: impl Into<String>, measured: f64, expected: f64, bound: f64) {
        self.checks.push(Check { what: what.into(), measured, expected, bound, least: false });
    }

    /// |measured| ≤ bound.
    pub(crate) fn small(&mut self, what: impl Into<String>, measured: f64, bound: f64) {
        self.near(what, measured, 0.0, bound);
    }

    /// measured ≥ least.
    pub(crate) fn at_least(&mut self, what: impl Into<String>, measured: f64, least: f64) {
        let what = what.into();
        self.checks.push(Check { what, measured, expected: least, bound: 0.0, least: true });
    }

    pub(crate) fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }
}

/// A case gives numbers, or says what stopped it (with the residual, where that was a solver).
pub(crate) type Run = fn(&Choice<'_>) -> Result<Outcome, String>;

/// A line of the table.
pub(crate) struct Case {
    pub(crate) name: &'static str,
    /// The number asked for, with its source.
    pub(crate) number: &'static str,
    /// How it is modelled, and what to know of it.
    pub(crate) about: &'static str,
    /// A published or closed-form value beside ours.
    pub(crate) peer: &'static str,
    /// One for each scalar.
    pub(crate) runs: &'static [(&'static str, Run)],
}

pub(crate) type Law<T, const D: usize> = Box<dyn ContactLaw<T, D>>;
pub(crate) type Solver<T, const D: usize> = Box<dyn ConeSolver<T, D>>;
pub(crate) type Scheme<T, const D: usize> = ThetaScheme<T, D>;

/// The law of the choice.
pub(crate) fn law<T: Scalar, const D: usize>(choice: &Choice<'_>, e: f64, mu: f64) -> Law<T, D> {
    laws::build(choice.law, &[lit(e), lit(mu)]).expect("a registered law with restitution and friction")
}

/// θ as the law claims it: its smallest, ½ for a law without claim.
pub(crate) fn theta<T: Scalar, const D: usize>(law: &dyn ContactLaw<T, D>) -> T {
    law.dissipative_theta().map_or_else(|| lit(0.5), |claim| *claim.start())
}

/// Wall time a single solve may take (s): beyond it a solver is of no use in a step.
const SOLVE_SECONDS: f64 = 5.0;

/// Wall time the steps of a run may take by default (s).
const RUN_SECONDS: f64 = 60.0;

/// The solver of the choice with a tolerance (the scalar's default where that is coarser).
pub(crate) fn solver<T: Scalar, const D: usize>(choice: &Choice<'_>, tolerance: f64) -> Solver<T, D> {
    let floor = to_f64(nonsmooth::scalar::epsilon::<T>()) * 64.0;
    let stopping =
        Stopping { max_seconds: Some(SOLVE_SECONDS), ..Stopping::to(lit(f64::max(tolerance, floor))) };
    solver::build(choice.solver, stopping).expect("a registered solver")
}

/// A scheme with one law on every interface, `predicted-gap` activation and the law's θ.
pub(crate) fn scheme<T: Scalar, const D: usize, S: System<T, D> + 'static>(
    choice: &Choice<'_>,
    system: S,
    (e, mu): (f64, f64),
    h: f64,
    tolerance: f64,
    q: Vec<T>,
    v: Vec<T>,
) -> Result<Scheme<T, D>, String> {
    let laws: Vec<Law<T, D>> = (0..system.interfaces()).map(|_| law(choice, e, mu)).collect();
    let theta = laws.first().map_or_else(|| lit(0.5), |law| theta::<T, D>(&**law));
    scheme_of(system, laws, solver(choice, tolerance), (to_f64(theta), h), (None, false), (q, v))
}

/// A scheme with `predicted-gap` activation, a gap tolerance (m), by default that of rounding, and bodies at rest that
/// sleep or do not.
pub(crate) fn scheme_of<T: Scalar, const D: usize, S: System<T, D> + 'static>(
    system: S,
    laws: Vec<Law<T, D>>,
    solver: Solver<T, D>,
    (theta, h): (f64, f64),
    (gap_tolerance, sleep): (Option<f64>, bool),
    (q, v): (Vec<T>, Vec<T>),
) -> Result<Scheme<T, D>, String> {
    let activation =
        Activation { gap_tolerance: gap_tolerance.map(lit), ..Activation::new(ActivationRule::PredictedGap) };
    let settings = Settings { activation, sleep, ..Settings::new(lit(theta), lit(h)) };
    ThetaScheme::new(Box::new(system), laws, solver, settings, lit(0.0), q, v)
        .map_err(|error| error.to_string())
}

/// Makes `steps` steps, calls `after` with the scheme after each, and counts.
pub(crate) fn drive<T: Scalar, const D: usize>(
    scheme: &mut Scheme<T, D>,
    steps: usize,
    outcome: &mut Outcome,
    mut after: impl FnMut(&Scheme<T, D>),
) -> Result<(), String> {
    let start = Instant::now();
    let mut spent = 0.0;
    for done in 0..steps {
        let clock = Instant::now();
        scheme.step().map_err(|error| error.to_string())?;
        spent += clock.elapsed().as_secs_f64();
        if let Some(solution) = &scheme.last_step().solution {
            outcome.iterations += solution.iterations;
            outcome.solves += 1;
        }
        outcome.steps += 1;
        after(scheme);
        if done % 64 == 0 && outcome.seconds + start.elapsed().as_secs_f64() > outcome.budget.max(RUN_SECONDS)
        {
            let budget = outcome.budget.max(RUN_SECONDS);
            return Err(format!("stopped after {} of {steps} steps: {budget} s are over", done + 1));
        }
    }
    outcome.seconds += spent;
    Ok(())
}

/// The largest |v_i|, as f64.
pub(crate) fn fastest<T: Scalar>(v: &[T]) -> f64 {
    to_f64(nonsmooth::linalg::max_abs(v))
}

/// f64 of every component.
pub(crate) fn numbers<T: Scalar>(x: &[T]) -> Vec<f64> {
    x.iter().map(|&x| to_f64(x)).collect()
}
