//! The energy certificate on a sample: `cargo run --release --example energy_certificate` makes the full one.

#[path = "../examples/energy_certificate/impacts.rs"]
mod impacts;

use impacts::{Stream, impacts};
use nonsmooth::laws::LAWS;

/// Impacts per law and dimension.
const SAMPLE: usize = 3000;

fn sample<const D: usize>() {
    for law in LAWS {
        let tally = impacts::<D>(law.name, SAMPLE, &mut Stream(7 + D as u64));
        let half = vec![0.5; law.parameters.len()];
        let claims = nonsmooth::laws::build::<f64, D>(law.name, &half).expect("a law").dissipative_theta();
        assert!(tally.imbalance < 1e-12, "{}, D = {D}: {tally:?}", law.name);
        // An honest refusal of the solver says nothing of the law, but must be rare.
        assert!(tally.unsolved * 50 <= tally.systems, "{}, D = {D}: {tally:?}", law.name);
        if claims.is_some() {
            assert!(tally.worst <= 1e-13, "{}, D = {D}: {tally:?}", law.name);
        } else if D > 1 {
            assert!(
                tally.worst > 1e-3,
                "a law that claims nothing does work: {}, D = {D}: {tally:?}",
                law.name
            );
        }
    }
}

#[test]
fn no_contact_of_a_claiming_law_does_positive_work_without_friction() {
    sample::<1>();
}

#[test]
fn no_contact_of_a_claiming_law_does_positive_work_in_the_plane() {
    sample::<2>();
}

#[test]
fn no_contact_of_a_claiming_law_does_positive_work_in_space() {
    sample::<3>();
}
