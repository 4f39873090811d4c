//! Nonsmooth contact dynamics.

pub mod cone;
#[cfg(feature = "fclib")]
pub mod fclib;
pub mod scalar;
pub mod solver;
pub use nonsmooth_laws as laws;
