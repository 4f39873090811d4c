//! Systems that turn by themselves: the step between two flights.
//!
//! The velocities of a body that turns in space change without any force, J ω̇ + ω × J ω = 0 in its own frame. A step of such
//! a system ([`Dynamics::flies`](crate::system::Dynamics)) is split,
//!
//! ```text
//!   A((1−θ)h) ∘ C(h) ∘ A(θh)
//! ```
//!
//! with the free flight A, which keeps the kinetic energy and the angular momentum, and the linear step C of this scheme at the
//! configuration q_m between the two flights: M (v'−v) = hF + H(q_m)ᵀp with velocities v before and v' after the contacts. The
//! balance (56) of C is that of the step, for any θ and any law, because A changes neither the kinetic energy nor, beside
//! moving bodies, the potential: the translations of both flights together are h v_{k+θ}, over which the forces work. The sign
//! a law claims for its works u_{k+θ}·p = (H(q_m) v_θ)·p is that of the linear scheme, and a percussion p at the arm r changes
//! the angular momentum by r × p exactly.
//!
//! Bodies in joints take no flights, see [`Dynamics::land`](crate::system::Dynamics::land): between the ends of the step they
//! go one way, q_k ⊕ h v_{k+θ}, along which the rows of the joints are discrete derivatives. q_m = q_k ⊕ (1−θ)h v_k is then where
//! their contacts are looked at.
//!
//! The θ of an island is known when its contacts are, after the first flight, which takes it to be that of the last step. Where
//! it is another the step flies again from its start, and takes H and the velocities of the contacts there.

use super::active_set::ActiveSet;
use super::lasting::Lasting;
use super::{Settings, ThetaScheme};
use crate::scalar::Scalar;
use crate::system::Dynamics;

/// The state at the start of a step, which the first flight leads away from.
#[derive(Debug)]
pub(super) struct Flight<T> {
    pub(super) q: Vec<T>,
    v: Vec<T>,
    /// v_{k+1}, behind the second flight.
    pub(super) after: Vec<T>,
    /// θ of every degree of freedom, of the last step until that of this one is known.
    theta: Vec<T>,
    /// How long every degree of freedom flies (s).
    times: Vec<T>,
}

impl<T: Scalar> Flight<T> {
    /// `None` for systems that do not fly.
    pub(super) fn new(system: &dyn Dynamics<T>, theta: T) -> Option<Self> {
        let zeros = |count: usize| vec![T::zero(); count];
        let n = system.dofs();
        system.flies().then(|| Self {
            q: zeros(system.coordinates()),
            v: zeros(n),
            after: zeros(n),
            theta: vec![theta; n],
            times: zeros(n),
        })
    }

    /// s ← the way ahead of q_m with velocities v in a step of length h.
    pub(super) fn ahead(&self, h: T, v: &[T], s: &mut [T]) {
        for (s, (&v, &theta)) in s.iter_mut().zip(v.iter().zip(&self.theta)) {
            *s = theta * h * v;
        }
    }

    fn set_times(&mut self, share: impl Fn(T) -> T) {
        self.times.iter_mut().zip(&self.theta).for_each(|(time, &theta)| *time = share(theta));
    }

    /// The degrees of freedom with another θ than that of the scene.
    pub(super) fn mark(&self, theta: T) -> Vec<u64> {
        let other = self.theta.iter().enumerate().filter(|&(_, &of)| of != theta);
        other.map(|(dof, _)| dof as u64).collect()
    }

    /// Goes to a mark, whose degrees of freedom take θ of rest; whether it is one of this scene.
    pub(super) fn restore(&mut self, mark: &[u64], theta: T, rest: T) -> Option<()> {
        self.theta.fill(theta);
        for &dof in mark {
            *self.theta.get_mut(usize::try_from(dof).ok()?)? = rest;
        }
        Some(())
    }
}

impl<T: Scalar, const D: usize> ThetaScheme<T, D> {
    /// (q, v) ← A((1−θ)h)(q_k, v_k).
    pub(super) fn take_off(&mut self) {
        let Self { settings: Settings { step: h, .. }, state, flight, .. } = self;
        let Some(flight) = flight else { return };
        flight.q.copy_from_slice(&state.q);
        flight.v.copy_from_slice(&state.v);
        flight.set_times(|theta| (T::one() - theta) * *h);
        self.fly();
    }

    fn fly(&mut self) {
        let Self { system, state, next, flight, .. } = self;
        let Some(Flight { times, .. }) = flight else { return };
        system.fly(times, &mut state.q, &mut state.v);
        system.mass().multiply(&state.v, &mut next.momentum[0]);
    }

    /// Flies again where islands have another θ than that of the last step, and takes their contacts as they are there.
    pub(super) fn fly_again(&mut self) {
        let Self { settings: Settings { theta, step: h, .. }, state, flight, lasting, .. } = self;
        let Some(flight) = flight else { return };
        let thetas = lasting.as_ref().and_then(Lasting::theta);
        let now = |dof: usize| thetas.map_or(*theta, |thetas| thetas[dof]);
        if flight.theta.iter().enumerate().all(|(dof, &guess)| guess == now(dof)) {
            return;
        }
        flight.theta.iter_mut().enumerate().for_each(|(dof, theta)| *theta = now(dof));
        flight.set_times(|theta| (T::one() - theta) * *h);
        state.q.copy_from_slice(&flight.q);
        state.v.copy_from_slice(&flight.v);
        self.fly();
        let Self { system, state, next, active: ActiveSet { jacobian, .. }, .. } = self;
        jacobian.clear();
        for (row, contact) in next.contacts.iter_mut().enumerate() {
            system.jacobian(contact.id, &state.q, jacobian);
            contact.before = jacobian.velocity(row, &state.v);
        }
    }

    /// The state at the start of the step again.
    #[cold]
    pub(super) fn fall_back(&mut self) {
        let Self { system, state, next, flight, .. } = self;
        let Some(Flight { q, v, .. }) = flight else { return };
        state.q.copy_from_slice(q);
        state.v.copy_from_slice(v);
        system.mass().multiply(&state.v, &mut next.momentum[0]);
    }

    /// q_{k+1} and v_{k+1} of the velocities before and after the contacts.
    pub(super) fn land(&mut self) {
        let Self { system, settings: Settings { step: h, .. }, state, next, flight, .. } = self;
        let Some(flight) = flight else { return };
        flight.set_times(|theta| theta * *h);
        let Flight { q, times, after, .. } = flight;
        next.q.copy_from_slice(&state.q);
        after.copy_from_slice(&next.v);
        // h v_{k+θ} stands in `scratch`.
        system.land(q, &next.scratch, times, &mut next.q, after);
    }

    /// How long the velocities of the state lead on to the end of the step (s): all of it without a flight before.
    pub(super) fn ahead(&self) -> T {
        let Settings { theta, step: h, .. } = self.settings;
        if self.flight.is_some() { theta * h } else { h }
    }
}
