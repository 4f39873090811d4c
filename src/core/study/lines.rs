//! The lines of a study: runs that differ in the length of their steps alone, their orders and envelopes.

use super::errors::Errors;
use super::scene::SceneResults;
use super::settings::Stepping;

/// One of the errors.
#[derive(Debug, Clone, Copy)]
pub struct Measure {
    /// Name in the tables.
    pub name: &'static str,
    /// Label of an axis that shows the relative error.
    pub label: &'static str,
    /// The error.
    pub absolute: fn(&Errors) -> f64,
    /// The relative error.
    pub relative: fn(&Errors) -> f64,
}

/// All errors.
pub const MEASURES: [Measure; 4] = [
    Measure { name: "q", label: "q in $L^∞$", absolute: |e| e.q, relative: |e| e.q_relative },
    Measure { name: "v", label: "v in $L^1$", absolute: |e| e.v, relative: |e| e.v_relative },
    Measure {
        name: "percussion",
        label: "percussions",
        absolute: |e| e.percussion,
        relative: |e| e.percussion_relative,
    },
    Measure { name: "energy", label: "energy", absolute: |e| e.energy, relative: |e| e.energy_relative },
];

/// A run on its line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// h or ε.
    pub value: f64,
    /// Mean step (s).
    pub step: f64,
    /// CPU time (s).
    pub cpu_seconds: f64,
    /// Errors.
    pub errors: Errors,
}

/// Runs that differ in h, or in ε, alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// What sets it apart from the other lines.
    pub label: String,
    /// The label without the arithmetic.
    pub scheme: String,
    /// `f64` or `f32`.
    pub scalar: String,
    /// Whether its steps are adaptive.
    pub adaptive: bool,
    /// Whether the study marks it.
    pub marked: bool,
    /// Its settings by name.
    pub settings: Vec<(String, String)>,
    /// Its runs, the longest steps first.
    pub points: Vec<Point>,
}

/// Neighbouring points of a line: what they guarantee together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bin {
    /// Geometric mean of the steps (s).
    pub step: f64,
    /// Median CPU time (s).
    pub cpu_seconds: f64,
    /// Largest relative error.
    pub error: f64,
    /// Smallest h, or ε, of the points.
    least: f64,
}

/// How an error falls along a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order {
    /// Points regressed over: those of steps not finer than the bin with the least envelope, beyond which rounding or
    /// what does not depend on h takes over.
    pub points: usize,
    /// Slope of ln(error) over ln(h), or ln(ε), by least squares.
    pub slope: f64,
    /// Standard deviation of the slope.
    pub deviation: f64,
    /// The slope rounded to a half.
    pub nominal: f64,
    /// Least C with error ≤ C h^nominal in all those points, absolute.
    pub constant: f64,
    /// The same of the relative error.
    pub constant_relative: f64,
    /// Least relative error of the line.
    pub least: f64,
}

/// Bins in a decade of h or ε.
const BINS: f64 = 4.0;

impl SceneResults {
    /// The lines of the runs that did not fail, in the order of the study.
    pub fn lines(&self) -> Vec<Line> {
        let stepping = ["h", "epsilon"];
        let rows: Vec<_> = self.rows.iter().map(|row| (row, row.settings.fields(&self.keys))).collect();
        // The tolerance a scalar has by default says no more than the scalar.
        let varies = |place: usize| match rows[0].1[place].0.as_str() {
            "tolerance" => rows.iter().any(|(row, fields)| {
                let alike = rows.iter().find(|(other, _)| other.settings.scalar == row.settings.scalar);
                alike.is_some_and(|(_, other)| other[place].1 != fields[place].1)
            }),
            // Nor does a key that only some blocks name, all with one value.
            _ => {
                let mut values =
                    rows.iter().map(|(_, fields)| &fields[place].1).filter(|value| !value.is_empty());
                let first = values.next();
                values.any(|value| Some(value) != first)
            }
        };
        let varying: Vec<usize> = match rows.first() {
            Some((_, fields)) => (0..fields.len())
                .filter(|&i| !stepping.contains(&fields[i].0.as_str()) && varies(i))
                .collect(),
            None => Vec::new(),
        };
        let mut lines: Vec<Line> = Vec::new();
        for (row, fields) in rows.iter().filter(|(row, _)| row.outcome.ok) {
            let settings: Vec<_> =
                fields.iter().filter(|(name, _)| !stepping.contains(&name.as_str())).cloned().collect();
            let point = Point {
                value: row.settings.stepping.value(),
                step: row.end / row.outcome.steps.max(1) as f64,
                cpu_seconds: row.outcome.cpu_seconds,
                errors: row.outcome.errors,
            };
            if let Some(line) = lines.iter_mut().find(|line| line.settings == settings) {
                line.points.push(point);
                continue;
            }
            let words = |scalar: bool| {
                let shown =
                    varying.iter().map(|&i| &fields[i]).filter(|(name, _)| scalar || name != "scalar");
                shown.filter_map(|(name, value)| word(name, value)).collect::<Vec<_>>().join(", ")
            };
            let has = |(name, value): (&String, &toml::Value)| {
                settings.iter().any(|(own, text)| own == name && *text == super::settings::text(value))
            };
            let marked = self.mark.as_ref().is_some_and(|mark| mark.settings.iter().all(has));
            lines.push(Line {
                label: words(true),
                scheme: words(false),
                scalar: row.settings.scalar.name().into(),
                adaptive: matches!(row.settings.stepping, Stepping::Adaptive(_)),
                marked,
                settings,
                points: vec![point],
            });
        }
        lines.iter_mut().for_each(|line| line.points.sort_by(|a, b| b.value.total_cmp(&a.value)));
        lines
    }
}

/// A setting in the words of a legend; fixed steps go without saying.
fn word(name: &str, value: &str) -> Option<String> {
    Some(match name {
        "scheme" if value == Stepping::Fixed(0.0).name() => return None,
        "law" | "solver" | "scalar" | "scheme" => value.into(),
        "theta" => format!("θ = {value}"),
        "tolerance" => format!("tol {value}"),
        path => {
            let short = path.rsplit('.').next().unwrap_or(path);
            format!("{short} {}", if value.is_empty() { "as is" } else { value })
        }
    })
}

impl Line {
    /// The envelope: the points of each quarter of a decade of h, or ε, together. The longest steps first.
    pub fn envelope(&self, measure: &Measure) -> Vec<Bin> {
        let cell = |value: f64| (value.log10() * BINS + 1e-9).floor();
        let mut bins = Vec::new();
        let known = self.points.iter().filter(|p| (measure.relative)(&p.errors).is_finite());
        let known: Vec<&Point> = known.collect();
        for members in known.chunk_by(|a, b| cell(a.value) == cell(b.value)) {
            let mut times: Vec<f64> = members.iter().map(|point| point.cpu_seconds).collect();
            times.sort_by(f64::total_cmp);
            let logs = members.iter().map(|point| point.step.ln()).sum::<f64>() / members.len() as f64;
            bins.push(Bin {
                step: logs.exp(),
                cpu_seconds: 0.5 * (times[(times.len() - 1) / 2] + times[times.len() / 2]),
                error: members.iter().map(|point| (measure.relative)(&point.errors)).fold(0.0, f64::max),
                least: members[members.len() - 1].value,
            });
        }
        bins
    }

    /// Order and constant of an error; `None` where fewer than three points know it.
    pub fn order(&self, measure: &Measure) -> Option<Order> {
        let bins = self.envelope(measure);
        let from = bins.iter().min_by(|a, b| a.error.total_cmp(&b.error))?.least;
        let fits = |point: &&Point| {
            let error = (measure.absolute)(&point.errors);
            point.value >= from && error.is_finite() && error > 0.0
        };
        let points: Vec<&Point> = self.points.iter().filter(fits).collect();
        let logs: Vec<(f64, f64)> =
            points.iter().map(|point| (point.value.ln(), (measure.absolute)(&point.errors).ln())).collect();
        let (slope, deviation) = regression(&logs)?;
        let nominal = 0.5 * (2.0 * slope).round();
        let constant = |error: fn(&Errors) -> f64| {
            points.iter().map(|point| error(&point.errors) / point.value.powf(nominal)).fold(0.0, f64::max)
        };
        Some(Order {
            points: points.len(),
            slope,
            deviation,
            nominal,
            constant: constant(measure.absolute),
            constant_relative: constant(measure.relative),
            least: self.points.iter().map(|p| (measure.relative)(&p.errors)).fold(f64::INFINITY, f64::min),
        })
    }

    /// CPU time (s) from which on the envelope is below a relative error, by interpolation of the logarithms; `None` where
    /// no run comes there.
    pub fn cost(&self, measure: &Measure, error: f64) -> Option<f64> {
        let bins = self.envelope(measure);
        let first = bins.iter().position(|bin| bin.error <= error)?;
        let (to, from) = (&bins[first], first.checked_sub(1).map(|before| &bins[before]));
        Some(from.map_or(to.cpu_seconds, |from| {
            let share = (from.error / error).ln() / (from.error / to.error).ln();
            (from.cpu_seconds.ln() + share * (to.cpu_seconds / from.cpu_seconds).ln()).exp()
        }))
    }
}

/// Slope of the least-squares line through points, and its standard deviation; `None` for fewer than three.
fn regression(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let n = points.len() as f64;
    if points.len() < 3 {
        return None;
    }
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let square: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let slope = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / square;
    let left: f64 = points.iter().map(|p| (p.1 - y - slope * (p.0 - x)).powi(2)).sum();
    slope.is_finite().then(|| (slope, (left / (n - 2.0) / square).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(error: impl Fn(f64) -> f64) -> Line {
        let point = |i: i32| {
            let h = 10f64.powf(-1.0 - 0.05 * f64::from(i));
            let errors = Errors { q: error(h), q_relative: 0.5 * error(h), ..Errors::UNKNOWN };
            Point { value: h, step: h, cpu_seconds: 1e-6 / h, errors }
        };
        Line {
            label: String::new(),
            scheme: String::new(),
            scalar: "f64".into(),
            adaptive: false,
            marked: false,
            settings: Vec::new(),
            points: (0..60).map(point).collect(),
        }
    }

    #[test]
    fn a_power_law_has_its_order_constant_and_cost() {
        let line = line(|h| 3.0 * h);
        let order = line.order(&MEASURES[0]).expect("60 points");
        assert!((order.slope - 1.0).abs() < 1e-12 && order.deviation < 1e-12 && order.points == 60);
        assert!((order.nominal, order.constant_relative) == (1.0, order.constant * 0.5));
        assert!((order.constant - 3.0).abs() < 1e-12);
        // 1.5 h = 1e-3 costs 1e-6/h = 1.5e-3 s; a bin has the error of its largest h, up to 4⁻¹ decade off.
        let cost = line.cost(&MEASURES[0], 1e-3).expect("within reach");
        assert!(cost >= 1.5e-3 && cost < 1.5e-3 * 10f64.powf(0.25), "{cost}");
        assert_eq!(line.cost(&MEASURES[0], 1e-9), None);
        assert_eq!(line.order(&MEASURES[1]), None);
    }

    #[test]
    fn what_rounding_adds_at_small_steps_does_not_count_for_the_order() {
        let order = line(|h| h + 1e-9 / (h * h)).order(&MEASURES[0]).expect("60 points");
        assert!(order.points < 60 && (order.slope - 1.0).abs() < 0.1, "{order:?}");
        assert!(order.least < 2e-3);
    }

    #[test]
    fn a_saw_tooth_is_bounded_by_its_envelope() {
        let saw = |h: f64| h * (0.1 + (0.377 / h).fract());
        let line = line(saw);
        let order = line.order(&MEASURES[0]).expect("60 points");
        assert!(order.constant > 0.8 && order.constant <= 1.1, "{order:?}");
        assert!(order.deviation > 1e-3, "two points would have told another order");
        assert!(line.envelope(&MEASURES[0]).windows(2).all(|bins| bins[0].step > bins[1].step));
    }
}
