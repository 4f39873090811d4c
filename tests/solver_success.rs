//! Success rates over random families: run with `--ignored --nocapture` for the table.

mod random_problems;

use nalgebra::SVector;
use nonsmooth::scalar::Scalar;
use nonsmooth::solver::{SolveError, Stopping, build};
use random_problems::{Recipe, Stream, random};

fn family<T: Scalar, const D: usize>(name: &str, friction: f64, singular: bool, count: usize) {
    let mut solver = build::<T, D>(name, Stopping::default()).expect("registered");
    let mut stream = Stream(7);
    let (mut solved, mut iterations, mut worst, mut most) = (0, 0, 0.0f64, 0);
    let clock = std::time::Instant::now();
    for seed in 0..count as u64 {
        let m = 1 + (stream.uniform(0.0, 1.0) * number("CONTACTS", 10.0)) as usize;
        let freedom =
            if singular { 1 + (stream.uniform(0.0, 1.0) * (m * D) as f64) as usize } else { m * D + 2 };
        let recipe = Recipe { seed, contacts: m, freedom, friction, decades: number("DECADES", 1.0) };
        let problem = random::<T, D>(&recipe);
        let start = vec![SVector::zeros(); m];
        let mut r = start.clone();
        match solver.solve(&problem, &start, &mut r) {
            Ok(solution) => {
                solved += 1;
                iterations += solution.iterations;
                most = most.max(solution.iterations);
            }
            Err(SolveError::NotConverged { residual, iterations, .. }) => {
                if std::env::var("VERBOSE").is_ok() {
                    println!("    {recipe:?}: {residual:e} after {iterations}");
                }
                worst = worst.max(residual)
            }
            Err(error) => panic!("{error}"),
        }
    }
    println!(
        "{name:14} {} D={D} μ={friction:<4} {} {solved:6}/{count} mean {:8.1} most {most:6} worst {worst:8.1e} {:7.3} ms",
        T::NAME,
        if singular { "singular" } else { "regular " },
        iterations as f64 / solved.max(1) as f64,
        clock.elapsed().as_secs_f64() * 1e3 / count as f64
    );
}

#[test]
#[ignore = "a measurement: minutes"]
fn success_rates() {
    let count = number("COUNT", 1000.0) as usize;
    let names = std::env::var("SOLVER").unwrap_or_else(|_| "newton".into());
    for name in names.split(',') {
        for singular in [false, true] {
            for friction in frictions() {
                if std::env::var("F32").is_ok() {
                    family::<f32, 2>(name, friction, singular, count);
                    family::<f32, 3>(name, friction, singular, count);
                    continue;
                }
                family::<f64, 1>(name, friction, singular, count);
                family::<f64, 2>(name, friction, singular, count);
                family::<f64, 3>(name, friction, singular, count);
            }
        }
    }
}

/// A number of the environment.
fn number(name: &str, default: f64) -> f64 {
    std::env::var(name).ok().and_then(|value| value.parse().ok()).unwrap_or(default)
}

/// The coefficients of friction measured: `FRICTION=2,10` narrows them.
fn frictions() -> Vec<f64> {
    let list = std::env::var("FRICTION").unwrap_or_else(|_| "0,0.1,0.5,1,2,10".into());
    list.split(',').filter_map(|mu| mu.parse().ok()).collect()
}
