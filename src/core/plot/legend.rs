//! A place for the legend where it hides no data.

use super::shape::{Point, Shape};

/// Length of the line shown for a series.
pub(super) const SAMPLE: f64 = 17.0;
/// Distance from the axes and the data, and between line and label.
pub(super) const GAP: f64 = 4.0;
/// Shares of the height that may be added to make room, and sizes of labels: small ones before much squeezed data.
const TRIES: [(f64, u32); 9] =
    [(0.0, 10), (0.12, 10), (0.2, 10), (0.12, 8), (0.3, 10), (0.3, 8), (0.5, 8), (0.8, 8), (1.4, 8)];

/// Entries row by row in columns.
#[derive(Clone, Debug)]
pub(super) struct Legend {
    columns: Vec<f64>,
    /// Size of the labels.
    pub(super) font: u32,
    /// Upper left corner.
    corner: Point,
    /// Shares of the height to add below and above the data.
    pub(super) extra: (f64, f64),
}

impl Legend {
    /// The first place that covers none of the `shapes` in axes of a `size`, or else the one that covers least; only if
    /// the axis may `extend`, the data may give way.
    pub(super) fn find(labels: &[&str], shapes: &[Shape], size: Point, extend: bool) -> Option<Self> {
        let dots: Vec<Point> = shapes.iter().flat_map(dots).collect();
        let tries = TRIES.iter().filter(|(share, _)| extend || *share == 0.0);
        let places = tries.flat_map(|&(share, font)| {
            let counts =
                [false, true].into_iter().flat_map(move |below| (1..=labels.len()).map(move |n| (n, below)));
            counts.flat_map(move |(n, below)| [1.0, 0.0, 0.5].map(|side| (share, font, n, below, side)))
        });
        let mut best = (f64::INFINITY, None);
        for (share, font, count, below, side) in places {
            let mut columns = vec![0.0_f64; count];
            for (i, label) in labels.iter().enumerate() {
                columns[i % count] = columns[i % count].max(SAMPLE + 2.4 * GAP + width(label, font));
            }
            let block = (columns.iter().sum::<f64>(), labels.len().div_ceil(count) as f64 * row(font));
            let room = (size.0 - block.0 - 2.0 * GAP, size.1 - block.1 - 2.0 * GAP);
            let overflow = (-room.0).max(0.0) + (-room.1).max(0.0);
            let down = if below { room.1.max(0.0) } else { 0.0 };
            let corner = (GAP + room.0.max(0.0) * side, size.1 - GAP - down);
            let covered = dots.iter().filter(|dot| {
                // Where the dot will be when the data have given way.
                let level = (dot.1 + if below { share * size.1 } else { 0.0 }) / (1.0 + share);
                (corner.0 - GAP..corner.0 + block.0).contains(&dot.0)
                    && (corner.1 - block.1 - GAP..corner.1 + GAP).contains(&level)
            });
            let cost = covered.count() as f64 + 1e4 * overflow;
            if cost < best.0 {
                let extra = if below { (share, 0.0) } else { (0.0, share) };
                best = (cost, Some(Self { columns, font, corner, extra }));
            }
            if cost == 0.0 {
                break;
            }
        }
        best.1
    }

    /// Where the line of an entry begins.
    pub(super) fn place(&self, entry: usize) -> Point {
        let (down, across) = (entry / self.columns.len(), entry % self.columns.len());
        let left = self.corner.0 + self.columns[..across].iter().sum::<f64>();
        (left, self.corner.1 - (down as f64 + 0.5) * row(self.font))
    }
}

/// Height of a row.
fn row(font: u32) -> f64 {
    1.35 * f64::from(font)
}

/// Width of a label, rather too large.
pub(super) fn width(label: &str, font: u32) -> f64 {
    let letter = |c: char| match c {
        '$' | '_' | '^' | '{' | '}' => 0.0,
        ' ' | '.' | ',' | ':' | '(' | ')' | '/' | 'i' | 'j' | 'l' | 't' | 'r' | '-' => 0.34,
        'm' | 'w' => 0.9,
        _ => 0.6,
    };
    f64::from(font) * label.chars().map(letter).sum::<f64>()
}

/// The marks, and points along the lines close enough to find what covers them.
fn dots(shape: &Shape) -> Vec<Point> {
    let between = |pair: &[Point]| {
        let (a, b) = (pair[0], pair[1]);
        let parts = ((b.0 - a.0).hypot(b.1 - a.1) / 3.0).ceil().max(1.0) as usize;
        let at = move |s: f64| (a.0 + s * (b.0 - a.0), a.1 + s * (b.1 - a.1));
        (0..=parts).map(move |i| at(i as f64 / parts as f64))
    };
    let lines = shape.lines.iter().flat_map(|line| line.windows(2).flat_map(between));
    lines.chain(shape.marks.iter().copied()).collect()
}
