//! From the active contacts to their percussions: W, b and the cones of (81), the start, the solution.

use std::iter::Peekable;

use nalgebra::SVector;

use super::active_set::ActiveSet;
use super::cones::Cones;
use super::equations::Equations;
use super::islands::{WORTH_SPLITTING, choose_start};
use super::matrix::Matrix;
use super::{ContactStep, StepError, ThetaScheme};
use crate::contact::{ContactId, pose};
use crate::laws::{Approach, Rows};
use crate::linalg::Factor;
use crate::scalar::{Scalar, lit};
use crate::solver::{Solution, solve_or_rescue};

/// Most that percussions are scaled by to start the next step with, where its length is another.
const MOST_GROWTH: f64 = 8.0;

impl<T: Scalar, const D: usize> ThetaScheme<T, D> {
    pub(super) fn set_cone_problem(&mut self) -> Result<(), StepError> {
        let (w, b, cones) = self.cones.problem.parts_mut();
        let Self {
            active: ActiveSet { jacobian, .. },
            matrix: Matrix { factor, .. },
            equations: Equations { joints, .. },
            ..
        } = self;
        match &mut self.matrix.kept {
            Some(kept) => {
                if self.cones.arms.rolls() {
                    kept.forget_selection();
                }
                if let Err(contact) = kept.select(&self.next.contacts, w) {
                    return Err(self.contact_error(contact, "place among the constant candidates"));
                }
            }
            None if joints.is_empty() => self.cones.assembler.assemble(jacobian, factor, w),
            None if jacobian.rows() == 0 => w.clear(),
            None => {
                self.cones.assembler.assemble_with(jacobian, |x: &mut [T]| joints.respond(factor, x), w);
            }
        }
        if self.cones.arms.rolls() {
            self.cones.arms.measure(&self.active.jacobian, w);
        }
        b.clear();
        cones.clear();
        self.warm.last.clear();
        self.warm.before.clear();
        // Percussions of a lasting contact grow with the step; those of an impact, made in a step of its own, do not.
        let growth = growth(self.warm.length, self.settings.step);
        let mut known = self.last.contacts.iter().peekable();
        let mut older = self.warm.contacts.iter().peekable();
        for (i, contact) in self.next.contacts.iter().enumerate() {
            let gap = self.lasting.as_ref().map_or_else(T::zero, |lasting| lasting.entries[i].gap);
            let approach = Approach::impact(contact.before, contact.theta);
            let memory = self.memories.of(contact.id, contact.interface);
            let approach = approach.with_gap(gap, self.settings.step, contact.lasting).with_memory(memory);
            let approach = if self.cones.arms.rolls() { approach.with_rows(Rows::Rolling) } else { approach };
            let free = self.active.jacobian.velocity(i, &self.next.v_free);
            match pose(&*self.laws[contact.interface], &approach, &free) {
                Ok((shifted, cone)) => {
                    b.push(self.cones.arms.enter_velocity(i, &shifted));
                    cones.push(cone.at_arm(self.cones.arms.length(i)));
                }
                Err(source) => {
                    let (step, time) = self.place();
                    let contact = self.system.contact_label(contact.id);
                    return Err(StepError::Law { step, time, contact, source });
                }
            }
            if self.equations.passes > 0 {
                self.warm.last.push(self.cones.arms.enter(i, &self.cones.percussions[i]));
                continue;
            }
            self.warm.last.push(self.cones.arms.enter(i, &(percussion_of(contact.id, &mut known) * growth)));
            self.warm
                .before
                .push(self.cones.arms.enter(i, &(percussion_of(contact.id, &mut older) * growth)));
        }
        Ok(())
    }

    pub(super) fn solve_cone_problem(&mut self) -> Result<Option<Solution<T>>, StepError> {
        let contacts = self.cones.problem.contacts();
        self.cones.percussions.clear();
        self.cones.percussions.resize(contacts, SVector::zeros());
        if contacts == 0 {
            return Ok(None);
        }
        let Self {
            cones: Cones { problem, islands, percussions, .. },
            solver,
            active: ActiveSet { jacobian, .. },
            matrix: Matrix { factor, .. },
            equations: Equations { joints, .. },
            ..
        } = self;
        let (warm_start, older) = (&mut self.warm.last, &self.warm.before);
        // Of bodies that nothing but contacts couples the solver may see H and M̂.
        let alone = joints.is_empty() && !self.cones.arms.rolls() && self.matrix.free == self.system.dofs();
        if let (Factor::Diagonal(inverse), true) = (&*factor, alone) {
            problem.copy_bodies(jacobian, inverse);
        }
        let worth = problem.delassus().formed().filter(|_| contacts > WORTH_SPLITTING);
        let solved = if let Some(w) = worth.filter(|w| islands.split(w) > 1) {
            islands.solve((problem, w), (warm_start, older), percussions, &mut **solver)
        } else {
            // A single contact is solved exactly from anywhere.
            if contacts > 1 {
                choose_start(problem, warm_start, older, solver.stopping().tolerance);
            }
            solve_or_rescue(&mut **solver, problem, (warm_start, older), percussions)
                .map_err(|source| (contacts, source))
        };
        self.cones.arms.leave(percussions);
        if let Some(lasting) = &mut self.lasting {
            lasting.note(problem, solver.stopping().tolerance);
        }
        solved.map(Some).map_err(|(contacts, source)| {
            let (step, time) = self.place();
            StepError::Solve { step, time, contacts, source }
        })
    }
}

/// Ratio of two lengths of steps, 1 where it is far from that.
fn growth<T: Scalar>(from: T, to: T) -> T {
    let ratio = to / from;
    if ratio <= lit(MOST_GROWTH) && ratio >= lit(1.0 / MOST_GROWTH) { ratio } else { T::one() }
}

/// The percussion of contact `id` in a list ordered by identity, found by walking along; zero where it is not there.
fn percussion_of<'a, T: Scalar, const D: usize>(
    id: ContactId,
    list: &mut Peekable<impl Iterator<Item = &'a ContactStep<T, D>>>,
) -> SVector<T, D> {
    while list.next_if(|old| old.id < id).is_some() {}
    list.next_if(|old| old.id == id).map_or_else(SVector::zeros, |old| old.percussion)
}
