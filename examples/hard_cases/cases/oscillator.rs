//! The impact oscillator: a periodic orbit with one impact, and the grazing orbit.

use nalgebra::Vector1;
use nonsmooth::linalg::Symmetric;
use nonsmooth::system::{Forces, Lagrangian, SmoothGap};

use super::support::{Case, Choice, Outcome, Scheme, drive, scheme};

pub(crate) const CASES: &[Case] = &[Case {
    name: "grazing impact, impact oscillator",
    number: "periodic orbit against its exact solution",
    about: "ẍ + 2ζẋ + x = c + cos(ωt + ψ), wall x ≥ 0, D = 1. Impacting: ζ = c = 0, ω = 1.7, e = ½, one impact per \
            period, over 100 periods (its multipliers have modulus e); grazing: ζ = 0.1, c the amplitude, so that the \
            orbit touches the wall at zero speed, over one period with one graze: later ones take the square root of \
            what the first left.",
    peer: "closed form",
    runs: &[("f64", oscillator)],
}];

type Oscillator = Scheme<f64, 1>;

fn build(
    choice: &Choice<'_>,
    (omega, phase, offset, damping, e): (f64, f64, f64, f64, f64),
    h: f64,
    (x, v): (f64, f64),
) -> Result<Oscillator, String> {
    let one = |x: f64| Symmetric::diagonal(vec![x]).expect("finite");
    let force = Forces::constant(vec![offset]).with_varying(move |t, f| f[0] += (omega * t + phase).cos());
    let mut system = Lagrangian::<f64, 1>::new(one(1.0)).with_stiffness(one(1.0)).expect("one");
    if damping > 0.0 {
        system = system.with_damping(one(2.0 * damping)).expect("one");
    }
    let gap = SmoothGap::new(|q: &[f64]| q[0], |_, push| push(0, Vector1::new(1.0)));
    let system = system.with_forces(force).expect("one").with_contact(0, gap).with_scales(1.0, 1.0);
    scheme::<f64, 1, _>(choice, system, (e, 0.0), h, 1e-12, vec![x], vec![v])
}

fn oscillator(choice: &Choice<'_>) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    // x(0) = x(T) = 0, ẋ(0) = v₀, ẋ(T) = −v₀/e, x = a cos t + b sin t + P cos ωt − Q sin ωt:
    // a = −P = v₀ (1 + 1/e) sin T/(2 (1 − cos T)), b = v₀ (1 + 1/e)/2, ωQ = b − v₀, P² + Q² = B².
    let (omega, e) = (1.7_f64, 0.5);
    let period = std::f64::consts::TAU / omega;
    let amplitude = 1.0 / (1.0 - omega * omega);
    let sum = 0.5 * (1.0 + 1.0 / e);
    let a = sum * period.sin() / (1.0 - period.cos());
    let q = (sum - 1.0) / omega;
    let speed = amplitude.abs() / a.hypot(q);
    let (p, q) = (-a * speed, q * speed);
    // P = B cos ψ, Q = B sin ψ.
    let phase = (q / amplitude).atan2(p / amplitude);
    let steps = if choice.full { 20_000 } else { 2_000 };
    let periods = if choice.full { 100 } else { 20 };
    let h = period / f64::from(steps);
    let mut orbit = build(choice, (omega, phase, 0.0, 0.0, e), h, (0.0, speed))?;
    let (mut rebound, mut impacts) = (0.0, 0);
    drive(&mut orbit, steps as usize * periods, &mut outcome, |scheme| {
        if let Some(contact) = scheme.last_step().contacts.iter().find(|c| c.percussion[0] > 0.0) {
            (rebound, impacts) = (contact.after[0], impacts + 1);
        }
    })?;
    outcome.near("impacts per period", f64::from(impacts) / periods as f64, 1.0, 1.0 / periods as f64);
    // The place of an impact within its step: h times accelerations of order one, amplified by the stable orbit.
    outcome.near(format!("rebound (m/s), h = {h:.1e}"), rebound, speed, 20.0 * h);

    let (omega, damping) = (2.0_f64, 0.1);
    let (real, imaginary) = (1.0 - omega * omega, 2.0 * damping * omega);
    let amplitude = 1.0 / real.hypot(imaginary);
    let lag = imaginary.atan2(real);
    let period = std::f64::consts::TAU / omega;
    let exact = move |t: f64| {
        let angle = omega * t - lag;
        (amplitude + amplitude * angle.cos(), -amplitude * omega * angle.sin())
    };
    for refine in [1, 4] {
        let steps = if choice.full { 5_000 } else { 500 } * refine;
        let h = period / f64::from(steps);
        let mut orbit = build(choice, (omega, 0.0, amplitude, damping, e), h, exact(0.0))?;
        let mut worst = 0.0_f64;
        drive(&mut orbit, steps as usize, &mut outcome, |scheme| {
            let state = scheme.state();
            worst = worst.max((state.q[0] - exact(state.time).0).abs());
        })?;
        // A graze of depth O(h²) rebounds at O(h).
        outcome.small(format!("grazing: deviation (m), h = {h:.1e}"), worst, h);
    }
    Ok(outcome)
}
