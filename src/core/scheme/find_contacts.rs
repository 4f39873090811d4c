//! The active contacts of a step.

use super::active_set::ActiveSet;
use super::lasting::Pace;
use super::record::Next;
use super::{ActivationRule, ContactStep, StepError, ThetaScheme};
use crate::contact::Candidate;
use crate::scalar::{Scalar, all_finite};

impl<T: Scalar, const D: usize> ThetaScheme<T, D> {
    pub(super) fn find_active_contacts(&mut self) -> Result<(), StepError> {
        loop {
            self.list_active_contacts()?;
            let Self { rest, active: ActiveSet { jacobian, .. }, .. } = self;
            if !rest.as_mut().is_some_and(|rest| rest.wake(jacobian)) {
                break;
            }
        }
        let Self { lasting, settings, active: ActiveSet { jacobian, .. }, next, .. } = self;
        if let Some(lasting) = lasting {
            lasting.assign(settings.theta, jacobian, &mut next.contacts);
        }
        self.fly_again();
        Ok(())
    }

    fn list_active_contacts(&mut self) -> Result<(), StepError> {
        let h = self.settings.step;
        let (mut gap_tolerance, velocity_tolerance) = self.active.tolerances;
        let (mut reach, literal) = (gap_tolerance, gap_tolerance);
        if let Some(lasting) = &mut self.lasting {
            let Next { q, v, .. } = &mut self.next;
            if let Some(prescribed) = self.system.prescribed() {
                prescribed.set(self.state.time + h, h, self.settings.theta, q, v);
            }
            let (free, place) = (self.matrix.free, q.len() - (v.len() - self.matrix.free));
            lasting.clear([&self.state.v[free..], &v[free..], &q[place..]], h, velocity_tolerance);
            if self.settings.activation.gap_tolerance.is_none() {
                gap_tolerance = nalgebra::RealField::max(gap_tolerance, lasting.noise(h));
            }
            reach = gap_tolerance + lasting.reach();
        }
        let rule = self.settings.activation.rule;
        let ahead = self.ahead();
        self.active.candidates.clear();
        let Self {
            system,
            state,
            next: Next { place, scratch, .. },
            rest,
            flight,
            active: ActiveSet { candidates, crossed, .. },
            ..
        } = self;
        if rule == ActivationRule::CurrentGap {
            place.copy_from_slice(&state.q);
        } else {
            match flight {
                Some(flight) => flight.ahead(h, &state.v, scratch),
                None => scratch.iter_mut().zip(&state.v).for_each(|(s, &v)| *s = ahead * v),
            }
            system.advance(&state.q, scratch, place);
        }
        let asleep = rest.as_ref().map_or(&[][..], |rest| rest.asleep());
        match rest {
            Some(_) => system.awake_candidates(place, reach, asleep, candidates),
            None => system.candidates(place, reach, candidates),
        }
        crossed.find(&mut **system, &state.q, (ahead, &state.v), asleep, candidates);
        self.active.candidates.sort_unstable_by_key(|candidate| candidate.id);
        self.active.jacobian.clear();
        self.next.contacts.clear();
        let theta = self.settings.theta;
        let mut known = 0;
        for i in 0..self.active.candidates.len() {
            let Candidate { id, interface, gap } = self.active.candidates[i];
            if !all_finite([&gap]) {
                return Err(self.contact_error(id, "gap"));
            }
            if interface >= self.laws.len() {
                return Err(self.unknown(id, "interface", interface, self.laws.len()));
            }
            let row = self.active.jacobian.rows();
            let Next { scratch, place, .. } = &mut self.next;
            let place = self.active.crossed.place(id, &*self.system, (ahead, &self.state), (scratch, place));
            self.system.jacobian(id, place, &mut self.active.jacobian);
            let dofs = self.state.v.len();
            if let Some(column) = self.active.jacobian.largest_column(row).filter(|&column| column >= dofs) {
                return Err(self.unknown(id, "degree of freedom", column, dofs));
            }
            let before = self.active.jacobian.velocity(row, &self.state.v);
            if !all_finite(before.iter()) {
                return Err(self.contact_error(id, "Jacobian"));
            }
            let closing = before[0] <= velocity_tolerance;
            let mut lasts = false;
            let told = self.lasting.as_ref().is_some_and(|l| !l.may_last(&self.active.jacobian, row));
            if let (Some(lasting), true) = (&mut self.lasting, told) {
                // What speeds up or slows down as told is met as an impact, by the rule of the active set alone.
                if gap > literal || rule == ActivationRule::MoreauJean && !closing {
                    self.active.jacobian.truncate(row);
                    continue;
                }
                lasting.push(&self.active.jacobian, row, h, (id, T::zero()), Pace::Fast);
            } else if let Some(lasting) = &mut self.lasting {
                let last = &self.last.contacts;
                known += last[known..].iter().take_while(|contact| contact.id < id).count();
                let last = last.get(known).filter(|contact| contact.id == id);
                let carried = last.is_some_and(|contact| contact.percussion[0] > T::zero());
                let tolerances = (gap_tolerance, velocity_tolerance);
                let pace = lasting.pace(
                    (&self.active.jacobian, row),
                    h,
                    (id, carried),
                    (gap, before[0]),
                    tolerances,
                );
                // A contact that separates is no impact either: it may have to be kept from closing.
                lasts = pace == Pace::Lasting || !closing;
                if pace == Pace::Lasting || gap <= gap_tolerance {
                    let slow = pace != Pace::Fast;
                    // What is closed to the tolerance is closed: its rounding is no motion.
                    let q = self.flight.as_ref().map_or(&self.state.q, |flight| &flight.q);
                    let start = if slow { self.system.gap(id, q) } else { T::zero() };
                    let start = if start > gap_tolerance { start } else { T::zero() };
                    lasting.push(&self.active.jacobian, row, h, (id, start), pace);
                } else {
                    self.active.jacobian.truncate(row);
                    continue;
                }
            } else if rule == ActivationRule::MoreauJean && !closing {
                self.active.jacobian.truncate(row);
                continue;
            }
            let contact = ContactStep::starting(id, interface, (gap, before), (theta, lasts));
            self.next.contacts.push(contact);
        }
        Ok(())
    }
}
