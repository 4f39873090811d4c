//! Steps under error control: the errors asked for, the guarantees of the scheme at every step kept, and what is refused.
#![cfg(feature = "scene")]

mod elastic;
#[path = "mechanics/example.rs"]
mod example;
mod motions;
#[path = "mechanics/regression.rs"]
mod regression;
mod scenes;

use std::ops::ControlFlow;
use std::path::Path;

use motions::{Case, adaptive, cases, run, scheme};
use nonsmooth::adaptive::{Adaptive, AdaptiveError, AdaptiveSettings, Limit};
use nonsmooth::mesh::Pattern;
use nonsmooth::scene::{Overrides, Scene};
use nonsmooth::scheme::{Settings, SetupError, State, Step, ThetaScheme};
use nonsmooth::system::{Axis, Dynamics, ElasticBody, Hypothesis, MassForm, Material, Signal};
use regression::order;

const TOLERANCES: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

/// Accuracy of the cone solver, relative to velocities.
const SOLVER: f64 = 1e-10;

/// Largest entry of W in the cases, at the end of the bar (1/kg).
const LARGEST_W: f64 = 8.0;

/// Rounding of a balance: some dozens of ε of the largest energy, and of the works of one step.
const ROUNDING: f64 = 256.0 * f64::EPSILON;

/// Checks that a step kept is one of the scheme, that it dissipates, and that its balance closes.
struct Guarantees {
    name: String,
    before: State<f64>,
    largest_energy: f64,
    dissipates: bool,
}

impl Guarantees {
    fn check<const D: usize>(&mut self, state: &State<f64>, step: &Step<f64, D>) {
        let (name, before) = (&self.name, &self.before);
        let h = state.time - before.time;
        assert_eq!(state.index, before.index + 1, "{name}: steps are told of one by one");
        for i in 0..state.q.len() {
            let made = before.q[i] + h * 0.5 * (before.v[i] + state.v[i]);
            // The clock rounds t, and with it h.
            let rounding = 16.0 * f64::EPSILON * (state.q[i].abs() + 1.0 + state.time * state.v[i].abs());
            let miss = (state.q[i] - made).abs();
            assert!(miss <= rounding, "{name}, t = {}: q[{i}] is off q_k + h v_θ by {miss:e}", state.time);
        }
        let balance = &step.balance;
        let terms = [balance.kinetic_change, balance.elastic_change, balance.external_work];
        let pushed = step.contacts.iter().map(|c| c.percussion.norm() * (c.before.norm() + c.after.norm()));
        let scale =
            terms.iter().fold(self.largest_energy + pushed.sum::<f64>(), |sum, term| sum + term.abs());
        self.largest_energy = self.largest_energy.max(step.energies.mechanical());
        let (imbalance, bound) = (balance.imbalance.abs(), ROUNDING * scale);
        assert!(imbalance <= bound, "{name}, t = {}: imbalance {imbalance:e} > {bound:e}", state.time);
        for contact in &step.contacts {
            let speed = contact.before.norm() + contact.after.norm();
            let work = contact.normal_work + contact.tangential_work;
            // The residual is relative to ‖b‖, which holds what the percussions change as well.
            let pushed = contact.percussion.norm();
            let bound = SOLVER * (speed + LARGEST_W * pushed) * pushed + ROUNDING * scale;
            assert!(!self.dissipates || work <= bound, "{name}, t = {}: work {work:e}", state.time);
        }
        self.before.clone_from(state);
    }
}

/// Runs a case at every tolerance; the global error is at most 3 ε, and every step keeps the guarantees.
fn meets_its_tolerances<const D: usize>(case: &Case) {
    for tolerance in TOLERANCES {
        let start = scheme::<D>(case);
        let mut guarantees = Guarantees {
            name: format!("{}, ε = {tolerance:e}", case.name),
            before: start.state().clone(),
            largest_energy: start.last_step().energies.mechanical(),
            // Newton's law claims nothing.
            dissipates: case.law == "fremond",
        };
        let (errors, report) =
            run::<D>(case, tolerance, |state, step| guarantees.check(state, step)).expect("a run");
        let name = &guarantees.name;
        let largest = errors.largest();
        assert!(largest <= 3.0 * tolerance, "{name}: {errors:?} after {report:?}");
        assert!(report.estimated_error <= 2.0 * tolerance, "{name}: {report:?}");
        assert_eq!(guarantees.before.time, case.scene.time.end, "{name}: it ends at the end");
        assert_eq!(guarantees.before.index, report.accepted, "{name}: {report:?}");
    }
}

#[test]
fn without_friction_the_error_is_the_one_asked_for() {
    // Ball through its accumulation point, impact oscillator, grazing oscillator, elastic bar.
    cases(&["fremond"]).frictionless.iter().for_each(meets_its_tolerances::<1>);
}

#[test]
fn with_friction_the_error_is_the_one_asked_for() {
    // Stick, disc sliding into rolling, block that sticks and slips.
    cases(&["newton", "fremond"]).frictional.iter().for_each(meets_its_tolerances::<2>);
}

fn named(name: &str) -> Case {
    let all = cases(&["fremond"]);
    let found = all.frictionless.into_iter().chain(all.frictional).find(|case| case.name.starts_with(name));
    found.expect("a case of this name")
}

#[test]
fn between_events_the_steps_grow_like_the_root_of_the_tolerance() {
    let oscillator = named("impact_oscillator");
    let steps = TOLERANCES
        .map(|tolerance| run::<1>(&oscillator, tolerance, |_, _| ()).expect("a run").1.accepted as f64);
    let measured = order(&TOLERANCES, &steps);
    // A second-order scheme: h² ~ ε. The steps around five impacts are some tens in thousands.
    assert!((measured + 0.5).abs() <= 0.01, "{steps:?}: {measured}");
}

#[test]
fn an_accumulation_point_takes_a_logarithm_of_steps_and_then_rest() {
    let ball = named("bouncing_ball");
    let counts = TOLERANCES.map(|tolerance| {
        let mut last = None;
        let report = run::<1>(&ball, tolerance, |state, _| last = Some(state.clone())).expect("a run").1;
        let last = last.expect("a step");
        // Landings a γ = 1e-4 ε above or below the floor each; the bounces left are not told from rest.
        assert!(last.q[1].abs() <= 0.1 * tolerance && last.v[1].abs() <= 1e-6, "ε = {tolerance:e}: {last:?}");
        report.accepted
    });
    // From 4.5 m/s down to 1e-6 m/s in halves: 22 bounces of two or three steps, whatever ε.
    assert!(counts.iter().all(|&steps| steps <= 100), "{counts:?}");
}

#[test]
fn a_run_may_be_made_in_pieces() {
    let stick = named("impacting_stick");
    let mut driver = adaptive::<2>(&stick, 1e-6).expect("in range");
    let mut times = vec![0.0];
    for end in [0.0123, 0.0603, 0.0604, 0.2] {
        let ended: ControlFlow<()> = driver
            .advance_to(end, |_, state, _| {
                times.push(state.time);
                ControlFlow::Continue(())
            })
            .expect("a run");
        assert!(ended.is_continue());
        assert!((driver.scheme().state().time - end).abs() <= f64::EPSILON * end, "stops at {end}");
    }
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "{times:?}");
    let (q, v) = (&mut [0.0; 3], &mut [0.0; 3]);
    (stick.motion)(0.2, q, v);
    let far = (0..3).fold(0.0, |far: f64, i| far.max((driver.scheme().state().q[i] - q[i]).abs()));
    assert!(far <= 3e-6 * 0.5, "{far:e}");
    let broken = driver.advance_to(0.2, |_, _, _| ControlFlow::Break(())).expect("nothing is left to do");
    assert!(broken.is_continue());
}

#[test]
fn a_break_ends_a_run_after_the_steps_that_were_kept_together() {
    let mut driver = adaptive::<1>(&named("impact_oscillator"), 1e-4).expect("in range");
    let mut told = 0;
    let ended = driver.advance_to(20.0, |_, _, _| {
        told += 1;
        if told < 10 { ControlFlow::Continue(()) } else { ControlFlow::Break("enough") }
    });
    assert_eq!(ended, Ok(ControlFlow::Break("enough")));
    assert!((10..=12).contains(&told) && driver.scheme().state().index == told, "{told}");
}

#[test]
fn single_precision_meets_what_it_can_resolve() {
    let case = named("impacting_stick");
    let scheme = scenes::stick::<f32, 2>("fremond", "nsgs");
    let mut driver = Adaptive::new(scheme, AdaptiveSettings::new(1e-2, 0.2)).expect("in range");
    let _end: ControlFlow<()> =
        driver.advance_to(0.2, |_, _, _| ControlFlow::Continue(())).expect("a run in single precision");
    let (q, v) = (&mut [0.0; 3], &mut [0.0; 3]);
    (case.motion)(0.2, q, v);
    let far = (0..3).fold(0.0, |far: f64, i| far.max((f64::from(driver.scheme().state().q[i]) - q[i]).abs()));
    assert!(far <= 3e-2 * 0.5, "{far:e}");
    let scheme = scenes::stick::<f32, 2>("fremond", "nsgs");
    let refused = Adaptive::new(scheme, AdaptiveSettings::new(1e-6, 0.2)).expect_err("below its rounding");
    assert!(refused.to_string().contains("4.8828125e-4"), "{refused}");
}

#[test]
fn settings_out_of_range_are_refused_with_their_value() {
    let oscillator = named("impact_oscillator");
    let good = AdaptiveSettings::new(1e-4, 20.0);
    let bad = [
        AdaptiveSettings { tolerance: 0.0, ..good },
        AdaptiveSettings { tolerance: f64::NAN, ..good },
        AdaptiveSettings { tolerance: 1.0, ..good },
        AdaptiveSettings { end: 0.0, ..good },
        AdaptiveSettings { end: f64::INFINITY, ..good },
        AdaptiveSettings { min_step: Some(-1.0), ..good },
        AdaptiveSettings { min_step: Some(30.0), ..good },
        AdaptiveSettings { max_step: Some(1e-30), ..good },
        AdaptiveSettings { max_step: Some(f64::NAN), ..good },
        AdaptiveSettings { first_step: Some(19.0), ..good },
    ];
    for settings in bad {
        let refused = Adaptive::new(scheme::<1>(&oscillator), settings).expect_err("out of range");
        assert!(matches!(refused, AdaptiveError::OutOfRange { .. }), "{settings:?}: {refused}");
    }
}

#[test]
fn a_smallest_step_that_is_too_long_ends_the_run_with_its_numbers() {
    for (name, min_step, expected) in
        [("impact_oscillator", 0.2, Limit::Error), ("bouncing_ball", 1e-3, Limit::Event)]
    {
        let case = named(name);
        let settings =
            AdaptiveSettings { min_step: Some(min_step), ..AdaptiveSettings::new(1e-5, case.scene.time.end) };
        let mut driver = Adaptive::new(scheme::<1>(&case), settings).expect("in range");
        let mut last = 0.0;
        let ended = driver.advance_to(case.scene.time.end, |_, state, _| {
            last = state.time;
            ControlFlow::<()>::Continue(())
        });
        let Err(AdaptiveError::Underflow { time, limit, step, least, .. }) = ended else {
            panic!("{name}: {ended:?}");
        };
        assert_eq!((limit, least), (expected, min_step), "{name}");
        assert!(step < least, "{name}: {step:e}");
        // What was told of is what was reached.
        assert_eq!((time, driver.scheme().state().time), (last, last), "{name}");
    }
}

/// A block whose top is moved up and down.
fn shaken() -> elastic::Scheme<2> {
    let mesh = elastic::built_in_mesh(12.5, Pattern::Structured);
    let hypothesis = Hypothesis::PlaneStress;
    let material = Material { young: 5750.0, poisson: 0.358, density: 1.17e-3, section: 15.0, hypothesis };
    let mut builder = ElasticBody::builder("block", mesh, material).expect("a material");
    let sine = Signal::Sine { frequency: 1.0, phase: 0.0 };
    builder.prescribe(elastic::TOP, Axis::Y, 0.01, sine).expect("the top");
    let body = builder.build().expect("a block");
    let zeros = vec![0.0; Dynamics::dofs(&body)];
    let solver = nonsmooth::solver::build("nsgs", nonsmooth::solver::Stopping::default()).expect("a solver");
    ThetaScheme::new(Box::new(body), vec![], solver, Settings::new(0.5, 1e-3), 0.0, zeros.clone(), zeros)
        .expect("a scheme")
}

#[test]
fn displacements_that_move_keep_one_step() {
    let refused =
        Adaptive::new(shaken(), AdaptiveSettings::new(1e-3, 1.0)).expect_err("its q_k depends on h");
    assert_eq!(refused, AdaptiveError::Setup(SetupError::MovingStep));
    assert_eq!(shaken().set_step(1e-4), Err(SetupError::MovingStep));
}

#[test]
fn lengths_come_back_to_their_factors_and_to_their_steps() {
    let make = || {
        let bar = elastic::bar(20, 0.0, 0.0, MassForm::Consistent);
        let law = nonsmooth::laws::build("fremond", &[0.0, 0.0]).expect("a law");
        let solver =
            nonsmooth::solver::build("nsgs", nonsmooth::solver::Stopping::to(1e-12)).expect("a solver");
        let (q, v) = (vec![0.0; 21], vec![-10.0; 21]);
        ThetaScheme::<f64, 1>::new(Box::new(bar), vec![law], solver, Settings::new(0.5, 1e-3), 0.0, q, v)
            .expect("a scheme")
    };
    let (mut plain, mut changed) = (make(), make());
    for _ in 0..50 {
        for h in [5e-4, 2e-3, 1e-3] {
            changed.set_step(h).expect("a length");
        }
        plain.step().expect("a step");
        changed.step().expect("a step");
    }
    assert_eq!(changed.factorisations(), 2, "each other length once");
    assert_eq!((&plain.state().q, &plain.state().v), (&changed.state().q, &changed.state().v));
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(changed.set_step(step), Err(SetupError::TimeStep { .. })), "{step}");
    }
    // Of two lengths in turn the clock loses nothing: 1000 times 1e-3 and 1e-4.
    let mut clock = make();
    for _ in 0..1000 {
        for h in [1e-3, 1e-4] {
            clock.set_step(h).expect("a length");
            clock.step().expect("a step");
        }
    }
    assert!((clock.state().time - 1.1).abs() <= 2.0 * f64::EPSILON, "{:e}", clock.state().time - 1.1);
}

fn with_time(time: &str) -> Result<Scene, String> {
    let text = include_str!("../examples/bouncing_ball.toml");
    let line = text.lines().find(|line| line.starts_with("step")).expect("the step");
    Scene::parse(&text.replace(line, time), Path::new("ball.toml")).map_err(|error| error.to_string())
}

#[test]
fn a_scene_asks_for_error_control() {
    let scene = with_time("step = \"adaptive\"\ntolerance = 1e-4\nmax_step = 0.1").expect("a scene");
    let adaptive = scene.time.adaptive.expect("error control");
    assert_eq!((adaptive.tolerance, adaptive.max_step, adaptive.min_step), (1e-4, Some(0.1), None));
    let mut fixed = scene.clone();
    fixed.override_with(&Overrides { step: Some(1e-3), ..Overrides::default() });
    assert_eq!((fixed.time.adaptive, fixed.time.step), (None, 1e-3));
    let mut finer = scene;
    finer.override_with(&Overrides { adaptive: Some(1e-6), ..Overrides::default() });
    let adaptive = finer.time.adaptive.expect("error control");
    assert_eq!((adaptive.tolerance, adaptive.max_step), (1e-6, Some(0.1)));
    assert_eq!(with_time("step = 1").expect("a whole number").time.step, 1.0);
    for (time, said) in [
        ("step = \"adaptive\"", "needs a `tolerance`"),
        ("step = \"clever\"\ntolerance = 1e-4", "\"adaptive\""),
        ("step = 1e-4\ntolerance = 1e-4", "`tolerance` goes with step"),
        ("step = 1e-4\nmin_step = 1e-9", "`min_step` goes with step"),
        ("step = true", "a time step in seconds"),
        ("step = \"adaptive\"\ntolerance = \"small\"", "expected f64"),
        ("step = \"adaptive\"\ntolerance = 1e-4\nstride = 2", "stride"),
    ] {
        let refused = with_time(time).expect_err(time);
        assert!(refused.contains(said) && refused.starts_with("ball.toml:"), "{time}: {refused}");
    }
}
