//! Islands: groups of contacts that W does not couple. Each is a cone problem of its own.
//!
//! Contacts share an island where a chain of blocks of W connects them: bodies in touch make one island, fixed obstacles
//! connect nothing. The solution of the whole problem is that of its islands, so that a difficult island costs no
//! iterations elsewhere, and one that is at rest costs a residual: where the percussions of the last step still solve it
//! they are kept, as every solver would keep them.

use nalgebra::SVector;

use crate::cone::{BlockMatrix, ConeProblem};
use crate::linalg::forest::{join, root};
use crate::scalar::{Scalar, lit};
use crate::solver::{Accuracy, ConeSolver, Solution, SolveError, solve_or_rescue};

/// Problems up to this many contacts are solved whole: to split them costs what it saves.
pub(super) const WORTH_SPLITTING: usize = 16;

/// Takes `older`, the percussions of the step before the last, for the start where they are nearer to a solution; whether
/// the start solves the problem as it is.
///
/// With e* = 1, Frémond's law at θ = ½, tangential velocities of sticking contacts alternate, and percussions with them:
/// those of two steps ago solve the problem where those of the last step are far off.
pub(super) fn choose_start<T: Scalar, const D: usize>(
    problem: &ConeProblem<T, D>,
    start: &mut [SVector<T, D>],
    older: &[SVector<T, D>],
    tolerance: T,
) -> bool {
    let last = problem.residual(start).scaled;
    // Written so that a NaN goes to the solver, which refuses it by name.
    if last <= tolerance || older.len() != start.len() {
        return last <= tolerance;
    }
    let before = problem.residual(older).scaled;
    if before < last * lit::<T>(0.5) {
        start.copy_from_slice(older);
        return before <= tolerance;
    }
    // At r = 0, where the scaled residual is at most 1, nothing is left of a bad start.
    if last > T::one() {
        start.fill(SVector::zeros());
    }
    false
}

/// The islands of a problem, and the buffers of one.
#[derive(Debug)]
pub(super) struct Islands<T: Scalar, const D: usize> {
    /// A contact of the same island, itself for the one that stands for it.
    parent: Vec<usize>,
    /// Contacts, island by island, and the ends of the islands.
    order: Vec<usize>,
    ends: Vec<usize>,
    /// Place of a contact in its island.
    place: Vec<usize>,
    problem: ConeProblem<T, D>,
    start: Vec<SVector<T, D>>,
    older: Vec<SVector<T, D>>,
    percussions: Vec<SVector<T, D>>,
}

impl<T: Scalar, const D: usize> Default for Islands<T, D> {
    fn default() -> Self {
        let (parent, order, ends, place) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let problem = ConeProblem::default();
        let (start, older, percussions) = (Vec::new(), Vec::new(), Vec::new());
        Self { parent, order, ends, place, problem, start, older, percussions }
    }
}

impl<T: Scalar, const D: usize> Islands<T, D> {
    /// Finds the islands of `w` and returns their number.
    pub(super) fn split(&mut self, w: &BlockMatrix<T, D>) -> usize {
        let contacts = w.rows();
        self.parent.clear();
        self.parent.extend(0..contacts);
        for i in 0..contacts {
            for (j, _) in w.row(i).take_while(|&(j, _)| j < i) {
                // The smallest contact stands for its island, so that islands come in the order of their contacts.
                join(&mut self.parent, i, j);
            }
        }
        for i in 0..contacts {
            self.parent[i] = root(&mut self.parent, i);
        }
        let Self { parent, order, ends, place, .. } = self;
        order.clear();
        order.extend(0..contacts);
        order.sort_unstable_by_key(|&contact| (parent[contact], contact));
        place.resize(contacts, 0);
        ends.clear();
        let mut first = 0;
        for (k, &contact) in order.iter().enumerate() {
            if k > 0 && parent[contact] != parent[order[k - 1]] {
                ends.push(k);
                first = k;
            }
            place[contact] = k - first;
        }
        ends.push(contacts);
        ends.len()
    }

    /// Solves the islands found by [`split`](Self::split) of `delassus`, the W of `whole`, one by one, from the percussions of the last step or the one
    /// before. Of their floors the largest is told.
    ///
    /// # Errors
    /// The number of contacts of the island that was not solved, and why.
    pub(super) fn solve(
        &mut self,
        (whole, delassus): (&ConeProblem<T, D>, &BlockMatrix<T, D>),
        starts: (&[SVector<T, D>], &[SVector<T, D>]),
        r: &mut [SVector<T, D>],
        solver: &mut dyn ConeSolver<T, D>,
    ) -> Result<Solution<T>, (usize, SolveError)> {
        self.problem.copy_masses_of(whole);
        let (mut iterations, mut first, mut worst, mut rescued_by) = (0, 0, None, None);
        for &end in &self.ends {
            let island = &self.order[first..end];
            let (w, b, cones) = self.problem.parts_mut();
            w.clear();
            b.clear();
            cones.clear();
            self.start.clear();
            self.older.clear();
            for &contact in island {
                w.start_row();
                delassus.row(contact).for_each(|(j, block)| w.push(self.place[j], *block));
                b.push(whole.b()[contact]);
                cones.push(whole.cones()[contact]);
                self.start.push(starts.0[contact]);
                self.older.extend(starts.1.get(contact));
            }
            self.problem.copy_rows(whole, island);
            let tolerance = solver.stopping().tolerance;
            let kept = choose_start(&self.problem, &mut self.start, &self.older, tolerance);
            self.percussions.clear();
            self.percussions.extend_from_slice(&self.start);
            if !kept {
                let starts = (&self.start[..], &self.older[..]);
                let solved = solve_or_rescue(solver, &self.problem, starts, &mut self.percussions);
                let solution = solved.map_err(|error| (island.len(), error))?;
                iterations += solution.iterations;
                rescued_by = rescued_by.or(solution.rescued_by);
                if let Accuracy::Rounding { floor } = solution.accuracy {
                    worst = Some(worst.map_or(floor, |worst: T| worst.max(floor)));
                }
            }
            for (&contact, &percussion) in island.iter().zip(&self.percussions) {
                r[contact] = percussion;
            }
            first = end;
        }
        let accuracy = worst.map_or(Accuracy::Tolerance, |floor| Accuracy::Rounding { floor });
        Ok(Solution { iterations, residual: whole.residual(r), accuracy, rescued_by })
    }
}
