//! FCLIB files: what is read, what is written, what is refused.
#![cfg(feature = "fclib")]

use std::path::{Path, PathBuf};

use nalgebra::{DMatrix, DVector};
use nonsmooth::cone::ConeProblem;
use nonsmooth::fclib::{self, Cone};

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
