//! What happens at an event: impacts, and the modes of the contacts that stay closed.

use nalgebra::{DVector, SVector};

use super::dynamics::{Held, references};
use super::integrate::Integrator;
use super::local::{Local, Solved};
use super::{ContactImpact, EventFailure, ImpactEvent, Mode, ModeChange};
use crate::contact::{ContactId, pose};
use crate::laws::Approach;
use crate::linalg::{axpy, max_abs};

/// θ = ½ is the continuous law: (35) for Newton's, Ξ (45–46) for Frémond's.
const THETA: f64 = 0.5;

/// Most events at one time that are neither impacts nor progress.
const MOST_AT_ONCE: usize = 14;

/// (N, T).
fn pair<const D: usize>(x: &SVector<f64, D>) -> [f64; 2] {
    [x[0], if D == 2 { x[D - 1] } else { 0.0 }]
}

impl<const D: usize> Integrator<'_, D> {
    /// The closed contacts: those within the tolerance, and the one that has just closed.
    fn closed(&mut self, closing: Option<ContactId>) -> Result<Vec<Held>, EventFailure> {
        let tolerance = self.settings.gap_tolerance * self.length;
        let mut closed = Vec::new();
        for candidate in self.dynamics.candidates(&self.q, f64::INFINITY)? {
            if candidate.gap <= tolerance || Some(candidate.id) == closing {
                let (id, interface) = (candidate.id, candidate.interface);
                closed.push(Held { id, interface, friction: 0.0, mode: Mode::Open, reference: [0.0; 2] });
            }
        }
        for held in &mut closed {
            let known = self.laws.len();
            let law = self.laws.get(held.interface);
            let law =
                law.ok_or(EventFailure::Size { what: "laws", given: known, expected: held.interface + 1 })?;
            held.friction = law.respond(&Approach::impact(SVector::zeros(), THETA)).cone.friction();
        }
        Ok(closed)
    }

    fn velocities(&mut self, contacts: &[Held]) -> Vec<SVector<f64, D>> {
        contacts.iter().map(|held| self.dynamics.velocity(held.id, &self.q, &self.v)).collect()
    }

    /// Impacts until no closed contact approaches, then the modes of those that stay.
    pub(super) fn settle(&mut self, closing: Option<ContactId>) -> Result<(), EventFailure> {
        loop {
            self.count_event()?;
            self.speed = self.speed.max(max_abs(&self.v));
            let tolerance = self.settings.speed_tolerance * self.speed;
            let closed = self.closed(closing)?;
            let u = self.velocities(&closed);
            if u.iter().any(|u| u[0] < -tolerance) {
                self.impact(&closed, &u, false)?;
                continue;
            }
            let touching = closed.iter().zip(&u).filter(|(_, u)| u[0] <= tolerance);
            let (mut held, u): (Vec<Held>, Vec<SVector<f64, D>>) =
                touching.map(|(&held, &u)| (held, u)).unzip();
            // What slips no faster than rounding does not slip.
            let slip: Vec<Option<f64>> = u
                .iter()
                .map(|u| (D == 2 && u[D - 1].abs() > 10.0 * tolerance).then(|| u[D - 1].signum()))
                .collect();
            let Some((forces, modes)) = self.modes(&held, &slip)? else {
                let u = self.velocities(&closed);
                self.impact(&closed, &u, true)?;
                continue;
            };
            held.iter_mut().zip(modes).for_each(|(held, mode)| held.mode = mode);
            held.iter_mut().zip(&forces).for_each(|(held, p)| held.reference = pair(p));
            // A contact that opens, but approaches by rounding, does not approach.
            let approaching = held.iter().zip(&u).filter(|(held, u)| held.mode != Mode::Open || u[0] < 0.0);
            // One that begins to slide, but slips the other way by rounding, does not slip yet.
            let corrected = approaching.map(|(&held, u)| {
                let against =
                    matches!(held.mode, Mode::Slide(s) if held.friction > 0.0 && s * u[D - 1] < 0.0);
                if against { Held { mode: Mode::Stick, ..held } } else { held }
            });
            let corrected: Vec<Held> = corrected.collect();
            let (mut held, slip): (Vec<Held>, Vec<Option<f64>>) =
                held.into_iter().zip(slip).filter(|(held, _)| held.mode != Mode::Open).unzip();
            self.share(&mut held, &slip)?;
            self.record_changes(&held);
            self.held = held;
            self.settled = self.time;
            return self.project(&corrected);
        }
    }

    fn count_event(&mut self) -> Result<(), EventFailure> {
        self.events += 1;
        if self.events > self.settings.max_events {
            return Err(EventFailure::TooMany { limit: self.settings.max_events });
        }
        if self.stalled > MOST_AT_ONCE {
            return Err(EventFailure::Stalled { count: self.stalled });
        }
        Ok(())
    }

    /// The impact of all closed contacts: v⁺ = v⁻ + M⁻¹Hᵀp with w = W p + u⁻ + δ, K* ∋ Φ(w) ⟂ p ∈ K. An impact without
    /// collision is that of contacts which an infinitesimal approach is added to.
    fn impact(
        &mut self,
        closed: &[Held],
        before: &[SVector<f64, D>],
        without_collision: bool,
    ) -> Result<(), EventFailure> {
        let frame = self.dynamics.frame(closed.iter().map(|held| held.id), &self.q)?;
        let mut b = DVector::zeros(closed.len() * D);
        let mut friction = Vec::with_capacity(closed.len());
        for (i, (held, u)) in closed.iter().zip(before).enumerate() {
            let (shifted, cone) = pose(&*self.laws[held.interface], &Approach::impact(*u, THETA), u)?;
            b.rows_mut(i * D, D).copy_from(&shifted);
            friction.push(cone.friction());
        }
        let mut local = Local::<D> { w: frame.w, b, friction };
        let slip = vec![None; closed.len()];
        let inconsistent = EventFailure::Inconsistent { contacts: closed.len() };
        let p = if without_collision {
            let exact = local.b.clone();
            // The approach that the forces make in a short time is one that bodies which wedge each other can have.
            let (free, ..) = self.dynamics.contact_accelerations(self.time, &self.q, &self.v, closed)?;
            let least = (0..closed.len()).map(|i| free.b[i * D]).fold(0.0, f64::min);
            let time = if least < 0.0 { 1e-6 * self.speed / -least } else { 0.0 };
            local.b.axpy(time, &free.b, 1.0);
            let Some((p, modes)) = local.solve(&mut *self.solver, &slip)? else { return Err(inconsistent) };
            local.b = exact;
            local.with_modes(&modes, &p, &vec![1.0; closed.len()]).ok_or(inconsistent.clone())?.p
        } else {
            local.solve(&mut *self.solver, &slip)?.ok_or(inconsistent.clone())?.0
        };
        if p.iter().all(|p| p.amax() == 0.0) {
            return Err(inconsistent);
        }
        let flat = DVector::from_iterator(p.len() * D, p.iter().flat_map(|p| p.iter().copied()));
        axpy(&mut self.v, 1.0, (&frame.inverse * flat).as_slice());
        let after = self.velocities(closed);
        let mut contacts = Vec::with_capacity(closed.len());
        for (i, held) in closed.iter().enumerate() {
            let [before, after, percussion] = [&before[i], &after[i], &p[i]].map(pair);
            let work = [0, 1].map(|d| 0.5 * (before[d] + after[d]) * percussion[d]);
            for d in 0..2 {
                self.totals.percussion[d] += percussion[d];
                self.totals.contact[d] += work[d];
            }
            contacts.push(ContactImpact {
                id: held.id,
                interface: held.interface,
                before,
                after,
                percussion,
                work,
            });
        }
        self.motion.impacts.push(ImpactEvent { time: self.time, contacts });
        self.stalled = 0;
        // The next flight may be short: its length is that of the highest rise.
        self.step = self.step.min(self.shortest_flight(closed, &after)?);
        Ok(())
    }

    /// A few times 2u_N/|a_N| of the contacts that leave and are pulled back.
    fn shortest_flight(&mut self, closed: &[Held], after: &[SVector<f64, D>]) -> Result<f64, EventFailure> {
        let (local, ..) = self.dynamics.contact_accelerations(self.time, &self.q, &self.v, closed)?;
        let flight = |(i, u): (usize, &SVector<f64, D>)| {
            let a = local.b[i * D];
            if u[0] > 0.0 && a < 0.0 { 3.0 * u[0] / -a } else { f64::INFINITY }
        };
        Ok(after.iter().enumerate().map(flight).fold(f64::INFINITY, f64::min))
    }

    /// The modes of contacts with u_N = 0 right after now, and forces, from the accelerations a little later: at an event
    /// they are undecided now. `None` in Painlevé's paradox.
    fn modes(&mut self, touching: &[Held], slip: &[Option<f64>]) -> Result<Option<Solved<D>>, EventFailure> {
        if touching.is_empty() {
            return Ok(Some((Vec::new(), Vec::new())));
        }
        let (mut q, mut v) = (self.q.clone(), self.v.clone());
        let (local, frame, free) = self.dynamics.contact_accelerations(self.time, &q, &v, touching)?;
        let Some((p, _)) = local.solve(&mut *self.solver, slip)? else { return Ok(None) };
        let flat = DVector::from_iterator(p.len() * D, p.iter().flat_map(|p| p.iter().copied()));
        let a = DVector::from_vec(free) + &frame.inverse * flat;
        // Events in quick succession look less far ahead, repeated ones at the same time further each time.
        let period = self.step.min(self.length / self.speed);
        let period = period.min((self.time - self.settled).max(1e-8 * period));
        let ahead = 1e-6 * period * 10f64.powi(self.stalled.min(MOST_AT_ONCE) as i32);
        axpy(&mut q, ahead, &v);
        axpy(&mut q, 0.5 * ahead * ahead, a.as_slice());
        axpy(&mut v, ahead, a.as_slice());
        let (local, ..) = self.dynamics.contact_accelerations(self.time + ahead, &q, &v, touching)?;
        local.solve(&mut *self.solver, slip)
    }

    /// Gives redundant contacts forces to stay near where their simple sharing would make one slide that need not: those
    /// furthest inside their cones, or, where none are found, those they have been given with their modes. A contact that
    /// slides no faster than it sticks, its force at the edge of the cone being one of many, may keep the others from theirs.
    fn share(&mut self, held: &mut [Held], slip: &[Option<f64>]) -> Result<(), EventFailure> {
        let free = |held: &mut [Held]| held.iter_mut().for_each(|held| held.reference = [0.0; 2]);
        if !held.iter().any(|held| held.mode == Mode::Stick) {
            free(held);
            return Ok(());
        }
        let (local, ..) = self.dynamics.contact_accelerations(self.time, &self.q, &self.v, held)?;
        let modes: Vec<Mode> = held.iter().map(|held| held.mode).collect();
        if !local.shares_badly(&modes) {
            free(held);
            return Ok(());
        }
        let given = references(held);
        let mut forces = local.inmost(slip, &modes).unwrap_or_else(|| given.clone());
        if !local.holds(&modes, &forces) {
            let free = local.freest(&given, modes, slip);
            held.iter_mut().zip(&free).for_each(|(held, mode)| held.mode = *mode);
            forces = local.inmost(slip, &free).unwrap_or(given);
        }
        held.iter_mut().zip(&forces).for_each(|(held, p)| held.reference = pair(p));
        Ok(())
    }

    fn record_changes(&mut self, held: &[Held]) {
        let mode =
            |list: &[Held], id| list.iter().find(|held| held.id == id).map_or(Mode::Open, |held| held.mode);
        let ids =
            self.held.iter().chain(held.iter().filter(|new| self.held.iter().all(|old| old.id != new.id)));
        let change = |id| ModeChange { time: self.time, id, from: mode(&self.held, id), to: mode(held, id) };
        let changes = ids.map(|held| change(held.id)).filter(|change| change.from != change.to);
        self.motion.changes.extend(changes);
    }

    /// Moves (q, v), in the metric of M, to g = 0, u_N = 0, and u_T = 0 where a contact sticks: by rounding.
    pub(super) fn project(&mut self, contacts: &[Held]) -> Result<(), EventFailure> {
        let count = contacts.len();
        if count == 0 {
            return Ok(());
        }
        let zeros = vec![SVector::zeros(); count];
        let frame = self.dynamics.frame(contacts.iter().map(|held| held.id), &self.q)?;
        let mut gaps = DVector::zeros(count * D);
        for candidate in self.dynamics.candidates(&self.q, f64::INFINITY)? {
            if let Some(i) = contacts.iter().position(|held| held.id == candidate.id) {
                gaps[i * D] = candidate.gap;
            }
        }
        // The correction of a contact that may slide is normal: it has no friction.
        let correct = |x: &mut [f64], b: DVector<f64>, modes: &[Mode]| {
            let friction = modes.iter().map(|mode| if *mode == Mode::Stick { 1.0 } else { 0.0 }).collect();
            let local = Local::<D> { w: frame.w.clone(), b, friction };
            if let Some(found) = local.with_modes(modes, &zeros, &vec![1.0; count]) {
                let flat = DVector::from_iterator(count * D, found.p.iter().flat_map(|p| p.iter().copied()));
                axpy(x, 1.0, (&frame.inverse * flat).as_slice());
            }
        };
        correct(&mut self.q, gaps, &vec![Mode::Slide(1.0); count]);
        let u = &frame.h * DVector::from_column_slice(&self.v);
        let mode = |held: &Held| if held.mode == Mode::Stick { Mode::Stick } else { Mode::Slide(1.0) };
        let modes: Vec<Mode> = contacts.iter().map(mode).collect();
        correct(&mut self.v, u, &modes);
        Ok(())
    }
}
