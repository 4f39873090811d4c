//! Solvers of the cone problem behind one door.
//!
//! A solver is one file here and one line in the `register!` call of `registry.rs`. It implements [`Method`]: a
//! description, settings that are checked at construction, and [`Method::iterate`], which may assume a checked problem
//! with contacts that do not all take off. [`Method::solver`] makes a [`ConeSolver`] of it; callers use
//! [`ConeSolver::solve`], which checks the data, measures the residual of the result on the problem and calls a missed
//! tolerance an error.
//!
//! The Newton methods share one core in `newton/`: equation and derivatives of a contact, scaling, linear systems, search
//! and schedule stand there once.

mod admm;
pub(crate) mod anderson;
mod cone_solver;
#[cfg(feature = "clarabel")]
mod conic_program;
mod control;
#[cfg(feature = "clarabel")]
mod convex_fixed_point;
mod entry;
mod error;
mod extragradient;
#[cfg(feature = "clarabel")]
mod feasibility;
mod gauss_seidel;
mod hybrid;
mod newton;
mod nsgs;
mod pivoting;
mod proximal_newton;
mod registry;
mod rescue;
mod semismooth_newton;
mod settings;
mod sweeps;

pub use admm::{Admm, AdmmSettings};
pub(crate) use anderson::Anderson;
pub use cone_solver::{Accuracy, ConeSolver, Description, Iteration, Method, Solution, Solver};
pub use control::{Control, Progress, Stopping, StoppingError, default_tolerance};
#[cfg(feature = "clarabel")]
pub use convex_fixed_point::{ConvexFixedPoint, ConvexFixedPointSettings, Polish};
pub use entry::{SolverEntry, family};
#[cfg(feature = "clarabel")]
pub use error::ProgramError;
pub use error::{Breakdown, BreakdownCause, Origin, RescueAttempt, RescueFailure, SolveError, UnknownSolver};
pub use extragradient::{Extragradient, ExtragradientSettings, Projections};
#[cfg(feature = "clarabel")]
pub use feasibility::{Feasibility, Undecided, feasibility};
pub use hybrid::{Hybrid, HybridSettings};
pub use newton::Formulation;
pub use nsgs::{Nsgs, NsgsSettings};
pub use proximal_newton::{ProximalNewton, ProximalNewtonSettings};
pub use registry::{DEFAULT, SOLVERS, build, describe, families};
pub use rescue::{RESCUE_TIME, rescue, solve_or_rescue};
pub use semismooth_newton::{SemismoothNewton, SemismoothNewtonSettings};
pub use settings::{Interval, SettingsError};
pub use sweeps::Sweep;
