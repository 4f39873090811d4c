//! The table of the cases, as Markdown.

use std::fmt::Write as _;
use std::path::Path;

use crate::cases::{self, Outcome};

/// A case under one law, solver and scalar.
pub(crate) struct Row {
    pub(crate) index: usize,
    pub(crate) scalar: &'static str,
    pub(crate) law: &'static str,
    pub(crate) solver: &'static str,
    pub(crate) outcome: Result<Outcome, String>,
    pub(crate) seconds: f64,
}

impl Row {
    fn passes(&self) -> bool {
        self.outcome.as_ref().is_ok_and(|outcome| outcome.checks.iter().all(|check| check.holds()))
    }

    /// One line: what holds, what does not.
    pub(crate) fn verdict(&self) -> String {
        match &self.outcome {
            Err(error) => format!("FAILS ({:.2} s): {error}", self.seconds),
            Ok(outcome) => {
                let mut line = if self.passes() { "passes".to_string() } else { "MISSES".to_string() };
                let _ = write!(line, " ({:.2} s)", self.seconds);
                for check in &outcome.checks {
                    let mark = if check.holds() { "" } else { " ✗" };
                    let _ = write!(line, "; {} = {}{mark}", check.what, number(check.measured));
                    if !check.holds() {
                        let _ = write!(line, " (expected {} ± {:.0e})", number(check.expected), check.bound);
                    }
                }
                for note in &outcome.notes {
                    let _ = write!(line, "; {note}");
                }
                line
            }
        }
    }
}

fn number(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 {
        "0".into()
    } else if (1e-2..1e5).contains(&size) {
        let text = format!("{x:.9}");
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        format!("{x:.2e}")
    }
}

/// Pipes would end a cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}

/// Writes the table.
pub(crate) fn write(path: &Path, rows: &[Row], warm: &str) -> std::io::Result<()> {
    let mut out = String::from(
        "# Hard cases\n\nWritten by `cargo run --release --example hard_cases`; smaller sizes of the same cases run in \
         `cargo test --test hard_cases`.\nEvery case runs under every registered law and solver. A case *passes* if every \
         number lies within its bound; a solver that does\nnot is shown with its residual. Times are wall times of \
         the whole case on one core.\n\n| case | number | numbers measured (Frémond, default solver, f64) | passing | \
         time |\n|---|---|---|---|---|\n",
    );
    let cases = cases::all();
    for (index, case) in cases.iter().enumerate() {
        let of: Vec<&Row> = rows.iter().filter(|row| row.index == index).collect();
        let best = of.iter().find(|row| row.law == "fremond" && row.solver == nonsmooth::solver::DEFAULT);
        let (measured, seconds) = best.map_or_else(
            || ("not run".to_string(), 0.0),
            |row| match &row.outcome {
                Err(error) => (error.clone(), row.seconds),
                Ok(outcome) => {
                    let checks = outcome.checks.iter().map(|check| {
                        let mark = if check.holds() { "" } else { " ✗" };
                        format!("{}: {}{mark}", check.what, number(check.measured))
                    });
                    (checks.collect::<Vec<_>>().join("; "), row.seconds)
                }
            },
        );
        let passing = of.iter().filter(|row| row.passes()).count();
        let _ = writeln!(
            out,
            "| [{}](#case-{}) | {} | {} | {passing} of {} | {seconds:.2} s |",
            case.name,
            index + 1,
            cell(case.number),
            cell(&measured),
            of.len()
        );
    }
    let _ = writeln!(out, "\n## Warm-started, with the default solver\n\n{warm}");
    out.push_str("![The arches, the stack and the chain](examples/figures/hard_cases.png)\n");
    for (index, case) in cases.iter().enumerate() {
        let _ = writeln!(
            out,
            "\n## Case {}\n\n**{}**: {}.\n\n{}\n",
            index + 1,
            case.name,
            case.number,
            case.about
        );
        if !case.peer.is_empty() {
            let _ = writeln!(out, "Beside it: {}.\n", case.peer);
        }
        out.push_str("| law | solver | scalar | | worst number, of its bound | iterations per solve | µs per step | time |\n");
        out.push_str("|---|---|---|---|---|---|---|---|\n");
        let of = rows.iter().filter(|row| row.index == index);
        for row in of {
            let verdict = if row.passes() { "passes" } else { "**fails**" };
            let (detail, iterations, step) = match &row.outcome {
                Err(error) => (error.clone(), String::new(), String::new()),
                Ok(outcome) => {
                    let share = |check: &&cases::support::Check| {
                        let off = check.off();
                        if check.bound > 0.0 {
                            off / check.bound
                        } else if off == 0.0 {
                            0.0
                        } else {
                            f64::INFINITY
                        }
                    };
                    let worst = outcome.checks.iter().max_by(|a, b| share(a).total_cmp(&share(b)));
                    let worst = worst.map_or_else(String::new, |check| {
                        let mut text = format!("{} = {}", check.what, number(check.measured));
                        if check.least {
                            let _ = write!(text, ", at least {}", number(check.expected));
                        } else if check.expected != 0.0 {
                            let _ = write!(text, ", expected {}", number(check.expected));
                        }
                        if check.bound > 0.0 {
                            let _ = write!(text, " ± {:.0e}", check.bound);
                        }
                        text
                    });
                    let notes: String =
                        outcome.notes.iter().fold(String::new(), |all, note| all + "; " + note);
                    let per = |total: f64, count: usize| if count == 0 { 0.0 } else { total / count as f64 };
                    (
                        worst + &notes,
                        format!("{:.1}", per(outcome.iterations as f64, outcome.solves)),
                        format!("{:.2}", per(outcome.seconds * 1e6, outcome.steps)),
                    )
                }
            };
            let _ = writeln!(
                out,
                "| `{}` | `{}` | {} | {verdict} | {} | {iterations} | {step} | {:.2} s |",
                row.law,
                row.solver,
                row.scalar,
                cell(&detail),
                row.seconds
            );
        }
    }
    std::fs::write(path, out)
}
