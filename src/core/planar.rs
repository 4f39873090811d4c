//! Planar scenes of rigid bodies from Rust, without a file.
//!
//! ```
//! use nonsmooth::laws::Fremond;
//! use nonsmooth::planar::{PlanarScene, Shape, body};
//! use nonsmooth::scheme::Settings;
//!
//! let mut scene = PlanarScene::new();
//! let ball = scene.add(body(Shape::disc(0.1)).named("ball").mass(2.0).at(0.0, 1.1).moving(1.0, 0.0));
//! let floor = scene.half_plane("floor", [0.0, 0.0], [0.0, 1.0]);
//! scene.interface(ball, floor, Fremond::new(0.5, 0.3)?);
//! scene.gravity(0.0, -10.0);
//!
//! let run = scene.run(Settings::new(0.5, 1e-3), 1.0)?;
//! let bounce = run.contacts.iter().flatten().next().ok_or("no impact")?;
//! // It falls 1 m, and half the speed is left.
//! assert!((bounce.before[0] + 20f64.sqrt()).abs() < 1e-2);
//! assert!((bounce.after[0] + 0.5 * bounce.before[0]).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`PlanarScene::scheme`] gives the scheme itself, to step by hand. Scene files know more: loads, springs, several shapes on a
//! body; and so does [`RigidBodies::builder`](crate::system::RigidBodies::builder), which this is made of.

use std::sync::atomic::AtomicBool;

use crate::laws::ContactLaw;
use crate::observe::{Recorder, Recording, RunInfo};
use crate::scalar::{Scalar, lit, to_f64};
use crate::scheme::{Settings, SetupError, ThetaScheme};
use crate::simulate::{SimulateError, Stepper};
use crate::solver::{self, ConeSolver, Stopping, UnknownSolver};
use crate::system::{Body, BodyId, GroupId, RigidBodies, RigidBodiesBuilder, SystemError, polygon_body};

/// The outline of a body.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Shape<T> {
    /// A disc about the centre of mass.
    Disc {
        /// Radius (m); 0 is a point.
        radius: T,
    },
    /// A convex polygon.
    Polygon {
        /// Vertices (m), counterclockwise; the centre of mass becomes the origin.
        vertices: Vec<[T; 2]>,
    },
}

impl<T: Scalar> Shape<T> {
    /// A disc.
    pub fn disc(radius: T) -> Self {
        Self::Disc { radius }
    }

    /// A point.
    pub fn point() -> Self {
        Self::Disc { radius: T::zero() }
    }

    /// A convex polygon, its vertices counterclockwise.
    pub fn polygon(vertices: impl Into<Vec<[T; 2]>>) -> Self {
        Self::Polygon { vertices: vertices.into() }
    }

    /// A rectangle.
    pub fn rectangle(width: T, height: T) -> Self {
        let (x, y) = (width * lit::<T>(0.5), height * lit::<T>(0.5));
        Self::polygon([[-x, -y], [x, -y], [x, y], [-x, y]])
    }
}

/// A homogeneous body of a shape, of mass 1 kg, at rest at the origin: methods say what is otherwise.
pub fn body<T: Scalar>(shape: Shape<T>) -> PlanarBody<T> {
    let zeros = [T::zero(); 2];
    PlanarBody {
        name: None,
        shape,
        mass: T::one(),
        inertia: None,
        position: zeros,
        angle: T::zero(),
        velocity: zeros,
        spin: T::zero(),
        force: (zeros, T::zero()),
    }
}

/// A body to be added to a scene, see [`body`].
#[derive(Debug, Clone, PartialEq)]
pub struct PlanarBody<T> {
    name: Option<String>,
    shape: Shape<T>,
    mass: T,
    inertia: Option<T>,
    position: [T; 2],
    angle: T,
    velocity: [T; 2],
    spin: T,
    force: ([T; 2], T),
}

impl<T: Scalar> PlanarBody<T> {
    /// With this name in outputs; `body` and its number without.
    #[must_use]
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: Some(name.into()), ..self }
    }

    /// With this mass (kg).
    #[must_use]
    pub fn mass(self, mass: T) -> Self {
        Self { mass, ..self }
    }

    /// With this inertia about the centre of mass (kg m²), in place of that of a homogeneous body. A point, which has none,
    /// has that of a disc of 1 m without.
    #[must_use]
    pub fn inertia(self, inertia: T) -> Self {
        Self { inertia: Some(inertia), ..self }
    }

    /// With the centre of mass here at the start (m).
    #[must_use]
    pub fn at(self, x: T, y: T) -> Self {
        Self { position: [x, y], ..self }
    }

    /// Turned by this angle at the start (rad).
    #[must_use]
    pub fn turned(self, angle: T) -> Self {
        Self { angle, ..self }
    }

    /// With this velocity of the centre of mass at the start (m/s).
    #[must_use]
    pub fn moving(self, x: T, y: T) -> Self {
        Self { velocity: [x, y], ..self }
    }

    /// With this angular velocity at the start (rad/s).
    #[must_use]
    pub fn spinning(self, spin: T) -> Self {
        Self { spin, ..self }
    }

    /// With a constant force (N) and torque (N m), beside gravity.
    #[must_use]
    pub fn pushed(self, force: [T; 2], torque: T) -> Self {
        Self { force: (force, torque), ..self }
    }

    /// Mass and inertia, and the outline about the centre of mass.
    fn inertial(&self) -> Result<(Body<T>, Shape<T>), SystemError> {
        let mass = self.mass;
        let (inertia, shape) = match &self.shape {
            Shape::Disc { radius } => {
                let radius_of_gyration = if *radius > T::zero() { *radius } else { T::one() };
                (mass * radius_of_gyration * radius_of_gyration * lit::<T>(0.5), self.shape.clone())
            }
            Shape::Polygon { vertices } => {
                let (unit, vertices, _) = polygon_body(T::one(), vertices)?;
                (unit.inertia / unit.mass * mass, Shape::Polygon { vertices })
            }
        };
        Ok((Body { mass, inertia: self.inertia.unwrap_or(inertia) }, shape))
    }
}

/// What contacts may lie on: a body, several, or a half-plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Surface(GroupId);

/// A body of a scene; its outline is a [`Surface`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Member {
    body: BodyId,
    surface: Surface,
}

impl From<Member> for Surface {
    fn from(member: Member) -> Self {
        member.surface
    }
}

/// Why a scene cannot be built or run.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum PlanarError {
    /// The bodies or half-planes are not valid.
    #[error(transparent)]
    System(#[from] SystemError),
    /// There is no such solver, or its stopping rule is out of range.
    #[error(transparent)]
    Solver(#[from] UnknownSolver),
    /// The scheme cannot start.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The run ended before its end time.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// The number of steps to the end is no number of steps.
    #[error("the end time is {end}, it must be finite, > 0 and at most 1e15 steps away")]
    End {
        /// The end time (s).
        end: f64,
    },
}

/// A planar scene of rigid bodies, in the making.
///
/// Contacts have dimension D: 2 with friction, 1 without. What is wrong with a body or a half-plane is told when the scene is
/// built.
#[derive(Debug)]
pub struct PlanarScene<T: Scalar = f64, const D: usize = 2> {
    builder: RigidBodiesBuilder<T>,
    bodies: usize,
    state: (Vec<T>, Vec<T>),
    gravity: [T; 2],
    laws: Vec<Box<dyn ContactLaw<T, D>>>,
    /// What was wrong first.
    wrong: Option<SystemError>,
}

impl<T: Scalar, const D: usize> Default for PlanarScene<T, D> {
    fn default() -> Self {
        Self {
            builder: RigidBodies::builder(),
            bodies: 0,
            state: (Vec::new(), Vec::new()),
            gravity: [T::zero(); 2],
            laws: Vec::new(),
            wrong: None,
        }
    }
}

impl PlanarScene {
    /// An empty scene in double precision, with friction. [`Default`] makes those of other arithmetics and dimensions.
    pub fn new() -> Self {
        Self::default()
    }
}

impl<T: Scalar, const D: usize> PlanarScene<T, D> {
    /// Notes the first thing that is wrong.
    fn noted<V>(&mut self, result: Result<V, SystemError>) -> Option<V> {
        match result {
            Ok(value) => Some(value),
            Err(error) => {
                self.wrong.get_or_insert(error);
                None
            }
        }
    }

    /// A surface that bodies and half-planes are to be put on, see [`add_to`](Self::add_to).
    pub fn surface(&mut self) -> Surface {
        Surface(self.builder.group())
    }

    /// Adds a body with a surface of its own.
    pub fn add(&mut self, body: PlanarBody<T>) -> Member {
        let surface = self.surface();
        self.add_to(surface, body)
    }

    /// Adds a body whose outline lies on `surface`: bodies of one surface touch the same others under the same laws, and each
    /// other where there is an interface of the surface with itself.
    pub fn add_to(&mut self, surface: Surface, body: PlanarBody<T>) -> Member {
        let name = body.name.clone().unwrap_or_else(|| format!("body{}", self.bodies));
        self.bodies += 1;
        let (q, v) = &mut self.state;
        q.extend([body.position[0], body.position[1], body.angle]);
        v.extend([body.velocity[0], body.velocity[1], body.spin]);
        // What is wrong is noted, and the body stands in so that those after it keep their places.
        let inertial = body.inertial();
        let stand_in = (Body { mass: T::one(), inertia: T::one() }, Shape::point());
        let (inertial, shape) = self.noted(inertial).unwrap_or(stand_in);
        let added = self.builder.body(&name, inertial);
        let id = match self.noted(added) {
            Some(id) => id,
            None => match self.builder.body(&name, Body { mass: T::one(), inertia: T::one() }) {
                Ok(id) => id,
                Err(_) => unreachable!("a mass and an inertia of 1 are in range"),
            },
        };
        let (force, torque) = body.force;
        let forced = self.builder.force(id, force, torque);
        self.noted(forced);
        let outlined = match &shape {
            Shape::Disc { radius } => self.builder.disc(&name, id, [T::zero(); 2], *radius, surface.0),
            Shape::Polygon { vertices } => self.builder.polygon(&name, id, vertices, surface.0),
        };
        self.noted(outlined);
        Member { body: id, surface }
    }

    /// Adds the fixed half-plane through `point` with the outward `normal`, of any length: bodies stay on the side it points
    /// to.
    pub fn half_plane(&mut self, name: &str, point: [T; 2], normal: [T; 2]) -> Surface {
        let surface = self.surface();
        let added = self.builder.half_plane(name, point, normal, surface.0);
        self.noted(added);
        surface
    }

    /// Lets two surfaces touch, under a law; given again for the same two it replaces the law. Surfaces without an interface
    /// pass through each other.
    pub fn interface(
        &mut self,
        a: impl Into<Surface>,
        b: impl Into<Surface>,
        law: impl ContactLaw<T, D> + 'static,
    ) {
        let declared = self.builder.interface(a.into().0, b.into().0);
        let Some(index) = self.noted(declared) else { return };
        let law: Box<dyn ContactLaw<T, D>> = Box::new(law);
        match self.laws.get_mut(index) {
            Some(old) => *old = law,
            None => self.laws.push(law),
        }
    }

    /// Pins the point `at` of a body, in its frame, to the point `on` of another one, or of the ground (m).
    pub fn pin(&mut self, name: &str, member: Member, at: [T; 2], other: Option<Member>, on: [T; 2]) {
        let pinned = self.builder.pin(name, member.body, at, other.map(|other| other.body), on);
        self.noted(pinned);
    }

    /// Acceleration of gravity (m/s²) on all bodies.
    pub fn gravity(&mut self, x: T, y: T) {
        self.gravity = [x, y];
    }

    /// The scheme at time 0, with the default solver.
    ///
    /// # Errors
    /// [`PlanarError`] with the first thing that is wrong.
    pub fn scheme(self, settings: Settings<T>) -> Result<ThetaScheme<T, D>, PlanarError> {
        self.scheme_with(settings, solver::build(solver::DEFAULT, Stopping::default())?)
    }

    /// The scheme at time 0, with a solver.
    ///
    /// # Errors
    /// [`PlanarError`] with the first thing that is wrong.
    pub fn scheme_with(
        mut self,
        settings: Settings<T>,
        solver: Box<dyn ConeSolver<T, D>>,
    ) -> Result<ThetaScheme<T, D>, PlanarError> {
        if let Some(error) = self.wrong {
            return Err(error.into());
        }
        self.builder.gravity(self.gravity)?;
        let (q, v) = self.state;
        let system = Box::new(self.builder.build()?);
        Ok(ThetaScheme::new(system, self.laws, solver, settings, T::zero(), q, v)?)
    }

    /// Runs from 0 to `end` (s) with the default solver and returns what happened, every step of it.
    ///
    /// # Errors
    /// [`PlanarError`].
    pub fn run(self, settings: Settings<T>, end: f64) -> Result<Recording, PlanarError> {
        let scheme = self.scheme(settings)?;
        let steps = (end / to_f64(settings.step) - 1e-6).ceil();
        if !(end > 0.0 && steps <= 1e15) {
            return Err(PlanarError::End { end });
        }
        let laws: Vec<String> = scheme.laws().iter().map(|law| law.name().to_string()).collect();
        let info = RunInfo::new(&laws.join(", "), scheme.solver().name(), laws, scheme.settings());
        let info = info.with_rows(scheme.rows());
        let mut recorder = Recorder::new(1);
        let steps = steps.max(1.0) as usize;
        Stepper::from(scheme).run(steps, &info, &mut [&mut recorder], &AtomicBool::new(false))?;
        Ok(recorder.finish())
    }
}
