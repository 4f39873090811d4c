//! Every registered law keeps its claim, with every solver, in every contact dimension.

use nonsmooth::laws::{self, ContactLaw, LAWS};
use nonsmooth::suite::{Suite, check_law_in};

const SUITE: Suite = Suite { cases: 400, regressions: Some("tests/regressions/dissipation.txt") };

fn registered_laws_keep_their_claim<const D: usize>() {
    for law in LAWS {
        let draw = |unit: &[f64]| -> Box<dyn ContactLaw<f64, D>> {
            laws::build(law.name, &law.draw(unit)).expect("drawn parameters are in range")
        };
        check_law_in::<D>(&SUITE, law.parameters.len(), &draw)
            .unwrap_or_else(|failure| panic!("law `{}`: {failure}", law.name));
    }
}

#[test]
fn frictionless_contacts_keep_the_claim_of_their_law() {
    registered_laws_keep_their_claim::<1>();
}

#[test]
fn planar_contacts_keep_the_claim_of_their_law() {
    registered_laws_keep_their_claim::<2>();
}

#[test]
fn spatial_contacts_keep_the_claim_of_their_law() {
    registered_laws_keep_their_claim::<3>();
}

/// Six rows are for laws that roll.
#[test]
fn rolling_contacts_in_space_keep_the_claim_of_their_law() {
    let draw = |unit: &[f64]| -> Box<dyn ContactLaw<f64, 6>> {
        let law = laws::describe("fremond-rolling").expect("registered");
        laws::build(law.name, &law.draw(unit)).expect("drawn parameters are in range")
    };
    let suite = Suite { cases: 100, ..SUITE };
    check_law_in::<6>(&suite, 4, &draw).unwrap_or_else(|failure| panic!("{failure}"));
}
