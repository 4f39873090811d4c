//! What error control costs against fixed steps: `cargo bench --bench adaptive`.
//!
//! For every case whose motion is known, and every tolerance: the error measured (the larger of q in L∞ and v in L1 over
//! time, in lengths of the scene), the processor time of the run, and that of fixed steps of equal error, from runs over a
//! ladder of steps through which a line is laid, ln(time) over ln(error), by least squares. `*`: the error is below all of
//! the ladder's, the line is prolonged.

#[path = "../tests/mechanics/example.rs"]
mod example;
#[path = "../tests/motions/mod.rs"]
mod motions;

use std::ops::ControlFlow;

use cpu_time::ThreadTime;
use motions::{Case, Measure, adaptive, cases, run, scheme};

const TOLERANCES: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

/// Fixed steps: the span over these numbers times powers of two.
const COARSEST: usize = 25;
const RUNGS: usize = 14;

/// Shortest time measured (s): runs are repeated until it is reached, and the fastest counts.
const LEAST: f64 = 0.02;

/// Time of `run` on what `set_up` makes.
fn seconds<R>(set_up: impl Fn() -> R, run: impl Fn(&mut R)) -> f64 {
    let (mut fastest, mut all) = (f64::INFINITY, 0.0);
    while all < LEAST {
        let mut made = set_up();
        let start = ThreadTime::now();
        run(&mut made);
        let took = start.elapsed().as_secs_f64();
        (fastest, all) = (fastest.min(took), all + took.max(1e-6));
    }
    fastest
}

/// Error and time of a run of `steps` fixed steps.
fn fixed<const D: usize>(case: &mut Case, weights: &[f64], steps: usize) -> (f64, f64) {
    case.scene.time.step = case.scene.time.end / steps as f64;
    let mut measured = scheme::<D>(case);
    let mut measure = Measure::new(&case.motion, weights, measured.state());
    for _ in 0..steps {
        measured.step().expect("a step");
        measure.take(measured.state());
    }
    let time = seconds(
        || scheme::<D>(case),
        |scheme| {
            for _ in 0..steps {
                scheme.step().expect("a step");
            }
        },
    );
    (measure.errors.largest(), time)
}

fn rows<const D: usize>(mut case: Case) {
    let weights = adaptive::<D>(&case, 1e-3).expect("in range").weights().to_vec();
    let ladder: Vec<(f64, f64)> =
        (0..RUNGS).map(|rung| fixed::<D>(&mut case, &weights, COARSEST << rung)).collect();
    // The line of ln(time) over ln(error).
    let points: Vec<(f64, f64)> = ladder.iter().map(|(error, time)| (error.ln(), time.ln())).collect();
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / n, y + point.1 / n));
    let along = |f: fn(f64, f64) -> f64| points.iter().map(|point| f(point.0 - x, point.1 - y)).sum::<f64>();
    let slope = along(|x, y| x * y) / along(|x, _| x * x);
    let least = ladder.iter().fold(f64::INFINITY, |least, (error, _)| least.min(*error));
    for tolerance in TOLERANCES {
        let (errors, report) = run::<D>(&case, tolerance, |_, _| ()).expect("a run");
        let error = errors.largest();
        let time = seconds(
            || adaptive::<D>(&case, tolerance).expect("in range"),
            |driver| {
                let _end: ControlFlow<()> = driver
                    .advance_to(case.scene.time.end, |_, _, _| ControlFlow::Continue(()))
                    .expect("a run");
            },
        );
        let equal = (y + slope * (error.ln() - x)).exp();
        println!(
            "{:28} {tolerance:>6.0e} {error:>9.1e} {:>7.3} {:>8} {:>8} {:>7} {:>10.1} {:>12.1}{} {:>10.1} {:>6.2}",
            case.name,
            error / tolerance,
            report.accepted,
            report.computed,
            report.events,
            time * 1e6,
            equal * 1e6,
            if error < least { '*' } else { ' ' },
            equal / time,
            -1.0 / slope,
        );
    }
}

fn main() {
    println!(
        "{:28} {:>6} {:>9} {:>7} {:>8} {:>8} {:>7} {:>10} {:>13} {:>10} {:>6}",
        "case", "ε", "error", "/ε", "steps", "computed", "events", "µs", "fixed µs ", "ratio", "order"
    );
    let all = cases(&["newton", "fremond"]);
    let wanted = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    let is_wanted = |case: &Case| wanted.as_ref().is_none_or(|wanted| case.name.contains(wanted));
    all.frictionless.into_iter().filter(is_wanted).for_each(rows::<1>);
    all.frictional.into_iter().filter(is_wanted).for_each(rows::<2>);
}
