//! The ledger of a step: energies, and the balance (56).

use super::active_set::ActiveSet;
use super::lasting::Lasting;
use super::matrix::Matrix;
use super::no_joints::joints_of;
use super::nonlinear::Start;
use super::record::Next;
use super::{Settings, StepError, ThetaScheme};
use crate::energy::{Balance, Energies};
use crate::linalg::{dot, sums};
use crate::scalar::{Scalar, all_finite, lit, to_f64};
use crate::system::Prescribed;

impl<T: Scalar, const D: usize> ThetaScheme<T, D> {
    pub(super) fn balance(&mut self, position_work: T) -> Result<(Energies<T>, Balance<T>), StepError> {
        let Self { system, settings, state, next, .. } = self;
        let Settings { theta, step: h, .. } = *settings;
        let half = lit::<T>(0.5);
        let mut balance = Balance { position_work, ..Balance::default() };
        let mut square;
        if let Some(nonlinear) = &self.equations.nonlinear {
            let start = Start::of(state, settings, &next.force);
            (balance.kinetic_change, balance.elastic_change, balance.damping_work, square) =
                nonlinear.changes(start, &next.v);
        } else {
            system.mass().multiply(&next.v, &mut next.momentum[1]);
            (balance.kinetic_change, square) = increments(&state.v, &next.v, &next.momentum);
        }
        if let Some(stiffness) = system.stiffness() {
            // (56) is that of the θ-step; springs that a displacement after it stretches give position work.
            let made = self.active.crossed.made().unwrap_or(&next.q);
            stiffness.multiply(made, &mut next.elastic_force[1]);
            let (elastic, stretch) = increments(&state.q, made, &next.elastic_force);
            balance.elastic_change = elastic;
            square += stretch;
            if self.active.crossed.made().is_some() {
                let before = dot(made, &next.elastic_force[1]);
                stiffness.multiply(&next.q, &mut next.elastic_force[1]);
                balance.position_work += half * (dot(&next.q, &next.elastic_force[1]) - before);
            }
        }
        balance.external_work = h * dot(&next.v_theta, &next.force);
        if let Some(damping) = system.damping() {
            damping.multiply(&next.v_theta, &mut next.scratch);
            balance.damping_work = -h * dot(&next.v_theta, &next.scratch);
        }
        let [springs, dampers, motors] = self.equations.joints.works(h);
        balance.elastic_change += springs;
        balance.damping_work += dampers;
        balance.external_work += motors;
        if let (false, Some(made)) = (self.equations.joints.is_empty(), self.active.crossed.made()) {
            let joints = joints_of(&**system);
            balance.position_work += joints.energy(&next.q) - joints.energy(made);
        }
        balance.numerical_dissipation = match self.lasting.as_ref().and_then(Lasting::theta) {
            None => (half - theta) * square,
            Some(thetas) => sums(next.v.len(), |i| {
                let change = next.momentum[1][i] - next.momentum[0][i];
                [(half - thetas[i]) * (next.v[i] - state.v[i]) * change]
            })[0],
        };
        if system.prescribed().is_some_and(Prescribed::moves) {
            balance.prescribed_work = self.prescribed_work();
        }
        let Self { system, next, .. } = self;
        for contact in &next.contacts {
            balance.normal_contact_work += contact.normal_work;
            balance.tangential_contact_work += contact.tangential_work;
        }
        balance.close();
        let (kinetic, elastic) = self.equations.nonlinear.as_ref().map_or_else(
            || {
                let stretch = system.stiffness().map(|_| dot(&next.q, &next.elastic_force[1]));
                (half * dot(&next.v, &next.momentum[1]), half * stretch.unwrap_or_else(T::zero))
            },
            |nonlinear| nonlinear.next_energies(&next.v),
        );
        let elastic = elastic + joints_of(&**system).energy(&next.q);
        let energies = Energies { kinetic, elastic, potential: system.potential(&next.q) };
        if !all_finite(&[energies.total(), balance.imbalance]) {
            let (step, time) = self.place();
            return Err(StepError::Energy { step, time, kinetic: to_f64(energies.kinetic) });
        }
        Ok((energies, balance))
    }

    /// Σ v_{k+θ}·R over the prescribed degrees of freedom, R the impulses that move them: what M (v_{k+1} − v_k) +
    /// hK q_{k+θ} + hC v_{k+θ} − hF_{k+θ} − Hᵀp leaves there. The damping force stands in `scratch`.
    fn prescribed_work(&mut self) -> T {
        let Self {
            system,
            settings: Settings { theta, step: h, .. },
            next,
            active: ActiveSet { jacobian, .. },
            matrix: Matrix { free, .. },
            ..
        } = self;
        let (theta, h) = (*theta, *h);
        let Next { v_theta, force, scratch, momentum, elastic_force, reaction, .. } = next;
        for (place, i) in (*free..v_theta.len()).enumerate() {
            let mut impulse = momentum[1][i] - momentum[0][i] - h * force[i];
            if system.stiffness().is_some() {
                impulse += h * ((T::one() - theta) * elastic_force[0][i] + theta * elastic_force[1][i]);
            }
            if system.damping().is_some() {
                impulse += h * scratch[i];
            }
            reaction[place] = impulse;
        }
        for (row, p) in self.cones.percussions.iter().enumerate() {
            for (dof, entry) in jacobian.row(row).filter(|&(dof, _)| dof >= *free) {
                reaction[dof - *free] -= entry.dot(p);
            }
        }
        self.equations.joints.take_from(*free, reaction);
        dot(&v_theta[*free..], reaction)
    }
}

/// ½(y−x)·A(y+x) and (y−x)·A(y−x), of x and y with A x and A y: the polarised forms, which do not cancel.
#[inline(always)]
fn increments<T: Scalar>(from: &[T], to: &[T], [a_from, a_to]: &[Vec<T>; 2]) -> (T, T) {
    let n = from.len();
    let (to, a_from, a_to) = (&to[..n], &a_from[..n], &a_to[..n]);
    let [change, square] = sums(n, |i| {
        let difference = to[i] - from[i];
        [difference * (a_to[i] + a_from[i]), difference * (a_to[i] - a_from[i])]
    });
    (lit::<T>(0.5) * change, square)
}
