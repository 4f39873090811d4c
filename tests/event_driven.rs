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

use nalgebra::{Vector1, Vector2};
use nonsmooth::event_driven::integrate;
use nonsmooth::laws;
use nonsmooth::linalg::Symmetric;
use nonsmooth::solver::{self, Stopping};
use nonsmooth::system::{Body, Forces, Lagrangian, MechanicalSystem, RigidBodies, SmoothGap};
#[path = "mechanics/random_lagrangian.rs"]
mod random_lagrangian;
#[path = "mechanics/stream.rs"]
mod stream;

fn box_of_discs(seed: u64, count: usize, e: f64, mu: f64, law: &str, end: f64) {
    let mut stream = stream::Stream(seed);
    let mut b = RigidBodies::<f64>::builder();
    let (discs, walls) = (b.group(), b.group());
    let (mut q, mut v) = (vec![], vec![]);
    for i in 0..count {
        let r = stream.uniform(0.05, 0.12);
        let m = stream.uniform(0.5, 2.0);
        let body = b.body(&format!("d{i}"), Body { mass: m, inertia: 0.5 * m * r * r }).unwrap();
        b.disc(&format!("d{i}"), body, [0.0; 2], r, discs).unwrap();
        q.extend([0.15 + 0.3 * (i % 3) as f64, 0.2 + 0.3 * (i / 3) as f64, 0.0]);
        v.extend([stream.uniform(-1.0, 1.0), stream.uniform(-1.0, 1.0), stream.uniform(-5.0, 5.0)]);
    }
    b.half_plane("floor", [0.0; 2], [0.0, 1.0], walls).unwrap();
    b.half_plane("left", [0.0; 2], [1.0, 0.0], walls).unwrap();
    b.half_plane("right", [0.9, 0.0], [-1.0, 0.0], walls).unwrap();
    b.interface(discs, discs).unwrap();
    b.interface(discs, walls).unwrap();
    b.gravity([0.0, -10.0]).unwrap();
    let law = || laws::build::<f64, 2>(law, &[e, mu]).unwrap();
    let clock = std::time::Instant::now();
    let result = integrate::<_, _, _, 2>(
        b.build().unwrap(),
        vec![law(), law()],
        solver::build("hybrid", Stopping::default()).unwrap(),
        0.0,
        q,
        v,
        end,
        &Settings::default(),
    );
    match result {
        Ok(m) => println!(
            "seed {seed}: ok {} pieces {} impacts {} changes, imbalance {:e}, {:?}",
            m.knots().count() - 1,
            m.impacts().len(),
            m.mode_changes().len(),
            m.balance(end).imbalance,
            clock.elapsed()
        ),
        Err(e) => {
            let m = e.motion.as_ref().unwrap();
            println!(
                "seed {seed}: {e}; {} pieces {} impacts {:?} last changes {:?}, {:?}",
                m.knots().count() - 1,
                m.impacts().len(),
                m.impacts().last(),
                &m.mode_changes()[m.mode_changes().len().saturating_sub(6)..],
                clock.elapsed()
            )
        }
    }
}

#[test]
fn explore_discs() {
    for seed in 0..4 {
        box_of_discs(seed, 3, 0.5, 0.3, "fremond", 2.0);
    }
    for seed in 0..4 {
        box_of_discs(seed, 6, 0.5, 0.3, "fremond", 1.0);
    }
    for seed in 0..4 {
        box_of_discs(seed, 6, 0.0, 0.3, "fremond", 2.0);
    }
    for seed in 0..2 {
        box_of_discs(seed, 6, 0.0, 0.3, "newton", 2.0);
    }
}

#[test]
fn explore_random() {
    for seed in 0..10 {
        let mut stream = stream::Stream(seed);
        let r = random_lagrangian::RandomLagrangian::<2>::draw(&mut stream, 4, 3, seed % 2 == 0);
        let system = r.system(random_lagrangian::Storage::Dense);
        let law = || laws::build::<f64, 2>("fremond", &[0.4, 0.3]).unwrap();
        let clock = std::time::Instant::now();
        let result = integrate::<_, _, _, 2>(
            system,
            vec![law(), law(), law()],
            solver::build("hybrid", Stopping::default()).unwrap(),
            0.0,
            r.q.clone(),
            r.v.clone(),
            2.0,
            &Settings::default(),
        );
        match result {
            Ok(m) => println!(
                "random {seed}: ok {} pieces {} impacts {} changes, imbalance {:e}, {:?}",
                m.knots().count() - 1,
                m.impacts().len(),
                m.mode_changes().len(),
                m.balance(2.0).imbalance,
                clock.elapsed()
            ),
            Err(e) => {
                let m = e.motion.as_ref().unwrap();
                println!(
                    "random {seed}: {e}; {} pieces {} impacts {:?} last changes {:?}, {:?}",
                    m.knots().count() - 1,
                    m.impacts().len(),
                    m.impacts().last(),
                    &m.mode_changes()[m.mode_changes().len().saturating_sub(6)..],
                    clock.elapsed()
                )
            }
        }
    }
}

#[test]
fn explore_hill() {
    let gap = SmoothGap::new(
        |q: &[f64]| q[0].hypot(q[1]) - 1.0,
        |q: &[f64], push| {
            let r = q[0].hypot(q[1]);
            push(0, Vector1::new(q[0] / r));
            push(1, Vector1::new(q[1] / r));
        },
    );
    let s = Lagrangian::<f64, 1>::new(Symmetric::diagonal(vec![2.0; 2]).unwrap())
        .with_forces(Forces::constant(vec![0.0, -20.0]))
        .unwrap()
        .with_contact(0, gap);
    let a = 0.1_f64;
    let law = laws::build::<f64, 1>("fremond", &[0.4, 0.0]).unwrap();
    let m = integrate::<_, _, _, 1>(
        s,
        vec![law],
        solver::build("hybrid", Stopping::default()).unwrap(),
        0.0,
        vec![a.sin(), a.cos()],
        vec![0.0; 2],
        1.5,
        &Settings::default(),
    );
    match m {
        Ok(m) => {
            show(&m);
            let (mut q, mut v) = ([0.0; 2], [0.0; 2]);
            let t = m.mode_changes().last().unwrap().time;
            m.at(t, &mut q, &mut v);
            println!("cos {} expected {}", q[1], 2.0 / 3.0 * a.cos());
        }
        Err(e) => println!("hill: {e}"),
    }
}

#[test]
fn explore_friction_oscillator() {
    let mut b = RigidBodies::<f64>::builder();
    let (d, w) = (b.group(), b.group());
    let body = b.body("m", Body { mass: 2.0, inertia: 1.0 }).unwrap();
    b.disc("p", body, [0.0; 2], 0.0, d).unwrap();
    b.half_plane("floor", [0.0; 2], [0.0, 1.0], w).unwrap();
    b.interface(d, w).unwrap();
    b.gravity([0.0, -10.0]).unwrap();
    b.spring(body, [50.0, 0.0, 0.0]).unwrap();
    let law = laws::build::<f64, 2>("newton", &[0.0, 0.2]).unwrap();
    let m = integrate::<_, _, _, 2>(
        b.build().unwrap(),
        vec![law],
        solver::build("hybrid", Stopping::default()).unwrap(),
        0.0,
        vec![0.87, 0.0, 0.0],
        vec![0.0; 3],
        5.0,
        &Settings::default(),
    );
    match m {
        Ok(m) => show(&m),
        Err(e) => println!("osc: {e}"),
    }
}

#[test]
fn explore_painleve() {
    // rod tan gamma = 1/2, mu = 2: W = [[1.6, 1.2], [1.2, 3.4]]
    for (law, e) in [("newton", 0.0), ("fremond", 0.0)] {
        let gamma = 0.5f64.atan();
        let mut b = RigidBodies::<f64>::builder();
        let (d, w) = (b.group(), b.group());
        let body = b.body("rod", Body { mass: 1.0, inertia: 1.0 / 12.0 }).unwrap();
        b.disc("tip", body, [0.0, -0.5], 0.0, d).unwrap();
        b.half_plane("floor", [0.0; 2], [0.0, 1.0], w).unwrap();
        b.interface(d, w).unwrap();
        b.gravity([0.0, -10.0]).unwrap();
        for (s, u) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0)] {
            let law = laws::build::<f64, 2>(law, &[e, 2.0]).unwrap();
            let m = integrate::<_, _, _, 2>(
                b.clone().build().unwrap(),
                vec![law],
                solver::build("hybrid", Stopping::default()).unwrap(),
                0.0,
                vec![0.0, 0.5 * gamma.cos(), s * gamma],
                vec![u, 0.0, 0.0],
                0.3,
                &Settings::default(),
            );
            match m {
                Ok(m) => show(&m),
                Err(e) => println!("painleve: {e}"),
            }
        }
    }
}
