//! `nonsmooth solve` and `nonsmooth compare`: cone problems from files.

use std::error::Error;
use std::io::{IsTerminal as _, Write as _};
use std::path::PathBuf;
use std::process::ExitCode;

use crate::collection::{Benchmark, BenchmarkOptions, SolveOptions, problem_files, solve_files};
use crate::registry::Registry;
use crate::solver::DEFAULT;

/// What `solve` takes.
#[derive(Debug, clap::Args)]
pub(super) struct SolveArguments {
    /// Problem files in the FCLIB layout (HDF5), local or global.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Cone solver.
    #[arg(long, default_value = DEFAULT)]
    solver: String,
    /// Tolerance on the scaled residual.
    #[arg(long, default_value_t = 1e-10, allow_negative_numbers = true)]
    tol: f64,
    /// Largest time spent on one problem, in seconds.
    #[arg(long, allow_negative_numbers = true)]
    max_seconds: Option<f64>,
    /// Print one JSON object per problem.
    #[arg(long)]
    json: bool,
    /// Put the solutions into the files of their problems.
    #[arg(long)]
    write_solution: bool,
}

/// What `compare` takes.
#[derive(Debug, clap::Args)]
pub(super) struct CompareArguments {
    /// Folder of problem files in the FCLIB layout (HDF5).
    folder: PathBuf,
    /// Solvers to compare, separated by commas [default: all].
    #[arg(long, value_delimiter = ',')]
    solver: Vec<String>,
    /// Tolerance on both residuals.
    #[arg(long, default_value_t = 1e-8, allow_negative_numbers = true)]
    tol: f64,
    /// Largest time spent on one problem by one solver, in seconds.
    #[arg(long, default_value_t = 30.0, allow_negative_numbers = true)]
    max_seconds: f64,
    /// Results of another program over the same problems, as NAME=FILE with one JSON line per problem and solver.
    #[arg(long)]
    peer: Vec<String>,
    /// Problem whose curves of residual against time are drawn [default: the largest].
    #[arg(long)]
    curves: Option<String>,
    /// Folder of the tables and figures.
    #[arg(long, default_value = "out/compare")]
    out: PathBuf,
}

/// Solves every file, one line each.
pub(super) fn solve(arguments: &SolveArguments, registry: &Registry) -> Result<ExitCode, Box<dyn Error>> {
    let options = SolveOptions {
        solver: arguments.solver.clone(),
        tolerance: arguments.tol,
        max_seconds: arguments.max_seconds,
        write_solution: arguments.write_solution,
    };
    let mut out = std::io::stdout().lock();
    let solved = solve_files(registry, &arguments.files, &options, arguments.json, &mut out)?;
    Ok(ExitCode::from(solved.exit_code()))
}

/// Runs every solver over every problem of a folder.
pub(super) fn compare(arguments: &CompareArguments, registry: &Registry) -> Result<ExitCode, Box<dyn Error>> {
    let files = problem_files(&arguments.folder)?;
    let options = BenchmarkOptions {
        solvers: arguments.solver.clone(),
        tolerance: arguments.tol,
        max_seconds: arguments.max_seconds,
        ..BenchmarkOptions::default()
    };
    let watched = std::io::stderr().is_terminal();
    let mut benchmark = Benchmark::run(registry, &files, &options, &mut |measured| {
        if watched {
            eprint!("\r\x1b[K{} with {}", measured.problem, measured.solver);
        }
    })?;
    if watched {
        eprint!("\r\x1b[K");
    }
    for peer in &arguments.peer {
        let (name, file) =
            peer.split_once('=').ok_or_else(|| format!("--peer {peer}: expected NAME=FILE"))?;
        benchmark.add_peer(name, file.as_ref())?;
    }
    let own = arguments.solver.first().map_or(DEFAULT, |name| name);
    let mut out = std::io::stdout().lock();
    benchmark.write_table(own, &mut out)?;
    benchmark.write_csv(own, &arguments.out)?;
    benchmark.profile_figure().save(&arguments.out.join("profile"))?;
    let largest = benchmark.measurements.iter().max_by_key(|measured| measured.contacts);
    let shown = arguments.curves.clone().or_else(|| largest.map(|measured| measured.problem.clone()));
    if let Some(problem) = shown {
        benchmark.curve_figure(&problem).save(&arguments.out.join("curves"))?;
    }
    writeln!(out, "\ntables and figures in {}", arguments.out.display())?;
    Ok(ExitCode::SUCCESS)
}
