//! The contact laws that come with `nonsmooth`, one file each: impact and friction for nonsmooth contact dynamics.
//!
//! They are written as those of any other crate are, against the door
//! [`nonsmooth_core::laws`](https://docs.rs/nonsmooth-core): an edit here compiles these files alone. A new law is one file
//! beside the ones here and one line in the `register!` call at the end of this page.

use nonsmooth_core::laws::{ContactLaw, Description, LawEntry, LawError, LawFamily, Scalar};

mod registry;

registry::register! {
    newton_coulomb::NewtonCoulomb,
    fremond::Fremond,
    moreau::MoreauAveraged,
    fremond_rolling::FremondRolling,
}
