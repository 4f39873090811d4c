//! The style of the figures: panels as the library's axes and plots.

use kuva::plot::{LinePlot, LineStyle, MarkerShape, ScatterPlot};
use kuva::render::layout::{AxisLabelOverlap, AxisLine, ComputedLayout, Layout, TickAlign};
use kuva::render::plots::Plot;
use kuva::render::render::{Primitive, Scene, TextAnchor, render_multiple};

use super::axis::Axis;
use super::legend::{self, GAP, Legend, SAMPLE};
use super::model::{Figure, Panel, Scale, Series, Style};
use super::shape::{Point, Shape};

/// Okabe and Ito's colours, the most readable on white first, and a grey.
const PALETTE: [&str; 9] =
    ["#0072b2", "#d55e00", "#009e73", "#000000", "#cc79a7", "#e69f00", "#56b4e9", "#f0e442", "#969696"];
const BLACK: usize = 3;
const GREY: usize = 8;
/// Dashes and gaps in widths of the line, whose round ends add to a dash.
const DASHES: [&[f64]; 5] = [&[], &[3.0, 2.6], &[0.02, 2.0], &[4.0, 2.2, 0.02, 2.2], &[7.0, 2.6]];
/// Markers, and whether they are open.
const MARKERS: [(MarkerShape, bool); 6] = [
    (MarkerShape::Circle, false),
    (MarkerShape::Square, true),
    (MarkerShape::Triangle, false),
    (MarkerShape::Diamond, true),
    (MarkerShape::Cross, false),
    (MarkerShape::Circle, true),
];
/// Radius of a marker.
const RADIUS: f64 = 2.3;
/// Width of the axes.
const RULE: f64 = 0.7;
/// The library's scale of margins and letters.
const SCALE: f64 = 0.5;
/// Above and below the axes, and on their right.
const MARGINS: (f64, f64, f64) = (20.0, 32.0, 13.0);

/// Draws the panels of a figure.
pub(super) fn draw(figure: &Figure) -> Scene {
    let columns = figure.columns.clamp(1, figure.panels.len().max(1));
    let size = (figure.width_px / columns as f64, figure.panel_height_px);
    let mut cells: Vec<Cell> = figure.panels.iter().map(|panel| Cell::new(panel, size)).collect();
    if cells.len() > 1 {
        ('a'..='z').zip(&mut cells).for_each(|(letter, c)| c.title = format!("({letter}) {}", c.title));
    }
    align(&mut cells, columns);
    cells.iter_mut().for_each(Cell::make_room);
    // Room for the legend changes the numbers at the axes.
    align(&mut cells, columns);
    let mut scene = Scene::new(figure.width_px, size.1 * cells.len().div_ceil(columns).max(1) as f64);
    scene.font_family = Some("DejaVu Sans, Verdana, Liberation Sans, Arial, sans-serif".to_owned());
    for (i, cell) in cells.iter().enumerate() {
        let corner = ((i % columns) as f64 * size.0, (i / columns) as f64 * size.1);
        scene.elements.push(Primitive::GroupStart {
            transform: Some(format!("translate({:.2},{:.2})", corner.0, corner.1)),
            title: None,
            extra_attrs: Some(r#"stroke-linejoin="round" stroke-linecap="round""#.to_owned()),
        });
        let panel = cell.draw(&format!("axes{i}"));
        scene.defs.extend(panel.defs);
        scene.elements.extend(panel.elements);
        scene.elements.push(Primitive::GroupEnd);
    }
    scene
}

/// Gives all panels of a column the same margin.
fn align(cells: &mut [Cell], columns: usize) {
    for column in 0..columns.min(cells.len()) {
        let left = |cell: &Cell| ComputedLayout::from_layout(&cell.layout(None)).margin_left;
        let widest = cells[column..].iter().step_by(columns).map(left).fold(0.0, f64::max);
        for cell in cells[column..].iter_mut().step_by(columns) {
            cell.axes.0 = (cell.size.0 - widest - MARGINS.2).max(1.0);
            cell.equalise();
        }
    }
}

/// A panel with its axes.
struct Cell<'a> {
    panel: &'a Panel,
    title: String,
    x: Axis,
    y: Axis,
    /// Width and height of the panel, and of its axes.
    size: Point,
    axes: Point,
    legend: Option<Legend>,
}

impl<'a> Cell<'a> {
    fn new(panel: &'a Panel, size: Point) -> Self {
        let series = || panel.series.iter();
        let drawn = |v: f64, scale| v.is_finite() && (scale == Scale::Linear || v > 0.0);
        let seen = |p: &Point| drawn(p.0, panel.x_scale) && drawn(p.1, panel.y_scale);
        let points = || series().flat_map(Series::points).filter(seen);
        let marked = series().any(|s| !matches!(s.style, Style::Line | Style::Steps));
        let pad = if marked || panel.equal_aspect { 0.06 } else { 0.0 };
        let zero = series().any(|s| s.style == Style::Stems).then_some(0.0);
        let x = Axis::fit(panel.x_scale, points().map(|p| p.0), pad, panel.x_limits);
        let y = Axis::fit(panel.y_scale, points().map(|p| p.1).chain(zero), 0.07, panel.y_limits);
        let axes = (0.7 * size.0, (size.1 - MARGINS.0 - MARGINS.1).max(1.0));
        Self { panel, title: panel.title.clone(), x, y, size, axes, legend: None }
    }

    fn shapes(&self) -> Vec<Shape> {
        self.panel.series.iter().map(|series| Shape::new(series, &self.x, &self.y, self.axes)).collect()
    }

    /// The series in the legend, with their ranks.
    fn named(&self) -> impl Iterator<Item = (usize, &'a Series)> {
        self.panel.series.iter().enumerate().filter(|(_, series)| !series.label.is_empty())
    }

    /// Finds a place for the legend, extending the vertical axis if need be.
    fn make_room(&mut self) {
        let labels: Vec<&str> = self.named().map(|(_, series)| series.label.as_str()).collect();
        if !labels.is_empty() {
            let extend = self.panel.y_limits.is_none() && !self.panel.equal_aspect;
            self.legend = Legend::find(&labels, &self.shapes(), self.axes, extend);
            let (below, above) = self.legend.as_ref().map_or((0.0, 0.0), |legend| legend.extra);
            self.y.grow(below, above);
        }
    }

    /// Lengthens one of the axes for both to have the same scale if they should.
    fn equalise(&mut self) {
        let (x, y, axes) = (&mut self.x, &mut self.y, self.axes);
        if self.panel.equal_aspect && !(x.log || y.log) {
            let ratio = x.ratio(y) * axes.1 / axes.0;
            let half = (ratio.max(1.0 / ratio) - 1.0).clamp(0.0, 1e6) / 2.0;
            if ratio > 1.0 { y.grow(half, half) } else { x.grow(half, half) }
        }
    }

    fn layout(&self, left: Option<f64>) -> Layout {
        let (x, y, axes) = (&self.x, &self.y, self.axes);
        let ((across, x_format), (up, y_format)) = (x.ticks(axes.0 / 52.0), y.ticks(axes.1 / 21.0));
        let (x_label, y_label) = (x.label(&self.panel.x_label), y.label(&self.panel.y_label));
        let label_size = font(&x_label, self.size.0).min(font(&y_label, self.size.1));
        let mut layout = Layout::new((x.lo, x.hi), (y.lo, y.hi))
            .with_width(self.size.0)
            .with_height(self.size.1)
            .with_scale(SCALE)
            .with_label_size((f64::from(label_size) / SCALE) as u32)
            .with_x_label(x_label)
            .with_y_label(y_label)
            .with_tick_size((10.0 / SCALE) as u32)
            .with_tick_align(TickAlign::Inside)
            .with_tick_length(3.5 / SCALE)
            .with_tick_width(RULE / SCALE)
            .with_axis_line(AxisLine::Box)
            .with_axis_line_width(RULE / SCALE)
            .with_show_grid(false)
            .with_x_label_overlap(AxisLabelOverlap::Thin)
            .with_x_tick_step(across)
            .with_y_tick_step(up)
            .with_x_tick_format(x_format)
            .with_y_tick_format(y_format)
            .with_force_margins_y(MARGINS.0, MARGINS.1);
        (layout.x_axis_min, layout.x_axis_max) = (Some(x.lo), Some(x.hi));
        (layout.y_axis_min, layout.y_axis_max) = (Some(y.lo), Some(y.hi));
        layout.force_margin_left = left;
        layout.force_margin_right = Some(MARGINS.2);
        layout
    }

    fn draw(&self, clip: &str) -> Scene {
        let (x, y, axes) = (&self.x, &self.y, self.axes);
        let mut plots = Vec::new();
        let zero = y.fraction(y.place(0.0));
        if self.panel.zero_line && zero > 0.0 && zero < 1.0 {
            let line = vec![(0.0, zero * axes.1), (axes.0, zero * axes.1)];
            self.plot((GREY, 0, 0.6), &Shape { lines: vec![line], marks: Vec::new() }, &mut plots);
        }
        for (rank, (series, shape)) in self.panel.series.iter().zip(self.shapes()).enumerate() {
            self.plot(pen(rank, series), &shape, &mut plots);
        }
        // A title begins above the axes, or before if it is long.
        let left_edge = self.size.0 - MARGINS.2 - axes.0;
        let size = font(&self.title, self.size.0 - MARGINS.2);
        let start = left_edge.min(self.size.0 - MARGINS.2 - legend::width(&self.title, size)).max(0.0);
        let mut texts = vec![text(start, MARGINS.0 - 4.5, size, &self.title)];
        for (i, (rank, series)) in self.named().enumerate() {
            let Some(legend) = &self.legend else { break };
            let (left, level) = legend.place(i);
            let (middle, right) = ((left + SAMPLE / 2.0, level), (left + SAMPLE, level));
            let line = vec![vec![(left, level), right]];
            let (lines, marks) = match series.style {
                Style::Line | Style::Steps => (line, vec![]),
                Style::Stems => (line, vec![(right.0 - RADIUS, level)]),
                Style::LineAndMarkers => (line, vec![middle]),
                Style::Markers => (vec![], vec![middle]),
            };
            self.plot(pen(rank, series), &Shape { lines, marks }, &mut plots);
            let foot = MARGINS.0 + axes.1 - level + 0.36 * f64::from(legend.font);
            texts.push(text(left_edge + right.0 + GAP, foot, legend.font, &series.label));
        }
        let ticks = minor_ticks(x, axes.0).map(|at| vec![(at, 0.0), (at, 2.0)]);
        let ticks = ticks.chain(minor_ticks(y, axes.1).map(|at| vec![(0.0, at), (2.0, at)]));
        self.plot((BLACK, 0, RULE), &Shape { lines: ticks.collect(), marks: Vec::new() }, &mut plots);
        let mut scene = render_multiple(plots, self.layout(Some(left_edge)));
        // The library numbers clips as they come; the same figure is to be the same file.
        for element in &mut scene.elements {
            if let Primitive::ClipStart { id, .. } = element {
                scene.defs.iter_mut().for_each(|def| *def = def.replace(id.as_str(), clip));
                clip.clone_into(id);
            }
        }
        scene.elements.extend(texts);
        scene
    }

    /// Adds lines and marks in pixels, in a colour, dashes and a width.
    fn plot(&self, (color, dashes, width): (usize, usize, f64), shape: &Shape, plots: &mut Vec<Plot>) {
        let number = |p: &Point| (self.x.number(p.0 / self.axes.0), self.y.number(p.1 / self.axes.1));
        let dashes: Vec<String> =
            DASHES[dashes].iter().map(|d| format!("{:.2}", d * width.max(0.6))).collect();
        let style = if dashes.is_empty() { LineStyle::Solid } else { LineStyle::Custom(dashes.join(" ")) };
        for line in &shape.lines {
            let plot = LinePlot::new().with_data(line.iter().map(number)).with_color(PALETTE[color]);
            plots.push(Plot::Line(plot.with_stroke_width(width).with_line_style(style.clone())));
        }
        let (marker, open) = MARKERS[color % MARKERS.len()];
        // An open marker is a smaller white one on a coloured one.
        let layers = [(PALETTE[color], RADIUS), ("#ffffff", RADIUS - 0.9)];
        for (color, radius) in layers.into_iter().take(1 + usize::from(open)) {
            let plot = ScatterPlot::new().with_data(shape.marks.iter().map(number)).with_color(color);
            plots.push(Plot::Scatter(plot.with_marker(marker).with_size(radius)));
        }
    }
}

/// The largest size of letters in which a text has room; the library neither shrinks nor cuts it.
fn font(text: &str, room: f64) -> u32 {
    ((room / legend::width(text, 1)) as u32).clamp(7, 11)
}

fn text(x: f64, y: f64, size: u32, content: &str) -> Primitive {
    let (content, anchor) = (content.to_owned(), TextAnchor::Start);
    Primitive::Text { x, y, content, size, anchor, rotate: None, bold: false, color: None }
}

/// Colour, dashes and width of a series.
fn pen(rank: usize, series: &Series) -> (usize, usize, f64) {
    let dashes = series.dash.map_or(rank % DASHES.len(), |dash| dash as usize);
    let width = if series.width.is_finite() { series.width.clamp(0.1, 20.0) } else { 1.0 };
    (series.color.unwrap_or(rank) % GREY, dashes, width)
}

/// Places between the decades of a logarithmic axis, unless there are too many.
fn minor_ticks(axis: &Axis, length: f64) -> impl Iterator<Item = f64> {
    let shown = axis.log && axis.hi - axis.lo < length / 30.0;
    let decades = if shown { axis.lo.floor() as i32..axis.hi.ceil() as i32 } else { 0..0 };
    let numbers = decades.flat_map(|d| (2..10).map(move |m| f64::from(d) + f64::from(m).log10()));
    numbers.map(move |n| axis.fraction(n) * length).filter(move |at| (0.0..=length).contains(at))
}
