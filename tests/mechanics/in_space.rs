//! Schemes over bodies in space, for tests.

use nonsmooth::laws::{ContactLaw, Fremond, NewtonCoulomb};
use nonsmooth::scheme::{Settings, ThetaScheme};
use nonsmooth::solver::{self, Stopping};
use nonsmooth::system::SpatialBodies;

/// As many equal laws.
pub(crate) fn laws(name: &str, e: f64, friction: f64, count: usize) -> Vec<Box<dyn ContactLaw<f64, 3>>> {
    let law = || -> Box<dyn ContactLaw<f64, 3>> {
        match name {
            "newton" => Box::new(NewtonCoulomb::new(e, friction).expect("in range")),
            _ => Box::new(Fremond::new(e, friction).expect("in range")),
        }
    };
    (0..count).map(|_| law()).collect()
}

/// A scheme of (θ, h) that solves to 1e-12, in the state (q, v).
pub(crate) fn scheme(
    system: SpatialBodies<f64>,
    laws: Vec<Box<dyn ContactLaw<f64, 3>>>,
    (theta, step): (f64, f64),
    (q, v): (Vec<f64>, Vec<f64>),
) -> ThetaScheme<f64, 3> {
    let solver = solver::build("hybrid", Stopping::to(1e-12)).expect("registered");
    ThetaScheme::new(Box::new(system), laws, solver, Settings::new(theta, step), 0.0, q, v).expect("valid")
}
