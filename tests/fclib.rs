//! FCLIB files: what is read, what is written, what is refused.
#![cfg(feature = "fclib")]

use std::path::{Path, PathBuf};

use nalgebra::{DMatrix, DVector};
use nonsmooth::cone::ConeProblem;
use nonsmooth::fclib::{self, Cone, FclibError, Solution, WriteOptions};

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
        for i in 0..m {
            p.delassus().row(i).for_each(|(j, block)| w.view_mut((i * D, j * D), (D, D)).copy_from(block));
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
