//! What the terminal shows.

use std::error::Error;
use std::fmt::Write as _;
use std::io::Write as _;
use std::process::ExitCode;

use crate::laws::Parameter;
use crate::observe::{RunSummary, Units};
use crate::registry::Registry;
use crate::solver::DEFAULT;

/// Impacts shown in the table; the others are in `summary.json`.
const SHOWN_IMPACTS: usize = 12;

/// Writes to the terminal; a reader that went away is no error.
fn show(text: &str) -> Result<ExitCode, Box<dyn Error>> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(ExitCode::SUCCESS),
    }
}

/// Lists the laws.
pub(super) fn laws(registry: &Registry) -> Result<ExitCode, Box<dyn Error>> {
    let mut text = String::new();
    for law in registry.laws() {
        writeln!(text, "{}\n  {}\n  {}", law.name, law.title, law.equation)?;
        writeln!(text, "  dissipative for: {}\n  {}", law.claim, law.reference)?;
        for Parameter { name, symbol, meaning, min, max, default, .. } in law.parameters {
            let default = default.map_or("mandatory".into(), |x| format!("default {x}"));
            writeln!(text, "    {name:12} {symbol} in [{min}, {max}], {default}: {meaning}")?;
        }
    }
    show(&text)
}

/// Lists the solvers.
pub(super) fn solvers(registry: &Registry) -> Result<ExitCode, Box<dyn Error>> {
    let mut text = String::new();
    for solver in registry.solvers() {
        let mark = if solver.name == DEFAULT { " (default)" } else { "" };
        writeln!(text, "{}{mark}\n  {}\n  for: {}", solver.name, solver.title, solver.when)?;
        writeln!(text, "  {}", solver.reference)?;
    }
    show(&text)
}

/// The impacts of all runs side by side, and a line of figures for each run.
pub(super) fn runs(title: &str, runs: &[RunSummary], units: &Units) -> Result<ExitCode, Box<dyn Error>> {
    let several_solvers = runs.iter().any(|run| run.solver != runs[0].solver);
    let label = |run: &RunSummary| match several_solvers {
        true => format!("{}/{}", run.law, run.solver),
        false => run.law.clone(),
    };
    let width = runs.iter().map(|run| label(run).chars().count()).max().unwrap_or(0).max(3);
    let mut text = format!("{title}\n\n");
    impacts(&mut text, runs, label, width, units)?;
    let energy = |name: &str| format!("{name} ({})", units.energy);
    writeln!(
        text,
        "{:width$}  {:>9} {:>8}  {:>12} {:>12}  {:>11} {:>11} {:>6}  {:>9} {:>9}",
        "run",
        "steps",
        "µs/step",
        energy("first E"),
        energy("final E"),
        energy("max w_N"),
        energy("max w_T"),
        "w > 0",
        "imbalance",
        "residual",
    )?;
    for run in runs {
        writeln!(
            text,
            "{:width$}  {:>9} {:>8.3}  {:>12.6e} {:>12.6e}  {:>+11.3e} {:>+11.3e} {:>6}  {:>9.1e} {:>9.1e}",
            label(run),
            run.steps,
            run.us_per_step,
            run.initial_energy,
            run.final_energy,
            run.max_normal_work,
            run.max_tangential_work,
            run.positive_work_steps,
            run.max_imbalance,
            run.max_residual,
        )?;
        if let Some(adaptive) = &run.adaptive {
            writeln!(
                text,
                "{:width$}  ε = {:e}: {} steps kept of {} computed, {} trials given up, {} events; estimated error {:.1e} of \
                 the scene's length; steps of {:.1e} to {:.1e} s",
                "",
                adaptive.tolerance,
                adaptive.accepted,
                adaptive.computed,
                adaptive.rejected,
                adaptive.events,
                adaptive.estimated_error,
                adaptive.smallest_step,
                adaptive.largest_step,
            )?;
        }
        if run.rescues > 0 {
            let (n, solver) = (run.rescues, &run.solver);
            writeln!(
                text,
                "{:width$}  steps that {solver} missed, solved by another start or method: {n}",
                ""
            )?;
        }
        if let Some(reason) = &run.stopped {
            writeln!(text, "{:width$}  stopped early: {reason}", "")?;
        }
    }
    show(&text)
}

fn impacts(
    text: &mut String,
    runs: &[RunSummary],
    label: impl Fn(&RunSummary) -> String,
    width: usize,
    units: &Units,
) -> std::fmt::Result {
    let most = runs.iter().map(|run| run.impacts.len()).max().unwrap_or(0);
    if most == 0 {
        return writeln!(text, "no impact\n");
    }
    let works = ["w_N", "w_T"].map(|work| format!("{work} ({})", units.energy));
    let heads = ["u_N-", "u_T-", "u_N+", "u_T+", "p_N", "p_T", &works[0], &works[1]];
    write!(text, "impact  {:width$} {:>9} {:>10}", "run", "step", format!("t ({})", units.time))?;
    heads.iter().try_for_each(|head| write!(text, " {head:>11}"))?;
    writeln!(text, "  contact")?;
    for i in 0..most.min(SHOWN_IMPACTS) {
        for (j, run) in runs.iter().enumerate() {
            let Some(impact) = run.impacts.get(i) else { continue };
            let number = if j == 0 { (i + 1).to_string() } else { String::new() };
            write!(text, "{number:>6}  {:width$} {:>9} {:>10.6}", label(run), impact.step, impact.time)?;
            for vector in [&impact.u_before, &impact.u_after, &impact.percussion] {
                for axis in 0..2 {
                    match vector.get(axis) {
                        Some(x) => write!(text, " {x:>+11.6}")?,
                        None => write!(text, " {:>11}", "–")?,
                    }
                }
            }
            writeln!(
                text,
                " {:>+11.3e} {:>+11.3e}  {}",
                impact.normal_work, impact.tangential_work, impact.contact
            )?;
        }
    }
    let all = runs.iter().map(|run| run.impact_count).max().unwrap_or(0);
    if all > SHOWN_IMPACTS {
        writeln!(text, "        … and {} more", all - SHOWN_IMPACTS)?;
    }
    writeln!(text)
}
