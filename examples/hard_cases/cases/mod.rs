//! The hard cases, one function each, for every law, solver and scalar.

mod belt;
mod degenerate;
mod double_pendulum;
mod elastic;
mod friction;
mod impacts;
mod long;
pub(crate) mod masonry;
mod oscillator;
pub(crate) mod pendulum;
pub(crate) mod stacks;
pub(crate) mod support;

pub(crate) use support::{Case, Choice, Outcome};

/// Every case, in the order of the table.
pub(crate) fn all() -> Vec<&'static Case> {
    let groups = [
        impacts::CASES,
        pendulum::CASES,
        friction::CASES,
        stacks::CASES,
        masonry::CASES,
        belt::CASES,
        oscillator::CASES,
        elastic::CASES,
        degenerate::CASES,
        long::CASES,
    ];
    groups.into_iter().flatten().collect()
}

/// The laws of restitution and friction: the cases have no other parameter, and a law with rolling resistance is
/// Frémond's where there is none.
pub(crate) fn laws() -> impl Iterator<Item = &'static nonsmooth::laws::Description> + Clone {
    nonsmooth::laws::LAWS
        .iter()
        .filter(|law| law.parameters.iter().all(|parameter| parameter.name != "rolling"))
}
