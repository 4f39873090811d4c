//! Arrangement of titles, axes and curves on the page.

use kuva::render::render::TextAnchor;

use super::axis::{Axis, Tick, axes};
use super::draw::{Ink, Pen};
use super::legend::{Entry, Placed};
use super::model::{Figure, Legend, Panel, Scale};
use super::shape::{Frame, Shape};
use super::text::{self, Text};

const BLACK: (u8, u8, u8) = (0, 0, 0);
const GREY: (u8, u8, u8) = (150, 150, 150);
const FRAME_WIDTH: f64 = 0.7;
/// Space between panels and around the figure.
const SPACE: f64 = 7.0;
/// Space between an axis and its tick labels.
const TICK_GAP: f64 = 3.5;
/// The same below the axes: a label at the foot of the vertical axis must clear it.
const FOOT_GAP: f64 = 5.0;

/// A panel being laid out.
struct Cell<'a> {
    panel: &'a Panel,
    title: String,
    x: Axis,
    y: Axis,
    frame: Frame,
    legend: Option<Placed>,
    entries: Vec<Entry>,
}

/// Draws the figure and returns its height; `ink` says for which backend.
pub(super) fn draw(figure: &Figure, ink: &mut Ink) -> f64 {
    let page = Page::new(figure);
    let mut cells: Vec<Cell> = (0..figure.panels.len()).map(|i| page.cell(i)).collect();
    page.place(&mut cells);
    for cell in &mut cells {
        page.find_legend(cell);
        let (below, above) = cell.legend.as_ref().map_or((0.0, 0.0), |l| l.extra);
        cell.y.grow(below, above);
        cell.equalise();
    }
    // Room for legends and equal scales change the ticks, hence the margins.
    page.place(&mut cells);
    for cell in &mut cells {
        cell.equalise();
        page.find_legend(cell);
        page.draw(cell, ink);
    }
    if let Some(title) = &figure.title {
        let (size, content) = text::fit(title, figure.font_px + 1, figure.width_px - 2.0 * SPACE);
        let y = SPACE + f64::from(size);
        page.text(ink, &content, (figure.width_px / 2.0, y), size, TextAnchor::Middle);
    }
    page.top + page.rows() as f64 * figure.panel_height_px + SPACE / 2.0
}

/// Dimensions common to the panels.
struct Page<'a> {
    figure: &'a Figure,
    columns: usize,
    /// Ordinate of the first row.
    top: f64,
    font: f64,
    tick: f64,
}

impl<'a> Page<'a> {
    fn new(figure: &'a Figure) -> Self {
        let font = f64::from(figure.font_px);
        let title = figure.title.is_some();
        Self {
            figure,
            columns: figure.columns.clamp(1, figure.panels.len().max(1)),
            top: SPACE / 2.0 + if title { 1.8 * font } else { 0.0 },
            font,
            tick: f64::from(self::tick_px(figure)),
        }
    }

    fn rows(&self) -> usize {
        self.figure.panels.len().div_ceil(self.columns)
    }

    fn cell(&self, index: usize) -> Cell<'a> {
        let panel = &self.figure.panels[index];
        let letter = letter(index).filter(|_| self.figure.panels.len() > 1);
        let title = match (letter, panel.title.as_str()) {
            (Some(letter), "") => format!("({letter})"),
            (Some(letter), title) => format!("({letter}) {title}"),
            (None, title) => title.to_owned(),
        };
        let named = panel.series.iter().enumerate();
        let named = named.filter(|(_, s)| !s.label.is_empty() && panel.legend == Legend::Auto);
        let entries = named.map(|(rank, series)| Entry {
            label: series.label.clone(),
            pen: Pen::new(series, rank),
            style: series.style,
        });
        let (x, y) = axes(panel);
        Cell { panel, title, x, y, frame: Frame::default(), legend: None, entries: entries.collect() }
    }

    /// Gives each panel the rectangle of its axes, aligned in rows and columns.
    fn place(&self, cells: &mut [Cell]) {
        let columns = self.columns as f64;
        let width = (self.figure.width_px - (columns + 1.0) * SPACE) / columns;
        let named = |s: &str| !s.is_empty();
        let above = if cells.iter().any(|c| named(&c.title)) { 1.55 * self.font } else { 0.5 * self.tick };
        let below = FOOT_GAP
            + 1.1 * self.tick
            + if cells.iter().any(|c| named(&c.panel.x_label)) { 1.35 * self.font } else { 0.0 };
        let height = self.figure.panel_height_px - above - below;
        for column in 0..self.columns {
            let members = || (column..cells.len()).step_by(self.columns);
            let left = members().map(|i| self.left(&cells[i], height)).fold(0.0, f64::max);
            let right = members().map(|i| self.right(&cells[i], width - left)).fold(2.0, f64::max);
            for i in (column..cells.len()).step_by(self.columns) {
                let row = (i / self.columns) as f64;
                let x = SPACE + column as f64 * (width + SPACE) + left;
                let y = self.top + row * self.figure.panel_height_px + above;
                cells[i].frame =
                    Frame { corner: (x, y), size: ((width - left - right).max(1.0), height.max(1.0)) };
            }
        }
    }

    /// Width of what stands on the left of the vertical axis.
    fn left(&self, cell: &Cell, height: f64) -> f64 {
        let label = if cell.panel.y_label.is_empty() && cell.y.exponent == 0 { 0.0 } else { 1.3 * self.font };
        TICK_GAP + self.widest(&self.y_ticks(cell, height)) + label
    }

    /// Width by which tick labels extend beyond the horizontal axis.
    fn right(&self, cell: &Cell, width: f64) -> f64 {
        let over = |t: &Tick| {
            let label = t.label.as_deref().unwrap_or_default();
            text::width(label, self.tick) / 2.0 - (1.0 - t.at) * width
        };
        let ticks = self.x_ticks(cell, width);
        ticks.iter().map(over).fold(0.0, f64::max)
    }

    fn widest(&self, ticks: &[Tick]) -> f64 {
        let labels = ticks.iter().filter_map(|t| t.label.as_deref());
        labels.map(|l| text::width(l, self.tick)).fold(0.0, f64::max)
    }

    fn x_ticks(&self, cell: &Cell, width: f64) -> Vec<Tick> {
        let fits = |ticks: &[Tick]| {
            let mut places = ticks.iter().filter(|t| t.label.is_some()).map(|t| t.at);
            let gap = match (places.next(), places.next()) {
                (Some(a), Some(b)) => (b - a) * width,
                _ => f64::INFINITY,
            };
            gap >= self.widest(ticks) + 0.8 * self.tick
        };
        cell.x.ticks((width / 28.0).clamp(2.0, 10.0) as usize, fits)
    }

    fn y_ticks(&self, cell: &Cell, height: f64) -> Vec<Tick> {
        let most = height / (2.0 * self.tick);
        cell.y.ticks(most.clamp(2.0, 8.0) as usize, |_| true)
    }

    fn find_legend(&self, cell: &mut Cell) {
        let fixed = cell.panel.y_limits.is_some() || cell.panel.equal_aspect;
        let stretch = cell.legend.is_none() && !fixed;
        cell.legend = if cell.entries.is_empty() {
            None
        } else {
            let size = tick_px(self.figure);
            Placed::find(&cell.entries, &cell.shapes(), cell.frame, size, stretch)
        };
    }

    fn draw(&self, cell: &Cell, ink: &mut Ink) {
        let Frame { corner, size } = cell.frame;
        let (left, top) = corner;
        let (right, bottom) = (left + size.0, top + size.1);
        if let (true, Some(zero)) = (cell.panel.zero_line, cell.y.zero()) {
            let y = bottom - zero * size.1;
            ink.lines(&[vec![(left, y), (right, y)]], GREY, 0.6);
        }
        for (rank, (series, shape)) in cell.panel.series.iter().zip(cell.shapes()).enumerate() {
            let pen = Pen::new(series, rank);
            ink.dashed(&shape.lines, pen.rgb, pen.width, pen.dash);
            ink.marks(&shape.marks, &pen);
        }
        let mut ruling = vec![vec![corner, (right, top), (right, bottom), (left, bottom), corner]];
        let tick = |t: &Tick| if t.label.is_some() { 3.5 } else { 2.0 };
        for t in self.x_ticks(cell, size.0) {
            let x = left + t.at * size.0;
            ruling.push(vec![(x, bottom), (x, bottom - tick(&t))]);
            let y = bottom + FOOT_GAP + 0.8 * self.tick;
            self.tick_label(ink, &t, (x, y), TextAnchor::Middle);
        }
        for t in self.y_ticks(cell, size.1) {
            let y = bottom - t.at * size.1;
            ruling.push(vec![(left, y), (left + tick(&t), y)]);
            let at = (left - TICK_GAP, y + 0.36 * self.tick);
            self.tick_label(ink, &t, at, TextAnchor::End);
        }
        ink.lines(&ruling, BLACK, FRAME_WIDTH);
        self.labels(cell, ink);
        if let Some(legend) = &cell.legend {
            legend.draw(&cell.entries, ink);
        }
    }

    fn labels(&self, cell: &Cell, ink: &mut Ink) {
        let Frame { corner, size } = cell.frame;
        let font = self.figure.font_px;
        let outer = self.left(cell, size.1);
        let room = size.0 + outer;
        let (px, title) = text::fit(&cell.title, font, room);
        let start = corner.0 + size.0 - text::width(&title, f64::from(px));
        let at = (start.min(corner.0), corner.1 - 0.42 * self.font);
        self.text(ink, &title, at, px, TextAnchor::Start);

        let label = cell.x.label(&cell.panel.x_label);
        let (px, label) = text::fit(&label, font, room);
        let y = corner.1 + size.1 + FOOT_GAP + 1.1 * self.tick + 0.95 * self.font;
        let half = text::width(&label, f64::from(px)) / 2.0;
        let x = (corner.0 + size.0 / 2.0).min(corner.0 + size.0 - half);
        self.text(ink, &label, (x, y), px, TextAnchor::Middle);

        let label = cell.y.label(&cell.panel.y_label);
        let (px, label) = text::fit(&label, font, size.1 + self.tick);
        let ticks = self.widest(&self.y_ticks(cell, size.1));
        ink.text(&Text {
            content: &label,
            x: corner.0 - TICK_GAP - ticks - 0.45 * self.font,
            y: corner.1 + size.1 / 2.0,
            size: px,
            anchor: TextAnchor::Middle,
            upright: true,
        });
    }

    fn tick_label(&self, ink: &mut Ink, tick: &Tick, at: (f64, f64), anchor: TextAnchor) {
        if let Some(label) = &tick.label {
            self.text(ink, label, at, tick_px(self.figure), anchor);
        }
    }

    fn text(&self, ink: &mut Ink, content: &str, at: (f64, f64), size: u32, anchor: TextAnchor) {
        if !content.is_empty() {
            ink.text(&Text { content, x: at.0, y: at.1, size, anchor, upright: false });
        }
    }
}

impl Cell<'_> {
    fn shapes(&self) -> Vec<Shape> {
        let shape = |s| Shape::new(s, &self.x, &self.y, self.frame);
        self.panel.series.iter().map(shape).collect()
    }

    /// Lengthens one of the axes so that both have the same scale.
    fn equalise(&mut self) {
        let panel = self.panel;
        if !panel.equal_aspect || (panel.x_scale, panel.y_scale) != (Scale::Linear, Scale::Linear) {
            return;
        }
        let per_px = |axis: &Axis, px: f64| (axis.hi - axis.lo) / px;
        let shift = 10f64.powi(self.x.exponent - self.y.exponent);
        let ratio = per_px(&self.x, self.frame.size.0) * shift / per_px(&self.y, self.frame.size.1);
        if ratio.is_finite() && ratio > 1.0 {
            let extra = ((ratio - 1.0) / 2.0).min(1e6);
            self.y.grow(extra, extra);
        } else if ratio > 0.0 {
            let extra = ((1.0 / ratio - 1.0) / 2.0).min(1e6);
            self.x.grow(extra, extra);
        }
    }
}

fn tick_px(figure: &Figure) -> u32 {
    figure.font_px.saturating_sub(1).max(1)
}

/// a, b, … z, and nothing beyond.
fn letter(index: usize) -> Option<char> {
    ('a'..='z').nth(index)
}
