//! Convex parts of simple polygons: ears are cut off (Meisters 1975), and parts joined again while they stay convex (Hertel &
//! Mehlhorn 1983), which leaves at most four times as many as the fewest.

use super::PolygonSpec;
use crate::system::SystemError;

/// Most vertices of an outline.
const MOST: usize = 1024;

/// A turn of this share of the squared extent is none.
const STRAIGHT: f64 = 1e-12;

type Point = [f64; 2];

/// Twice the area of the triangle (a, b, c), positive where it turns left.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether the segments ab and cd have a point in common.
fn meet([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let within =
        |p: Point, q: Point, x: Point| (0..2).all(|i| p[i].min(q[i]) <= x[i] && x[i] <= p[i].max(q[i]));
    let [u, v, w, x] = [turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b)];
    (u * v < 0.0 && w * x < 0.0)
        || (u == 0.0 && within(a, b, c))
        || (v == 0.0 && within(a, b, d))
        || (w == 0.0 && within(c, d, a))
        || (x == 0.0 && within(c, d, b))
}

impl PolygonSpec {
    /// The polygons it stands for, each with its label: itself, or its convex parts.
    ///
    /// # Errors
    /// [`SystemError::Polygon`] for an outline that cannot be decomposed.
    pub(super) fn parts(&self, label: &str) -> Result<Vec<(String, Vec<Point>)>, SystemError> {
        if !self.decompose {
            return Ok(vec![(label.into(), self.vertices.clone())]);
        }
        let parts = convex_parts(label, &self.vertices)?;
        let several = parts.len() > 1;
        let labelled = parts.into_iter().enumerate().map(|(number, part)| {
            (if several { format!("{label}.{}", number + 1) } else { label.into() }, part)
        });
        Ok(labelled.collect())
    }
}

/// The strictly convex, counterclockwise parts of the simple polygon `vertices`, which may run either way round.
///
/// # Errors
/// [`SystemError::Polygon`]: a vertex that is not finite, an outline that crosses itself, none that encloses anything.
fn convex_parts(label: &str, vertices: &[Point]) -> Result<Vec<Vec<Point>>, SystemError> {
    let error = |vertex, reason| Err(SystemError::Polygon { label: label.into(), vertex, reason });
    let n = vertices.len();
    if !(3..=MOST).contains(&n) {
        return error(n, "the number of vertices must be between 3 and 1024");
    }
    if let Some(vertex) = vertices.iter().position(|x| !x.iter().all(|x| x.is_finite())) {
        return error(vertex, "it is not finite");
    }
    let edge = |i: usize| [vertices[i], vertices[(i + 1) % n]];
    for i in 0..n {
        for j in i + 2..n {
            if (j + 1) % n != i && meet(edge(i), edge(j)) {
                return error(i, "the outline crosses or touches itself behind it");
            }
        }
    }
    let extent = |axis: usize| {
        let along = || vertices.iter().map(|x| x[axis]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    };
    let straight = STRAIGHT * extent(0).max(extent(1)).powi(2);
    let area: f64 = (1..n - 1).map(|i| turn(vertices[0], vertices[i], vertices[i + 1])).sum();
    if !(area.abs() > straight) {
        return error(0, "the outline encloses nothing");
    }
    let mut outline: Vec<usize> = (0..n).collect();
    if area < 0.0 {
        outline.reverse();
    }
    let at = |i: usize| vertices[i];
    let mut i = 0;
    while i < outline.len() && outline.len() > 3 {
        let [before, after] = [outline.len() - 1, 1].map(|step| outline[(i + step) % outline.len()]);
        if turn(at(before), at(outline[i]), at(after)).abs() <= straight {
            outline.remove(i);
        } else {
            i += 1;
        }
    }
    let mut parts = Vec::new();
    while outline.len() > 3 {
        let n = outline.len();
        let is_ear = |i: usize| {
            let [a, b, c] = [(i + n - 1) % n, i, (i + 1) % n].map(|k| at(outline[k]));
            let inside = |x: Point| turn(a, b, x) >= 0.0 && turn(b, c, x) >= 0.0 && turn(c, a, x) >= 0.0;
            let others = (2..n - 1).map(|k| at(outline[(i + k) % n]));
            turn(a, b, c) > straight && !others.into_iter().any(inside)
        };
        let Some(ear) = (0..n).find(|&i| is_ear(i)) else {
            return error(outline[0], "the outline is too thin there to be split");
        };
        parts.push(vec![outline[(ear + n - 1) % n], outline[ear], outline[(ear + 1) % n]]);
        outline.remove(ear);
    }
    parts.push(outline);
    while join_two(&mut parts, vertices, straight) {}
    Ok(parts.into_iter().map(|part| part.into_iter().map(at).collect()).collect())
}

/// Joins two parts across a common edge where the whole is strictly convex.
fn join_two(parts: &mut Vec<Vec<usize>>, vertices: &[Point], straight: f64) -> bool {
    for first in 0..parts.len() {
        for second in first + 1..parts.len() {
            let (a, b) = (&parts[first], &parts[second]);
            for i in 0..a.len() {
                let (start, end) = (a[i], a[(i + 1) % a.len()]);
                let Some(j) = (0..b.len()).find(|&j| b[j] == end && b[(j + 1) % b.len()] == start) else {
                    continue;
                };
                // Round a from the end of the common edge to its start, and round b back.
                let mut whole: Vec<usize> = (1..=a.len()).map(|k| a[(i + k) % a.len()]).collect();
                whole.extend((2..b.len()).map(|k| b[(j + k) % b.len()]));
                let n = whole.len();
                let convex = (0..n).all(|k| {
                    let [p, q, r] = [k, (k + 1) % n, (k + 2) % n].map(|k| vertices[whole[k]]);
                    turn(p, q, r) > straight
                });
                if convex {
                    parts[first] = whole;
                    parts.swap_remove(second);
                    return true;
                }
            }
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::{Point, convex_parts, turn};

    fn area(outline: &[Point]) -> f64 {
        (1..outline.len() - 1).map(|i| 0.5 * turn(outline[0], outline[i], outline[i + 1])).sum()
    }

    #[test]
    fn parts_are_convex_and_have_the_area_of_the_whole() {
        let star: Vec<Point> = (0..10)
            .map(|i| {
                let (r, angle) =
                    (if i % 2 == 0 { 1.0 } else { 0.4 }, std::f64::consts::TAU * f64::from(i) / 10.0);
                [r * f64::cos(angle), r * f64::sin(angle)]
            })
            .collect();
        let square = vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let ell = vec![[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        let comb = vec![
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 2.0],
            [4.0, 2.0],
            [4.0, 1.0],
            [3.0, 1.0],
            [3.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ];
        for (name, outline, most) in
            [("square", square, 1), ("ell", ell, 2), ("star", star, 6), ("comb", comb, 6)]
        {
            let clockwise: Vec<Point> = outline.iter().rev().copied().collect();
            for (outline, sign) in [(&outline, 1.0), (&clockwise, -1.0)] {
                let parts = convex_parts(name, outline).expect("simple");
                let sum: f64 = parts.iter().map(|part| area(part)).sum();
                assert!((sum - sign * area(outline)).abs() < 1e-12, "{name}: {sum}");
                assert!(parts.len() <= most, "{name}: {} parts", parts.len());
                for part in &parts {
                    let n = part.len();
                    assert!(
                        (0..n).all(|k| turn(part[k], part[(k + 1) % n], part[(k + 2) % n]) > 0.0),
                        "{part:?}"
                    );
                }
            }
        }
        let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        assert!(convex_parts("bow", &bow).expect_err("crossed").to_string().contains("crosses"));
        let flat = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]];
        assert!(convex_parts("flat", &flat).is_err());
    }
}
