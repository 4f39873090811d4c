//! The buffers of products with a factored W.

use std::sync::Mutex;

use crate::linalg::{Compensated, SolveBuffers};

/// Buffers of a product with W.
#[derive(Debug, Clone)]
pub(crate) struct Product<T> {
    pub(super) velocities: Vec<T>,
    pub(super) solve: SolveBuffers<T>,
    /// Impulses by degree of freedom, all zero between products.
    pub(super) impulses: Vec<Compensated<T>>,
}

/// The buffers of a problem's own products, taken by whoever comes first; another at the same time makes its own.
#[derive(Debug)]
pub(super) struct Scratch<T>(Mutex<Option<Product<T>>>);

impl<T> Default for Scratch<T> {
    fn default() -> Self {
        Self(Mutex::new(None))
    }
}

/// A copy of a problem has buffers of its own.
impl<T> Clone for Scratch<T> {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// Buffers hold nothing that could differ.
impl<T> PartialEq for Scratch<T> {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl<T> Scratch<T> {
    pub(super) fn take(&self) -> Product<T> {
        self.0.try_lock().ok().and_then(|mut product| product.take()).unwrap_or_default()
    }

    pub(super) fn give_back(&self, product: Product<T>) {
        if let Ok(mut place) = self.0.try_lock() {
            *place = Some(product);
        }
    }
}

impl<T> Default for Product<T> {
    fn default() -> Self {
        Self { velocities: Vec::new(), solve: SolveBuffers::default(), impulses: Vec::new() }
    }
}
