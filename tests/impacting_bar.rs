//! The impacting bar against its exact solution (Doyen, Ern & Piperno 2011): contact for 2L/c = 2/3, force ρcA v₀ =
//! 300, rebound at v₀.

mod elastic;

use elastic::{Impact, impact};
use nonsmooth::system::MassForm;

const CONTACT: f64 = 2.0 / 3.0;

/// Half the Courant step.
fn step(elements: usize) -> f64 {
    0.5 * 10.0 / elements as f64 / 30.0
}

fn run(elements: usize, gravity: f64) -> Impact {
    impact((elements, MassForm::Consistent), step(elements), 0.5, ("fremond", 0.0), gravity)
}

/// The slope of log e against log n by least squares.
fn order(elements: &[usize], errors: &[f64]) -> f64 {
    let points: Vec<(f64, f64)> =
        elements.iter().zip(errors).map(|(&n, e)| ((n as f64).ln(), e.ln())).collect();
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    -mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x).powi(2))
}

const MESHES: [usize; 4] = [50, 100, 200, 400];

#[test]
fn contact_time_force_rebound_and_energy_converge() {
    let runs = MESHES.map(|n| run(n, 0.0));
    let errors = |of: &dyn Fn(&Impact) -> f64| runs.each_ref().map(of);
    let time = errors(&|run| (run.contact_time - CONTACT).abs());
    let force = errors(&|run| (run.mean_force - 300.0).abs() / 300.0);
    let rebound = errors(&|run| (run.rebound - 10.0).abs() / 10.0);
    let energy = errors(&|run| run.energy_change.abs());
    let oscillation = errors(&|run| run.oscillation);
    println!(
        "time {time:?}\nforce {force:?}\nrebound {rebound:?}\nenergy {energy:?}\noscillation {oscillation:?}"
    );
    for (what, errors, slowest) in
        [("time", time, 0.5), ("force", force, 0.5), ("rebound", rebound, 0.5), ("energy", energy, 0.9)]
    {
        let order = order(&MESHES, &errors);
        println!("{what}: order {order:.2}");
        assert!(order > slowest, "{what}: order {order:.2}, errors {errors:?}");
    }
    assert!(oscillation[3] < 1e-2, "the force is smooth away from the wave fronts: {oscillation:?}");
}

#[test]
fn the_end_mass_is_lost_at_the_impact_and_nothing_else() {
    // e = 0 takes the kinetic energy of the effective mass of the end, ½ m v₀², which vanishes with the mesh.
    for elements in MESHES {
        let run = run(elements, 0.0);
        let element = 10.0 / elements as f64 * 100.0 / 2.0 / 500.0;
        assert!(run.energy_change <= 1e-12, "no energy is made: {:e}", run.energy_change);
        assert!(-run.energy_change <= element, "less than that of an element: {:e}", run.energy_change);
    }
}

#[test]
fn under_gravity_the_force_rises_as_the_exact_one() {
    let runs = MESHES.map(|n| run(n, 10.0));
    // 300 (1 + s) over 2/3: the mean is 400.
    let errors = runs.each_ref().map(|run| (run.mean_force - 400.0).abs() / 400.0);
    let rebound = runs.each_ref().map(|run| (run.rebound - 10.0).abs() / 10.0);
    println!("force {errors:?}\nrebound {rebound:?}");
    assert!(order(&MESHES, &errors) > 0.5, "{errors:?}");
    assert!(order(&MESHES, &rebound) > 0.5, "{rebound:?}");
    assert!(runs[3].oscillation < 1e-2, "{}", runs[3].oscillation);
}
