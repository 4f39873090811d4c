//! Observers: what is kept of a run. The scheme knows none of them.

#[cfg(feature = "hdf5")]
mod binary;
#[cfg(feature = "outputs")]
mod csv;
#[cfg(feature = "figures")]
mod figures;
#[cfg(feature = "html")]
mod html;
#[cfg(feature = "outputs")]
mod penetration;
mod recording;
mod series;
#[cfg(feature = "outputs")]
mod summary;
#[cfg(feature = "outputs")]
mod table;
mod units;
#[cfg(feature = "vtk")]
mod vtk;

#[cfg(feature = "hdf5")]
pub use self::binary::write_tables;
#[cfg(feature = "outputs")]
pub use self::csv::{CsvFiles, CsvMark, Rates};
#[cfg(feature = "figures")]
pub use figures::{comparison_figure, elastic_figure, mesh_figure, run_figure};
#[cfg(feature = "html")]
pub use html::{HtmlMark, HtmlPage, MOST_FRAMES};
#[cfg(feature = "outputs")]
pub use penetration::Penetration;
pub use recording::{ContactRecord, Recorder, Recording};
pub use series::{RunSeries, SeriesMark, SeriesRecorder};
#[cfg(feature = "outputs")]
pub use summary::{AdaptiveSummary, Impact, RunSummary, SummaryMark, SummaryRecorder};
pub use units::Units;

#[cfg(feature = "vtk")]
pub use vtk::VtkSeries;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::laws::Rows;
use crate::scalar::{Scalar, to_f64};
use crate::scheme::{Settings, State, Step};
use crate::system::System;

/// Which run an observer is in.
#[derive(Debug, Clone, PartialEq)]
pub struct RunInfo {
    /// Law of the run, as the scene names it.
    pub law: String,
    /// Cone solver.
    pub solver: String,
    /// Law of each interface.
    pub interface_laws: Vec<String>,
    /// θ.
    pub theta: f64,
    /// Time step h (s).
    pub step: f64,
    /// Arithmetic, `f64` or `f32`.
    pub scalar: &'static str,
    /// The components of the contacts.
    pub rows: Rows,
}

impl RunInfo {
    /// The same, of contacts with these components.
    pub fn with_rows(self, rows: Rows) -> Self {
        Self { rows, ..self }
    }

    /// The facts of a run over `settings`, of contacts that do not roll.
    pub fn new<T: Scalar>(law: &str, solver: &str, interfaces: Vec<String>, settings: &Settings<T>) -> Self {
        Self {
            law: law.into(),
            solver: solver.into(),
            interface_laws: interfaces,
            theta: to_f64(settings.theta),
            step: to_f64(settings.step),
            scalar: T::NAME,
            rows: Rows::default(),
        }
    }
}

/// What an observer sees: the state reached, and the step that led there.
#[derive(Clone, Copy)]
pub struct Frame<'a, T: Scalar, const D: usize> {
    /// The system.
    pub system: &'a dyn System<T, D>,
    /// The state at the end of the step.
    pub state: &'a State<T>,
    /// The step; at the start of a run its contacts are empty.
    pub step: &'a Step<T, D>,
}

/// Watches a run.
pub trait Observer<T: Scalar, const D: usize> {
    /// The run begins in the state of `frame`.
    ///
    /// # Errors
    /// [`ObserveError`] where something cannot be written; the run then does not start.
    fn begin(&mut self, _run: &RunInfo, _frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        Ok(())
    }

    /// A step was made.
    ///
    /// # Errors
    /// [`ObserveError`] where something cannot be written; the run then stops.
    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError>;

    /// The run is over: at its end time, interrupted, or at a step that failed.
    ///
    /// # Errors
    /// [`ObserveError`] where something cannot be written.
    fn end(&mut self, _frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        Ok(())
    }
}

/// `None` watches nothing.
impl<T: Scalar, const D: usize, O: Observer<T, D>> Observer<T, D> for Option<O> {
    fn begin(&mut self, run: &RunInfo, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        self.as_mut().map_or(Ok(()), |observer| observer.begin(run, frame))
    }

    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        self.as_mut().map_or(Ok(()), |observer| observer.step(frame))
    }

    fn end(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        self.as_mut().map_or(Ok(()), |observer| observer.end(frame))
    }
}

/// An output that could not be written.
#[derive(Debug, Clone, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
#[non_exhaustive]
pub struct ObserveError {
    /// The file or folder.
    pub path: PathBuf,
    /// What went wrong, in most cases what the system says.
    pub source: Arc<dyn Error + Send + Sync>,
}

impl ObserveError {
    /// The error of writing to `path`.
    pub fn new(path: &Path, error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self { path: path.into(), source: Arc::from(error.into()) }
    }
}
