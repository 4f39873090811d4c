//! Collections of problem files: solved one by one, and compared solver by solver.
#![cfg(feature = "collection")]

use std::path::{Path, PathBuf};

use nonsmooth::collection::{
    Benchmark, BenchmarkOptions, CollectionError, SolveOptions, Statuses, problem_files, solve_file,
    solve_files,
};
use nonsmooth::cone::Form;
use nonsmooth::fclib::{self, Data, Info, Local, Problem, SparseMatrix, WriteOptions};

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data")
}

fn ours(names: &[&str]) -> Vec<PathBuf> {
    names.iter().map(|name| data().join(format!("{name}.hdf5"))).collect()
}

/// A body between two walls that close in on it: W = [1 −1; −1 1] along the normals, b = (−1, −1).
fn squeezed(folder: &Path) -> PathBuf {
    let entries = [(0, 0, 1.0), (0, 2, -1.0), (2, 0, -1.0), (2, 2, 1.0), (1, 1, 1.0), (3, 3, 1.0)];
    let delassus = SparseMatrix::from_entries(4, 4, &entries);
    let problem = Problem {
        info: Info::default(),
        dimension: 2,
        friction: vec![0.0; 2],
        data: Data::Local(Local { delassus, velocity: vec![-1.0, 0.0, -1.0, 0.0], bilateral: None }),
        guesses: Vec::new(),
        solution: None,
    };
    let path = folder.join("squeezed.hdf5");
    fclib::write(&path, &problem, WriteOptions::default()).expect("a writable folder");
    path
}

#[test]
fn every_problem_of_ours_is_solved_and_told_in_one_line() {
    let files = problem_files(data()).expect("tests/data");
    let mut out = Vec::new();
    let solved = solve_files(&nonsmooth::registry(), &files, &SolveOptions::default(), true, &mut out)
        .expect("a known solver");
    let text = String::from_utf8(out).expect("UTF-8");
    for report in &solved.reports {
        assert!(report.converged, "{report:?}");
        assert!(report.scaled_residual <= 1e-10, "{report:?}");
    }
    assert_eq!((solved.exit_code(), solved.reports.len()), (0, files.len()));
    assert_eq!(text.lines().count(), files.len());

    let keys = [
        "problem",
        "contacts",
        "dimension",
        "solver",
        "converged",
        "iterations",
        "residual",
        "scaled_residual",
        "cpu_seconds",
        "status",
    ];
    for line in text.lines() {
        let line: serde_json::Value = serde_json::from_str(line).expect("one JSON object per line");
        let object = line.as_object().expect("an object");
        assert_eq!(object.keys().len(), keys.len(), "{line}");
        assert!(keys.iter().all(|key| object.contains_key(*key)), "{line}");
        let status = &line["status"];
        let sum: u64 =
            ["take_off", "stick", "slide"].iter().map(|s| status[s].as_u64().expect("a number")).sum();
        assert_eq!(sum, line["contacts"].as_u64().expect("a number"));
    }
}

#[test]
fn one_contact_takes_off_sticks_and_slides() {
    let expected = [
        ("take-off", Statuses { take_off: 1, stick: 0, slide: 0 }),
        ("stick", Statuses { take_off: 0, stick: 1, slide: 0 }),
        ("slide", Statuses { take_off: 0, stick: 0, slide: 1 }),
    ];
    for (suffix, status) in expected {
        for dimension in ["planar", "spatial"] {
            let file = data().join(format!("{dimension}-{suffix}.hdf5"));
            assert_eq!(
                solve_file(&nonsmooth::registry(), &file, &SolveOptions::default()).expect("our file").status,
                status,
                "{suffix}"
            );
        }
    }
}

#[test]
fn a_written_solution_satisfies_the_problem_of_its_file() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let options = SolveOptions { write_solution: true, ..SolveOptions::default() };
    for name in ["planar-ten", "planar-ten-global", "spatial-three", "spatial-three-global"] {
        let file = folder.path().join(format!("{name}.hdf5"));
        std::fs::copy(data().join(format!("{name}.hdf5")), &file).expect("a copy");
        for _ in 0..2 {
            let report = solve_file(&nonsmooth::registry(), &file, &options).expect("our file");
            let stored = fclib::read(&file).expect("our file");
            let solution = stored.solution.as_ref().expect("a solution was asked for");
            assert_eq!(&stored.solution(solution.percussions.clone()).expect("our problem"), solution);
            assert_eq!(solution.body_velocities.is_some(), name.ends_with("global"));
            // The residual of what is stored is the residual that was told.
            let residual = match stored.cone_in(Form::Auto).expect("our problem") {
                fclib::Cone::Planar(cone) => residual(&cone, &solution.percussions),
                fclib::Cone::Spatial(cone) => residual(&cone, &solution.percussions),
            };
            assert_eq!(residual, report.scaled_residual, "{name}");
        }
    }
}

fn residual<const D: usize>(cone: &nonsmooth::cone::ConeProblem<f64, D>, r: &[f64]) -> f64 {
    let r: Vec<_> = r.chunks_exact(D).map(nalgebra::SVector::from_column_slice).collect();
    cone.residual(&r).scaled
}

#[test]
fn what_is_not_solved_comes_with_its_certificate_and_exit_code() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = squeezed(folder.path());
    let options = SolveOptions { max_seconds: Some(2.0), write_solution: true, ..SolveOptions::default() };
    let mut out = Vec::new();
    let solved = solve_files(&nonsmooth::registry(), std::slice::from_ref(&file), &options, false, &mut out)
        .expect("a known solver");
    assert_eq!(solved.exit_code(), 1);
    let report = &solved.reports[0];
    assert!(!report.converged && report.scaled_residual > 1e-10);
    assert!(fclib::read(&file).expect("our file").solution.is_none(), "what is no solution is not written");
    let text = String::from_utf8(out).expect("UTF-8");
    assert!(text.contains("not converged"), "{text}");
    #[cfg(feature = "clarabel")]
    {
        use nonsmooth::collection::Verdict;
        let certificate = report.certificate.as_ref().expect("a certificate");
        assert_eq!(certificate.verdict, Verdict::Infeasible);
        // Σ_α d_α·b_α < 0 and Wᵀ d = 0: both normals pushed equally.
        let d = certificate.direction.as_ref().expect("a direction");
        assert!(d[0] > 0.0 && (d[0] - d[2]).abs() <= 1e-6 * d[0], "{d:?}");
        assert!(text.contains("infeasible"), "{text}");
    }
}

#[test]
fn a_file_that_is_none_is_told_and_the_others_are_solved() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let broken = folder.path().join("broken.hdf5");
    std::fs::write(&broken, b"nothing").expect("a writable folder");
    let files = [broken, ours(&["planar-stick"]).remove(0)];
    for json in [false, true] {
        let mut out = Vec::new();
        let solved = solve_files(&nonsmooth::registry(), &files, &SolveOptions::default(), json, &mut out)
            .expect("a known solver");
        assert_eq!((solved.exit_code(), solved.reports.len(), solved.failures.len()), (2, 1, 1));
        assert!(String::from_utf8(out).expect("UTF-8").contains("broken"));
    }
    for (solver, tolerance) in [("nobody", 1e-8), ("nsgs", 0.0), ("nsgs", f64::NAN)] {
        let options = SolveOptions { solver: solver.into(), tolerance, ..SolveOptions::default() };
        let refused = solve_files(&nonsmooth::registry(), &files, &options, false, &mut Vec::new());
        assert!(matches!(refused, Err(CollectionError::Solver(_))));
    }
}

#[test]
fn the_default_solver_solves_every_public_problem() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/fclib");
    for folder in ["local", "global"].map(|kind| root.join(kind)) {
        let Ok(files) = problem_files(&folder) else {
            println!("skipped: no public problems in {}", folder.display());
            continue;
        };
        for tolerance in [1e-8, 1e-12] {
            let options = SolveOptions { tolerance, max_seconds: Some(60.0), ..SolveOptions::default() };
            let mut out = Vec::new();
            let solved = solve_files(&nonsmooth::registry(), &files, &options, false, &mut out)
                .expect("a known solver");
            let text = String::from_utf8(out).expect("UTF-8");
            println!("{text}");
            assert_eq!(solved.exit_code(), 0, "{text}");
            for report in &solved.reports {
                assert!(report.residual <= tolerance && report.scaled_residual <= tolerance, "{text}");
            }
        }
    }
}

#[test]
fn a_comparison_tells_times_curves_profiles_and_ratios() {
    let files = ours(&["planar-slide", "planar-ten", "spatial-three"]);
    let solvers = vec!["hybrid".to_string(), "nsgs".to_string()];
    let options = BenchmarkOptions { solvers, max_seconds: 10.0, ..BenchmarkOptions::default() };
    let mut told = 0;
    let mut benchmark =
        Benchmark::run(&nonsmooth::registry(), &files, &options, &mut |_| told += 1).expect("our files");
    assert_eq!((told, benchmark.measurements.len()), (6, 6));
    for m in &benchmark.measurements {
        assert!(m.solved && m.residual <= 1e-8 && m.scaled_residual <= 1e-8 && m.cpu_seconds > 0.0, "{m:?}");
        assert!(m.curve.windows(2).all(|w| w[0].seconds <= w[1].seconds), "{m:?}");
    }
    let profiles = benchmark.profiles();
    assert_eq!(profiles.len(), 2);
    for p in &profiles {
        assert_eq!(p.shares.last(), Some(&1.0), "both solve everything");
    }
    // On every problem one of the two is the best.
    assert_eq!(profiles.iter().flat_map(|p| &p.ratios).filter(|&&r| r == 1.0).count(), 3);

    let folder = tempfile::tempdir().expect("a temporary folder");
    let peer = folder.path().join("peer.jsonl");
    let line = |problem: &str, solver: &str, time: &str, converged: bool| {
        format!(
            r#"{{"problem": "{problem}", "solver": "{solver}", "nc": 10, "dim": 2, "tol": 1e-08, "status": "ok", "converged": {converged}, "time": {time}, "iterations": 5, "residual": 1e-9}}"#
        )
    };
    let lines = [
        line("planar-ten", "A", "2.0", true),
        line("planar-ten", "B", "1.0", true),
        line("spatial-three", "A", "NaN", false),
        line("elsewhere", "A", "1.0", true),
    ];
    std::fs::write(&peer, lines.join("\n")).expect("a writable folder");
    assert_eq!(benchmark.add_peer("peer", &peer).expect("a table"), 3);
    let ratios = benchmark.ratios("hybrid");
    assert_eq!(ratios.len(), 3);
    assert_eq!(ratios[1].peer.as_deref(), Some("peer/B"));
    assert_eq!(ratios[1].ratio, Some(1.0 / ratios[1].seconds.expect("solved")));
    assert_eq!((ratios[0].ratio, ratios[2].ratio), (None, None));

    let mut table = Vec::new();
    benchmark.write_table("hybrid", &mut table).expect("memory");
    let table = String::from_utf8(table).expect("UTF-8");
    assert!(table.contains("3/3") && table.contains("peer/B") && table.contains("1/2"), "{table}");
    let results = folder.path().join("tables");
    benchmark.write_csv("hybrid", &results).expect("a writable folder");
    let lines = |name: &str| std::fs::read_to_string(results.join(name)).expect(name).lines().count();
    assert_eq!(lines("results.csv"), 1 + 6 + 3);
    assert_eq!(lines("ratios.csv"), 1 + 3);
    assert_eq!(lines("profile.csv"), 1 + 6 + 2);
    assert!(lines("curves.csv") > 6);

    #[cfg(feature = "figures")]
    {
        let svg = benchmark.profile_figure().svg().expect("a figure");
        assert!(["hybrid", "nsgs", "peer/A"].iter().all(|name| svg.contains(name)));
        assert!(benchmark.curve_figure("planar-ten").svg().expect("a figure").contains("nsgs"));
    }

    std::fs::write(&peer, "not JSON").expect("a writable folder");
    assert!(matches!(benchmark.add_peer("peer", &peer), Err(CollectionError::Peer { line: 1, .. })));
}
