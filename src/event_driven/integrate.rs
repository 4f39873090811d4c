//! The integrator: settle the contacts, fly to the next event, and again.

use nalgebra::{DVector, SVector};

use super::collocation::{Tried, step};
use super::crossing::first_crossing;
use super::dynamics::{Dynamics, Held};
use super::events::{Events, Rounding};
use super::local::Local;
use super::piece::{Piece, Totals};
use super::{ContactImpact, EventError, EventFailure, ImpactEvent, Mode, ModeChange, Motion, Settings};
use crate::contact::ContactId;
use crate::laws::ContactLaw;
use crate::linalg::{Factor, axpy, max_abs};
use crate::solver::ConeSolver;
use crate::system::{MechanicalSystem, Scales};

/// θ = ½ is the continuous law: (35) for Newton's, Ξ (45–46) for Frémond's.
const THETA: f64 = 0.5;

/// Most events at one time that are neither impacts nor progress.
const MOST_AT_ONCE: usize = 14;

/// Largest overlap at the start, relative to the length of the scene.
const OVERLAP: f64 = 1e-9;

/// Integrates `system` under `laws`, one per interface, from (q, v) at `start_time` to `end`; see the
/// [module](crate::event_driven).
///
/// # Errors
/// [`EventError`] with the time, the failure and the motion up to there.
#[expect(clippy::too_many_arguments, reason = "a system, its laws and solver, and an initial value problem")]
pub fn integrate<S, L, V, const D: usize>(
    system: S,
    laws: Vec<L>,
    solver: V,
    start_time: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    end: f64,
    settings: &Settings,
) -> Result<Motion, EventError>
where
    S: MechanicalSystem<f64, D>,
    L: ContactLaw<f64, D>,
    V: ConeSolver<f64, D>,
{
    let checked = check(&system, &laws, &solver, (start_time, end), (&q, &v), settings);
    let factor = checked.map_err(|failure| EventError { time: start_time, failure, motion: None })?;
    let Scales { length, speed } = system.scales(&q, &v);
    let motion = Motion {
        pieces: Vec::new(),
        impacts: Vec::new(),
        changes: Vec::new(),
        mass: system.mass().clone(),
        stiffness: system.stiffness().cloned(),
        constant_force: system.forces().constant_part().to_vec(),
        last: Piece::at_rest(start_time, &q, &v, Totals::default()),
    };
    let mut integrator = Integrator {
        dynamics: Dynamics::new(system, factor, length),
        laws,
        solver,
        settings,
        length,
        speed,
        time: start_time,
        q,
        v,
        totals: Totals::default(),
        held: Vec::new(),
        step: f64::INFINITY,
        events: 0,
        settled: f64::NEG_INFINITY,
        stalled: 0,
        motion,
    };
    let outcome = integrator.run(end);
    let Integrator { mut motion, time, q, v, totals, .. } = integrator;
    motion.last = Piece::at_rest(time, &q, &v, totals);
    match outcome {
        Ok(()) => Ok(motion),
        Err(failure) => Err(EventError { time, failure, motion: Some(Box::new(motion)) }),
    }
}

fn check<S, L, V, const D: usize>(
    system: &S,
    laws: &[L],
    solver: &V,
    (start, end): (f64, f64),
    (q, v): (&[f64], &[f64]),
    settings: &Settings,
) -> Result<Factor<f64>, EventFailure>
where
    S: MechanicalSystem<f64, D>,
    V: ConeSolver<f64, D>,
{
    for (unsupported, what) in [
        (D > 2, "contacts of dimension 3"),
        (system.joint_rows() > 0, "joints"),
        (system.nonlinear().is_some(), "a mass that depends on the configuration"),
        (system.prescribed().is_some(), "prescribed degrees of freedom"),
    ] {
        if unsupported {
            return Err(EventFailure::Unsupported { what });
        }
    }
    let n = system.dofs();
    for (what, given, expected) in
        [("q", q.len(), n), ("v", v.len(), n), ("laws", laws.len(), system.interfaces())]
    {
        if given != expected {
            return Err(EventFailure::Size { what, given, expected });
        }
    }
    for (what, values) in [("q", q), ("v", v), ("the start", &[start])] {
        if let Some(&value) = values.iter().find(|x| !x.is_finite()) {
            return Err(EventFailure::OutOfRange { what: what.into(), value, range: "finite" });
        }
    }
    if !(end > start && end.is_finite()) {
        let what = "the end".into();
        return Err(EventFailure::OutOfRange { what, value: end, range: "finite and after the start" });
    }
    settings.check()?;
    solver.stopping().check()?;
    Factor::new(system.mass()).map_err(EventFailure::Mass)
}

struct Integrator<'s, S, L, V, const D: usize> {
    dynamics: Dynamics<S, D>,
    laws: Vec<L>,
    solver: V,
    settings: &'s Settings,
    length: f64,
    /// The speed of the scene, growing with the motion.
    speed: f64,
    time: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    totals: Totals,
    held: Vec<Held>,
    /// Length the next step may have (s).
    step: f64,
    events: usize,
    /// When the modes were last settled.
    settled: f64,
    /// Events since the time last moved on.
    stalled: usize,
    motion: Motion,
}

impl<S, L, V, const D: usize> Integrator<'_, S, L, V, D>
where
    S: MechanicalSystem<f64, D>,
    L: ContactLaw<f64, D>,
    V: ConeSolver<f64, D>,
{
    fn run(&mut self, end: f64) -> Result<(), EventFailure> {
        let least =
            self.dynamics.candidates(&self.q, f64::INFINITY)?.iter().min_by(|a, b| a.gap.total_cmp(&b.gap));
        if let Some(&candidate) = least
            && candidate.gap < -OVERLAP * self.length
        {
            let contact = self.dynamics.system.contact_label(candidate.id);
            return Err(EventFailure::Overlap { contact, gap: candidate.gap });
        }
        // F is smooth from one break of its signals to the next.
        while self.time < end {
            let smooth =
                self.dynamics.system.forces().next_break(self.time).map_or(end, |next| next.min(end));
            self.dynamics.inside = 0.5 * (self.time + smooth);
            self.settle(None)?;
            while self.time < smooth {
                if let Some(closing) = self.fly(smooth)? {
                    self.settle(closing)?;
                }
            }
        }
        self.settle(None)
    }

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
            held.friction = law.friction();
        }
        Ok(closed)
    }

    fn velocities(&mut self, contacts: &[Held]) -> Vec<SVector<f64, D>> {
        contacts.iter().map(|held| self.dynamics.velocity(held.id, &self.q, &self.v)).collect()
    }

    /// Impacts until no closed contact approaches, then the modes of those that stay.
    fn settle(&mut self, closing: Option<ContactId>) -> Result<(), EventFailure> {
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
            let Some(modes) = self.modes(&held, &slip)? else {
                let u = self.velocities(&closed);
                self.impact(&closed, &u, true)?;
                continue;
            };
            held.iter_mut().zip(modes).for_each(|(held, mode)| held.mode = mode);
            // A contact that opens, but approaches by rounding, does not approach.
            let approaching = held.iter().zip(&u).filter(|(held, u)| held.mode != Mode::Open || u[0] < 0.0);
            let corrected: Vec<Held> = approaching.map(|(&held, _)| held).collect();
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
        let b = closed.iter().zip(before).flat_map(|(held, u)| {
            let b = u + self.laws[held.interface].evaluate(u, THETA).b_shift(u);
            b.iter().copied().collect::<Vec<f64>>()
        });
        let b = DVector::from_iterator(closed.len() * D, b);
        let friction = closed.iter().map(|held| held.friction).collect();
        let mut local = Local::<D> { w: frame.w, b, friction };
        let slip = vec![None; closed.len()];
        let inconsistent = EventFailure::Inconsistent { contacts: closed.len() };
        let p = if without_collision {
            let exact = local.b.clone();
            (0..closed.len()).for_each(|i| local.b[i * D] -= 1e-6 * self.speed);
            let Some((p, modes)) = local.solve(&mut self.solver, &slip)? else { return Err(inconsistent) };
            local.b = exact;
            local.with_modes(&modes, &p, &vec![1.0; closed.len()]).ok_or(inconsistent.clone())?.p
        } else {
            local.solve(&mut self.solver, &slip)?.ok_or(inconsistent.clone())?.0
        };
        if p.iter().all(|p| p.amax() == 0.0) {
            return Err(inconsistent);
        }
        let flat = DVector::from_iterator(p.len() * D, p.iter().flat_map(|p| p.iter().copied()));
        axpy(&mut self.v, 1.0, (&frame.inverse * flat).as_slice());
        let after = self.velocities(closed);
        let pair = |x: &SVector<f64, D>| [x[0], if D == 2 { x[D - 1] } else { 0.0 }];
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

    /// The modes of contacts with u_N = 0 right after now, from the accelerations a little later: at an event they are
    /// undecided now. `None` in Painlevé's paradox.
    fn modes(&mut self, touching: &[Held], slip: &[Option<f64>]) -> Result<Option<Vec<Mode>>, EventFailure> {
        if touching.is_empty() {
            return Ok(Some(Vec::new()));
        }
        let (mut q, mut v) = (self.q.clone(), self.v.clone());
        let (local, frame, free) = self.dynamics.contact_accelerations(self.time, &q, &v, touching)?;
        let Some((p, _)) = local.solve(&mut self.solver, slip)? else { return Ok(None) };
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
        Ok(local.solve(&mut self.solver, slip)?.map(|(_, modes)| modes))
    }

    /// Gives redundant contacts forces to stay near where their simple sharing would make one slide that need not.
    fn share(&mut self, held: &mut [Held], slip: &[Option<f64>]) -> Result<(), EventFailure> {
        if !held.iter().any(|held| held.mode == Mode::Stick) {
            return Ok(());
        }
        let (local, ..) = self.dynamics.contact_accelerations(self.time, &self.q, &self.v, held)?;
        let modes: Vec<Mode> = held.iter().map(|held| held.mode).collect();
        if local.shares_badly(&modes)
            && let Some(forces) = local.inmost(&mut self.solver, slip, &modes)
        {
            let pair = |p: &SVector<f64, D>| [p[0], if D == 2 { p[D - 1] } else { 0.0 }];
            held.iter_mut().zip(&forces).for_each(|(held, p)| held.reference = pair(p));
        }
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
    fn project(&mut self, contacts: &[Held]) -> Result<(), EventFailure> {
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

    /// One piece towards `smooth`; the contact that closes, where an event ends it.
    #[expect(clippy::option_option, reason = "an event, and the contact that closes with it, if one does")]
    fn fly(&mut self, smooth: f64) -> Result<Option<Option<ContactId>>, EventFailure> {
        let remaining = smooth - self.time;
        let mut h = self.step.min(self.settings.largest_step).min(remaining);
        if h > 0.99 * remaining {
            h = remaining;
        }
        let piece = loop {
            let state = (self.time, &*self.q, &*self.v);
            match step(
                &mut self.dynamics,
                &self.held,
                state,
                self.totals,
                h,
                (self.settings.tolerance, self.speed),
            )? {
                Tried::Accepted(piece, factor) => {
                    self.step = h * factor;
                    break piece;
                }
                Tried::Rejected(factor) => h *= factor,
            }
            if self.time + h * 1e-3 <= self.time {
                return Err(EventFailure::StepTooSmall { step: h });
            }
        };
        let (reach_q, reach_v) = piece.reach(h);
        let speed = self.speed.max(reach_v);
        let epsilon = f64::EPSILON;
        let rounding = Rounding {
            gap: 32.0 * epsilon * self.length.max(reach_q),
            speed: 64.0 * epsilon * speed,
            mean_speed: 128.0 * epsilon * speed,
            acceleration: 1e-12 * (speed * speed / self.length).max(self.largest_acceleration(&piece)),
        };
        let closed = self.settings.gap_tolerance * self.length;
        let scales = (self.length, speed);
        let mut events = Events::new(&mut self.dynamics, &piece, &self.held, scales, closed, rounding)?;
        let crossing = first_crossing(&mut events, h)?;
        let event = crossing.map(|(tau, i)| (tau, events.closes(i)));
        let tau = event.map_or(h, |(tau, _)| tau);
        let piece = if tau > 0.0 && tau < 0.25 * h { self.shorter(piece, tau)? } else { piece };
        self.advance(*piece, tau, if event.is_none() && h == remaining { Some(smooth) } else { None });
        if event.is_none() {
            let held = std::mem::take(&mut self.held);
            self.project(&held)?;
            self.held = held;
        }
        Ok(event.map(|(_, closing)| closing))
    }

    /// The piece made again for its beginning alone, whose digits are then those of its length.
    fn shorter(&mut self, piece: Box<Piece>, tau: f64) -> Result<Box<Piece>, EventFailure> {
        let state = (self.time, &*self.q, &*self.v);
        let tolerances = (self.settings.tolerance, self.speed);
        match step(&mut self.dynamics, &self.held, state, self.totals, tau, tolerances)? {
            Tried::Accepted(shorter, _) => Ok(shorter),
            Tried::Rejected(_) => Ok(piece),
        }
    }

    fn largest_acceleration(&self, piece: &Piece) -> f64 {
        let bound = |column: &[f64]| column.iter().map(|a| a.abs()).sum::<f64>();
        piece.acceleration.iter().map(|a| bound(a)).fold(0.0, f64::max)
    }

    /// Takes `piece` up to `tau`, which is the time `end` where that is known better.
    fn advance(&mut self, mut piece: Piece, tau: f64, end: Option<f64>) {
        piece.state(tau, &mut self.q, &mut self.v);
        self.totals = piece.totals(tau);
        self.time = end.unwrap_or(piece.start + tau);
        self.stalled = if tau > 0.0 { 0 } else { self.stalled + 1 };
        piece.end = self.time;
        if piece.end > piece.start {
            self.motion.pieces.push(piece);
        }
    }
}
