//! The figures of a study of a scene.

use super::lines::{MEASURES, Measure};
use super::scene::SceneResults;
use super::{Bin, Line};
use crate::plot::{Dash, Figure, Panel, Series, Style};

/// Size in pixels of a row of two panels over two journal columns.
const ROW: (f64, f64) = (644.0, 250.0);

/// Widths of a line, and of a marked one.
const WIDTHS: (f64, f64) = (1.1, 2.6);

impl SceneResults {
    /// Relative errors of q and v against CPU time, a line for each [`Line`]: a point is the h of a quarter of a decade,
    /// their largest error at their median time. Single precision is dotted, the marked line wide.
    pub fn speed_figure(&self) -> Figure {
        let lines = self.lines();
        let x = |bin: &Bin| bin.cpu_seconds;
        let panels = MEASURES[..2].iter().enumerate().map(|(rank, measure)| {
            let label = |line: &Line| if rank == 0 { self.name(line, &lines) } else { String::new() };
            self.panel(&lines, measure, "CPU time (s)", x, label)
        });
        Figure::new(2, panels.collect()).size(ROW.0, ROW.1)
    }

    /// Relative errors of the runs of fixed steps against h; the legends tell the regressed orders.
    pub fn order_figure(&self) -> Figure {
        let mut lines = self.lines();
        lines.retain(|line| !line.adaptive);
        let known = |measure: &&Measure| lines.iter().any(|line| line.order(measure).is_some());
        let x_label = format!("h ({})", self.units.time);
        let panels = MEASURES.iter().filter(known).map(|measure| {
            let order =
                |line: &Line| line.order(measure).map_or("—".into(), |order| format!("{:.2}", order.slope));
            let label = |line: &Line| {
                if stands_for_another(line, &lines) {
                    return String::new();
                }
                let twin = lines.iter().find(|other| line.is_twin(other));
                let single =
                    twin.map_or(String::new(), |twin| format!(" ({}: {})", twin.scalar, order(twin)));
                let name = if line.scheme.is_empty() { "order" } else { &line.scheme };
                format!("{name}: {}{single}", order(line)).replace('-', "−")
            };
            self.panel(&lines, measure, &x_label, |bin| bin.step, label)
        });
        Figure::new(2, panels.collect()).size(ROW.0, 1.2 * ROW.1)
    }

    fn name(&self, line: &Line, lines: &[Line]) -> String {
        match &self.mark {
            _ if stands_for_another(line, lines) => String::new(),
            Some(mark) if line.marked && !mark.label.is_empty() => {
                format!("{} ({})", line.scheme, mark.label)
            }
            _ => line.scheme.clone(),
        }
    }

    fn panel(
        &self,
        lines: &[Line],
        measure: &Measure,
        x_label: &str,
        x: impl Fn(&Bin) -> f64,
        label: impl Fn(&Line) -> String,
    ) -> Panel {
        let twins = lines.iter().any(|line| stands_for_another(line, lines));
        let dotted = if twins { ", dotted: f32" } else { "" };
        let mut panel = Panel::new(format!("{}{dotted}", measure.label), x_label, "relative error").log_log();
        let mut schemes: Vec<&str> = Vec::new();
        for line in lines {
            if !schemes.contains(&line.scheme.as_str()) {
                schemes.push(&line.scheme);
            }
        }
        // The wide line first, so that it hides none.
        let (marked, others): (Vec<&Line>, Vec<&Line>) = lines.iter().partition(|line| line.marked);
        for line in marked.into_iter().chain(others) {
            let color = schemes.iter().position(|scheme| *scheme == line.scheme).unwrap_or_default();
            let bins = line.envelope(measure);
            let (x, y) = bins.iter().map(|bin| (x(bin), bin.error)).unzip();
            let single = is_single(line);
            let style = if single { Style::Line } else { Style::LineAndMarkers };
            let series = Series::new(label(line), style, x, y)
                .color(color)
                .dash(if single { Dash::Dotted } else { Dash::Solid })
                .width(if line.marked { WIDTHS.1 } else { WIDTHS.0 });
            panel = panel.with(series);
        }
        panel
    }
}

fn is_single(line: &Line) -> bool {
    line.scalar == <f32 as crate::scalar::Scalar>::NAME
}

/// Whether a line is that of another one in single precision, which has its colour and its words.
fn stands_for_another(line: &Line, lines: &[Line]) -> bool {
    is_single(line) && lines.iter().any(|other| other.is_twin(line))
}

impl Line {
    /// Whether `other` is this line in another arithmetic.
    fn is_twin(&self, other: &Self) -> bool {
        self.scheme == other.scheme && self.scalar != other.scalar
    }
}
