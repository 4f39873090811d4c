//! Drawing of lines, markers and text with the library's primitives.

use std::fmt::Write as _;

use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive};

use super::model::{Dash, MARKERS, Marker, Series};
use super::shape::Point;
use super::text::Text;

/// A colour.
pub(super) type Rgb = (u8, u8, u8);

/// Okabe and Ito's colours, the most readable on white first.
const PALETTE: [Rgb; 8] = [
    (0, 114, 178),
    (213, 94, 0),
    (0, 158, 115),
    (0, 0, 0),
    (204, 121, 167),
    (230, 159, 0),
    (86, 180, 233),
    (240, 228, 66),
];

const DASHES: [Dash; 5] = [Dash::Solid, Dash::Dashed, Dash::Dotted, Dash::DashDot, Dash::LongDash];

/// Half-size of a marker.
pub(super) const RADIUS: f64 = 2.3;

/// Colour, dashes, marker and width of a series.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pen {
    pub(super) rgb: Rgb,
    pub(super) dash: Dash,
    pub(super) marker: Marker,
    pub(super) width: f64,
}

impl Pen {
    /// The pen of the series of the given rank.
    pub(super) fn new(series: &Series, rank: usize) -> Self {
        Self {
            rgb: PALETTE[series.color.unwrap_or(rank) % PALETTE.len()],
            dash: series.dash.unwrap_or(DASHES[rank % DASHES.len()]),
            marker: series.marker.unwrap_or(MARKERS[rank % MARKERS.len()]),
            width: if series.width.is_finite() { series.width.clamp(0.1, 20.0) } else { 1.0 },
        }
    }
}

/// Collects primitives, in the form that suits the rasteriser or SVG.
#[derive(Debug, Default)]
pub(super) struct Ink {
    pub(super) raster: bool,
    pub(super) out: Vec<Primitive>,
}

impl Ink {
    pub(super) fn text(&mut self, text: &Text) {
        if self.raster {
            text.raster(&mut self.out);
        } else {
            text.vector(&mut self.out);
        }
    }

    /// Fades what is under a rectangle.
    pub(super) fn veil(&mut self, corner: Point, size: Point) {
        self.out.push(Primitive::Rect {
            x: corner.0,
            y: corner.1,
            width: size.0,
            height: size.1,
            fill: Color::Rgb(255, 255, 255),
            stroke: None,
            stroke_width: None,
            opacity: Some(0.8),
        });
    }

    /// Draws unbroken lines.
    pub(super) fn lines(&mut self, lines: &[Vec<Point>], rgb: Rgb, width: f64) {
        self.dashed(lines, rgb, width, Dash::Solid);
    }

    /// Draws lines; a line of a single point is a dot.
    pub(super) fn dashed(&mut self, lines: &[Vec<Point>], rgb: Rgb, width: f64, dash: Dash) {
        let pattern = pattern(dash, width);
        if self.raster {
            // The rasteriser restarts the dashes at every point and does not
            // scale them, so it is given the dashes one by one.
            let pieces = lines.iter().flat_map(|line| dashes(line, &pattern));
            let stroke = |points| Primitive::PolyLine {
                points,
                stroke: Color::Rgb(rgb.0, rgb.1, rgb.2),
                stroke_width: width,
                stroke_dasharray: None,
            };
            self.out.extend(pieces.map(stroke));
            return;
        }
        let mut d = String::new();
        for line in lines {
            let again = (line.len() == 1).then(|| line[0]);
            for (i, p) in line.iter().copied().chain(again).enumerate() {
                let _ = write!(d, "{}{}", if i == 0 { 'M' } else { 'L' }, coordinates(p));
            }
        }
        let array: Vec<String> = pattern.iter().map(|l| format!("{l:.2}")).collect();
        self.path(d, None, rgb, width, (array.len() > 1).then(|| array.join(" ")));
    }

    /// Draws markers.
    pub(super) fn marks(&mut self, marks: &[Point], pen: &Pen) {
        let open = matches!(pen.marker, Marker::Square | Marker::Diamond | Marker::Circle);
        let cross = pen.marker == Marker::Cross;
        let width = if open || cross { 0.9 } else { 0.3 };
        let fill = match (open, cross) {
            (true, _) => Some((255, 255, 255)),
            (false, true) => None,
            (false, false) => Some(pen.rgb),
        };
        let outlines: Vec<Vec<Point>> = marks.iter().flat_map(|m| outline(*m, pen.marker)).collect();
        if cross {
            self.lines(&outlines, pen.rgb, width);
            return;
        }
        for line in &outlines {
            let mut d = String::new();
            for (i, p) in line.iter().enumerate() {
                let _ = write!(d, "{}{}", if i == 0 { 'M' } else { 'L' }, coordinates(*p));
            }
            d.push('Z');
            self.path(d, fill, pen.rgb, width, None);
        }
    }

    fn path(&mut self, d: String, fill: Option<Rgb>, rgb: Rgb, width: f64, dasharray: Option<String>) {
        if d.is_empty() {
            return;
        }
        self.out.push(Primitive::Path(Box::new(PathData {
            d,
            fill: fill.map(|(r, g, b)| Color::Rgb(r, g, b)),
            stroke: Color::Rgb(rgb.0, rgb.1, rgb.2),
            stroke_width: width,
            opacity: None,
            stroke_dasharray: dasharray,
        })));
    }
}

/// Lengths of dashes and gaps; line ends are round and add `width` to a dash.
fn pattern(dash: Dash, width: f64) -> Vec<f64> {
    let unit: &[f64] = match dash {
        Dash::Solid => &[],
        Dash::Dashed => &[3.0, 2.6],
        Dash::Dotted => &[0.02, 2.0],
        Dash::DashDot => &[4.0, 2.2, 0.02, 2.2],
        Dash::LongDash => &[7.0, 2.6],
    };
    unit.iter().map(|u| u * width.max(0.6)).collect()
}

/// Cuts a line into its dashes.
fn dashes(line: &[Point], pattern: &[f64]) -> Vec<Vec<Point>> {
    let Some(&first) = line.first() else {
        return Vec::new();
    };
    if line.len() == 1 {
        return vec![vec![first, first]];
    }
    if pattern.len() < 2 {
        return vec![line.to_vec()];
    }
    let mut out = vec![vec![first]];
    let (mut index, mut left) = (0, pattern[0]);
    for pair in line.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let length = (b.0 - a.0).hypot(b.1 - a.1);
        let mut done = 0.0;
        while length - done > left {
            done += left;
            index = (index + 1) % pattern.len();
            left = pattern[index];
            let s = done / length;
            let at = (a.0 + s * (b.0 - a.0), a.1 + s * (b.1 - a.1));
            match out.last_mut() {
                Some(dash) if index % 2 == 1 => dash.push(at),
                _ => out.push(vec![at]),
            }
        }
        left -= length - done;
        if let (Some(dash), 0) = (out.last_mut(), index % 2) {
            dash.push(b);
        }
    }
    out
}

/// The lines of a marker.
fn outline((x, y): Point, marker: Marker) -> Vec<Vec<Point>> {
    let regular = |n: u32, radius: f64, turn: f64| {
        let angle = |i: u32| (f64::from(i) / f64::from(n) + turn) * std::f64::consts::TAU;
        let corner = |i: u32| (x + radius * angle(i).sin(), y - radius * angle(i).cos());
        (0..n).map(corner).collect::<Vec<_>>()
    };
    match marker {
        Marker::Disc => vec![regular(16, 0.95 * RADIUS, 0.0)],
        Marker::Circle => vec![regular(16, RADIUS, 0.0)],
        Marker::Square => vec![regular(4, 1.2 * RADIUS, 0.125)],
        Marker::Triangle => vec![regular(3, 1.25 * RADIUS, 0.0)],
        Marker::Diamond => vec![regular(4, 1.3 * RADIUS, 0.0)],
        Marker::Cross => {
            let c = regular(4, 1.3 * RADIUS, 0.125);
            vec![vec![c[0], c[2]], vec![c[1], c[3]]]
        }
    }
}

/// Coordinates to a hundredth of a pixel, without needless digits.
fn coordinates((x, y): Point) -> String {
    let short = |v: f64| {
        let text = format!("{v:.2}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        if text == "-0" { "0".to_owned() } else { text.to_owned() }
    };
    format!("{} {}", short(x), short(y))
}
