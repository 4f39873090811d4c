//! Scenes that tests and benches share: the impacting stick, and piles of discs in a box.

#![allow(dead_code)]

use nonsmooth::laws::{self, ContactLaw};
use nonsmooth::scalar::{Scalar, lit};
use nonsmooth::scheme::{Activation, ActivationRule, Settings, ThetaScheme};
use nonsmooth::solver::{self, ConeSolver, Stopping};
use nonsmooth::system::{Body, RigidBodies};

/// A scheme over rigid bodies, the law and the solver chosen by name.
pub(crate) type Scheme<T, const D: usize> = ThetaScheme<T, D>;

fn law<T: Scalar, const D: usize>(name: &str, restitution: f64, friction: f64) -> Box<dyn ContactLaw<T, D>> {
    laws::build(name, &[lit(restitution), lit(friction)]).expect("a registered law")
}

fn solver<T: Scalar, const D: usize>(name: &str, tolerance: Option<f64>) -> Box<dyn ConeSolver<T, D>> {
    let stopping = tolerance.map_or_else(Stopping::default, |tolerance| Stopping::to(lit(tolerance)));
    solver::build(name, stopping).expect("a registered solver")
}

/// The impacting stick of Acary & Collins-Craft (2024), section 5.1: l = 1 m, m = 1 kg, e = 1, μ = 0.01 (0 if D = 1),
/// θ = ½, h = 1e-4 s; it falls on its tip at 0.0603 s and again at 0.163 s.
pub(crate) fn stick<T: Scalar, const D: usize>(law_name: &str, solver_name: &str) -> Scheme<T, D> {
    let mut builder = RigidBodies::<T>::builder();
    let (tip, floor) = (builder.group(), builder.group());
    let body = Body { mass: lit(1.0), inertia: lit(1.0 / 12.0) };
    let stick = builder.body("stick", body).expect("valid");
    builder.disc("tip", stick, [lit(0.0), lit(-0.5)], lit(0.0), tip).expect("valid");
    builder.half_plane("floor", [lit(0.0); 2], [lit(0.0), lit(1.0)], floor).expect("valid");
    builder.gravity([lit(0.0), lit(-10.0)]).expect("valid");
    builder.interface(tip, floor).expect("valid");
    let friction = if D == 1 { 0.0 } else { 0.01 };
    let reach = 0.5 * std::f64::consts::FRAC_1_SQRT_2;
    let q = [reach, reach + 0.01, std::f64::consts::FRAC_PI_4].map(lit).to_vec();
    let v = [-0.5, 0.1, 0.1].map(lit).to_vec();
    let laws = vec![law(law_name, 1.0, friction)];
    let settings = Settings::new(lit(0.5), lit(1e-4));
    let system = builder.build().expect("one body");
    ThetaScheme::new(Box::new(system), laws, solver(solver_name, None), settings, lit(0.0), q, v)
        .expect("valid")
}

/// Discs of radius 1 cm and 1 kg in hexagonal rows, `wide` and `wide` − 1 in turn, `high` rows, in a box; they start
/// a hair apart, fall together (e = 0, θ = 1, h = 1e-3 s) and rest.
pub(crate) fn pile<T: Scalar, const D: usize>(
    wide: usize,
    high: usize,
    friction: f64,
    solver_name: &str,
    tolerance: Option<f64>,
) -> Scheme<T, D> {
    let radius = 0.01;
    let mut builder = RigidBodies::<T>::builder();
    let (discs, walls) = (builder.group(), builder.group());
    let inertia = 0.5 * radius * radius;
    let (mut q, mut v) = (Vec::new(), Vec::new());
    for row in 0..high {
        let count = wide - row % 2;
        for column in 0..count {
            let name = format!("disc {row} {column}");
            let body = Body { mass: lit(1.0), inertia: lit(inertia) };
            let body = builder.body(&name, body).expect("valid");
            builder.disc(&name, body, [lit(0.0); 2], lit(radius), discs).expect("valid");
            let x = radius * (1 + 2 * column + row % 2) as f64;
            let y = radius * (1.0 + 1.0001 * 3f64.sqrt() * row as f64) + 1e-6;
            q.extend([x, y, 0.0].map(lit::<T>));
            v.extend([lit::<T>(0.0); 3]);
        }
    }
    let width = 2.0 * radius * wide as f64;
    for (name, point, normal) in
        [("floor", 0.0, [0.0, 1.0]), ("left", 0.0, [1.0, 0.0]), ("right", width, [-1.0, 0.0])]
    {
        builder.half_plane(name, [lit(point), lit(0.0)], normal.map(lit), walls).expect("valid");
    }
    builder.gravity([lit(0.0), lit(-10.0)]).expect("valid");
    builder.interface(discs, discs).expect("valid");
    builder.interface(discs, walls).expect("valid");
    let friction = if D == 1 { 0.0 } else { friction };
    let laws = vec![law("fremond", 0.0, friction), law("fremond", 0.0, friction)];
    // Discs roll and slide on each other: rule (55) would drop their contacts every other step.
    let activation = Activation::new(ActivationRule::PredictedGap);
    let settings = Settings { activation, ..Settings::new(lit(1.0), lit(1e-3)) };
    let system = builder.build().expect("bodies");
    ThetaScheme::new(Box::new(system), laws, solver(solver_name, tolerance), settings, lit(0.0), q, v)
        .expect("valid")
}
