//! Ranges, steps and numbers of axes.

use std::sync::Arc;

use kuva::TickFormat;
use kuva::render::render_utils::compute_tick_step;

use super::model::Scale;

/// Values below this magnitude are indistinguishable from zero on an axis.
const TINY: f64 = 1e-290;

/// An axis: the range shown of the numbers plotted, which are logarithms, or values over a power of ten.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub(super) log: bool,
    exponent: i32,
    pub(super) lo: f64,
    pub(super) hi: f64,
}

impl Axis {
    /// The axis that shows all `values` with a margin of `pad` times their extent, or `limits` if they make sense.
    pub(super) fn fit(
        scale: Scale,
        values: impl Iterator<Item = f64>,
        pad: f64,
        limits: Option<(f64, f64)>,
    ) -> Self {
        let log = scale == Scale::Log10;
        let drawable = |v: &f64| v.is_finite() && (!log || *v > 0.0);
        let fixed = limits.filter(|(a, b)| drawable(a) && drawable(b) && a < b);
        let extent = |(lo, hi): (f64, f64), v: f64| (lo.min(v), hi.max(v));
        let all = || values.filter(drawable).fold((f64::INFINITY, f64::NEG_INFINITY), extent);
        let (lo, hi) = Some(fixed.unwrap_or_else(all)).filter(|(lo, hi)| lo <= hi).unwrap_or((1.0, 10.0));
        let power = lo.abs().max(hi.abs()).max(TINY).log10().floor() as i32;
        let short = log || (-2..4).contains(&power) || power <= -290;
        let mut axis = Self { log, exponent: if short { 0 } else { power }, lo: 0.0, hi: 1.0 };
        (axis.lo, axis.hi) = (axis.place(lo), axis.place(hi));
        if axis.hi - axis.lo <= 1e-9 * axis.lo.abs().max(axis.hi.abs()) {
            let half = if axis.lo == 0.0 { 1.0 } else { axis.lo.abs() / 2.0 };
            (axis.lo, axis.hi) = (axis.lo - half, axis.hi + half);
        } else if fixed.is_none() {
            // What begins next to zero begins there.
            let begins = !log && axis.lo > 0.0 && axis.lo < 2e-3 * axis.hi;
            axis.lo = if begins { 0.0 } else { axis.lo };
            axis.grow(pad, pad);
        }
        // At least two labelled decades, for the scale to be readable.
        if log && axis.hi.floor() - axis.lo.ceil() < 1.0 {
            (axis.lo, axis.hi) = (axis.lo.floor(), axis.hi.ceil().max(axis.lo.floor() + 1.0));
        }
        axis
    }

    /// Extends the range by fractions of its extent.
    pub(super) fn grow(&mut self, below: f64, above: f64) {
        let span = self.hi - self.lo;
        (self.lo, self.hi) = (self.lo - below * span, self.hi + above * span);
    }

    /// The number plotted for `value`, not finite if it has none.
    pub(super) fn place(&self, value: f64) -> f64 {
        match self.log {
            true if value > 0.0 => value.log10(),
            true => f64::NAN,
            false if value.abs() < TINY => 0.0,
            false => value / 10f64.powi(self.exponent),
        }
    }

    /// How many times more an axis shows than another, in values.
    pub(super) fn ratio(&self, other: &Self) -> f64 {
        (self.hi - self.lo) / (other.hi - other.lo) * 10f64.powi(self.exponent - other.exponent)
    }

    /// The place of `number` as a fraction of the axis.
    pub(super) fn fraction(&self, number: f64) -> f64 {
        (number - self.lo) / (self.hi - self.lo)
    }

    /// The number at a fraction of the axis.
    pub(super) fn number(&self, fraction: f64) -> f64 {
        self.lo + fraction * (self.hi - self.lo)
    }

    /// Step between about `count` numbers, and how they are written.
    pub(super) fn ticks(&self, count: f64) -> (f64, TickFormat) {
        if self.log {
            let step = ((self.hi - self.lo) / count.max(2.0)).round().max(1.0);
            return (step, TickFormat::Custom(Arc::new(|decade| power_of_ten(decade.round() as i32))));
        }
        // An axis with a single number says nothing.
        let two = |step: &f64| (self.hi / step).floor() - (self.lo / step).ceil() >= 1.0;
        let least = count.max(2.0) as usize;
        let mut steps = (least..least + 9).map(|count| compute_tick_step(self.lo, self.hi, count));
        let step = steps.find(two).unwrap_or(self.hi - self.lo);
        let exact = |d: &i32| {
            let scaled = step * 10f64.powi(*d);
            (scaled - scaled.round()).abs() < 1e-6 * scaled
        };
        let decimals = (0..12).find(exact).unwrap_or(12) as usize;
        (step, TickFormat::Custom(Arc::new(move |v| format!("{v:.decimals$}").replace('-', "−"))))
    }

    /// The label with the common power of ten of the numbers in its unit.
    pub(super) fn label(&self, label: &str) -> String {
        let factor = format!("×{}", power_of_ten(self.exponent));
        match label.strip_suffix(')').and_then(|rest| rest.rsplit_once('(')) {
            _ if self.exponent == 0 => label.to_owned(),
            Some((name, unit)) => format!("{name}({factor} {unit})"),
            None => format!("{label} ({factor})"),
        }
    }
}

/// 10ⁿ in letters that need no markup.
fn power_of_ten(exponent: i32) -> String {
    let raised = |c: char| {
        c.to_digit(10).map_or('⁻', |d| ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][d as usize])
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}
