//! Nonsmooth contact dynamics: unilateral contact, impact and Coulomb friction, with contact laws and cone solvers
//! that plug into one step loop.
//!
//! The Moreau–Jean θ-scheme ([`scheme::ThetaScheme`]) steps a [`system::System`] under one
//! [`laws::ContactLaw`] per interface, and solves the cone problem of each step ([`cone::ConeProblem`]) with a
//! [`solver::ConeSolver`] chosen at construction. Data flows one way:
//!
//! ```text
//! scene → system → free velocity → contacts, active set → cone problem (W, b, μ) → solver
//!       → velocity and position update → energy ledger → observers
//! ```
//!
//! The crate `nonsmooth` is this one with its laws, its program and its manual; depend on that one.
//!
//! Equation numbers are those of V. Acary and N. A. Collins-Craft, "On the Moreau–Jean scheme with the Frémond
//! impact law. Energy conservation and dissipation properties for elastodynamics with contact impact and friction"
//! (2024). Local vectors are ordered (N, T1, T2); the normal points from the obstacle to the body.

pub mod adaptive;
#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "collection")]
pub mod collection;
pub mod cone;
pub mod contact;
pub mod energy;
pub mod event_driven;
#[cfg(feature = "fclib")]
pub mod fclib;
#[cfg(any(feature = "outputs", feature = "figures", feature = "fclib", feature = "vtk"))]
pub mod file;
pub mod geometry;
pub mod laws;
pub mod linalg;
pub mod mesh;
pub mod observe;
pub mod planar;
#[cfg(feature = "figures")]
pub mod plot;
pub mod registry;
#[cfg(feature = "scene")]
pub mod run;
pub mod scalar;
#[cfg(feature = "scene")]
pub mod scene;
pub mod scheme;
pub mod simulate;
pub mod solver;
#[cfg(feature = "study")]
pub mod study;
#[cfg(feature = "suite")]
pub mod suite;
pub mod system;
