//! Figures of a comparison: Dolan–Moré profiles, and residual against time for one problem.

use super::Benchmark;
use crate::plot::{Figure, Panel, Scale, Series, Style};

/// Size in pixels of a figure over two journal columns.
pub(super) const SIZE: (f64, f64) = (644.0, 300.0);

impl Benchmark {
    /// The share of the problems each solver solves within τ times the best time, over τ (logarithmic).
    pub fn profile_figure(&self) -> Figure {
        Figure::new(1, vec![self.profile_panel("")]).size(SIZE.0, SIZE.1)
    }

    /// The panel of [`profile_figure`](Self::profile_figure).
    pub(super) fn profile_panel(&self, title: &str) -> Panel {
        let profiles = self.profiles();
        let finite = profiles.iter().flat_map(|p| &p.ratios).copied().filter(|r| r.is_finite());
        // Room to the right of the last step, so that the shares reached can be read.
        let end = 1.5 * finite.fold(1.0, f64::max);
        let mut panel = Panel::new(title, "time over best time", "share of problems solved");
        panel.x_scale = Scale::Log10;
        panel.x_limits = Some((1.0, end));
        panel.y_limits = Some((0.0, 1.02));
        for profile in profiles {
            let steps = profile.ratios.iter().zip(&profile.shares).filter(|(ratio, _)| ratio.is_finite());
            let (mut x, mut y): (Vec<f64>, Vec<f64>) = (vec![1.0], vec![0.0]);
            for (&ratio, &share) in steps {
                x.push(ratio);
                y.push(share);
            }
            x.push(end);
            y.push(y[y.len() - 1]);
            panel = panel.with(Series::new(profile.solver, Style::Steps, x, y));
        }
        panel
    }

    /// Scaled residual against time for one problem, one curve per solver measured here (both axes logarithmic).
    ///
    /// Estimates of the solvers, but for the last point of each curve, which is measured on the problem.
    pub fn curve_figure(&self, problem: &str) -> Figure {
        let mut panel = Panel::new(problem, "t (s)", "scaled residual").log_log();
        for m in self.measurements.iter().filter(|m| m.problem == problem && !m.curve.is_empty()) {
            let (x, y) = m.curve.iter().map(|point| (point.seconds, point.residual)).unzip();
            panel = panel.with(Series::new(m.solver.clone(), Style::LineAndMarkers, x, y));
        }
        Figure::new(1, vec![panel]).size(SIZE.0, SIZE.1)
    }
}
