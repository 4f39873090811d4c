//! A program of one's own with a law of one's own, as `examples/my_laws` is: the law in scene files, studies, on the
//! command line and under the property suite.

#[path = "../examples/my_laws/speed_dependent.rs"]
mod speed_dependent;

use std::path::{Path, PathBuf};

use nonsmooth::laws::{self, LawError, LawFamily as _};
use nonsmooth::registry::{Registry, RegistryError};
use nonsmooth::solver::{self, Nsgs, Stopping, UnknownSolver};
use nonsmooth::suite::{Suite, check_law};
use speed_dependent::SpeedDependent;

fn registry() -> Registry {
    nonsmooth::registry().law(laws::family!(SpeedDependent<T>)).expect("a new name")
}

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/my_laws").join(name)
}

#[test]
fn the_law_passes_the_suite_of_the_built_in_ones() {
    let description = SpeedDependent::<f64>::DESCRIPTION;
    let draw = |unit: &[f64]| SpeedDependent::try_new(&description.draw(unit)).expect("in range");
    check_law(&Suite { cases: 8, ..Suite::default() }, description.parameters.len(), draw).unwrap();
}

#[test]
fn a_registry_holds_what_it_was_given_and_names_are_taken_once() {
    let registry = registry();
    assert_eq!(registry.laws().count(), laws::LAWS.len() + 1);
    assert_eq!(registry.laws().last().map(|law| law.name), Some("speed-dependent"));
    let law = registry.build_law::<f32, 3>("speed-dependent", &[1.0, 0.0]).expect("in range");
    assert_eq!(law.rows(), laws::Rows::Normal);
    let refused = registry.build_law::<f64, 2>("speed-dependent", &[-1.0, 0.0]).expect_err("out of range");
    assert!(matches!(refused, LawError::OutOfRange { value: -1.0, .. }));
    let unsupported = registry.find_law("speed-dependent").expect("registered").build::<f64, 4>(&[1.0, 0.0]);
    assert!(matches!(unsupported, Err(LawError::Unsupported { dimension: 4, .. })));

    let taken = registry.law(laws::family!(SpeedDependent<T>)).expect_err("registered already");
    assert_eq!(taken, RegistryError::LawTaken { name: "speed-dependent" });
    let taken = nonsmooth::registry().solver(solver::family!(Nsgs<T, D>)).expect_err("registered already");
    assert_eq!(taken, RegistryError::SolverTaken { name: "nsgs" });

    let small = Registry::empty().solver(solver::family!(Nsgs<T, D>)).expect("the first");
    assert_eq!(small.build_solver::<f64, 3>("nsgs", Stopping::default()).expect("registered").name(), "nsgs");
    let Err(UnknownSolver::Name { known, .. }) = small.build_solver::<f64, 3>("admm", Stopping::default())
    else {
        panic!("only one solver is registered")
    };
    assert_eq!(known, "nsgs");
}

#[test]
fn the_program_runs_the_law_in_a_scene_and_in_a_study() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = |name: &str| folder.path().join(name).display().to_string();
    let (ball, study) = (example("ball.toml").display().to_string(), example("study.toml"));
    let study = study.display().to_string();
    let run = |arguments: &[&str]| nonsmooth::cli::run_with(&registry(), ["my_laws"].iter().chain(arguments));

    run(&["run", &ball, "--out", &out("run"), "--no-figures"]);
    let summary = std::fs::read_to_string(folder.path().join("run/summary.json")).expect("a summary");
    assert!(summary.contains("\"law\": \"speed-dependent\""));
    // The first impact at u_N = −√(2 g h): e = c/(c + |u_N|) under the own law.
    let contacts = std::fs::read_to_string(folder.path().join("run/contacts.csv")).expect("a table");
    let column = |name: &str| {
        let header = contacts.lines().next().expect("a header");
        header.split(',').position(|column| column == name).expect("a column")
    };
    let (before, after) = (column("u_before_N"), column("u_after_N"));
    let number = |line: &str, column: usize| -> f64 {
        line.split(',').nth(column).and_then(|cell| cell.parse().ok()).expect("a number")
    };
    let impact = contacts.lines().find(|line| line.starts_with("speed-dependent")).expect("an impact");
    let speed = -number(impact, before);
    assert!((number(impact, after) / speed - 1.0 / (1.0 + speed)).abs() < 1e-10, "{impact}");

    run(&["study", &study, "--out", &out("study"), "--no-figures", "--threads", "1"]);
    let rows = std::fs::read_to_string(folder.path().join("study/runs.csv")).expect("a table");
    let of_law = rows.lines().filter(|row| row.starts_with("speed-dependent")).collect::<Vec<_>>();
    assert!(of_law.len() == 8 && of_law.iter().all(|row| row.contains(",true,,")), "{rows}");
}
