//! Runs from Rust: a scene in three lines, the same files as the command line, planar scenes without a file.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;

use nonsmooth::cone::{ArraysError, ConeProblem};
use nonsmooth::laws::{Fremond, NewtonCoulomb};
use nonsmooth::observe::{Frame, ObserveError, Observer};
use nonsmooth::planar::{PlanarError, PlanarScene, Shape, body};
use nonsmooth::run::{Checkpoints, WriteError, WriteOptions};
use nonsmooth::scalar::Scalar;
use nonsmooth::scene::{ScalarName, Scene, contact_dimension};
use nonsmooth::scheme::Settings;
use nonsmooth::simulate::Ended;

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name)
}

/// The cells of a table below its header.
fn rows(path: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    text.lines().skip(1).map(|line| line.split(',').map(String::from).collect()).collect()
}

/// A sink of one's own.
#[derive(Default)]
struct Count(usize);

impl<T: Scalar, const D: usize> Observer<T, D> for Count {
    fn step(&mut self, _frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        self.0 += 1;
        Ok(())
    }
}

#[test]
fn a_scene_runs_in_three_lines_and_its_arrays_are_the_tables_of_the_command_line() {
    let folder = tempfile::tempdir().expect("a folder");
    for scalar in ["f64", "f32"] {
        let mut scene = Scene::read(example("bouncing_ball.toml")).expect("an example");
        (scene.time.step, scene.time.end) = (1e-2, 1.0);
        scene.scalar = if scalar == "f64" { ScalarName::F64 } else { ScalarName::F32 };
        let runs = scene.run(&nonsmooth::registry()).expect("two runs");

        let out = folder.path().join(scalar);
        let path = example("bouncing_ball.toml");
        let arguments = ["--step", "1e-2", "--end", "1.0", "--no-figures", "--scalar", scalar];
        let mut program = Command::new(env!("CARGO_BIN_EXE_nonsmooth"));
        let program = program.arg("run").arg(&path).args(arguments).arg("--out").arg(&out);
        assert!(program.output().expect("the program").status.success());

        let (trajectory, energy) = (rows(&out.join("trajectory.csv")), rows(&out.join("energy.csv")));
        let contacts = rows(&out.join("contacts.csv"));
        let number = |cell: &String| cell.parse::<f64>().expect("a number");
        assert_eq!(runs.iter().map(|run| run.times.len()).sum::<usize>(), trajectory.len());
        let states = runs.iter().flat_map(|run| (0..run.times.len()).map(move |k| (run, k)));
        for (((run, k), row), energies) in states.zip(&trajectory).zip(&energy) {
            assert_eq!((&row[0], number(&row[3])), (&run.law, run.times[k]));
            let state: Vec<f64> = run.q[k].iter().chain(&run.v[k]).copied().collect();
            assert_eq!(state, row[4..].iter().map(number).collect::<Vec<f64>>());
            assert_eq!(run.energies[k].kinetic, number(&energies[4]));
        }
        let active: Vec<_> = runs.iter().flat_map(|run| run.contacts.iter().flatten()).collect();
        assert!(!active.is_empty() && active.len() == contacts.len());
        for (contact, row) in active.iter().zip(&contacts) {
            assert_eq!((&contact.contact, contact.percussion[0]), (&row[4], number(&row[9])));
        }
    }
}

#[test]
fn a_scene_is_written_as_the_command_line_writes_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let (own, program) = (folder.path().join("own"), folder.path().join("program"));
    let path = example("impacting_stick.toml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_nonsmooth"));
    command.arg("run").arg(&path).args(["--step", "1e-3"]).arg("--out").arg(&program);
    assert!(command.output().expect("the program").status.success());

    let mut scene = Scene::read(&path).expect("an example");
    scene.time.step = 1e-3;
    let options = WriteOptions::new(&own).scene_file(&path);
    let begun = std::cell::Cell::new(0);
    let mut watch = |_: &_| -> Box<dyn nonsmooth::simulate::Sink> {
        begun.set(begun.get() + 1);
        Box::new(Count::default())
    };
    let written = scene
        .write(&nonsmooth::registry(), &options, &mut watch, &AtomicBool::new(false))
        .expect("the folder can be written to");
    assert!(written.failure.is_none() && !written.interrupted && written.summaries.len() == begun.get());

    let mut names: Vec<_> = std::fs::read_dir(&program)
        .expect("results")
        .map(|entry| entry.expect("an entry").file_name())
        .collect();
    names.sort();
    assert!(names.len() > 6, "{names:?}");
    for name in names {
        let [a, b] = [&own, &program].map(|folder| std::fs::read(folder.join(&name)).expect("a file"));
        // Its times are its own.
        if name != "summary.json" {
            assert!(a == b, "{} differs", name.display());
        }
    }

    scene.time.adaptive = Some(nonsmooth::scene::AdaptiveSpec::new(1e-3));
    let options = WriteOptions::new(&own).checkpoints(Checkpoints::Every(10));
    let refused = scene.write(&nonsmooth::registry(), &options, &mut watch, &AtomicBool::new(false));
    assert!(matches!(refused, Err(WriteError::AdaptiveCheckpoint)));
}

#[test]
fn a_simulation_is_steered_and_goes_back() {
    let registry = nonsmooth::registry();
    let scene = Scene::read(example("impacting_stick.toml")).expect("an example");
    let runs = scene.runs(&registry).expect("laws and solvers");
    let dimension = contact_dimension(&scene, &runs, &registry).expect("laws");
    let mut simulation = scene.simulation(&runs[0], dimension, &registry).expect("a run");
    let start = simulation.snapshot().expect("fixed steps");
    let mut count = Count::default();
    let stop = AtomicBool::new(false);
    let first = simulation.advance(10, &mut [&mut count], &stop);
    assert!(matches!(first, Ok(Ended::Completed)));
    let reached = (simulation.time(), simulation.q(), simulation.v());
    assert_eq!((count.0, simulation.index(), reached.1.len()), (10, 10, simulation.dofs()));
    simulation.restore(&start).expect("its own snapshot");
    assert_eq!(simulation.index(), 0);
    stop.store(true, std::sync::atomic::Ordering::Relaxed);
    assert!(matches!(simulation.advance(10, &mut [], &stop), Ok(Ended::Interrupted)));
    stop.store(false, std::sync::atomic::Ordering::Relaxed);
    simulation.advance(10, &mut [], &stop).expect("the same steps");
    assert_eq!((simulation.time(), simulation.q(), simulation.v()), reached);
}

#[test]
fn a_planar_scene_from_rust_is_that_of_the_file() {
    let mut file = Scene::read(example("my_laws/ball.toml")).expect("an example");
    file.laws = vec!["fremond".into()];
    file.interfaces[0].parameters.remove("half_speed");
    file.interfaces[0].parameters.insert("restitution".into(), 0.2);
    let of_file = file.run(&nonsmooth::registry()).expect("a run");

    let mut scene = PlanarScene::new();
    let ball = scene.add(body(Shape::disc(0.1)).inertia(4e-3).at(0.0, 1.1).moving(1.0, 0.0));
    let floor = scene.half_plane("floor", [0.0, 0.0], [0.0, 1.0]);
    scene.interface(ball, floor, Fremond::new(0.2, 0.3).expect("in range"));
    scene.gravity(0.0, -10.0);
    let run = scene.run(Settings::new(0.5, 1e-3), 1.5).expect("a run");
    assert_eq!((&run.times, &run.q, &run.v), (&of_file[0].times, &of_file[0].q, &of_file[0].v));
}

#[test]
fn the_builder_gives_homogeneous_bodies_their_inertia_and_tells_what_is_wrong() {
    let mut scene = PlanarScene::new();
    let box_of_two = scene.add(body(Shape::rectangle(2.0, 1.0)).mass(12.0).at(0.0, 0.5));
    let floor = scene.half_plane("floor", [0.0, 0.0], [0.0, 2.0]);
    scene.interface(floor, box_of_two, NewtonCoulomb::new(0.0, 0.5).expect("in range"));
    // The one given last counts.
    scene.interface(floor, box_of_two, Fremond::new(0.0, 0.5).expect("in range"));
    scene.pin("hinge", box_of_two, [1.0, 0.0], None, [1.0, 0.5]);
    let scheme = scene.scheme(Settings::new(0.5, 1e-3)).expect("a scene");
    assert_eq!(scheme.laws()[0].name(), "fremond");
    // m (a² + b²)/12.
    let mut momentum = vec![0.0; 3];
    scheme.system().mass().multiply(&[0.0, 0.0, 1.0], &mut momentum);
    assert!((momentum[2] - 5.0).abs() < 1e-12, "{momentum:?}");

    let mut wrong = PlanarScene::new();
    wrong.add(body(Shape::disc(1.0)).named("light").mass(-1.0));
    wrong.add(body(Shape::polygon([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]])));
    let error = wrong.run(Settings::new(0.5, 1e-3), 1.0).expect_err("a negative mass");
    assert!(matches!(&error, PlanarError::System(_)) && error.to_string().contains("light"), "{error}");
    let mut endless = PlanarScene::new();
    endless.add(body(Shape::point()));
    let error = endless.run(Settings::new(0.5, 1e-3), f64::INFINITY).expect_err("no end");
    assert!(matches!(error, PlanarError::End { .. }));
}

#[test]
fn cone_problems_come_from_dense_and_from_compressed_arrays() {
    let dense = [2.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 2.0];
    let (b, friction) = ([-1.0, 0.5, -1.0, 0.0], [0.3, 0.4]);
    let of_dense = ConeProblem::<f64, 2>::from_dense(&dense, &b, &friction).expect("a problem");
    // In any order within a row, and the diagonal of the last row in two parts.
    let (starts, columns) = ([0, 2, 3, 5, 7], [2, 0, 1, 2, 0, 3, 3]);
    let values = [1.0, 2.0, 2.0, 2.0, 1.0, 1.5, 0.5];
    let of_rows =
        ConeProblem::<f64, 2>::from_csr(&starts, &columns, &values, &b, &friction).expect("a problem");
    let r = [nalgebra::vector![0.7, -0.1], nalgebra::vector![0.3, 0.2]];
    for contact in 0..2 {
        assert_eq!(of_dense.shifted_velocity(contact, &r), of_rows.shifted_velocity(contact, &r));
    }
    let short = ConeProblem::<f64, 2>::from_dense(&dense[1..], &b, &friction).expect_err("15 entries");
    assert_eq!(short, ArraysError::Length { what: "W", expected: 16, given: 15 });
    let refused = |starts: &[usize], columns: &[usize]| {
        ConeProblem::<f64, 2>::from_csr(starts, columns, &values, &b, &friction).expect_err("no such matrix")
    };
    assert!(matches!(refused(&[0, 3, 2, 5, 7], &columns), ArraysError::RowStart { row: 1, .. }));
    assert!(matches!(refused(&[0, 2, 3, 5, 6], &columns), ArraysError::RowStart { row: 3, .. }));
    assert!(matches!(
        refused(&starts, &[2, 0, 1, 2, 9, 3, 3]),
        ArraysError::Column { row: 2, column: 9, .. }
    ));
    let none = ConeProblem::<f64, 3>::from_dense(&[], &[], &[]).expect("no contact");
    assert_eq!(none.contacts(), 0);
}
