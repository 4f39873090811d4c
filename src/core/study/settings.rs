//! The settings of a run: what varies in a study.

use toml::Value;

use super::format::Axis;
use crate::scene::{PlannedRun, ScalarName, Scene};

/// How long the steps are.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Stepping {
    /// All h (s).
    Fixed(f64),
    /// Such that the error stays within ε.
    Adaptive(f64),
}

impl Stepping {
    /// That of a scene.
    fn of(scene: &Scene) -> Self {
        scene
            .time
            .adaptive
            .map_or(Self::Fixed(scene.time.step), |adaptive| Self::Adaptive(adaptive.tolerance))
    }

    /// `fixed` or `adaptive`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fixed(_) => "fixed",
            Self::Adaptive(_) => "adaptive",
        }
    }

    /// h or ε.
    pub fn value(self) -> f64 {
        match self {
            Self::Fixed(value) | Self::Adaptive(value) => value,
        }
    }
}

/// The settings of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSettings {
    /// Law of the interfaces that keep none of their own.
    pub law: String,
    /// θ.
    pub theta: f64,
    /// h or ε.
    pub stepping: Stepping,
    /// Cone solver.
    pub solver: String,
    /// Its tolerance.
    pub tolerance: f64,
    /// `f64` or `f32`.
    pub scalar: ScalarName,
    /// Other keys of the scene, by name, with their values.
    pub keys: Vec<(String, Value)>,
}

/// The short names of a study, and the keys of a scene they stand for.
pub(super) const SHORT: [(&str, &str); 7] = [
    ("law", "laws"),
    ("theta", "time.theta"),
    ("h", "time.step"),
    ("epsilon", "time.tolerance"),
    ("solver", "solvers"),
    ("tolerance", "solver.tolerance"),
    ("scalar", "scalar"),
];

/// What the scene has to change for a value of a key of the study.
pub(super) fn changes(key: &str, value: &Value) -> Vec<(String, Value)> {
    let set = |key: &str, value: Value| (key.to_string(), value);
    match SHORT.iter().find(|(short, _)| *short == key) {
        Some(("epsilon", long)) => vec![set("time.step", "adaptive".into()), set(long, value.clone())],
        // A run has one law and one solver.
        Some((_, long @ ("laws" | "solvers"))) => vec![set(long, Value::Array(vec![value.clone()]))],
        Some((_, long)) => vec![set(long, value.clone())],
        None => vec![set(key, value.clone())],
    }
}

impl RunSettings {
    /// The settings of a run of a scene; `keys` are those of the study that are keys of the scene.
    pub(super) fn new(scene: &Scene, run: &PlannedRun, keys: Vec<(String, Value)>) -> Self {
        Self {
            law: run.law.clone(),
            theta: run.theta,
            stepping: Stepping::of(scene),
            solver: run.solver.clone(),
            tolerance: scene.solver.tolerance.unwrap_or_else(|| scene.scalar.default_tolerance()),
            scalar: scene.scalar,
            keys,
        }
    }

    /// Every setting by name, as the tables show it; `names` are the keys of the scene the study varies.
    pub(super) fn fields(&self, names: &[String]) -> Vec<(String, String)> {
        let stepping = |name: &str, wanted: &str| {
            let value =
                if wanted == self.stepping.name() { number(self.stepping.value()) } else { String::new() };
            (name.to_string(), value)
        };
        let field = |name: &str, value: String| (name.to_string(), value);
        let mut fields = vec![
            field("law", self.law.clone()),
            field("theta", number(self.theta)),
            field("scheme", self.stepping.name().into()),
            stepping("h", "fixed"),
            stepping("epsilon", "adaptive"),
            field("solver", self.solver.clone()),
            field("tolerance", number(self.tolerance)),
            field("scalar", self.scalar.name().into()),
        ];
        let key = |name: &String| {
            let value = self.keys.iter().find(|(key, _)| key == name).map(|(_, value)| text(value));
            (name.clone(), value.unwrap_or_default())
        };
        fields.extend(names.iter().map(key));
        fields
    }

    /// The settings in words, for errors.
    pub(super) fn words(&self) -> String {
        let names: Vec<String> = self.keys.iter().map(|(key, _)| key.clone()).collect();
        let fields = self.fields(&names);
        let given = fields.iter().filter(|(_, value)| !value.is_empty());
        given.map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", ")
    }
}

/// A value of the study for tables.
pub(super) fn text(value: &Value) -> String {
    match (value, Axis::number(value)) {
        (Value::String(text), _) => text.clone(),
        (_, Some(x)) => number(x),
        _ => value.to_string(),
    }
}

/// The shortest decimal number that is read back as `x`.
pub(super) fn number(x: f64) -> String {
    if x == 0.0 || (1e-3..1e6).contains(&x.abs()) { format!("{x}") } else { format!("{x:e}") }
}
