//! The Gauss rule on [0, 1] and Legendre polynomials with their integrals: the arithmetic of a collocation step.

use std::sync::LazyLock;

/// Number of collocation points.
pub(super) const STAGES: usize = 12;

/// A value for each collocation point, or the coefficient of each polynomial P₀, P₁, ….
pub(super) type Column = [f64; STAGES];

/// P_k(2x − 1), or an integral of it, at one place for every k.
#[derive(Debug, Clone, Copy)]
pub(super) struct Values {
    /// P_k.
    pub(super) value: Column,
    /// ∫₀ˣ P_k.
    pub(super) first: Column,
    /// ∫₀ˣ∫₀ P_k.
    pub(super) second: Column,
}

/// The rule and what does not change from step to step.
#[derive(Debug)]
pub(super) struct Basis {
    /// Points c_j of (0, 1).
    pub(super) nodes: Column,
    /// Weights, of sum 1.
    pub(super) weights: Column,
    /// The polynomials at the points.
    pub(super) at_nodes: [Values; STAGES],
    /// Coefficient k is Σ_j `transform[k][j]` f(c_j): exact for polynomials through the points.
    transform: [Column; STAGES],
}

/// The one rule in use.
pub(super) static BASIS: LazyLock<Basis> = LazyLock::new(Basis::new);

/// P₀ … P_{STAGES+1} at y ∈ [−1, 1].
fn legendre(y: f64) -> [f64; STAGES + 2] {
    let mut p = [1.0; STAGES + 2];
    p[1] = y;
    for k in 1..=STAGES {
        let n = k as f64;
        p[k + 1] = ((2.0 * n + 1.0) * y * p[k] - n * p[k - 1]) / (n + 1.0);
    }
    p
}

impl Values {
    /// The polynomials at x.
    pub(super) fn at(x: f64) -> Self {
        let p = legendre(2.0 * x - 1.0);
        let mut values = Self { value: [0.0; STAGES], first: [0.0; STAGES], second: [0.0; STAGES] };
        values.value.copy_from_slice(&p[..STAGES]);
        // ∫₀ˣ P_k = (P_{k+1} − P_{k−1})/(2(2k+1)), and the same once more; P₀ = 1 is integrated by hand.
        let mut first = [0.0; STAGES + 1];
        first[0] = x;
        for k in 1..=STAGES {
            first[k] = (p[k + 1] - p[k - 1]) / (2.0 * (2 * k + 1) as f64);
        }
        values.first.copy_from_slice(&first[..STAGES]);
        values.second[0] = 0.5 * x * x;
        for k in 1..STAGES {
            values.second[k] = (first[k + 1] - first[k - 1]) / (2.0 * (2 * k + 1) as f64);
        }
        values
    }
}

impl Basis {
    fn new() -> Self {
        let (mut nodes, mut weights) = ([0.0; STAGES], [0.0; STAGES]);
        for j in 0..STAGES {
            // Newton's iteration from Tricomi's approximation of the roots, in ascending order.
            let mut y = -(std::f64::consts::PI * (j as f64 + 0.75) / (STAGES as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..8 {
                let p = legendre(y);
                slope = STAGES as f64 * (y * p[STAGES] - p[STAGES - 1]) / (y * y - 1.0);
                y -= p[STAGES] / slope;
            }
            nodes[j] = 0.5 * (1.0 + y);
            weights[j] = 1.0 / ((1.0 - y * y) * slope * slope);
        }
        let at_nodes = nodes.map(Values::at);
        let mut transform = [[0.0; STAGES]; STAGES];
        for (k, row) in transform.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = (2 * k + 1) as f64 * weights[j] * at_nodes[j].value[k];
            }
        }
        Self { nodes, weights, at_nodes, transform }
    }

    /// Coefficients of the polynomial through the values at the points; equal values give a constant to the last digit.
    pub(super) fn coefficients(&self, values: &Column) -> Column {
        if values.iter().all(|x| x == &values[0]) {
            let mut constant = [0.0; STAGES];
            constant[0] = values[0];
            return constant;
        }
        self.transform.map(|row| dot(&row, values))
    }
}

/// Σ a_k b_k.
pub(super) fn dot(a: &Column, b: &Column) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_reproduced_with_their_integrals() {
        // Coefficient k carries 2k + 1 roundings, 144 in all.
        let tolerance = 144.0 * f64::EPSILON;
        assert!((BASIS.weights.iter().sum::<f64>() - 1.0).abs() < tolerance);
        for degree in 0..STAGES as i32 {
            let coefficients = BASIS.coefficients(&BASIS.nodes.map(|x| x.powi(degree)));
            for x in [0.0, 0.013, 0.5, 0.77, 1.0_f64] {
                let at = Values::at(x);
                let n = f64::from(degree);
                for (found, exact) in [
                    (dot(&coefficients, &at.value), x.powi(degree)),
                    (dot(&coefficients, &at.first), x.powi(degree + 1) / (n + 1.0)),
                    (dot(&coefficients, &at.second), x.powi(degree + 2) / ((n + 1.0) * (n + 2.0))),
                ] {
                    assert!((found - exact).abs() < tolerance, "x^{degree} at {x}: {found} and {exact}");
                }
            }
        }
        // The rule is exact up to degree 2·12 − 1.
        for degree in 0..2 * STAGES as i32 {
            let sum: f64 = BASIS.nodes.iter().zip(BASIS.weights).map(|(x, w)| w * x.powi(degree)).sum();
            assert!((sum * f64::from(degree + 1) - 1.0).abs() < tolerance, "degree {degree}: {sum}");
        }
    }
}
