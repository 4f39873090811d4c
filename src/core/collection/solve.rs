//! `nonsmooth solve`: every file, one line.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use cpu_time::ThreadTime;
use nalgebra::SVector;

#[cfg(feature = "clarabel")]
use super::Verdict;
use super::lines::{heading, json_line, text_line};
use super::{Certificate, CollectionError, SolveReport, Statuses, problem_name};
use crate::cone::{ConeProblem, Form, Residual};
use crate::fclib::{self, Cone, FclibError};
use crate::registry::Registry;
use crate::scalar::{Scalar, epsilon, lit, to_f64};
use crate::solver::{self, Accuracy, Progress, SolveError, Stopping, UnknownSolver};

/// A percussion within this relative distance of the boundary of its cone slides. Percussions of redundant contacts are
/// known to fewer digits than the velocities the tolerance speaks of.
pub const STATUS_TOLERANCE: f64 = 1e-6;

/// What `solve` is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct SolveOptions {
    /// Name of the solver. Default [`solver::DEFAULT`].
    pub solver: String,
    /// Tolerance on the scaled residual (dimensionless). Default 1e-10.
    pub tolerance: f64,
    /// Largest wall time of one problem in seconds; default none.
    pub max_seconds: Option<f64>,
    /// Whether solutions are put into the files of their problems. Default no.
    pub write_solution: bool,
}

impl Default for SolveOptions {
    fn default() -> Self {
        Self { solver: solver::DEFAULT.into(), tolerance: 1e-10, max_seconds: None, write_solution: false }
    }
}

/// What came of all files.
#[derive(Debug, Default)]
pub struct Solved {
    /// Problems that were tried, in the order of the files.
    pub reports: Vec<SolveReport>,
    /// Files that hold no problem, or whose solution could not be written.
    pub failures: Vec<(PathBuf, CollectionError)>,
}

impl Solved {
    /// 0 where every problem was solved, 1 where a solver did not converge, 2 where a file could not be used.
    pub fn exit_code(&self) -> u8 {
        match (self.failures.is_empty(), self.reports.iter().all(|report| report.converged)) {
            (false, _) => 2,
            (true, false) => 1,
            (true, true) => 0,
        }
    }
}

/// Solves every file and writes one line for each, as text or (`json`) as one JSON object.
///
/// A file that cannot be used is one line as well, with its error, and does not keep the others from being solved.
///
/// # Errors
/// [`CollectionError::Solver`] before the first file, [`CollectionError::Io`] where `out` fails.
pub fn solve_files(
    registry: &Registry,
    files: &[PathBuf],
    options: &SolveOptions,
    json: bool,
    out: &mut dyn Write,
) -> Result<Solved, CollectionError> {
    check(registry, options)?;
    let mut solved = Solved::default();
    let to_out = |source| CollectionError::Io { path: "output".into(), source };
    let width = files.iter().map(|f| problem_name(f).chars().count()).max().unwrap_or(0).max(7);
    if !json && !files.is_empty() {
        heading(out, width).map_err(to_out)?;
    }
    for file in files {
        match solve_file(registry, file, options) {
            Ok(report) => {
                if json {
                    json_line(out, &report).map_err(to_out)?;
                } else {
                    text_line(out, &report, width).map_err(to_out)?;
                }
                solved.reports.push(report);
            }
            Err(error) => {
                if json {
                    let (problem, error) = (problem_name(file), error.to_string());
                    json_line(out, &serde_json::json!({ "problem": problem, "error": error }))
                        .map_err(to_out)?;
                } else {
                    writeln!(out, "{error}").map_err(to_out)?;
                }
                solved.failures.push((file.clone(), error));
            }
        }
    }
    out.flush().map_err(to_out)?;
    Ok(solved)
}

/// Reads a file, solves its problem from r = 0, and puts the solution into the file where that is asked for and found.
///
/// The solver converges on the scaled residual. Where the natural-map residual is then still above the tolerance it goes
/// on, for a few tries, from where it stands; that one depends on units, so it decides nothing.
///
/// # Errors
/// [`CollectionError::File`], [`CollectionError::Solve`], [`CollectionError::Solver`].
pub fn solve_file(
    registry: &Registry,
    path: &Path,
    options: &SolveOptions,
) -> Result<SolveReport, CollectionError> {
    check(registry, options)?;
    let in_file = |source| CollectionError::File { path: path.into(), source };
    let stored = fclib::read(path).map_err(in_file)?;
    let name = problem_name(path);
    let (report, percussions) = match stored.cone_in(Form::Auto).map_err(in_file)? {
        Cone::Planar(cone) => solve(registry, &name, &cone, options)?,
        Cone::Spatial(cone) => solve(registry, &name, &cone, options)?,
    };
    if options.write_solution && report.converged {
        let put = |percussions| -> Result<(), FclibError> {
            fclib::write_solution(path, &stored.solution(percussions)?)
        };
        put(percussions).map_err(in_file)?;
    }
    Ok(report)
}

fn check(registry: &Registry, options: &SolveOptions) -> Result<(), CollectionError> {
    stopping(options).check().map_err(UnknownSolver::from)?;
    registry.find_solver(&options.solver)?;
    Ok(())
}

fn stopping(options: &SolveOptions) -> Stopping<f64> {
    Stopping { tolerance: options.tolerance, max_iterations: None, max_seconds: options.max_seconds }
}

fn solve<const D: usize>(
    registry: &Registry,
    name: &str,
    cone: &ConeProblem<f64, D>,
    options: &SolveOptions,
) -> Result<(SolveReport, Vec<f64>), CollectionError> {
    let cpu = ThreadTime::now();
    let mut attempt = attempt(registry, name, cone, &options.solver, &stopping(options), None)?;
    let mut rescued_by = None;
    if let Some(failure) = attempt.failure.take() {
        match solver::rescue(failure, &stopping(options), cone, &[], &mut attempt.r) {
            Ok(solution) => {
                (attempt.iterations, attempt.residual) = (solution.iterations, solution.residual);
                rescued_by = solution.rescued_by.map(String::from);
            }
            Err(error) => {
                attempt.residual = cone.residual(&attempt.r);
                attempt.reason = attempt.reason.or_else(|| attempts(&error));
            }
        }
    }
    let cpu_seconds = cpu.elapsed().as_secs_f64();
    let count = cone.count_status(&attempt.r, STATUS_TOLERANCE);
    let converged = attempt.residual.scaled <= options.tolerance;
    let report = SolveReport {
        problem: name.into(),
        contacts: cone.contacts(),
        dimension: D,
        solver: options.solver.clone(),
        converged,
        iterations: attempt.iterations,
        residual: attempt.residual.natural,
        scaled_residual: attempt.residual.scaled,
        cpu_seconds,
        status: Statuses { take_off: count.take_off, stick: count.stick, slide: count.slide },
        rescued_by,
        reason: attempt.reason.filter(|_| !converged),
        certificate: if converged { None } else { certificate(cone) },
    };
    Ok((report, attempt.r.iter().flat_map(|r| r.iter().copied()).collect()))
}

/// How much was tried in vain.
fn attempts(error: &SolveError) -> Option<String> {
    match error {
        SolveError::Unsolved(attempts) => Some(format!("nor did {} further attempts", attempts.others.len())),
        _ => None,
    }
}

/// Where a solver came to.
pub(super) struct Reached<T: Scalar, const D: usize> {
    pub(super) r: Vec<SVector<T, D>>,
    pub(super) iterations: usize,
    pub(super) residual: Residual<T>,
    /// Tolerance on the scaled residual of the last call.
    pub(super) tolerance: T,
    pub(super) reason: Option<String>,
    /// The error of the call that missed the tolerance, where no earlier one had reached it.
    pub(super) failure: Option<SolveError>,
}

/// Calls made at most to bring the natural-map residual below the tolerance, too.
const CALLS: usize = 4;

/// Solves from r = 0 until both residuals are within the tolerance, or until the solver gives up.
pub(super) fn attempt<T: Scalar, const D: usize>(
    registry: &Registry,
    name: &str,
    cone: &ConeProblem<T, D>,
    solver: &str,
    stopping: &Stopping<T>,
    mut observer: Option<&mut dyn FnMut(Progress<T>)>,
) -> Result<Reached<T, D>, CollectionError> {
    let clock = Instant::now();
    let zero = vec![SVector::<T, D>::zeros(); cone.contacts()];
    let mut best = Reached {
        residual: Residual { natural: T::infinity_impl(), scaled: T::infinity_impl() },
        iterations: 0,
        tolerance: stopping.tolerance,
        reason: None,
        failure: None,
        r: zero.clone(),
    };
    let mut r = zero;
    for call in 1..=CALLS {
        let left = stopping.max_seconds.map(|limit| limit - clock.elapsed().as_secs_f64());
        if call > 1 && left.is_some_and(|left| left <= 0.0) {
            break;
        }
        let stage = Stopping { tolerance: best.tolerance, max_seconds: left, ..stopping.clone() };
        let mut solver = registry.build_solver::<T, D>(solver, stage)?;
        let before = best.iterations;
        let mut shifted = |progress: Progress<T>| {
            if let Some(observer) = observer.as_mut() {
                observer(Progress { iterations: before + progress.iterations, ..progress });
            }
        };
        let (iterations, residual, reason) =
            match solver.solve_observed(cone, &best.r, &mut r, Some(&mut shifted)) {
                Ok(solution) => {
                    let reason = match solution.accuracy {
                        Accuracy::Tolerance => None,
                        Accuracy::Rounding { floor } => {
                            let floor = to_f64(floor);
                            Some(Some(format!("rounding of the percussions leaves {floor:e}")))
                        }
                    };
                    (solution.iterations, solution.residual, reason)
                }
                Err(failure @ SolveError::NotConverged { .. }) => {
                    best.failure = (call == 1).then(|| failure.clone());
                    let SolveError::NotConverged { iterations, residual, natural, reason, .. } = failure
                    else {
                        break;
                    };
                    (
                        iterations,
                        Residual { natural: lit(natural), scaled: lit(residual) },
                        Some(reason.map(|reason| reason.to_string())),
                    )
                }
                Err(source) => return Err(CollectionError::Solve { problem: name.into(), source }),
            };
        best.iterations += iterations;
        // A later call must not undo what an earlier one reached.
        let better = residual.scaled <= best.residual.scaled || residual.natural <= best.residual.natural;
        if call == 1 || (better && residual.scaled <= stopping.tolerance) {
            (best.residual, best.reason) = (residual, reason.clone().flatten());
            best.r.copy_from_slice(&r);
        }
        if reason.is_some() || residual.natural <= stopping.tolerance {
            break;
        }
        // Half of what the natural map asks for; below the rounding of the scalar there is nothing to reach.
        let next = best.tolerance * lit::<T>(0.5) * stopping.tolerance / residual.natural;
        if !(next >= epsilon()) {
            break;
        }
        best.tolerance = next;
    }
    Ok(best)
}

#[cfg(feature = "clarabel")]
fn certificate<const D: usize>(cone: &ConeProblem<f64, D>) -> Option<Certificate> {
    use crate::solver::Feasibility;
    Some(match solver::feasibility(cone).ok()? {
        Feasibility::Strict { margin, .. } => {
            Certificate { verdict: Verdict::Feasible, margin, direction: None }
        }
        Feasibility::Separated { margin, direction } => {
            let direction = Some(direction.iter().flat_map(|d| d.iter().copied()).collect());
            Certificate { verdict: Verdict::Infeasible, margin, direction }
        }
        Feasibility::Undecided { margin, .. } => {
            Certificate { verdict: Verdict::Undecided, margin, direction: None }
        }
    })
}

/// Without clarabel nothing decides.
#[cfg(not(feature = "clarabel"))]
fn certificate<const D: usize>(_cone: &ConeProblem<f64, D>) -> Option<Certificate> {
    None
}
