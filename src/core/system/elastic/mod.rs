//! Linear elastic bodies: constant-strain triangles (T3) in the plane, two-node bars on a line.

mod assembly;
mod builder;
mod elements;
mod preload;

mod material;

use std::sync::Arc;

use nalgebra::{SVector, Vector2};

pub use builder::{Axis, ElasticBodyBuilder, ElasticError};
pub use material::{Hypothesis, Material};
pub use preload::{PreloadError, Support};

use super::{Contacts, Describe, Dynamics, Forces, Prescribed, Scales};
use crate::contact::{Candidate, ContactId};
use crate::linalg::{BlockRows, Symmetric, max_abs};
use crate::mesh::Mesh;
use crate::scalar::{Scalar, lit};

/// How the mass of an element is given to its nodes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "scene", derive(serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum MassForm {
    /// ∫ ρ N_a N_b (default).
    #[default]
    Consistent,
    /// Equal shares, a diagonal M.
    Lumped,
}

/// The fixed half-plane n·x ≤ d.
#[derive(Debug, Clone, PartialEq)]
struct Obstacle<T> {
    label: String,
    normal: Vector2<T>,
    distance: T,
}

/// A node that may touch an obstacle.
#[derive(Debug, Clone, Copy)]
struct ContactNode {
    node: usize,
    obstacle: usize,
    interface: usize,
}

/// The mesh of a body with the numbering of its degrees of freedom: what outputs need, beside the state.
#[derive(Debug)]
pub struct Geometry<T> {
    name: String,
    mesh: Arc<Mesh>,
    material: Material<T>,
    /// Degree of freedom of component `dimension·node + axis`, and the component of each degree of freedom.
    dofs: Vec<usize>,
    order: Vec<usize>,
    obstacles: Vec<Obstacle<T>>,
    contacts: Vec<ContactNode>,
}

impl<T: Scalar> Geometry<T> {
    /// Name of the body.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The material.
    pub fn material(&self) -> &Material<T> {
        &self.material
    }

    /// Degree of freedom of a component (0 for x, 1 for y) of a node.
    ///
    /// # Panics
    /// For a node or a component that does not exist.
    pub fn dof(&self, node: usize, axis: usize) -> usize {
        assert!(
            axis < self.mesh.dimension(),
            "component {axis} of a body of dimension {}",
            self.mesh.dimension()
        );
        self.dofs[node * self.mesh.dimension() + axis]
    }

    /// The components (x, y) of a node in a vector over the degrees of freedom; y = 0 in a body of dimension 1.
    pub fn at_node(&self, node: usize, x: &[T]) -> [T; 2] {
        let axis = |axis| if axis < self.mesh.dimension() { x[self.dof(node, axis)] } else { T::zero() };
        [axis(0), axis(1)]
    }

    /// Number of nodes that may touch an obstacle, counted once per obstacle.
    pub fn contact_count(&self) -> usize {
        self.contacts.len()
    }

    fn gap(&self, contact: &ContactNode, q: &[T]) -> T {
        let obstacle = &self.obstacles[contact.obstacle];
        let at = self.mesh.nodes()[contact.node].position.map(lit::<T>);
        let displacement = Vector2::from(self.at_node(contact.node, q));
        // The place first: displacements are small against it, and the gap of a node on the plane is exact.
        (obstacle.normal.dot(&Vector2::from(at)) - obstacle.distance) + obstacle.normal.dot(&displacement)
    }

    /// The nodes that may touch an obstacle with their gaps (m), once per obstacle.
    pub fn gaps(&self, q: &[T]) -> impl Iterator<Item = (usize, T)> {
        self.contacts.iter().map(|contact| (contact.node, self.gap(contact, q)))
    }

    /// Stress (σ_xx, σ_yy, σ_xy) (Pa) and von Mises stress of every element of the body, in its order.
    pub fn stresses(&self, q: &[T]) -> Vec<([T; 3], T)> {
        let displacement = |node: usize| self.at_node(node, q);
        let plane_strain = self.mesh.dimension() == 2 && self.material.hypothesis == Hypothesis::PlaneStrain;
        let each = |element| {
            let [xx, yy, xy] = elements::stress(&self.mesh, element, &self.material, displacement);
            let zz = if plane_strain { self.material.poisson * (xx + yy) } else { T::zero() };
            let squares = (xx - yy) * (xx - yy) + (yy - zz) * (yy - zz) + (zz - xx) * (zz - xx);
            let mises = squares * lit::<T>(0.5) + xy * xy * lit::<T>(3.0);
            ([xx, yy, xy], nalgebra::ComplexField::sqrt(mises))
        };
        self.mesh.body().map(each).collect()
    }
}

/// A linear elastic body against fixed half-planes; q holds displacements, the free ones first, the prescribed ones
/// last.
///
/// Contact frames are (n, t) with t = (n_y, −n_x), and H is constant: the scheme keeps the Delassus operator of all
/// contacts. The gap of a node is n·(X + u) − d.
#[derive(Debug)]
pub struct ElasticBody<T: Scalar> {
    geometry: Arc<Geometry<T>>,
    mass: Symmetric<T>,
    damping: Option<Symmetric<T>>,
    stiffness: Symmetric<T>,
    forces: Forces<T>,
    prescribed: Option<Prescribed<T>>,
    interfaces: usize,
    scales: Scales<T>,
}

impl<T: Scalar> ElasticBody<T> {
    /// Starts a body over a mesh.
    ///
    /// # Errors
    /// [`ElasticError`] for a material out of range.
    pub fn builder(
        name: &str,
        mesh: Mesh,
        material: Material<T>,
    ) -> Result<ElasticBodyBuilder<T>, ElasticError> {
        ElasticBodyBuilder::new(name, mesh, material)
    }

    /// Mesh and numbering, shared with outputs.
    pub fn geometry(&self) -> &Arc<Geometry<T>> {
        &self.geometry
    }

    /// Total mass (kg).
    pub fn total_mass(&self) -> T {
        let mesh = &self.geometry.mesh;
        let volume = mesh.body().map(|element| elements::measure::<T>(mesh, element));
        volume.fold(T::zero(), |sum, x| sum + x)
            * self.geometry.material.density
            * self.geometry.material.section
    }
}

impl<T: Scalar> Dynamics<T> for ElasticBody<T> {
    fn mass(&self) -> &Symmetric<T> {
        &self.mass
    }

    fn damping(&self) -> Option<&Symmetric<T>> {
        self.damping.as_ref()
    }

    fn stiffness(&self) -> Option<&Symmetric<T>> {
        Some(&self.stiffness)
    }

    fn forces(&self) -> &Forces<T> {
        &self.forces
    }

    fn prescribed(&self) -> Option<&Prescribed<T>> {
        self.prescribed.as_ref()
    }

    fn scales(&self, _q: &[T], v: &[T]) -> Scales<T> {
        let speed = nalgebra::RealField::max(self.scales.speed, max_abs(v));
        let fallback = self.geometry.material.bar_wave_speed();
        Scales { speed: if speed > T::zero() { speed } else { fallback }, ..self.scales }
    }
}

impl<T: Scalar, const D: usize> Contacts<T, D> for ElasticBody<T> {
    fn interfaces(&self) -> usize {
        self.interfaces
    }

    fn constant_jacobian(&self) -> bool {
        true
    }

    fn candidates(&mut self, q: &[T], reach: T, out: &mut Vec<Candidate<T>>) {
        for (i, contact) in self.geometry.contacts.iter().enumerate() {
            let gap = self.geometry.gap(contact, q);
            // Written so that a NaN gap is offered, and then refused by name.
            if !(gap > reach) {
                out.push(Candidate { id: ContactId::new(i as u64), interface: contact.interface, gap });
            }
        }
    }

    fn jacobian(&self, contact: ContactId, _q: &[T], out: &mut BlockRows<T, D>) {
        out.start_row();
        let contact = self.geometry.contacts[contact.number() as usize];
        let normal = self.geometry.obstacles[contact.obstacle].normal;
        let frame = [normal, Vector2::new(normal.y, -normal.x)];
        (0..self.geometry.mesh.dimension()).for_each(|axis| {
            let column =
                SVector::<T, D>::from_fn(|row, _| frame.get(row).map_or_else(T::zero, |row| row[axis]));
            out.push(self.geometry.dof(contact.node, axis), column);
        });
    }

    fn gap(&self, contact: ContactId, q: &[T]) -> T {
        self.geometry.gap(&self.geometry.contacts[contact.number() as usize], q)
    }
}

impl<T: Scalar> Describe<T> for ElasticBody<T> {
    fn dof_label(&self, dof: usize) -> String {
        let dimension = self.geometry.mesh.dimension();
        let component = self.geometry.order[dof];
        let tag = self.geometry.mesh.nodes()[component / dimension].tag;
        format!("{}.n{tag}.{}", self.geometry.name, ["x", "y"][component % dimension])
    }

    fn contact_label(&self, contact: ContactId) -> String {
        let contact = self.geometry.contacts[contact.number() as usize];
        let tag = self.geometry.mesh.nodes()[contact.node].tag;
        format!("{}.n{tag}|{}", self.geometry.name, self.geometry.obstacles[contact.obstacle].label)
    }

    fn geometry(&self) -> Option<&Arc<Geometry<T>>> {
        Some(&self.geometry)
    }

    fn contact_node(&self, contact: ContactId) -> Option<usize> {
        self.geometry.contacts.get(contact.number() as usize).map(|contact| contact.node)
    }
}
