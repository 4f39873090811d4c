//! Bodies at rest: islands that leave the steps until something touches them.
//!
//! Where nothing depends on time, an island of bodies in touch that stands still at the end of a step with the
//! percussions it started with stands still for ever: every step is that step again. Such an island is left out. Its
//! percussions are those of the step that found it, its velocities and works are zero, its configuration is kept; no
//! gap, Jacobian, row of W or percussion of it is computed again until a body that moves comes to touch one of its own.
//!
//! It has to show it first. The bodies are at rest to what the cone solver leaves, ‖v‖_M ≤ 10 tol ‖h M⁻¹F‖_M, tol the
//! solver's tolerance, over some steps in a row; then their velocities are set to zero, and the step made from there
//! (the one whose percussions are kept) must leave them at rest again. What is neglected is a kinetic energy of
//! (10 tol)² of that of one step of free fall, and the motion within the solver's tolerance that it would be.

use nalgebra::SVector;

use super::ContactStep;
use crate::contact::ContactId;
use crate::linalg::forest::{join, root};
use crate::linalg::{BlockRows, Symmetric};
use crate::scalar::{Scalar, lit, to_f64};
use crate::system::Dynamics;

/// Steps in a row that a body must be at rest.
const QUIET: u8 = 8;
/// Bodies whose velocities were set to zero, and those that stood still in the step made from there.
const SETTLING: u8 = QUIET + 1;
const SETTLED: u8 = QUIET + 2;

/// Kinetic energy at rest, in squares of the solver's tolerance times that of a step of free fall: 10².
const AT_REST: f64 = 100.0;

/// Steps after which islands are looked at again where no body has newly come to rest.
const AGAIN: usize = 64;

/// The island of a body that is awake.
const AWAKE: usize = usize::MAX;

/// Which bodies sleep, and their contacts.
#[derive(Debug)]
pub(super) struct Rest<T: Scalar, const D: usize> {
    /// Degrees of freedom of a body.
    unit: usize,
    /// Largest v·M v of a body at rest.
    bound: Vec<T>,
    asleep: Vec<bool>,
    /// Steps each body has been at rest, at most [`QUIET`], or how far it is on its way to sleep.
    quiet: Vec<u8>,
    /// The body that stands for the island of a sleeper; while islands are found, a parent in the tree of the island.
    island: Vec<usize>,
    /// The least `quiet` of an island, at the body that stands for it.
    least: Vec<u8>,
    /// Contacts of sleepers with their islands, ordered by identity, and the contacts alone.
    contacts: Vec<(ContactStep<T, D>, usize)>,
    listed: Vec<ContactStep<T, D>>,
}

/// [`Rest`] as plain numbers.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "outputs", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct RestMark {
    quiet: Vec<u8>,
    /// Island of every sleeper, and its place in the list of bodies.
    sleepers: Vec<(u64, u64)>,
    /// Identity, interface, gap and island of their contacts.
    contacts: Vec<(ContactId, u64, f64, u64)>,
}

impl RestMark {
    /// Everybody is awake, in a scene of `bodies` bodies.
    pub(super) fn awake(bodies: usize) -> Self {
        Self { quiet: vec![0; bodies], sleepers: Vec::new(), contacts: Vec::new() }
    }
}

impl<T: Scalar, const D: usize> Rest<T, D> {
    /// `None` for systems that cannot rest: without bodies, or with terms that depend on time or couple them otherwise.
    pub(super) fn new(system: &dyn Dynamics<T>, step: T, tolerance: T) -> Option<Self> {
        let unit = system.body_dofs().filter(|&unit| unit > 0 && system.dofs().is_multiple_of(unit))?;
        let Symmetric::Diagonal(mass) = system.mass() else { return None };
        let coupled = system.stiffness().is_some() || system.damping().is_some() || system.joints().is_some();
        let other = system.nonlinear().is_some() || system.prescribed().is_some();
        if coupled || other || system.forces().varies() {
            return None;
        }
        let weight = lit::<T>(AT_REST) * tolerance * tolerance * step * step;
        let fall = |(m, f): (&[T], &[T])| m.iter().zip(f).fold(T::zero(), |sum, (&m, &f)| sum + f * f / m);
        let bodies = mass.chunks_exact(unit).zip(system.forces().constant_part().chunks_exact(unit));
        let bound: Vec<T> = bodies.map(|body| fall(body) * weight).collect();
        let bodies = bound.len();
        Some(Self {
            unit,
            bound,
            asleep: vec![false; bodies],
            quiet: vec![0; bodies],
            island: vec![AWAKE; bodies],
            least: vec![0; bodies],
            contacts: Vec::new(),
            listed: Vec::new(),
        })
    }

    pub(super) fn bodies(&self) -> usize {
        self.asleep.len()
    }

    /// Whether each body sleeps.
    pub(super) fn asleep(&self) -> &[bool] {
        &self.asleep
    }

    /// Clears the forces on sleepers: their velocities then stay zero, their configuration as it is.
    pub(super) fn still(&self, force: &mut [T]) {
        for (f, _) in force.chunks_exact_mut(self.unit).zip(&self.asleep).filter(|&(_, &asleep)| asleep) {
            f.fill(T::zero());
        }
    }

    /// Wakes the islands of the bodies that `rows` touches; whether there were any.
    pub(super) fn wake(&mut self, rows: &BlockRows<T, D>) -> bool {
        let (unit, mut woken) = (self.unit, false);
        for row in 0..rows.rows() {
            for body in rows.row(row).map(|(dof, _)| dof / unit) {
                if self.asleep[body] {
                    self.wake_island(self.island[body]);
                    woken = true;
                }
            }
        }
        woken
    }

    fn wake_island(&mut self, island: usize) {
        for body in 0..self.asleep.len() {
            if self.island[body] == island {
                (self.asleep[body], self.quiet[body], self.island[body]) = (false, 0, AWAKE);
            }
        }
        self.contacts.retain(|&(_, other)| other != island);
        self.list();
    }

    /// `all` ← the contacts of a step and those of the sleepers, ordered by identity.
    pub(super) fn merge(&self, active: &[ContactStep<T, D>], all: &mut Vec<ContactStep<T, D>>) {
        all.clear();
        all.reserve(active.len() + self.contacts.len());
        let mut rest = self.listed.as_slice();
        for contact in active {
            let (before, after) = rest.split_at(rest.partition_point(|sleeper| sleeper.id < contact.id));
            all.extend_from_slice(before);
            all.push(*contact);
            rest = after;
        }
        all.extend_from_slice(rest);
    }

    fn list(&mut self) {
        self.listed.clear();
        self.listed.extend(self.contacts.iter().map(|&(contact, _)| contact));
    }

    /// Looks at the step made: bodies on their way to sleep have their velocities set to zero, and those that stay at rest
    /// then fall asleep. `contacts` are the active ones, with H in `rows`.
    pub(super) fn settle(
        &mut self,
        mass: &Symmetric<T>,
        (v, momentum): (&mut [T], &mut [T]),
        contacts: &[ContactStep<T, D>],
        rows: &BlockRows<T, D>,
        step: usize,
    ) {
        if !self.count(mass, v, step) {
            return;
        }
        let unit = self.unit;
        self.find_islands(rows);
        for (row, contact) in contacts.iter().enumerate() {
            let Some(body) = rows.row(row).map(|(dof, _)| dof / unit).next() else { continue };
            let island = root(&mut self.island, body);
            if self.least[island] == SETTLED {
                let rest =
                    ContactStep::resting(contact.id, contact.interface, contact.gap, contact.percussion);
                self.contacts.push((rest, island));
            }
        }
        self.contacts.sort_unstable_by_key(|(contact, _)| contact.id);
        self.list();
        for body in 0..self.asleep.len() {
            if self.asleep[body] {
                continue;
            }
            let island = root(&mut self.island, body);
            let least = self.least[island];
            if least < QUIET {
                // What was on its way waits for the others.
                self.quiet[body] = self.quiet[body].min(QUIET);
                continue;
            }
            let dofs = body * unit..(body + 1) * unit;
            v[dofs.clone()].fill(T::zero());
            momentum[dofs].fill(T::zero());
            self.quiet[body] = if least == SETTLED { SETTLED } else { SETTLING };
        }
        for body in 0..self.asleep.len() {
            if self.asleep[body] {
                continue;
            }
            self.island[body] = root(&mut self.island, body);
        }
        for body in 0..self.asleep.len() {
            match (self.asleep[body], self.quiet[body]) {
                (true, _) => {}
                (false, SETTLED) => (self.asleep[body], self.quiet[body]) = (true, 0),
                (false, _) => self.island[body] = AWAKE,
            }
        }
    }

    /// Counts the steps at rest; whether islands may have come to rest.
    fn count(&mut self, mass: &Symmetric<T>, v: &[T], step: usize) -> bool {
        let Symmetric::Diagonal(mass) = mass else { return false };
        let (mut ripe, mut waiting) = (false, false);
        for (body, (v, m)) in v.chunks_exact(self.unit).zip(mass.chunks_exact(self.unit)).enumerate() {
            if self.asleep[body] {
                continue;
            }
            let twice_energy = v.iter().zip(m).fold(T::zero(), |sum, (&v, &m)| sum + m * v * v);
            let at_rest = twice_energy <= self.bound[body];
            let before = self.quiet[body];
            let now = match before {
                _ if !at_rest => 0,
                SETTLING => SETTLED,
                QUIET => QUIET,
                before => before + 1,
            };
            self.quiet[body] = now;
            ripe |= now >= QUIET && now != before;
            waiting |= now == QUIET;
        }
        ripe || waiting && step.is_multiple_of(AGAIN)
    }

    /// The islands of the bodies that are awake, and the least quiet of each; a body without contact is not at rest.
    fn find_islands(&mut self, rows: &BlockRows<T, D>) {
        for body in 0..self.asleep.len() {
            if self.asleep[body] {
                continue;
            }
            (self.island[body], self.least[body]) = (body, 0);
        }
        let unit = self.unit;
        for row in 0..rows.rows() {
            let mut first = None;
            for body in rows.row(row).map(|(dof, _)| dof / unit) {
                self.least[body] = self.quiet[body];
                join(&mut self.island, *first.get_or_insert(body), body);
            }
        }
        for body in 0..self.asleep.len() {
            if self.asleep[body] {
                continue;
            }
            let island = root(&mut self.island, body);
            self.least[island] = self.least[island].min(self.least[body]);
        }
    }

    pub(super) fn mark(&self) -> RestMark {
        let sleepers = self.island.iter().enumerate().filter(|&(_, &island)| island != AWAKE);
        let contact = |(contact, island): &(ContactStep<T, D>, usize)| {
            (contact.id, contact.interface as u64, to_f64(contact.gap), *island as u64)
        };
        RestMark {
            quiet: self.quiet.clone(),
            sleepers: sleepers.map(|(body, &island)| (island as u64, body as u64)).collect(),
            contacts: self.contacts.iter().map(contact).collect(),
        }
    }

    /// Goes to a mark, the percussions of the sleepers' contacts among those of `last`; whether it is one of this scene.
    pub(super) fn restore(
        &mut self,
        mark: &RestMark,
        interfaces: usize,
        last: &[(ContactId, Vec<f64>)],
    ) -> Option<()> {
        let bodies = self.asleep.len();
        let below = |x: u64, count: usize| usize::try_from(x).ok().filter(|&x| x < count);
        if mark.quiet.len() != bodies {
            return None;
        }
        let (mut asleep, mut island) = (vec![false; bodies], vec![AWAKE; bodies]);
        for &(root, body) in &mark.sleepers {
            let body = below(body, bodies)?;
            (asleep[body], island[body]) = (true, below(root, bodies)?);
        }
        let mut contacts = Vec::new();
        for &(id, interface, gap, root) in &mark.contacts {
            let (_, p) = last.get(last.binary_search_by_key(&id, |&(id, _)| id).ok()?)?;
            let percussion = SVector::from_fn(|i, _| lit(p[i]));
            let contact = ContactStep::resting(id, below(interface, interfaces)?, lit(gap), percussion);
            contacts.push((contact, below(root, bodies)?));
        }
        self.quiet.copy_from_slice(&mark.quiet);
        (self.asleep, self.island, self.contacts) = (asleep, island, contacts);
        self.list();
        Some(())
    }
}
