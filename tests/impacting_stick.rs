//! The impacting stick of Acary & Collins-Craft (2024), section 5.1: the impacts of both laws to the last digit, with
//! every solver.
#![cfg(all(feature = "scene", feature = "outputs"))]

#[path = "mechanics/example.rs"]
mod example;

use std::sync::atomic::AtomicBool;

use example::scheme;
use nonsmooth::observe::{RunInfo, RunSummary, SummaryRecorder};
use nonsmooth::scalar::Scalar;
use nonsmooth::scene::Scene;
use nonsmooth::simulate::{Ended, Stepper};
use nonsmooth::solver::SOLVERS;

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

fn scene() -> Scene {
    example::scene("impacting_stick")
}

fn summary<T: Scalar>(scene: &Scene, law: &str, solver: &str) -> RunSummary {
    let (scheme, steps) = scheme::<T, 2>(scene, law, solver);
    let info = RunInfo::new(law, solver, vec![law.into()], scheme.settings());
    let mut recorder = SummaryRecorder::default();
    let ended = Stepper::from(scheme).run(steps, &info, &mut [&mut recorder], &AtomicBool::new(false));
    assert!(matches!(ended, Ok(Ended::Completed)), "{law}, {solver}");
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
            // 0.47 m/s that is one step of 4.7e-5 m. An impact a step late is one of g h = 1e-3 m/s more, which
            // friction of 3.7e-3 N s makes 4e-6 J.
            assert_impacts(&run, 1, 3e-3, 1e-5);
            // 64 ε: the terms of (56) at an impact are as large as E, and there are ten of them.
            let imbalance = run.max_imbalance / run.max_energy;
            assert!(imbalance <= 64.0 * f64::from(f32::EPSILON), "{law}, {}: {imbalance:e}", solver.name);
        }
    }
}
