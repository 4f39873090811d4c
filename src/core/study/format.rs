//! The study file as it is written; unknown keys and values are refused with their line and column.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use toml::{Spanned, Value};

use super::StudyError;

/// A study file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StudyFile {
    /// Title of the figures.
    pub(super) title: String,
    /// Scene file, from the folder of the study.
    pub(super) scene: Option<String>,
    /// Folder of problem files, from the folder of the study.
    pub(super) problems: Option<String>,
    /// What the runs of a scene are measured against.
    pub(super) reference: Option<ReferenceSpec>,
    /// Blocks of runs: of each the product of its lists.
    #[serde(default)]
    pub(super) runs: Vec<BTreeMap<String, Spanned<Value>>>,
    /// Settings whose lines the figures show wider than the others.
    pub(super) mark: Option<MarkSpec>,
    /// What is asked of solvers over problems.
    pub(super) budget: Option<BudgetSpec>,
}

/// What the runs of a scene are measured against, see [`crate::study`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceSpec {
    /// `finest`, or the name of a closed form.
    pub kind: String,
    /// h of the finest run (s); an eighth of the smallest h of the study where absent.
    pub h: Option<f64>,
    /// θ of the finest run; that of each run where absent.
    pub theta: Option<f64>,
}

/// Lines the figures mark: those with all of the settings given.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct MarkSpec {
    /// Words for the legend.
    pub label: String,
    /// Settings by the names of the columns of `runs.csv`.
    #[serde(flatten)]
    pub settings: BTreeMap<String, Value>,
}

/// What is asked of solvers over problems.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BudgetSpec {
    /// Largest wall time of one solve (s). Default 10.
    #[serde(default = "ten")]
    pub max_seconds: f64,
    /// Timings taken, of which the least counts. Default 3.
    #[serde(default = "three")]
    pub repeat: usize,
    /// Tolerances whose performance profiles are drawn. Default 1e-4, 1e-8.
    #[serde(default = "profiles")]
    pub profiles: Vec<f64>,
}

impl Default for BudgetSpec {
    fn default() -> Self {
        Self { max_seconds: ten(), repeat: three(), profiles: profiles() }
    }
}

fn ten() -> f64 {
    10.0
}

fn three() -> usize {
    3
}

fn profiles() -> Vec<f64> {
    vec![1e-4, 1e-8]
}

/// The values a key takes in a block of runs.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    pub(super) key: String,
    /// Where they stand in the file.
    pub(super) at: usize,
    pub(super) values: Vec<Value>,
}

impl Axis {
    /// The value as a number.
    pub(super) fn number(value: &Value) -> Option<f64> {
        value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
    }
}

/// Values from one to another, at the middle of equal cells of the logarithm.
///
/// The errors of event-capturing schemes saw-tooth with the place of the impacts in their steps: steps that divide the
/// time of an impact would all show the same phase. The cells leave out the round ends.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Span {
    from: f64,
    to: f64,
    per_decade: f64,
}

/// Values a span may have.
const MOST_VALUES: f64 = 10_000.0;

impl Span {
    fn values(&self) -> Result<Vec<Value>, String> {
        let Self { from, to, per_decade } = *self;
        for (name, x) in [("from", from), ("to", to), ("per_decade", per_decade)] {
            if !(x.is_finite() && x > 0.0) {
                return Err(format!("{name} is {x}, it must be finite and > 0"));
            }
        }
        let decades = (to / from).log10();
        let count = (decades.abs() * per_decade).round().max(1.0);
        if count > MOST_VALUES {
            return Err(format!("{count} values, at most {MOST_VALUES} are taken"));
        }
        let at = |i: usize| from * 10f64.powf(decades * (i as f64 + 0.5) / count);
        Ok((0..count as usize).map(|i| at(i).into()).collect())
    }
}

/// The values of a key: those of a list, of a span, or the value itself.
fn values(value: &Value) -> Result<Vec<Value>, String> {
    match value {
        Value::Array(list) if list.is_empty() => Err("the list is empty".into()),
        Value::Array(list) => Ok(list.clone()),
        Value::Table(table)
            if table.keys().any(|key| ["from", "to", "per_decade"].contains(&key.as_str())) =>
        {
            Span::deserialize(value.clone()).map_err(|error| error.to_string())?.values()
        }
        other => Ok(vec![other.clone()]),
    }
}

impl StudyFile {
    /// Reads a study, and the axes of its blocks of runs.
    pub(super) fn parse(text: &str, path: &Path) -> Result<(Self, Vec<Vec<Axis>>), StudyError> {
        let file: Self = toml::from_str(text).map_err(|error| {
            StudyError::parse(path, text, error.span().map_or(0, |span| span.start), error.message())
        })?;
        if file.scene.is_some() == file.problems.is_some() {
            let message = "a study names either a `scene` or a folder of `problems`";
            return Err(StudyError::parse(path, text, 0, message));
        }
        let scenes_only = [("reference", file.reference.is_some()), ("mark", file.mark.is_some())];
        let problems_only = [("budget", file.budget.is_some())];
        let foreign = if file.scene.is_some() { &problems_only[..] } else { &scenes_only[..] };
        if let Some((key, _)) = foreign.iter().find(|(_, given)| *given) {
            let what = if file.scene.is_some() { "a scene" } else { "problems" };
            return Err(StudyError::parse(path, text, 0, format!("`{key}` means nothing for {what}")));
        }
        let axis = |(key, value): (&String, &Spanned<Value>)| {
            let at = value.span().start;
            let values = values(value.get_ref())
                .map_err(|message| StudyError::parse(path, text, at, format!("{key}: {message}")))?;
            Ok(Axis { key: key.clone(), at, values })
        };
        let block = |block: &BTreeMap<String, Spanned<Value>>| block.iter().map(axis).collect();
        let axes = file.runs.iter().map(block).collect::<Result<Vec<Vec<Axis>>, StudyError>>()?;
        Ok((file, axes))
    }
}
