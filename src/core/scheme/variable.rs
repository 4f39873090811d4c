//! Steps of changing length: M̂ and W for each, and the way back from a step that is not kept.
//!
//! M̂ = M + hθC + h²θ²K changes with h where there is C or K. A diagonal one is inverted anew; of the others the factors
//! are kept, with W of all candidates, for the lengths used last, so that a ladder of lengths is factored once.

use std::mem::swap;

use super::clock::Clock;
use super::kept::{Kept, constant_rows};
use super::memory::Memories;
use super::setup::{check_settings, coupling, iteration_matrix};
use super::{ContactStep, SetupError, ThetaScheme};
use crate::contact::Candidate;
use crate::energy::{Balance, Energies};
use crate::linalg::{Factor, FactorError, Symmetric};
use crate::scalar::{Scalar, all_finite};
use crate::solver::Solution;
use crate::system::{Prescribed, Scales};

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

/// A state with all that the next step depends on.
#[derive(Debug)]
pub(crate) struct Saved<T: Scalar, const D: usize> {
    pub(crate) q: Vec<T>,
    pub(crate) v: Vec<T>,
    momentum: Vec<T>,
    elastic_force: Vec<T>,
    pub(crate) contacts: Vec<ContactStep<T, D>>,
    older: Vec<ContactStep<T, D>>,
    energies: Energies<T>,
    balance: Balance<T>,
    solution: Option<Solution<T>>,
    memories: Memories<T>,
    length: T,
    clock: Clock<T>,
}

impl<T: Scalar, const D: usize> Saved<T, D> {
    /// Time (s).
    pub(crate) fn time(&self) -> T {
        self.clock.origin
    }
}

impl<T: Scalar, const D: usize> ThetaScheme<T, D> {
    /// Gives the steps from here on the length `step` (s). Nothing else changes: θ, laws, active set and state stay.
    ///
    /// M̂ is factored where it depends on h and `step` is not one of the lengths used last, 64 of them at most.
    ///
    /// # Errors
    /// [`SetupError`]: h not finite or ≤ 0, M̂ not positive definite; displacements that move, whose states q_k depend
    /// on h; bodies that may sleep. The length is then as it was.
    pub fn set_step(&mut self, step: T) -> Result<(), SetupError> {
        if self.system.prescribed().is_some_and(Prescribed::moves) {
            return Err(SetupError::MovingStep);
        }
        if self.rest.is_some() {
            return Err(SetupError::SleepingStep);
        }
        if step == self.settings.step {
            return Ok(());
        }
        let settings = super::Settings { step, ..self.settings };
        check_settings(&settings)?;
        if self.system.stiffness().is_some() || self.system.damping().is_some() {
            self.refactor(&settings)?;
        }
        self.clock = self.clock.moved(self.state.index, self.settings.step);
        self.settings.step = step;
        Ok(())
    }

    fn refactor(&mut self, settings: &super::Settings<T>) -> Result<(), SetupError> {
        if self.kept.is_none() && matches!(self.factor, Factor::Diagonal(_)) {
            return self.invert_diagonal(settings).map_err(SetupError::IterationMatrix);
        }
        self.lengths.changes += 1;
        let place = self.lengths.others.iter().position(|other| other.step == settings.step);
        let mut other = match place {
            Some(place) => self.lengths.others.swap_remove(place),
            None => self.factored(settings)?,
        };
        swap(&mut self.factor, &mut other.factor);
        swap(&mut self.kept, &mut other.kept);
        swap(&mut self.coupling, &mut other.coupling);
        if let Some(kept) = &mut self.kept {
            kept.forget_selection();
        }
        (other.step, other.used) = (self.settings.step, self.lengths.changes);
        let others = &mut self.lengths.others;
        let numbers = |others: &[Factored<T, D>]| others.iter().map(Factored::numbers).sum::<usize>();
        while others.len() >= MOST_LENGTHS || (others.len() > 3 && numbers(others) > MOST_NUMBERS) {
            let oldest = (0..others.len()).min_by_key(|&i| others[i].used);
            oldest.map(|oldest| others.swap_remove(oldest));
        }
        others.push(other);
        Ok(())
    }

    fn factored(&mut self, settings: &super::Settings<T>) -> Result<Factored<T, D>, SetupError> {
        self.lengths.factored += 1;
        let Self { system, free, state, .. } = self;
        let matrix = iteration_matrix(&**system, settings);
        let coupling = coupling(&**system, &matrix, *free);
        let matrix = if *free < system.dofs() { matrix.leading(*free) } else { matrix };
        let rows = if self.kept.is_some() { constant_rows(&mut **system, &state.q)? } else { None };
        let last = rows.as_ref().map(|rows| rows.dofs(*free)).unwrap_or_default();
        let mut factor = Factor::with_last(&matrix, &last).map_err(SetupError::IterationMatrix)?;
        let kept = rows.map(|rows| rows.delassus(&mut factor, *free));
        Ok(Factored { step: settings.step, used: 0, factor, kept, coupling })
    }

    /// M̂⁻¹ of diagonal M, C and K, in place.
    fn invert_diagonal(&mut self, settings: &super::Settings<T>) -> Result<(), FactorError> {
        let Self { system, factor, free, .. } = self;
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
        if let Some(pivot) = (0..*free).find(|&i| !sound(pivot(i))) {
            return Err(FactorError::NotPositiveDefinite { pivot });
        }
        if let Factor::Diagonal(inverse) = factor {
            inverse.iter_mut().enumerate().for_each(|(i, x)| *x = T::one() / pivot(i));
        }
        Ok(())
    }

    /// Factorisations that changes of the step have cost so far.
    pub fn factorisations(&self) -> usize {
        self.lengths.factored
    }

    /// Whether a new length costs a factorisation.
    pub(crate) fn factors_lengths(&self) -> bool {
        let varies = self.system.stiffness().is_some() || self.system.damping().is_some();
        varies && !(self.kept.is_none() && matches!(self.factor, Factor::Diagonal(_)))
    }

    /// t − t_k, without the rounding of t_k.
    pub(crate) fn until(&self, time: T) -> T {
        self.clock.until(time, self.state.index, self.settings.step)
    }

    /// The length and the speed that the scene had at its start.
    pub(crate) fn scales(&self) -> Scales<T> {
        self.scales
    }

    /// Tolerances (gap, velocity) of the active set.
    pub(crate) fn tolerances(&self) -> (T, T) {
        self.tolerances
    }

    pub(crate) fn set_tolerances(&mut self, tolerances: (T, T)) {
        self.tolerances = tolerances;
    }

    /// A place to save states in.
    pub(crate) fn saved(&self) -> Saved<T, D> {
        Saved {
            q: self.state.q.clone(),
            v: self.state.v.clone(),
            momentum: self.next.momentum[0].clone(),
            elastic_force: self.next.elastic_force[0].clone(),
            contacts: self.last.contacts.clone(),
            older: self.older.clone(),
            energies: self.last.energies,
            balance: self.last.balance,
            solution: self.last.solution,
            memories: self.memories.clone(),
            length: self.last_length,
            clock: self.clock.moved(self.state.index, self.settings.step),
        }
    }

    pub(crate) fn save(&self, saved: &mut Saved<T, D>) {
        saved.q.copy_from_slice(&self.state.q);
        saved.v.copy_from_slice(&self.state.v);
        saved.momentum.copy_from_slice(&self.next.momentum[0]);
        if self.system.stiffness().is_some() {
            saved.elastic_force.copy_from_slice(&self.next.elastic_force[0]);
        }
        saved.contacts.clone_from(&self.last.contacts);
        saved.older.clone_from(&self.older);
        (saved.energies, saved.balance, saved.solution) =
            (self.last.energies, self.last.balance, self.last.solution);
        saved.memories.copy_from(&self.memories);
        saved.length = self.last_length;
        saved.clock = self.clock.moved(self.state.index, self.settings.step);
    }

    /// Goes back to a state saved; the length of the steps stays.
    pub(crate) fn recall(&mut self, saved: &Saved<T, D>) {
        self.state.q.copy_from_slice(&saved.q);
        self.state.v.copy_from_slice(&saved.v);
        self.next.momentum[0].copy_from_slice(&saved.momentum);
        if self.system.stiffness().is_some() {
            self.next.elastic_force[0].copy_from_slice(&saved.elastic_force);
        }
        if let (Some(nonlinear), Some(dynamics)) = (&mut self.nonlinear, self.system.nonlinear()) {
            nonlinear.start_from(dynamics, &saved.q);
        }
        self.last.contacts.clone_from(&saved.contacts);
        self.older.clone_from(&saved.older);
        (self.last.energies, self.last.balance, self.last.solution) =
            (saved.energies, saved.balance, saved.solution);
        self.memories.copy_from(&saved.memories);
        self.last_length = saved.length;
        self.clock = saved.clock;
        (self.state.index, self.state.time) = (saved.clock.index, saved.clock.origin);
    }

    /// forces ← M̂⁻¹ forces: accelerations, but for h.
    pub(crate) fn accelerate(&mut self, forces: &mut [T]) {
        self.factor.solve_in_place(&mut forces[..self.free]);
        forces[self.free..].fill(T::zero());
    }

    /// Candidates with gap ≤ `reach` in configuration q.
    pub(crate) fn candidates_at(&mut self, q: &[T], reach: T, out: &mut Vec<Candidate<T>>) {
        out.clear();
        self.system.candidates(q, reach, out);
    }

    /// u_N = H_N(q) v of a contact.
    pub(crate) fn gap_rate(&mut self, contact: crate::contact::ContactId, q: &[T], v: &[T]) -> T {
        self.jacobian.clear();
        self.system.jacobian(contact, q, &mut self.jacobian);
        self.jacobian.velocity(0, v)[0]
    }
}
