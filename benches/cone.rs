//! How a solver grows with the problem: `cargo bench --bench cone [-- SECONDS [LARGEST [SOLVER]]]`.
//!
//! Masonry walls and packings of spheres with fixed seeds, from 10² to 3·10⁴ contacts (or LARGEST), by the default solver (or SOLVER) to a scaled residual
//! of 1e-8, cold and from the solution of a problem whose b differs by 1 %; no solve takes longer than SECONDS (60).
//! Then the same walls with fewer contacts in both forms of W, and growth: the
//! exponents are those of time against contacts, from row to row. First what one contact costs.

#[allow(dead_code)]
mod families;

use std::hint::black_box;
use std::time::Instant;

use families::{Family, packing, wall};
use nalgebra::{SVector, matrix, vector};
use nonsmooth::cone::{BlockMatrix, ConeProblem, Form};
use nonsmooth::solver::{DEFAULT, SolveError, Stopping, build};

const TOLERANCE: f64 = 1e-8;
const NEARBY: f64 = 0.01;

/// Seconds, iterations and residual of one solve, and whether it met the tolerance.
struct Outcome {
    seconds: f64,
    iterations: usize,
    residual: f64,
    solved: bool,
}

fn solve(
    problem: &ConeProblem<f64, 3>,
    start: &[SVector<f64, 3>],
    r: &mut [SVector<f64, 3>],
    (limit, solver): (f64, &str),
) -> Outcome {
    let stopping = Stopping { max_seconds: Some(limit), ..Stopping::to(TOLERANCE) };
    let mut solver = build::<f64, 3>(solver, stopping).expect("registered");
    let clock = Instant::now();
    let result = solver.solve(problem, start, r);
    let seconds = clock.elapsed().as_secs_f64();
    match result {
        Ok(solution) => {
            let (iterations, residual) = (solution.iterations, solution.residual.scaled);
            Outcome { seconds, iterations, residual, solved: true }
        }
        Err(SolveError::NotConverged { iterations, residual, .. }) => {
            Outcome { seconds, iterations, residual, solved: false }
        }
        Err(error) => panic!("{error}"),
    }
}

fn growth(name: &str, families: impl Iterator<Item = Family>, (limit, largest, solver): (f64, usize, &str)) {
    println!(
        "\n{name:<8} {:>8} {:>8} {:>9} {:>9} {:>9} {:>8} {:>9} {:>9} {:>6}",
        "contacts", "cold it", "cold (s)", "residual", "exponent", "warm it", "warm (s)", "residual", "gain"
    );
    let mut previous = None::<(f64, f64)>;
    for family in families.take_while(|family| family.contacts() <= largest) {
        let contacts = family.contacts();
        let problem = family.problem(Form::Auto, 0.0);
        let zero = vec![SVector::zeros(); contacts];
        let (mut r, mut moved) = (zero.clone(), zero.clone());
        let cold = solve(&problem, &zero, &mut r, (limit, solver));
        let warm = solve(&family.problem(Form::Auto, NEARBY), &r, &mut moved, (limit, solver));
        let exponent = previous.map_or("–".into(), |(n, t)| {
            format!("{:.2}", (cold.seconds / t).ln() / (contacts as f64 / n).ln())
        });
        let mark = |outcome: &Outcome| if outcome.solved { ' ' } else { '!' };
        println!(
            "{:<8} {contacts:>8} {:>8} {:>9.4} {:>8.1e}{} {exponent:>9} {:>8} {:>9.4} {:>8.1e}{} {:>6.1}",
            "",
            cold.iterations,
            cold.seconds,
            cold.residual,
            mark(&cold),
            warm.iterations,
            warm.seconds,
            warm.residual,
            mark(&warm),
            cold.seconds / warm.seconds
        );
        previous = Some((contacts as f64, cold.seconds));
        if !cold.solved {
            println!(
                "{:<8} a row marked ! missed its tolerance in {limit} s; the larger ones are left out",
                ""
            );
            break;
        }
    }
}

/// Seconds of a cold solve with W formed (the forming included) and with H and M̂, against velocities per percussion: where
/// `factored_pays` changes over.
fn crossover(limit: f64) {
    println!(
        "\nform     {:>8} {:>9} {:>10} {:>12} {:>12} {:>8}",
        "contacts", "n/(D m)", "solver", "formed (s)", "factored (s)", "ratio"
    );
    for solver in ["nsgs", "proximal-newton", DEFAULT] {
        for share in [1.0, 0.6, 0.4, 0.3, 0.25, 0.2, 0.15] {
            let family = wall(16, 16, 1).thinned(share);
            let zero = vec![SVector::zeros(); family.contacts()];
            let mut seconds = [f64::INFINITY; 2];
            for _ in 0..3 {
                for (seconds, form) in seconds.iter_mut().zip([Form::Formed, Form::Factored]) {
                    let mut r = zero.clone();
                    let clock = Instant::now();
                    let problem = family.problem(form, 0.0);
                    let _ = solve(&problem, &zero, &mut r, (limit, solver));
                    *seconds = seconds.min(clock.elapsed().as_secs_f64());
                }
            }
            println!(
                "{:<8} {:>8} {:>9.3} {solver:>10.10} {:>12.4} {:>12.4} {:>8.2}",
                "",
                family.contacts(),
                family.ratio(),
                seconds[0],
                seconds[1],
                seconds[0] / seconds[1]
            );
        }
    }
}

/// Nanoseconds of `solve()` on one contact, residual measured, for the three statuses.
fn one_contact(solver: &str) {
    println!("\none contact with solve(), nanoseconds");
    let w = matrix![2.0, 0.1, 0.0; 0.1, 3.0, 0.2; 0.0, 0.2, 2.5];
    let states = [
        ("take-off", vector![0.5, 0.1, 0.0]),
        ("stick", vector![-1.0, 0.1, 0.05]),
        ("slide", vector![-1.0, 2.0, -1.0]),
    ];
    for (status, b) in states {
        let mut delassus = BlockMatrix::new();
        delassus.start_row();
        delassus.push(0, w);
        let problem = ConeProblem::new(delassus, vec![b], vec![0.5]).expect("a problem");
        let mut solver = build::<f64, 3>(solver, Stopping::default()).expect("registered");
        let (start, mut r) = ([SVector::zeros()], [SVector::zeros()]);
        let mut fastest = f64::INFINITY;
        for _ in 0..200 {
            let clock = Instant::now();
            for _ in 0..1_000 {
                black_box(solver.solve(black_box(&problem), &start, &mut r).expect("solvable"));
            }
            fastest = fastest.min(clock.elapsed().as_secs_f64());
        }
        println!("  {status:<9} {:>6.0}", fastest * 1e6);
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let number = |place: usize, default: f64| {
        arguments.get(place).map_or(default, |text| text.parse().expect("SECONDS and LARGEST are numbers"))
    };
    let (limit, largest) = (number(0, 60.0), number(1, 4e4) as usize);
    let solver = arguments.get(2).map_or(DEFAULT, String::as_str);
    println!("{solver} to a scaled residual of {TOLERANCE:e}");
    one_contact(solver);
    crossover(limit.min(20.0));
    let settings = (limit, largest, solver);
    growth("wall", [4, 7, 12, 26, 36, 63].into_iter().map(|side| wall(side, side, 1)), settings);
    let sides = [(3, 4), (5, 5), (6, 7), (8, 10), (10, 14), (14, 20)].into_iter();
    growth("packing", sides.map(|(layers, across)| packing(layers, across, 2)), settings);
}
