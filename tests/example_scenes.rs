//! The scenes of polygons and joints in `examples/`, read and run as they stand.
#![cfg(feature = "scene")]

#[path = "mechanics/example.rs"]
mod example;

use nonsmooth::scene::SceneError;

#[test]
fn the_rocking_block_loses_the_same_share_of_its_spin_at_every_impact() {
    let scene = example::scene("rocking_block");
    let alpha = 0.25_f64.atan();
    let ratio = 1.0 - 1.5 * alpha.sin().powi(2);
    for law in ["newton", "fremond", "moreau"] {
        let (mut scheme, steps) = example::scheme::<f64, 2>(&scene, law, "hybrid");
        let (mut before, mut ratios) = (0.0_f64, Vec::new());
        for _ in 0..steps {
            scheme.step().expect("two corners");
            let spin = scheme.state().v[2];
            // At an impact |ω| falls at once; between impacts it changes by some g h.
            if before.abs() > 0.2 && spin.abs() < 0.97 * before.abs() {
                ratios.push(spin / before);
            }
            before = spin;
        }
        assert!(ratios.len() >= 3, "{law}: {ratios:?}");
        for found in &ratios {
            // First order in h: g h against a spin of at least 0.2 rad/s.
            assert!((found - ratio).abs() < 1e-2, "{law}: {ratios:?}, exact {ratio}");
        }
    }
}

#[test]
fn the_pinned_pendulum_of_the_example_gains_energy_under_newton_alone() {
    let scene = example::scene("double_pendulum");
    for (law, expected) in [("newton", 1.361895571782e-2), ("fremond", -1.014349887098e-2)] {
        let (mut scheme, steps) = example::scheme::<f64, 2>(&scene, law, "hybrid");
        let balance = scheme.step().expect("the tip").balance;
        let change = balance.normal_contact_work + balance.tangential_contact_work;
        // A step of h = 1e-4 s brings g h = 1e-3 m/s to a velocity of 0.15 m/s.
        assert!((change - expected).abs() < 0.02 * expected.abs(), "{law}: {change}");
        let (mut impacts, mut worst) = (1, f64::MIN);
        for _ in 1..steps {
            let step = scheme.step().expect("the tip");
            impacts +=
                usize::from(step.contacts.iter().any(|c| c.percussion[0] > 0.0 && c.before[0] < -3e-3));
            worst = worst.max(step.balance.normal_contact_work + step.balance.tangential_contact_work);
        }
        assert!(impacts >= 5, "{law}: {impacts} impacts");
        // The solver's tolerance of 1e-10, on percussions of 0.5 N s and velocities of 0.5 m/s.
        assert!(law == "newton" || worst <= 1e-10, "{law}: {worst:e}");
    }
}

#[test]
fn a_joint_that_names_no_body_is_refused() {
    let mut scene = example::scene("double_pendulum");
    scene.joints[1].to = Some("middle".into());
    let runs = scene.runs(&nonsmooth::registry()).expect("laws and solvers");
    let error = nonsmooth::scene::build::<f64, 2>(&scene, &runs[0], &nonsmooth::registry())
        .expect_err("no such body");
    assert!(matches!(&error, SceneError::UnknownName { name, .. } if name == "middle"), "{error}");
}
