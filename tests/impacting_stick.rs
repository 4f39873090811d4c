//! The impacting stick of Acary & Collins-Craft (2024), section 5.1: the impacts of both laws to the last digit, with
//! every solver, and the convergence to the event-driven motion.
#![cfg(all(feature = "scene", feature = "outputs"))]

#[path = "mechanics/event_driven.rs"]
mod event_driven;
#[path = "mechanics/impact.rs"]
mod impact;
#[path = "mechanics/regression.rs"]
mod regression;

use std::path::Path;
use std::sync::atomic::AtomicBool;

use event_driven::Stick;
use nalgebra::Vector3;
use nonsmooth::observe::{RunInfo, RunSummary, SummaryRecorder};
use nonsmooth::scalar::Scalar;
use nonsmooth::scene::{Planar, Run, Scene, build};
use nonsmooth::simulate::{Outcome, simulate};
use nonsmooth::solver::SOLVERS;
use regression::{log_spaced, order};

/// An impact of the scheme at θ = ½, h = 1e-4 under rule (55): step, u⁻, u⁺, p in (N, T) and tangential work.
struct Row {
    law: &'static str,
    step: usize,
    before: [f64; 2],
    after: [f64; 2],
    percussion: [f64; 2],
    work: f64,
}

const TABLE: [Row; 4] = [
    Row {
        law: "newton",
        step: 603,
        before: [-0.466432463729, -0.464858139440],
        after: [0.466432463729, 0.085475265292],
        percussion: [0.373089212654, -3.730892126542e-3],
        work: 7.077182890524e-4,
    },
    Row {
        law: "newton",
        step: 1633,
        before: [-0.470227743579, -0.025709099453],
        after: [0.470227743579, 0.407574504402],
        percussion: [0.312721121772, -3.127211217717e-3],
        work: -5.970868890075e-4,
    },
    Row {
        law: "fremond",
        step: 603,
        before: [-0.466432463729, -0.464858139440],
        after: [0.466432463729, 0.097258308317],
        percussion: [0.368670891783, 3.686708917827e-3],
        work: -6.776167877976e-4,
    },
    Row {
        law: "fremond",
        step: 1634,
        before: [-0.469847121795, -0.015754782183],
        after: [0.469847121795, 0.416129101741],
        percussion: [0.312045141938, -3.120451419378e-3],
        work: -6.246743068730e-4,
    },
];

/// The event-driven limit h → 0, from 30-digit arithmetic.
struct Limit {
    law: &'static str,
    times: [f64; 2],
    works: [f64; 2],
    q: [f64; 3],
    v: [f64; 3],
}

const LIMITS: [Limit; 2] = [
    Limit {
        law: "newton",
        times: [0.0602740890931335, 0.163275784399643],
        works: [7.07557531928671e-4, -5.96201880021998e-4],
        q: [0.252917082969242, 0.247184152996499, 1.08198050693022],
        v: [-0.506857186185685, -1.21428138143152, 3.20697486630626],
    },
    Limit {
        law: "fremond",
        times: [0.0602740890931335, 0.163426487041862],
        works: [-6.77436191397145e-4, -6.24721696746364e-4],
        q: [0.253954653570177, 0.246505034604781, 1.08347693476027],
        v: [-0.499431898486806, -1.21909485547438, 3.21913960453411],
    },
];

const END: f64 = 0.2;
const RESTITUTION: f64 = 1.0;
const FRICTION: f64 = 0.01;

fn scene() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/impacting_stick.toml");
    Scene::read(&path).expect("the example is a scene")
}

fn scheme<T: Scalar>(scene: &Scene, law: &str, solver: &str) -> (Planar<T, 2>, usize) {
    let runs = Scene { laws: vec![law.into()], solvers: vec![solver.into()], ..scene.clone() }.runs();
    let [run] = <[Run; 1]>::try_from(runs.expect("registered names")).expect("one law, one solver");
    (build(scene, &run).expect("the example builds"), run.steps)
}

fn summary<T: Scalar>(scene: &Scene, law: &str, solver: &str) -> RunSummary {
    let (mut scheme, steps) = scheme::<T>(scene, law, solver);
    let info = RunInfo::new(law, solver, vec![law.into()], scheme.settings());
    let mut recorder = SummaryRecorder::default();
    let outcome = simulate(&mut scheme, steps, &info, &mut [&mut recorder], &AtomicBool::new(false));
    assert_eq!(outcome, Ok(Outcome::Completed), "{law}, {solver}");
    recorder.finish(None).expect("the run began")
}

/// The two impacts of a law are those of the table to `digits` of the velocity scale 1 m/s, with the steps up to
/// `steps`, and tangential works to `energy` of the energy.
fn assert_impacts(run: &RunSummary, steps: usize, digits: f64, energy: f64) {
    let place = format!("{}, {}, {}", run.law, run.solver, run.scalar);
    let rows: Vec<&Row> = TABLE.iter().filter(|row| row.law == run.law).collect();
    assert_eq!(run.impact_count, rows.len(), "{place}");
    for (impact, row) in run.impacts.iter().zip(rows) {
        let place = format!("{place}, step {}", row.step);
        assert!(impact.step.abs_diff(row.step) <= steps, "{place}: {}", impact.step);
        let close = |what: &str, computed: &[f64], published: &[f64; 2]| {
            for (x, y) in computed.iter().zip(published) {
                assert!((x - y).abs() <= digits, "{place}: {what} {computed:?}, published {published:?}");
            }
        };
        close("u⁻", &impact.u_before, &row.before);
        close("u⁺", &impact.u_after, &row.after);
        close("p", &impact.percussion, &row.percussion);
        let miss = (impact.tangential_work - row.work).abs() / run.max_energy;
        assert!(miss <= energy, "{place}: w_T {:e} misses by {miss:e} E", impact.tangential_work);
        // e = 1: no normal work.
        assert!(impact.normal_work.abs() <= energy * run.max_energy, "{place}: {:e}", impact.normal_work);
    }
}

#[test]
fn the_impacts_are_those_of_the_table_with_every_solver() {
    let mut scene = scene();
    // A residual of 1e-13 of ‖b‖ ≈ 1 m/s moves p by as much, and w_T by less: beyond the 12 digits of the table.
    scene.solver.tolerance = Some(1e-13);
    for law in ["newton", "fremond"] {
        for solver in SOLVERS {
            let run = summary::<f64>(&scene, law, solver.name);
            // Half a unit of the last digit printed, and 2000 steps of rounding at 1 m/s.
            assert_impacts(&run, 0, 0.5e-12 + 2000.0 * f64::EPSILON, 1e-12);
            let imbalance = run.max_imbalance / run.max_energy;
            assert!(imbalance <= 1e-14, "{law}, {}: (56) leaves {imbalance:e} E", solver.name);
            assert!(run.max_residual <= 1e-13, "{law}, {}: {:e}", solver.name, run.max_residual);
        }
    }
}

#[test]
fn newton_creates_energy_in_friction_where_fremond_dissipates() {
    for solver in SOLVERS {
        let newton = summary::<f64>(&scene(), "newton", solver.name);
        assert_eq!(newton.positive_work_steps, 1, "{}", solver.name);
        assert!(newton.max_tangential_work > 7e-4, "{}", solver.name);
        let fremond = summary::<f64>(&scene(), "fremond", solver.name);
        assert_eq!(fremond.positive_work_steps, 0, "{}", solver.name);
        assert!(fremond.max_tangential_work < 1e-15, "{}", solver.name);
    }
}

#[test]
fn single_precision_finds_the_same_impacts() {
    for law in ["newton", "fremond"] {
        for solver in SOLVERS {
            let run = summary::<f32>(&scene(), law, solver.name);
            // Positions round to ε/2 of 0.5 m in each of 1634 steps; at worst they add up, and over the fall of
            // 0.47 m/s that is one step of 4.7e-5 m. An impact a step late is one of g h = 1e-3 m/s more.
            assert_impacts(&run, 1, 3e-3, 1e-5);
            // 64 ε: the terms of (56) at an impact are as large as E, and there are ten of them.
            let imbalance = run.max_imbalance / run.max_energy;
            assert!(imbalance <= 64.0 * f64::from(f32::EPSILON), "{law}, {}: {imbalance:e}", solver.name);
        }
    }
}

fn reference(law: &str) -> Stick {
    let law = impact::law(law, RESTITUTION, FRICTION);
    Stick::new(&scene(), &*law, &mut *impact::solver("nsgs"), END)
}

#[test]
fn the_event_driven_motion_is_the_published_limit() {
    for limit in &LIMITS {
        let stick = reference(limit.law);
        assert_eq!(stick.flights.len(), 3, "{}: two impacts", limit.law);
        for (flight, (time, work)) in stick.flights[1..].iter().zip(limit.times.iter().zip(limit.works)) {
            // 15 digits; the root of the gap is known to ε·0.5 m / 0.47 m/s.
            assert!((flight.start - time).abs() <= 4.0 * f64::EPSILON, "{}: t = {}", limit.law, flight.start);
            let computed = flight.impact.expect("a flight begins with an impact").work[1];
            assert!((computed - work).abs() <= 1e-15, "{}: w_T = {computed:e}", limit.law);
        }
        let (q, v) = stick.at(END);
        // 15 digits of numbers up to 3.2, rounded, and the impact times times the speeds and spins.
        assert!((q - Vector3::from(limit.q)).amax() <= 16.0 * f64::EPSILON, "{}: q = {q}", limit.law);
        assert!((v - Vector3::from(limit.v)).amax() <= 32.0 * f64::EPSILON, "{}: v = {v}", limit.law);
    }
}

/// Distances of the scheme with step `step` from the event-driven motion.
struct Distance {
    q: f64,
    v_l1: f64,
    v_l2: f64,
    v_max: f64,
    times: f64,
    works: f64,
    end_q: f64,
    end_v: f64,
}

fn distance(scene: &Scene, law: &str, stick: &Stick, limit: &Limit) -> Distance {
    let (mut scheme, steps) = scheme::<f64>(scene, law, "nsgs");
    let h = scene.time.step;
    let mut far =
        Distance { q: 0.0, v_l1: 0.0, v_l2: 0.0, v_max: 0.0, times: 0.0, works: 0.0, end_q: 0.0, end_v: 0.0 };
    let mut impacts = 0;
    for _ in 0..steps {
        let step = scheme.step().expect("the stick steps");
        let work = step.contacts.first().map(|contact| contact.tangential_work);
        let state = scheme.state();
        let (q, v) = stick.at(state.time);
        let dq = (Vector3::from_column_slice(&state.q) - q).amax();
        let dv = (Vector3::from_column_slice(&state.v) - v).amax();
        far.q = far.q.max(dq);
        far.v_l1 += h * dv;
        far.v_l2 += h * dv * dv;
        far.v_max = far.v_max.max(dv);
        (far.end_q, far.end_v) = (dq, dv);
        if let Some(work) = work {
            far.times = far.times.max((state.time - limit.times[impacts]).abs());
            far.works = far.works.max((work - limit.works[impacts]).abs());
            impacts += 1;
        }
    }
    assert_eq!(impacts, 2, "{law}, h = {h}");
    far.v_l2 = far.v_l2.sqrt();
    far
}

#[test]
fn measure() {
    for limit in &LIMITS {
        let stick = reference(limit.law);
        let mut scene = scene();
        let steps = log_spaced(1e-5, 1e-3, 120);
        let mut all = Vec::new();
        for &h in &steps {
            scene.time.step = h;
            scene.time.end = (END / h).floor() * h;
            all.push(distance(&scene, limit.law, &stick, limit));
        }
        type Get = fn(&Distance) -> f64;
        let list: [(&str, Get); 8] = [
            ("q", |d| d.q),
            ("v1", |d| d.v_l1),
            ("v2", |d| d.v_l2),
            ("vmax", |d| d.v_max),
            ("t", |d| d.times),
            ("w", |d| d.works),
            ("endq", |d| d.end_q),
            ("endv", |d| d.end_v),
        ];
        for (name, f) in list {
            let e: Vec<f64> = all.iter().map(f).collect();
            let c: Vec<f64> = e.iter().zip(&steps).map(|(e, h)| e / h).collect();
            println!(
                "{} {name:5} order {:.3} C {:.3} .. {:.3}",
                limit.law,
                order(&steps, &e),
                c.iter().cloned().fold(f64::INFINITY, f64::min),
                c.iter().cloned().fold(0.0, f64::max)
            );
        }
    }
}
