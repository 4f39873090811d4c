//! Ranges, ticks and tick labels.

use super::model::{Panel, Scale, Style};

/// Values below this magnitude are indistinguishable from zero on an axis.
const TINY: f64 = 1e-290;

/// An axis: the range shown, in plotted units (scaled values or logarithms).
#[derive(Clone, Debug)]
pub(super) struct Axis {
    scale: Scale,
    /// Power of ten taken out of the tick labels of a linear axis.
    pub(super) exponent: i32,
    pub(super) lo: f64,
    pub(super) hi: f64,
}

/// A tick mark; minor ticks have no label.
#[derive(Clone, Debug)]
pub(super) struct Tick {
    /// Position as a fraction of the axis.
    pub(super) at: f64,
    pub(super) label: Option<String>,
}

impl Axis {
    /// The axis that shows all drawable `values` with a margin of `pad` times
    /// their extent, or exactly `limits` if they make sense.
    pub(super) fn fit(
        scale: Scale,
        values: impl Iterator<Item = f64>,
        pad: f64,
        limits: Option<(f64, f64)>,
    ) -> Self {
        let drawable = |v: &f64| v.is_finite() && (scale == Scale::Linear || *v > 0.0);
        let fixed = limits.filter(|(a, b)| drawable(a) && drawable(b) && a < b);
        let (min, max) = fixed.unwrap_or_else(|| {
            let extent = |(a, b): (f64, f64), v: f64| (a.min(v), b.max(v));
            values.filter(drawable).fold((f64::INFINITY, f64::NEG_INFINITY), extent)
        });
        let mut axis = Self { scale, exponent: 0, lo: 0.0, hi: 1.0 };
        if min > max {
            return axis;
        }
        if scale == Scale::Linear {
            axis.exponent = exponent(min.abs().max(max.abs()));
        }
        axis.lo = axis.transform(min).unwrap_or(0.0);
        axis.hi = axis.transform(max).unwrap_or(1.0);
        if fixed.is_none() || axis.hi <= axis.lo {
            axis.widen(pad);
        }
        axis
    }

    fn widen(&mut self, pad: f64) {
        let span = self.hi - self.lo;
        let middle = self.lo + span / 2.0;
        match self.scale {
            Scale::Linear if span <= 1e-9 * self.lo.abs().max(self.hi.abs()) => {
                let half = if middle == 0.0 { 1.0 } else { middle.abs() / 2.0 };
                (self.lo, self.hi) = (middle - half, middle + half);
            }
            Scale::Linear => self.grow(pad, pad),
            Scale::Log10 => {
                self.grow(pad, pad);
                // At least two labelled decades, for the scale to be readable.
                if self.hi.floor() - self.lo.ceil() < 1.0 {
                    self.lo = self.lo.floor();
                    self.hi = self.hi.ceil().max(self.lo + 1.0);
                }
            }
        }
    }

    /// Extends the range by fractions of its extent.
    pub(super) fn grow(&mut self, below: f64, above: f64) {
        let span = self.hi - self.lo;
        self.lo -= below * span;
        self.hi += above * span;
    }

    fn transform(&self, value: f64) -> Option<f64> {
        match self.scale {
            Scale::Linear => value.is_finite().then(|| value / 10f64.powi(self.exponent)),
            Scale::Log10 => (value.is_finite() && value > 0.0).then(|| value.log10()),
        }
    }

    /// Position of `value` as a fraction of the axis, not finite if it has none.
    pub(super) fn place(&self, value: f64) -> f64 {
        let transformed = self.transform(value).unwrap_or(f64::NAN);
        (transformed - self.lo) / (self.hi - self.lo)
    }

    /// Position of zero, or of the bottom of the axis if zero is out of it.
    pub(super) fn baseline(&self) -> f64 {
        match self.scale {
            Scale::Linear => self.place(0.0).clamp(0.0, 1.0),
            Scale::Log10 => 0.0,
        }
    }

    /// Position of zero if the axis shows it.
    pub(super) fn zero(&self) -> Option<f64> {
        let at = self.place(0.0);
        (self.scale == Scale::Linear && at > 0.0 && at < 1.0).then_some(at)
    }

    /// The label with the common power of ten of the ticks in its unit.
    pub(super) fn label(&self, label: &str) -> String {
        if self.exponent == 0 {
            return label.to_owned();
        }
        let factor = format!("$×10^{{{}}}$", minus(self.exponent.to_string()));
        let unit = label.trim_end().strip_suffix(')');
        match unit.and_then(|rest| rest.rsplit_once('(')) {
            Some((name, "-" | "–" | "−" | "1")) => format!("{name}({factor})"),
            Some((name, unit)) => format!("{name}({factor} {unit})"),
            None if label.is_empty() => factor,
            None => format!("{label} ({factor})"),
        }
    }

    /// The densest ticks, at most `most` with labels, for which `fits` holds; the
    /// sparsest that show the scale, with two labels, if it never does.
    pub(super) fn ticks(&self, most: usize, fits: impl Fn(&[Tick]) -> bool) -> Vec<Tick> {
        let most = most.max(2);
        let mut sparsest = Vec::new();
        for target in (1..=most + 3).rev() {
            let ticks = match self.scale {
                Scale::Linear => self.linear_ticks(target),
                Scale::Log10 => self.decade_ticks(target),
            };
            let labelled = ticks.iter().filter(|t| t.label.is_some()).count();
            if labelled < 2 {
                continue;
            }
            if labelled <= most && fits(&ticks) {
                return ticks;
            }
            sparsest = ticks;
        }
        sparsest
    }

    fn linear_ticks(&self, target: usize) -> Vec<Tick> {
        let span = self.hi - self.lo;
        let rough = span / target as f64;
        let unit = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .map(|m| m * unit)
            .into_iter()
            .find(|s| *s >= rough * 0.999)
            .unwrap_or(10.0 * unit);
        let decimals = (-(step.log10() + 1e-9).floor()).clamp(0.0, 12.0) as usize;
        // A range that misses a round end by a hair deserves its tick.
        let hair = 2e-3 * span / step;
        let first = (self.lo / step - hair).ceil();
        let last = (self.hi / step + hair).floor();
        if !(first.is_finite() && last.is_finite()) {
            return Vec::new();
        }
        let count = (last - first).clamp(-1.0, 50.0) as i64;
        let tick = |i: i64| {
            let value = (first + i as f64) * step;
            let value = if value.abs() < step / 2.0 { 0.0 } else { value };
            Tick {
                at: ((value - self.lo) / span).clamp(0.0, 1.0),
                label: Some(minus(format!("{value:.decimals$}"))),
            }
        };
        (0..=count).map(tick).collect()
    }

    fn decade_ticks(&self, target: usize) -> Vec<Tick> {
        let (first, last) = (self.lo.floor() as i64, self.hi.ceil() as i64);
        let stride = (self.hi - self.lo).max(1.0) as i64 / target as i64 + 1;
        let span = self.hi - self.lo;
        let mut ticks = Vec::new();
        for decade in first..=last {
            let labelled = decade.rem_euclid(stride) == 0;
            let label = labelled.then(|| format!("$10^{{{}}}$", minus(decade.to_string())));
            let minor = if stride == 1 { 2..10 } else { 0..0 };
            let minor = minor.map(|m| (decade as f64 + f64::from(m).log10(), None));
            for (at, label) in std::iter::once((decade as f64, label)).chain(minor) {
                let at = (at - self.lo) / span;
                if (-1e-9..=1.0 + 1e-9).contains(&at) {
                    ticks.push(Tick { at, label });
                }
            }
        }
        ticks
    }
}

/// Axes that show all the series of a panel.
pub(super) fn axes(panel: &Panel) -> (Axis, Axis) {
    let series = || panel.series.iter();
    let marked = series().any(|s| !matches!(s.style, Style::Line | Style::Steps));
    let bars = series().any(|s| s.style == Style::Stems && s.x.len().min(s.y.len()) > 0);
    let seen = |p: &(f64, f64)| {
        let drawn = |v: f64, scale| v.is_finite() && (scale == Scale::Linear || v > 0.0);
        drawn(p.0, panel.x_scale) && drawn(p.1, panel.y_scale)
    };
    let points = || series().flat_map(|s| s.points()).filter(seen);
    let pad = if marked || panel.equal_aspect { 0.06 } else { 0.0 };
    let zero = bars.then_some(0.0);
    let x = Axis::fit(panel.x_scale, points().map(|p| p.0), pad, panel.x_limits);
    let values = points().map(|p| p.1).chain(zero);
    let y = Axis::fit(panel.y_scale, values, 0.07, panel.y_limits);
    (x, y)
}

/// Power of ten to take out of labels up to `magnitude`; none when they are short.
fn exponent(magnitude: f64) -> i32 {
    if !(TINY..).contains(&magnitude) {
        return 0;
    }
    let power = magnitude.log10().floor() as i32;
    if (-2..4).contains(&power) { 0 } else { power }
}

/// Numbers are set with a true minus sign.
fn minus(number: String) -> String {
    number.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, most: usize) -> Vec<String> {
        let ticks = axis.ticks(most, |_| true);
        ticks.into_iter().filter_map(|t| t.label).collect()
    }

    fn linear(values: &[f64]) -> Axis {
        Axis::fit(Scale::Linear, values.iter().copied(), 0.05, None)
    }

    #[test]
    fn small_values_share_a_power_of_ten() {
        let axis = linear(&[-7e-4, 7e-4]);
        assert_eq!(labels(&axis, 4), ["−5", "0", "5"]);
        assert_eq!(axis.label("w (J)"), "w ($×10^{−4}$ J)");
        assert_eq!(axis.label("f (-)"), "f ($×10^{−4}$)");
        assert_eq!(axis.label(""), "$×10^{−4}$");
        assert_eq!(linear(&[-0.2, 0.2]).label("u (m)"), "u (m)");
    }

    #[test]
    fn any_values_give_a_sound_axis() {
        let sets: [&[f64]; 8] = [
            &[],
            &[f64::NAN, f64::INFINITY],
            &[0.0],
            &[3.0, 3.0],
            &[1e-320, -1e-320],
            &[-f64::MAX, f64::MAX],
            &[1.0, 1.0 + f64::EPSILON],
            &[f64::MIN_POSITIVE, f64::MAX],
        ];
        for values in sets {
            for scale in [Scale::Linear, Scale::Log10] {
                let axis = Axis::fit(scale, values.iter().copied(), 0.05, None);
                assert!(axis.lo < axis.hi && (axis.hi - axis.lo).is_finite());
                for most in [0, 1, 4, 9] {
                    assert!(labels(&axis, most).len() >= 2, "{values:?} {axis:?}");
                }
            }
        }
    }

    #[test]
    fn decades_are_labelled_as_powers() {
        let axis = Axis::fit(Scale::Log10, [2e-3, 30.0].into_iter(), 0.0, None);
        assert_eq!(labels(&axis, 6), ["$10^{−2}$", "$10^{−1}$", "$10^{0}$", "$10^{1}$"]);
        assert!(axis.place(-1.0).is_nan());
        assert_eq!(axis.place(2e-3), 0.0);
    }

    #[test]
    fn limits_are_obeyed_when_sound() {
        let fit = |limits| Axis::fit(Scale::Linear, [0.0, 1.0].into_iter(), 0.0, Some(limits));
        assert_eq!((fit((0.2, 0.4)).lo, fit((0.2, 0.4)).hi), (0.2, 0.4));
        assert_eq!((fit((0.4, 0.2)).lo, fit((f64::NAN, 0.2)).hi), (0.0, 1.0));
    }
}
