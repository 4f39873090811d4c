//! Studies of solvers over a folder of problems.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use super::engine::{Tasks, complete};
use super::format::{Axis, BudgetSpec, StudyFile};
use super::{StudyError, StudyOptions, StudyProgress};
use crate::collection::{
    BenchmarkOptions, Measurement, Sweep, measure, measure_single, problem_files, problem_name, read,
};
use crate::fclib::Cone;
use crate::registry::Registry;
use crate::scalar::Scalar;
use crate::scene::Fingerprint;
use crate::solver::Stopping;

/// A study of solvers: each problem of a folder with every solver to every tolerance in every arithmetic.
///
/// A problem counts as solved where both residuals are within the tolerance; single precision is judged by the residuals
/// in double precision. A solver that misses a tolerance on a problem is not tried on finer ones: they count as not solved.
#[derive(Debug)]
pub struct ProblemStudy {
    /// Title of the figures.
    pub title: String,
    /// Budgets and figures.
    pub budget: BudgetSpec,
    files: Vec<PathBuf>,
    tolerances: Vec<f64>,
    /// Problem, solver and arithmetic of each task.
    tasks: Vec<(usize, String, String)>,
    registry: Registry,
}

/// What a study of solvers left.
#[derive(Debug)]
pub struct ProblemResults {
    /// All measurements.
    pub sweep: Sweep,
    /// Problems with a solver in an arithmetic that an interruption left undone.
    pub missing: usize,
}

impl ProblemStudy {
    pub(super) fn new(
        registry: &Registry,
        file: StudyFile,
        blocks: &[Vec<Axis>],
        text: &str,
        path: &Path,
    ) -> Result<Self, StudyError> {
        let folder = path.parent().unwrap_or(Path::new("")).join(file.problems.unwrap_or_default());
        let files = problem_files(&folder)?;
        let refuse = |at: usize, message: String| StudyError::parse(path, text, at, message);
        let none = Vec::new();
        let block = match blocks {
            [] => &none,
            [block] => block,
            [_, second, ..] => {
                let at = second.first().map_or(0, |axis| axis.at);
                return Err(refuse(at, "a study of problems has one block of runs".into()));
            }
        };
        let mut solvers: Vec<String> = registry.solvers().map(|solver| solver.name.into()).collect();
        let mut tolerances: Vec<f64> = (2..=12).map(|power| 10f64.powi(-power)).collect();
        let mut scalars = vec![f64::NAME.to_string()];
        for Axis { key, at, values } in block {
            let refuse = |message: String| refuse(*at, format!("{key}: {message}"));
            let names = || {
                let name = |value: &toml::Value| value.as_str().map(String::from);
                values
                    .iter()
                    .map(name)
                    .collect::<Option<Vec<_>>>()
                    .ok_or_else(|| refuse("expected names".into()))
            };
            match key.as_str() {
                "solver" => solvers = names()?,
                "scalar" => scalars = names()?,
                "tolerance" => {
                    let numbers: Option<Vec<f64>> = values.iter().map(Axis::number).collect();
                    tolerances = numbers.ok_or_else(|| refuse("expected numbers".into()))?;
                }
                _ => return Err(refuse("problems have `solver`, `tolerance` and `scalar`".into())),
            }
            for name in solvers.iter().filter(|_| key == "solver") {
                registry.find_solver(name).map_err(|error| refuse(error.to_string()))?;
            }
            if let Some(name) = scalars.iter().find(|name| ![f64::NAME, f32::NAME].contains(&name.as_str())) {
                return Err(refuse(format!("`{name}` is neither f64 nor f32")));
            }
            for &tolerance in &tolerances {
                Stopping::<f64>::to(tolerance).check().map_err(|error| refuse(error.to_string()))?;
            }
        }
        let budget = file.budget.unwrap_or_default();
        for (what, good) in [
            ("max_seconds must be > 0", budget.max_seconds.is_finite() && budget.max_seconds > 0.0),
            ("profiles must be among the tolerances", budget.profiles.iter().all(|t| tolerances.contains(t))),
        ] {
            if !good {
                return Err(refuse(0, format!("budget: {what}")));
            }
        }
        tolerances.sort_by(|a, b| b.total_cmp(a));
        tolerances.dedup();
        let mut tasks = Vec::new();
        for problem in 0..files.len() {
            for scalar in &scalars {
                tasks.extend(solvers.iter().map(|solver| (problem, solver.clone(), scalar.clone())));
            }
        }
        let registry = registry.clone();
        Ok(Self { title: file.title, budget, files, tolerances, tasks, registry })
    }

    /// Number of problems with a solver in an arithmetic.
    pub fn runs(&self) -> usize {
        self.tasks.len()
    }

    /// Solves what the folder of results does not have yet, and tells of each; ends early, and in order, once `stop` is
    /// raised.
    ///
    /// # Errors
    /// [`StudyError`] for a file that holds no problem, and for what cannot be written.
    pub fn run(
        &self,
        folder: &Path,
        options: &StudyOptions,
        stop: &AtomicBool,
        tell: &mut dyn FnMut(StudyProgress),
    ) -> Result<ProblemResults, StudyError> {
        let read = |file: &PathBuf| std::fs::read(file).map_err(|source| StudyError::io(file, source));
        let bytes = self.files.iter().map(|file| Ok((Fingerprint::default().and(&read(file)?), file)));
        let prints = bytes
            .map(|pair: Result<_, StudyError>| pair.map(|(print, _)| print))
            .collect::<Result<Vec<_>, _>>()?;
        let cones = self.files.iter().map(|_| OnceLock::new()).collect();
        let outcomes = complete(&ProblemTasks { study: self, prints, cones }, folder, options, stop, tell)?;
        let missing = outcomes.iter().filter(|outcome| outcome.is_none()).count();
        let measurements = outcomes.into_iter().flatten().flatten().collect();
        Ok(ProblemResults { sweep: Sweep { measurements }, missing })
    }
}

struct ProblemTasks<'a> {
    study: &'a ProblemStudy,
    prints: Vec<Fingerprint>,
    cones: Vec<OnceLock<Cone>>,
}

impl Tasks for ProblemTasks<'_> {
    /// A measurement for each tolerance.
    type Outcome = Vec<Measurement>;

    fn keys(&self) -> Vec<u64> {
        let ProblemStudy { budget, tolerances, .. } = self.study;
        let common = format!("{tolerances:?} {} {}", budget.max_seconds, budget.repeat);
        let key = |(problem, solver, scalar): &(usize, String, String)| {
            let words = format!("{} {solver} {scalar} {common}", problem_name(&self.study.files[*problem]));
            self.prints[*problem].and(words.as_bytes()).number()
        };
        self.study.tasks.iter().map(key).collect()
    }

    fn cost(&self, task: usize) -> f64 {
        let file = &self.study.files[self.study.tasks[task].0];
        std::fs::metadata(file).map_or(0.0, |data| data.len() as f64)
    }

    fn prepare(&self, _open: &[usize], _stop: &AtomicBool) -> Result<(), StudyError> {
        Ok(())
    }

    fn work(&self, task: usize, stop: &AtomicBool) -> Result<Option<Self::Outcome>, StudyError> {
        let (problem, solver, scalar) = &self.study.tasks[task];
        let file = &self.study.files[*problem];
        let cone = match self.cones[*problem].get() {
            Some(cone) => cone,
            None => {
                let cone = read(file)?;
                self.cones[*problem].get_or_init(|| cone)
            }
        };
        let mut measurements: Vec<Measurement> = Vec::new();
        for &tolerance in &self.study.tolerances {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            if let Some(last) = measurements.last().filter(|last| !last.solved) {
                let missed =
                    Measurement { tolerance, cpu_seconds: f64::NAN, curve: Vec::new(), ..last.clone() };
                measurements.push(missed);
                continue;
            }
            let options = BenchmarkOptions {
                solvers: Vec::new(),
                tolerance,
                max_seconds: self.study.budget.max_seconds,
                repeat: self.study.budget.repeat,
            };
            let measure = if scalar == f64::NAME { measure } else { measure_single };
            measurements.push(measure(&self.study.registry, &problem_name(file), cone, solver, &options)?);
        }
        Ok(Some(measurements))
    }
}
