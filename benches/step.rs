//! Cost of a step of the impacting stick, both laws, with its ledger: `cargo bench --bench step`.
//!
//! An iteration is the whole run, 2000 steps from 0 to 0.2 s with two impacts. First a table of ns per step (the
//! fastest of many runs, so that other work on the machine does not count), then divan's statistics per run.

#[path = "../tests/scenes/mod.rs"]
mod scenes;

use std::hint::black_box;
use std::time::Instant;

use divan::Bencher;
use divan::counter::ItemsCount;
use nonsmooth::scalar::Scalar;
use scenes::Scheme;

const STEPS: usize = 2000;
const RUNS: usize = 200;
const LAWS: [&str; 2] = ["newton", "fremond"];
const SOLVERS: [&str; 2] = ["nsgs", "hybrid"];

fn run<T: Scalar>(scheme: &mut Scheme<T, 2>) {
    for _ in 0..STEPS {
        black_box(scheme.step().expect("the stick's step succeeds"));
    }
}

fn nanoseconds_per_step<T: Scalar>(law: &str, solver: &str) -> f64 {
    let fastest = (0..RUNS).fold(f64::INFINITY, |fastest, _| {
        let mut scheme = scenes::stick::<T, 2>(law, solver);
        let clock = Instant::now();
        run(&mut scheme);
        fastest.min(clock.elapsed().as_secs_f64())
    });
    fastest * 1e9 / STEPS as f64
}

fn main() {
    println!("ns per step     f64     f32");
    for law in LAWS {
        for solver in SOLVERS {
            let (double, single) =
                (nanoseconds_per_step::<f64>(law, solver), nanoseconds_per_step::<f32>(law, solver));
            println!("{law:8} {solver:6} {double:>6.1}  {single:>6.1}");
        }
    }
    divan::main();
}

#[divan::bench(types = [f64, f32], args = LAWS.iter().flat_map(|law| SOLVERS.map(|solver| format!("{law} {solver}"))))]
fn stick<T: Scalar>(bencher: Bencher<'_, '_>, names: &str) {
    let (law, solver) = names.split_once(' ').expect("two names");
    bencher
        .counter(ItemsCount::new(STEPS))
        .with_inputs(|| scenes::stick::<T, 2>(law, solver))
        .bench_local_refs(run);
}
