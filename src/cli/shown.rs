//! Which degrees of freedom and which contact the figures show.

use crate::contact::ContactId;
use crate::linalg::BlockRows;
use crate::scalar::Scalar;
use crate::scene::{Planar, Scene, SceneError};
use crate::system::MechanicalSystem;

/// Bodies up to which every pair is looked at when the first contact is sought.
const FEW_BODIES: usize = 200;

/// The degrees of freedom and the contact that figures show.
pub(super) fn shown<T: Scalar, const D: usize>(
    scene: &Scene,
    scheme: &mut Planar<T, D>,
) -> Result<(Vec<usize>, Option<ContactId>), SceneError> {
    let unknown = |place: &str, name: &String, known: Vec<String>| SceneError::UnknownName {
        place: place.into(),
        name: name.clone(),
        known: known.join(", "),
    };
    let body = match &scene.output.figure_body {
        None => 0,
        Some(name) => scene.bodies.iter().position(|body| &body.name == name).ok_or_else(|| {
            unknown("output.figure_body", name, scene.bodies.iter().map(|b| b.name.clone()).collect())
        })?,
    };
    let few = scene.bodies.len() <= FEW_BODIES || scene.output.figure_contact.is_some();
    let candidates = scheme.candidates(if few { T::infinity_impl() } else { T::zero() }).to_vec();
    let system: &dyn MechanicalSystem<T, D> = scheme.system();
    let contact = match &scene.output.figure_contact {
        None => candidates.iter().map(|candidate| candidate.id).min(),
        Some(name) => {
            let labels: Vec<_> = candidates.iter().map(|c| (c.id, system.contact_label(c.id))).collect();
            let found = labels.iter().find(|(_, label)| label == name).map(|&(id, _)| id);
            let known = || labels.iter().take(20).map(|(_, label)| label.clone()).collect();
            Some(found.ok_or_else(|| unknown("output.figure_contact", name, known()))?)
        }
    };
    if scene.solid.is_none() {
        return Ok(((3 * body..3 * body + 3).collect(), contact));
    }
    // Of an elastic body, what the contact moves.
    let mut row = BlockRows::<T, D>::new();
    if let Some(contact) = contact {
        system.jacobian(contact, &[], &mut row);
    }
    let dofs = if row.rows() > 0 { row.row(0).map(|(dof, _)| dof).collect() } else { Vec::new() };
    Ok((dofs, contact))
}
