//! Sparse block factorisation of the Newton systems: symbolic analysis once, numeric factors reused.

mod front;
mod multifrontal;
mod symbolic;

pub(crate) use multifrontal::Multifrontal;
