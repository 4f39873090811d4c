//! Building an elastic body: boundary conditions by the names of groups, every number checked where it enters.

use std::sync::Arc;

use nalgebra::Vector2;

use super::assembly::{add_dof_pairs, mass, stiffness};
use super::elements::measure;
use super::{ContactNode, ElasticBody, Geometry, MassForm, Material, Obstacle};
use crate::linalg::{Symmetric, max_abs};
use crate::mesh::{Mesh, MeshError};
use crate::scalar::{Scalar, all_finite, lit, to_f64};
use crate::system::{Forces, Prescribed, Scales, Signal, SystemError};

/// Why an elastic body could not be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ElasticError {
    /// The mesh, or a group named for a boundary condition.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A number out of range, or an operator that is not one.
    #[error(transparent)]
    System(#[from] SystemError),
    /// One component of one node is prescribed twice with different motions.
    #[error("component {axis} of node {node} is prescribed twice, by `{group}` and by a group before it")]
    PrescribedTwice {
        /// Tag of the node.
        node: u64,
        /// `x` or `y`.
        axis: char,
        /// The later group.
        group: String,
    },
    /// A component that the body does not have.
    #[error("{what}: a body of dimension 1 moves along x only")]
    NoSuchAxis {
        /// What asked for it.
        what: String,
    },
}

/// Component of a displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "scene", derive(serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Axis {
    /// Along x.
    X,
    /// Along y.
    Y,
}

/// Builder of [`ElasticBody`].
#[derive(Debug, Clone)]
pub struct ElasticBodyBuilder<T: Scalar> {
    name: String,
    mesh: Arc<Mesh>,
    material: Material<T>,
    mass: MassForm,
    rayleigh: [T; 2],
    damping: Vec<(usize, usize, T)>,
    gravity: [T; 2],
    tractions: Vec<(String, [T; 2], Signal<T>)>,
    /// Motion of each component of each node.
    prescribed: Vec<Option<(T, usize)>>,
    signals: Vec<Signal<T>>,
    obstacles: Vec<Obstacle<T>>,
    contacts: Vec<ContactNode>,
    interfaces: usize,
}

fn finite<T: Scalar>(what: &str, values: &[T]) -> Result<(), SystemError> {
    match values.iter().find(|x| !all_finite([*x])) {
        Some(&x) => Err(SystemError::OutOfRange { what: what.into(), value: to_f64(x), range: "finite" }),
        None => Ok(()),
    }
}

impl<T: Scalar> ElasticBodyBuilder<T> {
    pub(super) fn new(name: &str, mesh: Mesh, material: Material<T>) -> Result<Self, ElasticError> {
        material.check()?;
        let zero = T::zero();
        let components = mesh.nodes().len() * mesh.dimension();
        Ok(Self {
            name: name.into(),
            mesh: Arc::new(mesh),
            material,
            mass: MassForm::default(),
            rayleigh: [zero; 2],
            damping: Vec::new(),
            gravity: [zero; 2],
            tractions: Vec::new(),
            prescribed: vec![None; components],
            signals: Vec::new(),
            obstacles: Vec::new(),
            contacts: Vec::new(),
            interfaces: 0,
        })
    }

    /// Consistent (default) or lumped mass.
    pub fn mass(&mut self, form: MassForm) {
        self.mass = form;
    }

    /// Rayleigh damping C = α M + β K, with α (1/s) and β (s) ≥ 0; 0 and 0 by default: no C at all.
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`].
    pub fn rayleigh(&mut self, alpha: T, beta: T) -> Result<(), ElasticError> {
        for (what, value) in [("the Rayleigh coefficient α", alpha), ("the Rayleigh coefficient β", beta)] {
            if !(value >= T::zero() && all_finite([&value])) {
                let (what, value) = (what.into(), to_f64(value));
                return Err(SystemError::OutOfRange { what, value, range: "finite and ≥ 0" }.into());
            }
        }
        self.rayleigh = [alpha, beta];
        Ok(())
    }

    /// Adds any damping: entries (a, b, c_ab) (N s/m) of a symmetric positive semidefinite C over components of
    /// nodes, numbered `dimension·node + axis` in the order of the mesh.
    ///
    /// # Errors
    /// [`SystemError::Unknown`], [`SystemError::OutOfRange`]. Symmetry is checked when the body is built.
    pub fn damping(&mut self, entries: &[(usize, usize, T)]) -> Result<(), ElasticError> {
        let count = self.prescribed.len();
        for &(a, b, value) in entries {
            let what = "component of a node";
            if let Some(&index) = [a, b].iter().find(|&&index| index >= count) {
                return Err(SystemError::Unknown { what, index, count }.into());
            }
            finite("a damping coefficient", &[value])?;
        }
        self.damping.extend_from_slice(entries);
        Ok(())
    }

    /// Acceleration of gravity (m/s²).
    ///
    /// # Errors
    /// [`SystemError::OutOfRange`]; [`ElasticError::NoSuchAxis`] for a y component on a bar.
    pub fn gravity(&mut self, g: [T; 2]) -> Result<(), ElasticError> {
        finite("gravity", &g)?;
        self.check_axes("gravity", &g)?;
        self.gravity = g;
        Ok(())
    }

    fn check_axes(&self, what: &str, vector: &[T; 2]) -> Result<(), ElasticError> {
        if self.mesh.dimension() == 1 && vector[1] != T::zero() {
            return Err(ElasticError::NoSuchAxis { what: what.into() });
        }
        Ok(())
    }

    /// Adds the traction `stress`·signal(t) (Pa) on the lines of a group (its points, in a body of dimension 1).
    ///
    /// # Errors
    /// [`MeshError`] for the group, [`SystemError::OutOfRange`], [`ElasticError::NoSuchAxis`].
    pub fn traction(&mut self, group: &str, stress: [T; 2], signal: Signal<T>) -> Result<(), ElasticError> {
        self.mesh.group_elements(group, self.mesh.dimension() - 1)?;
        finite("a traction", &stress)?;
        self.check_axes(&format!("the traction on `{group}`"), &stress)?;
        signal.check()?;
        self.tractions.push((group.into(), stress, signal));
        Ok(())
    }

    /// Prescribes the displacement `value`·signal(t) (m) of one component of every node of a group.
    ///
    /// # Errors
    /// [`MeshError`] for the group, [`SystemError::OutOfRange`], [`ElasticError::PrescribedTwice`] where a node
    /// would have two different motions.
    pub fn prescribe(
        &mut self,
        group: &str,
        axis: Axis,
        value: T,
        signal: Signal<T>,
    ) -> Result<(), ElasticError> {
        finite("a prescribed displacement", &[value])?;
        signal.check()?;
        let dimension = self.mesh.dimension();
        if dimension == 1 && axis == Axis::Y {
            let what = format!("the displacement prescribed on `{group}`");
            return Err(ElasticError::NoSuchAxis { what });
        }
        let signal = self.signals.iter().position(|known| *known == signal).unwrap_or_else(|| {
            self.signals.push(signal);
            self.signals.len() - 1
        });
        for node in self.mesh.group_nodes(group)? {
            let motion = &mut self.prescribed[node * dimension + axis as usize];
            if motion.is_some_and(|known| known != (value, signal)) {
                let (node, axis) = (self.mesh.nodes()[node].tag, ['x', 'y'][axis as usize]);
                return Err(ElasticError::PrescribedTwice { node, axis, group: group.into() });
            }
            *motion = Some((value, signal));
        }
        Ok(())
    }

    /// A new interface; the scheme wants one law for each.
    pub fn interface(&mut self) -> usize {
        self.interfaces += 1;
        self.interfaces - 1
    }

    /// Lets every node of `group` meet the fixed half-plane through `point` with outward `normal` (any length > 0)
    /// under the law of `interface`. Nodes that meet the same obstacle already keep their interface.
    ///
    /// # Errors
    /// [`MeshError`] for the group, [`SystemError`], [`ElasticError::NoSuchAxis`].
    pub fn contact(
        &mut self,
        group: &str,
        obstacle: &str,
        point: [T; 2],
        normal: [T; 2],
        interface: usize,
    ) -> Result<(), ElasticError> {
        if interface >= self.interfaces {
            let (what, count) = ("interface", self.interfaces);
            return Err(SystemError::Unknown { what, index: interface, count }.into());
        }
        finite(&format!("the point of `{obstacle}`"), &point)?;
        let normal = Vector2::from(normal);
        let length = normal.norm();
        if !(length > T::zero() && all_finite([&length])) {
            let what = format!("the length of the normal of `{obstacle}`");
            let value = to_f64(length);
            return Err(SystemError::OutOfRange { what, value, range: "finite and > 0" }.into());
        }
        let normal = normal / length;
        self.check_axes(&format!("the normal of `{obstacle}`"), &normal.into())?;
        let distance = normal.dot(&Vector2::from(point));
        let obstacle = Obstacle { label: obstacle.into(), normal, distance };
        let index = self.obstacles.iter().position(|known| *known == obstacle).unwrap_or_else(|| {
            self.obstacles.push(obstacle);
            self.obstacles.len() - 1
        });
        for node in self.mesh.group_nodes(group)? {
            if !self.contacts.iter().any(|known| known.node == node && known.obstacle == index) {
                self.contacts.push(ContactNode { node, obstacle: index, interface });
            }
        }
        Ok(())
    }

    /// The body.
    ///
    /// # Errors
    /// [`SystemError`].
    pub fn build(self) -> Result<ElasticBody<T>, ElasticError> {
        let (mesh, material) = (&self.mesh, &self.material);
        let (dimension, components) = (mesh.dimension(), self.prescribed.len());
        let free = self.prescribed.iter().filter(|motion| motion.is_none()).count();
        let (mut dofs, mut order, mut motions) = (vec![0; components], vec![0; components], Vec::new());
        let mut next = [0, free];
        for (component, motion) in self.prescribed.iter().enumerate() {
            let slot = &mut next[usize::from(motion.is_some())];
            (dofs[component], order[*slot]) = (*slot, component);
            *slot += 1;
            motions.extend(*motion);
        }
        let operator = |what| move |source| SystemError::Operator { what, source };
        let mass = mass(mesh, material, self.mass, &dofs).map_err(operator("mass"))?;
        let stiffness = stiffness(mesh, material, &dofs).map_err(operator("stiffness"))?;
        let damping = self.damping_operator(&mass, &stiffness, &dofs)?;

        let mut weight = vec![T::zero(); components];
        for element in mesh.body() {
            let nodes = element.shape.nodes();
            let share = material.density * material.section * measure::<T>(mesh, element)
                / lit::<T>(nodes.len() as f64);
            add_dof_pairs(nodes, dimension, &dofs, |dof, axis| weight[dof] += share * self.gravity[axis]);
        }
        let mut varying = Vec::new();
        for (group, stress, signal) in &self.tractions {
            let mut load = vec![T::zero(); components];
            for element in mesh.group_elements(group, dimension - 1)? {
                let nodes = element.shape.nodes();
                let share = material.section * measure::<T>(mesh, &element) / lit::<T>(nodes.len() as f64);
                add_dof_pairs(nodes, dimension, &dofs, |dof, axis| load[dof] += share * stress[axis]);
            }
            if *signal == Signal::Constant {
                weight.iter_mut().zip(&load).for_each(|(f, &load)| *f += load);
            } else {
                let entries = load.into_iter().enumerate().filter(|&(_, x)| x != T::zero());
                varying.push((signal.clone(), entries.collect::<Vec<_>>()));
            }
        }
        let scales = self.scales();
        let constant = Forces::constant(weight);
        let forces =
            varying.into_iter().fold(constant, |sum, (signal, entries)| sum.with_load(signal, entries));
        let prescribed =
            (free < components).then(|| Prescribed::new(free, motions, self.signals)).transpose()?;
        let geometry = Geometry {
            name: self.name,
            mesh: self.mesh,
            material: self.material,
            dofs,
            order,
            obstacles: self.obstacles,
            contacts: self.contacts,
        };
        Ok(ElasticBody {
            geometry: Arc::new(geometry),
            mass,
            damping,
            stiffness,
            forces,
            prescribed,
            interfaces: self.interfaces,
            scales,
        })
    }

    fn damping_operator(
        &self,
        mass: &Symmetric<T>,
        stiffness: &Symmetric<T>,
        dofs: &[usize],
    ) -> Result<Option<Symmetric<T>>, ElasticError> {
        let [alpha, beta] = self.rayleigh;
        let mut damping: Option<Symmetric<T>> = None;
        let mut add = |factor: T, operator: &Symmetric<T>| {
            let zero = || Symmetric::Diagonal(vec![T::zero(); operator.size()]);
            damping = Some(damping.take().unwrap_or_else(zero).plus(factor, operator));
        };
        if alpha > T::zero() {
            add(alpha, mass);
        }
        if beta > T::zero() {
            add(beta, stiffness);
        }
        if !self.damping.is_empty() {
            let entries: Vec<_> = self.damping.iter().map(|&(a, b, c)| (dofs[a], dofs[b], c)).collect();
            let operator = Symmetric::sparse(dofs.len(), &entries)
                .map_err(|source| SystemError::Operator { what: "damping", source })?;
            add(T::one(), &operator);
        }
        Ok(damping)
    }

    /// Length: the body's. Speed: the largest that its loads, prescribed displacements and gravity impose.
    fn scales(&self) -> Scales<T> {
        let extent = self.mesh.extent();
        let length: T = lit(extent[0].max(extent[1]));
        let wave = self.material.bar_wave_speed();
        let larger = nalgebra::RealField::max;
        let mut speed = T::zero();
        for (_, stress, signal) in &self.tractions {
            let stress = Vector2::from(*stress).norm() * signal.amplitude();
            speed = larger(speed, stress / (self.material.density * wave));
        }
        let motion = |&(value, signal): &(T, usize)| value * self.signals[signal].amplitude();
        let motions: Vec<T> = self.prescribed.iter().flatten().map(motion).collect();
        speed = larger(speed, max_abs(&motions) * wave / length);
        speed = larger(speed, nalgebra::ComplexField::sqrt(Vector2::from(self.gravity).norm() * length));
        Scales { length, speed }
    }
}
