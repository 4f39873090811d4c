//! Event-driven motions: how they are made, asked and compared.

use nonsmooth::energy::Balance;
use nonsmooth::event_driven::{Motion, Settings, integrate};
use nonsmooth::laws::{self, ContactLaw};
use nonsmooth::solver::{self, ConeSolver, Stopping};
use nonsmooth::system::System;

/// Rounding of a computation of a few dozen operations on numbers of the given size.
pub(crate) fn rounding(size: f64) -> f64 {
    64.0 * f64::EPSILON * size
}

pub(crate) fn law<const D: usize>(
    name: &str,
    restitution: f64,
    friction: f64,
) -> Box<dyn ContactLaw<f64, D>> {
    laws::build(name, &[restitution, friction]).expect("a registered law")
}

pub(crate) fn hybrid<const D: usize>() -> Box<dyn ConeSolver<f64, D>> {
    solver::build("hybrid", Stopping::default()).expect("a registered solver")
}

/// The motion of a system with one law, from time 0.
pub(crate) fn motion<const D: usize>(
    system: impl System<f64, D> + 'static,
    law: Box<dyn ContactLaw<f64, D>>,
    (q, v): (&[f64], &[f64]),
    end: f64,
) -> Motion {
    integrate(Box::new(system), vec![law], hybrid(), 0.0, q.to_vec(), v.to_vec(), end, &Settings::default())
        .unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn state(motion: &Motion, time: f64) -> (Vec<f64>, Vec<f64>) {
    let n = motion.dofs();
    let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
    motion.at(time, &mut q, &mut v);
    (q, v)
}

#[allow(dead_code)]
pub(crate) fn before(motion: &Motion, time: f64) -> (Vec<f64>, Vec<f64>) {
    let n = motion.dofs();
    let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
    motion.before(time, &mut q, &mut v);
    (q, v)
}

#[track_caller]
pub(crate) fn close(what: &str, found: f64, exact: f64, tolerance: f64) {
    // Written so that a NaN fails.
    assert!(
        (found - exact).abs() <= tolerance,
        "{what}: {found:.17e}, exact {exact:.17e}, off {:e}",
        found - exact
    );
}

/// The balance of the energies closes at every tenth of the motion, to the rounding of each impact.
#[track_caller]
pub(crate) fn balances(motion: &Motion) {
    let times: Vec<f64> =
        (0..=10).map(|i| motion.start() + (motion.end() - motion.start()) * f64::from(i) / 10.0).collect();
    let largest = times.iter().map(|&t| motion.energy(t).mechanical()).fold(0.0, f64::max);
    for &time in &times {
        let balance = motion.balance(time);
        let Balance { external_work, damping_work, normal_contact_work, tangential_contact_work, .. } =
            balance;
        let works = [external_work, damping_work, normal_contact_work, tangential_contact_work];
        let size = works.iter().map(|w| w.abs()).sum::<f64>() + largest;
        let tolerance = rounding(size) * (1.0 + motion.impacts().len() as f64);
        close(&format!("imbalance at {time}"), balance.imbalance, 0.0, tolerance);
    }
}
