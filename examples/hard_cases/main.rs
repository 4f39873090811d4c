//! The wall of hard cases: runs every case with every registered law and solver, and writes the table.
//!
//! ```text
//! cargo run --release --example hard_cases                  # everything, writes README.md here and the figures
//! cargo run --release --example hard_cases -- arch hybrid   # what matches every word, printed only
//! cargo run --release --example hard_cases -- figures       # the figures and the times of their runs only
//! ```

#[path = "cases/mod.rs"]
mod cases;
mod figures;
mod table;

use std::panic::{AssertUnwindSafe, catch_unwind};

use cases::{Choice, Outcome};
use nonsmooth::solver::SOLVERS;
use table::Row;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let mut rows = Vec::new();
    for (index, case) in cases::all().into_iter().enumerate().filter(|_| words != ["figures"]) {
        for &(scalar, run) in case.runs {
            for law in cases::laws() {
                for solver in SOLVERS {
                    let line = format!("{} {scalar} {} {}", case.name, law.name, solver.name);
                    if !words
                        .iter()
                        .all(|word| line.split_whitespace().any(|part| part.starts_with(word.as_str())))
                    {
                        continue;
                    }
                    let choice = Choice { law: law.name, solver: solver.name, full: true };
                    let clock = std::time::Instant::now();
                    let run = || run(&choice);
                    let outcome: Result<Outcome, String> = catch_unwind(AssertUnwindSafe(run))
                        .unwrap_or_else(|_| Err("panicked, which no case may".into()));
                    let seconds = clock.elapsed().as_secs_f64();
                    let row = Row { index, scalar, law: law.name, solver: solver.name, outcome, seconds };
                    eprintln!("{line}: {}", row.verdict());
                    rows.push(row);
                }
            }
        }
    }
    if words.is_empty() || words == ["figures"] {
        let warm = figures::save()?;
        eprint!("{warm}");
        if words.is_empty() {
            table::write("examples/hard_cases/README.md".as_ref(), &rows, &warm)?;
            println!("examples/hard_cases/README.md");
        }
    }
    Ok(())
}
