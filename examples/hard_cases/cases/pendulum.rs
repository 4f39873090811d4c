//! Kane's double pendulum through many impacts, as a nonlinear Lagrangian system.

use super::double_pendulum::{RATES, START, pendulum};
use super::support::{Case, Choice, Outcome, Scheme, drive, scheme};

pub(crate) const CASES: &[Case] = &[Case {
    name: "Kane's double pendulum",
    number: "Newton gains energy, Frémond never; first impact ΔE = +1.361895571782e-2 (Newton), \
             −1.014349887098e-2 J (Frémond), e = μ = ½",
    about: "two rods of 1 kg and 1 m, angles 20° and 30°, rates −0.1 and −0.2 rad/s at the first impact; M(q), V(q), \
            Newton iteration. First impact in a step of 1e-9 s; then 2 s of h = 1e-4 s from the first impact on, `predicted-gap`, e = ½ and 0.7.",
    peer: "Kane & Levinson (1985); Acary & Collins-Craft (2024)",
    runs: &[("f64", kane)],
}];

type Pendulum = Scheme<f64, 2>;

fn start(choice: &Choice<'_>, e: f64, h: f64) -> Result<Pendulum, String> {
    let q = START.map(f64::to_radians).to_vec();
    scheme::<f64, 2, _>(choice, pendulum(G), (e, 0.5), h, 1e-13, q, RATES.to_vec())
}

const G: f64 = 9.81;

fn kane(choice: &Choice<'_>) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    for (e, newton, fremond) in
        [(0.5, 1.361895571782e-2, -1.014349887098e-2), (0.7, 4.074390455345e-2, -8.427108432142e-3)]
    {
        let mut first = start(choice, e, 1e-9)?;
        drive(&mut first, 1, &mut outcome, |_| ())?;
        let balance = &first.last_step().balance;
        let found =
            balance.normal_contact_work + balance.tangential_contact_work + balance.numerical_dissipation;
        // Gravity adds g h = 1e-8 m/s to a velocity of 0.1 m/s, the pendulum has turned by 1e-10 rad.
        match choice.law {
            "newton" => outcome.near(format!("ΔE at the first impact, e = {e} (J)"), found, newton, 1e-8),
            "fremond" => outcome.near(format!("ΔE at the first impact, e = {e} (J)"), found, fremond, 1e-8),
            _ => outcome.note(format!("ΔE at the first impact, e = {e}: {found:.9e} J")),
        }
        run(choice, e, &mut outcome)?;
    }
    Ok(outcome)
}

/// Times and energies above straight down (s, J) from the first impact on, `steps` steps of 1e-4 s with restitution e.
pub(crate) fn energies(choice: &Choice<'_>, e: f64, steps: usize) -> Result<[Vec<f64>; 2], String> {
    let mut scheme = start(choice, e, 1e-4)?;
    let (mut times, mut energies) = (vec![0.0], vec![scheme.last_step().energies.mechanical() + 2.0 * G]);
    drive(&mut scheme, steps, &mut Outcome::default(), |scheme| {
        times.push(scheme.state().time);
        energies.push(scheme.last_step().energies.mechanical() + 2.0 * G);
    })?;
    Ok([times, energies])
}

/// The pendulum with restitution e until it rests on the floor.
fn run(choice: &Choice<'_>, e: f64, outcome: &mut Outcome) -> Result<(), String> {
    let h = 1e-4;
    let mut scheme = start(choice, e, h)?;
    // Above straight down.
    let above = |mechanical: f64| mechanical + 2.0 * G;
    let initial = above(scheme.last_step().energies.mechanical());
    let (mut impacts, mut gain, mut worst, mut imbalance) = (0, f64::MIN, f64::MIN, 0.0_f64);
    let (mut works, mut passes) = (Vec::new(), 0);
    drive(&mut scheme, if choice.full { 20_000 } else { 10_000 }, outcome, |scheme| {
        let step = scheme.last_step();
        // Faster than what falls within a few steps of a contact at rest.
        let hit = step.contacts.iter().any(|c| c.percussion[0] > 0.0 && c.before[0] < -3.0 * G * h);
        impacts += usize::from(hit);
        let work = step.balance.normal_contact_work + step.balance.tangential_contact_work;
        worst = worst.max(work);
        if hit && impacts <= 5 {
            gain = gain.max(work);
            works.push(format!("{work:+.6e}"));
        }
        imbalance = imbalance.max(step.balance.imbalance.abs());
        passes = passes.max(scheme.passes());
    })?;
    let end = above(scheme.last_step().energies.mechanical());
    outcome.at_least(format!("impacts, e = {e}"), impacts as f64, 5.0);
    // 64 ε of the momenta and forces of the equations of motion, times a velocity.
    outcome.small(format!("imbalance of a step, e = {e} (J)"), imbalance, 1e-12);
    if choice.law == "newton" {
        outcome.at_least(format!("largest work of an impact, e = {e} (J)"), gain, 1e-2);
    } else {
        outcome.small(
            format!("largest contact work of a step, e = {e} (J)"),
            worst.max(0.0),
            1e-13 * initial,
        );
    }
    outcome.note(format!("e = {e}: work of the first five impacts {} J", works.join(", ")));
    outcome.note(format!("e = {e}: {impacts} impacts, energy {initial:.6} → {end:.6} J, passes ≤ {passes}"));
    Ok(())
}
