//! Arguments, exit codes and the commands that need no file of their own.
//!
//! Exit codes: 0 done; 1 a run or a solve ended before its aim; 2 the input or the output cannot be used;
//! 130 interrupted.

mod problems;
mod progress;
mod report;
mod run;
mod study;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::{Parser, Subcommand};

use crate::registry::Registry;
use crate::scene::ScalarName;

/// Nonsmooth contact dynamics: unilateral contact, impact and Coulomb friction.
#[derive(Debug, Parser)]
#[command(name = "nonsmooth", version, about, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a scene: every law with every solver it names, then compare them.
    Run(RunArguments),
    /// Solve cone problems from FCLIB files, one line each.
    Solve(problems::SolveArguments),
    /// Run every solver over a folder of cone problems: table, curves, performance profile.
    Compare(problems::CompareArguments),
    /// Run lists of settings over a scene, or solvers over problems: what accuracy costs.
    Study(study::StudyArguments),
    /// List the contact laws with their parameters.
    Laws,
    /// List the cone solvers and when to choose them.
    Solvers,
}

/// What `run` takes; options override the scene.
#[derive(Debug, clap::Args)]
struct RunArguments {
    /// Scene file (TOML).
    scene: PathBuf,
    /// Laws to run, separated by commas.
    #[arg(long, value_delimiter = ',')]
    law: Vec<String>,
    /// Cone solvers to run, separated by commas.
    #[arg(long, value_delimiter = ',')]
    solver: Vec<String>,
    /// Scheme parameter θ in [0, 1].
    #[arg(long, allow_hyphen_values = true)]
    theta: Option<f64>,
    /// Fixed time step h in seconds.
    #[arg(long, allow_hyphen_values = true)]
    step: Option<f64>,
    /// Steps under error control, with this error in q and v as a share of the scene's length.
    #[arg(long, value_name = "TOLERANCE", allow_hyphen_values = true, conflicts_with = "step")]
    adaptive: Option<f64>,
    /// End of the run in seconds.
    #[arg(long, allow_hyphen_values = true)]
    end: Option<f64>,
    /// Tolerance of the solver on the scaled residual.
    #[arg(long, allow_hyphen_values = true)]
    tol: Option<f64>,
    /// Arithmetic of the run.
    #[arg(long)]
    scalar: Option<ScalarName>,
    /// Accept a θ outside the interval in which a law is proved dissipative.
    #[arg(long)]
    allow_unproved_theta: bool,
    /// Mesh of the elastic body (Gmsh, MSH 2.0 to 4.1), in place of the scene's.
    #[arg(long)]
    mesh: Option<PathBuf>,
    /// Folder of the results [default: out/<name of the scene file>].
    #[arg(long)]
    out: Option<PathBuf>,
    /// Write no figures, and no page that shows the motion.
    #[arg(long)]
    no_figures: bool,
    /// Write cone problems that no solver solves to this folder, as FCLIB files.
    #[arg(long, value_name = "DIR")]
    save_failures: Option<PathBuf>,
    /// Leave a checkpoint every so many steps, which --resume goes on from.
    #[arg(long, value_name = "STEPS", conflicts_with = "resume", value_parser = clap::value_parser!(u64).range(1..))]
    checkpoint: Option<u64>,
    /// Go on from the last checkpoint in this folder of results, with the scene and the options of the run that
    /// left it.
    #[arg(long, value_name = "DIR", conflicts_with = "out")]
    resume: Option<PathBuf>,
}

/// A run ended before its end time because a step failed.
const FAILED: u8 = 1;
/// The input or the output cannot be used.
const UNUSABLE: u8 = 2;
/// Interrupted by Ctrl-C.
const INTERRUPTED: u8 = 130;

/// The program `nonsmooth`, with the laws and solvers of `registry`: reads the arguments of the process, does what they say
/// and returns the exit code.
///
/// A program with laws of one's own is this function over a registry of one's own:
///
/// ```no_run
/// # use std::process::ExitCode;
/// use nonsmooth::cli;
///
/// fn main() -> ExitCode {
///     cli::run(&nonsmooth::registry())
/// }
/// ```
pub fn run(registry: &Registry) -> ExitCode {
    run_with(registry, std::env::args_os())
}

/// [`run`] with these arguments in place of those of the process, the first of them the name of the program.
///
/// Arguments that cannot be understood, and those that ask for help, end the process, as in [`run`].
pub fn run_with<A: Into<OsString> + Clone>(
    registry: &Registry,
    arguments: impl IntoIterator<Item = A>,
) -> ExitCode {
    let done = match Arguments::parse_from(arguments).command {
        Command::Run(arguments) => run::run(&arguments, registry),
        Command::Solve(arguments) => problems::solve(&arguments, registry),
        Command::Compare(arguments) => problems::compare(&arguments, registry),
        Command::Study(arguments) => study::study(&arguments, registry),
        Command::Laws => report::laws(registry),
        Command::Solvers => report::solvers(registry),
    };
    done.unwrap_or_else(|error| {
        eprintln!("error: {error}");
        ExitCode::from(UNUSABLE)
    })
}

/// A flag that Ctrl-C raises, lowered.
fn interrupt_flag() -> Result<&'static AtomicBool, ctrlc::Error> {
    static RAISED: AtomicBool = AtomicBool::new(false);
    RAISED.store(false, Ordering::Relaxed);
    match ctrlc::set_handler(|| RAISED.store(true, Ordering::Relaxed)) {
        // A process has one handler: the one of an earlier call raises the same flag.
        Ok(()) | Err(ctrlc::Error::MultipleHandlers) => Ok(&RAISED),
        Err(error) => Err(error),
    }
}
