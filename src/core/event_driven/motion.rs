//! The motion found: pieces with dense output, impacts, changes of mode.

use std::fmt;

use super::EventFailure;
use super::piece::{Piece, Totals};
use crate::contact::ContactId;
use crate::energy::{Balance, Energies};
use crate::linalg::{Symmetric, dot};

/// What a closed contact does between impacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mode {
    /// It carries no force.
    Open,
    /// It does not slip.
    Stick,
    /// It slips in the direction of this sign of u_T, ±1; a contact without friction slides in direction 1.
    Slide(f64),
}

/// A contact that changes its mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeChange {
    /// When (s).
    pub time: f64,
    /// Which contact.
    pub id: ContactId,
    /// Its mode before.
    pub from: Mode,
    /// Its mode from then on.
    pub to: Mode,
}

/// What one contact does at an impact; vectors are (N, T), with T = 0 in dimension 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactImpact {
    /// Which contact.
    pub id: ContactId,
    /// Its interface.
    pub interface: usize,
    /// u⁻ (m/s).
    pub before: [f64; 2],
    /// u⁺ (m/s).
    pub after: [f64; 2],
    /// Percussion p (N s).
    pub percussion: [f64; 2],
    /// Works ½ (u⁻ + u⁺)·p (J).
    pub work: [f64; 2],
}

/// An impact: every closed contact, those without percussion too.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpactEvent {
    /// When (s).
    pub time: f64,
    /// The contacts that were closed, by identity.
    pub contacts: Vec<ContactImpact>,
}

/// The motion of a system over [`start`](Self::start) … [`end`](Self::end).
#[derive(Clone)]
pub struct Motion {
    pub(super) pieces: Vec<Piece>,
    pub(super) impacts: Vec<ImpactEvent>,
    pub(super) changes: Vec<ModeChange>,
    pub(super) mass: Symmetric<f64>,
    pub(super) stiffness: Option<Symmetric<f64>>,
    /// F₀, whose potential is −F₀·q.
    pub(super) constant_force: Vec<f64>,
    /// The state reached, which stands at the end.
    pub(super) last: Piece,
}

impl fmt::Debug for Motion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pieces, impacts, changes, .. } = self;
        let (start, end) = (self.start(), self.end());
        let (pieces, impacts, changes) = (pieces.len(), impacts.len(), changes.len());
        write!(
            f,
            "Motion {{ {start}..{end} s, {pieces} pieces, {impacts} impacts, {changes} changes of mode }}"
        )
    }
}

impl Motion {
    /// Where the motion starts (s).
    pub fn start(&self) -> f64 {
        self.pieces.first().map_or(self.last.start, |piece| piece.start)
    }

    /// Where it ends (s).
    pub fn end(&self) -> f64 {
        self.last.end
    }

    /// Number of degrees of freedom n.
    pub fn dofs(&self) -> usize {
        self.mass.size()
    }

    /// (q, v) at `time`; at an impact, v after it. Times outside the motion give its first and last state.
    ///
    /// # Panics
    /// If q or v has not [`dofs`](Self::dofs) components.
    pub fn at(&self, time: f64, q: &mut [f64], v: &mut [f64]) {
        let (piece, tau) = self.after(time);
        piece.state(tau, q, v);
    }

    /// (q, v) just before `time`: at an impact, v before it.
    ///
    /// # Panics
    /// If q or v has not [`dofs`](Self::dofs) components.
    pub fn before(&self, time: f64, q: &mut [f64], v: &mut [f64]) {
        let count = self.pieces.partition_point(|piece| piece.start < time);
        match count.checked_sub(1).map(|i| &self.pieces[i]) {
            Some(piece) => piece.state(time.min(piece.end) - piece.start, q, v),
            None => self.at(time, q, v),
        }
    }

    /// The impacts, in order.
    pub fn impacts(&self) -> &[ImpactEvent] {
        &self.impacts
    }

    /// The changes of mode between open, stick and slide, in order.
    pub fn mode_changes(&self) -> &[ModeChange] {
        &self.changes
    }

    /// Times at which the motion is not smooth, or one polynomial gives way to the next.
    pub fn knots(&self) -> impl Iterator<Item = f64> {
        self.pieces.iter().map(|piece| piece.start).chain([self.end()])
    }

    /// Percussions of all contacts up to `time`, [N, T] (N s): those of the impacts, the one at `time` included, and
    /// the integral of the forces between them.
    pub fn percussion(&self, time: f64) -> [f64; 2] {
        self.totals(time).percussion
    }

    /// Energies at `time`; at an impact, after it.
    pub fn energy(&self, time: f64) -> Energies<f64> {
        let n = self.dofs();
        let (mut q, mut v, mut product) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        self.at(time, &mut q, &mut v);
        self.mass.multiply(&v, &mut product);
        let kinetic = 0.5 * dot(&v, &product);
        let elastic = self.stiffness.as_ref().map_or(0.0, |stiffness| {
            stiffness.multiply(&q, &mut product);
            0.5 * dot(&q, &product)
        });
        Energies { kinetic, elastic, potential: -dot(&self.constant_force, &q) }
    }

    /// Refuses a motion whose last energy is not finite.
    pub(super) fn check_energy(&self) -> Result<(), EventFailure> {
        let energy = self.energy(self.end()).total();
        if energy.is_finite() { Ok(()) } else { Err(EventFailure::Energy { energy }) }
    }

    /// The balance of the energies from the start to `time`; its imbalance is rounding.
    pub fn balance(&self, time: f64) -> Balance<f64> {
        let (from, to) = (self.energy(self.start()), self.energy(time));
        let (first, last) = (self.first_totals(), self.totals(time));
        let mut balance = Balance {
            kinetic_change: to.kinetic - from.kinetic,
            elastic_change: to.elastic - from.elastic,
            external_work: last.external,
            damping_work: last.damping,
            normal_contact_work: last.contact[0],
            tangential_contact_work: last.contact[1],
            ..Balance::default()
        };
        // An impact at the start is part of the energy there.
        balance.normal_contact_work -= first.contact[0];
        balance.tangential_contact_work -= first.contact[1];
        balance.close();
        balance
    }

    fn first_totals(&self) -> Totals {
        self.pieces.first().unwrap_or(&self.last).totals
    }

    fn totals(&self, time: f64) -> Totals {
        let (piece, tau) = self.after(time);
        piece.totals(tau)
    }

    /// The piece that begins last, at or before `time`, and the time since.
    fn after(&self, time: f64) -> (&Piece, f64) {
        if time >= self.last.end {
            return (&self.last, 0.0);
        }
        let count = self.pieces.partition_point(|piece| piece.start <= time);
        let piece = self.pieces.get(count.saturating_sub(1)).unwrap_or(&self.last);
        (piece, (time.min(piece.end) - piece.start).max(0.0))
    }
}
