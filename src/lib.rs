//! Nonsmooth contact dynamics.

pub mod cone;
mod linalg;
pub mod scalar;
pub mod solver;
pub use nonsmooth_laws as laws;
