//! Every solver on every problem of a folder, beside a peer's results where there are any:
//! `cargo run --release --example compare_solvers -- FOLDER [OUT [PEER.jsonl]]`.

use std::path::{Path, PathBuf};

use nonsmooth::collection::{Benchmark, BenchmarkOptions, problem_files};
use nonsmooth::solver::DEFAULT;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let folder = arguments.next().ok_or("a folder of FCLIB files is asked for")?;
    let out = arguments.next().unwrap_or_else(|| Path::new("out").join("compare"));
    let mut benchmark = Benchmark::run(&problem_files(folder)?, &BenchmarkOptions::default(), &mut |m| {
        eprintln!("{}: {} in {:.3e} s, residual {:.1e}", m.problem, m.solver, m.cpu_seconds, m.residual);
    })?;
    if let Some(peer) = arguments.next() {
        let name = peer.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        benchmark.add_peer(&name, &peer)?;
    }
    benchmark.write_table(DEFAULT, &mut std::io::stdout())?;
    benchmark.write_csv(DEFAULT, &out)?;
    #[cfg(feature = "figures")]
    benchmark.profile_figure().save(&out.join("profile"))?;
    println!("tables in {}", out.display());
    Ok(())
}
