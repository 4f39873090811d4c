//! Accelerations: M a = F − C v − K q + Hᵀ λ, with the forces λ that keep every held contact in its mode.

use nalgebra::{DMatrix, DVector, SVector};

use super::local::{Local, WithModes};
use super::piece::{TOTALS, Totals};
use super::{EventFailure, Mode};
use crate::contact::{Candidate, ContactId};
use crate::linalg::{BlockRows, Factor, dot, max_abs};
use crate::system::System;

/// A closed contact with its mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Held {
    pub(super) id: ContactId,
    pub(super) interface: usize,
    pub(super) friction: f64,
    pub(super) mode: Mode,
    /// Forces (N, T) inside the cones that those of redundant contacts are nearest to; zero where none is known.
    pub(super) reference: [f64; 2],
}

/// The vectors that the references of contacts are.
pub(super) fn references<const D: usize>(contacts: &[Held]) -> Vec<SVector<f64, D>> {
    contacts.iter().map(|held| SVector::from_fn(|d, _| held.reference[d.min(1)])).collect()
}

/// H of some contacts, M⁻¹ Hᵀ and W = H M⁻¹ Hᵀ.
#[derive(Debug)]
pub(super) struct Frame {
    pub(super) h: DMatrix<f64>,
    pub(super) inverse: DMatrix<f64>,
    pub(super) w: DMatrix<f64>,
}

/// The acceleration and what comes with it.
#[derive(Debug)]
pub(super) struct Evaluation<const D: usize> {
    pub(super) acceleration: Vec<f64>,
    /// Forces λ of the held contacts (N).
    pub(super) forces: Vec<SVector<f64, D>>,
    /// Velocities u of the held contacts (m/s).
    pub(super) velocities: Vec<SVector<f64, D>>,
    /// Rates of the totals.
    pub(super) rates: [f64; TOTALS],
}

/// The system with the factors of its mass.
#[derive(Debug)]
pub(super) struct Equations<const D: usize> {
    pub(super) system: Box<dyn System<f64, D>>,
    factor: Factor<f64>,
    /// √M_ii, the unit of component i in norms.
    pub(super) weights: Vec<f64>,
    /// Length (m) over which gaps vary.
    length: f64,
    /// A time inside the stretch on which F is smooth.
    pub(super) inside: f64,
    rows: BlockRows<f64, D>,
    found: Vec<Candidate<f64>>,
    external: Vec<f64>,
    scratch: Vec<f64>,
}

impl<const D: usize> Equations<D> {
    pub(super) fn new(system: Box<dyn System<f64, D>>, factor: Factor<f64>, length: f64) -> Self {
        let n = system.dofs();
        let mut weights = vec![0.0; n];
        system.mass().entries().filter(|(i, j, _)| i == j).for_each(|(i, _, m)| weights[i] = m.sqrt());
        Self {
            system,
            factor,
            weights,
            length,
            inside: 0.0,
            rows: BlockRows::new(),
            found: Vec::new(),
            external: vec![0.0; n],
            scratch: vec![0.0; n],
        }
    }

    /// Every candidate with a gap of at most `reach`, by identity.
    pub(super) fn candidates(&mut self, q: &[f64], reach: f64) -> Result<&[Candidate<f64>], EventFailure> {
        self.found.clear();
        self.system.candidates(q, reach, &mut self.found);
        self.found.sort_unstable_by_key(|candidate| candidate.id);
        match self.found.iter().find(|candidate| !candidate.gap.is_finite()) {
            Some(candidate) => {
                let contact = self.system.contact_label(candidate.id);
                Err(EventFailure::NotFinite { what: "gap", contact })
            }
            None => Ok(&self.found),
        }
    }

    /// u = H v of one contact.
    pub(super) fn velocity(&mut self, id: ContactId, q: &[f64], v: &[f64]) -> SVector<f64, D> {
        self.rows.clear();
        self.system.jacobian(id, q, &mut self.rows);
        self.rows.velocity(0, v)
    }

    /// H, M⁻¹Hᵀ and W of the contacts `ids`.
    pub(super) fn frame(
        &mut self,
        ids: impl Iterator<Item = ContactId>,
        q: &[f64],
    ) -> Result<Frame, EventFailure> {
        let n = q.len();
        self.rows.clear();
        for id in ids {
            self.system.jacobian(id, q, &mut self.rows);
            let row = self.rows.rows() - 1;
            let finite = self.rows.row(row).all(|(_, h)| h.iter().all(|h| h.is_finite()));
            if !finite || self.rows.largest_column(row).is_some_and(|column| column >= n) {
                let contact = self.system.contact_label(id);
                return Err(EventFailure::NotFinite { what: "Jacobian", contact });
            }
        }
        let mut h = DMatrix::zeros(self.rows.rows() * D, n);
        for row in 0..self.rows.rows() {
            for (column, entry) in self.rows.row(row) {
                (0..D).for_each(|d| h[(row * D + d, column)] += entry[d]);
            }
        }
        let mut inverse = h.transpose();
        for mut column in inverse.column_iter_mut() {
            self.factor.solve_in_place(column.as_mut_slice());
        }
        let w = &h * &inverse;
        let w = (&w + w.transpose()) * 0.5;
        Ok(Frame { h, inverse, w })
    }

    /// M⁻¹ (F − C v − K q), and F in `self.external`.
    fn free_acceleration(&mut self, time: f64, q: &[f64], v: &[f64]) -> Vec<f64> {
        self.system.forces().continued(time, self.inside, &mut self.external);
        let mut a = self.external.clone();
        for (operator, x) in [(self.system.damping(), v), (self.system.stiffness(), q)] {
            if let Some(operator) = operator {
                operator.multiply(x, &mut self.scratch);
                a.iter_mut().zip(&self.scratch).for_each(|(a, y)| *a -= y);
            }
        }
        self.factor.solve_in_place(&mut a);
        a
    }

    /// Ḣ v, the derivative of H(q + εv) v at ε = 0 by Ridders' extrapolation of central differences (1982,
    /// doi:10.1016/S0141-1195(82)80057-0): to some 1e-14 of ‖v‖²/length, and exact for a constant H.
    fn bias(&mut self, id: ContactId, q: &[f64], v: &[f64]) -> SVector<f64, D> {
        const LEVELS: usize = 6;
        let speed = max_abs(v);
        if speed == 0.0 {
            return SVector::zeros();
        }
        let mut epsilon = 0.4 * self.length.min(1.0) / speed;
        let mut at = |epsilon: f64| {
            let mut moved = std::mem::take(&mut self.scratch);
            moved.copy_from_slice(q);
            moved.iter_mut().zip(v).for_each(|(q, v)| *q += epsilon * v);
            let u = self.velocity(id, &moved, v);
            self.scratch = moved;
            u
        };
        let mut previous: Vec<SVector<f64, D>> = Vec::new();
        let (mut best, mut error) = (SVector::zeros(), f64::INFINITY);
        for _ in 0..LEVELS {
            let (ahead, behind) = (at(epsilon), at(-epsilon));
            let mut row = vec![(ahead - behind) / (2.0 * epsilon)];
            if previous.is_empty() && row[0] == SVector::<f64, D>::zeros() {
                return row[0];
            }
            let mut power = 4.0;
            for (k, &coarse) in previous.iter().enumerate() {
                let finer = (row[k] * power - coarse) / (power - 1.0);
                let miss = (finer - row[k]).amax().max((finer - coarse).amax());
                if miss < error {
                    (best, error) = (finer, miss);
                }
                row.push(finer);
                power *= 4.0;
            }
            previous = row;
            epsilon *= 0.5;
        }
        best
    }

    /// The problem of the accelerations of the contacts `ids`: w = W λ + b with b = H a_free + Ḣ v, and a_free.
    pub(super) fn contact_accelerations(
        &mut self,
        time: f64,
        q: &[f64],
        v: &[f64],
        contacts: &[Held],
    ) -> Result<(Local<D>, Frame, Vec<f64>), EventFailure> {
        let free = self.free_acceleration(time, q, v);
        let frame = self.frame(contacts.iter().map(|contact| contact.id), q)?;
        let mut b = &frame.h * DVector::from_column_slice(&free);
        for (i, contact) in contacts.iter().enumerate() {
            let bias = self.bias(contact.id, q, v);
            (0..D).for_each(|d| b[i * D + d] += bias[d]);
        }
        let friction = contacts.iter().map(|contact| contact.friction).collect();
        Ok((Local { w: frame.w.clone(), b, friction }, frame, free))
    }

    /// The acceleration at (q, v), with every held contact kept in its mode.
    pub(super) fn evaluate(
        &mut self,
        time: f64,
        q: &[f64],
        v: &[f64],
        held: &[Held],
    ) -> Result<Evaluation<D>, EventFailure> {
        let mut rates = Totals::default();
        let (acceleration, forces, velocities);
        if held.is_empty() {
            acceleration = self.free_acceleration(time, q, v);
            (forces, velocities) = (Vec::new(), Vec::new());
        } else {
            let (local, frame, free) = self.contact_accelerations(time, q, v, held)?;
            let modes: Vec<Mode> = held.iter().map(|contact| contact.mode).collect();
            let solution = local.shared(&modes, &references(held));
            let solution = solution.ok_or(EventFailure::Inconsistent { contacts: held.len() })?;
            let WithModes { p, .. } = solution;
            let flat = DVector::from_iterator(p.len() * D, p.iter().flat_map(|p| p.iter().copied()));
            let a = DVector::from_vec(free) + &frame.inverse * flat;
            let u = &frame.h * DVector::from_column_slice(v);
            velocities = (0..p.len()).map(|i| SVector::from_fn(|d, _| u[i * D + d])).collect::<Vec<_>>();
            for (p, u) in p.iter().zip(&velocities) {
                for d in 0..D.min(2) {
                    rates.percussion[d] += p[d];
                    rates.contact[d] += p[d] * u[d];
                }
            }
            acceleration = a.as_slice().to_vec();
            forces = p;
        }
        rates.external = dot(&self.external, v);
        if let Some(damping) = self.system.damping() {
            damping.multiply(v, &mut self.scratch);
            rates.damping = -dot(&self.scratch, v);
        }
        Ok(Evaluation { acceleration, forces, velocities, rates: rates.to_array() })
    }
}
