//! From a study file to its runs.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use toml::Value;

use super::format::{Axis, MarkSpec, ReferenceSpec, StudyFile};
use super::job::Job;
use super::settings::{RunSettings, SHORT, changes};
use super::{StudyError, references};
use crate::observe::Units;
use crate::registry::Registry;
use crate::scene::{PlannedRun, Scene, contact_dimension};

/// Runs a study may have.
const MOST_RUNS: usize = 100_000;

/// A study of a scene: its runs in the order of the table, the last of its lists running fastest.
#[derive(Debug)]
pub struct SceneStudy {
    /// Title of the figures.
    pub title: String,
    /// Units of the scene.
    pub units: &'static Units,
    /// What the runs are measured against.
    pub reference: ReferenceSpec,
    /// Which lines the figures mark.
    pub mark: Option<MarkSpec>,
    /// Keys of the scene that the study varies.
    pub(super) keys: Vec<String>,
    pub(super) jobs: Vec<Job>,
    pub(super) registry: Registry,
}

/// The order in which lists are run through, the slowest first; other keys come before the steps.
const ORDER: [&str; 5] = ["law", "theta", "scalar", "solver", "tolerance"];

impl SceneStudy {
    pub(super) fn new(
        registry: &Registry,
        file: StudyFile,
        blocks: Vec<Vec<Axis>>,
        text: &str,
        path: &Path,
        scene: PathBuf,
    ) -> Result<Self, StudyError> {
        let base = std::fs::read_to_string(&scene).map_err(|source| StudyError::io(&scene, source))?;
        let units = Scene::parse(&base, &scene)?.units.units();
        let base = Scene::table(&base, &scene)?;
        let finest = || ReferenceSpec { kind: references::FINEST.into(), h: None, theta: None };
        let reference = file.reference.unwrap_or_else(finest);
        references::check(&reference).map_err(|message| StudyError::parse(path, text, 0, message))?;
        let mut keys = BTreeSet::new();
        let mut jobs: Vec<Job> = Vec::new();
        // A study without blocks makes the runs of the scene.
        let blocks = if blocks.is_empty() { vec![Vec::new()] } else { blocks };
        for mut block in blocks {
            for axis in &block {
                check_axis(axis, &base, &scene, registry).map_err(|refused| refused.at(axis, text, path))?;
            }
            let rank = |axis: &Axis| match ORDER.iter().position(|key| *key == axis.key) {
                Some(place) => place,
                None if axis.key == "h" || axis.key == "epsilon" => ORDER.len() + 1,
                None => ORDER.len(),
            };
            block.sort_by_key(rank);
            keys.extend(block.iter().filter(|axis| !is_short(&axis.key)).map(|axis| axis.key.clone()));
            for choice in product(&block)? {
                jobs.extend(of_choice(&base, &scene, &choice, registry)?);
                if jobs.len() > MOST_RUNS {
                    return Err(StudyError::TooMany { runs: jobs.len(), most: MOST_RUNS });
                }
            }
        }
        let mut seen = BTreeSet::new();
        if let Some(job) = jobs.iter().find(|job| !seen.insert(job.key.number())) {
            return Err(StudyError::Twice { settings: job.settings.words() });
        }
        let names: Vec<String> = keys.into_iter().collect();
        if let (Some(mark), Some(job)) = (&file.mark, jobs.first()) {
            let fields = job.settings.fields(&names);
            let unknown = mark.settings.keys().find(|key| fields.iter().all(|(name, _)| name != *key));
            if let Some(key) = unknown {
                let known: Vec<String> = fields.into_iter().map(|(name, _)| name).collect();
                let message = format!("mark: there is no setting `{key}` (known: {})", known.join(", "));
                return Err(StudyError::parse(path, text, 0, message));
            }
        }
        let registry = registry.clone();
        Ok(Self { title: file.title, units, reference, mark: file.mark, keys: names, jobs, registry })
    }
}

fn is_short(key: &str) -> bool {
    SHORT.iter().any(|(short, _)| *short == key)
}

/// Why a list cannot be run through.
enum Refused {
    Key(String),
    Value(Box<crate::scene::SceneError>),
}

impl Refused {
    fn at(self, axis: &Axis, text: &str, path: &Path) -> StudyError {
        let key = axis.key.clone();
        match self {
            Self::Key(message) => StudyError::parse(path, text, axis.at, format!("{key}: {message}")),
            Self::Value(source) => {
                let (line, column) = crate::scene::line_and_column(text, axis.at);
                StudyError::Value { path: path.into(), line, column, key, source }
            }
        }
    }
}

/// Whether the scene takes each of the values.
fn check_axis(axis: &Axis, base: &toml::Table, scene: &Path, registry: &Registry) -> Result<(), Refused> {
    if let Some((short, _)) = SHORT.iter().find(|(_, long)| *long == axis.key && axis.key != "scalar") {
        return Err(Refused::Key(format!("this is called `{short}` in a study")));
    }
    for value in &axis.values {
        let numbers = ["h", "epsilon", "theta", "tolerance"].contains(&axis.key.as_str());
        if numbers && Axis::number(value).is_none() {
            return Err(Refused::Key(format!("{value} is not a number")));
        }
        let epsilon = Axis::number(value).filter(|_| axis.key == "epsilon");
        if let Some(epsilon) = epsilon.filter(|&epsilon| !(epsilon > 0.0 && epsilon <= 0.5)) {
            return Err(Refused::Key(format!("ε is {epsilon}, it must be in (0, 0.5]")));
        }
        let changed = Scene::with_keys(base, scene, &changes(&axis.key, value));
        changed.and_then(|scene| scene.runs(registry)).map_err(|source| Refused::Value(Box::new(source)))?;
    }
    Ok(())
}

/// A value for every key.
type Choice = Vec<(String, Value)>;

/// The product of the lists; h and ε are entries of one list.
fn product(block: &[Axis]) -> Result<Vec<Choice>, StudyError> {
    let (steps, others): (Vec<&Axis>, Vec<&Axis>) =
        block.iter().partition(|axis| axis.key == "h" || axis.key == "epsilon");
    let entries = |axis: &Axis| {
        let key = axis.key.clone();
        axis.values.iter().map(move |value| (key.clone(), value.clone())).collect::<Vec<_>>()
    };
    let mut lists: Vec<Choice> = others.into_iter().map(entries).collect();
    if !steps.is_empty() {
        lists.push(steps.into_iter().flat_map(entries).collect());
    }
    let runs = lists.iter().map(Vec::len).fold(1, usize::saturating_mul);
    if runs > MOST_RUNS {
        return Err(StudyError::TooMany { runs, most: MOST_RUNS });
    }
    let mut choices: Vec<Choice> = vec![Vec::new()];
    for list in &lists {
        let longer = |choice: &Choice| {
            let choice = choice.clone();
            list.iter().map(move |entry| [&choice[..], std::slice::from_ref(entry)].concat())
        };
        choices = choices.iter().flat_map(longer).collect();
    }
    Ok(choices)
}

/// The runs of a choice: one, or where it names no law or solver one for each of the scene.
fn of_choice(
    base: &toml::Table,
    path: &Path,
    choice: &Choice,
    registry: &Registry,
) -> Result<Vec<Job>, StudyError> {
    let all: Vec<_> = choice.iter().flat_map(|(key, value)| changes(key, value)).collect();
    let scene = Scene::with_keys(base, path, &all)?;
    let keys: Choice = choice.iter().filter(|(key, _)| !is_short(key)).cloned().collect();
    let job = |run: PlannedRun| {
        let scene = Scene { laws: vec![run.law.clone()], solvers: vec![run.solver.clone()], ..scene.clone() };
        let settings = RunSettings::new(&scene, &run, keys.clone());
        let dimension =
            contact_dimension(&scene, std::slice::from_ref(&run), registry).map_err(|source| {
                StudyError::Combination { settings: settings.words(), source: Box::new(source) }
            })?;
        let key = scene.fingerprint().map_err(|source| StudyError::io(path, source))?;
        Ok(Job { settings, scene, run, dimension, key })
    };
    scene.runs(registry)?.into_iter().map(job).collect()
}
