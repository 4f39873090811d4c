//! A global problem with its bodies: H and M kept, W never formed.

use nalgebra::SVector;

use super::FclibError;
use super::condense::bodies;
use super::problem::Global;
use crate::cone::{ConeProblem, FactoredDelassus, Form, factored_pays};
use crate::linalg::{BlockRows, Symmetric};

/// Velocities of a rigid body in space and in the plane.
const RIGID: [usize; 2] = [6, 3];

/// The cone problem with W = Hᵀ M⁻¹ H in factored form, b = w + Hᵀ M⁻¹ f; `None` where `form` is left to choose and it does not pay
/// ([`factored_pays`]), or is not possible: bilateral constraints, and an M that is not symmetric or not regular, go the
/// way of condensation, which says what is wrong.
///
/// # Errors
/// [`FclibError::Problem`].
pub(super) fn factored<const D: usize>(
    global: &Global,
    friction: &[f64],
    form: Form,
) -> Result<Option<ConeProblem<f64, D>>, FclibError> {
    let n = global.force.len();
    let pays = form == Form::Factored || factored_pays(n, global.velocity.len());
    if global.bilateral.is_some() || !pays {
        return Ok(None);
    }
    let entries: Vec<_> = global.mass.entries().collect();
    let Ok(mass) = Symmetric::sparse(n, &entries) else { return Ok(None) };
    let jacobian = rows(global, friction.len());
    let Ok(delassus) = FactoredDelassus::new(&jacobian, &mass, block_size::<D>(n, &entries)) else {
        return Ok(None);
    };
    let Ok((free, _)) = bodies(global, &vec![0.0; global.velocity.len()]) else { return Ok(None) };
    let shift = global.velocity.chunks_exact(D).map(SVector::<f64, D>::from_column_slice);
    let b = shift.enumerate().map(|(i, w)| w + jacobian.velocity(i, &free)).collect();
    Ok(Some(ConeProblem::factored(delassus, Form::Factored, b, friction.to_vec())?))
}

/// H, contact by contact.
fn rows<const D: usize>(global: &Global, contacts: usize) -> BlockRows<f64, D> {
    let mut entries: Vec<(usize, usize, usize, f64)> =
        global.directions.entries().map(|(velocity, j, x)| (j / D, velocity, j % D, x)).collect();
    entries.sort_unstable_by_key(|&(contact, velocity, component, _)| (contact, velocity, component));
    let mut rows = BlockRows::new();
    let mut next = entries.into_iter().peekable();
    for contact in 0..contacts {
        rows.start_row();
        while let Some(&(_, velocity, _, _)) = next.peek().filter(|entry| entry.0 == contact) {
            let mut column = SVector::<f64, D>::zeros();
            while let Some((_, _, component, x)) =
                next.next_if(|entry| (entry.0, entry.1) == (contact, velocity))
            {
                column[component] += x;
            }
            rows.push(velocity, column);
        }
    }
    rows
}

/// Velocities per block of M: those of a rigid body where M then is block-diagonal, else those of a point.
fn block_size<const D: usize>(n: usize, mass: &[(usize, usize, f64)]) -> usize {
    let uncoupled = |d: usize| mass.iter().all(|&(i, j, x)| x == 0.0 || i / d == j / d);
    let rigid = RIGID[if D == 2 { 1 } else { 0 }];
    let sizes = [rigid, D, 1].into_iter().filter(|&d| n.is_multiple_of(d));
    let rigid_or_point = sizes.clone().find(|&d| uncoupled(d));
    rigid_or_point.or_else(|| sizes.into_iter().find(|&d| d <= D)).unwrap_or(1)
}
