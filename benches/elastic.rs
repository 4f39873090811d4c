//! What a step of the sliding block costs, part by part, and how it grows with the mesh:
//! `cargo bench --bench elastic`.
//!
//! Times are the fastest of several stretches of steps, so that other work on the machine does not count.

#[path = "../tests/elastic/mod.rs"]
mod elastic;

use std::time::{Duration, Instant};

use elastic::{Scheme, authors_mesh, block_scheme, built_in_mesh};
use nonsmooth::linalg::{Factor, Symmetric};
use nonsmooth::mesh::{Mesh, Pattern};
use nonsmooth::scheme::{ActivationRule, Part};
use nonsmooth::system::{Hypothesis, MechanicalSystem};

const PARTS: [(Part, &str); 6] = [
    (Part::FreeVelocity, "forces, solve down"),
    (Part::ActiveSet, "active set"),
    (Part::ConeProblem, "cone problem"),
    (Part::ConeSolution, "cone solver"),
    (Part::NextState, "solve up"),
    (Part::Ledger, "products, ledger"),
];

/// Steps of a stretch, and stretches.
const STRETCH: usize = 10;
const STRETCHES: usize = 300;

fn scheme(mesh: Mesh, law: &str, solver: &str) -> Scheme<2> {
    block_scheme(mesh, Hypothesis::PlaneStress, law, solver, ActivationRule::MoreauJean)
}

/// Seconds per step of each part, of the stretch in which the step was fastest.
fn parts(scheme: &mut Scheme<2>) -> [f64; 6] {
    let mut best = [f64::INFINITY; 6];
    for _ in 0..STRETCHES {
        let mut spent = [Duration::ZERO; 6];
        for _ in 0..STRETCH {
            let mut clock = Instant::now();
            let step = scheme.step_with(|part| {
                let now = Instant::now();
                let place = PARTS.iter().position(|&(known, _)| known == part).expect("every part is listed");
                spent[place] += now - clock;
                clock = now;
            });
            step.expect("the block's step succeeds");
        }
        let seconds = spent.map(|time| time.as_secs_f64() / STRETCH as f64);
        if seconds.iter().sum::<f64>() < best.iter().sum() {
            best = seconds;
        }
    }
    best
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
    let system: &dyn MechanicalSystem<f64, 2> = scheme.system();
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
    println!(" {:>8} {:>8}", "total", "sweeps");
    for law in ["newton", "fremond"] {
        for solver in ["hybrid", "nsgs", "proximal-newton"] {
            let mut scheme = scheme(mesh.clone(), law, solver);
            let times = parts(&mut scheme);
            let total: f64 = times.iter().sum();
            let mut iterations = 0;
            for _ in 0..10 * STRETCH {
                let step = scheme.step().expect("the block's step succeeds");
                iterations += step.solution.map_or(0, |solution| solution.iterations);
            }
            print!("{law:8} {solver:15}");
            times.iter().for_each(|t| print!(" {:>12.2} ({:>3.0} %)", t * 1e6, 100.0 * t / total));
            println!(" {:>8.2} {:>8.2}", total * 1e6, iterations as f64 / (10 * STRETCH) as f64);
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
        let steps = (1e5 / unknowns) as usize;
        let mut best = [f64::INFINITY; 2];
        for _ in 0..(1e6 / unknowns) as usize {
            let (mut spent, mut cone) = (Duration::ZERO, Duration::ZERO);
            for _ in 0..steps.max(4) {
                let mut clock = Instant::now();
                let step = scheme.step_with(|part| {
                    let now = Instant::now();
                    spent += now - clock;
                    if part == Part::ConeSolution {
                        cone += now - clock;
                    }
                    clock = now;
                });
                step.expect("the block's step succeeds");
            }
            let seconds = spent.as_secs_f64() / steps.max(4) as f64;
            if seconds < best[0] {
                best = [seconds, cone.as_secs_f64() / steps.max(4) as f64];
            }
        }
        let (_, entries) = kernels(&scheme);
        let now = (unknowns, best[0], entries as f64);
        let [time, memory] = last.map_or([f64::NAN; 2], |last| {
            [exponent([last.0, now.0], [last.1, now.1]), exponent([last.0, now.0], [last.2, now.2])]
        });
        println!(
            "{size:>7} {unknowns:>9} {:>9} {:>12.1} {time:>10.2} {:>9.1} {entries:>12} {memory:>10.2} {:>10.1} {setup:>11.2}",
            scheme.system().contact_count(),
            best[0] * 1e6,
            best[1] * 1e6,
            entries as f64 * 8.0 / 1024.0 / 1024.0,
        );
        last = Some(now);
    }
}

fn main() {
    table();
    growth();
}
