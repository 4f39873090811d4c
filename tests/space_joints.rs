//! Scene files in space with joints, springs, motors, obstacles that move, and torques about fixed axes.
#![cfg(feature = "scene")]

#[path = "mechanics/scene_text.rs"]
mod scene_text;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use nonsmooth::scene::SceneError;
use nonsmooth::scheme::ThetaScheme;

const HEAD: &str = "\
title = \"joints\"
laws = [\"newton\", \"fremond\"]
dimension = 3
";

fn scheme(text: &str, law: usize) -> Result<ThetaScheme<f64, 3>, SceneError> {
    scene_text::scheme(&format!("{HEAD}{text}"), law)
}

fn body(name: &str, position: [f64; 3], rest: &str) -> String {
    format!(
        "[[bodies]]\nname = \"{name}\"\ndensity = 1000.0\nposition = {position:?}\n\
         shapes = [{{ box = [0.2, 0.1, 0.3] }}]\n{rest}\n"
    )
}

#[test]
fn what_a_joint_lacks_or_has_too_much_is_named() {
    let scene = |joint: &str| {
        let bodies = body("one", [0.0; 3], "") + &body("two", [1.0, 0.0, 0.0], "");
        format!("[time]\nstep = 1e-3\nend = 1.0\n{bodies}{joint}")
    };
    let joint = |keys: &str| scene(&format!("[[joints]]\nname = \"j\"\nbody = \"one\"\n{keys}\n"));
    let spring = |keys: &str| scene(&format!("[[springs]]\nname = \"s\"\nbody = \"one\"\n{keys}\n"));
    let obstacle =
        |keys: &str| scene(&format!("[[obstacles]]\nname = \"o\"\nshapes = [{{ ball = 0.1 }}]\n{keys}\n"));
    for (text, part) in [
        (joint("kind = \"ball\""), "joint `j` is of a kind that wants `point`"),
        (joint("kind = \"hinge\"\npoint = [0.0, 0.0, 0.0]"), "joint `j` is of a kind that wants `axis`"),
        (joint("kind = \"rod\"\npoint = [0.0, 0.0, 0.0]"), "joint `j` is of a kind that wants `on`"),
        (joint("kind = \"weld\"\npoint = [0.0, 0.0, 0.0]"), "joint `j` is of a kind that takes no `point`"),
        (joint("kind = \"ball\"\npoint = [0.0, 0.0, 0.0]\naxis = [1.0, 0.0, 0.0]"), "takes no `axis`"),
        (joint("kind = \"weld\"\nlimits = [0.0, 1.0]"), "need a hinge or a slider"),
        (joint("kind = \"weld\"\nto = \"three\""), "three"),
        (joint("kind = \"weld\"\nto = \"one\""), "connects `one` with `one`"),
        (
            joint("kind = \"hinge\"\npoint = [0.0, 0.0, 0.0]\naxis = [0.0, 0.0, 0.0]"),
            "length of the axis of `j`",
        ),
        (
            joint("kind = \"rod\"\nto = \"two\"\npoint = [0.0, 0.0, 0.0]\non = [0.0, 0.0, 0.0]"),
            "length of `j` is 0",
        ),
        (
            joint(
                "kind = \"slider\"\npoint = [0.0, 0.0, 0.0]\naxis = [1.0, 0.0, 0.0]\nlimits = [0.5, -0.5]\n\
                 parameters = { restitution = 0.0 }",
            ),
            "upper less lower limit of `j`",
        ),
        (
            joint("kind = \"hinge\"\npoint = [0.0, 0.0, 0.0]\naxis = [1.0, 0.0, 0.0]\nmotor = {}"),
            "the motor of joint `j`",
        ),
        (spring("stiffness = 1.0"), "spring `s` wants `point`"),
        (spring("stiffness = 1.0\nangular = true"), "spring `s` wants `axis`"),
        (spring("point = [0.0, 0.0, 0.0]\non = [0.0, 0.0, 0.0]"), "stiffness and damping of `s`"),
        (obstacle("motion = [{ angle = 1.0, signal = \"constant\" }]"), "wants `motion_axis`"),
    ] {
        let error = scheme(&text, 0).map(drop).expect_err(part).to_string();
        assert!(error.contains(part), "{part}: {error}");
    }
}

/// A ball on two springs along x: ω² = 2k/m, and the energies of springs and motion add up to what there was.
#[test]
fn a_mass_between_springs_swings_at_their_frequency_and_keeps_its_energy() {
    let springs = |x: f64| {
        format!(
            "[[springs]]\nname = \"s{x}\"\nbody = \"ball\"\npoint = [0.0, 0.0, 0.0]\non = [{x:?}, 0.0, 0.0]\n\
             stiffness = 50.0\n"
        )
    };
    let text = format!(
        "[time]\nstep = 1e-3\nend = 1.0\n[[bodies]]\nname = \"ball\"\nmass = 4.0\nposition = [0.0, 0.0, 0.0]\n\
         velocity = [0.5, 0.0, 0.0]\nshapes = [{{ ball = 0.05 }}]\n{}{}",
        springs(-1.0),
        springs(1.0)
    );
    let mut scheme = scheme(&text, 0).expect("a scene");
    let start = scheme.last_step().energies.total();
    for _ in 0..1000 {
        scheme.step().expect("a step");
        assert!((scheme.last_step().energies.total() - start).abs() <= 1e-12 * start);
    }
    // The middle is half the sum of the springs, each of which is stretched by the way.
    let omega: f64 = (2.0 * 50.0 / 4.0_f64).sqrt();
    let exact = 0.5 / omega * omega.sin();
    assert!((scheme.state().q[0] - exact).abs() <= 1e-5 * 0.1, "{} {exact}", scheme.state().q[0]);
}

/// A torque about a fixed axis gives an unequal body L = τ t in space, however it tumbles.
#[test]
fn a_torque_about_a_fixed_axis_gives_its_angular_momentum() {
    let turned = "orientation = [0.8, 0.3, -0.2, 0.4]\nfixed_torque = [0.0, 0.3, 1.0]\n";
    let text = format!("[time]\nstep = 1e-2\nend = 1.0\n{}", body("one", [0.0; 3], turned));
    let mut scheme = scheme(&text, 0).expect("a scene");
    (0..100).for_each(|_| assert!(scheme.step().is_ok()));
    let (q, v) = (&scheme.state().q, &scheme.state().v);
    let turn = UnitQuaternion::new_normalize(Quaternion::new(q[3], q[4], q[5], q[6]));
    let nonsmooth::linalg::Symmetric::Diagonal(mass) = scheme.system().mass() else { panic!("a diagonal") };
    let momentum = turn * Vector3::new(mass[3] * v[3], mass[4] * v[4], mass[5] * v[5]);
    let error = (momentum - Vector3::new(0.0, 0.3, 1.0)).norm();
    assert!(error <= 1e-12, "{error:e}");
    let imbalance = scheme.last_step().balance.imbalance.abs();
    assert!(imbalance <= 1e-13 * scheme.last_step().energies.total(), "{imbalance:e}");
}

/// A table that shakes along x faster than friction follows: what slides is dragged by μ g at most, and the works add up.
#[test]
fn what_lies_on_a_table_that_moves_is_taken_along_by_friction_alone() {
    for law in 0..2 {
        let text = format!(
            "gravity = [0.0, 0.0, -10.0]\n[time]\nstep = 1e-3\nend = 1.0\n{}\
             [[obstacles]]\nname = \"table\"\nshapes = [{{ box = [4.0, 4.0, 0.2] }}]\nposition = [0.0, 0.0, -0.1]\n\
             motion = [{{ displacement = [0.1, 0.0, 0.0], signal = {{ sine = {{ frequency = 3.0 }} }} }}]\n\
             [[interfaces]]\nbetween = [\"one\", \"table\"]\nparameters = {{ restitution = 0.0, friction = 0.2 }}\n",
            body("one", [0.0, 0.0, 0.15], "")
        );
        let mut scheme = scheme(&text, law).expect("a scene");
        let mut before = 0.0;
        for k in 0..500 {
            scheme.step().unwrap_or_else(|error| panic!("step {k}: {error}"));
            let v = scheme.state().v[0];
            // μ g h, and the twist of a box that tilts is none.
            assert!((v - before).abs() <= 0.2 * 10.0 * 1e-3 * (1.0 + 1e-3), "step {k}: {v} {before}");
            before = v;
            let made = scheme.last_step();
            let scale = made.energies.kinetic + 6.0;
            assert!(made.balance.imbalance.abs() <= 1e-12 * scale, "step {k}: {:?}", made.balance);
            assert!(made.balance.tangential_contact_work <= 1e-12 * scale, "step {k}");
        }
        assert!((scheme.state().q[2] - 0.15).abs() <= 1e-9, "{}", scheme.state().q[2]);
    }
}
