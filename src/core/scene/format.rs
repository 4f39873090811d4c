//! The scene file as it is written; unknown keys are refused with their line and column.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;

use super::include::Document;
use super::space::{self, SpaceSpec};
use super::{JointSpec, LagrangianSpec, ObstacleSpec, SceneError, SolidSpec, SpringSpec, TimeSpec};
use crate::observe::Units;
use crate::system::Signal;

/// A scene of planar rigid bodies, of one elastic body, or of a linear system of a few coordinates. Units are SI (m, kg, s, N, rad), or any other consistent
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
    /// Files taken in, relative to the folder of this one; a single one may stand without brackets. What this file says wins,
    /// lists of tables go on with theirs.
    #[serde(default)]
    pub include: Vec<String>,
    /// Number of dimensions (dimensionless), 2; with 3 the file is a scene in space.
    pub dimension: Option<u8>,
    /// Arithmetic of the run.
    #[serde(default)]
    pub scalar: ScalarName,
    /// Units the numbers of the scene are in, for the labels of outputs; nothing is converted.
    #[serde(default)]
    pub units: UnitsName,
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
    /// A linear system of a few coordinates, in place of bodies.
    pub lagrangian: Option<LagrangianSpec>,
    /// Fixed half-planes.
    #[serde(default)]
    pub half_planes: Vec<HalfPlaneSpec>,
    /// Fixed shapes of any kind.
    #[serde(default)]
    pub obstacles: Vec<ObstacleSpec>,
    /// Joints between bodies, or to the ground.
    #[serde(default)]
    pub joints: Vec<JointSpec>,
    /// Springs and dampers between bodies, or to the ground.
    #[serde(default)]
    pub springs: Vec<SpringSpec>,
    /// Which pairs touch, and the parameters of their law.
    #[serde(default)]
    pub interfaces: Vec<InterfaceSpec>,
    /// What a scene in space has, in place of all that is planar.
    #[serde(skip)]
    pub space: Option<SpaceSpec>,
    /// Folder of the scene file, which the names of mesh files start from.
    #[serde(skip)]
    pub folder: PathBuf,
}

pub(super) fn default_solvers() -> Vec<String> {
    vec![crate::solver::DEFAULT.into()]
}

/// A consistent set of units.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[non_exhaustive]
pub enum UnitsName {
    /// m, s, kg, and so N, J (default).
    #[default]
    #[serde(rename = "SI")]
    Si,
    /// mm, ms, g, and so N, MPa, mJ.
    #[serde(rename = "mm-ms-g")]
    MmMsG,
}

impl UnitsName {
    /// The words for them.
    pub fn units(self) -> &'static Units {
        match self {
            Self::Si => &Units::SI,
            Self::MmMsG => &Units::MM_MS_G,
        }
    }
}

/// Arithmetic of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum ScalarName {
    /// Double precision (default).
    #[default]
    F64,
    /// Single precision.
    F32,
}

/// Settings of the solvers.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolverSpec {
    /// Tolerance on the scaled residual (dimensionless); 1e-10, or 64 ε of the arithmetic if that is more, where absent.
    pub tolerance: Option<f64>,
    /// Budget of one solve, in the iterations of the solver; each has its own where absent.
    pub max_iterations: Option<usize>,
    /// Budget of one solve (s); unlimited where absent.
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
    /// A VTK file of the bodies every so many steps, and one of their contacts; none where absent.
    pub vtk_every: Option<usize>,
    /// Write `tables.h5` beside the CSV tables: the same rows in binary (HDF5), for long runs.
    #[serde(default)]
    pub hdf5: bool,
    /// Write a page that shows the motion of the bodies, an HTML file for each run; `true` where absent.
    pub html: Option<bool>,
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
    /// Name, unique among bodies, obstacles and half-planes.
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
    /// Forces that vary in time, added to the constant one.
    #[serde(default)]
    pub loads: Vec<LoadSpec>,
    /// Springs to the ground, along x, along y and in rotation (N/m, N/m, N m/rad); without force at the origin and at
    /// angle 0.
    #[serde(default)]
    pub stiffness: [f64; 3],
    /// Dampers to the ground, likewise (N s/m, N s/m, N m s).
    #[serde(default)]
    pub damping: [f64; 3],
    /// Contact discs and points of the body.
    #[serde(default)]
    pub discs: Vec<DiscSpec>,
    /// Polygons of the body.
    #[serde(default)]
    pub polygons: Vec<PolygonSpec>,
}

/// A force and a torque on a body, times a signal.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadSpec {
    /// Force (N).
    #[serde(default)]
    pub force: [f64; 2],
    /// Torque (N m).
    #[serde(default)]
    pub torque: f64,
    /// Signal; constant where absent.
    #[serde(default)]
    pub signal: Signal<f64>,
}

/// A polygon of a body: convex, or a simple one that is decomposed.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolygonSpec {
    /// Name, unique in the body or obstacle; interfaces call it `body.polygon`.
    pub name: String,
    /// Vertices in its frame (m), counterclockwise, strictly convex unless it is decomposed.
    pub vertices: Vec<[f64; 2]>,
    /// Split the outline, any one that does not cross itself, into convex parts, which are called `body.polygon.1` and so on
    /// in outputs.
    #[serde(default)]
    pub decompose: bool,
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
    /// Name, unique among bodies, obstacles and half-planes.
    pub name: String,
    /// A point of its boundary (m).
    #[serde(default)]
    pub point: [f64; 2],
    /// Outward normal (dimensionless), of any length: bodies stay on the side it points to.
    pub normal: [f64; 2],
}

/// Two sides that touch, and the parameters of the law between them.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InterfaceSpec {
    /// Each side is a body or an obstacle, one of its shapes `body.name`, a half-plane or a group. The first interface that fits a pair
    /// governs it; pairs that fit none pass through each other.
    pub between: [String; 2],
    /// A law this interface keeps in every run, in place of the law of the run.
    pub law: Option<String>,
    /// Parameters of the law by name (of each parameter its own); a law takes those it has.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
}

impl OutputSpec {
    /// Steps between rows of `trajectory.csv`.
    pub fn trajectory_every(&self) -> usize {
        self.trajectory_every.or(self.every).unwrap_or(1)
    }
}

impl Scene {
    /// Reads a scene file.
    ///
    /// # Errors
    /// [`SceneError::Read`], [`SceneError::Parse`] with line and column, [`SceneError::Include`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path)
            .map_err(|source| SceneError::Read { path: path.into(), source: Arc::new(source) })?;
        Self::parse(&text, path)
    }

    /// Parses the text of a scene file; `path` is for errors, and where files it includes are sought.
    ///
    /// # Errors
    /// [`SceneError::Parse`] with line and column, [`SceneError::Include`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, SceneError> {
        let document = Document::new(text, path)?;
        let scene = match space::is_spatial(&document.read()?) {
            true => document.read().map(space::SpaceScene::into_scene),
            false => document.read::<Self>(),
        };
        Ok(scene?.in_folder_of(path))
    }

    /// The table of the text of a scene file, with what the files it includes add to it.
    ///
    /// # Errors
    /// [`SceneError::Parse`] with line and column, [`SceneError::Include`].
    pub fn table(text: &str, path: &Path) -> Result<toml::Table, SceneError> {
        Document::new(text, path)?.read()
    }

    fn in_folder_of(mut self, path: &Path) -> Self {
        self.folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        self
    }

    /// The scene of a table (that of the text of the scene file at `path`) with some of its keys set to other values.
    /// A key is a dotted path, an entry of a list its number from 0: `interfaces.0.parameters.friction`.
    ///
    /// # Errors
    /// [`SceneError::Key`] for a path that leads nowhere, or a scene that is then none.
    pub fn with_keys(
        table: &toml::Table,
        path: &Path,
        changes: &[(String, toml::Value)],
    ) -> Result<Self, SceneError> {
        let mut table = table.clone();
        let all = || changes.iter().map(|(key, _)| key.as_str()).collect::<Vec<_>>().join(", ");
        for (key, value) in changes {
            set_key(&mut table, key, value.clone())
                .map_err(|message| SceneError::Key { key: key.clone(), message })?;
        }
        let scene = match space::is_spatial(&table) {
            true => space::from_table(table),
            false => Self::deserialize(toml::Value::Table(table)),
        };
        let scene = scene.map_err(|error| SceneError::Key {
            key: all(),
            message: error.to_string().split_whitespace().collect::<Vec<_>>().join(" "),
        })?;
        Ok(scene.in_folder_of(path))
    }
}

/// Sets what a dotted path leads to; tables on the way are made where they are absent, entries of lists are not.
fn set_key(table: &mut toml::Table, key: &str, value: toml::Value) -> Result<(), String> {
    let mut parts = key.split('.');
    let mut name = parts.next().unwrap_or_default();
    let mut place: &mut toml::Value = table.entry(name).or_insert_with(|| toml::Table::new().into());
    for part in parts {
        place = match place {
            toml::Value::Table(table) => table.entry(part).or_insert_with(|| toml::Table::new().into()),
            toml::Value::Array(list) => {
                let count = list.len();
                let entry = part.parse::<usize>().ok().and_then(|index| list.get_mut(index));
                entry.ok_or_else(|| format!("`{name}` has {count} entries, numbered from 0: no `{part}`"))?
            }
            other => return Err(format!("`{name}` is a {}, it has no `{part}`", other.type_str())),
        };
        name = part;
    }
    *place = value;
    Ok(())
}
