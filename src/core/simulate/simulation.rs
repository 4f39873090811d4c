//! A run behind one face for every arithmetic and contact dimension.

use std::fmt::Debug;
use std::sync::atomic::AtomicBool;

use super::{Compiled, Ended, SimulateError, Sink, Stepper};
use crate::adaptive::Report;
use crate::contact::ContactId;
use crate::energy::Energies;
use crate::linalg::BlockRows;
use crate::mesh::Mesh;
use crate::observe::{ContactRecord, ObserveError, Observer, RunInfo};
use crate::scalar::{Scalar, lit, to_f64};
use crate::scheme::{RestoreError, SetupError, Snapshot};

/// A run that is ready to start, or under way: a [`Stepper`] of any arithmetic and contact dimension. Numbers are `f64`.
pub trait Simulation: Debug + Send {
    /// Which run it is.
    fn info(&self) -> &RunInfo;

    /// Whether error control chooses the lengths of the steps.
    fn is_adaptive(&self) -> bool;

    /// Tolerance of the error control and what it has made of the run, `None` for fixed steps.
    fn control(&self) -> Option<(f64, Report<f64>)>;

    /// Steps made.
    fn index(&self) -> usize;

    /// Time reached (s).
    fn time(&self) -> f64;

    /// Number of degrees of freedom, components of v.
    fn dofs(&self) -> usize;

    /// Configuration reached.
    fn q(&self) -> Vec<f64>;

    /// Velocity reached.
    fn v(&self) -> Vec<f64>;

    /// Energies of the state reached (J).
    fn energies(&self) -> Energies<f64>;

    /// What the active contacts of the last step did.
    fn contacts(&self) -> Vec<ContactRecord>;

    /// Mesh of an elastic body.
    fn mesh(&self) -> Option<&Mesh>;

    /// Identities and names of the contacts whose gap is at most `reach` (m).
    fn candidates(&mut self, reach: f64) -> Vec<(ContactId, String)>;

    /// Degrees of freedom that a contact moves.
    fn moved_by(&self, contact: ContactId) -> Vec<usize>;

    /// Tells the sinks that the run begins.
    ///
    /// # Errors
    /// [`ObserveError`].
    fn begin(&self, sinks: &mut [&mut dyn Sink]) -> Result<(), ObserveError>;

    /// Makes `steps` fixed steps, or under error control all steps to the end, unless `interrupt` is raised before, and
    /// tells the sinks of each.
    ///
    /// # Errors
    /// [`SimulateError`].
    fn advance(
        &mut self,
        steps: usize,
        sinks: &mut [&mut dyn Sink],
        interrupt: &AtomicBool,
    ) -> Result<Ended, SimulateError>;

    /// Tells the sinks that the run is over.
    ///
    /// # Errors
    /// [`ObserveError`].
    fn end(&self, sinks: &mut [&mut dyn Sink]) -> Result<(), ObserveError>;

    /// Makes `steps` fixed steps, or under error control all steps to the end, unless `interrupt` is raised before, and
    /// tells the sinks of the beginning, each step and the end.
    ///
    /// # Errors
    /// [`SimulateError`]; the sinks' `end` has then been called all the same.
    fn run(
        &mut self,
        steps: usize,
        sinks: &mut [&mut dyn Sink],
        interrupt: &AtomicBool,
    ) -> Result<Ended, SimulateError> {
        self.begin(sinks)?;
        let ended = self.advance(steps, sinks, interrupt);
        let told = self.end(sinks);
        let ended = ended?;
        told?;
        Ok(ended)
    }

    /// The cone problem of the last step, or of the one that failed, as a problem file.
    ///
    /// # Errors
    /// [`FclibError`](crate::fclib::FclibError): contacts of a kind the layout does not know.
    #[cfg(feature = "fclib")]
    fn cone_problem(
        &self,
        info: crate::fclib::Info,
    ) -> Result<crate::fclib::Problem, crate::fclib::FclibError>;

    /// The contacts that overlap in the state reached: their names and their gaps (m), all negative.
    fn overlaps(&mut self) -> Vec<(String, f64)>;

    /// The state reached, to go on from; under error control, which keeps more than its state, `None`.
    fn snapshot(&self) -> Option<Snapshot>;

    /// Goes on from a snapshot of the same run.
    ///
    /// # Errors
    /// [`RestoreError`] for a snapshot of another run, and under error control for any.
    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), RestoreError>;
}

/// A [`Simulation`] in the arithmetic T with contacts of dimension D.
#[derive(Debug)]
pub struct Simulated<T: Scalar, const D: usize> {
    stepper: Stepper<T, D>,
    info: RunInfo,
    /// The step that is shorter than the others, and its length (s).
    last: Option<(usize, T)>,
}

impl<T: Scalar, const D: usize> Simulated<T, D> {
    /// The run of a stepper; its law and its solver have these names in outputs.
    pub fn new(stepper: Stepper<T, D>, law: &str, solver: &str) -> Self {
        let scheme = stepper.scheme();
        let laws = scheme.laws().iter().map(|law| law.name().to_string()).collect();
        let info = RunInfo::new(law, solver, laws, scheme.settings()).with_rows(scheme.rows());
        Self { stepper, info, last: None }
    }

    /// The same, of fixed steps of which the one after `before` steps has the length `length` (s): it ends where the run
    /// does. Where steps must have one length (displacements that move, bodies that sleep) it is not made.
    #[must_use]
    pub fn with_last_step(self, before: usize, length: T) -> Self {
        Self { last: Some((before, length)), ..self }
    }

    /// The stepper.
    pub fn stepper(&self) -> &Stepper<T, D> {
        &self.stepper
    }
}

/// The sinks as observers of a run.
fn observers<'a, T: Compiled<D>, const D: usize>(
    sinks: &'a mut [&mut dyn Sink],
) -> Vec<&'a mut dyn Observer<T, D>> {
    sinks.iter_mut().map(|sink| T::observer(*sink)).collect()
}

fn plain<T: Scalar>(values: &[T]) -> Vec<f64> {
    values.iter().map(|&x| to_f64(x)).collect()
}

impl<T: Compiled<D>, const D: usize> Simulation for Simulated<T, D> {
    fn info(&self) -> &RunInfo {
        &self.info
    }

    fn is_adaptive(&self) -> bool {
        matches!(self.stepper, Stepper::Adaptive(_))
    }

    fn control(&self) -> Option<(f64, Report<f64>)> {
        let Stepper::Adaptive(driver) = &self.stepper else { return None };
        let Report { accepted, rejected, computed, events, .. } = *driver.report();
        let report = Report {
            accepted,
            rejected,
            computed,
            events,
            estimated_error: to_f64(driver.report().estimated_error),
            smallest_step: to_f64(driver.report().smallest_step),
            largest_step: to_f64(driver.report().largest_step),
        };
        Some((to_f64(driver.settings().tolerance), report))
    }

    fn index(&self) -> usize {
        self.stepper.scheme().state().index
    }

    fn time(&self) -> f64 {
        to_f64(self.stepper.scheme().state().time)
    }

    fn dofs(&self) -> usize {
        self.stepper.scheme().system().dofs()
    }

    fn q(&self) -> Vec<f64> {
        plain(&self.stepper.scheme().state().q)
    }

    fn v(&self) -> Vec<f64> {
        plain(&self.stepper.scheme().state().v)
    }

    fn energies(&self) -> Energies<f64> {
        let Energies { kinetic, elastic, potential } = self.stepper.scheme().last_step().energies;
        Energies { kinetic: to_f64(kinetic), elastic: to_f64(elastic), potential: to_f64(potential) }
    }

    fn contacts(&self) -> Vec<ContactRecord> {
        let scheme = self.stepper.scheme();
        let record = |contact| ContactRecord::new(scheme.system(), contact);
        scheme.last_step().contacts.iter().map(record).collect()
    }

    fn mesh(&self) -> Option<&Mesh> {
        self.stepper.scheme().system().geometry().map(|geometry| geometry.mesh())
    }

    fn candidates(&mut self, reach: f64) -> Vec<(ContactId, String)> {
        let found = match &mut self.stepper {
            Stepper::Fixed(scheme) => scheme.candidates(lit(reach)),
            Stepper::Adaptive(driver) => driver.candidates(lit(reach)),
        };
        let found: Vec<ContactId> = found.iter().map(|candidate| candidate.id).collect();
        let system = self.stepper.scheme().system();
        found.into_iter().map(|id| (id, system.contact_label(id))).collect()
    }

    #[cfg(feature = "fclib")]
    fn cone_problem(
        &self,
        info: crate::fclib::Info,
    ) -> Result<crate::fclib::Problem, crate::fclib::FclibError> {
        crate::fclib::Problem::from_cone(&self.stepper.scheme().cone_problem().cast::<f64>(), info)
    }

    fn overlaps(&mut self) -> Vec<(String, f64)> {
        let found = match &mut self.stepper {
            Stepper::Fixed(scheme) => scheme.candidates(T::zero()),
            Stepper::Adaptive(driver) => driver.candidates(T::zero()),
        };
        let deep = found.iter().filter(|candidate| candidate.gap < T::zero());
        let deep: Vec<_> = deep.map(|candidate| (candidate.id, to_f64(candidate.gap))).collect();
        let system = self.stepper.scheme().system();
        deep.into_iter().map(|(id, gap)| (system.contact_label(id), gap)).collect()
    }

    fn moved_by(&self, contact: ContactId) -> Vec<usize> {
        let scheme = self.stepper.scheme();
        let mut row = BlockRows::<T, D>::new();
        scheme.system().jacobian(contact, &scheme.state().q, &mut row);
        if row.rows() > 0 { row.row(0).map(|(dof, _)| dof).collect() } else { Vec::new() }
    }

    fn begin(&self, sinks: &mut [&mut dyn Sink]) -> Result<(), ObserveError> {
        self.stepper.begin(&self.info, &mut observers(sinks))
    }

    fn advance(
        &mut self,
        steps: usize,
        sinks: &mut [&mut dyn Sink],
        interrupt: &AtomicBool,
    ) -> Result<Ended, SimulateError> {
        let index = self.index();
        let last = self.last.filter(|&(before, _)| (index..index.saturating_add(steps)).contains(&before));
        let Some((before, length)) = last else {
            return self.stepper.advance(steps, &mut observers(sinks), interrupt);
        };
        if self.stepper.advance(before - index, &mut observers(sinks), interrupt)? == Ended::Interrupted {
            return Ok(Ended::Interrupted);
        }
        match self.stepper.fixed().map(|scheme| scheme.set_step(length)) {
            Some(Err(SetupError::MovingStep | SetupError::SleepingStep)) => Ok(Ended::Completed),
            Some(Err(error)) => Err(error.into()),
            _ => self.stepper.advance(1, &mut observers(sinks), interrupt),
        }
    }

    fn end(&self, sinks: &mut [&mut dyn Sink]) -> Result<(), ObserveError> {
        self.stepper.end(&mut observers(sinks))
    }

    fn snapshot(&self) -> Option<Snapshot> {
        match &self.stepper {
            Stepper::Fixed(scheme) => Some(scheme.snapshot()),
            Stepper::Adaptive(_) => None,
        }
    }

    fn restore(&mut self, snapshot: &Snapshot) -> Result<(), RestoreError> {
        match self.stepper.fixed() {
            Some(scheme) => {
                // A run that is over has made its last step with another length.
                let whole: T = lit(self.info.step);
                if scheme.settings().step != whole && scheme.set_step(whole).is_err() {
                    return Err(RestoreError { what: "the step has another length".into() });
                }
                scheme.restore(snapshot)
            }
            None => Err(RestoreError { what: "error control keeps more than a snapshot holds".into() }),
        }
    }
}
