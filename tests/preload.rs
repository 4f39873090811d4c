//! A static preload that contacts resolve: the body stands where it starts, or the run says what nothing holds.

use nonsmooth::laws;
use nonsmooth::mesh::{Pattern, rectangle};
use nonsmooth::scheme::{Activation, ActivationRule, EquilibriumError, Settings, ThetaScheme, equilibrium};
use nonsmooth::solver::{self, Stopping};
use nonsmooth::system::{Dynamics, ElasticBody, Hypothesis, Material};

const YOUNG: f64 = 1e6;
const DENSITY: f64 = 1e3;
const G: f64 = 10.0;

/// A block of `width` × `height` m on the plane y = 0 under gravity inclined by `slope` (rad), which is a block on a slope.
fn block((width, height): (f64, f64), size: f64, pattern: Pattern, slope: f64) -> ElasticBody<f64> {
    let mesh = rectangle(width, height, size, pattern).expect("a rectangle");
    let hypothesis = Hypothesis::PlaneStress;
    let material = Material { young: YOUNG, poisson: 0.3, density: DENSITY, section: 1.0, hypothesis };
    let mut builder = ElasticBody::builder("block", mesh, material).expect("a material");
    builder.gravity([G * slope.sin(), -G * slope.cos()]).expect("gravity");
    let interface = builder.interface();
    builder.contact("bottom", "ground", [0.0; 2], [0.0, 1.0], interface).expect("the bottom");
    builder.build().expect("a block")
}

fn resolve(body: &mut ElasticBody<f64>, friction: f64) -> Result<Vec<f64>, EquilibriumError> {
    let mut solver = solver::build::<f64, 2>(solver::DEFAULT, Stopping::to(1e-13)).expect("registered");
    equilibrium(body, &[friction], &mut *solver, 0.0, true)
}

/// K q − F, the contact forces with the sign of reactions; zero but at the nodes that touch.
fn reactions(body: &ElasticBody<f64>, q: &[f64]) -> Vec<f64> {
    let stiffness = Dynamics::stiffness(body).expect("elastic");
    let mut left = q.to_vec();
    stiffness.multiply(q, &mut left);
    let force = Dynamics::forces(body).constant_part();
    left.iter().zip(force).map(|(k, f)| k - f).collect()
}

/// Equilibrium of the state with every law of contact: forces where nothing touches are rounding, the reactions lie in
/// their cones, carry the weight, and nothing is below the ground.
fn assert_static(what: &str, body: &ElasticBody<f64>, q: &[f64], friction: f64, slope: f64) {
    let weight = body.total_mass() * G;
    let left = reactions(body, q);
    let geometry = body.geometry();
    let bottom = geometry.mesh().group_nodes("bottom").expect("the bottom");
    // What is left is 1e-12 of the loads, or rounding of K q: 1e-8 at the very most.
    let slack = 1e-8 * weight;
    let (mut normal, mut tangential) = (0.0, 0.0);
    for node in 0..geometry.mesh().nodes().len() {
        let [x, y] = [0, 1].map(|axis| left[geometry.dof(node, axis)]);
        if bottom.contains(&node) {
            assert!(y >= -slack && x.abs() <= friction * y + slack, "{what}: reaction ({x:e}, {y:e}) N");
            let gap = q[geometry.dof(node, 1)];
            assert!(gap >= -1e-9, "{what}: node {node} is {gap:e} m below the ground");
            assert!(y <= slack || gap <= 1e-9, "{what}: node {node} carries {y:e} N over a gap of {gap:e} m");
            normal += y;
            tangential += x;
        } else {
            assert!(x.abs() <= slack && y.abs() <= slack, "{what}: ({x:e}, {y:e}) N left at node {node}");
        }
    }
    assert!(
        (normal - weight * slope.cos()).abs() <= slack,
        "{what}: normal reaction {normal} N of {weight} N"
    );
    assert!((tangential + weight * slope.sin()).abs() <= slack, "{what}: tangential reaction {tangential} N");
}

/// The motion from the preload stands still for 1000 steps with both laws.
fn assert_stands(what: &str, make: impl Fn() -> ElasticBody<f64>, q: &[f64], friction: f64) {
    for law in ["newton", "fremond"] {
        let law = laws::build::<f64, 2>(law, &[0.0, friction]).expect("a law");
        let name = law.name().to_string();
        let solver = solver::build(solver::DEFAULT, Stopping::to(1e-13)).expect("registered");
        let activation = Activation::new(ActivationRule::PredictedGap);
        let settings = Settings { activation, allow_unproved_theta: true, ..Settings::new(0.5, 1e-4) };
        let v = vec![0.0; q.len()];
        let mut scheme = ThetaScheme::new(Box::new(make()), vec![law], solver, settings, 0.0, q.to_vec(), v)
            .expect("a scheme");
        let mut fastest = 0.0_f64;
        for _ in 0..1000 {
            scheme.step().expect("a step at rest");
            fastest = scheme.state().v.iter().fold(fastest, |most, v| most.max(v.abs()));
        }
        // g h = 1e-3 m/s is what a step without contact would make.
        assert!(fastest <= 1e-9, "{what}, {name}: {fastest:e} m/s");
    }
}

#[test]
fn a_block_stands_under_its_own_weight() {
    for (shape, size, pattern) in [
        ((2.0, 1.0), 0.25, Pattern::Structured),
        ((1.0, 1.0), 0.2, Pattern::Quality),
        ((0.5, 2.0), 0.25, Pattern::Structured),
        ((4.0, 0.5), 0.25, Pattern::Quality),
        ((2.0, 1.0), 0.1, Pattern::Structured),
    ] {
        for friction in [0.0, 0.1, 0.3, 1.0] {
            let what = format!("{shape:?} m, elements of {size} m, μ = {friction}");
            let make = || block(shape, size, pattern, 0.0);
            let mut body = make();
            let q = resolve(&mut body, friction).unwrap_or_else(|error| panic!("{what}: {error}"));
            assert_static(&what, &body, &q, friction, 0.0);
            if size >= 0.25 {
                assert_stands(&what, make, &q, friction);
            }
        }
    }
}

#[test]
fn a_block_stands_on_a_slope_within_the_cone_and_not_beyond() {
    let slope = 0.3_f64.atan();
    let mut body = block((2.0, 1.0), 0.25, Pattern::Structured, slope);
    let q = resolve(&mut body, 0.5).unwrap_or_else(|error| panic!("within the cone: {error}"));
    assert_static("on a slope", &body, &q, 0.5, slope);
    for friction in [0.0, 0.2] {
        let refused = resolve(&mut body, friction).expect_err("beyond the cone");
        let EquilibriumError::NotHeld { free, residual, .. } = &refused else { panic!("{refused}") };
        // What is left is at least the tangential force that friction does not carry.
        assert!(*residual > 1e-3 && free.contains("along x"), "μ = {friction}: {refused}");
    }
}
