//! Exact solutions of oscillators with impact and friction.

use std::f64::consts::{PI, TAU};

/// The root of f between `low` and `high`, where it changes sign, by bisection to the last digit.
pub(crate) fn bisect(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let sign = f(low).signum();
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if f(middle).signum() == sign { low = middle } else { high = middle }
    }
    high
}

/// ∫ f over (a, b) by Simpson's rule on `n` (even) intervals.
pub(crate) fn simpson(a: f64, b: f64, n: u32, f: impl Fn(f64) -> f64) -> f64 {
    let h = (b - a) / f64::from(n);
    let inner = (1..n).map(|i| f(a + h * f64::from(i)) * if i % 2 == 1 { 4.0 } else { 2.0 });
    (f(a) + f(b) + inner.sum::<f64>()) * h / 3.0
}

/// ẍ + ω²x = −μg sgn ẋ from rest at `start`: half swings about ±μg/ω², each shorter by twice that shift.
pub(crate) struct FrictionOscillator {
    pub(crate) omega: f64,
    pub(crate) shift: f64,
    pub(crate) start: f64,
}

impl FrictionOscillator {
    /// (x, ẋ) at time t.
    pub(crate) fn at(&self, t: f64) -> (f64, f64) {
        let (mut left, mut x) = (t, self.start);
        while x.abs() > self.shift {
            let centre = self.shift.copysign(x);
            if left < PI / self.omega {
                let (sin, cos) = (self.omega * left).sin_cos();
                return (centre + (x - centre) * cos, -(x - centre) * self.omega * sin);
            }
            left -= PI / self.omega;
            x = 2.0 * centre - x;
        }
        (x, 0.0)
    }
}

/// The orbit of ẍ + x = cos(ωt + ψ) with one impact of restitution e at x = 0 per period of the force.
pub(crate) struct PeriodicOrbit {
    omega: f64,
    /// x = a cos t + b sin t + P cos ωt − Q sin ωt.
    coefficients: [f64; 4],
    pub(crate) period: f64,
    /// ẋ after an impact.
    pub(crate) speed: f64,
}

impl PeriodicOrbit {
    pub(crate) fn new(omega: f64, restitution: f64) -> Self {
        // x(0) = x(T) = 0, ẋ(0) = v₀, ẋ(T) = −v₀/e: a = −P = v₀ (1 + 1/e) sin T/(2 (1 − cos T)), b = v₀ (1 + 1/e)/2,
        // ωQ = b − v₀, P² + Q² = (1 − ω²)⁻².
        let period = TAU / omega;
        let b = 0.5 * (1.0 + 1.0 / restitution);
        let a = b * period.sin() / (1.0 - period.cos());
        let q = (b - 1.0) / omega;
        let speed = (1.0 / (1.0 - omega * omega)).abs() / a.hypot(q);
        Self { omega, coefficients: [a, b, -a, q].map(|x| x * speed), period, speed }
    }

    /// (x, ẋ) at time t, after an impact at that time.
    pub(crate) fn at(&self, t: f64) -> (f64, f64) {
        let t = t - self.period * (t / self.period).floor();
        let [a, b, p, q] = self.coefficients;
        let ((sin, cos), (fast_sin, fast_cos)) = (t.sin_cos(), (self.omega * t).sin_cos());
        let x = a * cos + b * sin + p * fast_cos - q * fast_sin;
        (x, b * cos - a * sin - self.omega * (p * fast_sin + q * fast_cos))
    }
}

/// (x, ẋ) of ẍ + 2ζẋ + x = c + cos ωt on the orbit that touches x = 0, c being its amplitude.
pub(crate) fn grazing(omega: f64, damping: f64, t: f64) -> (f64, f64) {
    let (real, imaginary) = (1.0 - omega * omega, 2.0 * damping * omega);
    let amplitude = 1.0 / real.hypot(imaginary);
    let angle = omega * t - imaginary.atan2(real);
    (amplitude * (1.0 + angle.cos()), -amplitude * omega * angle.sin())
}
