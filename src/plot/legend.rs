//! Placement and drawing of the legend.

use kuva::render::render::TextAnchor;

use super::draw::{Ink, Pen, RADIUS};
use super::model::Style;
use super::shape::{Frame, Point, Shape, inside};
use super::text::{self, Text};

/// Length of the line shown for a series.
const SAMPLE: f64 = 17.0;
const GAP: f64 = 4.0;
/// Smallest size of the labels.
const LEAST: u32 = 7;
/// Distance between the legend and the axes.
const INSET: f64 = 4.0;
/// Distance between the legend and the data.
const MARGIN: f64 = RADIUS + 0.5;

/// Shares of the vertical extent that may be added to make room.
const SHARES: [f64; 9] = [0.0, 0.12, 0.2, 0.3, 0.4, 0.55, 0.75, 1.0, 1.4];
/// How many of them squeeze the data less than small labels bother the reader.
const FEW: usize = 5;

/// A series as the legend shows it.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) label: String,
    pub(super) pen: Pen,
    pub(super) style: Style,
}

/// The entries in columns, before they have a place.
#[derive(Clone, Debug)]
struct Block {
    /// Width of each column.
    columns: Vec<f64>,
    /// Height of a row.
    row: f64,
    size: u32,
    rows: usize,
}

impl Block {
    /// Entries row by row in `count` columns. A single column is made to fit in
    /// `room`; with several, it is for the caller to see if they do.
    fn new(entries: &[Entry], count: usize, room: f64, size: u32) -> Self {
        let mut columns = vec![0.0_f64; count.max(1)];
        for (i, entry) in entries.iter().enumerate() {
            let width = SAMPLE + 2.0 * GAP + text::width(&entry.label, f64::from(size));
            let column = &mut columns[i % count.max(1)];
            *column = column.max(width);
        }
        if let [only] = columns.as_mut_slice()
            && *only > room
        {
            if size > LEAST {
                return Self::new(entries, count, room, size - 1);
            }
            *only = room;
        }
        Self {
            columns,
            row: (f64::from(size) * 1.3).ceil(),
            size,
            rows: entries.len().div_ceil(count.max(1)),
        }
    }

    fn extent(&self) -> Point {
        (self.columns.iter().sum(), self.rows as f64 * self.row)
    }
}

/// A legend laid out in a frame.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    block: Block,
    /// Upper left corner.
    corner: Point,
    /// Shares of the vertical extent to add below and above the data.
    pub(super) extra: (f64, f64),
    hides_data: bool,
}

impl Placed {
    /// Finds the place that hides least of the `shapes` in a frame at `corner`,
    /// with room above or below the data as a last resort if the axis may `stretch`.
    pub(super) fn find(
        entries: &[Entry],
        shapes: &[Shape],
        frame: Frame,
        size: u32,
        stretch: bool,
    ) -> Option<Self> {
        let mut best: Option<(f64, Self)> = None;
        // Smaller labels are better than much squeezed data.
        let small = size.min(size.saturating_sub(2).max(LEAST));
        let (few, many) = SHARES.split_at(if stretch { FEW } else { 1 });
        let many = if stretch { many } else { &[] };
        let tries = few.iter().map(|s| (s, size));
        let tries = tries.chain(few.iter().chain(many).map(|s| (s, small)));
        for ((&share, size), at_bottom) in tries.flat_map(|t| [(t, false), (t, true)]) {
            for columns in 1..=entries.len() {
                let block = Block::new(entries, columns, frame.size.0 - 2.0 * INSET, size);
                let (width, height) = block.extent();
                let room = (frame.size.0 - width - 2.0 * INSET, frame.size.1 - height - 2.0 * INSET);
                let overflow = (-room.0).max(0.0) + (-room.1).max(0.0);
                for across in [1.0, 0.0, 0.5] {
                    let down = if at_bottom { 1.0 } else { 0.0 };
                    let corner = (
                        frame.corner.0 + INSET + room.0.max(0.0) * across,
                        frame.corner.1 + INSET + room.1.max(0.0) * down,
                    );
                    // Where the block would be among the shapes as they are now.
                    let fixed = frame.corner.1 + frame.size.1 * (1.0 - down);
                    let unsqueezed = |y: f64| fixed + (y - fixed) * (1.0 + share);
                    let top = unsqueezed(corner.1 - MARGIN);
                    let origin = (corner.0 - MARGIN, top);
                    let bottom = unsqueezed(corner.1 + height + MARGIN);
                    let area = (width + 2.0 * MARGIN, bottom - top);
                    let cost = covered(shapes, origin, area) + 1e4 * overflow;
                    let placed = || Self {
                        block: block.clone(),
                        corner,
                        extra: if at_bottom { (share, 0.0) } else { (0.0, share) },
                        hides_data: cost > 0.0,
                    };
                    if cost == 0.0 {
                        return Some(placed());
                    }
                    if share == 0.0 && best.as_ref().is_none_or(|b| cost < b.0) {
                        best = Some((cost, placed()));
                    }
                }
            }
        }
        best.map(|b| b.1)
    }

    /// Draws the legend.
    pub(super) fn draw(&self, entries: &[Entry], ink: &mut Ink) {
        let Block { columns, row, size, .. } = &self.block;
        if self.hides_data {
            ink.veil(self.corner, self.block.extent());
        }
        for (i, entry) in entries.iter().enumerate() {
            let (down, across) = (i / columns.len(), i % columns.len());
            let before: f64 = columns[..across].iter().sum();
            let x = self.corner.0 + before;
            let y = self.corner.1 + (down as f64 + 0.5) * row;
            let line = match entry.style {
                Style::Markers => Vec::new(),
                _ => vec![vec![(x + 1.0, y), (x + SAMPLE, y)]],
            };
            ink.dashed(&line, entry.pen.rgb, entry.pen.width, entry.pen.dash);
            let mark = match entry.style {
                Style::Line | Style::Steps => Vec::new(),
                Style::Stems => vec![(x + SAMPLE - RADIUS, y)],
                Style::Markers | Style::LineAndMarkers => vec![(x + SAMPLE / 2.0, y)],
            };
            ink.marks(&mark, &entry.pen);
            let room = columns[across] - SAMPLE - 2.0 * GAP;
            let (px, label) = text::fit(&entry.label, *size, room + 0.01);
            ink.text(&Text {
                content: &label,
                x: x + SAMPLE + GAP,
                y: y + 0.36 * f64::from(*size),
                size: px,
                anchor: TextAnchor::Start,
                upright: false,
            });
        }
    }
}

/// Length of line and number of markers, weighted, in a rectangle.
fn covered(shapes: &[Shape], origin: Point, size: Point) -> f64 {
    let length = |line: &Vec<Point>| -> f64 {
        let part = |pair: &[Point]| {
            let (a, b) = (pair[0], pair[1]);
            let share = inside(a, b, origin, size).map_or(0.0, |(from, to)| to - from);
            share * (b.0 - a.0).hypot(b.1 - a.1)
        };
        line.windows(2).map(part).sum()
    };
    let within = |m: &&Point| inside(**m, **m, origin, size).is_some();
    let cost = |shape: &Shape| {
        let lines: f64 = shape.lines.iter().map(length).sum();
        lines + 6.0 * shape.marks.iter().filter(within).count() as f64
    };
    shapes.iter().map(cost).sum()
}
