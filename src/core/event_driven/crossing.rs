//! The first time at which one of several functions becomes negative, none missed.
//!
//! On an interval every function is replaced by its Chebyshev interpolant Σ c_k T_k (Trefethen 2019,
//! doi:10.1137/1.9781611975949). |T_k| ≤ 1 bounds it from below by c₀ − Σ|c_k|: where the bound is positive there is no
//! crossing, two close ones included; where the same bound on the derivative shows a monotone function there is at
//! most one; otherwise, and where the last coefficients say that the interpolant is not the function yet, the interval
//! is halved. Roots are then found to the last digit.

use std::sync::LazyLock;

/// Degree of the interpolants.
const DEGREE: usize = 16;

/// Where sampling stops: this share of the interval searched.
const FINEST: f64 = 1e-12;

/// Most intervals looked at in one search.
const MOST_INTERVALS: usize = 20_000;

/// Functions of time, evaluated together.
pub(super) trait Functions {
    /// Why they cannot be evaluated.
    type Error;
    /// Number of functions.
    fn count(&self) -> usize;
    /// Values at `time`.
    fn at(&mut self, time: f64, values: &mut [f64]) -> Result<(), Self::Error>;
    /// How far below zero function `i` may be by rounding, in an interval that starts at `time`.
    fn rounding(&self, i: usize, time: f64) -> f64;
    /// A time at which the search is split in two, for functions whose rounding changes there.
    fn split(&self) -> f64;
}

/// A search that did not end.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("a function is not resolved by {MOST_INTERVALS} intervals near {time}")]
pub(super) struct Unresolved {
    /// Where the search was.
    pub(super) time: f64,
}

type Samples = [f64; DEGREE + 1];

/// x_j = cos πj/N from −1 to 1, and coefficient k as Σ_j `transform[k][j]` f(x_j).
struct Table {
    points: Samples,
    transform: [Samples; DEGREE + 1],
}

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let n = DEGREE as f64;
    let mut table = Table { points: [0.0; DEGREE + 1], transform: [[0.0; DEGREE + 1]; DEGREE + 1] };
    let end = |j: usize| if j == 0 || j == DEGREE { 0.5 } else { 1.0 };
    for j in 0..=DEGREE {
        table.points[j] = -(std::f64::consts::PI * j as f64 / n).cos();
        for k in 0..=DEGREE {
            let cosine = (std::f64::consts::PI * (k * (DEGREE - j)) as f64 / n).cos();
            table.transform[k][j] = 2.0 / n * end(j) * end(k) * cosine;
        }
    }
    table
});

/// What an interval says of one function.
enum Verdict {
    /// It does not become negative.
    Clear,
    /// It crosses once, downwards.
    Crosses,
    /// It is negative at the start of the interval already.
    Negative,
    /// Halve the interval.
    Open,
}

fn verdict(samples: &Samples, rounding: f64) -> Verdict {
    let c = TABLE.transform.map(|row| row.iter().zip(samples).map(|(t, f)| t * f).sum::<f64>());
    // What the interpolant leaves out, from the decay of its last coefficients: nothing where they are rounding.
    let tail = c[DEGREE - 3..].iter().fold(0.0_f64, |tail, c| tail.max(c.abs()));
    let tail = if tail <= rounding { 0.0 } else { tail * DEGREE as f64 };
    let rest: f64 = c[1..].iter().map(|c| c.abs()).sum();
    if c[0] - rest - tail >= -rounding {
        return Verdict::Clear;
    }
    // Derivative with respect to x: d_{k−1} = d_{k+1} + 2k c_k.
    let mut d = [0.0; DEGREE + 2];
    for k in (1..=DEGREE).rev() {
        d[k - 1] = d[k + 1] + 2.0 * k as f64 * c[k];
    }
    let rest: f64 = d[1..].iter().map(|d| d.abs()).sum();
    let monotone = 0.5 * d[0].abs() - rest - tail * (DEGREE * DEGREE) as f64 > 0.0;
    let (first, last) = (samples[0], samples[DEGREE]);
    match (monotone, d[0] > 0.0) {
        (true, true) if first < -rounding => Verdict::Negative,
        (true, true) => Verdict::Clear,
        (true, false) if last >= -rounding => Verdict::Clear,
        (true, false) if first < -rounding => Verdict::Negative,
        (true, false) => Verdict::Crosses,
        (false, _) => Verdict::Open,
    }
}

/// The first time in [0, `end`] at which a function becomes negative, and its index.
pub(super) fn first_crossing<F>(functions: &mut F, end: f64) -> Result<Option<(f64, usize)>, F::Error>
where
    F: Functions,
    F::Error: From<Unresolved>,
{
    let count = functions.count();
    if count == 0 {
        return Ok(None);
    }
    let split = functions.split();
    let mut stack = if split < end { vec![(split, end), (0.0, split)] } else { vec![(0.0, end)] };
    let (mut values, mut samples) = (vec![0.0; count], vec![[0.0; DEGREE + 1]; count]);
    let mut intervals = 0;
    while let Some((a, b)) = stack.pop() {
        intervals += 1;
        if intervals > MOST_INTERVALS {
            return Err(Unresolved { time: a }.into());
        }
        let place = |j: usize| match j {
            0 => a,
            DEGREE => b,
            _ => 0.5 * (a + b) + 0.5 * (b - a) * TABLE.points[j],
        };
        for j in 0..=DEGREE {
            functions.at(place(j), &mut values)?;
            samples.iter_mut().zip(&values).for_each(|(samples, value)| samples[j] = *value);
        }
        let finest = b - a <= FINEST * end || place(1) <= a || place(DEGREE - 1) >= b;
        let mut brackets: Vec<(usize, f64, f64)> = Vec::new();
        let mut open = false;
        for (i, samples) in samples.iter().enumerate() {
            let rounding = functions.rounding(i, a);
            match verdict(samples, rounding) {
                Verdict::Clear => {}
                Verdict::Crosses => brackets.push((i, a, b)),
                Verdict::Negative => brackets.push((i, a, a)),
                Verdict::Open if finest => {
                    if let Some(j) = samples.iter().position(|&f| f < -rounding) {
                        brackets.push((i, place(j.saturating_sub(1)), place(j)));
                    }
                }
                Verdict::Open => open = true,
            }
        }
        if open {
            let middle = 0.5 * (a + b);
            stack.push((middle, b));
            stack.push((a, middle));
            continue;
        }
        let mut first: Option<(f64, usize)> = None;
        for (i, low, high) in brackets {
            let root = root(functions, i, low, high, &mut values)?;
            if first.is_none_or(|(time, _)| root < time) {
                first = Some((root, i));
            }
        }
        if first.is_some() {
            return Ok(first);
        }
    }
    Ok(None)
}

/// Where function `i`, not negative at `low` and negative at `high`, changes sign: the ITP method (Oliveira & Takahashi
/// 2021, doi:10.1145/3423597), which is never slower than bisection by more than a step.
fn root<F: Functions>(
    functions: &mut F,
    i: usize,
    mut low: f64,
    mut high: f64,
    values: &mut [f64],
) -> Result<f64, F::Error> {
    let mut at = |time: f64, values: &mut [f64]| functions.at(time, values).map(|()| values[i]);
    let (mut f_low, mut f_high) = (at(low, values)?, at(high, values)?);
    if f_low <= 0.0 || f_high >= 0.0 {
        return Ok(if f_low <= 0.0 { low } else { high });
    }
    let (width, mut step) = (high - low, 0);
    loop {
        let half = 0.5 * (high - low);
        let middle = low + half;
        if middle <= low || middle >= high {
            return Ok(low);
        }
        // Interpolate, truncate towards the middle, project into the interval the minmax strategy leaves.
        let secant = (high * f_low - low * f_high) / (f_low - f_high);
        let side = if middle >= secant { 1.0 } else { -1.0 };
        let truncation = 0.2 / width * (high - low) * (high - low);
        let truncated =
            if truncation <= (middle - secant).abs() { secant + side * truncation } else { middle };
        // The least width asked for is that of neighbouring numbers.
        let least = f64::EPSILON * low.abs().max(high.abs()).max(f64::MIN_POSITIVE);
        let halvings = (width / least).log2().ceil() + 1.0;
        let radius = (0.5 * least * (halvings - f64::from(step)).exp2() - half).max(0.0);
        let next = if (truncated - middle).abs() <= radius { truncated } else { middle - side * radius };
        let next = if next > low && next < high { next } else { middle };
        let f = at(next, values)?;
        if f > 0.0 {
            (low, f_low) = (next, f);
        } else if f < 0.0 {
            (high, f_high) = (next, f);
        } else {
            return Ok(next);
        }
        step += 1;
        if step > 200 {
            return Ok(low);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Closure<F>(F, usize);

    impl<F: Fn(f64, usize) -> f64> Functions for Closure<F> {
        type Error = Unresolved;
        fn count(&self) -> usize {
            self.1
        }
        fn at(&mut self, time: f64, values: &mut [f64]) -> Result<(), Self::Error> {
            values.iter_mut().enumerate().for_each(|(i, value)| *value = (self.0)(time, i));
            Ok(())
        }
        fn rounding(&self, _: usize, _: f64) -> f64 {
            4e-15
        }
        fn split(&self) -> f64 {
            0.3
        }
    }

    fn first(count: usize, end: f64, f: impl Fn(f64, usize) -> f64) -> Option<(f64, usize)> {
        first_crossing(&mut Closure(f, count), end).expect("resolved")
    }

    #[test]
    fn close_pairs_of_crossings_are_not_missed_and_touches_are_no_crossings() {
        // A dip of depth δ and width 2√δ at √2 of an interval of length 10.
        let at = std::f64::consts::SQRT_2;
        for depth in [1e-3, 1e-6, 1e-9, 1e-12, 1e-13] {
            let dip = |t: f64, _| (t - at) * (t - at) - depth;
            let (time, _) = first(1, 10.0, dip).unwrap_or_else(|| panic!("a dip of {depth} is missed"));
            // Rounding of 2ε·at² over the slope 2√δ.
            assert!((time - (at - depth.sqrt())).abs() < 1e-15 / depth.sqrt() + 1e-15, "{depth}: {time}");
        }
        assert_eq!(first(1, 10.0, |t, _| (t - at) * (t - at)), None);
        assert_eq!(first(1, 10.0, |t, _| (t - at) * (t - at) + 1e-13), None);
    }

    #[test]
    fn the_first_of_several_functions_is_found_to_the_last_digit() {
        let f = |t: f64, i: usize| match i {
            0 => (40.0 * t).sin() + 1.1,
            1 => 2.0 - t * t,
            2 => (3.0 * t).cos(),
            _ => {
                if t < 2.0 {
                    1.0
                } else {
                    -1.0
                }
            }
        };
        let (time, i) = first(2, 10.0, f).expect("√2");
        assert!(i == 1 && (time - 2f64.sqrt()).abs() <= 2.0 * f64::EPSILON, "{time}");
        let (time, i) = first(4, 10.0, f).expect("π/6");
        assert!(i == 2 && (time - std::f64::consts::FRAC_PI_6).abs() <= 2.0 * f64::EPSILON, "{time}");
        // A jump is found, to the resolution of the search.
        let (time, _) = first(1, 10.0, |t, _| f(t, 3)).expect("a jump");
        assert!((time - 2.0).abs() <= 10.0 * FINEST, "{time}");
        // A root 1e-9 of the interval away.
        let (time, _) = first(1, 10.0, |t, _| 1e-8 - t).expect("near the start");
        assert!((time - 1e-8).abs() < 1e-22, "{time:e}");
    }

    #[test]
    fn what_is_negative_at_the_start_crosses_there() {
        assert_eq!(first(1, 1.0, |t, _| -0.1 - t), Some((0.0, 0)));
        assert_eq!(first(1, 1.0, |t, _| t), None);
        assert_eq!(first(1, 1.0, |t, _| t * t * (1.0 + t)), None);
        assert_eq!(first(1, 1.0, |t, _| t * (1.0 - t) * (1.0 + t.exp())).map(|(t, _)| t >= 1.0), None);
    }
}
