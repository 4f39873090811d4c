//! The buffers of products with a Delassus operator that is not formed.

use crate::linalg::{Compensated, SolveBuffers};

/// Buffers of a product with W, kept by whoever makes products again and again: a warm solve allocates nothing.
///
/// Everything here works with an empty one as well; a formed W needs none.
#[derive(Debug, Clone)]
pub struct Workspace<T> {
    pub(super) velocities: Vec<T>,
    pub(super) solve: SolveBuffers<T>,
    /// Impulses by degree of freedom, all zero between products.
    pub(super) impulses: Vec<Compensated<T>>,
}

impl<T> Default for Workspace<T> {
    fn default() -> Self {
        Self { velocities: Vec::new(), solve: SolveBuffers::default(), impulses: Vec::new() }
    }
}
