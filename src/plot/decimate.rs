//! Reduction of long series to what a figure can show.

/// Series up to this length are drawn point by point.
const SHORT: usize = 512;

/// Upper bound on the points kept from one series, whatever its shape.
const MAX_POINTS: usize = 12_000;

/// Splits a curve at its non-finite points and thins each piece.
///
/// The drawing goes from abscissa 0 to `width` and is cut into `columns` columns,
/// with one more on either side for what lies out of it. Every run of consecutive
/// points in the same column is replaced by its first, lowest, highest and last
/// point, so spikes of a single sample survive. The first and last point of each
/// piece are kept, short curves (≤ 512 points) are returned unchanged, and the
/// result is bounded even for curves that sweep back and forth in `x`.
///
/// ```
/// let y = (0..1_000_000).map(|i| if i == 700_123 { 5.0 } else { 0.0 });
/// let curve = y.enumerate().map(|(i, y)| (i as f64 * 1e-6, y));
/// let pieces = nonsmooth::plot::decimate(curve, 1.0, 100);
/// assert_eq!(pieces.len(), 1);
/// assert!(pieces[0].len() < 500);
/// assert!(pieces[0].iter().any(|p| p.1 == 5.0));
/// ```
pub fn decimate<I>(points: I, width: f64, columns: usize) -> Vec<Vec<(f64, f64)>>
where
    I: IntoIterator<Item = (f64, f64)>,
{
    let mut pieces = Pieces::new(width, columns);
    for point in points {
        pieces.push(point);
    }
    pieces.finish()
}

/// Accumulates the pieces of one curve in a single pass.
struct Pieces {
    per_unit: f64,
    columns: f64,
    done: Vec<Vec<(f64, f64)>>,
    /// The piece being read, verbatim, until it outgrows [`SHORT`].
    head: Vec<(f64, f64)>,
    thinned: Option<Vec<(f64, f64)>>,
    run: Option<Run>,
}

impl Pieces {
    fn new(width: f64, columns: usize) -> Self {
        let columns = columns.max(1) as f64;
        Self {
            per_unit: columns / width,
            columns,
            done: Vec::new(),
            head: Vec::new(),
            thinned: None,
            run: None,
        }
    }

    fn push(&mut self, point: (f64, f64)) {
        if !(point.0.is_finite() && point.1.is_finite()) {
            self.break_piece();
        } else if self.thinned.is_some() {
            self.thin(point);
        } else {
            self.head.push(point);
            if self.head.len() > SHORT {
                self.thinned = Some(Vec::new());
                for kept in std::mem::take(&mut self.head) {
                    self.thin(kept);
                }
            }
        }
    }

    fn thin(&mut self, point: (f64, f64)) {
        let column = (point.0 * self.per_unit).floor().clamp(-1.0, self.columns);
        match &mut self.run {
            Some(run) if run.column == column || column.is_nan() => run.add(point),
            slot => {
                if let (Some(run), Some(out)) = (slot.take(), self.thinned.as_mut()) {
                    run.flush(out);
                }
                *slot = Some(Run::new(column, point));
            }
        }
    }

    fn break_piece(&mut self) {
        let mut piece = std::mem::take(&mut self.head);
        if let Some(mut out) = self.thinned.take() {
            if let Some(run) = self.run.take() {
                run.flush(&mut out);
            }
            piece = out;
        }
        if !piece.is_empty() {
            self.done.push(piece);
        }
    }

    fn finish(mut self) -> Vec<Vec<(f64, f64)>> {
        self.break_piece();
        let total: usize = self.done.iter().map(Vec::len).sum();
        if total <= MAX_POINTS {
            return self.done;
        }
        // Columns could not bound the curve: fall back to extremes of equal
        // shares of the path, and to a regular choice among too many pieces.
        let stride = self.done.len().div_ceil(MAX_POINTS / 4).max(1);
        let share = total.div_ceil(stride).div_ceil(MAX_POINTS / 6).max(1);
        let kept = self.done.into_iter().step_by(stride);
        kept.map(|piece| shares(&piece, share)).collect()
    }
}

/// Points of one column: extremes with their rank, to restore their order.
struct Run {
    column: f64,
    count: usize,
    first: (f64, f64),
    last: (f64, f64),
    low: (usize, (f64, f64)),
    high: (usize, (f64, f64)),
}

impl Run {
    fn new(column: f64, point: (f64, f64)) -> Self {
        Self { column, count: 1, first: point, last: point, low: (0, point), high: (0, point) }
    }

    fn add(&mut self, point: (f64, f64)) {
        if point.1 < self.low.1.1 {
            self.low = (self.count, point);
        }
        if point.1 > self.high.1.1 {
            self.high = (self.count, point);
        }
        self.last = point;
        self.count += 1;
    }

    fn flush(self, out: &mut Vec<(f64, f64)>) {
        let end = self.count - 1;
        let mut kept = [(0, self.first), self.low, self.high, (end, self.last)];
        kept.sort_by_key(|k| k.0);
        let mut previous = None;
        for (rank, point) in kept {
            if previous != Some(rank) {
                out.push(point);
            }
            previous = Some(rank);
        }
    }
}

/// Extremes in both directions of every `share` consecutive points.
fn shares(piece: &[(f64, f64)], share: usize) -> Vec<(f64, f64)> {
    let mut out = Vec::with_capacity(piece.len().min(MAX_POINTS));
    for chunk in piece.chunks(share) {
        let pick = |better: fn(&(f64, f64), &(f64, f64)) -> bool| {
            let best = |best: usize, i: usize| {
                if better(&chunk[i], &chunk[best]) { i } else { best }
            };
            (0..chunk.len()).fold(0, best)
        };
        let mut kept = [
            0,
            pick(|a, b| a.0 < b.0),
            pick(|a, b| a.0 > b.0),
            pick(|a, b| a.1 < b.1),
            pick(|a, b| a.1 > b.1),
            chunk.len() - 1,
        ];
        kept.sort_unstable();
        let mut previous = None;
        for i in kept {
            if previous != Some(i) {
                out.push(chunk[i]);
            }
            previous = Some(i);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(n: usize) -> Vec<(f64, f64)> {
        let point = |i: usize| (i as f64 * 200.0 / n as f64, (i as f64 * 0.37).sin());
        (0..n).map(point).collect()
    }

    #[test]
    fn short_curves_are_unchanged() {
        let curve = wave(SHORT);
        assert_eq!(decimate(curve.iter().copied(), 200.0, 4), vec![curve]);
    }

    #[test]
    fn long_curves_keep_extremes_and_ends() {
        let mut curve = wave(200_000);
        curve[123_457].1 = 9.0;
        curve[123_459].1 = -8.0;
        let pieces = decimate(curve.iter().copied(), 200.0, 400);
        let piece = &pieces[0];
        assert!(piece.len() <= 4 * 402, "{}", piece.len());
        assert_eq!(piece.first(), curve.first());
        assert_eq!(piece.last(), curve.last());
        assert!(piece.contains(&curve[123_457]));
        assert!(piece.contains(&curve[123_459]));
        assert!(piece.windows(2).all(|w| w[0].0 <= w[1].0));
    }

    #[test]
    fn non_finite_points_break_the_curve() {
        let curve =
            [(f64::NAN, 0.0), (0.0, 1.0), (1.0, 1.0), (2.0, f64::INFINITY), (3.0, 1.0), (4.0, f64::NAN)];
        let expected = vec![vec![(0.0, 1.0), (1.0, 1.0)], vec![(3.0, 1.0)]];
        assert_eq!(decimate(curve, 10.0, 10), expected);
    }

    #[test]
    fn loops_and_fragments_are_bounded() {
        let angle = |i: usize| i as f64 * 0.01;
        let spiral = (0..2_000_000).map(|i| (50.0 * angle(i).cos(), 50.0 * angle(i).sin()));
        let total: usize = decimate(spiral, 100.0, 200).iter().map(Vec::len).sum();
        assert!(total <= MAX_POINTS, "{total}");

        let holes = (0..300_000).map(|i| (if i % 3 == 0 { f64::NAN } else { 1.0 }, i as f64));
        let total: usize = decimate(holes, 100.0, 200).iter().map(Vec::len).sum();
        assert!(total <= MAX_POINTS, "{total}");
    }

    #[test]
    fn a_senseless_width_is_harmless() {
        for width in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(!decimate(wave(5_000), width, 0).is_empty());
        }
    }
}
