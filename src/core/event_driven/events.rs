//! What ends a smooth piece: a gap that closes, a force that leaves its cone, a slip that stops.

use super::crossing::{Functions, Unresolved};
use super::dynamics::{Equations, Held};
use super::legendre::BASIS;
use super::piece::Piece;
use super::{EventFailure, Mode};
use crate::contact::ContactId;

impl From<Unresolved> for EventFailure {
    fn from(Unresolved { time }: Unresolved) -> Self {
        Self::Unresolved { after: time }
    }
}

/// How far the functions may be below zero by rounding.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rounding {
    /// Of gaps (m).
    pub(super) gap: f64,
    /// Of velocities (m/s).
    pub(super) speed: f64,
    /// Of mean velocities since the last contact (m/s).
    pub(super) mean_speed: f64,
    /// Of accelerations (m/s²).
    pub(super) acceleration: f64,
}

/// The functions of time on a piece that are positive until an event.
///
/// In this order: for each contact that leaves, having been closed at the start, its mean normal velocity since then
/// (the gap over the time, whose root at the start is thus divided out); for each open contact known at the start its
/// gap; the least gap of any other; for each held contact whether it is still there, its normal force as an
/// acceleration W_NN λ_N, and, sticking, its distance from both sides of the cone, or, sliding, its slip.
pub(super) struct Events<'a, const D: usize> {
    pub(super) dynamics: &'a mut Equations<D>,
    pub(super) piece: &'a Piece,
    pub(super) held: &'a [Held],
    leaving: Vec<ContactId>,
    open: Vec<ContactId>,
    /// Length that stands for a contact that is not there (m).
    length: f64,
    /// Time (s) up to which a mean velocity is integrated, not divided.
    short: f64,
    rounding: Rounding,
    /// W_NN, W_TT of the held contacts at the start.
    mobility: Vec<[f64; 2]>,
    kinds: Vec<Kind>,
    q: Vec<f64>,
    v: Vec<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Speed,
    MeanSpeed,
    Gap,
    Presence,
    Force,
}

impl<'a, const D: usize> Events<'a, D> {
    /// `closed` is the gap up to which a contact counts as closed at the start of the piece, `speed` the scene's.
    pub(super) fn new(
        dynamics: &'a mut Equations<D>,
        piece: &'a Piece,
        held: &'a [Held],
        (length, speed): (f64, f64),
        closed: f64,
        rounding: Rounding,
    ) -> Result<Self, EventFailure> {
        let (mut leaving, mut open) = (Vec::new(), Vec::new());
        for candidate in dynamics.candidates(&piece.q, f64::INFINITY)? {
            if held.iter().all(|held| held.id != candidate.id) {
                if candidate.gap <= closed { leaving.push(candidate.id) } else { open.push(candidate.id) }
            }
        }
        let frame = dynamics.frame(held.iter().map(|held| held.id), &piece.q)?;
        let mobility = (0..held.len()).map(|i| [i * D, i * D + D - 1].map(|k| frame.w[(k, k)])).collect();
        let mut kinds = vec![Kind::MeanSpeed; leaving.len()];
        kinds.resize(leaving.len() + open.len() + 1, Kind::Gap);
        for held in held {
            kinds.extend([Kind::Presence, Kind::Force]);
            if D == 2 && held.friction > 0.0 {
                match held.mode {
                    Mode::Stick => kinds.extend([Kind::Force, Kind::Force]),
                    Mode::Slide(_) => kinds.push(Kind::Speed),
                    Mode::Open => {}
                }
            }
        }
        let (q, v) = (piece.q.clone(), piece.v.clone());
        let short = 1e-2 * length / speed;
        Ok(Self { dynamics, piece, held, leaving, open, length, short, rounding, mobility, kinds, q, v })
    }

    /// The contact that closes with function `i`, where it is one.
    pub(super) fn closes(&self, i: usize) -> Option<ContactId> {
        self.leaving.iter().chain(&self.open).nth(i).copied()
    }

    /// (1/τ) ∫₀^τ u_N.
    fn mean_speed(&mut self, id: ContactId, tau: f64) -> f64 {
        let mut at = |tau: f64| {
            self.piece.state(tau, &mut self.q, &mut self.v);
            self.dynamics.velocity(id, &self.q, &self.v)[0]
        };
        if tau == 0.0 {
            return at(0.0);
        }
        BASIS.nodes.iter().zip(BASIS.weights).map(|(x, w)| w * at(x * tau)).sum()
    }
}

impl<const D: usize> Functions for Events<'_, D> {
    type Error = EventFailure;

    fn count(&self) -> usize {
        self.kinds.len()
    }

    fn split(&self) -> f64 {
        self.short
    }

    fn rounding(&self, i: usize, time: f64) -> f64 {
        match self.kinds[i] {
            Kind::Speed => self.rounding.speed,
            Kind::MeanSpeed if time >= self.short => self.rounding.gap / time,
            Kind::MeanSpeed => self.rounding.mean_speed,
            Kind::Gap => self.rounding.gap,
            Kind::Presence => 0.0,
            Kind::Force => self.rounding.acceleration,
        }
    }

    fn at(&mut self, tau: f64, values: &mut [f64]) -> Result<(), EventFailure> {
        self.piece.state(tau, &mut self.q, &mut self.v);
        let known = self.leaving.len() + self.open.len();
        values[..=known].fill(self.length);
        let mut present = vec![-1.0; self.held.len()];
        for candidate in self.dynamics.candidates(&self.q, f64::INFINITY)? {
            let place = |ids: &[ContactId]| ids.binary_search(&candidate.id).ok();
            if let Some(i) = self.held.iter().position(|held| held.id == candidate.id) {
                present[i] = 1.0;
            } else if let Some(i) = place(&self.leaving) {
                values[i] = candidate.gap / tau;
            } else if let Some(i) = place(&self.open) {
                values[self.leaving.len() + i] = candidate.gap;
            } else {
                values[known] = values[known].min(candidate.gap);
            }
        }
        let mut next = known + 1;
        if !self.held.is_empty() {
            let time = self.piece.start + tau;
            let found = self.dynamics.evaluate(time, &self.q, &self.v, self.held)?;
            for (i, held) in self.held.iter().enumerate() {
                let (force, [normal, tangential]) = (found.forces[i], self.mobility[i]);
                let mut push = |value: f64| {
                    values[next] = value;
                    next += 1;
                };
                push(present[i]);
                push(normal * force[0]);
                if D == 2 && held.friction > 0.0 {
                    let (limit, drag) = (tangential * held.friction * force[0], tangential * force[D - 1]);
                    match held.mode {
                        Mode::Stick => {
                            push(limit - drag);
                            push(limit + drag);
                        }
                        Mode::Slide(s) => push(s * found.velocities[i][D - 1]),
                        Mode::Open => {}
                    }
                }
            }
        }
        if tau <= self.short {
            for (i, value) in values.iter_mut().enumerate().take(self.leaving.len()) {
                *value = self.mean_speed(self.leaving[i], tau);
            }
        }
        Ok(())
    }
}
