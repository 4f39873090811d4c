//! The integrator: settle the contacts, fly to the next event, and again.

use super::collocation::{Tried, step};
use super::crossing::first_crossing;
use super::dynamics::{Equations, Held};
use super::events::{Events, Rounding};
use super::piece::{Piece, Totals};
use super::{EventError, EventFailure, Motion, Settings};
use crate::contact::ContactId;
use crate::laws::{ContactLaw, Rows};
use crate::linalg::Factor;
use crate::solver::ConeSolver;
use crate::system::{Scales, System};

/// Largest overlap at the start, relative to the length of the scene.
const OVERLAP: f64 = 1e-9;

/// Integrates `system` under `laws`, one per interface, from (q, v) at `start_time` to `end`; see the
/// [module](crate::event_driven).
///
/// # Errors
/// [`EventError`] with the time, the failure and the motion up to there.
#[expect(clippy::too_many_arguments, reason = "a system, its laws and solver, and an initial value problem")]
pub fn integrate<const D: usize>(
    system: Box<dyn System<f64, D>>,
    laws: Vec<Box<dyn ContactLaw<f64, D>>>,
    solver: Box<dyn ConeSolver<f64, D>>,
    start_time: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    end: f64,
    settings: &Settings,
) -> Result<Motion, EventError> {
    let checked = check(&*system, &laws, &*solver, (start_time, end), (&q, &v), settings);
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
    motion.check_energy().map_err(|failure| EventError { time: start_time, failure, motion: None })?;
    let mut integrator = Integrator {
        dynamics: Equations::new(system, factor, length),
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
    match outcome.and_then(|()| motion.check_energy()) {
        Ok(()) => Ok(motion),
        Err(failure) => Err(EventError { time, failure, motion: Some(Box::new(motion)) }),
    }
}

fn check<const D: usize>(
    system: &dyn System<f64, D>,
    laws: &[Box<dyn ContactLaw<f64, D>>],
    solver: &dyn ConeSolver<f64, D>,
    (start, end): (f64, f64),
    (q, v): (&[f64], &[f64]),
    settings: &Settings,
) -> Result<Factor<f64>, EventFailure> {
    for (unsupported, what) in [
        (D > 2, "contacts of dimension 3"),
        (system.joints().is_some(), "joints"),
        (!system.is_flat(), "configurations that do not add up"),
        (system.nonlinear().is_some(), "a mass that depends on the configuration"),
        (system.prescribed().is_some(), "prescribed degrees of freedom"),
        (laws.iter().any(|law| law.rows() == Rows::Rolling), "rolling resistance"),
        (laws.iter().any(|law| law.memory() > 0), "laws that remember"),
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

/// A motion in the making.
pub(super) struct Integrator<'s, const D: usize> {
    pub(super) dynamics: Equations<D>,
    pub(super) laws: Vec<Box<dyn ContactLaw<f64, D>>>,
    pub(super) solver: Box<dyn ConeSolver<f64, D>>,
    pub(super) settings: &'s Settings,
    pub(super) length: f64,
    /// The speed of the scene, growing with the motion.
    pub(super) speed: f64,
    pub(super) time: f64,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    pub(super) totals: Totals,
    pub(super) held: Vec<Held>,
    /// Length the next step may have (s).
    pub(super) step: f64,
    pub(super) events: usize,
    /// When the modes were last settled.
    pub(super) settled: f64,
    /// Events since the time last moved on.
    pub(super) stalled: usize,
    pub(super) motion: Motion,
}

impl<const D: usize> Integrator<'_, D> {
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

    /// One piece towards `smooth`; the contact that closes, where an event ends it.
    #[expect(clippy::option_option, reason = "an event, and the contact that closes with it, if one does")]
    fn fly(&mut self, smooth: f64) -> Result<Option<Option<ContactId>>, EventFailure> {
        let limit = self.settings.max_steps;
        if self.motion.pieces.len() >= limit {
            return Err(EventFailure::TooManySteps { limit, step: self.step });
        }
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
