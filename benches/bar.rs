//! Errors of the impacting bar against its exact solution, over mesh, step, θ, law, e and mass:
//! `cargo bench --bench bar`. Exact: contact for 0.6667, force 300 (300 (1 + s) under gravity), rebound +10, no
//! energy lost.

#[path = "../tests/elastic/mod.rs"]
mod elastic;

use elastic::impact;
use nonsmooth::system::MassForm;

fn main() {
    println!(
        "{:>8} {:>10} {:>8} {:>5} {:8} {:>4} {:>7}  {:>9} {:>9} {:>11} {:>9} {:>10}",
        "elements",
        "mass",
        "h c/Δx",
        "θ",
        "law",
        "e",
        "gravity",
        "time",
        "force",
        "oscillation",
        "rebound",
        "energy"
    );
    let row = |elements: usize, mass, courant: f64, theta, law: &str, e, gravity| {
        let step = courant * 10.0 / elements as f64 / 30.0;
        let got = impact((elements, mass), step, theta, (law, e), gravity);
        let mass = if mass == MassForm::Lumped { "lumped" } else { "consistent" };
        println!(
            "{elements:>8} {mass:>10} {courant:>8} {theta:>5} {law:8} {e:>4} {gravity:>7}  {:>9.5} {:>9.3} {:>11.2e} {:>9.5} {:>+10.2e}",
            got.contact_time, got.mean_force, got.oscillation, got.rebound, got.energy_change
        );
    };
    for mass in [MassForm::Consistent, MassForm::Lumped] {
        for elements in [25, 50, 100, 200, 400] {
            row(elements, mass, 0.5, 0.5, "fremond", 0.0, 0.0);
        }
    }
    for courant in [2.0, 1.0, 0.5, 0.25, 0.125] {
        row(100, MassForm::Consistent, courant, 0.5, "fremond", 0.0, 0.0);
    }
    for theta in [0.5, 0.6, 0.75, 1.0] {
        row(100, MassForm::Consistent, 0.5, theta, "fremond", 0.0, 0.0);
    }
    for law in ["newton", "fremond", "moreau"] {
        for e in [0.0, 0.5, 1.0] {
            row(100, MassForm::Consistent, 0.5, 0.5, law, e, 0.0);
        }
    }
    for elements in [50, 100, 200, 400] {
        row(elements, MassForm::Consistent, 0.5, 0.5, "fremond", 0.0, 10.0);
    }
}
