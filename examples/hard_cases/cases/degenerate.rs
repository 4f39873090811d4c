//! Contacts that say the same thing twice.

use nalgebra::{SVector, Vector1, Vector2, Vector3};
use nonsmooth::linalg::Symmetric;
use nonsmooth::system::{Forces, Lagrangian, SmoothGap};

use super::support::{Case, Choice, Outcome, drive, scheme};

pub(crate) const CASES: &[Case] = &[Case {
    name: "near-parallel and duplicated contacts, W of rank 1",
    number: "solved, or a typed refusal with the reason",
    about: "a mass on one contact given once, and 50 times (D = 1, 2, 3: W of rank 1, 2, 3); normals apart by 1e-2 … \
            1e-12 rad; and a contact whose block W_αα has rank 1, u_T = 2 u_N, with μ = ½.",
    peer: "",
    runs: &[("f64", degenerate)],
}];

/// Velocity after a step of a point mass with the contacts (N, T, …) given by their rows.
fn after<const D: usize>(
    choice: &Choice<'_>,
    rows: Vec<Vec<SVector<f64, D>>>,
    mu: f64,
    v: Vec<f64>,
    outcome: &mut Outcome,
) -> Result<Vec<f64>, String> {
    let n = v.len();
    let mut force = vec![0.0; n];
    force[0] = -10.0;
    let mut system = Lagrangian::<f64, D>::new(Symmetric::diagonal(vec![1.0; n]).expect("finite"))
        .with_forces(Forces::constant(force))
        .expect("sizes agree")
        .with_scales(1.0, 1.0);
    for row in rows {
        let gap = row.clone();
        let gap = SmoothGap::new(
            move |q: &[f64]| gap.iter().zip(q).map(|(h, q)| h[0] * q).sum(),
            move |_, push: &mut dyn FnMut(usize, SVector<f64, D>)| {
                row.iter().enumerate().for_each(|(i, &h)| push(i, h));
            },
        );
        system = system.with_contact(0, gap);
    }
    let mut scheme = scheme::<f64, D, _>(choice, system, (0.0, mu), 1e-2, 1e-12, vec![0.0; n], v)?;
    drive(&mut scheme, 1, outcome, |_| ())?;
    Ok(scheme.state().v.clone())
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |d, (a, b)| f64::max(d, (a - b).abs()))
}

fn degenerate(choice: &Choice<'_>) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    let failed = |what: &str, error: String| format!("{what}: {error}");

    let one = vec![Vector1::new(1.0)];
    let single = after::<1>(choice, vec![one.clone()], 0.0, vec![-1.0], &mut outcome)?;
    let many = after::<1>(choice, vec![one; 50], 0.0, vec![-1.0], &mut outcome)
        .map_err(|e| failed("50 duplicates, D = 1", e))?;
    outcome.small("50 duplicates, D = 1: v − v of one (m/s)", difference(&single, &many), 1e-10);

    let plane = vec![Vector2::x(), Vector2::y()];
    let start = vec![-1.0, 2.0];
    let single = after::<2>(choice, vec![plane.clone()], 0.5, start.clone(), &mut outcome)?;
    let many = after::<2>(choice, vec![plane; 50], 0.5, start.clone(), &mut outcome)
        .map_err(|e| failed("50 duplicates, D = 2", e))?;
    outcome.small("50 duplicates, D = 2: v − v of one (m/s)", difference(&single, &many), 1e-10);

    let space = vec![Vector3::x(), Vector3::y(), Vector3::z()];
    let fast = vec![-1.0, 2.0, 1.0];
    let once = after::<3>(choice, vec![space.clone()], 0.5, fast.clone(), &mut outcome)?;
    let many = after::<3>(choice, vec![space; 50], 0.5, fast, &mut outcome)
        .map_err(|e| failed("50 duplicates, D = 3", e))?;
    outcome.small("50 duplicates, D = 3: v − v of one (m/s)", difference(&once, &many), 1e-10);

    for exponent in [2, 4, 6, 8, 10, 12] {
        let angle = 10.0_f64.powi(-exponent);
        let tilted = |a: f64| vec![Vector2::new(a.cos(), a.sin()), Vector2::new(-a.sin(), a.cos())];
        let v = after::<2>(choice, vec![tilted(angle), tilted(-angle)], 0.5, start.clone(), &mut outcome)
            .map_err(|e| failed(&format!("normals {angle:e} apart"), e))?;
        outcome.small(
            format!("normals 2e-{exponent} rad apart: v − v of one (m/s)"),
            difference(&single, &v),
            10.0 * angle + 1e-10,
        );
    }

    // u_N = v, u_T = 2v: a percussion (n, t) gives n + 2t; with |t| ≤ n/2 the mass cannot be stopped from sliding down
    // the tangent, and sticks at t = 0…: the answer is a solution or a refusal that says why.
    let rank_one = vec![Vector2::new(1.0, 2.0)];
    match after::<2>(choice, vec![rank_one], 0.25, vec![-1.0], &mut outcome) {
        Ok(v) => {
            outcome.small("block of rank 1: u_N (m/s)", v[0].min(0.0), 1e-10);
        }
        Err(error) => {
            let typed = error.contains("residual") || error.contains("contact");
            outcome.near("block of rank 1: refusal with its reason", f64::from(typed), 1.0, 0.0);
            outcome.note(error);
        }
    }
    Ok(outcome)
}
