//! M̂ = M + hθC + h²θ²K, factored: for the length of the step in use, and for those used last.
//!
//! M̂ changes with h where there is C or K. A diagonal one is inverted anew; of the others the factors are kept, with W of
//! all candidates, so that a ladder of lengths is factored once.

use std::mem::swap;

use super::SetupError;
use super::kept::{ConstantRows, Kept, constant_rows};
use super::setup::Settings;
use crate::linalg::{Factor, FactorError, Symmetric};
use crate::scalar::{Scalar, all_finite, lit};
use crate::system::{Dynamics, Prescribed, System};

/// Which form of the step is solved, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    Increment,
    Average,
    /// The average, in two stages: contacts see the free velocity before the solve goes back through all unknowns,
    /// and their percussions join it there. One pair of triangular solves in all.
    Staged,
}

/// From this θ on the average is solved.
const AVERAGE_THETA: f64 = 0.25;

impl Form {
    pub(super) fn of<T: Scalar>(theta: T, has_stiffness: bool, factor: &Factor<T>, keeps: bool) -> Self {
        match factor {
            _ if !has_stiffness || theta < lit(AVERAGE_THETA) => Self::Increment,
            Factor::Sparse(_) if keeps => Self::Staged,
            _ => Self::Average,
        }
    }
}

/// What the step solves with.
#[derive(Debug)]
pub(super) struct Matrix<T: Scalar, const D: usize> {
    /// Factors of M̂ over the free degrees of freedom, the first `free` ones.
    pub(super) factor: Factor<T>,
    pub(super) free: usize,
    /// Entries (i, j, M̂_ij) between a free degree of freedom and a prescribed one that moves.
    pub(super) coupling: Vec<(usize, usize, T)>,
    pub(super) form: Form,
    /// W of all candidates, where H is constant.
    pub(super) kept: Option<Kept<T, D>>,
    lengths: Lengths<T, D>,
}

impl<T: Scalar, const D: usize> Matrix<T, D> {
    /// # Errors
    /// [`SetupError`]: M̂ not positive definite, H of a candidate not finite.
    pub(super) fn new(
        system: &mut dyn System<T, D>,
        settings: &Settings<T>,
        q: &[T],
    ) -> Result<Self, SetupError> {
        let free = system.prescribed().map_or(system.dofs(), |prescribed| prescribed.first());
        let constant = system.constant_jacobian() && system.joints().is_none();
        let rows = if constant { constant_rows(system, q)? } else { None };
        let (factor, kept, coupling) = factor(system, settings, free, rows)?;
        let form = Form::of(settings.theta, system.stiffness().is_some(), &factor, kept.is_some());
        Ok(Self { factor, free, coupling, form, kept, lengths: Lengths::default() })
    }

    /// Whether another length of step costs an inversion of a diagonal and no more.
    pub(super) fn is_cheap(&self) -> bool {
        self.kept.is_none() && matches!(self.factor, Factor::Diagonal(_))
    }

    /// Factorisations that changes of the step have cost so far.
    pub(super) fn factorisations(&self) -> usize {
        self.lengths.factored
    }

    /// Makes M̂ that of another length of step, `settings.step`; `length` is that of the one at hand.
    ///
    /// # Errors
    /// [`SetupError`]; M̂ is then as it was.
    pub(super) fn refactor(
        &mut self,
        system: &mut dyn System<T, D>,
        settings: &Settings<T>,
        q: &[T],
        length: T,
    ) -> Result<(), SetupError> {
        if self.is_cheap() {
            return self.invert_diagonal(system, settings).map_err(SetupError::IterationMatrix);
        }
        self.lengths.changes += 1;
        let place = self.lengths.others.iter().position(|other| other.step == settings.step);
        let mut other = match place {
            Some(place) => self.lengths.others.swap_remove(place),
            None => self.factored(system, settings, q)?,
        };
        swap(&mut self.factor, &mut other.factor);
        swap(&mut self.kept, &mut other.kept);
        swap(&mut self.coupling, &mut other.coupling);
        if let Some(kept) = &mut self.kept {
            kept.forget_selection();
        }
        (other.step, other.used) = (length, self.lengths.changes);
        let others = &mut self.lengths.others;
        let numbers = |others: &[Factored<T, D>]| others.iter().map(Factored::numbers).sum::<usize>();
        while others.len() >= MOST_LENGTHS || (others.len() > 3 && numbers(others) > MOST_NUMBERS) {
            let oldest = (0..others.len()).min_by_key(|&i| others[i].used);
            oldest.map(|oldest| others.swap_remove(oldest));
        }
        others.push(other);
        Ok(())
    }

    fn factored(
        &mut self,
        system: &mut dyn System<T, D>,
        settings: &Settings<T>,
        q: &[T],
    ) -> Result<Factored<T, D>, SetupError> {
        self.lengths.factored += 1;
        let rows = if self.kept.is_some() { constant_rows(system, q)? } else { None };
        let (factor, kept, coupling) = factor(system, settings, self.free, rows)?;
        Ok(Factored { step: settings.step, used: 0, factor, kept, coupling })
    }

    /// M̂⁻¹ of diagonal M, C and K, in place.
    fn invert_diagonal(
        &mut self,
        system: &dyn System<T, D>,
        settings: &Settings<T>,
    ) -> Result<(), FactorError> {
        let weight = settings.step * settings.theta;
        let entry = |operator: Option<&Symmetric<T>>, i: usize| match operator {
            Some(Symmetric::Diagonal(diagonal)) => diagonal[i],
            _ => T::zero(),
        };
        let pivot = |i: usize| {
            let (mass, damping) = (entry(Some(system.mass()), i), entry(system.damping(), i));
            mass + weight * damping + weight * weight * entry(system.stiffness(), i)
        };
        let sound = |x: T| x > T::zero() && all_finite(&[x, T::one() / x]);
        if let Some(pivot) = (0..self.free).find(|&i| !sound(pivot(i))) {
            return Err(FactorError::NotPositiveDefinite { pivot });
        }
        if let Factor::Diagonal(inverse) = &mut self.factor {
            inverse.iter_mut().enumerate().for_each(|(i, x)| *x = T::one() / pivot(i));
        }
        Ok(())
    }
}

/// M̂ factored, W of all candidates, and the entries that couple free degrees of freedom to prescribed ones.
type Parts<T, const D: usize> = (Factor<T>, Option<Kept<T, D>>, Vec<(usize, usize, T)>);

fn factor<T: Scalar, const D: usize>(
    system: &dyn System<T, D>,
    settings: &Settings<T>,
    free: usize,
    rows: Option<ConstantRows<T, D>>,
) -> Result<Parts<T, D>, SetupError> {
    let matrix = iteration_matrix(system, settings);
    let coupling = coupling(system, &matrix, free);
    let matrix = if free < system.dofs() { matrix.leading(free) } else { matrix };
    let last = rows.as_ref().map(|rows| rows.dofs(free)).unwrap_or_default();
    let mut factor = Factor::with_last(&matrix, &last).map_err(SetupError::IterationMatrix)?;
    let kept = rows.map(|rows| rows.delassus(&mut factor, free));
    Ok((factor, kept, coupling))
}

/// M̂ = M + hθC + h²θ²K.
fn iteration_matrix<T: Scalar>(system: &dyn Dynamics<T>, settings: &Settings<T>) -> Symmetric<T> {
    let weight = settings.step * settings.theta;
    let mut matrix = system.mass().clone();
    if let Some(damping) = system.damping() {
        matrix = matrix.plus(weight, damping);
    }
    if let Some(stiffness) = system.stiffness() {
        matrix = matrix.plus(weight * weight, stiffness);
    }
    matrix
}

/// Entries of M̂ between free degrees of freedom and prescribed ones; none where nothing prescribed moves.
fn coupling<T: Scalar>(
    system: &dyn Dynamics<T>,
    matrix: &Symmetric<T>,
    free: usize,
) -> Vec<(usize, usize, T)> {
    if !system.prescribed().is_some_and(Prescribed::moves) {
        return Vec::new();
    }
    matrix.entries().filter(|&(i, j, m)| i < free && j >= free && m != T::zero()).collect()
}

/// Lengths of steps whose factors are kept.
const MOST_LENGTHS: usize = 64;

/// Numbers they may have in all, L and W counted (256 MiB in double precision); three lengths are kept in any case.
const MOST_NUMBERS: usize = 1 << 25;

/// M̂ of one length of step, factored.
#[derive(Debug)]
struct Factored<T: Scalar, const D: usize> {
    step: T,
    used: u64,
    factor: Factor<T>,
    kept: Option<Kept<T, D>>,
    coupling: Vec<(usize, usize, T)>,
}

impl<T: Scalar, const D: usize> Factored<T, D> {
    fn numbers(&self) -> usize {
        let n = self.factor.size();
        let factor = match &self.factor {
            Factor::Diagonal(_) => n,
            Factor::Dense(_) => n * n,
            Factor::Sparse(factor) => factor.entries(),
        };
        factor + self.kept.as_ref().map_or(0, Kept::numbers)
    }
}

/// The factors of the lengths used, but the one in use.
#[derive(Debug)]
pub(super) struct Lengths<T: Scalar, const D: usize> {
    others: Vec<Factored<T, D>>,
    /// Changes of length so far, to see which was used last.
    changes: u64,
    /// Factorisations made since the scheme was set up.
    factored: usize,
}

impl<T: Scalar, const D: usize> Default for Lengths<T, D> {
    fn default() -> Self {
        Self { others: Vec::new(), changes: 0, factored: 0 }
    }
}
