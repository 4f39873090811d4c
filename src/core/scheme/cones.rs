//! The cone problem of a step, and what it starts from.

use nalgebra::SVector;

use super::arms::Arms;
use super::delassus::Assembler;
use super::islands::Islands;
use super::record::ContactStep;
use crate::cone::ConeProblem;
use crate::scalar::Scalar;

/// The cone problem of the step being made, and its solution.
#[derive(Debug)]
pub(super) struct Cones<T: Scalar, const D: usize> {
    pub(super) problem: ConeProblem<T, D>,
    pub(super) assembler: Assembler<T, D>,
    pub(super) islands: Islands<T, D>,
    pub(super) arms: Arms<T>,
    pub(super) percussions: Vec<SVector<T, D>>,
}

impl<T: Scalar, const D: usize> Cones<T, D> {
    pub(super) fn new(dofs: usize, free: usize, arms: Arms<T>) -> Self {
        Self {
            problem: ConeProblem::default(),
            assembler: Assembler::new(dofs, free),
            islands: Islands::default(),
            arms,
            percussions: Vec::new(),
        }
    }
}

/// Where the solver starts: percussions of the steps before.
#[derive(Debug)]
pub(super) struct WarmStart<T: Scalar, const D: usize> {
    /// Percussions of the last step, by the contacts of this one, and of the step before it.
    pub(super) last: Vec<SVector<T, D>>,
    pub(super) before: Vec<SVector<T, D>>,
    /// Contacts of the step before the last.
    pub(super) contacts: Vec<ContactStep<T, D>>,
    /// Length of the last step (s).
    pub(super) length: T,
}

impl<T: Scalar, const D: usize> WarmStart<T, D> {
    pub(super) fn new(length: T) -> Self {
        Self { last: Vec::new(), before: Vec::new(), contacts: Vec::new(), length }
    }
}
