//! What a step of the sliding block costs, part by part, and how it grows with the mesh:
//! `cargo bench --bench elastic`.
//!
//! Times are medians over steps, part by part, so that what else the machine does hardly counts. With the feature
//! `outputs`, also 10⁴ steps with their tables.

#[path = "../tests/elastic/mod.rs"]
mod elastic;

use std::time::Instant;

use elastic::{Scheme, authors_mesh, block_scheme, built_in_mesh};
use nonsmooth::linalg::{Factor, Symmetric};
use nonsmooth::mesh::{Mesh, Pattern};
use nonsmooth::scheme::{ActivationRule, Part};
use nonsmooth::system::{Hypothesis, System};

const PARTS: [(Part, &str); 6] = [
    (Part::FreeVelocity, "forces, solve down"),
    (Part::ActiveSet, "active set"),
    (Part::ConeProblem, "cone problem"),
    (Part::ConeSolution, "cone solver"),
    (Part::NextState, "solve up"),
    (Part::Ledger, "products, ledger"),
];

/// Steps looked at, after some that the contacts need to spread.
const STEPS: usize = 2000;
const WARM_UP: usize = 2500;

fn scheme(mesh: Mesh, law: &str, solver: &str) -> Scheme<2> {
    block_scheme(mesh, Hypothesis::PlaneStress, law, solver, ActivationRule::MoreauJean)
}

/// The median, and the value that a tenth stays below: what an undisturbed machine would take.
fn quantiles(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    [values[values.len() / 2], values[values.len() / 10]]
}

/// Quantiles of the seconds of each part over `steps` steps, and the mean number of iterations of the solver.
fn parts(scheme: &mut Scheme<2>, warm_up: usize, steps: usize) -> ([[f64; 2]; 6], f64) {
    let mut spent: [Vec<f64>; 6] = std::array::from_fn(|_| Vec::with_capacity(steps));
    let mut iterations = 0;
    for _ in 0..warm_up {
        scheme.step().expect("the block's step succeeds");
    }
    for _ in 0..steps {
        let mut clock = Instant::now();
        let step = scheme.step_with(|part| {
            let now = Instant::now();
            let place = PARTS.iter().position(|&(known, _)| known == part).expect("every part is listed");
            spent[place].push((now - clock).as_secs_f64());
            clock = now;
        });
        let step = step.expect("the block's step succeeds");
        iterations += step.solution.map_or(0, |solution| solution.iterations);
    }
    (spent.map(quantiles), iterations as f64 / steps as f64)
}

fn fastest(repeat: usize, mut work: impl FnMut()) -> f64 {
    let once = |work: &mut dyn FnMut()| {
        let clock = Instant::now();
        work();
        clock.elapsed().as_secs_f64()
    };
    (0..repeat).map(|_| once(&mut work)).fold(f64::INFINITY, f64::min)
}

/// Seconds of the products with M and K, and of one pair of triangular solves with M̂.
fn kernels(scheme: &Scheme<2>) -> ([f64; 3], usize) {
    let system: &dyn System<f64, 2> = scheme.system();
    let free = system.prescribed().map_or(system.dofs(), |prescribed| prescribed.first());
    let stiffness = system.stiffness().expect("an elastic body");
    let h = scheme.settings().step;
    let matrix = system.mass().clone().plus(0.25 * h * h, stiffness).leading(free);
    let mut factor = Factor::new(&matrix).expect("positive definite");
    let mut x = vec![1.0; system.dofs()];
    let mut y = x.clone();
    let mut product = |operator: &Symmetric<f64>| fastest(200, || operator.multiply(&x, &mut y));
    let products = [product(system.mass()), product(stiffness)];
    let solve = fastest(200, || factor.solve_in_place(&mut x[..free]));
    let entries = match &factor {
        Factor::Sparse(factor) => factor.entries(),
        _ => 0,
    };
    ([products[0], products[1], solve], entries)
}

fn table() {
    let (mesh, name) = match authors_mesh() {
        Some(mesh) => (mesh, "the authors' mesh"),
        None => (built_in_mesh(1.0, Pattern::Quality), "the built-in mesh"),
    };
    println!("sliding block on {name}, {} nodes; µs per step", mesh.nodes().len());
    print!("{:8} {:15}", "law", "solver");
    PARTS.iter().for_each(|(_, part)| print!(" {part:>19}"));
    println!(" {:>8} {:>8} {:>8}", "median", "calm", "sweeps");
    for law in ["newton", "fremond"] {
        for solver in ["hybrid", "nsgs", "proximal-newton"] {
            let mut scheme = scheme(mesh.clone(), law, solver);
            let (times, iterations) = parts(&mut scheme, WARM_UP, STEPS);
            let total: f64 = times.iter().map(|t| t[0]).sum();
            let calm: f64 = times.iter().map(|t| t[1]).sum();
            print!("{law:8} {solver:15}");
            times.iter().for_each(|[t, _]| print!(" {:>12.2} ({:>3.0} %)", t * 1e6, 100.0 * t / total));
            println!(" {:>8.2} {:>8.2} {iterations:>8.2}", total * 1e6, calm * 1e6);
        }
    }
    let ([mass, stiffness, solve], entries) = kernels(&scheme(mesh, "fremond", "hybrid"));
    println!(
        "alone: product with M {:.1} µs, with K {:.1} µs, triangular solves {:.1} µs ({entries} entries of L)\n",
        mass * 1e6,
        stiffness * 1e6,
        solve * 1e6
    );
}

/// Exponent of y ∝ xᵃ between two rows.
fn exponent(x: [f64; 2], y: [f64; 2]) -> f64 {
    (y[1] / y[0]).ln() / (x[1] / x[0]).ln()
}

fn growth() {
    println!("growth, fremond with hybrid, structured meshes; exponents against the row above");
    println!(
        "{:>7} {:>9} {:>9} {:>12} {:>10} {:>9} {:>12} {:>10} {:>10} {:>11}",
        "size",
        "unknowns",
        "contacts",
        "µs per step",
        "exponent",
        "cone µs",
        "entries of L",
        "exponent",
        "MiB of L",
        "set-up (s)"
    );
    let mut last: Option<(f64, f64, f64)> = None;
    for size in [1.0, 0.5, 0.25, 0.125] {
        let mesh = built_in_mesh(size, Pattern::Structured);
        let clock = Instant::now();
        let mut scheme = scheme(mesh, "fremond", "hybrid");
        let setup = clock.elapsed().as_secs_f64();
        let unknowns = scheme.state().q.len() as f64;
        // Fewer steps on large meshes: a step costs enough to be seen.
        let steps = ((1e7 / unknowns) as usize).clamp(30, 2000);
        let (times, _) = parts(&mut scheme, steps / 2, steps);
        let best = [times.iter().map(|t| t[0]).sum::<f64>(), times[3][0]];
        let (_, entries) = kernels(&scheme);
        let now = (unknowns, best[0], entries as f64);
        let [time, memory] = last.map_or([f64::NAN; 2], |last| {
            [exponent([last.0, now.0], [last.1, now.1]), exponent([last.0, now.0], [last.2, now.2])]
        });
        println!(
            "{size:>7} {unknowns:>9} {:>9} {:>12.1} {time:>10.2} {:>9.1} {entries:>12} {memory:>10.2} {:>10.1} {setup:>11.2}",
            scheme.system().geometry().map_or(0, |geometry| geometry.contact_count()),
            best[0] * 1e6,
            best[1] * 1e6,
            entries as f64 * 8.0 / 1024.0 / 1024.0,
        );
        last = Some(now);
    }
}

/// 10⁴ steps of both laws with ledger and tables, at the rates of `examples/sliding_block.toml`.
#[cfg(feature = "outputs")]
fn whole() {
    use nonsmooth::observe::{CsvFiles, Rates, RunInfo, SummaryRecorder};
    use nonsmooth::simulate::Stepper;
    use std::sync::atomic::AtomicBool;

    let Some(mesh) = authors_mesh() else { return };
    let folder = std::env::temp_dir().join("nonsmooth-bench-elastic");
    std::fs::create_dir_all(&folder).expect("a folder");
    println!("10⁴ steps on the authors' mesh, with the ledger and, second, with tables; seconds");
    for law in ["newton", "fremond"] {
        let run = |with_tables: bool| {
            let scheme = scheme(mesh.clone(), law, "hybrid");
            let info = RunInfo::new(law, "hybrid", vec![law.into()], scheme.settings());
            let rates = Rates { trajectory: 100, contacts: 100, energy: 1 };
            let mut tables = CsvFiles::create(&folder, rates).expect("tables");
            let mut summary = SummaryRecorder::default();
            let mut stepper = Stepper::from(scheme);
            let clock = Instant::now();
            let interrupt = AtomicBool::new(false);
            let ended = if with_tables {
                stepper.run(10_000, &info, &mut [&mut tables, &mut summary], &interrupt)
            } else {
                stepper.run(10_000, &info, &mut [], &interrupt)
            };
            ended.expect("the block runs");
            tables.commit().expect("tables");
            clock.elapsed().as_secs_f64()
        };
        println!("{law:8} {:>6.2} {:>6.2}", run(false), run(true));
    }
    let _ = std::fs::remove_dir_all(&folder);
    println!();
}

fn main() {
    table();
    #[cfg(feature = "outputs")]
    whole();
    growth();
}
