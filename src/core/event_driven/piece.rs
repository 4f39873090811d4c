//! A smooth stretch of the motion: the collocation polynomial, which is its dense output.

use super::legendre::{Column, STAGES, Values, dot};

/// Quantities integrated along the motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Totals {
    /// Normal and tangential percussions of all contacts (N s): impulses of impacts, and of the forces between them.
    pub(super) percussion: [f64; 2],
    /// Work of F (J).
    pub(super) external: f64,
    /// Work of the damping (J).
    pub(super) damping: f64,
    /// Works of the contacts, normal and tangential (J).
    pub(super) contact: [f64; 2],
}

/// Number of totals.
pub(super) const TOTALS: usize = 6;

impl Totals {
    pub(super) fn to_array(self) -> [f64; TOTALS] {
        let Self { percussion: [a, b], external, damping, contact: [c, d] } = self;
        [a, b, external, damping, c, d]
    }

    pub(super) fn from_array([a, b, external, damping, c, d]: [f64; TOTALS]) -> Self {
        Self { percussion: [a, b], external, damping, contact: [c, d] }
    }
}

/// The motion over [start, end]: the acceleration is a polynomial of x = (t − start)/span, q and v are its integrals.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    pub(super) start: f64,
    /// Where the piece gives way to the next one, at or before start + span.
    pub(super) end: f64,
    pub(super) span: f64,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    /// Legendre coefficients of each component of the acceleration.
    pub(super) acceleration: Vec<Column>,
    pub(super) totals: Totals,
    /// Legendre coefficients of the rates of the totals.
    pub(super) rates: [Column; TOTALS],
}

impl Piece {
    /// A piece that stands still in (q, v), of no duration.
    pub(super) fn at_rest(start: f64, q: &[f64], v: &[f64], totals: Totals) -> Self {
        Self {
            start,
            end: start,
            span: 1.0,
            q: q.to_vec(),
            v: v.to_vec(),
            acceleration: vec![[0.0; STAGES]; q.len()],
            totals,
            rates: [[0.0; STAGES]; TOTALS],
        }
    }

    /// (q, v) at `tau` ≥ 0 after the start.
    pub(super) fn state(&self, tau: f64, q: &mut [f64], v: &mut [f64]) {
        let at = Values::at(tau / self.span);
        for (i, a) in self.acceleration.iter().enumerate() {
            v[i] = self.v[i] + self.span * dot(a, &at.first);
            q[i] = self.q[i] + (self.v[i] * tau + self.span * self.span * dot(a, &at.second));
        }
    }

    /// The totals at `tau` after the start.
    pub(super) fn totals(&self, tau: f64) -> Totals {
        let at = Values::at(tau / self.span);
        let mut totals = self.totals.to_array();
        totals
            .iter_mut()
            .zip(&self.rates)
            .for_each(|(total, rate)| *total += self.span * dot(rate, &at.first));
        Totals::from_array(totals)
    }

    /// Largest |q|, |v| that the piece may reach over `tau`, coarsely: the scale of its rounding.
    pub(super) fn reach(&self, tau: f64) -> (f64, f64) {
        let bound = |column: &Column| column.iter().map(|a| a.abs()).sum::<f64>();
        let (mut q, mut v) = (0.0_f64, 0.0_f64);
        for (i, a) in self.acceleration.iter().enumerate() {
            let a = bound(a);
            v = v.max(self.v[i].abs() + a * tau);
            q = q.max(self.q[i].abs() + self.v[i].abs() * tau + 0.5 * a * tau * tau);
        }
        (q, v)
    }
}
