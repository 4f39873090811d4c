//! The runs a scene asks for: every law with every solver, after what the caller overrides.

use super::{AdaptiveSpec, ScalarName, Scene, SceneError};
use crate::registry::Registry;

/// What a caller may change of a scene; `None` and empty lists leave it as it is.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overrides {
    /// Laws to run.
    pub laws: Vec<String>,
    /// Solvers to run.
    pub solvers: Vec<String>,
    /// θ.
    pub theta: Option<f64>,
    /// Time step (s), fixed.
    pub step: Option<f64>,
    /// Error control with this tolerance, in place of fixed steps or of the scene's tolerance.
    pub adaptive: Option<f64>,
    /// End time (s).
    pub end: Option<f64>,
    /// Solver tolerance.
    pub tolerance: Option<f64>,
    /// Arithmetic.
    pub scalar: Option<ScalarName>,
    /// Accept a θ outside the claimed intervals.
    pub allow_unproved_theta: bool,
    /// Mesh file of the elastic body, from the working folder.
    pub mesh: Option<std::path::PathBuf>,
}

/// One run of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedRun {
    /// Law of the interfaces that keep none of their own.
    pub law: String,
    /// Cone solver.
    pub solver: String,
    /// Scheme parameter θ: the scene's, or one that suits the laws of the run.
    pub theta: f64,
    /// Number of steps; 0 under error control, which chooses it.
    pub steps: usize,
    /// Length of the last step (s) where it is shorter than the others, so that it ends at the end time.
    pub last_step: Option<f64>,
}

impl Scene {
    /// Applies what the caller overrides.
    pub fn override_with(&mut self, overrides: &Overrides) {
        if !overrides.laws.is_empty() {
            self.laws.clone_from(&overrides.laws);
        }
        if !overrides.solvers.is_empty() {
            self.solvers.clone_from(&overrides.solvers);
        }
        let time = &mut self.time;
        time.theta = overrides.theta.or(time.theta);
        time.step = overrides.step.unwrap_or(time.step);
        time.end = overrides.end.unwrap_or(time.end);
        if overrides.step.is_some() {
            time.adaptive = None;
        }
        if let Some(tolerance) = overrides.adaptive {
            let spec = time.adaptive.unwrap_or(AdaptiveSpec::new(tolerance));
            time.adaptive = Some(AdaptiveSpec { tolerance, ..spec });
        }
        time.allow_unproved_theta |= overrides.allow_unproved_theta;
        if let (Some(solid), Some(file)) = (&mut self.solid, &overrides.mesh) {
            // The name of a file may start from the working folder or from the scene's: made absolute, from neither.
            let file = std::path::absolute(file).unwrap_or_else(|_| file.clone());
            solid.mesh = super::MeshSpec { file: Some(file), ..super::MeshSpec::default() };
        }
        self.scalar = overrides.scalar.unwrap_or(self.scalar);
        self.solver.tolerance = overrides.tolerance.or(self.solver.tolerance);
    }

    /// The runs, laws first.
    ///
    /// # Errors
    /// [`SceneError::Empty`], an unknown law or solver, a step or an end time out of range.
    pub fn runs(&self, registry: &Registry) -> Result<Vec<PlannedRun>, SceneError> {
        for (what, empty) in [("law", self.laws.is_empty()), ("solver", self.solvers.is_empty())] {
            if empty {
                return Err(SceneError::Empty { what });
            }
        }
        for law in &self.laws {
            registry.find_law(law).map_err(SceneError::UnknownLaw)?;
        }
        for name in &self.solvers {
            registry.find_solver(name)?;
        }
        for names in [&self.laws, &self.solvers] {
            // A run is known by its law and its solver: twice the same would overwrite its own results.
            if let Some((_, name)) = names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)) {
                return Err(SceneError::DuplicateName { name: name.clone() });
            }
        }
        let output = &self.output;
        let rates = [
            ("output.every", output.every),
            ("output.trajectory_every", output.trajectory_every),
            ("output.contacts_every", output.contacts_every),
            ("output.vtk_every", output.vtk_every),
        ];
        if let Some((what, _)) = rates.iter().find(|(_, rate)| *rate == Some(0)) {
            let what = (*what).into();
            return Err(SceneError::OutOfRange { what, value: 0.0, range: "at least 1" });
        }
        let (steps, last_step) = self.steps()?;
        let mut runs = Vec::new();
        for law in &self.laws {
            let theta = self.theta(law, registry);
            for solver in &self.solvers {
                let (law, solver) = (law.clone(), solver.clone());
                runs.push(PlannedRun { law, solver, theta, steps, last_step });
            }
        }
        Ok(runs)
    }

    fn steps(&self) -> Result<(usize, Option<f64>), SceneError> {
        let (step, end) = (self.time.step, self.time.end);
        let positive = |x: f64| x.is_finite() && x > 0.0;
        for (what, value) in [("time.step", step), ("time.end", end)] {
            if !positive(value) {
                return Err(SceneError::OutOfRange { what: what.into(), value, range: "finite and > 0" });
            }
        }
        if self.time.adaptive.is_some() {
            return Ok((0, None));
        }
        // An end that is a multiple of h but for rounding must not cost a step more.
        let exact = end / step;
        let steps = (exact - ROUNDING).ceil().max(1.0);
        if steps > 1e15 {
            let what = "the number of steps".into();
            return Err(SceneError::OutOfRange { what, value: steps, range: "at most 1e15" });
        }
        let is_short = steps > 1.0 && exact < steps - ROUNDING && !self.time.whole_steps;
        Ok((steps as usize, is_short.then_some(end - (steps - 1.0) * step)))
    }

    /// Length of the steps (s): never longer than the run, unless it may end after its end time.
    pub(super) fn step_length(&self) -> f64 {
        let time = &self.time;
        if time.whole_steps || time.adaptive.is_some() { time.step } else { time.step.min(time.end) }
    }
}

/// A part of a step that is rounding of the quotient of the end time by the step.
const ROUNDING: f64 = 1e-6;
