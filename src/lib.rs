//! Nonsmooth contact dynamics.

pub mod cone;
pub mod contact;
pub mod energy;
#[cfg(feature = "fclib")]
pub mod fclib;
#[cfg(any(feature = "outputs", feature = "figures"))]
pub mod file;
pub mod linalg;
pub mod observe;
#[cfg(feature = "figures")]
pub mod plot;
pub mod scalar;
#[cfg(feature = "scene")]
pub mod scene;
pub mod scheme;
pub mod simulate;
pub mod solver;
pub mod system;
pub use nonsmooth_laws as laws;
