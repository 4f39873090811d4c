//! A family of solvers without its type: what a registry holds.

use std::any::Any;
use std::sync::Arc;

use super::{ConeSolver, Description, Family, Stopping, UnknownSolver};
use crate::scalar::Scalar;

/// Makes a solver from a stopping rule that has been checked.
type Maker<T, const D: usize> = fn(Stopping<T>) -> Box<dyn ConeSolver<T, D>>;

/// A family of solvers as a registry holds it: its description, and how to make its solvers in each arithmetic and contact
/// dimension it supports. [`family!`](crate::solver::family) makes one from the type of a solver.
#[derive(Debug, Clone)]
pub struct SolverEntry {
    description: Description,
    /// A [`Maker`] for each arithmetic and dimension.
    makers: Vec<Arc<dyn Any + Send + Sync>>,
}

impl SolverEntry {
    /// A family that supports no arithmetic and no dimension yet, see [`with`](Self::with).
    pub fn new(description: Description) -> Self {
        Self { description, makers: Vec::new() }
    }

    /// Adds the arithmetic T and the contact dimension D, in which `V` is the solver.
    #[must_use]
    pub fn with<V, T, const D: usize>(mut self) -> Self
    where
        T: Scalar,
        V: Family<T> + ConeSolver<T, D> + 'static,
    {
        let maker: Maker<T, D> = |stopping| Box::new(V::with_stopping(stopping));
        self.makers.push(Arc::new(maker));
        self
    }

    /// What the family is, and when to choose it.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Makes a solver.
    ///
    /// # Errors
    /// [`UnknownSolver::Unsupported`] for an arithmetic or a dimension the family does not have, the stopping rule that is
    /// out of range.
    pub fn build<T: Scalar, const D: usize>(
        &self,
        stopping: Stopping<T>,
    ) -> Result<Box<dyn ConeSolver<T, D>>, UnknownSolver> {
        stopping.check()?;
        let maker = self.makers.iter().find_map(|maker| maker.downcast_ref::<Maker<T, D>>());
        let maker = maker.ok_or_else(|| UnknownSolver::Unsupported {
            solver: self.description.name,
            scalar: T::NAME,
            dimension: D,
        })?;
        Ok(maker(stopping))
    }
}

/// The [`SolverEntry`] of a solver that is generic over scalar and dimension, `MySolver<T, D>`: in `f64` and `f32`, with
/// contacts of 1, 2 and 3 dimensions.
///
/// ```
/// use nonsmooth::solver::{Nsgs, Stopping, family};
///
/// let entry = family!(Nsgs);
/// let solver = entry.build::<f64, 2>(Stopping::default()).unwrap();
/// assert_eq!(solver.name(), entry.description().name);
/// ```
#[doc(hidden)]
#[macro_export]
macro_rules! solver_family {
    ($($solver:ident)::+) => {
        $crate::solver::SolverEntry::new(
            <$($solver)::+<f64, 1> as $crate::solver::Family<f64>>::DESCRIPTION,
        )
        .with::<$($solver)::+<f64, 1>, f64, 1>()
        .with::<$($solver)::+<f64, 2>, f64, 2>()
        .with::<$($solver)::+<f64, 3>, f64, 3>()
        .with::<$($solver)::+<f32, 1>, f32, 1>()
        .with::<$($solver)::+<f32, 2>, f32, 2>()
        .with::<$($solver)::+<f32, 3>, f32, 3>()
    };
}
#[doc(inline)]
pub use solver_family as family;
