//! What a step has to solve beside its contacts: joints and nonlinear terms, in passes.

use super::joints::Bilateral;
use super::nonlinear::Nonlinear;
use crate::scalar::Scalar;
use crate::system::Scales;

/// Joints and nonlinear terms of the step being made.
#[derive(Debug)]
pub(super) struct Equations<T: Scalar> {
    pub(super) joints: Bilateral<T>,
    pub(super) nonlinear: Option<Box<Nonlinear<T>>>,
    /// Passes made over the step being made, beyond the first.
    pub(super) passes: usize,
    /// What the last pass left of the equations of motion.
    pub(super) left_over: T,
    /// Length (m) that scales the tolerance of the joints, and speed (m/s) of the differences of a nonlinear system.
    pub(super) scales: Scales<T>,
}
