//! The event-driven motion against exact solutions.
#![cfg(feature = "scene")]

#[path = "mechanics/example.rs"]
mod example;

use nonsmooth::event_driven::{Motion, Settings};
use nonsmooth::scene::event_driven;

fn motion<const D: usize>(name: &str, law: &str) -> Motion {
    let scene = example::scene(name);
    let run = example::run(&scene, law, "hybrid");
    let prepared = event_driven::<D>(&scene, &run).expect("an example builds");
    prepared.integrate(&Settings::default()).unwrap_or_else(|error| panic!("{name}, {law}: {error}"))
}

fn show(m: &Motion) {
    let n = m.dofs();
    let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
    println!(
        "pieces {} impacts {} changes {}",
        m.knots().count() - 1,
        m.impacts().len(),
        m.mode_changes().len()
    );
    for i in m.impacts().iter().take(6) {
        println!("  {i:?}");
    }
    for i in m.mode_changes().iter().take(30) {
        println!("  {i:?}");
    }
    m.at(m.end(), &mut q, &mut v);
    println!("end {} q {q:.17?} v {v:.17?}\n  {:?}", m.end(), m.balance(m.end()));
}

#[test]
fn explore() {
    show(&motion::<2>("impacting_stick", "newton"));
    show(&motion::<2>("impacting_stick", "fremond"));
    show(&motion::<1>("bouncing_ball", "newton"));
    show(&motion::<2>("rolling_disc", "fremond"));
    show(&motion::<2>("stick_slip", "fremond"));
    show(&motion::<1>("impact_oscillator", "fremond"));
    show(&motion::<1>("grazing_oscillator", "fremond"));
    show(&motion::<2>("rocking_block", "fremond"));
}
