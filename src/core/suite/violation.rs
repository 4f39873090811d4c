//! A claim is sharp: outside its interval, or without one, energy is created.

use nalgebra::SVector;
use proptest::collection::vec;
use proptest::strategy::{Strategy, ValueTree};

use super::strategies::asked;
use super::{Draw, RandomSystem, Suite, SuiteFailure, random_system};
use crate::cone::solve_one_contact;
use crate::contact::pose;
use crate::laws::{Approach, ContactLaw};

/// One-contact systems searched for a violation.
const SEARCHED: usize = 20_000;

/// Created energy, relative to that of the state, that round-off cannot explain.
const CREATED: f64 = 1e-9;

/// A system at an impact in which a law creates energy.
#[derive(Debug, Clone)]
pub struct Violation<const D: usize> {
    /// The system.
    pub system: RandomSystem<D>,
    /// θ.
    pub theta: f64,
    /// Percussion p.
    pub percussion: SVector<f64, D>,
    /// Contact work u_{k+θ}·p.
    pub contact_work: f64,
    /// Contact work plus (½−θ)‖v_{k+1}−v_k‖²_M: what the step adds beyond the external work.
    pub created: f64,
}

/// Searches random systems of one contact for a step in which contact work, or contact work and numerical
/// dissipation together, are positive. The search is the same in every run.
pub fn find_violation<const D: usize>(law: &dyn ContactLaw<f64, D>, theta: f64) -> Option<Violation<D>> {
    let mut runner = Suite::default().runner();
    let systems = random_system::<D>(1);
    (0..SEARCHED).find_map(|_| {
        let system = systems.new_tree(&mut runner).ok()?.current();
        let violation = evaluate(law, theta, system)?;
        let energy = |v: &[f64]| v.iter().zip(&violation.system.mass).map(|(v, m)| m * v * v).sum::<f64>();
        let scale = energy(&violation.system.before) + energy(&violation.system.free);
        (violation.created.max(violation.contact_work) > CREATED * scale).then_some(violation)
    })
}

fn evaluate<const D: usize>(
    law: &dyn ContactLaw<f64, D>,
    theta: f64,
    system: RandomSystem<D>,
) -> Option<Violation<D>> {
    let (before, free) = (system.local_before()[0], system.local_free()[0]);
    let (b, cone) = pose(law, &asked(law, Approach::impact(before, theta)), &free).ok()?;
    let w = *system.delassus().diagonal(0).expect("a contact has a diagonal block");
    let percussion = solve_one_contact(&w, &b, cone);
    let after = w * percussion + free;
    let contact_work = (before * (1.0 - theta) + after * theta).dot(&percussion);
    let mut impulse = vec![0.0; system.mass.len()];
    system.jacobian.add_transpose(0, &percussion, &mut impulse);
    let change = |i: usize| system.free[i] + impulse[i] / system.mass[i] - system.before[i];
    let square: f64 = (0..impulse.len()).map(|i| system.mass[i] * change(i) * change(i)).sum();
    let created = contact_work + (0.5 - theta) * square;
    Some(Violation { system, theta, percussion, contact_work, created })
}

/// Instances of a law violate dissipation outside the interval they claim, and everywhere if they claim none; a
/// claim wider than the truth fails [`check_dissipation`](super::check_dissipation), one that is too narrow fails
/// here.
///
/// # Errors
/// [`SuiteFailure`] with the θ at which no violation was found.
pub fn check_claim_is_sharp<const D: usize>(
    suite: &Suite,
    parameters: usize,
    draw: &Draw<'_, D>,
) -> Result<(), SuiteFailure> {
    let mut runner = suite.runner();
    // Away from the ends of the parameter ranges, where a law may coincide with another one that does claim.
    let unit = vec(0.2..0.8, parameters);
    for _ in 0..8 {
        let unit = unit.new_tree(&mut runner).expect("a range has values").current();
        let law = draw(&unit);
        let outside = match law.dissipative_theta() {
            None => vec![0.5, 0.95],
            Some(claim) => {
                let (low, high) = (*claim.start(), *claim.end());
                let mut outside = vec![0.6 * low];
                outside.extend((high < 0.99).then_some(0.4 * high + 0.6));
                outside
            }
        };
        for theta in outside {
            if find_violation(&*law, theta).is_none() {
                let case = format!("{law:?} creates no energy at θ = {theta}, outside its claim");
                let property = "a claim is sharp";
                return Err(SuiteFailure { property, dimension: D, solver: "–".into(), case });
            }
        }
    }
    Ok(())
}
