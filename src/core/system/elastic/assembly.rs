//! Assembly of M and K.

use super::elements::{self, consistent_share, measure};
use super::{MassForm, Material};
use crate::linalg::{OperatorError, Symmetric};
use crate::mesh::Mesh;
use crate::scalar::{Scalar, lit};

/// Calls `add(dof, axis)` for every component of `nodes`.
pub(super) fn add_dof_pairs(
    nodes: &[usize],
    dimension: usize,
    dofs: &[usize],
    mut add: impl FnMut(usize, usize),
) {
    for &node in nodes {
        (0..dimension).for_each(|axis| add(dofs[node * dimension + axis], axis));
    }
}

pub(super) fn mass<T: Scalar>(
    mesh: &Mesh,
    material: &Material<T>,
    form: MassForm,
    dofs: &[usize],
) -> Result<Symmetric<T>, OperatorError> {
    let dimension = mesh.dimension();
    let total = |element| material.density * material.section * measure::<T>(mesh, element);
    match form {
        MassForm::Lumped => {
            let mut diagonal = vec![T::zero(); dofs.len()];
            for element in mesh.body() {
                let nodes = element.shape.nodes();
                let share = total(element) / lit::<T>(nodes.len() as f64);
                add_dof_pairs(nodes, dimension, dofs, |dof, _| diagonal[dof] += share);
            }
            Symmetric::diagonal(diagonal)
        }
        MassForm::Consistent => {
            let mut entries = Vec::new();
            for element in mesh.body() {
                let nodes = element.shape.nodes();
                for (i, &a) in nodes.iter().enumerate() {
                    for (j, &b) in nodes.iter().enumerate() {
                        let share = consistent_share(total(element), nodes.len(), i == j);
                        let entry = |axis| (dofs[a * dimension + axis], dofs[b * dimension + axis], share);
                        entries.extend((0..dimension).map(entry));
                    }
                }
            }
            Symmetric::sparse(dofs.len(), &entries)
        }
    }
}

pub(super) fn stiffness<T: Scalar>(
    mesh: &Mesh,
    material: &Material<T>,
    dofs: &[usize],
) -> Result<Symmetric<T>, OperatorError> {
    let dimension = mesh.dimension();
    let mut entries = Vec::new();
    for element in mesh.body() {
        let nodes = element.shape.nodes();
        let dof = |local: usize| dofs[nodes[local / dimension] * dimension + local % dimension];
        elements::stiffness(mesh, element, material, |i, j, k| entries.push((dof(i), dof(j), k)));
    }
    Symmetric::sparse(dofs.len(), &entries)
}
