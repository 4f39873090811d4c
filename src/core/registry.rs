//! The laws and the solvers a program knows, by name.
//!
//! `nonsmooth::registry()` holds the built-in ones. A crate of one's own adds its laws and solvers, and hands the registry
//! to scenes, studies, collections and the command line:
//!
//! ```
//! use nonsmooth::laws::{self, Approach, ContactLaw, Description, FRICTION, LawFamily, Response, Scalar};
//!
//! /// No restitution, whatever θ.
//! #[derive(Debug)]
//! struct Plastic<T> {
//!     friction: T,
//! }
//!
//! impl<T: Scalar> LawFamily<T> for Plastic<T> {
//!     const DESCRIPTION: Description = Description {
//!         name: "plastic",
//!         title: "no restitution",
//!         equation: "û = u⁺",
//!         claim: "none",
//!         reference: "this page",
//!         parameters: &[FRICTION],
//!     };
//!     fn from_values(values: &[T]) -> Self {
//!         Self { friction: values[0] }
//!     }
//! }
//!
//! impl<T: Scalar, const D: usize> ContactLaw<T, D> for Plastic<T> {
//!     fn name(&self) -> &str {
//!         "plastic"
//!     }
//!     fn respond(&self, _: &Approach<T, D>) -> Response<T, D> {
//!         Response::new(T::one(), nalgebra::zero(), self.friction)
//!     }
//! }
//!
//! let registry = nonsmooth::registry().law(laws::family!(Plastic<T>))?;
//! let law = registry.build_law::<f64, 2>("plastic", &[0.5])?;
//! assert_eq!(law.rows(), laws::Rows::Tangent);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::laws::{self, ContactLaw, LawEntry, LawError};
use crate::scalar::Scalar;
use crate::solver::{self, ConeSolver, SolverEntry, Stopping, UnknownSolver};

/// The laws and the solvers a program knows, by name.
#[derive(Debug, Clone)]
pub struct Registry {
    laws: Vec<LawEntry>,
    solvers: Vec<SolverEntry>,
}

/// A law or a solver that cannot be registered.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RegistryError {
    /// There is a law of this name.
    #[error("a law called `{name}` is registered already")]
    LawTaken {
        /// The name.
        name: &'static str,
    },
    /// There is a solver of this name.
    #[error("a solver called `{name}` is registered already")]
    SolverTaken {
        /// The name.
        name: &'static str,
    },
}

impl Registry {
    /// A registry that knows nothing yet.
    pub fn empty() -> Self {
        Self { laws: Vec::new(), solvers: Vec::new() }
    }

    /// The built-in solvers, and no law: laws come from other crates.
    pub fn solvers_only() -> Self {
        Self { laws: Vec::new(), solvers: solver::families() }
    }

    /// Adds a family of laws, see [`laws::family!`].
    ///
    /// # Errors
    /// [`RegistryError::LawTaken`].
    pub fn law(mut self, family: LawEntry) -> Result<Self, RegistryError> {
        let name = family.description().name;
        if self.laws().any(|law| law.name == name) {
            return Err(RegistryError::LawTaken { name });
        }
        self.laws.push(family);
        Ok(self)
    }

    /// Adds a family of solvers, see [`solver::family!`].
    ///
    /// # Errors
    /// [`RegistryError::SolverTaken`].
    pub fn solver(mut self, family: SolverEntry) -> Result<Self, RegistryError> {
        let name = family.description().name;
        if self.solvers().any(|solver| solver.name == name) {
            return Err(RegistryError::SolverTaken { name });
        }
        self.solvers.push(family);
        Ok(self)
    }

    /// What the laws are, in the order of registration.
    pub fn laws(&self) -> impl Iterator<Item = &laws::Description> {
        self.laws.iter().map(LawEntry::description)
    }

    /// What the solvers are, in the order of registration.
    pub fn solvers(&self) -> impl Iterator<Item = &solver::Description> {
        self.solvers.iter().map(SolverEntry::description)
    }

    /// The family of laws of a name.
    ///
    /// # Errors
    /// [`LawError::UnknownLaw`] with the names that exist.
    pub fn find_law(&self, name: &str) -> Result<&LawEntry, LawError> {
        self.laws.iter().find(|law| law.description().name == name).ok_or_else(|| LawError::UnknownLaw {
            name: name.into(),
            known: self.laws().map(|law| law.name).collect::<Vec<_>>().join(", "),
        })
    }

    /// The family of solvers of a name.
    ///
    /// # Errors
    /// [`UnknownSolver::Name`] with the names that exist.
    pub fn find_solver(&self, name: &str) -> Result<&SolverEntry, UnknownSolver> {
        self.solvers.iter().find(|solver| solver.description().name == name).ok_or_else(|| {
            UnknownSolver::Name {
                name: name.into(),
                known: self.solvers().map(|solver| solver.name).collect::<Vec<_>>().join(", "),
            }
        })
    }

    /// Makes a law from parameter values in the order of its description.
    ///
    /// # Errors
    /// Those of [`find_law`](Self::find_law) and of [`LawEntry::build`].
    pub fn build_law<T: Scalar, const D: usize>(
        &self,
        name: &str,
        values: &[T],
    ) -> Result<Box<dyn ContactLaw<T, D>>, LawError> {
        self.find_law(name)?.build(values)
    }

    /// Makes a solver.
    ///
    /// # Errors
    /// Those of [`find_solver`](Self::find_solver) and of [`SolverEntry::build`].
    pub fn build_solver<T: Scalar, const D: usize>(
        &self,
        name: &str,
        stopping: Stopping<T>,
    ) -> Result<Box<dyn ConeSolver<T, D>>, UnknownSolver> {
        self.find_solver(name)?.build(stopping)
    }
}
