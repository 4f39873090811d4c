//! Why a scene could not be read or built.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::include::IncludeError;
use crate::adaptive::AdaptiveError;
use crate::geometry::{CompoundError, PoseError, ShapeError, SurfaceError};
use crate::laws::LawError;
use crate::mesh::MeshError;
use crate::scheme::{EquilibriumError, SetupError};
use crate::solver::UnknownSolver;
use crate::system::{ElasticError, PreloadError, SystemError};

/// Why a scene could not be read or built.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A law with rolling resistance on an elastic body, whose nodes do not turn.
    #[error("the nodes of an elastic body do not turn: a law with rolling resistance has nothing to act on")]
    RollingSolid,
    /// A law with rolling resistance in space.
    #[error("laws with rolling resistance act on planar bodies: `{law}` in space wants one without")]
    RollingSpace {
        /// The law.
        law: String,
    },
    /// A shape that is none.
    #[error("shape `{shape}`: {source}")]
    Shape {
        /// Its name.
        shape: String,
        /// What is wrong.
        source: ShapeError,
    },
    /// A shape that is given in no way, or in several.
    #[error(
        "shape `{shape}` has {}: give one of ball, box, capsule, cylinder, cone, hull, file, terrain and heights",
        if given.is_empty() { "no geometry" } else { given }
    )]
    OneShape {
        /// Its name.
        shape: String,
        /// The ways it is given in.
        given: String,
    },
    /// A scale of what no file has.
    #[error("shape `{shape}` has a scale, which is for shapes of a file")]
    NoFile {
        /// Its name.
        shape: String,
    },
    /// A file of a shape that cannot be read.
    #[error("shape `{shape}`: cannot read {}: {source}", file.display())]
    ShapeFile {
        /// Its name.
        shape: String,
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: Arc<std::io::Error>,
    },
    /// A file that is no convex solid.
    #[error("shape `{shape}`, {}: {source}", file.display())]
    Surface {
        /// Its name.
        shape: String,
        /// The file.
        file: PathBuf,
        /// What is wrong.
        source: SurfaceError,
    },
    /// A place that is none.
    #[error("place of `{of}`: {source}")]
    Pose {
        /// What stands there.
        of: String,
        /// What is wrong.
        source: PoseError,
    },
    /// A body whose shapes give no mass or inertia.
    #[error("mass of `{body}`: {source}")]
    BodyMass {
        /// Its name.
        body: String,
        /// What is wrong.
        source: CompoundError,
    },
    /// A body without mass, or with two.
    #[error("body `{body}` wants a density, or a mass, or a mass and an inertia")]
    MassOrDensity {
        /// Its name.
        body: String,
    },
    /// The file cannot be read.
    #[error("cannot read the scene {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: Arc<std::io::Error>,
    },
    /// The file is not a scene.
    #[error("{}:{line}:{column}: {message}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong there.
        message: String,
    },
    /// A file that the scene takes in.
    #[error("{}:{line}:{column}: {source}", path.display())]
    Include {
        /// The file that takes it in.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// Why it cannot.
        source: IncludeError,
    },
    /// A key of the scene cannot be set to a value.
    #[error("{key}: {message}")]
    Key {
        /// The key, as a dotted path.
        key: String,
        /// What is wrong.
        message: String,
    },
    /// A list that must not be empty is.
    #[error("the scene names no {what}")]
    Empty {
        /// Laws, solvers or bodies.
        what: &'static str,
    },
    /// An arc with one angle.
    #[error("arc `{arc}` has one of `from` and `to`: an arc needs both, a whole circle neither")]
    HalfArc {
        /// Name of the arc.
        arc: String,
    },
    /// Limits, friction or a motor of a joint that leaves nothing free.
    #[error(
        "joint `{joint}` holds everything: limits, friction and motors need a pin (no `angle`) or a slider (an `axis`)"
    )]
    NothingFree {
        /// Name of the joint.
        joint: String,
    },
    /// Limits, friction or a motor in a joint in space that leaves no coordinate for them.
    #[error("joint `{joint}`: limits, friction and motors need a hinge or a slider")]
    NothingFreeInSpace {
        /// Name of the joint.
        joint: String,
    },
    /// A joint in space without what its kind wants.
    #[error("joint `{joint}` is of a kind that wants `{what}`")]
    JointWants {
        /// Name of the joint.
        joint: String,
        /// The key.
        what: &'static str,
    },
    /// A key that the kind of a joint has no use for.
    #[error("joint `{joint}` is of a kind that takes no `{what}`")]
    JointTakes {
        /// Name of the joint.
        joint: String,
        /// The key.
        what: &'static str,
    },
    /// A spring in space without a place.
    #[error("spring `{spring}` wants `{what}`")]
    SpringWants {
        /// Name of the spring.
        spring: String,
        /// The key.
        what: &'static str,
    },
    /// An obstacle in space that turns about no axis.
    #[error("the motion of obstacle `{obstacle}` has an angle: it wants `motion_axis`")]
    MotionAxis {
        /// Name of the obstacle.
        obstacle: String,
    },
    /// Two displacements of one component.
    #[error("obstacle `{obstacle}` has two motions in {component}; every component may have one")]
    TwoMotions {
        /// Name of the obstacle.
        obstacle: String,
        /// x, y or angle.
        component: &'static str,
    },
    /// Something beside a Lagrangian system.
    #[error(
        "the scene has a `lagrangian` block and {what}: all of such a system stands in the block, its contacts as `gaps`"
    )]
    BesideLagrangian {
        /// What else there is.
        what: &'static str,
    },
    /// A motor that is not one of two kinds.
    #[error(
        "the motor of joint `{joint}` must have either `speed`, with `most` or without, or `force` alone"
    )]
    Motor {
        /// Name of the joint.
        joint: String,
    },
    /// A spring in rotation with a direction.
    #[error("spring `{spring}` is angular and has an axis; it may have one of them")]
    AngularAxis {
        /// Name of the spring.
        spring: String,
    },
    /// Two things have one name.
    #[error("the name `{name}` is taken twice")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// A name that names nothing.
    #[error("{place}: nothing is called `{name}` (known: {known})")]
    UnknownName {
        /// Where it stands.
        place: String,
        /// The name.
        name: String,
        /// What exists.
        known: String,
    },
    /// A parameter that no law has.
    #[error("interface {interface}: no law has a parameter `{parameter}` (known: {known})")]
    UnusedParameter {
        /// The interface, as its two sides.
        interface: String,
        /// The parameter.
        parameter: String,
        /// Those that laws have.
        known: String,
    },
    /// A number is outside its range.
    #[error("{what} is {value}, it must be {range}")]
    OutOfRange {
        /// What it is.
        what: String,
        /// The value refused.
        value: f64,
        /// The range in words.
        range: &'static str,
    },
    /// A law of an interface cannot be made.
    #[error("interface {interface}: {source}")]
    Law {
        /// The interface, as its two sides.
        interface: String,
        /// Why.
        source: LawError,
    },
    /// The scene's θ is not one for which a law is proved dissipative.
    #[error(
        "interface {interface}: θ = {theta} is outside [{min}, {max}], where the law `{law}` is proved dissipative: leave \
         time.theta out or choose it inside, or accept it without proof by time.allow_unproved_theta = true"
    )]
    UnprovedTheta {
        /// The interface, as its two sides.
        interface: String,
        /// Its law.
        law: String,
        /// The value refused.
        theta: f64,
        /// Lower end of the claimed interval.
        min: f64,
        /// Upper end of the claimed interval.
        max: f64,
    },
    /// No θ is one for which all laws of a run are proved dissipative.
    #[error(
        "interface {interface}: the law `{law}` is proved dissipative for θ in [{min}, {max}], and the interfaces before it \
         want one in [{low}, {high}]: give one of them another law or other parameters, or set time.theta and accept \
         it without proof by time.allow_unproved_theta = true"
    )]
    NoTheta {
        /// The interface, as its two sides.
        interface: String,
        /// Its law.
        law: String,
        /// Lower end of its interval.
        min: f64,
        /// Upper end of its interval.
        max: f64,
        /// Lower end of what the interfaces before it leave.
        low: f64,
        /// Upper end of what they leave.
        high: f64,
    },
    /// A law named for the runs does not exist.
    #[error(transparent)]
    UnknownLaw(LawError),
    /// A solver cannot be made.
    #[error(transparent)]
    Solver(#[from] UnknownSolver),
    /// The bodies or half-planes are not valid.
    #[error(transparent)]
    System(#[from] SystemError),
    /// The mesh of the elastic body cannot be used.
    #[error("mesh: {0}")]
    Mesh(#[from] MeshError),
    /// The elastic body is not valid.
    #[error(transparent)]
    Elastic(#[from] ElasticError),
    /// The elastic body has no static preload.
    #[error(transparent)]
    Preload(#[from] PreloadError),
    /// The preload with contacts was not found.
    #[error(transparent)]
    Equilibrium(#[from] EquilibriumError),
    /// Rigid bodies or obstacles and an elastic body in the same scene.
    #[error("the scene has bodies or obstacles and a solid; it must have one or the other")]
    Mixed,
    /// Error control cannot start.
    #[error(transparent)]
    Adaptive(#[from] AdaptiveError),
    /// The scheme cannot start.
    #[error(transparent)]
    Setup(#[from] SetupError),
}

impl SceneError {
    pub(super) fn parse(path: &Path, text: &str, error: &toml::de::Error) -> Self {
        Self::parse_at(path, text, error.span().map_or(0, |span| span.start), error.message().into())
    }

    pub(super) fn parse_at(path: &Path, text: &str, at: usize, message: String) -> Self {
        let (line, column) = line_and_column(text, at);
        Self::Parse { path: path.into(), line, column, message }
    }

    pub(super) fn include(path: &Path, text: &str, at: usize, source: IncludeError) -> Self {
        let (line, column) = line_and_column(text, at);
        Self::Include { path: path.into(), line, column, source }
    }
}

/// Line and column, from 1, of the byte `at` of a text.
pub fn line_and_column(text: &str, at: usize) -> (usize, usize) {
    let before = text.get(..at.min(text.len())).unwrap_or_default();
    let line = before.matches('\n').count() + 1;
    (line, before.rsplit('\n').next().unwrap_or_default().chars().count() + 1)
}
