//! The table of the cases, as Markdown.

use std::fmt::Write as _;
use std::path::Path;

use crate::cases::support::Check;
use crate::cases::{self, Case, Outcome};
use nonsmooth::solver::{DEFAULT, SOLVERS};

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
        self.outcome.as_ref().is_ok_and(|outcome| outcome.checks.iter().all(Check::holds))
    }

    /// What failed or missed, with its numbers.
    fn failure(&self) -> String {
        match &self.outcome {
            Err(error) => shortened(error),
            Ok(outcome) => {
                let missed = outcome.checks.iter().filter(|check| !check.holds());
                let missed: Vec<_> = missed
                    .map(|check| format!("{} = {} ({})", check.what, number(check.measured), wanted(check)))
                    .collect();
                missed.join(", ")
            }
        }
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
                        let _ = write!(line, " ({})", wanted(check));
                    }
                }
                outcome.notes.iter().fold(line, |line, note| line + "; " + note)
            }
        }
    }

    /// Time and iterations per solve, or a cross.
    fn cell(&self) -> String {
        match &self.outcome {
            Ok(outcome) if self.passes() => {
                let iterations = outcome.iterations as f64 / outcome.solves.max(1) as f64;
                format!("{} s · {iterations:.1}", brief(self.seconds))
            }
            _ => "**✗**".into(),
        }
    }
}

/// The value a check asks for.
fn wanted(check: &Check) -> String {
    match (check.least, check.expected, check.bound) {
        (true, expected, _) => format!("≥ {}", number(expected)),
        (_, expected, 0.0) => number(expected),
        (_, 0.0, bound) => format!("≤ {bound:.0e}"),
        (_, expected, bound) => format!("{} ± {bound:.0e}", number(expected)),
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

/// Three digits.
fn brief(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 {
        "0".into()
    } else if (1e-2..1e4).contains(&size) {
        let decimals = (2.0 - size.log10().floor()).clamp(0.0, 4.0);
        let text = format!("{x:.*}", decimals as usize);
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
    } else {
        format!("{x:.1e}")
    }
}

/// A message with its numbers cut to a few digits.
fn shortened(message: &str) -> String {
    let mut out = String::new();
    let mut rest = message;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let (before, from) = rest.split_at(start);
        out.push_str(before);
        let end = from.find(|c: char| !(c.is_ascii_digit() || c == '.' || c == 'e' || c == '-'));
        let (token, after) = from.split_at(end.unwrap_or(from.len()));
        match token.parse::<f64>() {
            Ok(x) if token.len() > 8 => out.push_str(&brief(x)),
            _ => out.push_str(token),
        }
        rest = after;
    }
    (out + rest).replace('\n', " ")
}

/// Pipes would end a cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}

/// Numbers shown in a cell of the first table.
const MOST_NUMBERS: usize = 6;

const HEAD: &str = "# Hard cases

Written by `cargo run --release --example hard_cases`; smaller sizes of the same cases run in `cargo test --test
hard_cases`. Every case runs under every registered law and solver, in double precision and, where the number allows, in
single. A run *passes* if every number lies within its bound; one that does not stands below its case with its residual.
Times are wall times of the whole case on one core.

| case | number | measured: Frémond, default solver | passing | time |
|---|---|---|---|---|
";

/// Writes the table.
pub(crate) fn write(path: &Path, rows: &[Row], warm: &str) -> std::io::Result<()> {
    let mut out = String::from(HEAD);
    let cases = cases::all();
    for (index, case) in cases.iter().enumerate() {
        let of: Vec<&Row> = rows.iter().filter(|row| row.index == index).collect();
        let best = default_run(&of, "fremond");
        let (measured, seconds) = best.map_or_else(
            || ("not run".to_string(), 0.0),
            |row| match &row.outcome {
                Err(_) => ("**fails**, see there".into(), row.seconds),
                Ok(outcome) => {
                    let values = outcome
                        .checks
                        .iter()
                        .take(MOST_NUMBERS)
                        .map(|check| brief(check.measured) + if check.holds() { "" } else { " ✗" });
                    let more = if outcome.checks.len() > MOST_NUMBERS { " …" } else { "" };
                    (values.collect::<Vec<_>>().join(" · ") + more, row.seconds)
                }
            },
        );
        let passing = of.iter().filter(|row| row.passes()).count();
        let _ = writeln!(
            out,
            "| [{}](#case-{}) | {} | {measured} | {passing} of {} | {} s |",
            case.name,
            index + 1,
            cell(case.number),
            of.len(),
            brief(seconds),
        );
    }
    let _ = writeln!(out, "\n## Warm-started, with the default solver\n\n{warm}");
    out.push_str("![The arches, the stack, the chain, the pendulum](../figures/hard_cases.png)\n\n");
    out.push_str(
        "In the tables of the cases a cell has the time of the run and the iterations per solve (sweeps, Newton steps or \
         convex programs, as the solver counts them).\n",
    );
    for (index, case) in cases.iter().enumerate() {
        let of: Vec<&Row> = rows.iter().filter(|row| row.index == index).collect();
        section(&mut out, index, case, &of);
    }
    std::fs::write(path, out)
}

/// The run of the default solver in double precision.
fn default_run<'a>(of: &[&'a Row], law: &str) -> Option<&'a Row> {
    of.iter().copied().find(|row| row.law == law && row.solver == DEFAULT && row.scalar == "f64")
}

/// A case: what it is, its numbers, the runs, those that fail, and what there is to note.
fn section(out: &mut String, index: usize, case: &Case, of: &[&Row]) {
    let _ = writeln!(out, "\n## Case {}\n\n**{}**: {}.\n", index + 1, case.name, case.number);
    let _ = writeln!(out, "{}\n", case.about);
    if !case.peer.is_empty() {
        let _ = writeln!(out, "Beside it: {}.\n", case.peer);
    }
    if let Some(Ok(outcome)) = default_run(of, "fremond").map(|row| &row.outcome) {
        out.push_str("| Frémond, default solver | measured | wanted |\n|---|---|---|\n");
        for check in &outcome.checks {
            let _ =
                writeln!(out, "| {} | {} | {} |", cell(&check.what), number(check.measured), wanted(check));
        }
        out.push('\n');
    }
    let columns: Vec<(&str, &str)> =
        case.runs.iter().flat_map(|&(scalar, _)| cases::laws().map(move |law| (scalar, law.name))).collect();
    let heads: Vec<_> = columns.iter().map(|(scalar, law)| format!("{law} {scalar}")).collect();
    let _ = writeln!(out, "| solver | {} |\n|---{}|", heads.join(" | "), "|---".repeat(columns.len()));
    for solver in SOLVERS {
        let cells: Vec<_> = columns
            .iter()
            .map(|&(scalar, law)| {
                let run =
                    of.iter().find(|row| row.scalar == scalar && row.law == law && row.solver == solver.name);
                run.map_or_else(|| "not run".into(), |row| row.cell())
            })
            .collect();
        let _ = writeln!(out, "| `{}` | {} |", solver.name, cells.join(" | "));
    }
    for solver in SOLVERS {
        let failing = of.iter().filter(|row| row.solver == solver.name && !row.passes());
        let failing: Vec<_> =
            failing.map(|row| format!("{} {}: {}", row.law, row.scalar, row.failure())).collect();
        if !failing.is_empty() {
            let _ = writeln!(out, "\n`{}` fails. {}.", solver.name, failing.join("; "));
        }
    }
    for law in cases::laws() {
        if let Some(Ok(outcome)) = default_run(of, law.name).map(|row| &row.outcome)
            && !outcome.notes.is_empty()
        {
            let _ = writeln!(out, "\n{}, default solver: {}.", law.name, outcome.notes.join("; "));
        }
    }
}
