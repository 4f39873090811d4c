//! The solvers by name: one line each.

use super::cone_solver::{ConeSolver, Description, Method};
use super::control::Stopping;
#[cfg(feature = "clarabel")]
use super::convex_fixed_point;
use super::entry::SolverEntry;
use super::{UnknownSolver, admm, extragradient, hybrid, nsgs, proximal_newton, semismooth_newton};
use crate::scalar::Scalar;

/// Name of the solver taken where none is chosen.
pub const DEFAULT: &str = "hybrid";

macro_rules! register {
    ($($(#[$meta:meta])* $module:ident :: $solver:ident),+ $(,)?) => {
        /// Every registered solver.
        pub const SOLVERS: &[Description] =
            &[$($(#[$meta])* <$module::$solver<f64, 3> as Method<f64, 3>>::DESCRIPTION),+];

        /// The registered families, in the order of registration.
        pub fn families() -> Vec<SolverEntry> {
            vec![$($(#[$meta])* crate::solver::family!($module::$solver<T, D>)),+]
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
                if name == <$module::$solver<T, D> as Method<T, D>>::DESCRIPTION.name {
                    let solver = <$module::$solver<T, D> as Method<T, D>>::solver(stopping, Default::default())?;
                    return Ok(Box::new(solver));
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
