//! Orders of convergence from many step sizes: errors of event-capturing schemes saw-tooth, so two are not enough.

/// `count` step sizes from `least` to `largest`, equally spaced in their logarithm.
#[allow(dead_code, reason = "each test takes what it needs")]
pub(crate) fn log_spaced(least: f64, largest: f64, count: usize) -> Vec<f64> {
    let ratio = (largest / least).ln() / (count - 1) as f64;
    (0..count).map(|i| least * (ratio * i as f64).exp()).collect()
}

/// Slope of the least-squares line of ln(error) over ln(step).
pub(crate) fn order(steps: &[f64], errors: &[f64]) -> f64 {
    let log = |x: &[f64]| x.iter().map(|x| x.ln()).collect::<Vec<f64>>();
    let (x, y) = (log(steps), log(errors));
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (x_mean, y_mean) = (mean(&x), mean(&y));
    let along =
        |x: &[f64], m: f64, y: &[f64], n: f64| x.iter().zip(y).map(|(x, y)| (x - m) * (y - n)).sum::<f64>();
    along(&x, x_mean, &y, y_mean) / along(&x, x_mean, &x, x_mean)
}
