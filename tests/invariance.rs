//! The shifted velocity w that solves a problem depends neither on the units, nor on the order of the contacts, nor on
//! contacts given twice; and a warm solve allocates nothing.

use nalgebra::{SMatrix, SVector};
use nonsmooth::cone::{BlockMatrix, ConeProblem};
use nonsmooth::solver::{ConeSolver, Method, Nsgs, NsgsSettings, Stopping, build};

const SOLVERS: [&str; 3] = ["nsgs", "proximal-newton", "hybrid"];
/// Tolerance of the solves; W is well conditioned, so that w is unique and moves by a small multiple of it.
const TOLERANCE: f64 = 1e-11;
const DISTANCE: f64 = 1e3 * TOLERANCE;

struct Random(u64);

impl Random {
    fn symmetric(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        2.0 * (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64 - 1.0
    }
}

/// Contacts in a ring, each coupled with its neighbours: symmetric, diagonally dominant.
fn ring<const D: usize>(m: usize, seed: u64) -> ConeProblem<f64, D> {
    let mut random = Random(seed);
    let links: Vec<SMatrix<f64, D, D>> =
        (0..m).map(|_| SMatrix::from_fn(|_, _| 0.12 * random.symmetric())).collect();
    let mut w = BlockMatrix::new();
    for i in 0..m {
        w.start_row();
        let (before, after) = ((i + m - 1) % m, (i + 1) % m);
        let mut row = [(before, links[before].transpose()), (i, SMatrix::identity()), (after, links[i])];
        row.sort_by_key(|&(j, _)| j);
        row.iter().for_each(|&(j, block)| w.push(j, block));
    }
    let b = (0..m)
        .map(|_| SVector::from_fn(|i, _| random.symmetric() - if i == 0 { 0.4 } else { 0.0 }))
        .collect();
    ConeProblem::new(w, b, (0..m).map(|i| 0.1 * (i % 6) as f64).collect()).expect("a problem")
}

fn solve<const D: usize>(name: &str, problem: &ConeProblem<f64, D>) -> Vec<SVector<f64, D>> {
    let mut solver = build::<f64, D>(name, Stopping::to(TOLERANCE)).expect("registered");
    let mut r = vec![SVector::zeros(); problem.contacts()];
    let start = r.clone();
    solver.solve(problem, &start, &mut r).unwrap_or_else(|error| panic!("{name}: {error}"));
    (0..r.len()).map(|i| problem.shifted_velocity(i, &r)).collect()
}

fn rebuilt<const D: usize>(
    problem: &ConeProblem<f64, D>,
    contacts: &[usize],
    percussion: f64,
    velocity: f64,
) -> ConeProblem<f64, D> {
    let mut w = BlockMatrix::new();
    for &i in contacts {
        w.start_row();
        for (j, &original) in contacts.iter().enumerate() {
            if let Some((_, block)) =
                problem.delassus().formed().expect("formed").row(i).find(|&(column, _)| column == original)
            {
                w.push(j, block * (velocity / percussion));
            }
        }
    }
    let b = contacts.iter().map(|&i| problem.b()[i] * velocity).collect();
    ConeProblem::new(w, b, contacts.iter().map(|&i| problem.cones()[i]).collect()).expect("a problem")
}

fn assert_same<const D: usize>(
    what: &str,
    w: &[SVector<f64, D>],
    reference: &[SVector<f64, D>],
    contacts: &[usize],
    velocity: f64,
) {
    let size = reference.iter().map(|w| w.norm()).fold(0.0, f64::max);
    for (w, &i) in w.iter().zip(contacts) {
        let distance = (w / velocity - reference[i]).norm() / size;
        assert!(distance <= DISTANCE, "{what}, contact {i}: w differs by {distance:e}");
    }
}

fn invariance<const D: usize>() {
    let m = 24;
    let problem = ring::<D>(m, 11);
    let order: Vec<usize> = (0..m).collect();
    let shuffled: Vec<usize> = (0..m).map(|i| (7 * i + 3) % m).collect();
    let twice: Vec<usize> = (0..m + 5).map(|i| if i < m { i } else { 3 * (i - m) }).collect();
    for name in SOLVERS {
        let reference = solve(name, &problem);
        for (percussion, velocity) in [(1e6, 1.0), (1e-6, 1.0), (1.0, 1e6), (1.0, 1e-6), (1e6, 1e-6)] {
            let w = solve(name, &rebuilt(&problem, &order, percussion, velocity));
            assert_same(
                &format!("{name}, units {percussion:e} {velocity:e}"),
                &w,
                &reference,
                &order,
                velocity,
            );
        }
        let w = solve(name, &rebuilt(&problem, &shuffled, 1.0, 1.0));
        assert_same(&format!("{name}, permuted"), &w, &reference, &shuffled, 1.0);
        let w = solve(name, &rebuilt(&problem, &twice, 1.0, 1.0));
        assert_same(&format!("{name}, duplicated"), &w, &reference, &twice, 1.0);
    }
}

#[test]
fn frictionless_contacts_do_not_depend_on_their_description() {
    invariance::<1>();
}

#[test]
fn planar_contacts_do_not_depend_on_their_description() {
    invariance::<2>();
}

#[test]
fn spatial_contacts_do_not_depend_on_their_description() {
    invariance::<3>();
}

fn allocations_of_a_warm_solve<const D: usize>(acceleration: usize) -> u64 {
    let problem = ring::<D>(200, 5);
    let stopping = Stopping::to(1e-9);
    let mut solver =
        Nsgs::solver(stopping, NsgsSettings::default().with_acceleration(acceleration)).expect("in range");
    let start = vec![SVector::<f64, D>::zeros(); problem.contacts()];
    let mut r = start.clone();
    solver.solve(&problem, &start, &mut r).expect("cold");
    let counted = allocation_counter::measure(|| {
        solver.solve(&problem, &start, &mut r).expect("warm");
    });
    counted.count_total
}

#[test]
fn a_warm_gauss_seidel_allocates_nothing() {
    for acceleration in [0, 10] {
        assert_eq!(allocations_of_a_warm_solve::<1>(acceleration), 0);
        assert_eq!(allocations_of_a_warm_solve::<2>(acceleration), 0);
        assert_eq!(allocations_of_a_warm_solve::<3>(acceleration), 0);
    }
}
