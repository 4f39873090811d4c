//! The solvers by name: one line each.

#[cfg(feature = "clarabel")]
use super::convex_fixed_point;
use super::{ConeSolver, SolverEntry, Stopping, StoppingError};
use super::{admm, extragradient, hybrid, nsgs, proximal_newton, semismooth_newton};
use crate::scalar::Scalar;

/// A solver as the registry lists it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Description {
    /// Name in scene files and on the command line.
    pub name: &'static str,
    /// One line saying what the method is.
    pub title: &'static str,
    /// When to choose it.
    pub when: &'static str,
    /// Publication the method comes from.
    pub reference: &'static str,
}

/// A solver the registry can describe and build from its stopping rule, every other setting at its default.
pub trait Family<T: Scalar>: Sized {
    /// The registry's entry.
    const DESCRIPTION: Description;

    /// The solver with a stopping rule that has been checked.
    fn with_stopping(stopping: Stopping<T>) -> Self;
}

/// No solver of this name is registered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum UnknownSolver {
    /// The name is not in the registry.
    #[error("no solver is called `{name}` (known: {known})")]
    Name {
        /// The name given.
        name: String,
        /// The registered names.
        known: String,
    },
    /// The solver is not there in this arithmetic and contact dimension.
    #[error("solver `{solver}` cannot be had in {scalar} with contacts of dimension {dimension}")]
    Unsupported {
        /// Name of the solver.
        solver: &'static str,
        /// The arithmetic.
        scalar: &'static str,
        /// Contact dimension.
        dimension: usize,
    },
    /// The stopping rule is out of range.
    #[error(transparent)]
    Stopping(#[from] StoppingError),
}

macro_rules! register {
    ($($(#[$meta:meta])* $module:ident :: $solver:ident),+ $(,)?) => {
        /// Every registered solver.
        pub const SOLVERS: &[Description] =
            &[$($(#[$meta])* <$module::$solver<f64, 3> as Family<f64>>::DESCRIPTION),+];

        /// The registered families, in the order of registration.
        pub fn families() -> Vec<SolverEntry> {
            vec![$($(#[$meta])* crate::solver::family!($module::$solver)),+]
        }

        /// Builds a registered solver.
        ///
        /// # Errors
        /// [`UnknownSolver`] with the names that exist, or the stopping rule that is out of range.
        pub fn build<T: Scalar, const D: usize>(
            name: &str,
            stopping: Stopping<T>,
        ) -> Result<Box<dyn ConeSolver<T, D>>, UnknownSolver> {
            stopping.check()?;
            $(
                $(#[$meta])*
                if name == <$module::$solver<T, D> as Family<T>>::DESCRIPTION.name {
                    return Ok(Box::new(<$module::$solver<T, D> as Family<T>>::with_stopping(stopping)));
                }
            )+
            Err(describe(name).err().expect("a described solver is one of those tried above"))
        }
    };
}

register! {
    hybrid::Hybrid,
    nsgs::Nsgs,
    semismooth_newton::SemismoothNewton,
    #[cfg(feature = "clarabel")]
    convex_fixed_point::ConvexFixedPoint,
    proximal_newton::ProximalNewton,
    admm::Admm,
    extragradient::Extragradient,
}

/// The registry's entry for a solver.
///
/// # Errors
/// [`UnknownSolver`] with the names that exist.
pub fn describe(name: &str) -> Result<&'static Description, UnknownSolver> {
    SOLVERS.iter().find(|solver| solver.name == name).ok_or_else(|| UnknownSolver::Name {
        name: name.into(),
        known: SOLVERS.iter().map(|solver| solver.name).collect::<Vec<_>>().join(", "),
    })
}
