//! When a solver stops: tolerance, iteration and time budget, observer.

use std::time::{Duration, Instant};

use crate::scalar::{Scalar, epsilon, lit, to_f64};

/// Tolerance and budget of a solver.
#[derive(Debug, Clone, PartialEq)]
pub struct Stopping<T> {
    /// Tolerance on the scaled residual (dimensionless, > 0). Default 1e-10, or 64 ε for a scalar that cannot
    /// resolve it.
    pub tolerance: T,
    /// Largest number of iterations, in the unit of the solver; `None` takes the solver's own default.
    pub max_iterations: Option<usize>,
    /// Largest wall time of one solve in seconds; `None` is no limit.
    pub max_seconds: Option<f64>,
}

impl<T: Scalar> Default for Stopping<T> {
    fn default() -> Self {
        Self { tolerance: default_tolerance(), max_iterations: None, max_seconds: None }
    }
}

/// A tolerance or a budget no solver can work with.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StoppingError {
    /// The tolerance is not a positive finite number.
    #[error("the solver tolerance is {value}, it must be a finite number > 0")]
    Tolerance {
        /// The value refused.
        value: f64,
    },
    /// The time budget is not a positive number.
    #[error("the solver's time budget is {value} s, it must be > 0")]
    Seconds {
        /// The value refused.
        value: f64,
    },
}

impl<T: Scalar> Stopping<T> {
    /// The default budget with a tolerance on the scaled residual.
    pub fn to(tolerance: T) -> Self {
        Self { tolerance, ..Self::default() }
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// [`StoppingError`] with the value refused.
    pub fn check(&self) -> Result<(), StoppingError> {
        let value = to_f64(self.tolerance);
        if !(value > 0.0 && value.is_finite()) {
            return Err(StoppingError::Tolerance { value });
        }
        match self.max_seconds {
            Some(value) if value.is_nan() || value <= 0.0 => Err(StoppingError::Seconds { value }),
            _ => Ok(()),
        }
    }
}

/// What an observer is told after an iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress<T> {
    /// Iterations so far, in the unit of the solver.
    pub iterations: usize,
    /// The solver's estimate of the scaled residual.
    pub residual: T,
}

/// The solver's view of its budget.
pub struct Control<'a, T> {
    tolerance: T,
    max_iterations: Option<usize>,
    deadline: Option<Instant>,
    observer: Option<&'a mut dyn FnMut(Progress<T>)>,
}

impl<'a, T: Scalar> Control<'a, T> {
    /// Starts the clock.
    pub fn new(stopping: &Stopping<T>, observer: Option<&'a mut dyn FnMut(Progress<T>)>) -> Self {
        // A budget beyond what the clock can represent is no limit.
        let after = |s: f64| Duration::try_from_secs_f64(s).ok().and_then(|d| Instant::now().checked_add(d));
        Self {
            tolerance: stopping.tolerance,
            max_iterations: stopping.max_iterations,
            deadline: stopping.max_seconds.and_then(after),
            observer,
        }
    }

    /// Tolerance on the scaled residual.
    pub fn tolerance(&self) -> T {
        self.tolerance
    }

    /// The iteration budget, `default` where the caller set none.
    pub fn max_iterations(&self, default: usize) -> usize {
        self.max_iterations.unwrap_or(default)
    }

    /// Tells the observer of an iteration, and the solver whether time is left.
    pub fn proceed(&mut self, iterations: usize, residual: T) -> bool {
        if let Some(observer) = self.observer.as_mut() {
            observer(Progress { iterations, residual });
        }
        self.deadline.is_none_or(|deadline| Instant::now() < deadline)
    }

    /// A control for a stage of a larger solver: the same clock and observer, another tolerance and budget.
    pub fn stage(&mut self, tolerance: T, max_iterations: usize) -> Control<'_, T> {
        let observer: Option<&mut dyn FnMut(Progress<T>)> = match self.observer.as_mut() {
            Some(observer) => Some(&mut **observer),
            None => None,
        };
        Control { tolerance, max_iterations: Some(max_iterations), deadline: self.deadline, observer }
    }
}

/// The default tolerance on the scaled residual: 1e-10, or 64 ε where the scalar cannot resolve that.
pub fn default_tolerance<T: Scalar>() -> T {
    let floor = lit::<T>(64.0) * epsilon::<T>();
    let wanted = lit::<T>(1e-10);
    if wanted > floor { wanted } else { floor }
}
