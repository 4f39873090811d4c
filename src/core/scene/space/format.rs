//! The scene file in space, as it is written.

use serde::Deserialize;

use super::{RepeatSpec, ShapeSpec, SpaceJointSpec, SpaceMotionSpec, SpaceSpringSpec};
use crate::scene::format::default_solvers;
use crate::scene::{InterfaceSpec, OutputSpec, ScalarName, Scene, SolverSpec, TimeSpec, UnitsName};
use crate::system::Signal;

/// A scene of rigid bodies in space: a file with `dimension = 3`, or with three numbers for gravity or for the position of a
/// body.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpaceScene {
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
    /// Number of dimensions (dimensionless), 3.
    pub dimension: Option<u8>,
    /// Arithmetic of the run.
    #[serde(default)]
    pub scalar: ScalarName,
    /// Units the numbers of the scene are in, for the labels of outputs; nothing is converted.
    #[serde(default)]
    pub units: UnitsName,
    /// Acceleration of gravity (m/s²).
    #[serde(default)]
    pub gravity: [f64; 3],
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
    pub bodies: Vec<SpaceBodySpec>,
    /// Fixed half-spaces.
    #[serde(default)]
    pub half_spaces: Vec<SpaceHalfSpec>,
    /// Shapes that are fixed, or move as told.
    #[serde(default)]
    pub obstacles: Vec<SpaceObstacleSpec>,
    /// Joints between bodies, or of bodies with obstacles and the ground.
    #[serde(default)]
    pub joints: Vec<SpaceJointSpec>,
    /// Springs and dampers.
    #[serde(default)]
    pub springs: Vec<SpaceSpringSpec>,
    /// Which pairs touch, and the parameters of their law.
    #[serde(default)]
    pub interfaces: Vec<InterfaceSpec>,
}

/// What a scene in space has beside what all scenes have.
#[derive(Debug, Clone, PartialEq)]
pub struct SpaceSpec {
    /// Acceleration of gravity (m/s²).
    pub gravity: [f64; 3],
    /// Moving rigid bodies, repeated ones one by one.
    pub bodies: Vec<SpaceBodySpec>,
    /// Fixed half-spaces.
    pub half_spaces: Vec<SpaceHalfSpec>,
    /// Shapes that are fixed, or move as told.
    pub obstacles: Vec<SpaceObstacleSpec>,
    /// Joints.
    pub joints: Vec<SpaceJointSpec>,
    /// Springs and dampers.
    pub springs: Vec<SpaceSpringSpec>,
}

/// A rigid body in space. Its mass and inertia are those of its shapes and a density, or given.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpaceBodySpec {
    /// Name, unique among bodies, obstacles and half-spaces.
    pub name: String,
    /// Groups the body belongs to, for interfaces.
    #[serde(default)]
    pub groups: Vec<String>,
    /// Density of its shapes (kg/m³), where no mass is given.
    pub density: Option<f64>,
    /// Mass (kg); without `inertia` that of a homogeneous body of these shapes.
    pub mass: Option<f64>,
    /// Moments of inertia about the axes of the body's frame, at its origin (kg m²): these are then principal axes, and the
    /// origin is the centre of mass.
    pub inertia: Option<[f64; 3]>,
    /// Initial position of the origin of the body's frame (m).
    pub position: [f64; 3],
    /// Initial orientation, a quaternion (w, x, y, z) of any length from the body's frame to the fixed one (dimensionless).
    #[serde(default = "upright")]
    pub orientation: [f64; 4],
    /// Initial velocity of the centre of mass (m/s).
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Initial angular velocity about the fixed axes (rad/s).
    #[serde(default)]
    pub spin: [f64; 3],
    /// Constant force at the centre of mass, along the fixed axes (N).
    #[serde(default)]
    pub force: [f64; 3],
    /// Constant torque about the axes of the body (N m).
    #[serde(default)]
    pub torque: [f64; 3],
    /// Constant torque about the fixed axes (N m).
    #[serde(default)]
    pub fixed_torque: [f64; 3],
    /// Forces that vary in time, added to the constant one.
    #[serde(default)]
    pub loads: Vec<SpaceLoadSpec>,
    /// Shapes of the body.
    #[serde(default)]
    pub shapes: Vec<ShapeSpec>,
    /// Copies of the body on a grid.
    pub repeat: Option<RepeatSpec>,
}

/// No turn.
pub(super) fn upright() -> [f64; 4] {
    [1.0, 0.0, 0.0, 0.0]
}

/// A force and a torque on a body in space, times a signal.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpaceLoadSpec {
    /// Force along the fixed axes (N).
    #[serde(default)]
    pub force: [f64; 3],
    /// Torque about the axes of the body (N m).
    #[serde(default)]
    pub torque: [f64; 3],
    /// Torque about the fixed axes (N m).
    #[serde(default)]
    pub fixed_torque: [f64; 3],
    /// Signal; constant where absent.
    #[serde(default)]
    pub signal: Signal<f64>,
}

/// A fixed half-space.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpaceHalfSpec {
    /// Name, unique among bodies, obstacles and half-spaces.
    pub name: String,
    /// A point of its boundary (m).
    #[serde(default)]
    pub point: [f64; 3],
    /// Outward normal (dimensionless), of any length: bodies stay on the side it points to.
    pub normal: [f64; 3],
}

/// Fixed shapes in space, under one name; or, with a `motion`, shapes that move as told: a belt, a shaker, a drum.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpaceObstacleSpec {
    /// Name, unique among bodies, obstacles and half-spaces.
    pub name: String,
    /// Groups the obstacle belongs to, for interfaces.
    #[serde(default)]
    pub groups: Vec<String>,
    /// Position of the origin of its frame (m).
    #[serde(default)]
    pub position: [f64; 3],
    /// Orientation, a quaternion (w, x, y, z) of any length (dimensionless).
    #[serde(default = "upright")]
    pub orientation: [f64; 4],
    /// Displacements of the frame, each times a signal; fixed where there are none.
    #[serde(default)]
    pub motion: Vec<SpaceMotionSpec>,
    /// Axis through the origin of the frame (dimensionless), along the fixed axes and of any length, about which the `motion` turns.
    pub motion_axis: Option<[f64; 3]>,
    /// Its shapes.
    pub shapes: Vec<ShapeSpec>,
}

impl SpaceScene {
    /// The scene; what only scenes in the plane have is absent.
    pub(in crate::scene) fn into_scene(self) -> Scene {
        let Self { title, laws, solvers, include, scalar, units, time, solver, output, interfaces, .. } =
            self;
        let Self { gravity, bodies, half_spaces, obstacles, joints, springs, .. } = self;
        let bodies = bodies.into_iter().flat_map(SpaceBodySpec::copies).collect();
        Scene {
            title,
            laws,
            solvers,
            include,
            scalar,
            units,
            dimension: Some(3),
            gravity: [0.0; 2],
            time,
            solver,
            output,
            bodies: Vec::new(),
            solid: None,
            lagrangian: None,
            half_planes: Vec::new(),
            obstacles: Vec::new(),
            joints: Vec::new(),
            springs: Vec::new(),
            interfaces,
            space: Some(SpaceSpec { gravity, bodies, half_spaces, obstacles, joints, springs }),
            folder: std::path::PathBuf::new(),
        }
    }
}
