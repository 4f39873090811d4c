//! Figures of solvers over tolerances.

use super::Sweep;
use super::figures::SIZE;
use super::sweep::full_name;
use crate::plot::{Dash, Figure, Panel, Series, Style};
use crate::scalar::Scalar;

/// Problems whose residuals are drawn, the largest.
const SHOWN: usize = 6;

impl Sweep {
    /// A line for a solver: one colour for both arithmetics, single precision dotted.
    fn series(&self, (solver, scalar): (&str, &str), style: Style, (x, y): (Vec<f64>, Vec<f64>)) -> Series {
        let mut names: Vec<&str> = Vec::new();
        for (name, _) in self.solvers() {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let color = names.iter().position(|name| *name == solver).unwrap_or_default();
        let dash = if scalar == f64::NAME { Dash::Solid } else { Dash::Dotted };
        Series::new(full_name(solver, scalar), style, x, y).color(color).dash(dash)
    }

    /// The CPU time in which half of the problems are solved to a tolerance, and the share of problems solved to it.
    pub fn precision_figure(&self) -> Figure {
        let mut time = Panel::new("half of the problems", "CPU time (s)", "tolerance").log_log();
        let mut share = Panel::new("all problems", "tolerance", "share solved");
        share.x_scale = crate::plot::Scale::Log10;
        let problems = self.problems().len().max(1) as f64;
        for solver in self.solvers() {
            let (mut times, mut shares) = ((Vec::new(), Vec::new()), (Vec::new(), Vec::new()));
            for tolerance in self.tolerances() {
                let (solved, seconds) = self.solved(solver, tolerance);
                times.0.push(seconds.unwrap_or(f64::NAN));
                times.1.push(tolerance);
                shares.0.push(tolerance);
                shares.1.push(solved as f64 / problems);
            }
            time = time.with(self.series(solver, Style::LineAndMarkers, times));
            let mut line = self.series(solver, Style::LineAndMarkers, shares);
            // The legend of the first panel is that of both.
            line.label.clear();
            share = share.with(line);
        }
        Figure::new(2, vec![time, share]).size(SIZE.0, SIZE.1)
    }

    /// The residual reached against the CPU time it took, tolerance by tolerance, of the largest problems.
    pub fn residual_figure(&self) -> Figure {
        let panels =
            self.problems().into_iter().take(SHOWN).enumerate().map(|(rank, (contacts, problem))| {
                let title = format!("{problem}, {contacts} contacts");
                let mut panel = Panel::new(title, "CPU time (s)", "residual").log_log();
                for solver in self.solvers() {
                    let own = self.measurements.iter().filter(|m| {
                        m.problem == problem && m.solved && (m.solver.as_str(), m.scalar.as_str()) == solver
                    });
                    // The residual that is larger decides; one of 0 has no place on the axis.
                    let points = own.map(|m| (m.cpu_seconds, m.residual.max(m.scaled_residual)));
                    let points = points.filter(|(_, residual)| *residual > 0.0).unzip();
                    let mut line = self.series(solver, Style::LineAndMarkers, points);
                    if rank > 0 {
                        line.label.clear();
                    }
                    panel = panel.with(line);
                }
                panel
            });
        Figure::new(2, panels.collect()).size(SIZE.0, 0.75 * SIZE.1)
    }

    /// Dolan–Moré profiles at some of the tolerances.
    pub fn profile_figure(&self, tolerances: &[f64]) -> Figure {
        let panel = |&tolerance: &f64| self.at(tolerance).profile_panel(&format!("to {tolerance:e}"));
        Figure::new(2, tolerances.iter().map(panel).collect()).size(SIZE.0, SIZE.1)
    }
}
