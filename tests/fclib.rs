//! FCLIB files: what is read, what is written, what is refused.
#![cfg(feature = "fclib")]

mod problems;

use std::path::{Path, PathBuf};

use nalgebra::{DMatrix, DVector};
use nonsmooth::cone::{BlockMatrix, ConeProblem, Form, Status, solve_one_contact, status};
use nonsmooth::fclib::{
    self, Cone, Data, FclibError, Global, GlobalBilateral, Info, Local, LocalBilateral, Problem, Solution,
    SparseMatrix, WriteOptions,
};
use nonsmooth::solver::{self, Stopping};

/// The files of a folder in order, none where it does not exist.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .map(|entries| entries.filter_map(|entry| Some(entry.ok()?.path())).collect())
        .unwrap_or_default();
    files.retain(|file| file.extension().is_some_and(|e| e == "hdf5"));
    files.sort();
    files
}

fn public(kind: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/fclib").join(kind);
    let files = files(&folder);
    if files.is_empty() {
        println!("skipped: no public problems in {}", folder.display());
    }
    files
}

#[test]
fn every_public_problem_is_a_cone_problem() {
    for file in public("local").into_iter().chain(public("global")) {
        let problem = fclib::read(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        let cone = problem.cone().unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        println!("{}: {} contacts of dimension {}", file.display(), cone.contacts(), cone.dimension());
        assert_eq!((cone.contacts(), cone.dimension()), (problem.contacts(), problem.dimension));
    }
}

/// ‖a − b‖∞ / ‖b‖∞ over the scalars of two operators with the same contacts.
fn distance<const D: usize>(a: &ConeProblem<f64, D>, b: &ConeProblem<f64, D>) -> (f64, f64) {
    let dense = |p: &ConeProblem<f64, D>| {
        let m = p.contacts();
        let mut w = DMatrix::zeros(m * D, m * D);
        let mut own = BlockMatrix::new();
        let delassus = p.delassus().form_in(&mut own);
        for i in 0..m {
            delassus.row(i).for_each(|(j, block)| w.view_mut((i * D, j * D), (D, D)).copy_from(block));
        }
        w
    };
    let (v, w) = (dense(a), dense(b));
    let free =
        |p: &ConeProblem<f64, D>| DVector::from_iterator(p.contacts() * D, p.b().iter().flatten().copied());
    let (q, r) = (free(a), free(b));
    ((v - &w).amax() / w.amax(), (q - &r).amax() / r.amax().max(f64::MIN_POSITIVE))
}

#[test]
fn bodies_condense_to_the_published_local_problem() {
    for file in public("global") {
        let Some(twin) = public("local").into_iter().find(|local| local.file_name() == file.file_name())
        else {
            continue;
        };
        let [a, b] = [&file, &twin].map(|f| fclib::read(f).and_then(|p| p.cone()).expect("a public problem"));
        let (w, q) = match (&a, &b) {
            (Cone::Planar(a), Cone::Planar(b)) => distance(a, b),
            (Cone::Spatial(a), Cone::Spatial(b)) => distance(a, b),
            _ => panic!("{}: the two files differ in dimension", file.display()),
        };
        println!("{}: W differs by {w:e}, b by {q:e}", file.display());
        // Two condensations in double precision, of masses whose condition is below 1e4: 1e4 ε = 2e-12.
        assert!(w <= 2e-12 && q <= 2e-12, "{}: W differs by {w:e}, b by {q:e}", file.display());
    }
}

/// A folder of its own for a test, emptied at the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("nonsmooth-fclib-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        Self(folder)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        if std::env::var_os("KEEP").is_none() {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }
}

#[test]
fn what_is_written_reads_back_the_same() {
    let scratch = Scratch::new("round-trip");
    for (k, file) in public("local").iter().chain(&public("global")).enumerate() {
        let mut problem = fclib::read(file).expect("a public problem");
        let n = problem.dimension * problem.contacts();
        let solution = |scale: f64| Solution {
            percussions: (0..n).map(|i| scale * i as f64).collect(),
            velocities: (0..n).map(|i| scale / (1 + i) as f64).collect(),
            ..Solution::default()
        };
        problem.guesses = vec![solution(1.0), solution(-0.1)];
        problem.solution = Some(solution(1e-300));
        for gzip in [None, Some(6)] {
            let copy = scratch.0.join(format!("{k}-{}.hdf5", gzip.unwrap_or(0)));
            fclib::write(&copy, &problem, WriteOptions { gzip }).expect("a writable folder");
            assert_eq!(fclib::read(&copy).expect("a file of our own"), problem, "{}", file.display());
        }
    }
}

#[test]
fn a_solution_joins_its_problem_and_replaces_the_one_before() {
    let scratch = Scratch::new("solution");
    for (k, file) in public("local").iter().chain(&public("global")).enumerate() {
        let mut problem = fclib::read(file).expect("a public problem");
        let copy = scratch.0.join(format!("{k}.hdf5"));
        std::fs::write(&copy, std::fs::read(file).expect("a public problem")).expect("a writable folder");
        let n = problem.dimension * problem.contacts();
        for value in [1.0, 2.0] {
            let (percussions, velocities) = (vec![value; n], vec![-value; n]);
            let solution = Solution { percussions, velocities, ..Solution::default() };
            fclib::write_solution(&copy, &solution).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
            problem.solution = Some(solution);
            assert_eq!(fclib::read(&copy).expect("a file of our own"), problem, "{}", file.display());
        }
        let short =
            Solution { percussions: vec![0.0; n - 1], velocities: vec![0.0; n], ..Solution::default() };
        assert!(matches!(fclib::write_solution(&copy, &short), Err(FclibError::Length { .. })));
        assert_eq!(fclib::read(&copy).expect("untouched by what was refused"), problem);
    }
}

#[test]
fn the_problems_of_our_own_are_what_their_generator_makes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let made = problems::all().expect("the generator");
    for problems::Named { name, problem } in &made {
        let stored = fclib::read(folder.join(format!("{name}.hdf5"))).expect(name);
        assert_eq!(&stored, problem, "{name}: run `cargo run --example make_problems`");
    }
    assert_eq!(files(&folder).len(), made.len(), "every file of {} is made", folder.display());
}

#[test]
fn bodies_and_their_local_problem_say_the_same() {
    let made = problems::all().expect("the generator");
    let find = |name: &str| made.iter().find(|p| p.name == name).expect("a problem of ours").problem.cone();
    for name in ["planar-three", "planar-ten", "spatial-three", "spatial-ten"] {
        assert_eq!(find(&format!("{name}-global")).expect(name), find(name).expect(name), "{name}");
    }
}

/// With H and M kept, W and b are those of the condensed problem, and the solution solves it.
#[test]
fn bodies_that_are_kept_pose_the_condensed_problem() {
    for problems::Named { name, problem } in problems::all().expect("the generator") {
        let Data::Global(global) = &problem.data else { continue };
        let kept = problem.cone_in(Form::Factored).expect("a cone problem");
        let (differ, factored) = match (&kept, problem.cone().expect("a cone problem")) {
            (Cone::Planar(a), Cone::Planar(b)) => (distance(a, &b), a.factors().is_some()),
            (Cone::Spatial(a), Cone::Spatial(b)) => (distance(a, &b), a.factors().is_some()),
            _ => panic!("{name}: another dimension"),
        };
        assert_eq!(factored, global.bilateral.is_none(), "{name}");
        assert!(differ.0 <= 1e-12 && differ.1 <= 1e-12, "{name}: {differ:?}");
        let solved = |cone: &Cone| match cone {
            Cone::Planar(cone) => solved_by_default(cone),
            Cone::Spatial(cone) => solved_by_default(cone),
        };
        assert!(solved(&kept) <= 1e-10, "{name}");
    }
}

fn solved_by_default<const D: usize>(cone: &ConeProblem<f64, D>) -> f64 {
    let mut solver = solver::build::<f64, D>(solver::DEFAULT, Stopping::default()).expect("registered");
    let zero = vec![nalgebra::SVector::zeros(); cone.contacts()];
    let mut r = zero.clone();
    solver.solve(cone, &zero, &mut r).map_or(f64::INFINITY, |solution| solution.residual.scaled)
}

#[test]
fn one_contact_takes_off_sticks_or_slides_as_its_file_says() {
    let made = problems::all().expect("the generator");
    let expected = [("take-off", Status::TakeOff), ("stick", Status::Stick), ("slide", Status::Slide)];
    for (suffix, expected) in expected {
        for dimension in ["planar", "spatial"] {
            let name = format!("{dimension}-{suffix}");
            let problem = &made.iter().find(|p| p.name == name).expect("a problem of ours").problem;
            let found = match problem.cone().expect("a cone problem") {
                Cone::Planar(cone) => status_of_one(&cone),
                Cone::Spatial(cone) => status_of_one(&cone),
            };
            assert_eq!(found, expected, "{name}");
        }
    }
}

fn status_of_one<const D: usize>(cone: &ConeProblem<f64, D>) -> Status {
    let r = solve_one_contact(cone.diagonal(0), &cone.b()[0], cone.cones()[0]);
    // The exact solution of one contact: nothing but rounding is left.
    assert!(cone.residual(&[r]).scaled <= 64.0 * f64::EPSILON);
    status(&r, cone.cones()[0], 64.0 * f64::EPSILON)
}

/// A planar bead on a rod along x (a bilateral constraint on z): what the joint carries must not reach W.
#[test]
fn bilateral_constraints_are_eliminated() {
    let (mass, inertia, free) = (2.0, 3.0, [1.5, -4.0, 0.5]);
    // One contact along x: N = x, T = z, at an arm that couples both to the turning.
    let (n, t) = ([1.0, 0.0, 0.4], [0.0, 1.0, -0.7]);
    let entries: Vec<_> = (0..3_u32).flat_map(|i| [(i, 0, n[i as usize]), (i, 1, t[i as usize])]).collect();
    let masses = [mass, mass, inertia];
    let diagonal: Vec<_> = (0..3_u32).map(|i| (i, i, masses[i as usize])).collect();
    let guided = 0.25;
    let global = Problem {
        info: Info::default(),
        dimension: 2,
        friction: vec![0.3],
        data: Data::Global(Global {
            mass: SparseMatrix::from_entries(3, 3, &diagonal),
            directions: SparseMatrix::from_entries(3, 2, &entries),
            force: (0..3).map(|i| masses[i] * free[i]).collect(),
            velocity: vec![0.0, 0.0],
            // The joint asks for v_z = 0.25: Gᵀ v + b = 0.
            bilateral: Some(GlobalBilateral {
                directions: SparseMatrix::from_entries(3, 1, &[(1, 0, 1.0)]),
                velocity: vec![-guided],
            }),
        }),
        guesses: Vec::new(),
        solution: None,
    };
    // With v_z given, x and the turning remain.
    let w = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] / mass + a[2] * b[2] / inertia;
    let expected = [[w(n, n), w(n, t)], [w(t, n), w(t, t)]];
    let b = [n, t].map(|e| e[0] * free[0] + e[1] * guided + e[2] * free[2]);
    let close = |cone: Cone| {
        let Cone::Planar(cone) = cone else { panic!("a planar problem") };
        for i in 0..2 {
            // A handful of roundings on numbers of order one.
            assert!((cone.b()[0][i] - b[i]).abs() <= 16.0 * f64::EPSILON);
            (0..2).for_each(|j| {
                assert!((cone.diagonal(0)[(i, j)] - expected[i][j]).abs() <= 16.0 * f64::EPSILON)
            });
        }
    };
    close(global.cone().expect("a regular problem"));
    let global_solution = global.solution(vec![0.7, -0.2]).expect("a regular problem");

    // The same joint in a local problem: W, V, R of the bodies without it.
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| a[i] * b[i] / masses[i]).sum::<f64>();
    let g = [0.0, 1.0, 0.0];
    let full = [(0, 0, dot(n, n)), (0, 1, dot(n, t)), (1, 0, dot(t, n)), (1, 1, dot(t, t))];
    let local = Local {
        delassus: SparseMatrix::from_entries(2, 2, &full),
        velocity: [n, t].map(|e| (0..3).map(|i| e[i] * free[i]).sum()).to_vec(),
        bilateral: Some(LocalBilateral {
            directions: SparseMatrix::from_entries(2, 1, &[(0, 0, dot(n, g)), (1, 0, dot(t, g))]),
            compliance: SparseMatrix::from_entries(1, 1, &[(0, 0, dot(g, g))]),
            velocity: vec![free[1] - guided],
        }),
    };
    let local = Problem { data: Data::Local(local), ..global };
    close(local.cone().expect("a regular problem"));

    // Bodies and joint under a percussion, from both forms; the joint holds.
    let r = vec![0.7, -0.2];
    let (a, b) = (global_solution, local.solution(r).expect("a regular problem"));
    let velocity = a.body_velocities.expect("a global problem has bodies");
    assert!((velocity[1] - guided).abs() <= 16.0 * f64::EPSILON);
    for (x, y) in [(&a.velocities, &b.velocities), (&a.multipliers.unwrap(), &b.multipliers.unwrap())] {
        assert!(x.iter().zip(y).all(|(x, y)| (x - y).abs() <= 64.0 * f64::EPSILON), "{x:?} {y:?}");
    }

    let bytes = fclib::write_bytes(&local, WriteOptions::default()).expect("a file");
    assert_eq!(fclib::read_bytes(bytes).expect("a file of our own"), local);
}
