//! The lines `solve` prints.

use std::io::{self, Write};

use serde::Serialize;

use super::{Certificate, SolveReport, Statuses, Verdict};

/// One JSON object.
pub(super) fn json_line(out: &mut dyn Write, value: &impl Serialize) -> io::Result<()> {
    serde_json::to_writer(&mut *out, value)?;
    writeln!(out)
}

/// Names of the columns.
pub(super) fn heading(out: &mut dyn Write, width: usize) -> io::Result<()> {
    writeln!(
        out,
        "{:width$} {:>8} {:>2}  {:20} {:>9} {:>9} {:>9} {:>10}  take-off/stick/slide",
        "problem", "contacts", "D", "solver", "iterations", "residual", "scaled", "CPU (s)"
    )
}

/// One problem.
pub(super) fn text_line(out: &mut dyn Write, report: &SolveReport, width: usize) -> io::Result<()> {
    let SolveReport { problem, contacts, dimension, solver, iterations, residual, .. } = report;
    let Statuses { take_off, stick, slide } = report.status;
    write!(
        out,
        "{problem:width$} {contacts:>8} {dimension:>2}  {solver:20} {iterations:>9} {residual:>9.1e} {:>9.1e} {:>10.3e}  \
         {take_off}/{stick}/{slide}",
        report.scaled_residual, report.cpu_seconds
    )?;
    if let Some(solver) = &report.rescued_by {
        write!(out, "  rescued by {solver}")?;
    }
    if !report.converged {
        write!(out, "  not converged")?;
        if let Some(reason) = &report.reason {
            write!(out, ": {reason}")?;
        }
        match &report.certificate {
            Some(Certificate { verdict: Verdict::Feasible, margin, .. }) => {
                write!(out, "; feasible with margin {margin:.1e}, residual above is the best reached")?;
            }
            Some(Certificate { verdict: Verdict::Infeasible, margin, .. }) => {
                write!(out, "; infeasible: no percussion opens every cone, margin {margin:.1e}")?;
            }
            Some(Certificate { verdict: Verdict::Undecided, .. }) => write!(out, "; feasibility undecided")?,
            None => {}
        }
    }
    writeln!(out)
}
