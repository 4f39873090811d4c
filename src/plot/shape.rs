//! Geometry of the series.

use super::axis::Axis;
use super::decimate::decimate;
use super::draw::RADIUS;
use super::model::{Series, Style};

/// A point in pixels.
pub(super) type Point = (f64, f64);

/// The rectangle of the axes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Frame {
    /// Upper left corner.
    pub(super) corner: Point,
    pub(super) size: Point,
}

/// Most markers drawn on a joined series; the others would only blot the line.
const MOST_MARKS: usize = 60;

/// Columns per pixel kept by decimation.
const COLUMNS_PER_PX: f64 = 2.0;

/// Lines and markers of a series in pixels.
#[derive(Clone, Debug, Default)]
pub(super) struct Shape {
    pub(super) lines: Vec<Vec<Point>>,
    pub(super) marks: Vec<Point>,
}

impl Shape {
    /// The part of a series inside the axes.
    pub(super) fn new(series: &Series, x: &Axis, y: &Axis, frame: Frame) -> Self {
        let (width, height) = frame.size;
        let stems = series.style == Style::Stems;
        let place = |(a, b): Point| (x.place(a) * width, (1.0 - y.place(b)) * height);
        // A zero percussion is the absence of one.
        let drawn = series.points().filter(|p| !stems || p.1 != 0.0).map(place);
        let pieces = decimate(drawn, width, (width * COLUMNS_PER_PX) as usize);
        let all = || pieces.iter().flatten().copied();
        let mut shape = Self::default();
        match series.style {
            Style::Markers => shape.marks = sparse(all(), 0.5),
            Style::Line => shape.lines = pieces,
            Style::LineAndMarkers => {
                shape.marks = all().collect();
                if shape.marks.len() > MOST_MARKS {
                    shape.marks = sparse(all(), 6.0 * RADIUS);
                }
                shape.lines = pieces;
            }
            Style::Steps => shape.lines = pieces.iter().map(|p| stairs(p)).collect(),
            Style::Stems => {
                let base = (1.0 - y.baseline()) * height;
                shape.lines = all().map(|p| vec![(p.0, base), p]).collect();
                if shape.lines.len() <= MOST_MARKS {
                    shape.marks = all().collect();
                }
            }
        }
        let slack = 0.01;
        let inside =
            |p: &Point| (-slack..=width + slack).contains(&p.0) && (-slack..=height + slack).contains(&p.1);
        if !shape.lines.iter().flatten().all(inside) {
            shape.lines = shape.lines.iter().flat_map(|l| clip(l, frame.size)).collect();
        }
        shape.marks.retain(inside);
        let points = shape.lines.iter_mut().flatten();
        for p in points.chain(shape.marks.iter_mut()) {
            *p = (p.0 + frame.corner.0, p.1 + frame.corner.1);
        }
        shape
    }
}

/// Drops points closer than `spacing` to the last one kept.
fn sparse(points: impl Iterator<Item = Point>, spacing: f64) -> Vec<Point> {
    let mut kept: Vec<Point> = Vec::new();
    for p in points {
        if kept.last().is_none_or(|q| (p.0 - q.0).hypot(p.1 - q.1) >= spacing) {
            kept.push(p);
        }
    }
    kept
}

/// The piecewise constant curve through the points.
fn stairs(points: &[Point]) -> Vec<Point> {
    let mut out: Vec<Point> = Vec::with_capacity(2 * points.len());
    for &p in points {
        if let Some(&q) = out.last() {
            out.push((p.0, q.1));
        }
        out.push(p);
    }
    out
}

/// The part of a segment inside a rectangle from the origin to `size`
/// (Liang and Barsky), as fractions of the segment.
pub(super) fn inside(a: Point, b: Point, origin: Point, size: Point) -> Option<(f64, f64)> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    let sides = [
        (a.0 - b.0, a.0 - origin.0),
        (b.0 - a.0, origin.0 + size.0 - a.0),
        (a.1 - b.1, a.1 - origin.1),
        (b.1 - a.1, origin.1 + size.1 - a.1),
    ];
    for (rate, room) in sides {
        if rate == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if rate < 0.0 {
            from = from.max(room / rate);
        } else {
            to = to.min(room / rate);
        }
    }
    (from <= to).then_some((from, to))
}

/// The pieces of a line inside a rectangle from the origin to `size`.
fn clip(line: &[Point], size: Point) -> Vec<Vec<Point>> {
    let mut out: Vec<Vec<Point>> = Vec::new();
    let mut open = false;
    for pair in line.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let Some((from, to)) = inside(a, b, (0.0, 0.0), size) else {
            open = false;
            continue;
        };
        let at = |s: f64| (a.0 + s * (b.0 - a.0), a.1 + s * (b.1 - a.1));
        match out.last_mut() {
            Some(piece) if open && from == 0.0 => piece.push(at(to)),
            _ => out.push(vec![at(from), at(to)]),
        }
        open = to == 1.0;
    }
    out
}
