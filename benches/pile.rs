//! Cost of a step of settled piles of discs, and how it grows with their number: `cargo bench --bench pile`.
//!
//! The piles are ten discs high and ever wider, in f64 with the default solver to a residual of 1e-6; 100 steps let
//! them settle, then the fastest of 20 steps is taken. With D = 2 and μ = 0.3.

#[path = "../tests/scenes/mod.rs"]
mod scenes;

use std::time::Instant;

const WIDTHS: [usize; 3] = [10, 100, 1000];
const HIGH: usize = 10;
const FRICTION: f64 = 0.3;
const SOLVER: &str = "hybrid";
const TOLERANCE: f64 = 1e-6;
const SETTLE: usize = 100;
const MEASURED: usize = 20;

fn main() {
    println!(
        "{:>7} {:>9} {:>7} {:>12} {:>12} {:>9}",
        "discs", "contacts", "sweeps", "µs/step", "ns/contact", "exponent"
    );
    let mut previous = None::<(f64, f64)>;
    for wide in WIDTHS {
        let discs = (0..HIGH).map(|row| wide - row % 2).sum::<usize>();
        let mut scheme = scenes::pile::<f64, 2>(wide, HIGH, FRICTION, SOLVER, Some(TOLERANCE));
        let (mut fastest, mut contacts, mut sweeps) = (f64::INFINITY, 0, 0);
        for step in 0..SETTLE + MEASURED {
            let clock = Instant::now();
            let made = scheme.step().expect("the pile's step succeeds");
            let seconds = clock.elapsed().as_secs_f64();
            if step >= SETTLE && seconds < fastest {
                fastest = seconds;
                contacts = made.contacts.len();
                sweeps = made.solution.map_or(0, |solution| solution.iterations);
            }
        }
        let exponent = previous.map(|(n, t)| (fastest / t).ln() / (discs as f64 / n).ln());
        let exponent = exponent.map_or("–".into(), |x| format!("{x:.2}"));
        let per_contact = fastest * 1e9 / contacts.max(1) as f64;
        println!(
            "{discs:>7} {contacts:>9} {sweeps:>7} {:>12.1} {per_contact:>12.1} {exponent:>9}",
            fastest * 1e6
        );
        previous = Some((discs as f64, fastest));
    }
}
