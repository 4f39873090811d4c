//! The cone problem (W, b, μ), checked once, and the two residuals it is judged by.

use std::sync::OnceLock;

use nalgebra::{DMatrix, SVector};

use super::coulomb::{StatusCount, de_saxce, largest_eigenvalue, natural_map, status};
use super::product::Scratch;
use super::{BlockMatrix, FactoredDelassus, one_contact};
use crate::scalar::{Scalar, all_finite, epsilon, lit, to_f64};

/// Find r with w = W r + b and K* ∋ Φ(w) ⟂ r ∈ K, for contacts of dimension D.
///
/// W maps percussions (N s) to velocities (m/s); b is the free velocity shifted by the laws. W may be singular,
/// and slightly asymmetric (it is solved as given).
#[derive(Debug, Clone, PartialEq)]
pub struct ConeProblem<T: Scalar, const D: usize> {
    /// W block by block; where the problem holds H and M̂ instead, filled by the first who asks.
    delassus: OnceLock<BlockMatrix<T, D>>,
    factored: Option<FactoredDelassus<T, D>>,
    scratch: Scratch<T>,
    b: Vec<SVector<T, D>>,
    friction: Vec<T>,
}

/// Distance of a candidate r from a solution, in the two norms in use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual<T> {
    /// ‖r − proj_K(r − Φ(w))‖₂ / (1 + ‖b‖₂): the natural-map residual of the literature. It mixes impulses and
    /// velocities, so it changes with the units.
    pub natural: T,
    /// ‖ρ⁻¹(r − proj_K(r − ρ Φ(w)))‖₂ / ‖b‖₂ with ρ_α = 1/λ_max(W_αα): a velocity over a velocity, free of
    /// units. Solvers converge on this one.
    pub scaled: T,
}

/// Why (W, b, μ) is not a cone problem.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProblemError {
    /// W, b and μ do not have the same number of contacts.
    #[error("sizes differ: W has {rows} block rows, b {b} blocks, μ {friction} values")]
    Sizes {
        /// Block rows of W.
        rows: usize,
        /// Blocks of b.
        b: usize,
        /// Coefficients of friction.
        friction: usize,
    },
    /// A NaN or an infinity.
    #[error("{what} of contact {contact} is not finite")]
    NotFinite {
        /// `W`, `b` or `μ`.
        what: &'static str,
        /// Index of the contact.
        contact: usize,
    },
    /// μ < 0.
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

/// The form in which a problem given by H and M̂ holds W.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Form {
    /// Whichever has fewer unknowns: factored where there are fewer velocities than percussions (default).
    #[default]
    Auto,
    /// W block by block.
    Formed,
    /// H and M̂.
    Factored,
}

impl<T: Scalar, const D: usize> Default for ConeProblem<T, D> {
    fn default() -> Self {
        Self {
            delassus: BlockMatrix::new().into(),
            factored: None,
            scratch: Scratch::default(),
            b: Vec::new(),
            friction: Vec::new(),
        }
    }
}

impl<T: Scalar, const D: usize> ConeProblem<T, D> {
    /// A problem from data that are checked.
    ///
    /// # Errors
    /// Every [`ProblemError`].
    pub fn new(
        delassus: BlockMatrix<T, D>,
        b: Vec<SVector<T, D>>,
        friction: Vec<T>,
    ) -> Result<Self, ProblemError> {
        let problem =
            Self { delassus: delassus.into(), factored: None, scratch: Scratch::default(), b, friction };
        problem.check()?;
        problem.check_symmetric_semidefinite()?;
        Ok(problem)
    }

    /// A problem with W = H M̂⁻¹ Hᵀ in the given form: symmetric and positive semidefinite by construction.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn factored(
        delassus: FactoredDelassus<T, D>,
        form: Form,
        b: Vec<SVector<T, D>>,
        friction: Vec<T>,
    ) -> Result<Self, ProblemError> {
        let formed = match form {
            Form::Formed => true,
            Form::Factored => false,
            // A Newton step factors one matrix or the other.
            Form::Auto => delassus.nodes() * delassus.dofs() >= delassus.contacts() * D,
        };
        let problem = if formed {
            Self {
                delassus: delassus.form().into(),
                factored: None,
                scratch: Scratch::default(),
                b,
                friction,
            }
        } else {
            Self {
                delassus: OnceLock::new(),
                factored: Some(delassus),
                scratch: Scratch::default(),
                b,
                friction,
            }
        };
        problem.check()?;
        Ok(problem)
    }

    /// The problem in another arithmetic, with W formed; [`check`](Self::check) tells whether it still is one.
    pub fn cast<U: Scalar>(&self) -> ConeProblem<U, D> {
        ConeProblem {
            delassus: self.delassus().cast().into(),
            factored: None,
            scratch: Scratch::default(),
            b: self.b.iter().map(|b| b.map(|x| lit(to_f64(x)))).collect(),
            friction: self.friction.iter().map(|&x| lit(to_f64(x))).collect(),
        }
    }

    /// H and M̂, where the problem holds W in factored form. A solver that does not know it takes
    /// [`delassus`](Self::delassus), which forms W.
    pub fn factors(&self) -> Option<&FactoredDelassus<T, D>> {
        self.factored.as_ref()
    }

    /// Blocks of W, counted without forming it.
    pub fn delassus_blocks(&self) -> usize {
        match &self.factored {
            Some(factored) => factored.formed_blocks(),
            None => self.delassus().stored_blocks(),
        }
    }

    /// Number of contacts m.
    pub fn contacts(&self) -> usize {
        self.b.len()
    }

    /// W, block rows of D×D blocks. Where the problem holds H and M̂, the first call forms it.
    #[inline]
    pub fn delassus(&self) -> &BlockMatrix<T, D> {
        self.delassus
            .get_or_init(|| self.factored.as_ref().map_or_else(BlockMatrix::new, FactoredDelassus::form))
    }

    /// b, one block per contact, in the order (N, T1, T2).
    pub fn b(&self) -> &[SVector<T, D>] {
        &self.b
    }

    /// μ, one value per contact.
    pub fn friction(&self) -> &[T] {
        &self.friction
    }

    /// The parts, to refill them in place; [`check`](Self::check) tells whether they still are a problem.
    /// A problem in factored form becomes one with W formed.
    pub fn parts_mut(&mut self) -> (&mut BlockMatrix<T, D>, &mut Vec<SVector<T, D>>, &mut Vec<T>) {
        self.delassus();
        self.factored = None;
        let delassus = self.delassus.get_mut().expect("filled by the line above");
        (delassus, &mut self.b, &mut self.friction)
    }

    /// W_αα.
    ///
    /// # Panics
    /// If the block is absent, which [`check`](Self::check) excludes.
    #[inline]
    pub fn diagonal(&self, contact: usize) -> &nalgebra::SMatrix<T, D, D> {
        match &self.factored {
            Some(factored) => factored.diagonal(contact),
            None => self.delassus().diagonal(contact).expect("checked problems have every diagonal block"),
        }
    }

    /// (W r + b)_α.
    #[inline]
    pub fn shifted_velocity(&self, contact: usize, r: &[SVector<T, D>]) -> SVector<T, D> {
        self.delassus().row_product(contact, r) + self.b[contact]
    }

    /// Calls `visit` with every α and (W r + b)_α: W is not formed for it.
    fn visit_velocities(&self, r: &[SVector<T, D>], mut visit: impl FnMut(usize, SVector<T, D>)) {
        match &self.factored {
            Some(factored) => {
                let mut product = self.scratch.take();
                factored.velocities(r, &mut product);
                for (i, b) in self.b.iter().enumerate() {
                    visit(i, factored.jacobian.velocity(i, factored.dofs(), &product.velocities) + b);
                }
                self.scratch.give_back(product);
            }
            None => (0..r.len()).for_each(|i| visit(i, self.shifted_velocity(i, r))),
        }
    }

    /// ‖b‖₂.
    pub fn b_norm(&self) -> T {
        nalgebra::ComplexField::sqrt(self.b.iter().fold(T::zero(), |sum, b| sum + b.norm_squared()))
    }

    /// Whether r = 0 is a solution: every b_N ≥ 0.
    pub fn takes_off(&self) -> bool {
        self.b.iter().all(|b| b[0] >= T::zero())
    }

    /// Both residuals of `r`, measured on the problem.
    ///
    /// With b = 0 the scaled residual is 0 at r = 0 and infinite elsewhere.
    ///
    /// # Panics
    /// If `r` has not one block per contact.
    pub fn residual(&self, r: &[SVector<T, D>]) -> Residual<T> {
        assert_eq!(r.len(), self.contacts(), "one percussion per contact");
        let (mut natural, mut scaled) = (T::zero(), T::zero());
        self.visit_velocities(r, |i, w| {
            let phi = de_saxce(&w, self.friction[i]);
            natural += natural_map(&r[i], &phi, self.friction[i]).norm_squared();
            let size = largest_eigenvalue(self.diagonal(i));
            scaled += (natural_map(&r[i], &(phi / size), self.friction[i]) * size).norm_squared();
        });
        let (natural, scaled) = (nalgebra::ComplexField::sqrt(natural), nalgebra::ComplexField::sqrt(scaled));
        let b = self.b_norm();
        let scaled = if scaled == T::zero() { scaled } else { scaled / b };
        Residual { natural: natural / (T::one() + b), scaled }
    }

    /// The scaled residual alone, with `sizes` = λ_max(W_αα) at hand.
    pub(crate) fn scaled_residual(&self, r: &[SVector<T, D>], sizes: &[T]) -> T {
        let mut sum = T::zero();
        self.visit_velocities(r, |i, w| {
            let (mu, size) = (self.friction[i], sizes[i]);
            let phi = de_saxce(&w, mu);
            sum += (natural_map(&r[i], &(phi / size), mu) * size).norm_squared();
        });
        if sum == T::zero() { sum } else { nalgebra::ComplexField::sqrt(sum) / self.b_norm() }
    }

    /// Status of every contact in the solution `r`, with the boundary of the cone taken to `tolerance`.
    pub fn count_status(&self, r: &[SVector<T, D>], tolerance: T) -> StatusCount {
        let mut count = StatusCount::default();
        r.iter().zip(&self.friction).for_each(|(r, &mu)| count.add(status(r, mu, tolerance)));
        count
    }

    /// Checks sizes, finiteness, μ ≥ 0, the columns of W and its diagonal, in one pass without allocation.
    ///
    /// # Errors
    /// [`ProblemError::Sizes`], [`NotFinite`](ProblemError::NotFinite),
    /// [`NegativeFriction`](ProblemError::NegativeFriction), [`Column`](ProblemError::Column),
    /// [`NoMobility`](ProblemError::NoMobility).
    pub fn check(&self) -> Result<(), ProblemError> {
        const { assert!(1 <= D && D <= 3, "the contact dimension is 1, 2 or 3") };
        let rows = self.factored.as_ref().map_or_else(|| self.delassus().rows(), FactoredDelassus::contacts);
        if rows != self.b.len() || rows != self.friction.len() {
            return Err(ProblemError::Sizes { rows, b: self.b.len(), friction: self.friction.len() });
        }
        for contact in 0..rows {
            let mut previous = None;
            let formed = self.factored.is_none().then(|| self.delassus().row(contact));
            for (column, block) in formed.into_iter().flatten() {
                if column >= rows || previous.is_some_and(|p| p >= column) {
                    return Err(ProblemError::Column { row: contact, column, rows });
                }
                previous = Some(column);
                if !all_finite(block.iter()) {
                    return Err(ProblemError::NotFinite { what: "W", contact });
                }
            }
            if !all_finite(self.b[contact].iter()) {
                return Err(ProblemError::NotFinite { what: "b", contact });
            }
            let mu = self.friction[contact];
            if !all_finite([&mu]) {
                return Err(ProblemError::NotFinite { what: "μ", contact });
            }
            if mu < T::zero() {
                return Err(ProblemError::NegativeFriction { contact, value: to_f64(mu) });
            }
            let diagonal = match &self.factored {
                Some(factored) => Some(factored.diagonal(contact)),
                None => self.delassus().diagonal(contact),
            };
            let normal = diagonal.map_or(T::zero(), |block| block[(0, 0)]);
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
        for row in 0..self.contacts() {
            for (column, block) in self.delassus().row(row) {
                let mirror = self.delassus().row(column).find(|&(j, _)| j == row).map(|(_, mirror)| mirror);
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
        if self.contacts() * D <= SPECTRUM_LIMIT { self.check_spectrum() } else { Ok(()) }
    }

    fn check_spectrum(&self) -> Result<(), ProblemError> {
        let n = self.contacts() * D;
        if n == 0 {
            return Ok(());
        }
        // In f64 and scaled to a unit diagonal of W_NN: the eigensolver squares entries, which small or single
        // precision ones do not survive.
        let size = |row: usize| to_f64(nalgebra::ComplexField::sqrt(self.diagonal(row)[(0, 0)]));
        let mut dense = DMatrix::<f64>::zeros(n, n);
        for row in 0..self.contacts() {
            for (column, block) in self.delassus().row(row) {
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

    /// The exact solution of contact `contact` alone, the percussions of the others held at `r`.
    #[inline]
    pub fn solve_contact(&self, contact: usize, r: &[SVector<T, D>]) -> SVector<T, D> {
        let block = self.diagonal(contact);
        let local = self.shifted_velocity(contact, r) - block * r[contact];
        one_contact::solve_one_contact(block, &local, self.friction[contact])
    }
}
