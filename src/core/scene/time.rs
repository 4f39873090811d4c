//! `[time]`: fixed steps, or steps under error control.

use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer};

use crate::adaptive::AdaptiveSettings;
use crate::scalar::{Scalar, lit};
use crate::scheme::ActivationRule;

/// Time stepping.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "TimeFields")]
pub struct TimeSpec {
    /// Time step h > 0 (s), or `"adaptive"`: lengths chosen by error control.
    pub step: f64,
    /// Error control, where the file says `step = "adaptive"`.
    pub adaptive: Option<AdaptiveSpec>,
    /// End of the run (s); it starts at 0. The last step is shortened to end there, and a step longer than the run is the run;
    /// where displacements move or bodies may sleep, whose steps have one length, the run stops at the last whole step.
    pub end: f64,
    /// Make the last step as long as the others, past the end where that is no multiple of the step.
    pub whole_steps: bool,
    /// Scheme parameter θ ∈ [0, 1] (dimensionless); where absent the nearest to ½ for which every law of a run is proved
    /// dissipative.
    pub theta: Option<f64>,
    /// Accept a θ outside the interval in which a law is proved dissipative.
    pub allow_unproved_theta: bool,
    /// Contacts that carried a percussion and are slow are no impacts; `false` takes the rule of the active set literally.
    pub lasting: bool,
    /// θ ∈ [½, 1] (dimensionless) of islands all of whose contacts last.
    pub theta_rest: f64,
    /// Leave bodies at rest out of the steps until something touches them; goes with fixed steps alone.
    pub sleep: bool,
    /// Rule of the active set.
    pub activation: ActivationRule,
    /// Tolerance of the rule on the gap (m); scales with the scene where absent.
    pub gap_tolerance: Option<f64>,
    /// Tolerance of the rule on the normal velocity (m/s), above what the solver leaves; scales with the scene where
    /// absent.
    pub velocity_tolerance: Option<f64>,
    /// Opening of joints that a step may leave (m or rad); the rounding of positions where absent.
    pub joint_tolerance: Option<f64>,
}

/// Error control, see [`crate::adaptive`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdaptiveSpec {
    /// ε, the error aimed at as a share of the scene's length (dimensionless); needed by error control, and goes with it alone.
    pub tolerance: f64,
    /// Length of the first step tried (s); a hundredth of the span where absent. Of error control alone.
    pub first_step: Option<f64>,
    /// Smallest length of a step (s); 64 ε of the span where absent. Of error control alone.
    pub min_step: Option<f64>,
    /// Largest length of a step (s); a tenth of the span where absent. Of error control alone.
    pub max_step: Option<f64>,
    /// Largest number of steps computed in a thousandth of the span; 500,000 where absent. Of error control alone.
    pub max_steps: Option<usize>,
}

impl AdaptiveSpec {
    /// Tolerance ε, step lengths by default.
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance, first_step: None, min_step: None, max_step: None, max_steps: None }
    }
}

impl TimeSpec {
    /// The settings of a run under error control; `None` for fixed steps.
    pub fn adaptive_settings<T: Scalar>(&self) -> Option<AdaptiveSettings<T>> {
        let AdaptiveSpec { tolerance, first_step, min_step, max_step, max_steps } = self.adaptive?;
        let defaults = AdaptiveSettings::new(lit(tolerance), lit(self.end));
        Some(AdaptiveSettings {
            max_steps: max_steps.unwrap_or(defaults.max_steps),
            first_step: first_step.map(lit),
            min_step: min_step.map(lit),
            max_step: max_step.map(lit),
            ..defaults
        })
    }
}

/// The part of the span that a first step of error control has where nothing else is said.
const FIRST: f64 = 1e-2;

/// The table as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TimeFields {
    step: StepField,
    tolerance: Option<f64>,
    first_step: Option<f64>,
    min_step: Option<f64>,
    max_step: Option<f64>,
    max_steps: Option<usize>,
    end: f64,
    #[serde(default)]
    whole_steps: bool,
    theta: Option<f64>,
    #[serde(default)]
    allow_unproved_theta: bool,
    #[serde(default = "yes")]
    lasting: bool,
    #[serde(default = "one")]
    theta_rest: f64,
    #[serde(default)]
    sleep: bool,
    #[serde(default)]
    activation: ActivationRule,
    gap_tolerance: Option<f64>,
    velocity_tolerance: Option<f64>,
    joint_tolerance: Option<f64>,
}

fn one() -> f64 {
    1.0
}

fn yes() -> bool {
    true
}

/// A number, or `"adaptive"`.
enum StepField {
    Fixed(f64),
    Adaptive,
}

impl<'de> Deserialize<'de> for StepField {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Field;
        impl Visitor<'_> for Field {
            type Value = StepField;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a time step in seconds, or \"adaptive\"")
            }
            fn visit_f64<E: de::Error>(self, step: f64) -> Result<StepField, E> {
                Ok(StepField::Fixed(step))
            }
            fn visit_i64<E: de::Error>(self, step: i64) -> Result<StepField, E> {
                Ok(StepField::Fixed(step as f64))
            }
            fn visit_str<E: de::Error>(self, name: &str) -> Result<StepField, E> {
                match name {
                    "adaptive" => Ok(StepField::Adaptive),
                    other => Err(E::invalid_value(de::Unexpected::Str(other), &self)),
                }
            }
        }
        deserializer.deserialize_any(Field)
    }
}

impl TryFrom<TimeFields> for TimeSpec {
    type Error = String;

    fn try_from(fields: TimeFields) -> Result<Self, String> {
        let TimeFields { tolerance, first_step, min_step, max_step, max_steps, end, .. } = fields;
        let given = [
            ("tolerance", tolerance),
            ("first_step", first_step),
            ("min_step", min_step),
            ("max_step", max_step),
            ("max_steps", max_steps.map(|steps| steps as f64)),
        ];
        let (step, adaptive) = match fields.step {
            StepField::Fixed(step) => match given.iter().find(|(_, given)| given.is_some()) {
                Some((key, _)) => return Err(format!("`{key}` goes with step = \"adaptive\" alone")),
                None => (step, None),
            },
            StepField::Adaptive if fields.sleep => {
                return Err("`sleep` goes with fixed steps alone".into());
            }
            StepField::Adaptive => {
                let tolerance = tolerance.ok_or("step = \"adaptive\" needs a `tolerance`")?;
                let adaptive = AdaptiveSpec { tolerance, first_step, min_step, max_step, max_steps };
                (first_step.unwrap_or(FIRST * end), Some(adaptive))
            }
        };
        Ok(Self {
            step,
            adaptive,
            end,
            whole_steps: fields.whole_steps,
            theta: fields.theta,
            allow_unproved_theta: fields.allow_unproved_theta,
            lasting: fields.lasting,
            theta_rest: fields.theta_rest,
            sleep: fields.sleep,
            activation: fields.activation,
            gap_tolerance: fields.gap_tolerance,
            velocity_tolerance: fields.velocity_tolerance,
            joint_tolerance: fields.joint_tolerance,
        })
    }
}
