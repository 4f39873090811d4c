//! One step of Gauss–Legendre collocation (Hairer, Nørsett & Wanner 1993, II.7, doi:10.1007/978-3-540-78862-1).
//!
//! The acceleration is the polynomial of degree 11 through its values at the 12 Gauss points, q and v are its integrals:
//! order 24 at the end of the step, and 13 of q at every time. The points are found by fixed-point sweeps (Picard). The
//! step is accepted where the last Legendre coefficients of the acceleration have decayed to the tolerance, so that the
//! polynomial is the motion to rounding; constant forces make it the exact parabola, for steps of any length.

use super::EventFailure;
use super::dynamics::{Equations, Held};
use super::legendre::{BASIS, Column, STAGES, dot};
use super::piece::{Piece, TOTALS, Totals};

/// Most sweeps of one step.
const SWEEPS: usize = 50;

/// A step that was tried.
pub(super) enum Tried {
    /// The piece, and the factor by which the next step may be longer.
    Accepted(Box<Piece>, f64),
    /// The factor by which the step must be shorter.
    Rejected(f64),
}

/// Tries a step of length `h` from (q, v) at `time`, with the tolerance on velocities relative to them or to `speed`.
pub(super) fn step<const D: usize>(
    dynamics: &mut Equations<D>,
    held: &[Held],
    (time, q, v): (f64, &[f64], &[f64]),
    totals: Totals,
    h: f64,
    (tolerance, speed): (f64, f64),
) -> Result<Tried, EventFailure> {
    let n = q.len();
    let basis = &*BASIS;
    let mut values = vec![[0.0; STAGES]; n];
    let mut rates = [[0.0; STAGES]; TOTALS];
    let mut acceleration = vec![[0.0; STAGES]; n];
    let (mut q_j, mut v_j) = (q.to_vec(), v.to_vec());
    let mut previous = f64::INFINITY;
    let heaviest = dynamics.weights.iter().fold(0.0_f64, |heaviest, w| heaviest.max(*w));
    let mut scale = 0.0_f64;
    for sweep in 0..SWEEPS {
        let mut change = 0.0_f64;
        let mut next = values.clone();
        for j in 0..STAGES {
            let at = &basis.at_nodes[j];
            for i in 0..n {
                v_j[i] = v[i] + h * dot(&acceleration[i], &at.first);
                q_j[i] = q[i] + (h * basis.nodes[j] * v[i] + h * h * dot(&acceleration[i], &at.second));
            }
            if !v_j.iter().chain(&q_j).all(|x| x.is_finite()) {
                return Ok(Tried::Rejected(0.1));
            }
            let found = dynamics.evaluate(time + h * basis.nodes[j], &q_j, &v_j, held)?;
            for (i, &a) in found.acceleration.iter().enumerate() {
                change = change.max(dynamics.weights[i] * (a - values[i][j]).abs());
                next[i][j] = a;
            }
            rates.iter_mut().zip(found.rates).for_each(|(rate, found)| rate[j] = found);
        }
        values = next;
        if !change.is_finite() {
            return Ok(Tried::Rejected(0.1));
        }
        acceleration.iter_mut().zip(&values).for_each(|(a, values)| *a = basis.coefficients(values));
        // Below the speed of the scene errors count in its units: what rests moves by rounding.
        scale = speed * heaviest;
        for (i, values) in values.iter().enumerate() {
            let largest = values.iter().fold(0.0_f64, |largest, a| largest.max(a.abs()));
            scale = scale.max(dynamics.weights[i] * v[i].abs().max(h * largest));
        }
        let left = h * change;
        // Rounding keeps the sweeps from ending at zero: they end where they no longer gain.
        if left <= f64::EPSILON * scale || (sweep > 2 && change > 0.5 * previous && left <= tolerance * scale)
        {
            break;
        }
        if sweep > 4 && change > 0.7 * previous || sweep + 1 == SWEEPS {
            return Ok(Tried::Rejected(0.4));
        }
        previous = change;
    }
    // What the polynomials leave out.
    let tail = |column: &Column| column[STAGES - 2].abs().max(column[STAGES - 1].abs());
    let mut missed = 0.0_f64;
    for (i, a) in acceleration.iter().enumerate() {
        missed = missed.max(h * dynamics.weights[i] * tail(a));
    }
    let rates = rates.map(|rate| basis.coefficients(&rate));
    let mut ratio = if missed > 0.0 { missed / (tolerance * scale) } else { 0.0 };
    for rate in &rates[2..] {
        let energy = 0.5 * scale * scale + h * rate.iter().fold(0.0_f64, |largest, r| largest.max(r.abs()));
        if energy > 0.0 {
            ratio = ratio.max(h * tail(rate) / (10.0 * tolerance * energy));
        }
    }
    let factor = 0.9 * ratio.max(1e-30).powf(-1.0 / STAGES as f64);
    if !(ratio <= 1.0) {
        return Ok(Tried::Rejected(factor.clamp(0.1, 0.8)));
    }
    let piece = Piece {
        start: time,
        end: time + h,
        span: h,
        q: q.to_vec(),
        v: v.to_vec(),
        acceleration,
        totals,
        rates,
    };
    Ok(Tried::Accepted(Box::new(piece), factor.clamp(0.5, 30.0)))
}
