//! The trait every solver implements, and the wrapper that makes one of a method.

use std::fmt::Debug;

use nalgebra::SVector;

use super::control::{Control, Progress, Stopping};
use super::error::{Breakdown, SolveError};
use super::settings::SettingsError;
use crate::cone::{ConeProblem, Residual, Workspace};
use crate::scalar::{Scalar, all_finite, epsilon, to_f64};

/// What a successful solve reports; the residual is measured on the problem, never estimated by the solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solution<T> {
    /// Iterations of the solver, in its own unit (sweeps, Newton steps, convex programs).
    pub iterations: usize,
    /// Residual of the percussions returned, [`ConeProblem::residual`]; where rounding decides, that of
    /// [`ConeProblem::precise_residual`].
    pub residual: Residual<T>,
    /// Whether that is the tolerance asked for, or all that percussions of this precision can reach.
    pub accuracy: Accuracy<T>,
    /// The solver that found it after the chosen one had failed ([`rescue`](super::rescue())); `None` in the ordinary case.
    pub rescued_by: Option<&'static str>,
}

/// What a solution was accepted by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Accuracy<T> {
    /// The scaled residual is within the tolerance.
    Tolerance,
    /// The tolerance lies below what rounding leaves in working precision: the scaled residual, evaluated precisely, is
    /// within [`ConeProblem::floor`], or within the tolerance after all. Large percussions that nearly cancel make it so:
    /// light bodies between heavy ones. It excuses no tolerance below the ε of the arithmetic.
    Rounding {
        /// The floor (dimensionless).
        floor: T,
    },
}

/// A solver of the cone problem w = W r + b, K* ∋ Φ(w) ⟂ r ∈ K.
pub trait ConeSolver<T: Scalar, const D: usize>: Debug + Send {
    /// Name in scene files and reports.
    fn name(&self) -> &'static str;

    /// Tolerance and budget.
    fn stopping(&self) -> &Stopping<T>;

    /// The hook a solver implements: improves `r` from where it stands until `control` says stop, and returns the
    /// number of iterations. `r` is left at the best iterate, whatever the outcome.
    ///
    /// The problem is checked, has at least one contact, and `r` has the right length and is finite.
    ///
    /// # Errors
    /// [`Breakdown`] where the arithmetic fails before the budget ends.
    fn iterate(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        control: &mut Control<'_, T>,
    ) -> Result<usize, Breakdown>;

    /// The workspace that the residual of the result is measured in; `None` (default) for a solver that keeps none, and
    /// then a problem in factored form costs an allocation.
    fn workspace(&mut self) -> Option<&mut Workspace<T>> {
        None
    }

    /// Solves `problem` from the percussions `start` (N s, one block (N, T1, T2) per contact; zeros are a cold
    /// start) and writes the solution to `r`.
    ///
    /// # Errors
    /// [`SolveError`]; where the tolerance was missed `r` holds the best iterate and the error its residual.
    fn solve(
        &mut self,
        problem: &ConeProblem<T, D>,
        start: &[SVector<T, D>],
        r: &mut [SVector<T, D>],
    ) -> Result<Solution<T>, SolveError> {
        self.solve_observed(problem, start, r, None)
    }

    /// Solves `problem` from rest, r = 0, and writes the solution to `r`.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    fn solve_cold(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
    ) -> Result<Solution<T>, SolveError> {
        r.fill(SVector::zeros());
        self.solve_from(problem, r, None)
    }

    /// [`solve`](Self::solve) with an observer that is told of every iteration.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    fn solve_observed(
        &mut self,
        problem: &ConeProblem<T, D>,
        start: &[SVector<T, D>],
        r: &mut [SVector<T, D>],
        observer: Option<&mut dyn FnMut(Progress<T>)>,
    ) -> Result<Solution<T>, SolveError> {
        let contacts = problem.contacts();
        for given in [start.len(), r.len()] {
            if given != contacts {
                problem.check()?;
                return Err(SolveError::Shape { contacts, given });
            }
        }
        r.copy_from_slice(start);
        self.solve_from(problem, r, observer)
    }

    /// [`solve_observed`](Self::solve_observed) from the percussions that stand in `r`.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    fn solve_from(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        observer: Option<&mut dyn FnMut(Progress<T>)>,
    ) -> Result<Solution<T>, SolveError> {
        problem.check()?;
        if r.len() != problem.contacts() {
            return Err(SolveError::Shape { contacts: problem.contacts(), given: r.len() });
        }
        // A start that is not finite is a cold start.
        if !r.iter().all(|p| all_finite(p.iter())) {
            r.fill(SVector::zeros());
        }
        let stopping = self.stopping().clone();
        let (iterations, reason) = if problem.takes_off() {
            r.fill(SVector::zeros());
            (0, None)
        } else {
            let mut control = Control::new(&stopping, observer);
            match self.iterate(problem, r, &mut control) {
                Ok(iterations) => (iterations, None),
                Err(Breakdown { iterations, cause }) => (iterations, Some(cause)),
            }
        };
        let mut own = Workspace::default();
        let workspace = self.workspace().unwrap_or(&mut own);
        let residual = problem.residual_in(r, workspace);
        // Both tests are written so that a NaN residual fails.
        if residual.scaled <= stopping.tolerance {
            return Ok(Solution { iterations, residual, accuracy: Accuracy::Tolerance, rescued_by: None });
        }
        let floor = problem.floor(r);
        // A tolerance below ε cannot be excused by rounding.
        let excused = stopping.tolerance >= epsilon::<T>();
        if excused && ConeProblem::<T, D>::is_near_floor(residual.scaled, floor) {
            // Not to be confused with the rounding of its own evaluation.
            let precise = problem.precise_residual_in(r, workspace);
            if precise.scaled <= stopping.tolerance.max(floor) {
                let accuracy = Accuracy::Rounding { floor };
                return Ok(Solution { iterations, residual: precise, accuracy, rescued_by: None });
            }
        }
        Err(SolveError::NotConverged {
            solver: self.name(),
            iterations,
            residual: to_f64(residual.scaled),
            natural: to_f64(residual.natural),
            tolerance: to_f64(stopping.tolerance),
            reason,
        })
    }
}

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
    /// What an iteration is.
    pub iteration: Iteration,
}

/// What one iteration of a method costs, by which a rescue divides its budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Iteration {
    /// Products with W, or solves by factors that are kept.
    Sweep,
    /// A factorisation of a matrix with the pattern of W.
    Factorisation,
    /// A convex program.
    Program,
}

/// A method for the cone problem: its description, its settings with their check, and one run.
///
/// ```
/// use nalgebra::{SMatrix, SVector, vector};
/// use nonsmooth::cone::{BlockMatrix, ConeProblem};
/// use nonsmooth::scalar::Scalar;
/// use nonsmooth::solver::{
///     Breakdown, ConeSolver, Control, Description, Iteration, Method, SettingsError, Stopping,
/// };
///
/// /// Sweeps of exact one-contact solutions.
/// #[derive(Debug)]
/// struct Sweeps;
///
/// impl<T: Scalar, const D: usize> Method<T, D> for Sweeps {
///     const DESCRIPTION: Description = Description {
///         name: "sweeps",
///         title: "exact one-contact solutions in turn",
///         when: "few contacts",
///         reference: "Jean (1999), doi:10.1016/S0045-7825(98)00383-1",
///         iteration: Iteration::Sweep,
///     };
///     type Settings = ();
///
///     fn new((): ()) -> Result<Self, SettingsError> {
///         Ok(Self)
///     }
///
///     fn iterate(
///         &mut self,
///         problem: &ConeProblem<T, D>,
///         r: &mut [SVector<T, D>],
///         control: &mut Control<'_, T>,
///     ) -> Result<usize, Breakdown> {
///         let budget = control.max_iterations(1_000);
///         for sweep in 1..=budget {
///             for contact in 0..r.len() {
///                 r[contact] = problem.solve_contact(contact, r);
///             }
///             let residual = problem.residual(r).scaled;
///             if !control.proceed(sweep, residual) || residual <= control.tolerance() {
///                 return Ok(sweep);
///             }
///         }
///         Ok(budget)
///     }
/// }
///
/// let mut solver = <Sweeps as Method<f64, 3>>::solver(Stopping::to(1e-8), ())?;
/// let w = BlockMatrix::from_fn(1, |_, _| SMatrix::identity());
/// let problem = ConeProblem::<f64, 3>::new(w, vec![vector![-1.0, 0.1, 0.0]], vec![0.5])?;
/// let mut r = [SVector::zeros()];
/// solver.solve_cold(&problem, &mut r)?;
/// assert!((r[0] - vector![1.0, -0.1, 0.0]).norm() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Method<T: Scalar, const D: usize>: Debug + Send + Sized {
    /// The registry's entry.
    const DESCRIPTION: Description;

    /// What can be set, apart from the [`Stopping`] rule.
    type Settings: Default;

    /// The method with settings that are checked here.
    ///
    /// # Errors
    /// [`SettingsError`] with the setting that is out of range.
    fn new(settings: Self::Settings) -> Result<Self, SettingsError>;

    /// [`ConeSolver::iterate`].
    ///
    /// # Errors
    /// [`Breakdown`] where the arithmetic fails before the budget ends.
    fn iterate(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        control: &mut Control<'_, T>,
    ) -> Result<usize, Breakdown>;

    /// [`ConeSolver::workspace`].
    fn workspace(&mut self) -> Option<&mut Workspace<T>> {
        None
    }

    /// The solver that runs this method under a stopping rule.
    ///
    /// # Errors
    /// [`SettingsError`] with what is out of range.
    fn solver(stopping: Stopping<T>, settings: Self::Settings) -> Result<Solver<T, Self>, SettingsError> {
        stopping.check()?;
        Ok(Solver { stopping, method: Self::new(settings)? })
    }
}

/// A [`Method`] with its stopping rule, from [`Method::solver`].
#[derive(Debug, Clone)]
pub struct Solver<T, M> {
    stopping: Stopping<T>,
    method: M,
}

impl<T: Scalar, const D: usize, M: Method<T, D>> ConeSolver<T, D> for Solver<T, M> {
    fn name(&self) -> &'static str {
        M::DESCRIPTION.name
    }

    fn stopping(&self) -> &Stopping<T> {
        &self.stopping
    }

    fn iterate(
        &mut self,
        problem: &ConeProblem<T, D>,
        r: &mut [SVector<T, D>],
        control: &mut Control<'_, T>,
    ) -> Result<usize, Breakdown> {
        self.method.iterate(problem, r, control)
    }

    fn workspace(&mut self) -> Option<&mut Workspace<T>> {
        self.method.workspace()
    }
}
