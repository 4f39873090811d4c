//! The runs of a study of a scene, made.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

use super::engine::{Tasks, complete, spread};
use super::job::Job;
use super::reference::Reference;
use super::references::Target;
use super::run::{RunOutcome, measure};
use super::settings::RunSettings;
use super::{MarkSpec, SceneStudy, StudyError, StudyOptions, StudyProgress};
use crate::observe::Units;

/// A run that was made.
#[derive(Debug, Clone)]
pub struct Row {
    /// Its settings.
    pub settings: RunSettings,
    /// End of the run (s).
    pub end: f64,
    /// What came of it.
    pub outcome: RunOutcome,
}

/// What a study of a scene left.
#[derive(Debug)]
pub struct SceneResults {
    /// Title of the figures.
    pub title: String,
    /// Units of the scene.
    pub units: &'static Units,
    /// Which lines the figures mark.
    pub mark: Option<MarkSpec>,
    /// Keys of the scene that the study varies.
    pub keys: Vec<String>,
    /// The runs, in the order of the study.
    pub rows: Vec<Row>,
    /// Runs an interruption left undone.
    pub missing: usize,
}

/// References made so far, by the number of what they depend on.
type Made = BTreeMap<u64, Arc<dyn Reference>>;

struct SceneTasks<'a> {
    study: &'a SceneStudy,
    /// The reference of each job.
    targets: Vec<(u64, Target)>,
    /// Different references.
    count: usize,
    options: &'a StudyOptions,
    made: Mutex<Made>,
}

impl SceneStudy {
    /// Number of runs.
    pub fn runs(&self) -> usize {
        self.jobs.len()
    }

    /// Makes the runs that the folder of results does not have yet, and tells of each; ends early, and in order, once
    /// `stop` is raised.
    ///
    /// # Errors
    /// [`StudyError`] for a reference that does not know the motion, and for what cannot be written. A run that fails is
    /// a row.
    pub fn run(
        &self,
        folder: &Path,
        options: &StudyOptions,
        stop: &AtomicBool,
        tell: &mut dyn FnMut(StudyProgress),
    ) -> Result<SceneResults, StudyError> {
        let least = self.jobs.iter().filter_map(Job::step).min_by(f64::total_cmp);
        let target = |job: &Job| {
            let target = Target::new(&self.registry, &self.reference, job, least)?;
            let key = target.key().map_err(|source| StudyError::io(folder, source))?;
            Ok((key, target))
        };
        let targets = self.jobs.iter().map(target).collect::<Result<Vec<_>, StudyError>>()?;
        let different: BTreeMap<u64, &Target> = targets.iter().map(|(key, target)| (*key, target)).collect();
        let count = different.len();
        let made = Mutex::new(Made::new());
        let tasks = SceneTasks { study: self, targets, count, options, made };
        let outcomes = complete(&tasks, folder, options, stop, tell)?;
        let missing = outcomes.iter().filter(|outcome| outcome.is_none()).count();
        let row = |(job, outcome): (&Job, Option<RunOutcome>)| {
            outcome.map(|outcome| Row { settings: job.settings.clone(), end: job.scene.time.end, outcome })
        };
        Ok(SceneResults {
            title: self.title.clone(),
            units: self.units,
            mark: self.mark.clone(),
            keys: self.keys.clone(),
            rows: self.jobs.iter().zip(outcomes).filter_map(row).collect(),
            missing,
        })
    }
}

impl Job {
    /// h, where the steps are of one length.
    fn step(&self) -> Option<f64> {
        match self.settings.stepping {
            super::Stepping::Fixed(h) => Some(h),
            super::Stepping::Adaptive(_) => None,
        }
    }
}

impl Tasks for SceneTasks<'_> {
    type Outcome = RunOutcome;

    fn keys(&self) -> Vec<u64> {
        let both = self.study.jobs.iter().zip(&self.targets);
        both.map(|(job, (reference, _))| job.key.and(&reference.to_le_bytes()).number()).collect()
    }

    fn cost(&self, task: usize) -> f64 {
        // Under error control nobody knows, and not many.
        self.study.jobs[task].run.steps as f64
    }

    fn prepare(&self, open: &[usize], stop: &AtomicBool) -> Result<(), StudyError> {
        let mut first = BTreeMap::new();
        open.iter().for_each(|&task| {
            first.entry(self.targets[task].0).or_insert(task);
        });
        let tasks: Vec<usize> = first.into_values().collect();
        let make = |task: usize, stop: &AtomicBool| {
            self.targets[task].1.make(&self.study.registry, self.count, stop)
        };
        spread(self.options.threads, &tasks, stop, &make, &mut |task, reference| {
            self.references().insert(self.targets[task].0, reference);
            Ok(())
        })
    }

    fn work(&self, task: usize, stop: &AtomicBool) -> Result<Option<RunOutcome>, StudyError> {
        let reference = self.references().get(&self.targets[task].0).cloned();
        let (registry, job) = (&self.study.registry, &self.study.jobs[task]);
        Ok(reference.and_then(|reference| measure(registry, job, &reference, self.options.timed, stop)))
    }
}

impl SceneTasks<'_> {
    fn references(&self) -> std::sync::MutexGuard<'_, Made> {
        self.made.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}
