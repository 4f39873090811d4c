//! The least solution of A x = b with A square, of full rank or not, by a complete orthogonal decomposition (Golub & Van
//! Loan 2013, §5.5.2): what the singular value decomposition gives, at a tenth of its cost.

use nalgebra::linalg::{ColPivQR, QR};
use nalgebra::{DMatrix, DVector, Dyn};

/// A P = Q R and, where the rank is not full, R₁ᵀ = Z U of the rows that are not zero.
#[derive(Debug)]
pub(super) struct LeastNorm {
    pivoted: ColPivQR<f64, Dyn, Dyn>,
    r: DMatrix<f64>,
    rank: usize,
    rows: Option<QR<f64, Dyn, Dyn>>,
}

impl LeastNorm {
    /// Decomposes `a`; rows of R below the share `redundant` of the first are those of redundant unknowns.
    pub(super) fn new(a: DMatrix<f64>, redundant: f64) -> Self {
        let n = a.nrows();
        let pivoted = a.col_piv_qr();
        let r = pivoted.r();
        let threshold = redundant * r[(0, 0)].abs();
        let rank = (0..n).take_while(|&i| r[(i, i)].abs() > threshold).count();
        let rows = (0 < rank && rank < n).then(|| r.rows(0, rank).transpose().qr());
        Self { pivoted, r, rank, rows }
    }

    /// Whether the solution is one of many.
    pub(super) fn redundant(&self) -> bool {
        self.rank < self.r.nrows()
    }

    /// The x of least norm among those with the least ‖A x − b‖.
    pub(super) fn solve(&self, mut b: DVector<f64>) -> Option<DVector<f64>> {
        self.pivoted.q_tr_mul(&mut b);
        let mut x = if self.rank == b.len() {
            self.r.solve_upper_triangular(&b)?
        } else if let Some(rows) = &self.rows {
            rows.q() * rows.r().tr_solve_upper_triangular(&b.rows(0, self.rank))?
        } else {
            DVector::zeros(b.len())
        };
        self.pivoted.p().inv_permute_rows(&mut x);
        Some(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_is_that_of_the_pseudo_inverse() {
        for (n, rank) in [(1, 1), (4, 4), (4, 3), (7, 2), (3, 0)] {
            let wave = |i: usize, j: usize, s: f64| (1.0 + s * (i * i + 3 * j) as f64 + (j * i) as f64).sin();
            let a = DMatrix::from_fn(n, rank, |i, j| wave(i, j, 0.3))
                * DMatrix::from_fn(rank, n, |i, j| wave(i, j, 0.7));
            let b = DVector::from_fn(n, |i, _| wave(i, 1, 0.9));
            let decomposed = LeastNorm::new(a.clone(), 1e-12);
            assert_eq!(decomposed.redundant(), rank < n);
            let x = decomposed.solve(b.clone()).expect("finite");
            let exact = a.pseudo_inverse(1e-10).expect("a tolerance") * b;
            assert!((&x - &exact).amax() <= 1e-10 * exact.amax(), "{n}, {rank}: {x} {exact}");
        }
    }
}
