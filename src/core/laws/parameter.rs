//! What the registry knows of a law: its name, equation, source and parameters, and how they are checked.

use super::Scalar;

/// A parameter of a law: its admissible range is enforced at construction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Name in scene files and in errors.
    pub name: &'static str,
    /// Mathematical symbol.
    pub symbol: &'static str,
    /// What it is, with its unit.
    pub meaning: &'static str,
    /// Smallest admissible value.
    pub min: f64,
    /// Largest admissible value; infinity where only finiteness is asked.
    pub max: f64,
    /// Value taken where none is given; `None` makes the parameter mandatory.
    pub default: Option<f64>,
    /// Range from which random instances are drawn, within `min..=max`.
    pub draw: (f64, f64),
}

/// Coefficient of restitution e ∈ [0, 1].
pub const RESTITUTION: Parameter = Parameter {
    name: "restitution",
    symbol: "e",
    meaning: "coefficient of restitution (dimensionless)",
    min: 0.0,
    max: 1.0,
    default: None,
    draw: (0.0, 1.0),
};

/// Coefficient of friction μ ≥ 0.
pub const FRICTION: Parameter = Parameter {
    name: "friction",
    symbol: "μ",
    meaning: "Coulomb coefficient of friction (dimensionless)",
    min: 0.0,
    max: f64::INFINITY,
    default: Some(0.0),
    draw: (0.0, 2.0),
};

/// A law as the registry lists it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Description {
    /// Name in scene files, on the command line and in errors.
    pub name: &'static str,
    /// One line saying what the law is.
    pub title: &'static str,
    /// The evaluation point û in the paper's notation.
    pub equation: &'static str,
    /// The θ-interval in which dissipation is proved, in words and symbols.
    pub claim: &'static str,
    /// Publication the law comes from.
    pub reference: &'static str,
    /// Parameters, in the order of the values of [`LawFamily::try_new`].
    pub parameters: &'static [Parameter],
}

impl Description {
    /// Parameter values of a random instance from one number in [0, 1] per parameter; missing numbers count
    /// as 0.
    pub fn draw(&self, unit: &[f64]) -> Vec<f64> {
        let at = |i: usize| unit.get(i).copied().unwrap_or(0.0).clamp(0.0, 1.0);
        let range = |p: &Parameter, x: f64| p.draw.0 + x * (p.draw.1 - p.draw.0);
        self.parameters.iter().enumerate().map(|(i, p)| range(p, at(i))).collect()
    }

    /// Values in declaration order from (name, value) pairs; defaults fill what is not given.
    ///
    /// # Errors
    /// [`LawError::UnknownParameter`] and [`LawError::MissingParameter`].
    pub fn arrange<'a>(&self, given: impl IntoIterator<Item = (&'a str, f64)>) -> Result<Vec<f64>, LawError> {
        let mut values: Vec<Option<f64>> = self.parameters.iter().map(|p| p.default).collect();
        for (name, value) in given {
            let Some(i) = self.parameters.iter().position(|p| p.name == name) else {
                let known = self.parameters.iter().map(|p| p.name).collect::<Vec<_>>().join(", ");
                return Err(LawError::UnknownParameter { law: self.name, parameter: name.into(), known });
            };
            values[i] = Some(value);
        }
        let missing = |p: &Parameter| LawError::MissingParameter { law: self.name, parameter: p.name };
        self.parameters.iter().zip(values).map(|(p, v)| v.ok_or_else(|| missing(p))).collect()
    }
}

/// Why a law could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LawError {
    /// A parameter is NaN, infinite or outside its range.
    #[error("law `{law}`: {parameter} = {value} is not a finite number in [{min}, {max}]")]
    OutOfRange {
        /// Name of the law.
        law: &'static str,
        /// Name of the parameter.
        parameter: &'static str,
        /// The value refused.
        value: f64,
        /// Smallest admissible value.
        min: f64,
        /// Largest admissible value.
        max: f64,
    },
    /// The number of values is not the number of parameters.
    #[error("law `{law}` takes {expected} parameters, {given} were given")]
    ParameterCount {
        /// Name of the law.
        law: &'static str,
        /// Number of parameters of the law.
        expected: usize,
        /// Number of values given.
        given: usize,
    },
    /// The law has no parameter of this name.
    #[error("law `{law}` has no parameter `{parameter}` (it has: {known})")]
    UnknownParameter {
        /// Name of the law.
        law: &'static str,
        /// The name given.
        parameter: String,
        /// The names it has.
        known: String,
    },
    /// A mandatory parameter was not given.
    #[error("law `{law}` needs the parameter `{parameter}`")]
    MissingParameter {
        /// Name of the law.
        law: &'static str,
        /// Name of the parameter.
        parameter: &'static str,
    },
    /// The law is not there in this arithmetic and contact dimension.
    #[error("law `{law}` cannot be had in {scalar} with contacts of dimension {dimension}")]
    Unsupported {
        /// Name of the law.
        law: &'static str,
        /// The arithmetic.
        scalar: &'static str,
        /// Contact dimension.
        dimension: usize,
    },
    /// No law of this name is registered.
    #[error("no law is called `{name}` (known: {known})")]
    UnknownLaw {
        /// The name given.
        name: String,
        /// The registered names.
        known: String,
    },
}

/// A law the registry can describe and build from numbers.
pub trait LawFamily<T: Scalar>: Sized {
    /// The registry's entry.
    const DESCRIPTION: Description;

    /// The law from parameter values that have been checked against [`Self::DESCRIPTION`].
    fn from_values(values: &[T]) -> Self;

    /// The law from parameter values in the order of the description.
    ///
    /// # Errors
    /// [`LawError::OutOfRange`] with the value, [`LawError::ParameterCount`].
    fn try_new(values: &[T]) -> Result<Self, LawError> {
        let Description { name: law, parameters, .. } = Self::DESCRIPTION;
        if values.len() != parameters.len() {
            let (expected, given) = (parameters.len(), values.len());
            return Err(LawError::ParameterCount { law, expected, given });
        }
        for (p, value) in parameters.iter().zip(values) {
            let value = value.to_f64().unwrap_or(f64::NAN);
            if !(value.is_finite() && p.min <= value && value <= p.max) {
                return Err(LawError::OutOfRange { law, parameter: p.name, value, min: p.min, max: p.max });
            }
        }
        Ok(Self::from_values(values))
    }
}
