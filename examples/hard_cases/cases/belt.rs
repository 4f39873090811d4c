//! The capstan: an elastic belt on a cylinder.

use nalgebra::Vector2;
use nonsmooth::linalg::Symmetric;
use nonsmooth::system::{Forces, Lagrangian, SmoothGap};

use super::support::{Case, Choice, Law, Outcome, drive, law, scheme_of, solver};

pub(crate) const CASES: &[Case] = &[Case {
    name: "capstan, elastic belt on a cylinder",
    number: "T₂/T₁ → e^{μφ} with refinement, order stated",
    about: "n nodes with linear bars around φ = π, μ = ½, T₁ = 1 N at one end, a heavy grip drags the other at 1 m/s; \
            θ = 1, e = 0, implicit steps until steady. A polygon of n equal turns has \
            ((1 + μ tan(φ/2n))/(1 − μ tan(φ/2n)))ⁿ exactly, which tends to e^{μφ} with order 2.",
    peer: "Euler–Eytelwein, e^{π/2} = 4.810477",
    runs: &[("f64", capstan)],
}];

const MU: f64 = 0.5;
const STIFFNESS: f64 = 1e3;

/// T₂/T₁ of the belt with `n` nodes in steady sliding.
fn tension_ratio(choice: &Choice<'_>, n: usize, outcome: &mut Outcome) -> Result<f64, String> {
    let turn = std::f64::consts::PI / n as f64;
    let (sin, cos) = (0.5 * turn).sin_cos();
    // Node i: radial 2i, tangential 2i + 1; the grip is the last degree of freedom.
    let dofs = 2 * n + 1;
    let mut bars: Vec<Vec<(usize, f64)>> = (0..n - 1)
        .map(|i| vec![(2 * i, sin), (2 * i + 1, -cos), (2 * i + 2, sin), (2 * i + 3, cos)])
        .collect();
    bars.push(vec![(2 * n - 2, sin), (2 * n - 1, -cos), (2 * n, 1.0)]);
    // The same elongation under the same load, whatever n.
    let stiffness = STIFFNESS * n as f64;
    let mut triplets = Vec::new();
    for bar in &bars {
        for &(i, x) in bar {
            triplets.extend(bar.iter().map(|&(j, y)| (i, j, stiffness * x * y)));
        }
    }
    let mut mass = vec![1e-3 / n as f64; dofs];
    mass[2 * n] = 1e9;
    let mut force = vec![0.0; dofs];
    (force[0], force[1]) = (-sin, -cos);
    let mut system = Lagrangian::<f64, 2>::new(Symmetric::diagonal(mass).expect("finite"))
        .with_stiffness(Symmetric::sparse(dofs, &triplets).expect("symmetric"))
        .and_then(|system| system.with_forces(Forces::constant(force)))
        .expect("sizes agree")
        .with_scales(1.0, 1.0);
    for i in 0..n {
        let gap = SmoothGap::new(
            move |q: &[f64]| q[2 * i],
            move |_, push| {
                push(2 * i, Vector2::x());
                push(2 * i + 1, Vector2::y());
            },
        );
        system = system.with_contact(0, gap);
    }
    let mut v = vec![0.0; dofs];
    v[2 * n] = 1.0;
    let laws: Vec<Law<f64, 2>> = vec![law(choice, 0.0, MU)];
    let mut scheme =
        scheme_of(system, laws, solver(choice, 1e-12), (1.0, 1e-3), (None, false), (vec![0.0; dofs], v))?;
    let tension =
        |q: &[f64], bar: &[(usize, f64)]| stiffness * bar.iter().map(|&(i, x)| x * q[i]).sum::<f64>();
    let (mut ratio, mut change) = (0.0, f64::INFINITY);
    // The belt first slackens and tightens, node after node.
    for _ in 0..40 {
        drive(&mut scheme, 25, outcome, |_| ())?;
        let next = tension(&scheme.state().q, &bars[n - 1]);
        change = (next - ratio).abs();
        ratio = next;
        if change < 1e-10 {
            break;
        }
    }
    if change < 1e-8 {
        Ok(ratio)
    } else {
        Err(format!("n = {n}: not steady, T₂/T₁ still changes by {change:e}"))
    }
}

fn capstan(choice: &Choice<'_>) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    let limit = (MU * std::f64::consts::PI).exp();
    let mut errors = Vec::new();
    let counts: &[usize] = if choice.full { &[8, 16, 32, 64] } else { &[4, 8, 16] };
    for &n in counts {
        let ratio = tension_ratio(choice, n, &mut outcome)?;
        let x = MU * (0.5 * std::f64::consts::PI / n as f64).tan();
        let polygon = ((1.0 + x) / (1.0 - x)).powi(n as i32);
        outcome.near(format!("T₂/T₁, {n} nodes"), ratio, polygon, 1e-7);
        errors.push(ratio - limit);
    }
    let last = errors.len() - 1;
    outcome.near("order towards e^{μφ}", (errors[last - 1] / errors[last]).log2(), 2.0, 0.05);
    outcome.note(format!("e^{{μφ}} = {limit:.6}, error at {} nodes {:.2e}", counts[last], errors[last]));
    Ok(outcome)
}
