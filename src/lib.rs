//! Nonsmooth contact dynamics: unilateral contact, impact and Coulomb friction, with contact laws and cone solvers
//! that plug into one step loop.
//!
//! Three crates make it, so that an edit compiles little: [`nonsmooth_core`] holds schemes, solvers, systems, scenes and
//! outputs, and knows no law; `laws` holds the laws, each a file; this one puts them together, with the program
//! `nonsmooth` and the manual, [`guide`]. Everything is found under the names of this crate.
//!
//! ```
//! use nonsmooth::laws::Fremond;
//!
//! let registry = nonsmooth::registry();
//! assert!(registry.laws().any(|law| law.name == "fremond"));
//! let law = Fremond::new(0.5, 0.3)?;
//! # Ok::<(), nonsmooth::laws::LawError>(())
//! ```

#[doc(no_inline)]
pub use nonsmooth_core::*;

#[cfg(any(doc, doctest))]
pub mod guide;

/// The laws of this crate, and what a law is: see [`ContactLaw`](laws::ContactLaw).
pub mod laws {
    #[doc(inline)]
    pub use nonsmooth_core::laws::*;
    #[doc(inline)]
    pub use nonsmooth_laws::*;
}

/// The laws and the solvers that come with this crate; one's own are added to it.
pub fn registry() -> registry::Registry {
    let known = registry::Registry::solvers_only();
    nonsmooth_laws::families()
        .into_iter()
        .fold(known, |known, law| known.law(law).expect("the names of the built-in laws differ"))
}

/// The README's programs compile and run.
#[cfg(all(doctest, feature = "scene"))]
#[doc = include_str!("../README.md")]
struct Readme;
