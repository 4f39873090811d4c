//! Springs and dampers between two bodies: closed forms, and an energy balance that closes to rounding.
#![cfg(feature = "scene")]

#[path = "mechanics/from_text.rs"]
mod from_text;

use std::f64::consts::PI;

use from_text::{follow, scheme, try_scheme, upcrossings};

fn head(theta: f64, step: f64, end: f64, gravity: f64) -> String {
    format!(
        r#"
        title = "springs"
        laws = ["fremond"]
        gravity = [0.0, -{gravity:?}]
        [time]
        theta = {theta:?}
        step = {step:?}
        end = {end:?}
        "#
    )
}

/// Mean time between upcrossings of a quantity.
fn period(text: &str, of: impl Fn(&[f64]) -> f64) -> f64 {
    let mut samples = Vec::new();
    follow::<1>(text, |scheme| samples.push((scheme.state().time, of(&scheme.state().q))));
    let crossings = upcrossings(&samples);
    (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64
}

/// Angular frequency that the midpoint rule gives an oscillator of frequency ω: tan(ω_h h/2) = ω h/2.
fn midpoint(omega: f64, step: f64) -> f64 {
    2.0 / step * (omega * step / 2.0).atan()
}

const PAIR: &str = r#"
    [[bodies]]
    name = "a"
    mass = 1.0
    inertia = 0.1
    position = [0.0, 0.0]
    velocity = [-0.3, -0.4]
    [[bodies]]
    name = "b"
    mass = 2.0
    inertia = 0.1
    position = [0.6, 0.8]
    velocity = [0.15, 0.2]
    [[springs]]
    name = "between"
    body = "a"
    to = "b"
    stiffness = 50.0
"#;

#[test]
fn two_bodies_on_a_spring_oscillate_with_their_reduced_mass() {
    let step = 2e-3;
    let text = head(0.5, step, 5.0, 0.0) + PAIR;
    let omega = midpoint((50.0 / (2.0 / 3.0_f64)).sqrt(), step);
    let found = period(&text, |q| (q[3] - q[0]).hypot(q[4] - q[1]) - 1.0);
    // Crossings are interpolated over a step: (ω h)²/8 of a step each.
    assert!((found * omega / (2.0 * PI) - 1.0).abs() < 1e-6, "{found}, {}", 2.0 * PI / omega);
    let (mut scheme, steps) = scheme::<1>(&text);
    let start = scheme.last_step().energies;
    for _ in 0..steps {
        let made = scheme.step().expect("a spring");
        let total = made.energies.total();
        assert!((total - start.total()).abs() < 1e4 * f64::EPSILON * start.total(), "{total}, {start:?}");
    }
    let v = &scheme.state().v;
    // Internal forces: no momentum, and no turn.
    assert!((v[0] + 2.0 * v[3]).abs() + (v[1] + 2.0 * v[4]).abs() + v[2].abs() + v[5].abs() < 1e-12, "{v:?}");
}

#[test]
fn an_elastic_pendulum_keeps_its_energy_through_large_swings_for_every_theta_but_for_what_theta_takes() {
    let bob = r#"
        [[bodies]]
        name = "bob"
        mass = 1.5
        inertia = 0.02
        position = [1.0, 0.0]
        angle = 0.3
        [[springs]]
        name = "rope"
        body = "bob"
        at = [0.1, 0.05]
        stiffness = 120.0
    "#;
    for theta in [0.5, 0.7, 1.0] {
        let text = head(theta, 5e-3, 10.0, 9.81) + bob;
        let (mut lowest, mut last, mut first, mut taken) = (0.0_f64, 0.0, None, 0.0);
        let imbalance = follow::<1>(&text, |scheme| {
            let step = scheme.last_step();
            let total = step.energies.total();
            lowest = lowest.min(scheme.state().q[1]);
            let made = total - step.balance.numerical_dissipation;
            taken += step.balance.numerical_dissipation;
            first.get_or_insert(made);
            last = total;
        });
        // Energies of some m g L = 15 J; the iteration stops at 64 ε of its terms.
        assert!(imbalance < 1e3 * f64::EPSILON * 15.0, "θ = {theta}: {imbalance}");
        let first = first.expect("steps");
        assert!((last - first - taken).abs() < 1e-9, "θ = {theta}: {last}, {first}, {taken}");
        assert!(lowest < -1.1, "{lowest}");
        assert!(if theta == 0.5 { taken == 0.0 } else { taken < -1e-3 }, "{taken}");
    }
}

#[test]
fn a_damped_spring_comes_to_rest_where_it_carries_the_weight() {
    let text = head(0.5, 2e-3, 12.0, 9.81)
        + r#"
        [[bodies]]
        name = "bob"
        mass = 2.0
        inertia = 0.02
        position = [0.3, -1.0]
        [[springs]]
        name = "suspension"
        body = "bob"
        stiffness = 400.0
        damping = 15.0
        rest = 1.0
        [[springs]]
        name = "side"
        body = "bob"
        on = [0.0, -1.0]
        axis = [1.0, 0.0]
        damping = 8.0
        "#;
    let (mut q, mut lost, mut start) = (Vec::new(), 0.0, None);
    let mut end = 0.0;
    let imbalance = follow::<1>(&text, |scheme| {
        let step = scheme.last_step();
        q.clone_from(&scheme.state().q);
        let damping = step.balance.damping_work;
        assert!(damping <= 1e-15, "{damping}");
        lost += damping;
        start.get_or_insert(step.energies.total() - damping);
        end = step.energies.total();
    });
    assert!(imbalance < 1e3 * f64::EPSILON * 20.0, "{imbalance}");
    assert!((q[1] + 1.0 + 2.0 * 9.81 / 400.0).abs() < 1e-6 && q[0].abs() < 1e-6, "{q:?}");
    assert!((end - start.expect("steps") - lost).abs() < 1e-10, "{end}, {start:?}, {lost}");
}

#[test]
fn an_angular_spring_makes_a_torsion_pendulum_and_one_along_an_axis_leaves_the_other_direction_alone() {
    let step = 1e-3;
    let torsion = head(0.5, step, 6.0, 0.0)
        + r#"
        [[bodies]]
        name = "wheel"
        mass = 1.0
        inertia = 0.2
        position = [0.0, 0.0]
        spin = 3.0
        [[joints]]
        name = "axle"
        body = "wheel"
        [[springs]]
        name = "hair"
        body = "wheel"
        angular = true
        stiffness = 5.0
        "#;
    let omega = midpoint(5.0, step);
    let found = period(&torsion, |q| q[2]);
    assert!((found * omega / (2.0 * PI) - 1.0).abs() < 1e-6, "{found}");
    let slanted = head(0.5, step, 6.0, 0.0)
        + r#"
        [[bodies]]
        name = "bead"
        mass = 4.0
        inertia = 0.2
        position = [0.0, 0.0]
        velocity = [0.5, 0.1]
        [[springs]]
        name = "slanted"
        body = "bead"
        axis = [3.0, 4.0]
        stiffness = 36.0
        "#;
    let omega = midpoint(3.0, step);
    let found = period(&slanted, |q| 0.6 * q[0] + 0.8 * q[1]);
    assert!((found * omega / (2.0 * PI) - 1.0).abs() < 1e-6, "{found}");
    let (mut scheme, steps) = scheme::<1>(&slanted);
    for _ in 0..steps {
        scheme.step().expect("a spring");
    }
    let across = |x: &[f64]| -0.8 * x[0] + 0.6 * x[1];
    let state = scheme.state();
    assert!((across(&state.v) + 0.34).abs() < 1e-12, "{:?}", state.v);
    assert!((across(&state.q) + 0.34 * state.time).abs() < 1e-11, "{:?}", state.q);
}

#[test]
fn a_body_thrown_at_the_floor_on_a_spring_balances_its_energy_through_the_impacts() {
    let text = head(0.5, 1e-3, 3.0, 9.81)
        + r#"
        [[bodies]]
        name = "ball"
        mass = 1.0
        inertia = 0.01
        position = [0.4, 0.6]
        spin = 20.0
        discs = [{ name = "rim", radius = 0.1 }]
        [[half_planes]]
        name = "floor"
        normal = [0.0, 1.0]
        [[springs]]
        name = "tether"
        body = "ball"
        at = [0.1, 0.0]
        on = [0.0, 0.5]
        stiffness = 60.0
        damping = 0.2
        rest = 0.3
        [[interfaces]]
        between = ["ball", "floor"]
        parameters = { restitution = 0.8, friction = 0.4 }
        "#;
    let (mut impacts, mut worst) = (0, f64::NEG_INFINITY);
    let text = text.replace("theta = 0.5", "theta = 0.5\nallow_unproved_theta = true");
    let imbalance = follow::<2>(&text, |scheme| {
        let step = scheme.last_step();
        impacts += step.contacts.iter().filter(|contact| contact.percussion[0] > 0.0).count();
        worst = worst.max(step.balance.tangential_contact_work + step.balance.normal_contact_work);
    });
    assert!(impacts > 3, "{impacts}");
    // Every pass holds the law at its velocities, and the equations of motion to 64 ε.
    assert!(imbalance < 1e4 * f64::EPSILON * 10.0, "{imbalance}");
    assert!(worst < 1e-12, "{worst}");
}

#[test]
fn a_spring_that_is_none_is_refused_in_words() {
    for (change, said) in [
        (
            ("stiffness = 50.0", "stiffness = 0.0"),
            "stiffness and damping of `between` is 0, it must be not both 0",
        ),
        (("stiffness = 50.0", "stiffness = -1.0"), "stiffness of `between` is -1"),
        (("to = \"b\"", "to = \"c\""), "spring `between`"),
        (("to = \"b\"", "to = \"a\""), "another body"),
        (("stiffness = 50.0", "stiffness = 1.0\naxis = [0.0, 0.0]"), "length of the axis of `between` is 0"),
        (
            ("stiffness = 50.0", "stiffness = 1.0\nangular = true\naxis = [0.0, 1.0]"),
            "angular and has an axis",
        ),
        (("stiffness = 50.0", "stiffness = inf"), "stiffness of `between` is inf"),
    ] {
        let text = head(0.5, 1e-3, 1.0, 0.0) + &PAIR.replace(change.0, change.1);
        let error = try_scheme::<1>(&text).expect_err(change.1).to_string();
        assert!(error.contains(said), "{change:?}: {error}");
    }
}
