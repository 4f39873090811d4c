//! A step as joints see it, and an iterate for its end.

use crate::scalar::{Scalar, lit};
use crate::scheme::flight::Flight;
use crate::scheme::lasting::Lasting;
use crate::scheme::{Settings, State};

/// A step as joints see it: where it starts, its length, and θ of each degree of freedom.
#[derive(Debug, Clone, Copy)]
pub(in crate::scheme) struct Span<'a, T, F> {
    pub(in crate::scheme) q: &'a [T],
    pub(in crate::scheme) v: &'a [T],
    pub(in crate::scheme) step: T,
    pub(in crate::scheme) theta: F,
}

impl<'a, T: Scalar> Span<'a, T, ()> {
    /// The step from `state`, or from where its first flight began, with the θ of the island each degree of freedom is in.
    pub(in crate::scheme) fn of(
        settings: &Settings<T>,
        state: &'a State<T>,
        flight: Option<&'a Flight<T>>,
        lasting: Option<&'a Lasting<T>>,
    ) -> Span<'a, T, impl Fn(usize) -> T + use<'a, T>> {
        let (theta, thetas) = (settings.theta, lasting.and_then(Lasting::theta));
        let theta = move |dof: usize| thetas.map_or(theta, |thetas| thetas[dof]);
        let q = flight.map_or(&state.q, |flight| &flight.q);
        Span { q, v: &state.v, step: settings.step, theta }
    }
}

/// An iterate: velocities, multipliers of the joints, and the impulse Hᵀp of the contacts.
#[derive(Debug)]
pub(super) struct Iterate<T> {
    pub(super) v: Vec<T>,
    pub(super) multipliers: Vec<T>,
    pub(super) impulse: Vec<T>,
}

impl<T: Scalar> Iterate<T> {
    pub(super) fn new(rows: usize, dofs: usize) -> Self {
        let zeros = |n: usize| vec![T::zero(); n];
        Self { v: zeros(dofs), multipliers: zeros(rows), impulse: zeros(dofs) }
    }

    pub(super) fn set(&mut self, other: &Self) {
        self.v.copy_from_slice(&other.v);
        self.multipliers.copy_from_slice(&other.multipliers);
        self.impulse.copy_from_slice(&other.impulse);
    }

    /// Velocities and multipliers, one after another.
    pub(super) fn pack(&self, out: &mut [T]) {
        let (v, multipliers) = out.split_at_mut(self.v.len());
        v.copy_from_slice(&self.v);
        multipliers.copy_from_slice(&self.multipliers);
    }

    /// Takes what [`pack`](Self::pack) wrote.
    pub(super) fn unpack(&mut self, from: &[T]) {
        let (v, multipliers) = from.split_at(self.v.len());
        self.v.copy_from_slice(v);
        self.multipliers.copy_from_slice(multipliers);
    }

    /// The point midway to another.
    pub(super) fn approach(&mut self, other: &Self) {
        let half = lit::<T>(0.5);
        let middle = |x: &mut [T], y: &[T]| x.iter_mut().zip(y).for_each(|(x, &y)| *x = (*x + y) * half);
        middle(&mut self.v, &other.v);
        middle(&mut self.multipliers, &other.multipliers);
        middle(&mut self.impulse, &other.impulse);
    }
}
