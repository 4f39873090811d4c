//! The convex programs of a cone problem in the form clarabel takes: min ½ xᵀPx + qᵀx, Ax + s = b, s ∈ cones.

use clarabel::algebra::CscMatrix;
use clarabel::solver::SupportedConeT::{self, NonnegativeConeT, SecondOrderConeT, ZeroConeT};
use clarabel::solver::{DefaultSettings, SolverStatus};

use crate::cone::cones::{Shape, blocks};
use crate::cone::{BlockMatrix, Cone, ConeProblem};
use crate::scalar::{Scalar, to_f64};

/// Where each contact's unknowns start: D of them, or r_N alone without friction.
#[derive(Debug, Clone, Default)]
pub(super) struct Unknowns {
    starts: Vec<usize>,
}

impl Unknowns {
    /// The unknowns r ∈ K of a problem: those fixed to 0 (r_T where μ = 0) are left out.
    pub(super) fn of<T: Scalar, const D: usize>(problem: &ConeProblem<T, D>) -> Self {
        let mut starts = vec![0];
        for &cone in problem.cones() {
            starts.push(starts[starts.len() - 1] + if rubs::<T, D>(cone) { D } else { 1 });
        }
        Self { starts }
    }

    /// Every component of every contact.
    pub(super) fn all<const D: usize>(contacts: usize) -> Self {
        Self { starts: (0..=contacts).map(|i| i * D).collect() }
    }

    /// The unknowns of a contact.
    pub(super) fn range(&self, contact: usize) -> std::ops::Range<usize> {
        self.starts[contact]..self.starts[contact + 1]
    }

    /// Number of unknowns.
    pub(super) fn len(&self) -> usize {
        self.starts[self.starts.len() - 1]
    }
}

/// A sparse matrix from (row, column, value), equal places added.
pub(super) fn sparse(rows: usize, columns: usize, entries: &[(usize, usize, f64)]) -> CscMatrix<f64> {
    let (mut i, mut j, mut v) = (Vec::new(), Vec::new(), Vec::new());
    for &(row, column, value) in entries {
        i.push(row);
        j.push(column);
        v.push(value);
    }
    CscMatrix::new_from_triplets(rows, columns, i, j, v)
}

/// Upper triangle of the symmetric part of W on the unknowns.
pub(super) fn symmetric_part<T: Scalar, const D: usize>(
    w: &BlockMatrix<T, D>,
    unknowns: &Unknowns,
) -> CscMatrix<f64> {
    let mut entries = Vec::new();
    for i in 0..w.rows() {
        for (j, block) in w.row(i) {
            for (r, row) in unknowns.range(i).enumerate() {
                for (c, column) in unknowns.range(j).enumerate() {
                    let value = to_f64(block[(r, c)]);
                    // Each entry is half of the symmetric pair; on the diagonal it is the pair itself.
                    let half = if row == column { value } else { 0.5 * value };
                    entries.push((row.min(column), row.max(column), half));
                }
            }
        }
    }
    sparse(unknowns.len(), unknowns.len(), &entries)
}

/// Whether anything but r_N can differ from 0.
fn rubs<T: Scalar, const D: usize>(cone: Cone<T>) -> bool {
    match Shape::of::<D>(cone) {
        Shape::Disc(friction) => friction > T::zero(),
        Shape::Blocks(coefficients) => coefficients.iter().any(|&c| c > T::zero()),
    }
}

/// The rows that say r_α ∈ K, s = −A r ∈ cones: r_N ≥ 0 without friction, μ r_N ± r_T ≥ 0 in the plane,
/// (μ r_N, r_T) in the second-order cone in space, and with rolling resistance (c_B r_N, r_B) for every block, r_B = 0 where
/// c_B = 0.
pub(super) fn coulomb_cones<T: Scalar, const D: usize>(
    problem: &ConeProblem<T, D>,
    unknowns: &Unknowns,
) -> (CscMatrix<f64>, Vec<SupportedConeT<f64>>) {
    let (mut entries, mut cones, mut row) = (Vec::new(), Vec::new(), 0);
    for (contact, &cone) in problem.cones().iter().enumerate() {
        let (first, mu) = (unknowns.range(contact).start, to_f64(cone.friction()));
        let size = unknowns.range(contact).len();
        if let (Shape::Blocks(coefficients), true) = (Shape::of::<D>(cone), size > 1) {
            for block in blocks::of::<T, D>(coefficients) {
                let (c, size) = (to_f64(block.coefficient), block.components().len());
                let radius = usize::from(c > 0.0);
                if c > 0.0 {
                    entries.push((row, first, -c));
                    cones.push(SecondOrderConeT(size + 1));
                } else {
                    cones.push(ZeroConeT(size));
                }
                entries
                    .extend(block.components().enumerate().map(|(k, d)| (row + radius + k, first + d, -1.0)));
                row += size + radius;
            }
            continue;
        }
        match size {
            1 => {
                entries.push((row, first, -1.0));
                cones.push(NonnegativeConeT(1));
            }
            2 => {
                entries.extend([(row, first, -mu), (row, first + 1, -1.0)]);
                entries.extend([(row + 1, first, -mu), (row + 1, first + 1, 1.0)]);
                cones.push(NonnegativeConeT(2));
            }
            _ => {
                entries.push((row, first, -mu));
                entries.extend((1..D).map(|d| (row + d, first + d, -1.0)));
                cones.push(SecondOrderConeT(D));
            }
        }
        row += size;
    }
    (sparse(row, unknowns.len(), &entries), cones)
}

/// Silent settings with one tolerance for gap and feasibility, and the structure left alone so that it can be
/// solved again with another q.
pub(super) fn settings(tolerance: f64, iterations: u32) -> DefaultSettings<f64> {
    DefaultSettings {
        verbose: false,
        max_iter: iterations,
        tol_gap_abs: tolerance,
        tol_gap_rel: tolerance,
        tol_feas: tolerance,
        presolve_enable: false,
        ..DefaultSettings::default()
    }
}

/// Whether the point clarabel stopped at is worth measuring.
pub(super) fn usable(status: SolverStatus) -> bool {
    use SolverStatus::{AlmostSolved, InsufficientProgress, MaxIterations, Solved};
    matches!(status, Solved | AlmostSolved | InsufficientProgress | MaxIterations)
}
