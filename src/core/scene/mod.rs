//! Scene files: bodies, shapes, laws and solvers by registered name, in TOML.
//!
//! A scene is read ([`Scene::read`]), turned into the runs it asks for ([`Scene::runs`]: every law with every
//! solver), and each run is built into a scheme over planar rigid bodies, an elastic body
//! or a linear system of a few coordinates ([`build`]). Frictionless runs are built
//! with contacts of dimension 1, the others with dimension 2. [`event_driven()`] builds the event-driven integration of the
//! same run.

mod behind;
mod build;
mod decompose;
mod error;
mod event_driven;
mod fingerprint;
mod format;
mod include;
mod instance;
mod joints;
mod lagrangian;
mod names;
mod obstacles;
mod plan;
mod solid;
mod space;
mod theta;
mod time;
mod warnings;

pub use build::{build, contact_dimension};
pub use error::{SceneError, line_and_column};
pub use event_driven::{EventDriven, event_driven};
pub use fingerprint::Fingerprint;
pub use format::{
    BodySpec, DiscSpec, HalfPlaneSpec, InterfaceSpec, LoadSpec, OutputSpec, PolygonSpec, ScalarName, Scene,
    SolverSpec, UnitsName,
};
pub use include::IncludeError;
pub use instance::{InKind, in_kind};
pub use joints::{JointSpec, MotorSpec, SpringSpec};
pub use lagrangian::{GapSpec, GeneralLoadSpec, LagrangianSpec};
pub use obstacles::{ArcSpec, ChainSpec, MotionSpec, ObstacleSpec};
pub use plan::{Overrides, PlannedRun};
pub use solid::{MeshSpec, PreloadSpec, PrescribedSpec, SolidSpec, SupportName, TractionSpec};
pub use space::{
    HeightsSpec, RepeatSpec, ShapeSpec, SpaceBodySpec, SpaceHalfSpec, SpaceJointKind, SpaceJointSpec,
    SpaceLoadSpec, SpaceMotionSpec, SpaceObstacleSpec, SpaceScene, SpaceSpec, SpaceSpringSpec,
};
pub use time::{AdaptiveSpec, TimeSpec};
pub use warnings::SceneWarning;
