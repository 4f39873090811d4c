//! The scene file as it is written; unknown keys are refused with their line and column.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{SceneError, SolidSpec};

/// A scene of planar rigid bodies, or of one elastic body. Units are SI (m, kg, s, N, rad), or any other consistent
/// set: mm, ms, g makes MPa, N, mJ.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Title of the outputs.
    pub title: String,
    /// Names of the laws to run, each over the whole scene.
    pub laws: Vec<String>,
    /// Names of the solvers to run with each law.
    #[serde(default = "default_solvers")]
    pub solvers: Vec<String>,
    /// Arithmetic of the run.
    #[serde(default)]
    pub scalar: ScalarName,
    /// Acceleration of gravity (m/s²).
    #[serde(default)]
    pub gravity: [f64; 2],
    /// Time stepping.
    pub time: TimeSpec,
    /// Settings of the solvers.
    #[serde(default)]
    pub solver: SolverSpec,
    /// What is written, and how often.
    #[serde(default)]
    pub output: OutputSpec,
    /// Moving rigid bodies.
    #[serde(default)]
    pub bodies: Vec<BodySpec>,
    /// An elastic body, in place of the rigid ones.
    pub solid: Option<SolidSpec>,
    /// Fixed half-planes.
    #[serde(default)]
    pub half_planes: Vec<HalfPlaneSpec>,
    /// Joints between bodies, or to the ground.
    #[serde(default)]
    pub joints: Vec<JointSpec>,
    /// Which pairs touch, and the parameters of their law.
    #[serde(default)]
    pub interfaces: Vec<InterfaceSpec>,
    /// Folder of the scene file, which the names of mesh files start from.
    #[serde(skip)]
    pub folder: PathBuf,
}

fn default_solvers() -> Vec<String> {
    vec![crate::solver::DEFAULT.into()]
}

/// Arithmetic of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ScalarName {
    /// Double precision (default).
    #[default]
    F64,
    /// Single precision.
    F32,
}

/// Name of an active-set rule, see [`crate::scheme::ActivationRule`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ActivationRuleName {
    /// Rule (55) of the paper (default).
    #[default]
    MoreauJean,
    /// Predicted gap alone.
    PredictedGap,
    /// Gap at the start of the step alone.
    CurrentGap,
}

/// Time stepping.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeSpec {
    /// Time step h > 0 (s).
    pub step: f64,
    /// End of the run (s); it starts at 0.
    pub end: f64,
    /// Scheme parameter θ ∈ [0, 1].
    #[serde(default = "half")]
    pub theta: f64,
    /// Accept a θ outside the interval in which a law is proved dissipative.
    #[serde(default)]
    pub allow_unproved_theta: bool,
    /// Leave bodies at rest out of the steps until something touches them.
    #[serde(default)]
    pub sleep: bool,
    /// Rule of the active set.
    #[serde(default)]
    pub activation: ActivationRuleName,
    /// Tolerance of the rule on the gap (m); scales with the scene where absent.
    pub gap_tolerance: Option<f64>,
    /// Tolerance of the rule on the normal velocity (m/s); scales with the scene where absent.
    pub velocity_tolerance: Option<f64>,
}

fn half() -> f64 {
    0.5
}

/// Settings of the solvers.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolverSpec {
    /// Tolerance on the scaled residual (dimensionless).
    pub tolerance: Option<f64>,
    /// Budget of one solve, in the iterations of the solver.
    pub max_iterations: Option<usize>,
    /// Budget of one solve in seconds.
    pub max_seconds: Option<f64>,
}

/// What is written, and how often.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutputSpec {
    /// A row of `trajectory.csv` and `energy.csv` every so many steps (default 1); the last step is always
    /// written.
    pub every: Option<usize>,
    /// A row of `trajectory.csv` every so many steps, in place of `every`.
    pub trajectory_every: Option<usize>,
    /// `contacts.csv` has the active contacts of every so many steps (default 1: of all).
    pub contacts_every: Option<usize>,
    /// A VTK file of the elastic body every so many steps; none where absent.
    pub vtk_every: Option<usize>,
    /// The body whose motion the figures show; the first where absent.
    pub figure_body: Option<String>,
    /// The contact whose velocities and percussions the figures show, as `disc|half-plane` or `disc|disc`; the
    /// first where absent.
    pub figure_contact: Option<String>,
}

/// A rigid body.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodySpec {
    /// Name, unique among bodies and half-planes.
    pub name: String,
    /// Groups the body belongs to, for interfaces.
    #[serde(default)]
    pub groups: Vec<String>,
    /// Mass (kg).
    pub mass: f64,
    /// Moment of inertia about the centre of mass (kg m²).
    pub inertia: f64,
    /// Initial position of the centre of mass (m).
    pub position: [f64; 2],
    /// Initial angle (rad).
    #[serde(default)]
    pub angle: f64,
    /// Initial velocity of the centre of mass (m/s).
    #[serde(default)]
    pub velocity: [f64; 2],
    /// Initial angular velocity (rad/s).
    #[serde(default)]
    pub spin: f64,
    /// Constant force (N).
    #[serde(default)]
    pub force: [f64; 2],
    /// Constant torque (N m).
    #[serde(default)]
    pub torque: f64,
    /// Contact discs and points of the body.
    #[serde(default)]
    pub discs: Vec<DiscSpec>,
    /// Convex polygons of the body.
    #[serde(default)]
    pub polygons: Vec<PolygonSpec>,
}

/// A convex polygon of a body.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolygonSpec {
    /// Name, unique in the body; interfaces call it `body.polygon`.
    pub name: String,
    /// Vertices in the frame of the body (m), counterclockwise, strictly convex.
    pub vertices: Vec<[f64; 2]>,
}

/// A joint: a point of a body held on a point of another, or of the ground.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointSpec {
    /// Name, for errors.
    pub name: String,
    /// The body.
    pub body: String,
    /// Its point, in its frame (m).
    #[serde(default)]
    pub at: [f64; 2],
    /// The other body; the ground where absent.
    pub to: Option<String>,
    /// The other body's point in its frame, or the point of the ground (m).
    #[serde(default)]
    pub on: [f64; 2],
    /// Angle of the body less that of the other (rad), held as well where it is given: a weld, not a pin.
    pub angle: Option<f64>,
}

/// A contact disc, or point, of a body.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DiscSpec {
    /// Name, unique in the body; interfaces call it `body.disc`.
    pub name: String,
    /// Centre in the frame of the body (m).
    #[serde(default)]
    pub centre: [f64; 2],
    /// Radius (m); 0 is a point.
    #[serde(default)]
    pub radius: f64,
}

/// A fixed half-plane.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HalfPlaneSpec {
    /// Name, unique among bodies and half-planes.
    pub name: String,
    /// A point of its boundary (m).
    #[serde(default)]
    pub point: [f64; 2],
    /// Outward normal, of any length: bodies stay on the side it points to.
    pub normal: [f64; 2],
}

/// Two sides that touch, and the parameters of the law between them.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InterfaceSpec {
    /// Each side is a body, a disc or polygon `body.name`, a half-plane or a group. The first interface that fits a pair
    /// governs it; pairs that fit none pass through each other.
    pub between: [String; 2],
    /// A law this interface keeps in every run, in place of the law of the run.
    pub law: Option<String>,
    /// Parameters of the law by name; a law takes those it has.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
}

impl Scene {
    /// Reads a scene file.
    ///
    /// # Errors
    /// [`SceneError::Read`], [`SceneError::Parse`] with line and column.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| SceneError::Read { path: path.into(), message: source.to_string() })?;
        Self::parse(&text, path)
    }

    /// Parses the text of a scene file; `path` is for the error only.
    ///
    /// # Errors
    /// [`SceneError::Parse`] with line and column.
    pub fn parse(text: &str, path: &Path) -> Result<Self, SceneError> {
        let mut scene: Self = toml::from_str(text).map_err(|error| SceneError::parse(path, text, &error))?;
        scene.folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        Ok(scene)
    }
}
