//! Lines and markers of a series in pixels from the lower left corner of the axes.

use super::axis::Axis;
use super::model::{Series, Style};

/// A point in pixels.
pub(super) type Point = (f64, f64);

/// Most pieces of a broken curve.
const PIECES: usize = 20_000;
/// Most markers drawn on a curve, and most bars with a head.
const MARKS: usize = 60;

/// Lines and markers.
#[derive(Clone, Debug, Default)]
pub(super) struct Shape {
    pub(super) lines: Vec<Vec<Point>>,
    pub(super) marks: Vec<Point>,
}

impl Shape {
    /// The series in axes of a `size`, thinned to what they can show; what lies out of them is not far out.
    pub(super) fn new(series: &Series, x: &Axis, y: &Axis, size: Point) -> Self {
        let at = |axis: &Axis, number: f64, length: f64| axis.fraction(number).clamp(-9.0, 10.0) * length;
        // A percussion of zero is the absence of one.
        let drawn = series.points().filter(|p| series.style != Style::Stems || p.1 != 0.0);
        let points: Vec<Point> =
            drawn.map(|(a, b)| (at(x, x.place(a), size.0), at(y, y.place(b), size.1))).collect();
        let pieces =
            points.split(|p| !(p.0.is_finite() && p.1.is_finite())).filter(|piece| !piece.is_empty());
        let stride = pieces.clone().count().div_ceil(PIECES).max(1);
        let lines: Vec<Vec<Point>> = pieces.step_by(stride).map(|piece| thin(piece, 2.0 * size.0)).collect();
        let all: Vec<Point> = lines.concat();
        match series.style {
            Style::Line => Self { lines, marks: Vec::new() },
            Style::Steps => {
                Self { lines: lines.iter().map(|line| stairs(line)).collect(), marks: Vec::new() }
            }
            Style::Markers => Self { lines: Vec::new(), marks: all },
            Style::LineAndMarkers => {
                Self { lines, marks: all.iter().copied().step_by(all.len().div_ceil(MARKS).max(1)).collect() }
            }
            Style::Stems => {
                // Bars begin at zero, or at the edge of axes without zero.
                let base = if y.log { 0.0 } else { y.fraction(0.0).clamp(0.0, 1.0) * size.1 };
                let lines = all.iter().map(|p| vec![(p.0, base), *p]).collect();
                Self { lines, marks: if all.len() <= MARKS { all } else { Vec::new() } }
            }
        }
    }
}

/// The first, lowest, highest and last point of each of some `shares` of a long curve, so that no spike is lost.
fn thin(curve: &[Point], shares: f64) -> Vec<Point> {
    let share = curve.len().div_ceil(shares as usize + 1);
    let share = if share > 4 { share } else { 1 };
    let extremes = |run: &[Point]| {
        let by_height = |a: &usize, b: &usize| run[*a].1.total_cmp(&run[*b].1);
        let (low, high) = ((0..run.len()).min_by(by_height), (0..run.len()).max_by(by_height));
        let mut kept = vec![0, low.unwrap_or(0), high.unwrap_or(0), run.len() - 1];
        kept.sort_unstable();
        kept.dedup();
        kept.into_iter().map(|i| run[i]).collect::<Vec<Point>>()
    };
    curve.chunks(share).flat_map(extremes).collect()
}

/// The piecewise constant curve through the points.
fn stairs(points: &[Point]) -> Vec<Point> {
    let corners = points.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    corners.chain(points.last().copied()).collect()
}
