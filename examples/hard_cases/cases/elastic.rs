//! A stiff elastic block, from soft steps to steps far beyond its waves.

use nalgebra::{SMatrix, SVector, Vector2};
use nonsmooth::linalg::Symmetric;
use nonsmooth::system::{Forces, Lagrangian, SmoothGap};

use super::support::{Case, Choice, Outcome, drive, scheme};

pub(crate) const CASES: &[Case] = &[Case {
    name: "stiff elastic block, h²K/M from 1e-4 to 1e8",
    number: "no loss of the energy sign, no solver failure",
    about: "square of 6 × 6 bilinear elements in plane strain (ν = 0.3), lumped mass, dropped on its lower edge at \
            (1, −1) m/s, e = ½, μ = ½; Young's modulus scaled so that h² k_max/m_min takes the values. Solver \
            tolerance 1e-12. `newton` claims no sign: its largest work is a note.",
    peer: "",
    runs: &[("f64", stiff)],
}];

/// Elements per side.
const N: usize = 6;

/// Stiffness of a unit square element in plane strain, E = 1, ν = 0.3, by 2×2 Gauss points; nodes counterclockwise.
fn element() -> SMatrix<f64, 8, 8> {
    let nu = 0.3;
    let c = 1.0 / ((1.0 + nu) * (1.0 - 2.0 * nu));
    let law = SMatrix::<f64, 3, 3>::new(1.0 - nu, nu, 0.0, nu, 1.0 - nu, 0.0, 0.0, 0.0, 0.5 - nu) * c;
    let point = 0.5 / 3.0_f64.sqrt();
    let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
    let mut stiffness = SMatrix::<f64, 8, 8>::zeros();
    for [sx, sy] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
        let (x, y) = (sx * point, sy * point);
        let mut strain = SMatrix::<f64, 3, 8>::zeros();
        for (i, [cx, cy]) in corners.into_iter().enumerate() {
            // Shape ¼(1 + 4 c_x x)(1 + 4 c_y y).
            let (dx, dy) = (cx * (1.0 + 4.0 * cy * y), cy * (1.0 + 4.0 * cx * x));
            strain[(0, 2 * i)] = dx;
            strain[(1, 2 * i + 1)] = dy;
            (strain[(2, 2 * i)], strain[(2, 2 * i + 1)]) = (dy, dx);
        }
        stiffness += strain.transpose() * law * strain * 0.25;
    }
    stiffness
}

fn stiff(choice: &Choice<'_>) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    let h = 1e-3;
    let nodes = (N + 1) * (N + 1);
    let dofs = 2 * nodes;
    let unit = element();
    let mut mass = vec![0.0; dofs];
    let mut triplets = Vec::new();
    for row in 0..N {
        for column in 0..N {
            let node = |r: usize, c: usize| r * (N + 1) + c;
            let corners =
                [node(row, column), node(row, column + 1), node(row + 1, column + 1), node(row + 1, column)];
            for (i, &a) in corners.iter().enumerate() {
                mass[2 * a] += 0.25;
                mass[2 * a + 1] += 0.25;
                for (j, &b) in corners.iter().enumerate() {
                    for (k, l) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                        triplets.push((2 * a + k, 2 * b + l, unit[(2 * i + k, 2 * j + l)]));
                    }
                }
            }
        }
    }
    let largest = triplets.iter().map(|t| t.2).fold(0.0, f64::max);
    let mut worst = f64::MIN;
    let mut imbalance = 0.0_f64;
    let mut worst_at = 0.0;
    for exponent in [-4, -2, 0, 2, 4, 6, 8] {
        let target = 10.0_f64.powi(exponent);
        // Lightest node ¼, stiffest entry about `largest`: h² E k/m = target.
        let modulus = target * 0.25 / (h * h * largest);
        let scaled: Vec<_> = triplets.iter().map(|&(i, j, x)| (i, j, modulus * x)).collect();
        let weight = mass.iter().enumerate().map(|(i, m)| if i % 2 == 1 { -9.81 * m } else { 0.0 });
        let mut system = Lagrangian::<f64, 2>::new(Symmetric::diagonal(mass.clone()).expect("finite"))
            .with_stiffness(Symmetric::sparse(dofs, &scaled).expect("symmetric"))
            .and_then(|system| system.with_forces(Forces::constant(weight.collect())))
            .expect("sizes agree")
            .with_scales(1.0, 1.0);
        for i in 0..=N {
            let gap = SmoothGap::new(
                move |q: &[f64]| 0.01 + q[2 * i + 1],
                move |_, push: &mut dyn FnMut(usize, SVector<f64, 2>)| {
                    push(2 * i + 1, Vector2::x());
                    push(2 * i, Vector2::y());
                },
            );
            system = system.with_contact(0, gap);
        }
        let v = (0..dofs).map(|i| if i % 2 == 1 { -1.0 } else { 1.0 }).collect();
        let mut scheme = scheme::<f64, 2, _>(choice, system, (0.5, 0.5), h, 1e-12, vec![0.0; dofs], v)?;
        let energy = scheme.last_step().energies.mechanical();
        let steps = if choice.full { 500 } else { 50 };
        drive(&mut scheme, steps, &mut outcome, |scheme| {
            let step = scheme.last_step();
            for contact in &step.contacts {
                let work = (contact.normal_work + contact.tangential_work) / energy;
                if work > worst {
                    (worst, worst_at) = (work, target);
                }
            }
            imbalance = imbalance.max(step.balance.imbalance.abs() / energy);
        })
        .map_err(|error| format!("h²K/M = {target:e}: {error}"))?;
    }
    if choice.law == "newton" {
        outcome.note(format!("largest contact work / E = {worst:.3e} at h²K/M = {worst_at:e}"));
    } else {
        // What a solver leaves: its tolerance times percussion times velocity.
        outcome.small("largest contact work / E", worst.max(0.0), 1e-12);
    }
    // K q loses what its stiffness exceeds the stretch by: ε h²K/M of the energy.
    outcome.note(format!("largest imbalance / E = {imbalance:.1e}"));
    outcome.near("stiffnesses with every step solved", 7.0, 7.0, 0.0);
    Ok(outcome)
}
