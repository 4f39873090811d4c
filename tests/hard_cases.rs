//! The hard cases at the sizes of every test run, with the default solver and every law; the table of
//! `cargo run --release --example hard_cases` has the full sizes and the other solvers.

#[path = "../examples/hard_cases/cases/mod.rs"]
#[allow(dead_code, unused_imports)]
mod cases;

use cases::Choice;
use nonsmooth::solver::DEFAULT;

/// Runs the cases whose name starts with `name` under every law, and says what missed.
fn holds(name: &str) {
    let chosen: Vec<_> = cases::all().into_iter().filter(|case| case.name.starts_with(name)).collect();
    assert!(!chosen.is_empty(), "no case is called {name}");
    for case in chosen {
        for &(scalar, run) in case.runs {
            // Single precision has its lines in the table; which of its cases hold depends on the solver.
            if scalar != "f64" {
                continue;
            }
            for law in cases::laws() {
                let choice = Choice { law: law.name, solver: DEFAULT, full: false };
                let outcome = run(&choice).unwrap_or_else(|e| panic!("{}, {}: {e}", case.name, law.name));
                for check in &outcome.checks {
                    assert!(check.holds(), "{}, {}: {check:?}", case.name, law.name);
                }
                assert!(outcome.steps > 0, "{}: steps were made", case.name);
            }
        }
    }
}

macro_rules! hard_cases {
    ($($test:ident: $name:literal),+ $(,)?) => {
        $(
            #[test]
            fn $test() {
                holds($name);
            }
        )+

        #[test]
        fn every_case_has_its_test() {
            let names = [$($name),+];
            for case in cases::all() {
                assert!(names.iter().any(|name| case.name.starts_with(name)), "{} has no test", case.name);
            }
        }
    };
}

hard_cases! {
    the_bouncing_ball_comes_to_rest_in_time_and_exactly: "bouncing ball",
    three_touching_balls_share_the_momentum: "three touching balls",
    the_painleve_rod_has_a_solution_at_every_step: "Painlevé",
    newton_creates_energy_at_kanes_pendulum_and_fremond_does_not: "Kane",
    sliding_turns_into_rolling: "disc and sphere",
    the_block_on_an_incline_sticks_exactly_or_slides: "block on an incline",
    a_light_block_carries_a_heavy_one: "top-heavy stack",
    the_hyperstatic_block_moves_the_same_whatever_its_points: "hyperstatic",
    the_hanging_chain_carries_what_hangs_below: "1,000-link",
    the_thick_arch_stands_and_the_thin_one_falls: "semicircular arch",
    the_rocking_block_loses_what_housner_says: "rocking block",
    the_belt_holds_by_the_exponential_of_its_angle: "capstan",
    the_impact_oscillator_keeps_its_orbit: "grazing impact",
    a_stiff_block_never_gains_energy_at_its_contacts: "stiff elastic block",
    contacts_given_twice_are_contacts_given_once: "near-parallel",
    long_runs_stay_round_off: "10⁷ steps",
}
