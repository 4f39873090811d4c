//! The free velocity, and the velocity and configuration at the end of the step.
//!
//! Over the free degrees of freedom, with prescribed ones moving as told, a step solves one of two forms of (52):
//!
//! ```text
//!   average     M̂ v_{k+θ} = M v_k + θh (F_{k+θ} − K q_k) + θ Hᵀp
//!   increment   M̂ (v_{k+1} − v_k) = h (F_{k+θ} − C v_k − K (q_k + hθ v_k)) + Hᵀp
//! ```
//!
//! The average needs M v_k and K q_k alone, which the ledger has computed: no product is made twice. It divides by θ,
//! so that small θ take the increment, and so do systems without stiffness.

use super::no_joints::joints_of;
use nalgebra::SVector;

use super::active_set::ActiveSet;
use super::cones::Cones;
use super::equations::Equations;
use super::joints::Span;
use super::lasting::Lasting;
use super::matrix::{Form, Matrix};
use super::nonlinear::Start;
use super::record::Next;
use super::{Settings, StepError, ThetaScheme};
use crate::linalg::{Factor, axpy};
use crate::scalar::{Scalar, all_finite};

impl<T: Scalar, const D: usize> ThetaScheme<T, D> {
    /// v_free of this pass, on the joints.
    pub(super) fn set_free_velocity(&mut self) -> Result<(), StepError> {
        let Self {
            system,
            settings,
            state,
            next,
            matrix: Matrix { factor, .. },
            equations: Equations { nonlinear, .. },
            ..
        } = self;
        if let (Some(nonlinear), Some(dynamics)) = (nonlinear, system.nonlinear()) {
            let start = Start::of(state, settings, &next.force);
            nonlinear.free_velocity(dynamics, start, &next.v, factor, &mut next.v_free);
        } else {
            self.solve_free_velocity();
        }
        let Self {
            system,
            settings,
            state,
            next,
            matrix: Matrix { factor, .. },
            equations: Equations { joints, .. },
            lasting,
            flight,
            ..
        } = self;
        if joints.is_empty() {
            return Ok(());
        }
        let span = Span::of(settings, state, flight.as_ref(), lasting.as_ref());
        if self.equations.passes == 0 {
            joints.start(&**system, &span, &next.v, state.time, self.equations.scales.length);
        }
        let contacts = !next.contacts.is_empty();
        if let Err(row) = joints.bind(&**system, span, contacts, factor, &mut next.v_free) {
            let (step, time) = self.place();
            return Err(StepError::Joints { step, time, joint: joints_of(&*self.system).label(row) });
        }
        Ok(())
    }

    /// v_free of a linear system.
    fn solve_free_velocity(&mut self) {
        let Self {
            system, settings, state, next, matrix: Matrix { factor, free, coupling, form, .. }, ..
        } = self;
        let (Settings { theta, step: h, .. }, free) = (*settings, *free);
        let Next { v, v_theta, v_free, force, scratch, momentum, elastic_force, .. } = next;
        if *form == Form::Increment {
            v_free[..free].copy_from_slice(&force[..free]);
            if let Some(damping) = system.damping() {
                damping.multiply(&state.v, scratch);
                axpy(&mut v_free[..free], -T::one(), scratch);
            }
            if let Some(stiffness) = system.stiffness() {
                if theta > T::zero() {
                    stiffness.multiply(&state.v, scratch);
                    axpy(&mut v_free[..free], -(h * theta), scratch);
                }
                axpy(&mut v_free[..free], -T::one(), &elastic_force[0]);
            }
            v_free[..free].iter_mut().for_each(|x| *x *= h);
            coupling.iter().for_each(|&(i, j, m)| v_free[i] -= m * (v[j] - state.v[j]));
            factor.solve_in_place(&mut v_free[..free]);
            axpy(&mut v_free[..free], T::one(), &state.v);
        } else {
            let weight = theta * h;
            for i in 0..free {
                v_free[i] = momentum[0][i] + weight * (force[i] - elastic_force[0][i]);
            }
            coupling.iter().for_each(|&(i, j, m)| v_free[i] -= m * v_theta[j]);
            match factor {
                Factor::Sparse(factor) if *form == Form::Staged => {
                    // Contacts move the last unknowns alone: nothing else is read from v_free.
                    factor.load(&v_free[..free]);
                    factor.last_unknowns(&mut v_free[..free]);
                }
                factor => factor.solve_in_place(&mut v_free[..free]),
            }
            let inverse = T::one() / theta;
            for (average, &v) in v_free[..free].iter_mut().zip(&state.v) {
                *average = v + (*average - v) * inverse;
            }
        }
    }

    /// v_{k+1}, v_{k+θ}, q_{k+1}, and what the contacts did.
    pub(super) fn set_next_state(&mut self) -> Result<(), StepError> {
        let Self {
            system,
            settings,
            state,
            next,
            matrix: Matrix { factor, free, form, .. },
            active: ActiveSet { jacobian, .. },
            cones: Cones { percussions, .. },
            equations: Equations { joints, .. },
            lasting,
            flight,
            ..
        } = self;
        let (Settings { theta, step: h, .. }, free) = (*settings, *free);
        let Next { q, place, v, v_theta, v_free, scratch, impulse, contacts, .. } = next;
        match factor {
            Factor::Sparse(factor) if *form == Form::Staged => {
                for (row, p) in percussions.iter().enumerate() {
                    for (dof, entry) in jacobian.row(row).filter(|&(dof, _)| dof < free) {
                        factor.add(dof, theta * entry.dot(p));
                    }
                }
                factor.finish(&mut v[..free]);
                let inverse = T::one() / theta;
                for (average, &v) in v[..free].iter_mut().zip(&state.v) {
                    *average = v + (*average - v) * inverse;
                }
            }
            factor => {
                v[..free].copy_from_slice(&v_free[..free]);
                impulse.fill(T::zero());
                if !contacts.is_empty() {
                    for (row, p) in percussions.iter().enumerate() {
                        jacobian.add_transpose(row, p, impulse);
                    }
                    scratch.copy_from_slice(impulse);
                    if joints.is_empty() {
                        factor.solve_in_place(&mut scratch[..free]);
                    } else {
                        joints.respond(factor, scratch);
                    }
                    axpy(&mut v[..free], T::one(), scratch);
                }
            }
        }
        match lasting.as_ref().and_then(Lasting::theta) {
            None => (0..free).for_each(|i| v_theta[i] = (T::one() - theta) * state.v[i] + theta * v[i]),
            Some(theta) => {
                (0..free).for_each(|i| v_theta[i] = (T::one() - theta[i]) * state.v[i] + theta[i] * v[i]);
            }
        }
        scratch.iter_mut().zip(&*v_theta).for_each(|(s, &v)| *s = h * v);
        let told = v.len() - free;
        if flight.is_some() {
            self.land();
        } else if told == 0 {
            system.advance(&state.q, scratch, q);
        } else {
            // What moves as told is there already.
            system.advance(&state.q, scratch, place);
            let moved = q.len() - told;
            q[..moved].copy_from_slice(&place[..moved]);
        }
        let Self {
            active: ActiveSet { jacobian, .. }, cones: Cones { percussions, .. }, lasting, next, ..
        } = self;
        let Next { v, v_theta, contacts, .. } = next;
        let thetas = lasting.as_ref().and_then(Lasting::theta);
        for (i, contact) in contacts.iter_mut().enumerate() {
            contact.percussion = percussions[i];
            contact.after = jacobian.velocity(i, v);
            let theta = contact.theta;
            let average: SVector<T, D> = match thetas {
                // What moves as told keeps the θ of the scene, whatever that of the bodies on it.
                Some(_) if told > 0 => jacobian.velocity(i, v_theta),
                _ => contact.before * (T::one() - theta) + contact.after * theta,
            };
            contact.normal_work = average[0] * contact.percussion[0];
            contact.tangential_work = average.dot(&contact.percussion) - contact.normal_work;
            if D == 1 {
                contact.tangential_work = T::zero();
            }
        }
        for (what, x) in [("v", &self.next.v), ("q", &self.next.q)] {
            if !all_finite(x) {
                return Err(self.state_error(what, x));
            }
        }
        Ok(())
    }
}
