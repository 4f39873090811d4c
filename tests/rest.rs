//! Bodies at rest: asleep, they are as if computed, until something touches them.

use nonsmooth::laws;
use nonsmooth::scheme::{Activation, ActivationRule, Settings, SetupError, ThetaScheme};
use nonsmooth::solver::{self, Stopping};
use nonsmooth::system::{Body, Describe, RigidBodies, polygon_body};

type Scheme = ThetaScheme<f64, 2>;

const STACKS: usize = 5;
const G: f64 = 10.0;

/// Stacks of two squares, 3 m apart, and a disc that falls beside the first, rolls, and runs into it after about a second.
fn scene(sleep: bool) -> Scheme {
    let mut builder = RigidBodies::builder();
    let (ball, square, floor) = (builder.group(), builder.group(), builder.group());
    let disc = builder.body("disc", Body { mass: 2.0, inertia: 0.09 }).expect("positive");
    builder.disc("disc", disc, [0.0; 2], 0.3, ball).expect("a disc");
    let (mut q, mut v) = (vec![-3.0, 0.5, 0.0], vec![2.5, 0.0, 0.0]);
    let outline = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
    let (body, vertices, _) = polygon_body(1.0, &outline).expect("a square");
    for stack in 0..STACKS {
        for height in [0.5, 1.5] {
            let name = format!("square {stack} at {height}");
            let body = builder.body(&name, body).expect("positive");
            builder.polygon(&name, body, &vertices, square).expect("convex");
            q.extend([3.0 * stack as f64, height, 0.0]);
            v.extend([0.0; 3]);
        }
    }
    builder.half_plane("floor", [0.0; 2], [0.0, 1.0], floor).expect("a plane");
    for pair in [(ball, floor), (square, floor), (square, square), (ball, square)] {
        builder.interface(pair.0, pair.1).expect("two groups");
    }
    builder.gravity([0.0, -G]).expect("finite");
    let laws = (0..4).map(|_| laws::build("fremond", &[0.0, 0.4]).expect("registered")).collect();
    let solver = solver::build(solver::DEFAULT, Stopping::to(1e-13)).expect("registered");
    let activation =
        Activation { gap_tolerance: Some(1e-9), ..Activation::new(ActivationRule::PredictedGap) };
    let settings = Settings { activation, sleep, ..Settings::new(0.8, 1e-3) };
    ThetaScheme::new(Box::new(builder.build().expect("bodies")), laws, solver, settings, 0.0, q, v)
        .expect("a valid setup")
}

/// Contacts that were not computed in the last step.
fn sleeping(scheme: &Scheme) -> usize {
    scheme.last_step().contacts.len() - scheme.cone_problem().contacts()
}

#[test]
fn what_sleeps_stands_as_if_it_were_computed_and_wakes_when_touched() {
    let (mut awake, mut asleep) = (scene(false), scene(true));
    let (mut most, mut woken, mut apart) = (0, false, 0.0_f64);
    for step in 0..2000 {
        awake.step().expect("squares");
        asleep.step().expect("squares");
        let sleepers = sleeping(&asleep);
        woken |= sleepers < most;
        if !woken {
            most = sleepers;
        }
        assert_eq!(sleeping(&awake), 0);
        // Who sleeps is reported, in the order of identities and with the force that holds it.
        let (one, other) = (&awake.last_step().contacts, &asleep.last_step().contacts);
        let ids = |contacts: &[nonsmooth::scheme::ContactStep<f64, 2>]| -> Vec<_> {
            contacts.iter().map(|contact| contact.id).collect()
        };
        assert!(other.is_sorted_by_key(|contact| contact.id));
        if !woken {
            assert_eq!(ids(one), ids(other), "step {step}");
        }
        let difference = awake.state().q.iter().zip(&asleep.state().q);
        apart = difference.fold(apart, |apart, (a, b)| apart.max((a - b).abs()));
        let balance = &asleep.last_step().balance;
        // The energies are some 10 J.
        assert!(balance.imbalance.abs() <= 1e-14, "step {step}: {balance:?}");
        assert!(balance.normal_contact_work + balance.tangential_contact_work <= 1e-14, "step {step}");
    }
    // Four contacts in each stack.
    assert_eq!(most, 4 * STACKS, "all stacks fell asleep");
    assert!(woken, "the disc woke the first");
    assert!(sleeping(&asleep) >= 4 * (STACKS - 1), "and no other");
    assert!(asleep.state().q[3] > 1e-3, "the first stack was pushed: {}", asleep.state().q[3]);
    // The tolerance of the solver, over 2,000 steps and an impact.
    assert!(apart <= 1e-10, "{apart:e}");
    for stack in 1..STACKS {
        let held = asleep.last_step().contacts.iter().filter(|contact| {
            let label = Describe::contact_label(asleep.system(), contact.id);
            label.starts_with(&format!("square {stack} at 0.5")) && label.ends_with("floor")
        });
        let weight = held.map(|contact| contact.percussion[0] / 1e-3).sum::<f64>();
        assert!((weight - 2.0 * G).abs() <= 1e-10, "stack {stack}: {weight}");
    }
}

#[test]
fn a_snapshot_knows_who_sleeps() {
    let mut whole = scene(true);
    for _ in 0..300 {
        whole.step().expect("squares");
    }
    assert_eq!(sleeping(&whole), 4 * STACKS);
    let snapshot = whole.snapshot();
    let mut resumed = scene(true);
    resumed.restore(&snapshot).expect("the same scene");
    for step in 0..1500 {
        let one = whole.step().expect("squares").clone();
        let other = resumed.step().expect("squares");
        assert_eq!(one, *other, "step {step}");
    }
    assert_eq!(whole.state(), resumed.state());
    let other = scene(false).snapshot();
    assert!(resumed.restore(&other).is_ok(), "a scene without sleepers");
    assert_eq!(resumed.state().index, 0);
    resumed.step().expect("squares");
    assert_eq!(sleeping(&resumed), 0, "nobody sleeps who was not at rest");
}

#[test]
fn steps_with_sleepers_allocate_nothing() {
    let mut scheme = scene(true);
    for _ in 0..300 {
        scheme.step().expect("squares");
    }
    let (mut computed, mut failed) = (0, false);
    let allocated = allocation_counter::measure(|| {
        for _ in 0..500 {
            failed |= scheme.step().is_err();
            computed += scheme.cone_problem().contacts();
        }
    });
    assert!(!failed && sleeping(&scheme) == 4 * STACKS, "the stacks sleep");
    assert!(computed > 100, "the disc rolls: {computed}");
    assert_eq!(allocated.count_total, 0, "{} bytes", allocated.bytes_total);
}

#[test]
fn what_only_turns_around_does_not_fall_asleep() {
    // A disc that rolls on the floor turns back under a force: it is at rest for one step.
    let mut builder = RigidBodies::<f64>::builder();
    let (ball, floor) = (builder.group(), builder.group());
    let disc = builder.body("disc", Body { mass: 1.0, inertia: 0.02 }).expect("positive");
    builder.disc("disc", disc, [0.0; 2], 0.2, ball).expect("a disc");
    builder.half_plane("floor", [0.0; 2], [0.0, 1.0], floor).expect("a plane");
    builder.interface(ball, floor).expect("two groups");
    builder.gravity([0.0, -G]).expect("finite");
    builder.force(disc, [-1.5, 0.0], 0.0).expect("finite");
    let law = laws::build("fremond", &[0.0, 0.9]).expect("registered");
    let solver = solver::build(solver::DEFAULT, Stopping::to(1e-12)).expect("registered");
    let activation = Activation::new(ActivationRule::PredictedGap);
    let settings = Settings { activation, sleep: true, ..Settings::new(0.5, 1e-3) };
    // Rolling, so that (m + I/r²) a = F: a = −1 m/s², and v = 0 after half a second.
    let (q, v) = (vec![0.0, 0.2, 0.0], vec![0.5, 0.0, -2.5]);
    let system = builder.build().expect("a body");
    let mut scheme: Scheme =
        ThetaScheme::new(Box::new(system), vec![law], solver, settings, 0.0, q, v).expect("a valid setup");
    for _ in 0..1000 {
        scheme.step().expect("a disc");
    }
    assert!((scheme.state().v[0] + 0.5).abs() <= 1e-9, "{:?}", scheme.state().v);
}

#[test]
fn a_step_that_changes_its_length_takes_no_sleepers() {
    let (mut awake, mut asleep) = (scene(false), scene(true));
    assert_eq!(awake.set_step(2e-3), Ok(()));
    assert_eq!(asleep.set_step(2e-3), Err(SetupError::SleepingStep));
    assert_eq!(asleep.settings().step, 1e-3, "the length is as it was");
}
