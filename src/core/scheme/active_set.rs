//! The active set: the candidates of a step, and H of those that are active.

use super::crossed::Crossed;
use crate::contact::Candidate;
use crate::linalg::BlockRows;
use crate::scalar::Scalar;

/// The contacts of the step being made.
#[derive(Debug)]
pub(super) struct ActiveSet<T: Scalar, const D: usize> {
    pub(super) candidates: Vec<Candidate<T>>,
    /// H of the active contacts, in their order.
    pub(super) jacobian: BlockRows<T, D>,
    /// What the step would cross.
    pub(super) crossed: Crossed<T, D>,
    /// (gap, velocity).
    pub(super) tolerances: (T, T),
}

impl<T: Scalar, const D: usize> ActiveSet<T, D> {
    pub(super) fn new(coordinates: usize, dofs: usize, tolerances: (T, T)) -> Self {
        let crossed = Crossed::new(coordinates, dofs);
        Self { candidates: Vec::new(), jacobian: BlockRows::new(), crossed, tolerances }
    }
}
