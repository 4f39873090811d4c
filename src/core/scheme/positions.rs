//! The positions that impacts leave, corrected where contacts last.
//!
//! An impact within a step leaves an overlap or a gap of up to h |u_N|, which velocities alone never take back. After a step
//! the contacts that last and overlap are opened by Δq = M̂⁻¹ H_Nᵀ π with 0 ≤ g + W_NN π ⟂ π ≥ 0, which moves no velocity.
//! The work −F·Δq = −Σ_α π_α (H_N M̂⁻¹F)_α against the forces is in the ledger
//! ([`Balance::position_work`](crate::energy::Balance)). It gives back at most what the contacts of the island have taken
//! since they began, their works and what θ > ½ took from the island, and every contact pays in proportion to what it has
//! taken: the sum over its life of its works, of its part of the numerical dissipation and of its part of the position work
//! is never positive. Bodies that overlap without having lost energy (drawn so, say) stay as they are, and a body that slides
//! in a bowl, which a step along the tangent leaves by ½ h² v²/R, comes back as far as (θ−½) ‖v_{k+1} − v_k‖²_M pays for.

use nalgebra::SVector;

use super::active_set::ActiveSet;
use super::lasting::{Entry, Lasting};
use super::record::{ContactStep, Next};
use super::{Settings, ThetaScheme};
use crate::cone::BlockMatrix;
use crate::linalg::forest::root;
use crate::linalg::{BlockRows, dot};
use crate::scalar::{Scalar, lit};

/// Sweeps over the overlaps in one step; what they leave, the next step takes.
const SWEEPS: usize = 50;

/// How far contacts are opened, in the largest overlap of their island: one may open several.
const MOST_OPENED: f64 = 2.0;

impl<T: Scalar> Lasting<T> {
    /// Gives every contact an equal part of what its island lost to θ > ½, `loss(dof, θ)` of each degree of freedom.
    fn share_losses<const D: usize>(
        &mut self,
        loss: impl Fn(usize, T) -> T,
        rows: &BlockRows<T, D>,
        contacts: usize,
    ) {
        self.sums.fill([T::zero(); 4]);
        for dof in 0..self.theta.len() {
            let island = root(&mut self.parent, dof);
            self.sums[island][0] += loss(dof, self.theta[dof]);
        }
        for row in 0..contacts {
            let Some(island) = self.island(rows, row) else { continue };
            self.sums[island][1] += T::one();
        }
        for row in 0..contacts {
            let Some(island) = self.island(rows, row) else { continue };
            let [loss, contacts, ..] = self.sums[island];
            self.entries[row].account += nalgebra::RealField::min(loss, T::zero()) / contacts;
        }
    }

    /// π of 0 ≤ g + W_NN π ⟂ π ≥ 0, by projected Gauss–Seidel.
    fn open<const D: usize>(&mut self, w: &BlockMatrix<T, D>, tolerance: T) {
        let Self { target, opening, .. } = self;
        opening.clear();
        opening.resize(target.len(), T::zero());
        for _ in 0..SWEEPS {
            let mut moved = T::zero();
            for i in 0..target.len() {
                let (mut gap, mut diagonal) = (target[i], T::zero());
                for (j, block) in w.row(i) {
                    gap += block[(0, 0)] * opening[j];
                    if i == j {
                        diagonal = block[(0, 0)];
                    }
                }
                // A row without motion opens nothing.
                if !(diagonal > T::zero()) {
                    continue;
                }
                let next = nalgebra::RealField::max(opening[i] - gap / diagonal, T::zero());
                let step = nalgebra::ComplexField::abs(next - opening[i]) * diagonal;
                moved = nalgebra::RealField::max(moved, step);
                opening[i] = next;
            }
            if moved <= tolerance {
                break;
            }
        }
    }
}

impl<T: Scalar, const D: usize> ThetaScheme<T, D> {
    /// q_{k+1} ← q_{k+1} + Δq where lasting contacts overlap; the position work, −F·Δq.
    pub(super) fn correct_positions(&mut self) -> T {
        let Self {
            system,
            settings,
            active: ActiveSet { tolerances: (tolerance, _), .. },
            state,
            next,
            lasting,
            ..
        } = self;
        let Some(lasting) = lasting else { return T::zero() };
        for (entry, contact) in lasting.entries.iter_mut().zip(&next.contacts) {
            entry.account += contact.normal_work + contact.tangential_work;
        }
        if lasting.changed || settings.theta > lit(0.5) && !next.contacts.is_empty() {
            let Next { v, momentum: [before, after], contacts, .. } = next;
            system.mass().multiply(v, after);
            let loss = |dof: usize, theta: T| {
                (lit::<T>(0.5) - theta) * (v[dof] - state.v[dof]) * (after[dof] - before[dof])
            };
            lasting.share_losses(loss, &self.active.jacobian, contacts.len());
        }
        let tolerance = nalgebra::RealField::max(*tolerance, lasting.noise(settings.step));
        let overlaps = |(contact, entry): (&ContactStep<T, D>, &Entry<T>)| {
            entry.slow && system.gap(contact.id, &next.q) < -tolerance
        };
        if !next.contacts.iter().zip(&lasting.entries).any(overlaps) {
            return T::zero();
        }
        // Contacts that do not last are not opened, but not closed further either.
        let target = |(contact, entry): (&ContactStep<T, D>, &Entry<T>)| {
            let gap = system.gap(contact.id, &next.q);
            if entry.slow { gap } else { nalgebra::RealField::max(gap, T::zero()) }
        };
        lasting.target.clear();
        lasting.target.extend(next.contacts.iter().zip(&lasting.entries).map(target));
        let Some(w) = self.cones.problem.delassus().formed() else { return T::zero() };
        lasting.open(w, tolerance);
        self.displace()
    }

    /// Moves the bodies by the openings found, as far as their islands can pay for.
    fn displace(&mut self) -> T {
        let Self {
            system,
            settings: Settings { step: h, .. },
            next,
            lasting,
            active: ActiveSet { jacobian, .. },
            ..
        } = self;
        let (factor, free, joints) = (&mut self.matrix.factor, &self.matrix.free, &mut self.equations.joints);
        let (Some(lasting), Some(w)) = (lasting, self.cones.problem.delassus().formed()) else {
            return T::zero();
        };
        let Next { q, place, v_free, force, scratch, impulse, contacts, .. } = next;
        // H_N M̂⁻¹F, the acceleration that pulls a contact open.
        let pull = |row: usize, contact: &ContactStep<T, D>| {
            (jacobian.velocity(row, v_free)[0] - contact.before[0]) / *h
        };
        let larger = nalgebra::RealField::max;
        lasting.sums.fill([T::zero(); 4]);
        for (row, contact) in contacts.iter().enumerate() {
            let Some(island) = lasting.island(jacobian, row) else { continue };
            let opens =
                w.row(row).fold(T::zero(), |sum, (j, block)| sum + block[(0, 0)] * lasting.opening[j]);
            let sums = &mut lasting.sums[island];
            sums[0] -= lasting.entries[row].account;
            sums[1] -= lasting.opening[row] * pull(row, contact);
            sums[2] = larger(sums[2], opens);
            sums[3] = larger(sums[3], -lasting.target[row]);
        }
        impulse.fill(T::zero());
        for row in 0..contacts.len() {
            let Some(island) = lasting.island(jacobian, row) else { continue };
            let [taken, given, opened, overlap] = lasting.sums[island];
            let part = |of: T, most: T| if of > most { most / of } else { T::one() };
            // Overlaps that contradict each other, of what is wedged, would throw the rest about.
            let share = part(opened, lit::<T>(MOST_OPENED) * overlap);
            let share = nalgebra::RealField::min(share, part(given, larger(taken, T::zero())));
            // Every contact of the island pays in proportion to what it has taken.
            if taken > T::zero() {
                lasting.entries[row].account *= (taken - share * given) / taken;
            }
            let mut opening = SVector::<T, D>::zeros();
            opening[0] = lasting.opening[row] * share;
            jacobian.add_transpose(row, &opening, impulse);
        }
        scratch.copy_from_slice(impulse);
        if joints.is_empty() {
            // What moves as told moves by nothing else.
            scratch[*free..].fill(T::zero());
            factor.solve_in_place(&mut scratch[..*free]);
            place.copy_from_slice(q);
            system.advance(place, scratch, q);
            return -dot(force, scratch);
        }
        joints.respond(factor, scratch);
        place.copy_from_slice(q);
        system.advance(place, scratch, q);
        joints.close(&**system, factor, place, q);
        system.difference(place, q, scratch);
        -dot(force, scratch)
    }
}
