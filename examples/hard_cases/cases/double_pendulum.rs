//! Kane's double pendulum in its two angles (Kane & Levinson 1985).

use nalgebra::{DMatrix, Vector2};
use nonsmooth::system::{NonlinearLagrangian, NonlinearTerms, SmoothGap};

/// Two uniform rods of mass and length 1, hinged to a fixed point and to each other; q: their angles from the vertical.
#[derive(Debug)]
pub(crate) struct DoublePendulum {
    pub(crate) gravity: f64,
}

impl NonlinearTerms<f64> for DoublePendulum {
    fn mass(&self, q: &[f64], out: &mut DMatrix<f64>) {
        let coupling = 0.5 * (q[0] - q[1]).cos();
        out.copy_from_slice(&[4.0 / 3.0, coupling, coupling, 1.0 / 3.0]);
    }

    fn mass_derivative(&self, q: &[f64], i: usize, out: &mut DMatrix<f64>) {
        let slope = -0.5 * (q[0] - q[1]).sin() * if i == 0 { 1.0 } else { -1.0 };
        out.copy_from_slice(&[0.0, slope, slope, 0.0]);
    }

    fn potential(&self, q: &[f64]) -> f64 {
        -self.gravity * (1.5 * q[0].cos() + 0.5 * q[1].cos())
    }

    fn potential_gradient(&self, q: &[f64], out: &mut [f64]) {
        out[0] = self.gravity * 1.5 * q[0].sin();
        out[1] = self.gravity * 0.5 * q[1].sin();
    }
}

/// The pendulum over a floor that its tip touches at (20°, 30°).
pub(crate) fn pendulum(gravity: f64) -> NonlinearLagrangian<f64, 2> {
    let start = START.map(f64::to_radians);
    let height = start[0].cos() + start[1].cos();
    let gap = SmoothGap::new(
        move |q: &[f64]| height - q[0].cos() - q[1].cos(),
        |q, push| {
            push(0, Vector2::new(q[0].sin(), q[0].cos()));
            push(1, Vector2::new(q[1].sin(), q[1].cos()));
        },
    );
    let system = NonlinearLagrangian::new(DoublePendulum { gravity }, &start).expect("a symmetric mass");
    system.with_contact(0, gap).with_scales(1.0, 1.0)
}

/// Angles at the first impact (degrees) and rates (rad/s).
pub(crate) const START: [f64; 2] = [20.0, 30.0];
pub(crate) const RATES: [f64; 2] = [-0.1, -0.2];
