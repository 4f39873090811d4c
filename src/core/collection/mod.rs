//! Collections of problem files: solve each one, or compare every solver over all of them.
//!
//! [`solve_files`] is the command `nonsmooth solve`: one line per problem, with the residuals measured on the problem
//! and, where a solver gives up, the certificate that says whether there was anything to find. [`Benchmark`] measures
//! solvers over the same files: a table, residual against time, and the profiles of Dolan and Moré.

mod benchmark;
#[cfg(feature = "figures")]
mod figures;
mod lines;
mod peer;
mod profile;
mod report;
mod solve;
mod sweep;
#[cfg(feature = "figures")]
mod sweep_figures;
mod tables;

use std::path::{Path, PathBuf};

pub use benchmark::{Benchmark, BenchmarkOptions, Measurement, Point, measure, measure_single, read};
pub use profile::Profile;
pub use report::{Certificate, SolveReport, Statuses, Verdict};
pub use solve::{STATUS_TOLERANCE, SolveOptions, Solved, solve_file, solve_files};
pub use sweep::Sweep;
pub use tables::{Ratio, SolverSummary};

use crate::fclib::FclibError;
use crate::solver::{SolveError, UnknownSolver};

/// Why a collection could not be worked on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CollectionError {
    /// A problem file is not one.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: FclibError,
    },
    /// The solver refused the problem.
    #[error("{problem}: {source}")]
    Solve {
        /// Name of the problem.
        problem: String,
        /// What the solver said.
        source: SolveError,
    },
    /// No such solver, or a tolerance or budget that is none.
    #[error(transparent)]
    Solver(#[from] UnknownSolver),
    /// A folder or an output cannot be used.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A table of peer results is malformed.
    #[error("{}, line {line}: {message}", path.display())]
    Peer {
        /// The table.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong with it.
        message: String,
    },
    /// A table could not be written.
    #[error("{}: {source}", path.display())]
    Table {
        /// The table.
        path: PathBuf,
        /// What went wrong.
        source: csv::Error,
    },
}

/// The problem files (`.hdf5`, `.h5`) of a folder, by name; folders inside it are not entered.
///
/// # Errors
/// [`CollectionError::Io`] where the folder cannot be read.
pub fn problem_files(folder: impl AsRef<Path>) -> Result<Vec<PathBuf>, CollectionError> {
    let folder = folder.as_ref();
    let io = |source| CollectionError::Io { path: folder.into(), source };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        if path.is_file() && path.extension().is_some_and(|e| e == "hdf5" || e == "h5") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// Name of a problem: its file without folder and ending.
pub fn problem_name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
