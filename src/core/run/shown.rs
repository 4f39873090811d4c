//! Which degrees of freedom and which contact the figures show.

use crate::contact::ContactId;
use crate::scene::{Scene, SceneError};
use crate::simulate::Simulation;

/// Bodies up to which every pair is looked at when the first contact is sought.
const FEW_BODIES: usize = 200;

/// The degrees of freedom and the contact that figures show.
pub(super) fn shown(
    scene: &Scene,
    simulation: &mut dyn Simulation,
) -> Result<(Vec<usize>, Option<ContactId>), SceneError> {
    let unknown = |place: &str, name: &String, known: Vec<String>| SceneError::UnknownName {
        place: place.into(),
        name: name.clone(),
        known: known.join(", "),
    };
    let bodies: Vec<&String> = match &scene.space {
        Some(space) => space.bodies.iter().map(|body| &body.name).collect(),
        None => scene.bodies.iter().map(|body| &body.name).collect(),
    };
    let body = match &scene.output.figure_body {
        None => 0,
        Some(name) => bodies.iter().position(|&body| body == name).ok_or_else(|| {
            unknown("output.figure_body", name, bodies.iter().take(20).map(|&b| b.clone()).collect())
        })?,
    };
    let few = bodies.len() <= FEW_BODIES && scene.space.is_none() || scene.output.figure_contact.is_some();
    let candidates = simulation.candidates(if few { f64::INFINITY } else { 0.0 });
    let contact = match &scene.output.figure_contact {
        // Bodies in space have thousands that never touch: none stands for all.
        None if scene.space.is_some() => None,
        None => candidates.iter().map(|&(id, _)| id).min(),
        Some(name) => {
            let found = candidates.iter().find(|(_, label)| label == name).map(|&(id, _)| id);
            let known = || candidates.iter().take(20).map(|(_, label)| label.clone()).collect();
            Some(found.ok_or_else(|| unknown("output.figure_contact", name, known()))?)
        }
    };
    if scene.space.is_some() {
        return Ok(((6 * body..6 * body + 3).collect(), contact));
    }
    if let Some(lagrangian) = &scene.lagrangian {
        return Ok(((0..lagrangian.coordinates.len().min(3)).collect(), contact));
    }
    if scene.solid.is_none() {
        return Ok(((3 * body..3 * body + 3).collect(), contact));
    }
    // Of an elastic body, what the contact moves.
    Ok((contact.map(|contact| simulation.moved_by(contact)).unwrap_or_default(), contact))
}
