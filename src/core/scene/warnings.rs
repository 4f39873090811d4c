//! What a scene says that has no effect, or hardly the one meant.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use nalgebra::DMatrix;

use super::behind::SHOWN;
use super::names::Directory;
use super::obstacles::turned;
use super::{BodySpec, LagrangianSpec, Scene, SceneError, SpringSpec};
use crate::registry::Registry;
use crate::system::Signal;

/// A step longer than this part of a period does not follow it.
const OF_PERIOD: f64 = 0.25;

/// What a scene says that has no effect, or hardly the one meant. It can be run all the same.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum SceneWarning {
    /// Shapes that no interface lets touch anything: their bodies pass through all others.
    TouchesNothing {
        /// The bodies all of whose shapes are meant, by name, and the other shapes as `body.shape`.
        names: Vec<String>,
    },
    /// An interface that governs no pair.
    UnusedInterface {
        /// The interface, as its two sides.
        interface: String,
        /// Its parameters, which act nowhere.
        parameters: Vec<String>,
        /// Whether all it names is one body.
        one_body: bool,
    },
    /// A parameter of an interface that governs pairs, which none of its laws in the runs takes.
    IdleParameter {
        /// The interface, as its two sides.
        interface: String,
        /// The parameter.
        parameter: String,
        /// The laws of the interface in the runs, with the parameters they have.
        laws: Vec<(String, Vec<String>)>,
    },
    /// Parameters of a joint without limits.
    NoLimits {
        /// The joint.
        joint: String,
        /// Its parameters, which act nowhere.
        parameters: Vec<String>,
    },
    /// Bodies that start behind a chain, where all that may touch it do.
    BehindChain {
        /// The chain, as `obstacle.chain`.
        chain: String,
        /// The bodies.
        bodies: Vec<String>,
    },
    /// A step longer than a wave needs through an elastic body.
    LongStepForWaves {
        /// The body.
        body: String,
        /// How long a wave needs (s).
        crossing: f64,
        /// The step (s).
        step: f64,
    },
    /// A body in space that is carried past the thinnest shape within a step, where nothing sees it pass.
    Passes {
        /// The body.
        body: String,
        /// Its way in a step (m).
        way: f64,
        /// Thickness of the thinnest shape (m).
        thickness: f64,
    },
    /// A step that is long for what moves in its own time.
    LongStep {
        /// What moves.
        what: String,
        /// Its period (s).
        period: f64,
        /// The step (s).
        step: f64,
    },
}

impl fmt::Display for SceneWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TouchesNothing { names } => {
                let shown = names.iter().take(SHOWN).map(|name| format!("`{name}`")).collect::<Vec<_>>();
                write!(f, "no interface lets {} touch anything", shown.join(", "))?;
                if names.len() > SHOWN {
                    write!(f, " (nor {} more)", names.len() - SHOWN)?;
                }
                write!(f, ": what no [[interfaces]] entry names passes through everything")
            }
            Self::UnusedInterface { interface, parameters, one_body } => {
                let why = if *one_body {
                    "its sides are one body, which does not touch itself"
                } else {
                    "it fits no pair of shapes, or interfaces before it govern those it fits"
                };
                write!(f, "interface {interface} has no effect: {why}")?;
                match parameters.is_empty() {
                    true => Ok(()),
                    false => write!(f, "; its {} act nowhere", parameters.join(", ")),
                }
            }
            Self::IdleParameter { interface, parameter, laws } => {
                let law = |(law, known): &(String, Vec<String>)| {
                    let known = known.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
                    format!("`{law}` has {}", if known.is_empty() { "none" } else { &known })
                };
                let laws = laws.iter().map(law).collect::<Vec<_>>().join("; ");
                write!(
                    f,
                    "interface {interface}: `{parameter}` acts nowhere, no law of it in the runs takes it ({laws})"
                )
            }
            Self::NoLimits { joint, parameters } => {
                write!(f, "joint `{joint}` has no limits: its {} act nowhere", parameters.join(", "))
            }
            Self::BehindChain { chain, bodies } => {
                let shown = bodies.iter().take(SHOWN).map(|name| format!("`{name}`")).collect::<Vec<_>>();
                write!(f, "{}", shown.join(", "))?;
                if bodies.len() > SHOWN {
                    write!(f, " and {} more", bodies.len() - SHOWN)?;
                }
                write!(
                    f,
                    " start behind the chain `{chain}`: its free side is on the left, seen from its first point to its \
                     last; reverse its points if bodies are to stay on the other side"
                )
            }
            Self::LongStepForWaves { body, crossing, step } => {
                write!(
                    f,
                    "the step {step:e} is long for the waves in `{body}`, which cross it in {crossing:.3e}"
                )
            }
            Self::Passes { body, way, thickness } => {
                write!(
                    f,
                    "`{body}` starts with {way:.3e} in a step, and the thinnest shape is {thickness:.3e} thick: in space \
                     what is passed within a step is not felt, take a shorter step"
                )
            }
            Self::LongStep { what, period, step } => {
                write!(f, "the step {step:e} is long for {what}, whose period is {period:.3e}")
            }
        }
    }
}

/// What stands on the same sides of all interfaces: bodies (by index), and whether an obstacle or a half-plane is among it.
#[derive(Default)]
struct Alike {
    bodies: BTreeSet<usize>,
    other: bool,
}

impl Alike {
    /// Whether there is something else here than `body`.
    fn meets(&self, body: usize) -> bool {
        self.other || self.bodies.iter().any(|&other| other != body)
    }
}

impl Scene {
    /// What of the scene has no effect, or hardly the one meant, in its runs with the laws of `registry`.
    ///
    /// # Errors
    /// [`SceneError`]: names taken twice, interfaces that name nothing, a law or a mesh that cannot be had.
    pub fn warnings(&self, registry: &Registry) -> Result<Vec<SceneWarning>, SceneError> {
        let mut warnings = Vec::new();
        if let Some(solid) = &self.solid {
            if self.interfaces.is_empty() && !self.half_planes.is_empty() {
                warnings.push(SceneWarning::TouchesNothing { names: vec![solid.name.clone()] });
            }
        } else {
            self.warn_of_interfaces(&mut warnings)?;
            self.warn_of_chains(&mut warnings)?;
        }
        self.warn_of_parameters(registry, &mut warnings)?;
        if self.time.adaptive.is_none() {
            self.warn_of_step(&mut warnings)?;
        }
        Ok(warnings)
    }

    fn warn_of_parameters(
        &self,
        registry: &Registry,
        warnings: &mut Vec<SceneWarning>,
    ) -> Result<(), SceneError> {
        let unused: BTreeSet<String> = (warnings.iter())
            .filter_map(|warning| match warning {
                SceneWarning::UnusedInterface { interface, .. } => Some(interface.clone()),
                _ => None,
            })
            .collect();
        for interface in self.all_interfaces().filter(|interface| !unused.contains(&interface.label())) {
            let mut laws = Vec::new();
            for name in interface.laws_in(&self.laws) {
                let family = registry
                    .find_law(name)
                    .map_err(|source| SceneError::Law { interface: interface.label(), source })?;
                let known = family.description().parameters.iter().map(|p| p.name.to_string()).collect();
                laws.push((name.to_string(), known));
            }
            let is_taken =
                |name: &String| laws.iter().any(|(_, known): &(String, Vec<String>)| known.contains(name));
            for parameter in interface.parameters.keys().filter(|name| !is_taken(name)) {
                let (interface, parameter) = (interface.label(), parameter.clone());
                warnings.push(SceneWarning::IdleParameter { interface, parameter, laws: laws.clone() });
            }
        }
        let planar = self.joints.iter().map(|joint| (&joint.name, joint.limits, &joint.parameters));
        let spatial = self.space.iter().flat_map(|space| &space.joints);
        let spatial = spatial.map(|joint| (&joint.name, joint.limits, &joint.parameters));
        for (name, limits, parameters) in planar.chain(spatial) {
            if limits.is_none() && !parameters.is_empty() {
                let parameters = parameters.keys().map(|name| format!("`{name}`")).collect();
                warnings.push(SceneWarning::NoLimits { joint: name.clone(), parameters });
            }
        }
        Ok(())
    }

    fn warn_of_interfaces(&self, warnings: &mut Vec<SceneWarning>) -> Result<(), SceneError> {
        let directory = Directory::new(self)?;
        directory.check_interfaces(self)?;
        let mut alike: BTreeMap<Vec<[bool; 2]>, Alike> = BTreeMap::new();
        for (body, shapes) in directory.contactors.iter().enumerate() {
            for names in shapes {
                alike.entry(Directory::sides(self, names)).or_default().bodies.insert(body);
            }
        }
        for names in directory.others() {
            alike.entry(Directory::sides(self, names)).or_default().other = true;
        }
        let mut names = Vec::new();
        for (own, (body, shapes)) in directory.bodies.iter().zip(&directory.contactors).enumerate() {
            let index = names.len();
            for (label, known) in body.shapes.iter().zip(shapes) {
                let sides = Directory::sides(self, known);
                let touches = |(other, what): (&Vec<[bool; 2]>, &Alike)| {
                    Directory::interface_between(&sides, other).is_some() && what.meets(own)
                };
                if !alike.iter().any(touches) {
                    names.push(format!("{}.{label}", body.name));
                }
            }
            if !shapes.is_empty() && names.len() - index == shapes.len() {
                names.truncate(index);
                names.push(body.name.clone());
            }
        }
        if !names.is_empty() {
            warnings.push(SceneWarning::TouchesNothing { names });
        }
        let mut used = vec![false; self.interfaces.len()];
        for (a, of_a) in &alike {
            for (b, of_b) in &alike {
                if let Some(interface) = Directory::interface_between(a, b)
                    && of_a.bodies.iter().any(|&body| of_b.meets(body))
                {
                    used[interface] = true;
                }
            }
        }
        for (interface, _) in self.interfaces.iter().zip(&used).filter(|(_, used)| !**used) {
            let bodies: BTreeSet<usize> = (directory.contactors.iter().enumerate())
                .filter(|(_, shapes)| {
                    shapes.iter().any(|names| interface.between.iter().any(|side| names.contains(side)))
                })
                .map(|(body, _)| body)
                .collect();
            let others =
                directory.others().any(|names| interface.between.iter().any(|side| names.contains(side)));
            warnings.push(SceneWarning::UnusedInterface {
                interface: interface.label(),
                parameters: interface.parameters.keys().map(|name| format!("`{name}`")).collect(),
                one_body: bodies.len() == 1 && !others,
            });
        }
        Ok(())
    }

    fn warn_of_step(&self, warnings: &mut Vec<SceneWarning>) -> Result<(), SceneError> {
        let step = self.step_length();
        let passes = self.space.as_ref().and_then(|space| space.passes(step, &self.folder));
        warnings.extend(passes);
        let mut look = |what: String, period: f64| {
            if step > OF_PERIOD * period {
                warnings.push(SceneWarning::LongStep { what, period, step });
            }
        };
        let turn = std::f64::consts::TAU;
        for body in &self.bodies {
            let inertias = [body.mass, body.mass, body.inertia];
            let periods = body.stiffness.iter().zip(inertias).filter(|(k, _)| **k > 0.0);
            let shortest = periods.map(|(k, m)| turn * (m / k).sqrt()).fold(f64::INFINITY, f64::min);
            look(format!("the springs of `{}`", body.name), shortest);
            look(format!("the spin of `{}`", body.name), turn / body.spin.abs());
            look(
                format!("the loads on `{}`", body.name),
                shortest_of(body.loads.iter().map(|load| &load.signal)),
            );
        }
        for body in self.space.iter().flat_map(|space| &space.bodies) {
            look(format!("the spin of `{}`", body.name), turn / length(&body.spin));
            let signals = body.loads.iter().map(|load| &load.signal);
            look(format!("the loads on `{}`", body.name), shortest_of(signals));
        }
        for spring in &self.springs {
            let rate = (spring.stiffness * self.mobility_along(spring)).sqrt();
            look(format!("the spring `{}`", spring.name), turn / rate);
        }
        for obstacle in &self.obstacles {
            let signals = obstacle.motion.iter().map(|motion| &motion.signal);
            look(format!("the motion of `{}`", obstacle.name), shortest_of(signals));
        }
        if let Some(lagrangian) = &self.lagrangian {
            look("the springs of the Lagrangian system".into(), turn / lagrangian.fastest());
            let loads = lagrangian.loads.iter().map(|load| &load.signal);
            look("the loads on the Lagrangian system".into(), shortest_of(loads));
        }
        let Some(solid) = &self.solid else { return Ok(()) };
        for (group, signal) in (solid.tractions.iter().map(|traction| (&traction.group, &traction.signal)))
            .chain(solid.prescribed.iter().map(|prescribed| (&prescribed.group, &prescribed.signal)))
        {
            look(format!("the signal on `{group}`"), shortest_of([signal].into_iter()));
        }
        // Along its longest side: a step that is shorter follows the slowest of its waves at least.
        let extent = solid.mesh.mesh(&self.folder)?.extent();
        let crossing = extent[0].max(extent[1]) / (solid.young / solid.density).sqrt();
        if step > crossing {
            let body = solid.name.clone();
            warnings.push(SceneWarning::LongStepForWaves { body, crossing, step });
        }
        Ok(())
    }

    /// How easily the ends of a spring are moved against each other (1/kg or 1/(kg m²)) as the scene starts, joints not
    /// counted; 0 where nothing of it moves.
    fn mobility_along(&self, spring: &SpringSpec) -> f64 {
        let body = |name: &str| self.bodies.iter().find(|body| body.name == name);
        let (one, other) = (body(&spring.body), spring.to.as_deref().and_then(body));
        let sides = [(one, spring.at), (other, spring.on)];
        let free = || sides.iter().filter_map(|&(body, point)| Some((body?, point)));
        if spring.angular {
            return free().map(|(body, _)| 1.0 / body.inertia).sum();
        }
        let arm = |body: &BodySpec, point: [f64; 2]| turned(point, body.angle);
        let place = |(body, point): (Option<&BodySpec>, [f64; 2])| match body {
            Some(body) => {
                let [x, y] = arm(body, point);
                [body.position[0] + x, body.position[1] + y]
            }
            None => point,
        };
        // A point of an obstacle is given in its frame.
        let obstacle = spring.to.as_ref().and_then(|to| self.obstacles.iter().find(|o| o.name == *to));
        let axis = spring.axis.map(|axis| turned(axis, other.map_or(0.0, |body| body.angle)));
        let (from, to) = (place(sides[0]), obstacle.map_or(place(sides[1]), |o| o.place(spring.on)));
        let [x, y] = axis.unwrap_or([from[0] - to[0], from[1] - to[1]]);
        let length = x.hypot(y);
        let (x, y) = if length > 0.0 { (x / length, y / length) } else { (0.0, 0.0) };
        free()
            .map(|(body, point)| {
                let [a, b] = arm(body, point);
                1.0 / body.mass + (a * y - b * x).powi(2) / body.inertia
            })
            .sum()
    }
}

/// Length of a vector.
pub(super) fn length(vector: &[f64; 3]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The shortest period of signals (s), infinite where they have none.
fn shortest_of<'a>(signals: impl Iterator<Item = &'a Signal<f64>>) -> f64 {
    let period = |signal: &Signal<f64>| match signal {
        Signal::Sine { frequency, .. } | Signal::Square { frequency, .. } => 1.0 / frequency,
        _ => f64::INFINITY,
    };
    signals.map(period).fold(f64::INFINITY, f64::min)
}

impl LagrangianSpec {
    /// The largest angular frequency of M and K (rad/s); 0 without stiffness, or where M and K are none.
    fn fastest(&self) -> f64 {
        let n = self.coordinates.len();
        let is_square = |rows: &[Vec<f64>]| rows.len() == n && rows.iter().all(|row| row.len() == n);
        if !(is_square(&self.mass) && is_square(&self.stiffness)) {
            return 0.0;
        }
        let matrix = |rows: &[Vec<f64>]| DMatrix::from_fn(n, n, |i, j| rows[i][j]);
        let Some(factor) = matrix(&self.mass).cholesky() else { return 0.0 };
        // L⁻¹ K L⁻ᵀ, as L⁻¹ (L⁻¹ K)ᵀ.
        let lower = factor.l();
        let squares = (lower.solve_lower_triangular(&matrix(&self.stiffness)))
            .and_then(|half| lower.solve_lower_triangular(&half.transpose()))
            .map(|whole| whole.symmetric_eigenvalues());
        squares.map_or(0.0, |squares| squares.iter().fold(0.0_f64, |most, &x| most.max(x)).sqrt())
    }
}
