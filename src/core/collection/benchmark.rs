//! Every solver on every problem: times, residuals, curves.

use std::path::{Path, PathBuf};
use std::time::Instant;

use cpu_time::ThreadTime;
use nalgebra::SVector;
use serde::{Deserialize, Serialize};

use super::solve::{Reached, attempt};
use super::{CollectionError, problem_name};
use crate::cone::{ConeProblem, Form};
use crate::fclib::{self, Cone};
use crate::registry::Registry;
use crate::scalar::{Scalar, lit, to_f64};
use crate::solver::{Progress, Stopping, UnknownSolver};

/// What a comparison is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct BenchmarkOptions {
    /// Names of the solvers; none is every registered one. Default none.
    pub solvers: Vec<String>,
    /// A problem counts as solved where both residuals are within this. Default 1e-8.
    pub tolerance: f64,
    /// Largest wall time of one solve in seconds. Default 30.
    pub max_seconds: f64,
    /// Timings taken, of which the shortest counts; solves beyond 2 s are timed once. Default 3.
    pub repeat: usize,
}

impl Default for BenchmarkOptions {
    fn default() -> Self {
        Self { solvers: Vec::new(), tolerance: 1e-8, max_seconds: 30.0, repeat: 3 }
    }
}

/// A point of a curve of residual against time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Point {
    /// Iterations so far, in the unit of the solver.
    pub iterations: usize,
    /// Wall time since the start (s).
    pub seconds: f64,
    /// Scaled residual as the solver estimates it; of the last point, as measured on the problem.
    pub residual: f64,
}

/// One solver on one problem.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Name of the problem.
    pub problem: String,
    /// Number of contacts.
    pub contacts: usize,
    /// Dimension of a contact.
    pub dimension: usize,
    /// Name of the solver.
    pub solver: String,
    /// Whether it is a peer's, measured elsewhere.
    pub peer: bool,
    /// Arithmetic, `f64` or `f32`; of a peer, as far as it is known.
    pub scalar: String,
    /// The tolerance.
    pub tolerance: f64,
    /// Whether both residuals are within the tolerance (a peer: as it was judged).
    pub solved: bool,
    /// Iterations.
    pub iterations: usize,
    /// Natural-map residual.
    pub residual: f64,
    /// Scaled residual; not a number for a peer.
    pub scaled_residual: f64,
    /// CPU time of one solve (s); of an unsolved problem, of the attempt.
    pub cpu_seconds: f64,
    /// Residual against time.
    #[serde(skip)]
    pub curve: Vec<Point>,
}

/// All measurements of a comparison.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Benchmark {
    /// One per problem and solver.
    pub measurements: Vec<Measurement>,
    /// The tolerance.
    pub tolerance: f64,
}

impl Benchmark {
    /// Runs every solver on every file; `tell` is shown each measurement when it is there.
    ///
    /// Each solve starts from r = 0. Where the scaled residual is within the tolerance but the natural one is not, the
    /// tolerance handed to the solver is lowered until both are, and the solve that is timed is one from the start to
    /// that tolerance. Solves below a millisecond are timed many at a time.
    ///
    /// # Errors
    /// [`CollectionError`] at the first file or solver that cannot be used.
    pub fn run(
        registry: &Registry,
        files: &[PathBuf],
        options: &BenchmarkOptions,
        tell: &mut dyn FnMut(&Measurement),
    ) -> Result<Self, CollectionError> {
        let all = || registry.solvers().map(|solver| solver.name.into()).collect();
        let solvers: Vec<String> = if options.solvers.is_empty() { all() } else { options.solvers.clone() };
        options.stopping::<f64>().check().map_err(UnknownSolver::from)?;
        for name in &solvers {
            registry.find_solver(name)?;
        }
        let mut measurements = Vec::new();
        for file in files {
            let cone = read(file)?;
            for name in &solvers {
                let measured = measure(registry, &problem_name(file), &cone, name, options)?;
                tell(&measured);
                measurements.push(measured);
            }
        }
        Ok(Self { measurements, tolerance: options.tolerance })
    }
}

impl BenchmarkOptions {
    fn stopping<T: Scalar>(&self) -> Stopping<T> {
        Stopping { tolerance: lit(self.tolerance), max_iterations: None, max_seconds: Some(self.max_seconds) }
    }
}

/// Reads the cone problem of a file.
///
/// # Errors
/// [`CollectionError::File`].
pub fn read(file: &Path) -> Result<Cone, CollectionError> {
    let read = || fclib::read(file)?.cone_in(Form::Auto);
    read().map_err(|source| CollectionError::File { path: file.into(), source })
}

/// Measures one solver on one problem.
///
/// # Errors
/// [`CollectionError::Solve`], [`CollectionError::Solver`].
pub fn measure(
    registry: &Registry,
    problem: &str,
    cone: &Cone,
    solver: &str,
    options: &BenchmarkOptions,
) -> Result<Measurement, CollectionError> {
    match cone {
        Cone::Planar(cone) => measure_in(registry, problem, cone, cone, solver, options),
        Cone::Spatial(cone) => measure_in(registry, problem, cone, cone, solver, options),
    }
}

/// [`measure`] in single precision. The percussions are judged by the residuals of the problem in double precision.
///
/// # Errors
/// As [`measure`].
pub fn measure_single(
    registry: &Registry,
    problem: &str,
    cone: &Cone,
    solver: &str,
    options: &BenchmarkOptions,
) -> Result<Measurement, CollectionError> {
    match cone {
        Cone::Planar(cone) => measure_in(registry, problem, cone, &cone.cast::<f32>(), solver, options),
        Cone::Spatial(cone) => measure_in(registry, problem, cone, &cone.cast::<f32>(), solver, options),
    }
}

/// Solves `cone` and judges the percussions by `judge`, the same problem in double precision.
fn measure_in<T: Scalar, const D: usize>(
    registry: &Registry,
    problem: &str,
    judge: &ConeProblem<f64, D>,
    cone: &ConeProblem<T, D>,
    name: &str,
    options: &BenchmarkOptions,
) -> Result<Measurement, CollectionError> {
    let mut curve: Vec<Point> = Vec::new();
    let (cpu, clock) = (ThreadTime::now(), Instant::now());
    let judged = |r: &[SVector<T, D>]| {
        judge.residual(&r.iter().map(|r| r.map(to_f64)).collect::<Vec<SVector<f64, D>>>())
    };
    let mut record = |Progress { iterations, residual }: Progress<T>| {
        // A hundredth of progress is enough for a figure.
        let last = curve.last().map_or(0, |point| point.iterations);
        if last < 100 || iterations >= last + last / 100 {
            let seconds = clock.elapsed().as_secs_f64();
            curve.push(Point { iterations, seconds, residual: to_f64(residual) });
        }
    };
    let Reached { r, iterations, tolerance, .. } =
        attempt(registry, problem, cone, name, &options.stopping(), Some(&mut record))?;
    let (mut cpu_seconds, seconds) = (cpu.elapsed().as_secs_f64(), clock.elapsed().as_secs_f64());
    let residual = judged(&r);
    curve.push(Point { iterations, seconds, residual: residual.scaled });
    let mut measured = Measurement {
        problem: problem.into(),
        contacts: cone.contacts(),
        dimension: D,
        solver: name.into(),
        peer: false,
        scalar: T::NAME.into(),
        tolerance: options.tolerance,
        solved: residual.scaled <= options.tolerance && residual.natural <= options.tolerance,
        iterations,
        residual: residual.natural,
        scaled_residual: residual.scaled,
        cpu_seconds,
        curve,
    };
    if !measured.solved {
        return Ok(measured);
    }

    let stopping = Stopping { tolerance, ..options.stopping() };
    let mut solver = registry.build_solver::<T, D>(name, stopping)?;
    let start = vec![SVector::zeros(); cone.contacts()];
    let mut r = start.clone();
    let repeat =
        if cpu_seconds > 2.0 && to_f64(tolerance) == options.tolerance { 0 } else { options.repeat.max(1) };
    let mut timed = None::<f64>;
    for _ in 0..repeat {
        // Many at a time below the millisecond, so that the clock does not count.
        let batch = (1e-3 / cpu_seconds.max(1e-9)).ceil().clamp(1.0, 10_000.0) as usize;
        let cpu = ThreadTime::now();
        let mut outcome = solver.solve(cone, &start, &mut r);
        for _ in 1..batch {
            outcome = solver.solve(cone, &start, &mut r);
        }
        let time = cpu.elapsed().as_secs_f64() / batch as f64;
        cpu_seconds = time;
        // The solve that is timed is the one that is judged: from the start in one go.
        let residual = judged(&r);
        if let Ok(solution) = outcome {
            measured.iterations = solution.iterations;
        }
        (measured.residual, measured.scaled_residual) = (residual.natural, residual.scaled);
        measured.solved = residual.natural <= options.tolerance && residual.scaled <= options.tolerance;
        timed = Some(timed.map_or(time, |best| best.min(time)));
        if time > 2.0 || !measured.solved {
            break;
        }
    }
    measured.cpu_seconds = timed.unwrap_or(measured.cpu_seconds);
    Ok(measured)
}
