//! Figures of solvers over tolerances.

use super::Sweep;
use super::figures::SIZE;
use super::sweep::full_name;
use crate::plot::{Dash, Figure, Panel, Scale, Series, Style};
use crate::scalar::Scalar;

/// Problems whose residuals are drawn, the largest.
const SHOWN: usize = 6;

impl Sweep {
    /// A line for a solver: single precision is dotted, in the colour of its name.
    fn series(&self, (solver, scalar): (&str, &str), (x, y): (Vec<f64>, Vec<f64>), named: bool) -> Series {
        let mut names: Vec<&str> = Vec::new();
        for (name, _) in self.solvers() {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let rank = names.iter().position(|name| *name == solver).unwrap_or_default();
        let alone = !self.solvers().contains(&(solver, f64::NAME));
        let (style, dash) = match scalar == f64::NAME {
            true => (Style::LineAndMarkers, Dash::Solid),
            false => (Style::Line, Dash::Dotted),
        };
        // One legend does for all panels, and one entry for both arithmetics.
        let label =
            if named && (alone || scalar == f64::NAME) { full_name(solver, scalar) } else { String::new() };
        Series::new(label, style, x, y).color(rank).dash(dash)
    }

    /// A title that tells what the dots are.
    fn title(&self, title: &str) -> String {
        let both = |scalar: &str| self.solvers().iter().any(|(_, own)| *own == scalar);
        let dotted = if both(f64::NAME) && both(f32::NAME) { ", dotted: f32" } else { "" };
        format!("{title}{dotted}")
    }

    /// The CPU time in which half of the problems are solved to a tolerance, and the share of problems solved to it.
    pub fn precision_figure(&self) -> Figure {
        let mut time = Panel::new(self.title("half of the problems"), "CPU time (s)", "tolerance").log_log();
        let mut share = Panel::new(self.title("all problems"), "tolerance", "share solved");
        share.x_scale = Scale::Log10;
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
            time = time.with(self.series(solver, times, true));
            share = share.with(self.series(solver, shares, false));
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
                    panel = panel.with(self.series(solver, points, rank == 0));
                }
                panel
            });
        Figure::new(2, panels.collect()).size(SIZE.0, 0.75 * SIZE.1)
    }

    /// Dolan–Moré profiles at some of the tolerances, of each arithmetic in which a solver solves half of the problems.
    pub fn profile_figure(&self, tolerances: &[f64]) -> Figure {
        let mut scalars: Vec<&str> = self.solvers().into_iter().map(|(_, scalar)| scalar).collect();
        scalars.sort_by(|a, b| b.cmp(a));
        scalars.dedup();
        let mut panels = Vec::new();
        for &tolerance in tolerances {
            for &scalar in &scalars {
                let own = self.solvers().into_iter().filter(|(_, own)| *own == scalar);
                let mut solved = own.map(|solver| self.solved(solver, tolerance).1);
                if solved.any(|seconds| seconds.is_some()) {
                    panels.push(
                        self.at(tolerance, scalar).profile_panel(&format!("{scalar} to {tolerance:e}")),
                    );
                }
            }
        }
        Figure::new(2, panels).size(SIZE.0, 0.8 * SIZE.1)
    }
}
