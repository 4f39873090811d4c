//! A Gauss–Seidel sweep against the bare row gather it cannot do without, in one run: nanoseconds per contact and their
//! ratio, for 20,000 contacts: `cargo bench --bench sweep`.
//!
//! Two patterns: a masonry wall (its W, or its leading D×D blocks), and a lattice with seven blocks per row numbered at
//! random, unfriendly to the cache and with little to gather.

#[path = "families/mod.rs"]
#[allow(dead_code)]
mod families;

use std::hint::black_box;
use std::time::Instant;

use families::{Random, wall};
use nalgebra::{SMatrix, SVector};
use nonsmooth::cone::{BlockMatrix, ConeProblem, Form};
use nonsmooth::solver::{ConeSolver, Method, Nsgs, NsgsSettings, Stopping};

/// Contacts on a periodic 3D lattice with six neighbours, numbered at random.
fn lattice<const D: usize>(side: usize, seed: u64) -> ConeProblem<f64, D> {
    let mut random = Random::new(seed);
    let (layer, m) = (side * side, side * side * side);
    let mut name: Vec<usize> = (0..m).collect();
    for i in (1..m).rev() {
        name.swap(i, ((random.symmetric() + 1.0) * 0.5 * (i + 1) as f64) as usize);
    }
    let mut rows: Vec<Vec<(usize, SMatrix<f64, D, D>)>> =
        (0..m).map(|i| vec![(i, SMatrix::identity())]).collect();
    for i in 0..m {
        let (x, y, z) = (i % side, i / side % side, i / layer);
        let next = [
            (x + 1) % side + y * side + z * layer,
            x + (y + 1) % side * side + z * layer,
            x + y * side + (z + 1) % side * layer,
        ];
        for j in next {
            let block = SMatrix::from_fn(|_, _| 0.05 * random.symmetric());
            rows[name[i]].push((name[j], block));
            rows[name[j]].push((name[i], block.transpose()));
        }
    }
    let mut w = BlockMatrix::new();
    for row in &mut rows {
        row.sort_by_key(|&(j, _)| j);
        w.start_row();
        row.iter().for_each(|&(j, block)| w.push(j, block));
    }
    let b = (0..m)
        .map(|_| SVector::from_fn(|i, _| random.symmetric() - if i == 0 { 0.5 } else { 0.0 }))
        .collect();
    ConeProblem::new(w, b, vec![0.4; m]).expect("a problem")
}

/// Seconds this process has spent on a processor where the system tells, seconds passed elsewhere: others on the machine
/// must not count.
fn clock() -> f64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    let nanoseconds = std::fs::read_to_string("/proc/self/schedstat")
        .ok()
        .and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    match nanoseconds {
        Some(nanoseconds) => nanoseconds * 1e-9,
        None => START.get_or_init(Instant::now).elapsed().as_secs_f64(),
    }
}

fn timed(run: impl FnOnce()) -> f64 {
    let start = clock();
    run();
    clock() - start
}

/// The wall's W in the first D directions of every contact, formed.
fn masonry<const D: usize>(side: usize) -> ConeProblem<f64, D> {
    let spatial = wall(side, side, 1).problem(Form::Formed, 0.0);
    let mut w = BlockMatrix::new();
    for i in 0..spatial.contacts() {
        w.start_row();
        spatial
            .delassus()
            .formed()
            .expect("formed")
            .row(i)
            .for_each(|(j, block)| w.push(j, block.fixed_view::<D, D>(0, 0).into_owned()));
    }
    let b = spatial.b().iter().map(|b| b.fixed_rows::<D>(0).into_owned()).collect();
    ConeProblem::new(w, b, spatial.cones().to_vec()).expect("a problem")
}

fn compare<const D: usize>(pattern: &str, problem: &ConeProblem<f64, D>) {
    let m = problem.contacts();
    let start = vec![SVector::<f64, D>::zeros(); m];
    let mut r = start.clone();
    let solver = |sweeps: usize, r: &mut Vec<SVector<f64, D>>| {
        let stopping = Stopping { max_iterations: Some(sweeps), ..Stopping::to(1e-300) };
        let mut solver =
            Nsgs::solver(stopping, NsgsSettings::default().with_acceleration(0)).expect("in range");
        // The budget ends first, by design.
        let _ = solver.solve(problem, &start, r);
    };
    let (mut gather, mut few, mut many) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
    for _ in 0..5 {
        gather = gather.min(timed(|| {
            for _ in 0..64 {
                let mut sum = SVector::<f64, D>::zeros();
                (0..m).for_each(|i| sum += problem.delassus().formed().expect("formed").row_product(i, &r));
                black_box(sum);
            }
        }));
        few = few.min(timed(|| solver(2, &mut r)));
        many = many.min(timed(|| solver(66, &mut r)));
    }
    // With the solver's own checks of the residual, one in eight sweeps or fewer.
    let (sweep, gather) = ((many - few) / 64.0, gather / 64.0);
    let per_contact = 1e9 / m as f64;
    println!(
        "{pattern:<8} D = {D}, {m} contacts, {:4.1} blocks per row: gather {:5.1} ns, sweep {:5.1} ns per contact, ratio {:.2}",
        problem.delassus().blocks() as f64 / m as f64,
        gather * per_contact,
        sweep * per_contact,
        sweep / gather
    );
}

fn main() {
    compare("wall", &masonry::<1>(50));
    compare("wall", &masonry::<2>(50));
    compare("wall", &masonry::<3>(50));
    compare("lattice", &lattice::<1>(27, 7));
    compare("lattice", &lattice::<2>(27, 7));
    compare("lattice", &lattice::<3>(27, 7));
}
