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
    /// Name; interfaces call a group of its mesh, or a selected part of its boundary, `name.group`.
    pub name: String,
    /// The mesh.
    pub mesh: MeshSpec,
    /// Young's modulus (Pa).
    pub young: f64,
    /// Poisson's ratio (dimensionless); without effect on bars.
    #[serde(default)]
    pub poisson: f64,
    /// Density (kg/m³).
    pub density: f64,
    /// Thickness in the plane, cross-section of a bar (m; of a bar m²).
    #[serde(default = "one")]
    pub section: f64,
    /// Plane stress (default) or plane strain.
    #[serde(default)]
    pub hypothesis: Hypothesis,
    /// Consistent (default) or lumped mass.
    #[serde(default)]
    pub mass: MassForm,
    /// Rayleigh damping C = α M + β K: `[α, β]` (1/s, s).
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
    /// Gmsh file (MSH 2.0 to 4.1), relative to the folder of the scene.
    pub file: Option<PathBuf>,
    /// Width and height (m) of a rectangle with a corner at the origin; groups `bottom`, `right`, `top`, `left`, `body`.
    pub rectangle: Option<[f64; 2]>,
    /// Length of elements of a rectangle (m).
    pub size: Option<f64>,
    /// How a rectangle is triangulated.
    #[serde(default)]
    pub pattern: Pattern,
    /// Length of a bar from the origin (m); groups `left`, `right`, `body`.
    pub interval: Option<f64>,
    /// Number of elements of a bar.
    pub elements: Option<usize>,
    /// New names of groups, geometric entities (`curve 3`) or selected parts of the boundary (`left`, `x < 1e-6`, `normal -y`),
    /// by the old ones.
    #[serde(default)]
    pub groups: BTreeMap<String, String>,
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
#[non_exhaustive]
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
    /// Group of the mesh, or a selected part of its boundary.
    pub group: String,
    /// Component.
    pub axis: Axis,
    /// Displacement (m), times the signal.
    pub value: f64,
    /// Signal; constant where absent.
    #[serde(default)]
    pub signal: Signal<f64>,
}

/// A traction on a group of edges (points, for a bar).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TractionSpec {
    /// Group of the mesh, or a selected part of its boundary.
    pub group: String,
    /// Traction (Pa), times the signal.
    pub stress: [f64; 2],
    /// Signal; constant where absent.
    #[serde(default)]
    pub signal: Signal<f64>,
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
                let size = self.size.ok_or_else(|| format("mesh.rectangle needs mesh.size"))?;
                rectangle(width, height, size, self.pattern)?
            }
            (None, None, Some(length)) => {
                let elements = self.elements.ok_or_else(|| format("mesh.interval needs mesh.elements"))?;
                Mesh::interval(length, elements)?
            }
            _ => return Err(format("mesh needs one of file, rectangle and interval").into()),
        };
        if self.size.is_some() && self.rectangle.is_none() {
            return Err(format("mesh.size goes with mesh.rectangle alone").into());
        }
        if self.elements.is_some() && self.interval.is_none() {
            return Err(format("mesh.elements goes with mesh.interval alone").into());
        }
        mesh.rename_groups(self.groups.iter().map(|(old, new)| (old.as_str(), new.as_str())))?;
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
            hypothesis: self.hypothesis,
        };
        let mesh = self.mesh.mesh(&scene.folder)?;
        let mut builder = ElasticBody::builder(&self.name, mesh.clone(), material)?;
        builder.mass(self.mass);
        let [alpha, beta] = self.rayleigh.map(lit);
        builder.rayleigh(alpha, beta)?;
        builder.gravity(scene.gravity.map(lit))?;
        for PrescribedSpec { group, axis, value, signal } in &self.prescribed {
            builder.prescribe(group, *axis, lit(*value), signal.cast())?;
        }
        for TractionSpec { group, stress, signal } in &self.tractions {
            builder.traction(group, stress.map(lit), signal.cast())?;
        }
        let mut interfaces = Vec::new();
        for (index, spec) in scene.interfaces.iter().enumerate() {
            let unknown = |name: &String| {
                let selected =
                    ["left", "x < 1e-6", "normal -y"].map(|part| format!("`{}.{part}`", self.name));
                let selected = format!("parts of the boundary as {}", selected.join(" or "));
                let sides = mesh.group_names().take(20).map(|group| format!("{}.{group}", self.name));
                let sides = sides.chain([selected]);
                let planes = scene.half_planes.iter().map(|plane| plane.name.clone());
                let known = sides.chain(planes).collect::<Vec<_>>().join(", ");
                let place = format!("interface {}", spec.label());
                SceneError::UnknownName { place, name: name.clone(), known }
            };
            let group = |name: &String| {
                let group = name.strip_prefix(&self.name)?.strip_prefix('.')?;
                mesh.knows_group(group).then(|| group.to_string())
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
            builder.contact(&group, &plane.name, plane.point.map(lit), plane.normal.map(lit), own)?;
        }
        Ok((builder.build()?, interfaces))
    }
}
