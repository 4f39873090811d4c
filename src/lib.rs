//! Nonsmooth contact dynamics.

pub mod cone;
pub mod contact;
pub mod energy;
pub mod linalg;
pub mod scalar;
#[cfg(feature = "scene")]
pub mod scene;
pub mod scheme;
pub mod solver;
pub mod system;
pub use nonsmooth_laws as laws;
