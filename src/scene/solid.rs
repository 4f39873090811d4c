//! Elastic bodies as scene files write them, and what is built from them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{Scene, SceneError};
use crate::mesh::{Mesh, MeshError, Pattern, rectangle};
use crate::scalar::{Scalar, lit};
use crate::system::{Axis, ElasticBody, Hypothesis, MassForm, Material, Signal, Support};

/// An elastic body: constant-strain triangles in the plane, bars on a line. Units are those of the scene.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolidSpec {
    /// Name; interfaces call a group of its mesh `name.group`.
    pub name: String,
    /// The mesh.
    pub mesh: MeshSpec,
    /// Young's modulus (Pa).
    pub young: f64,
    /// Poisson's ratio; without effect on bars.
    #[serde(default)]
    pub poisson: f64,
    /// Density (kg/m³).
    pub density: f64,
    /// Thickness in the plane (m), cross-section of a bar (m²).
    #[serde(default = "one")]
    pub section: f64,
    /// Plane stress (default) or plane strain.
    #[serde(default)]
    pub hypothesis: HypothesisName,
    /// Consistent (default) or lumped mass.
    #[serde(default)]
    pub mass: MassName,
    /// Rayleigh damping C = α M + β K: [α (1/s), β (s)].
    #[serde(default)]
    pub rayleigh: [f64; 2],
    /// Uniform initial velocity (m/s).
    #[serde(default)]
    pub velocity: [f64; 2],
    /// Start in the equilibrium under the initial boundary conditions; without, the body starts undeformed.
    pub preload: Option<PreloadSpec>,
    /// Prescribed displacements.
    #[serde(default)]
    pub prescribed: Vec<PrescribedSpec>,
    /// Tractions on the boundary.
    #[serde(default)]
    pub tractions: Vec<TractionSpec>,
}

fn one() -> f64 {
    1.0
}

/// A mesh: one of `file`, `rectangle` and `interval`.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshSpec {
    /// Gmsh file (MSH 4.1 or 2.2), relative to the folder of the scene.
    pub file: Option<PathBuf>,
    /// Width and height of a rectangle with a corner at the origin; groups `bottom`, `right`, `top`, `left`, `body`.
    pub rectangle: Option<[f64; 2]>,
    /// Length of elements of a rectangle.
    pub size: Option<f64>,
    /// How a rectangle is triangulated.
    #[serde(default)]
    pub pattern: PatternName,
    /// Length of a bar from the origin; groups `left`, `right`, `body`.
    pub interval: Option<f64>,
    /// Number of elements of a bar.
    pub elements: Option<usize>,
    /// New names of groups of a built-in mesh, by the old ones.
    #[serde(default)]
    pub groups: BTreeMap<String, String>,
}

/// Name of a [`Pattern`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PatternName {
    /// Nearly equilateral triangles (default).
    #[default]
    Quality,
    /// Right triangles.
    Structured,
}

/// Name of a [`Hypothesis`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HypothesisName {
    /// σ_zz = 0 (default).
    #[default]
    PlaneStress,
    /// ε_zz = 0.
    PlaneStrain,
}

/// Name of a [`MassForm`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MassName {
    /// Consistent (default).
    #[default]
    Consistent,
    /// Lumped.
    Lumped,
}

/// Static preload.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PreloadSpec {
    /// What the nodes that may touch do.
    #[serde(default)]
    pub contacts: SupportName,
    /// Whether gravity and constant tractions act.
    #[serde(default)]
    pub constant_forces: bool,
}

/// What the nodes that may touch do in the preload.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SupportName {
    /// Held in every direction (default).
    #[default]
    Fixed,
    /// Held along the normal.
    Sliding,
    /// Free.
    Free,
    /// Resolved by the cone solver: they press, stick or slide as friction lets them.
    Resolved,
}

impl SupportName {
    /// The support of a preload without contact forces; `None` where the cone solver resolves them.
    pub(super) fn support(self) -> Option<Support> {
        match self {
            Self::Fixed => Some(Support::Fixed),
            Self::Sliding => Some(Support::Sliding),
            Self::Free => Some(Support::Free),
            Self::Resolved => None,
        }
    }
}

/// A component of the displacement of a group that moves as told.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PrescribedSpec {
    /// Group of the mesh.
    pub group: String,
    /// Component.
    pub axis: AxisName,
    /// Displacement (m), times the signal.
    pub value: f64,
    /// Signal; constant where absent.
    #[serde(default)]
    pub signal: SignalSpec,
}

/// Name of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AxisName {
    /// Along x.
    X,
    /// Along y.
    Y,
}

/// A traction on a group of edges (points, for a bar).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TractionSpec {
    /// Group of the mesh.
    pub group: String,
    /// Traction (Pa), times the signal.
    pub stress: [f64; 2],
    /// Signal; constant where absent.
    #[serde(default)]
    pub signal: SignalSpec,
}

/// A signal, see [`Signal`].
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum SignalSpec {
    /// 1 (default).
    #[default]
    Constant,
    /// sin 2π(f t + φ).
    Sine {
        /// f (1/s).
        frequency: f64,
        /// φ, as a fraction of the period.
        #[serde(default)]
        phase: f64,
    },
    /// sgn sin 2π(f t + φ).
    Square {
        /// f (1/s).
        frequency: f64,
        /// φ, as a fraction of the period.
        #[serde(default)]
        phase: f64,
    },
    /// From 0 at `start` to 1 at `end`.
    Ramp {
        /// Where it leaves 0 (s).
        #[serde(default)]
        start: f64,
        /// Where it reaches 1 (s).
        end: f64,
    },
    /// Linear between points.
    Table {
        /// Times (s).
        times: Vec<f64>,
        /// Values.
        values: Vec<f64>,
    },
}

impl SignalSpec {
    pub(super) fn signal<T: Scalar>(&self) -> Signal<T> {
        let all = |values: &[f64]| values.iter().map(|&x| lit(x)).collect();
        match self {
            Self::Constant => Signal::Constant,
            &Self::Sine { frequency, phase } => Signal::Sine { frequency: lit(frequency), phase: lit(phase) },
            &Self::Square { frequency, phase } => {
                Signal::Square { frequency: lit(frequency), phase: lit(phase) }
            }
            &Self::Ramp { start, end } => Signal::Ramp { start: lit(start), end: lit(end) },
            Self::Table { times, values } => Signal::Table { times: all(times), values: all(values) },
        }
    }
}

impl MeshSpec {
    /// Reads or builds the mesh; files are relative to `folder`.
    ///
    /// # Errors
    /// [`SceneError::Mesh`].
    pub fn mesh(&self, folder: &Path) -> Result<Mesh, SceneError> {
        let format = |message: &str| MeshError::Format { line: 0, message: message.into() };
        let mut mesh = match (&self.file, self.rectangle, self.interval) {
            (Some(file), None, None) => Mesh::read(&folder.join(file))?,
            (None, Some([width, height]), None) => {
                let pattern = match self.pattern {
                    PatternName::Quality => Pattern::Quality,
                    PatternName::Structured => Pattern::Structured,
                };
                let size = self.size.ok_or_else(|| format("mesh.rectangle needs mesh.size"))?;
                rectangle(width, height, size, pattern)?
            }
            (None, None, Some(length)) => {
                let elements = self.elements.ok_or_else(|| format("mesh.interval needs mesh.elements"))?;
                Mesh::interval(length, elements)?
            }
            _ => return Err(format("mesh needs one of file, rectangle and interval").into()),
        };
        // A file has the names it has: the new ones may be in it already.
        if self.file.is_none() {
            mesh.rename_groups(self.groups.iter().map(|(old, new)| (old.as_str(), new.as_str())))?;
        }
        Ok(mesh)
    }
}

impl SolidSpec {
    /// The body and the interface (of the scene) behind each of its own.
    pub(super) fn body<T: Scalar>(&self, scene: &Scene) -> Result<(ElasticBody<T>, Vec<usize>), SceneError> {
        let material = Material {
            young: lit(self.young),
            poisson: lit(self.poisson),
            density: lit(self.density),
            section: lit(self.section),
            hypothesis: match self.hypothesis {
                HypothesisName::PlaneStress => Hypothesis::PlaneStress,
                HypothesisName::PlaneStrain => Hypothesis::PlaneStrain,
            },
        };
        let mesh = self.mesh.mesh(&scene.folder)?;
        let groups: Vec<String> = mesh.group_names().map(String::from).collect();
        let mut builder = ElasticBody::builder(&self.name, mesh, material)?;
        builder.mass(match self.mass {
            MassName::Consistent => MassForm::Consistent,
            MassName::Lumped => MassForm::Lumped,
        });
        let [alpha, beta] = self.rayleigh.map(lit);
        builder.rayleigh(alpha, beta)?;
        builder.gravity(scene.gravity.map(lit))?;
        for PrescribedSpec { group, axis, value, signal } in &self.prescribed {
            let axis = if *axis == AxisName::X { Axis::X } else { Axis::Y };
            builder.prescribe(group, axis, lit(*value), signal.signal())?;
        }
        for TractionSpec { group, stress, signal } in &self.tractions {
            builder.traction(group, stress.map(lit), signal.signal())?;
        }
        let mut interfaces = Vec::new();
        for (index, spec) in scene.interfaces.iter().enumerate() {
            let unknown = |name: &String| {
                let sides = groups.iter().map(|group| format!("{}.{group}", self.name));
                let planes = scene.half_planes.iter().map(|plane| plane.name.clone());
                let known = sides.chain(planes).collect::<Vec<_>>().join(", ");
                let place = format!("interface {}", spec.label());
                SceneError::UnknownName { place, name: name.clone(), known }
            };
            let group = |name: &String| {
                let group = name.strip_prefix(&self.name)?.strip_prefix('.')?;
                groups.iter().find(|known| *known == group)
            };
            let plane = |name: &String| scene.half_planes.iter().find(|plane| plane.name == *name);
            let [a, b] = &spec.between;
            let (group, plane) = match (group(a), plane(b), group(b), plane(a)) {
                (Some(group), Some(plane), ..) | (_, _, Some(group), Some(plane)) => (group, plane),
                (None, _, None, None) => return Err(unknown(a)),
                (Some(_), None, ..) => return Err(unknown(b)),
                _ => return Err(unknown(if plane(a).is_some() { b } else { a })),
            };
            let own = builder.interface();
            interfaces.push(index);
            builder.contact(group, &plane.name, plane.point.map(lit), plane.normal.map(lit), own)?;
        }
        Ok((builder.build()?, interfaces))
    }
}
