//! Kane's double pendulum at the impact of its tip: Newton's law with Coulomb friction creates energy, Frémond's
//! does not (Kane & Levinson, Dynamics: Theory and Applications, 1985; Acary & Collins-Craft 2024).
//!
//! ```text
//! cargo run --release --example kane
//! ```

use nalgebra::{Matrix2, Vector2};
use nonsmooth::cone::{BlockMatrix, ConeProblem, Status, status};
use nonsmooth::contact::pose;
use nonsmooth::laws::{self, Approach, ContactLaw};
use nonsmooth::solver::{self, ConeSolver, Stopping};

/// Two uniform rods, m = 1 kg and L = 1 m each, the first hinged to a fixed point, the second to its end. Both hang,
/// at the angles q from the vertical, and the tip of the second touches the floor.
pub(crate) struct Pendulum {
    mass: Matrix2<f64>,
    jacobian: Matrix2<f64>,
    rates: Vector2<f64>,
}

impl Pendulum {
    /// The configuration q = (20°, 30°) with the rates (−0.1, −0.2) rad/s.
    pub(crate) fn at_the_impact() -> Self {
        let (m, l) = (1.0, 1.0);
        let [a, b] = [20.0_f64.to_radians(), 30.0_f64.to_radians()];
        let coupling = 0.5 * m * l * l * (a - b).cos();
        Self {
            mass: Matrix2::new(4.0 / 3.0 * m * l * l, coupling, coupling, m * l * l / 3.0),
            // g = height of the hinge − L (cos q₁ + cos q₂); the tangent points along x = L (sin q₁ + sin q₂).
            jacobian: Matrix2::new(l * a.sin(), l * b.sin(), l * a.cos(), l * b.cos()),
            rates: Vector2::new(-0.1, -0.2),
        }
    }

    /// W = H M⁻¹ Hᵀ.
    pub(crate) fn delassus(&self) -> Matrix2<f64> {
        let cholesky = self.mass.cholesky().expect("a mass matrix is positive definite");
        let w = self.jacobian * cholesky.solve(&self.jacobian.transpose());
        (w + w.transpose()) * 0.5
    }

    /// u⁻ = H q̇, in the order (N, T).
    pub(crate) fn before(&self) -> Vector2<f64> {
        self.jacobian * self.rates
    }

    /// E⁻, the kinetic energy before the impact.
    pub(crate) fn energy(&self) -> f64 {
        0.5 * self.rates.dot(&(self.mass * self.rates))
    }
}

/// A published impact: law, e, μ and the change of the energy (J).
pub(crate) type Published = (&'static str, f64, f64, f64);

/// The impacts of Kane's pendulum.
pub(crate) const PUBLISHED: [Published; 4] = [
    ("newton", 0.5, 0.5, 1.361895571782e-2),
    ("fremond", 0.5, 0.5, -1.014349887098e-2),
    ("newton", 0.7, 0.5, 4.074390455345e-2),
    ("fremond", 0.7, 0.5, -8.427108432142e-3),
];

/// What an impact does.
pub(crate) struct Outcome {
    pub(crate) after: Vector2<f64>,
    pub(crate) percussion: Vector2<f64>,
    pub(crate) status: Status,
    /// Normal and tangential work ½(u⁺ + u⁻)·p (J).
    pub(crate) work: Vector2<f64>,
}

/// The scheme at θ = ½ over a step that is nothing but the impact: b = u⁻ + δ, K* ∋ Φ(W p + b) ⟂ p ∈ K.
pub(crate) fn impact(
    pendulum: &Pendulum,
    law: &dyn ContactLaw<f64, 2>,
    solver: &mut dyn ConeSolver<f64, 2>,
) -> Result<Outcome, Box<dyn std::error::Error>> {
    let (w, before) = (pendulum.delassus(), pendulum.before());
    let (b, cone) = pose(law, &Approach::impact(before, 0.5), &before)?;
    let problem = ConeProblem::new(BlockMatrix::from_fn(1, |_, _| w), vec![b], vec![cone.friction()])?;
    let mut p = [Vector2::zeros()];
    solver.solve(&problem, &[Vector2::zeros()], &mut p)?;
    let [percussion] = p;
    let after = w * percussion + before;
    let work = ((after + before) * 0.5).component_mul(&percussion);
    Ok(Outcome { after, percussion, status: status(&percussion, cone.friction(), 1e-9), work })
}

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let pendulum = Pendulum::at_the_impact();
    let mut solver = solver::build(solver::DEFAULT, Stopping::to(1e-14))?;
    let pair = |u: Vector2<f64>| format!("{:+.6} {:+.6}", u[0], u[1]);
    println!("Kane's double pendulum at the impact, θ = ½, E⁻ = {:.13} J", pendulum.energy());
    println!("u⁻ = {} m/s in the order (N, T)\n", pair(pendulum.before()));
    println!(
        "{:8} {:>4} {:>4}  {:^19}  {:^19}  {:8}  {:^12}  {:^12}  {:^19}  {:^19}",
        "law", "e", "μ", "u⁺ (m/s)", "p (N s)", "status", "W_N (J)", "W_T (J)", "ΔE (J)", "published ΔE"
    );
    for (name, e, mu, published) in PUBLISHED {
        let law = laws::build(name, &[e, mu])?;
        let Outcome { after, percussion, status, work } = impact(&pendulum, &*law, &mut *solver)?;
        println!(
            "{name:8} {e:>4} {mu:>4}  {}  {}  {:8}  {:+12.5e}  {:+12.5e}  {:+19.12e}  {published:+19.12e}",
            pair(after),
            pair(percussion),
            format!("{status:?}").to_lowercase(),
            work[0],
            work[1],
            work.sum(),
        );
    }
    Ok(())
}
