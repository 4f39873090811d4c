//! The planar problem of the closed contacts as a linear complementarity problem, by Lemke's method.
//!
//! A cone solver iterates, and may stop early where contacts are redundant: their forces are then not unique and may be
//! large against what moves. In the plane the problem is w = M z + q with 0 ≤ w ⟂ z ≥ 0 (Stewart & Trinkle 1996,
//! doi:10.1002/(SICI)1097-0207(19960815)39:15<2673::AID-NME972>3.0.CO;2-I): p_T = β₊ − β₋ and
//!
//! ```text
//!   0 ≤ w_N ⟂ p_N ≥ 0,   0 ≤ λ ± w_T ⟂ β± ≥ 0,   0 ≤ μ p_N − β₊ − β₋ ⟂ λ ≥ 0
//! ```
//!
//! and p_T = −μ s p_N of a contact that slides in direction s leaves one row. Lemke's method goes from vertex to vertex;
//! with the lexicographic choice of the one that leaves it visits none twice, and ends, at a solution or at a ray
//! (Cottle, Pang & Stone 2009, §4.9, doi:10.1137/1.9780898719000).

use nalgebra::{DMatrix, DVector};

/// Entries of a tableau of numbers near 1 below this are rounding.
const ZERO: f64 = 1e-11;

/// z ≥ 0 with M z + q ≥ 0 and z ⟂ M z + q; `None` at a ray.
pub(super) fn lemke(m: &DMatrix<f64>, q: &DVector<f64>) -> Option<DVector<f64>> {
    let n = q.len();
    let mut z = DVector::zeros(n);
    if q.iter().all(|&q| q >= 0.0) {
        return Some(z);
    }
    // Columns: w, z, the artificial variable, the right-hand side.
    let (artificial, rhs) = (2 * n, 2 * n + 1);
    let mut tableau = DMatrix::zeros(n, 2 * n + 2);
    tableau.view_mut((0, 0), (n, n)).fill_with_identity();
    tableau.view_mut((0, n), (n, n)).copy_from(&-m);
    tableau.column_mut(artificial).fill(-1.0);
    tableau.column_mut(rhs).copy_from(q);
    let mut basis: Vec<usize> = (0..n).collect();
    // The row of the lexicographically least of (q, I).
    let mut row = (0..n).reduce(|a, b| if q[b] <= q[a] { b } else { a })?;
    let mut entering = artificial;
    for _ in 0..50 * n + 50 {
        let leaving = basis[row];
        let pivot = tableau[(row, entering)];
        tableau.row_mut(row).unscale_mut(pivot);
        let pivot_row = tableau.row(row).into_owned();
        for other in (0..n).filter(|&other| other != row) {
            let factor = tableau[(other, entering)];
            if factor != 0.0 {
                tableau.row_mut(other).iter_mut().zip(&pivot_row).for_each(|(x, p)| *x -= factor * p);
            }
        }
        basis[row] = entering;
        if leaving == artificial {
            basis.iter().enumerate().filter(|(_, v)| **v >= n).for_each(|(row, &v)| {
                z[v - n] = tableau[(row, rhs)].max(0.0);
            });
            return Some(z);
        }
        entering = if leaving < n { leaving + n } else { leaving - n };
        row = leaves(&tableau, &basis, entering)?;
    }
    None
}

/// The row of the lexicographically least ratio; among the least of the first ratios, the artificial variable's.
fn leaves(tableau: &DMatrix<f64>, basis: &[usize], entering: usize) -> Option<usize> {
    let n = basis.len();
    let (artificial, rhs) = (2 * n, 2 * n + 1);
    let mut rows: Vec<usize> = (0..n).filter(|&row| tableau[(row, entering)] > ZERO).collect();
    for column in std::iter::once(rhs).chain(0..n) {
        let ratio = |row: usize| tableau[(row, column)] / tableau[(row, entering)];
        let least = rows.iter().map(|&row| ratio(row)).fold(f64::INFINITY, f64::min);
        rows.retain(|&row| ratio(row) <= least + ZERO * (1.0 + least.abs()));
        if column == rhs
            && let Some(&row) = rows.iter().find(|&&row| basis[row] == artificial)
        {
            return Some(row);
        }
        if rows.len() <= 1 {
            break;
        }
    }
    rows.first().copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_are_solutions_and_a_ray_has_none() {
        // A ball pressed into a corner by two equal contacts on the left: the sum of their forces is 1, the floor's 2.
        let m = DMatrix::from_row_slice(3, 3, &[1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        let q = DVector::from_vec(vec![-1.0, -1.0, -2.0]);
        let z = lemke(&m, &q).expect("a solution");
        assert_eq!((z[0] + z[1], z[2]), (1.0, 2.0));
        // Nothing pushes back: w = −1 whatever z is.
        assert_eq!(lemke(&DMatrix::zeros(1, 1), &DVector::from_vec(vec![-1.0])), None);
        // Random symmetric positive semidefinite matrices of half rank, q in their range or above it.
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        for n in [2, 5, 10, 20] {
            let h = DMatrix::from_fn(n, n.div_ceil(2), |_, _| uniform());
            let q = &h * DVector::from_fn(n.div_ceil(2), |_, _| uniform());
            let m = &h * h.transpose();
            let z = lemke(&m, &q).expect("feasible");
            let w = &m * &z + &q;
            for (w, z) in w.iter().zip(&z) {
                assert!(*z >= 0.0 && *w >= -1e-10 && w.min(*z) < 1e-10, "{n}: w = {w}, z = {z}");
            }
        }
    }
}
