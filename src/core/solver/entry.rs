//! A family of solvers without its type: what a registry holds.

use std::any::Any;
use std::sync::Arc;

use super::{ConeSolver, Description, Method, Stopping, UnknownSolver};
use crate::scalar::Scalar;

/// Makes a solver from a stopping rule, every other setting at its default.
type Maker<T, const D: usize> = fn(Stopping<T>) -> Result<Box<dyn ConeSolver<T, D>>, UnknownSolver>;

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

    /// Adds the arithmetic T and the contact dimension D, in which `M` is the method.
    #[must_use]
    pub fn with<M, T, const D: usize>(mut self) -> Self
    where
        T: Scalar,
        M: Method<T, D> + 'static,
    {
        let maker: Maker<T, D> = |stopping| Ok(Box::new(M::solver(stopping, M::Settings::default())?));
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
        let solver = self.description.name;
        let maker = maker.ok_or(UnknownSolver::Unsupported { solver, scalar: T::NAME, dimension: D })?;
        maker(stopping)
    }
}

/// The [`SolverEntry`] of a [`Method`](crate::solver::Method) in `f64` and `f32`, with contacts of 1, 2 and 3 dimensions:
/// `family!(MyMethod)`, or of a type that is generic over scalar and dimension `family!(MyMethod<T, D>)`.
///
/// ```
/// use nonsmooth::solver::{Nsgs, Stopping, family};
///
/// let entry = family!(Nsgs<T, D>);
/// let solver = entry.build::<f64, 2>(Stopping::default()).unwrap();
/// assert_eq!(solver.name(), entry.description().name);
/// ```
#[doc(hidden)]
#[macro_export]
macro_rules! solver_family {
    ($($method:ident)::+ <T, D>) => {
        $crate::solver_family!(@ $($method)::+<f64, 1>, $($method)::+<f64, 2>, $($method)::+<f64, 3>,
            $($method)::+<f32, 1>, $($method)::+<f32, 2>, $($method)::+<f32, 3>)
    };
    ($method:ty) => {
        $crate::solver_family!(@ $method, $method, $method, $method, $method, $method)
    };
    (@ $a:ty, $b:ty, $c:ty, $d:ty, $e:ty, $f:ty) => {
        $crate::solver::SolverEntry::new(<$a as $crate::solver::Method<f64, 1>>::DESCRIPTION)
            .with::<$a, f64, 1>()
            .with::<$b, f64, 2>()
            .with::<$c, f64, 3>()
            .with::<$d, f32, 1>()
            .with::<$e, f32, 2>()
            .with::<$f, f32, 3>()
    };
}
#[doc(inline)]
pub use solver_family as family;
