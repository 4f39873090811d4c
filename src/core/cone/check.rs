//! What makes (W, b, μ) a cone problem, and what is wrong where it is none.

use nalgebra::DMatrix;

use super::{BlockMatrix, ConeProblem};
use crate::scalar::{Scalar, all_finite, epsilon, lit, to_f64};

/// Why (W, b, μ) is not a cone problem.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProblemError {
    /// W, b and the cones do not have the same number of contacts.
    #[error("sizes differ: W has {rows} block rows, b {b} blocks, there are {cones} cones")]
    Sizes {
        /// Block rows of W.
        rows: usize,
        /// Blocks of b.
        b: usize,
        /// Cones.
        cones: usize,
    },
    /// A NaN or an infinity.
    #[error("{what} of contact {contact} is not finite")]
    NotFinite {
        /// `W`, `b` or `μ`.
        what: &'static str,
        /// Index of the contact.
        contact: usize,
    },
    /// μ < 0, or another coefficient of the cone.
    #[error("the coefficient of friction of contact {contact} is {value}, it must be ≥ 0")]
    NegativeFriction {
        /// Index of the contact.
        contact: usize,
        /// The value refused.
        value: f64,
    },
    /// A block column outside the matrix, or twice in a row.
    #[error("row {row} of W names block column {column} out of order, twice, or beyond {rows}")]
    Column {
        /// Block row.
        row: usize,
        /// Block column.
        column: usize,
        /// Number of block rows.
        rows: usize,
    },
    /// W_αα is absent or has no positive normal entry: nothing the contact touches can move.
    #[error("contact {contact} acts on nothing that can move: W_NN = {normal}")]
    NoMobility {
        /// Index of the contact.
        contact: usize,
        /// The normal entry of the diagonal block.
        normal: f64,
    },
    /// ‖W − Wᵀ‖ is not small against ‖W‖.
    #[error("W is not symmetric: blocks ({row}, {column}) differ by {difference} of the diagonal")]
    NotSymmetric {
        /// Block row.
        row: usize,
        /// Block column.
        column: usize,
        /// Largest difference over √(W_ii W_jj).
        difference: f64,
    },
    /// W has a negative eigenvalue.
    #[error("W is indefinite: smallest eigenvalue {smallest}, largest {largest}")]
    Indefinite {
        /// Smallest eigenvalue of the symmetric part (or of the offending 2×2 minor).
        smallest: f64,
        /// Largest eigenvalue.
        largest: f64,
    },
}

/// Asymmetry |W_ij − W_ji|/√(W_ii W_jj) that is taken for noise: published problems have up to 2e-2 in single entries
/// (2e-3 in the norm).
pub const SYMMETRY_TOLERANCE: f64 = 0.1;

/// Negative eigenvalues of W, relative to the largest, that are taken for noise.
pub const DEFINITENESS_TOLERANCE: f64 = 1e-2;

/// Up to this size (scalar rows) [`ConeProblem::new`] computes the spectrum of W; beyond, it tests 2×2 minors.
pub const SPECTRUM_LIMIT: usize = 192;

impl<T: Scalar, const D: usize> ConeProblem<T, D> {
    /// Checks sizes, finiteness, μ ≥ 0, the columns of W and its diagonal, in one pass without allocation.
    ///
    /// # Errors
    /// [`ProblemError::Sizes`], [`NotFinite`](ProblemError::NotFinite),
    /// [`NegativeFriction`](ProblemError::NegativeFriction), [`Column`](ProblemError::Column),
    /// [`NoMobility`](ProblemError::NoMobility).
    pub fn check(&self) -> Result<(), ProblemError> {
        const { assert!(matches!(D, 1 | 2 | 3 | 6), "the contact dimension is 1, 2, 3 or 6") };
        let rows = self.delassus().contacts();
        if rows != self.b().len() || rows != self.cones().len() {
            return Err(ProblemError::Sizes { rows, b: self.b().len(), cones: self.cones().len() });
        }
        for contact in 0..rows {
            let mut previous = None;
            let formed = self.delassus().formed().map(|w| w.row(contact));
            for (column, block) in formed.into_iter().flatten() {
                if column >= rows || previous.is_some_and(|p| p >= column) {
                    return Err(ProblemError::Column { row: contact, column, rows });
                }
                previous = Some(column);
                if !all_finite(block.iter()) {
                    return Err(ProblemError::NotFinite { what: "W", contact });
                }
            }
            if !all_finite(self.b()[contact].iter()) {
                return Err(ProblemError::NotFinite { what: "b", contact });
            }
            let coefficients = self.cones()[contact].coefficients();
            if !all_finite(&coefficients) {
                return Err(ProblemError::NotFinite { what: "μ", contact });
            }
            if let Some(&value) = coefficients.iter().find(|&&c| c < T::zero()) {
                return Err(ProblemError::NegativeFriction { contact, value: to_f64(value) });
            }
            let normal = self.delassus().diagonal(contact).map_or(T::zero(), |block| block[(0, 0)]);
            if normal <= T::zero() {
                return Err(ProblemError::NoMobility { contact, normal: to_f64(normal) });
            }
        }
        Ok(())
    }

    /// Checks that W is symmetric to [`SYMMETRY_TOLERANCE`] and positive semidefinite to
    /// [`DEFINITENESS_TOLERANCE`]: by its spectrum up
    /// to [`SPECTRUM_LIMIT`] scalar rows, by its 2×2 minors beyond.
    ///
    /// # Errors
    /// [`ProblemError::NotSymmetric`], [`ProblemError::Indefinite`].
    pub fn check_symmetric_semidefinite(&self) -> Result<(), ProblemError> {
        let (tolerance, negative) = (lit::<T>(SYMMETRY_TOLERANCE), lit::<T>(DEFINITENESS_TOLERANCE));
        let size = |row: usize, i: usize| self.diagonal(row)[(i, i)];
        let mut own = BlockMatrix::new();
        let w = self.delassus().form_in(&mut own);
        for row in 0..self.contacts() {
            for (column, block) in w.row(row) {
                let mirror = w.row(column).find(|&(j, _)| j == row).map(|(_, mirror)| mirror);
                let mut worst = T::zero();
                for i in 0..D {
                    for j in 0..D {
                        let (a, b) = (size(row, i), size(column, j));
                        if a < T::zero() || b < T::zero() {
                            let smallest = to_f64(if a < b { a } else { b });
                            return Err(ProblemError::Indefinite { smallest, largest: to_f64(a + b) });
                        }
                        let scale = nalgebra::ComplexField::sqrt(a * b);
                        let entry = block[(i, j)];
                        let difference = entry - mirror.map_or(T::zero(), |mirror| mirror[(j, i)]);
                        // A zero-mobility direction must decouple; rounding of its neighbours is let pass.
                        let floor = epsilon::<T>() * (a + b);
                        worst = worst.max(nalgebra::ComplexField::abs(difference) / (scale + floor));
                        if nalgebra::ComplexField::abs(entry) > scale * (T::one() + negative) + floor {
                            let centre = (a + b) * lit::<T>(0.5);
                            let radius = nalgebra::ComplexField::sqrt(
                                (a - b) * (a - b) * lit::<T>(0.25) + entry * entry,
                            );
                            let (smallest, largest) = (to_f64(centre - radius), to_f64(centre + radius));
                            return Err(ProblemError::Indefinite { smallest, largest });
                        }
                    }
                }
                if worst > tolerance {
                    let difference = to_f64(worst);
                    return Err(ProblemError::NotSymmetric { row, column, difference });
                }
            }
        }
        if self.contacts() * D <= SPECTRUM_LIMIT { self.check_spectrum(w) } else { Ok(()) }
    }

    fn check_spectrum(&self, w: &BlockMatrix<T, D>) -> Result<(), ProblemError> {
        let n = self.contacts() * D;
        if n == 0 {
            return Ok(());
        }
        // In f64 and scaled to a unit diagonal of W_NN: the eigensolver squares entries, which small or single
        // precision ones do not survive.
        let size = |row: usize| to_f64(nalgebra::ComplexField::sqrt(self.diagonal(row)[(0, 0)]));
        let mut dense = DMatrix::<f64>::zeros(n, n);
        for row in 0..self.contacts() {
            for (column, block) in w.row(row) {
                for (i, j) in (0..D).flat_map(|i| (0..D).map(move |j| (i, j))) {
                    let half = 0.5 * to_f64(block[(i, j)]) / (size(row) * size(column));
                    dense[(row * D + i, column * D + j)] += half;
                    dense[(column * D + j, row * D + i)] += half;
                }
            }
        }
        let eigenvalues = dense.symmetric_eigenvalues();
        let (smallest, largest) = (eigenvalues.min(), eigenvalues.max());
        // Written so that an eigensolver that gave up accuses nobody.
        if largest > 0.0 && smallest < -DEFINITENESS_TOLERANCE * largest {
            return Err(ProblemError::Indefinite { smallest, largest });
        }
        Ok(())
    }
}
