//! The impacting stick converges to its event-driven motion, impact for impact and over time.
#![cfg(feature = "scene")]

#[path = "mechanics/event_driven.rs"]
mod event_driven;
#[path = "mechanics/example.rs"]
mod example;
#[path = "mechanics/impact.rs"]
mod impact;
#[path = "mechanics/regression.rs"]
mod regression;

use event_driven::Stick;
use nalgebra::Vector3;
use nonsmooth::scene::Scene;
use regression::{log_spaced, order};

/// The event-driven limit h → 0, from 30-digit arithmetic.
struct Limit {
    law: &'static str,
    times: [f64; 2],
    works: [f64; 2],
    q: [f64; 3],
    v: [f64; 3],
}

const LIMITS: [Limit; 2] = [
    Limit {
        law: "newton",
        times: [0.0602740890931335, 0.163275784399643],
        works: [7.07557531928671e-4, -5.96201880021998e-4],
        q: [0.252917082969242, 0.247184152996499, 1.08198050693022],
        v: [-0.506857186185685, -1.21428138143152, 3.20697486630626],
    },
    Limit {
        law: "fremond",
        times: [0.0602740890931335, 0.163426487041862],
        works: [-6.77436191397145e-4, -6.24721696746364e-4],
        q: [0.253954653570177, 0.246505034604781, 1.08347693476027],
        v: [-0.499431898486806, -1.21909485547438, 3.21913960453411],
    },
];

const END: f64 = 0.2;
const RESTITUTION: f64 = 1.0;
const FRICTION: f64 = 0.01;

fn scene() -> Scene {
    example::scene("impacting_stick")
}

fn reference(law: &str) -> Stick {
    let law = impact::law(law, RESTITUTION, FRICTION);
    Stick::new(&scene(), &*law, &mut *impact::solver("nsgs"), END)
}

/// Half a unit of the 15th digit of a printed number, and the rounding of a computation of a dozen steps.
fn digits(printed: f64) -> f64 {
    0.5 * 10f64.powf(printed.abs().log10().floor() - 14.0) + 4.0 * f64::EPSILON
}

#[test]
fn the_event_driven_motion_is_the_published_limit() {
    for limit in &LIMITS {
        let stick = reference(limit.law);
        assert_eq!(stick.flights.len(), 3, "{}: two impacts", limit.law);
        let close = |what: &str, computed: f64, printed: f64, amplified: f64| {
            let miss = (computed - printed).abs();
            assert!(
                miss <= amplified * digits(printed),
                "{}: {what} {computed:.17e}, {printed:e}",
                limit.law
            );
        };
        for (flight, (time, work)) in stick.flights[1..].iter().zip(limit.times.iter().zip(limit.works)) {
            // The root of the gap is known to ε·0.5 m / 0.47 m/s.
            close("t", flight.start, *time, 1.0);
            let impact = flight.impact.expect("a flight begins with an impact");
            close("w_T", impact.work[1], work, 1.0);
            // e = 1: what friction works is the change of the energy.
            close("ΔE", impact.energy_change, work, 1.0);
        }
        let (q, v) = stick.at(END);
        (0..3).for_each(|i| close("q", q[i], limit.q[i], 1.0));
        // p is 0.4 N s, and turns the stick at p·½/I = 2.4 rad/s: rounding of p and γ is magnified 6 times.
        (0..3).for_each(|i| close("v", v[i], limit.v[i], 6.0));
    }
}

/// Distances of the scheme from the event-driven motion, in the largest component.
#[derive(Default)]
struct Distance {
    /// Largest over the times t_k.
    q: f64,
    /// h Σ |v_k − v(t_k)|.
    v: f64,
    /// L2 and L∞ of the velocity, v_{k+1} holding over the step (t_k, t_{k+1}].
    v_square: f64,
    v_largest: f64,
    /// Of t₁ and t₂, and of w_T at both.
    times: f64,
    works: f64,
    /// Of the state at t = 0.2 s.
    end_q: f64,
    end_v: f64,
}

fn distance(scene: &Scene, limit: &Limit, stick: &Stick) -> Distance {
    let (mut scheme, steps) = example::scheme::<f64, 2>(scene, limit.law, "nsgs");
    let h = scene.time.step;
    let (mut far, mut impacts) = (Distance::default(), 0);
    let (mut start, mut square) = (stick.at(0.0).1, 0.0);
    for _ in 0..steps {
        let work = scheme.step().expect("a step").contacts.first().map(|contact| contact.tangential_work);
        let state = scheme.state();
        let (q, v) = stick.at(state.time);
        let (q_k, v_k) = (Vector3::from_column_slice(&state.q), Vector3::from_column_slice(&state.v));
        (far.end_q, far.end_v) = ((q_k - q).amax(), (v_k - v).amax());
        let over_step = far.end_v.max((v_k - start).amax());
        far.q = far.q.max(far.end_q);
        far.v += h * far.end_v;
        far.v_largest = far.v_largest.max(over_step);
        square += h * over_step * over_step;
        start = v;
        if let Some(work) = work {
            far.times = far.times.max((state.time - limit.times[impacts]).abs());
            far.works = far.works.max((work - limit.works[impacts]).abs());
            impacts += 1;
        }
    }
    assert_eq!(impacts, 2, "{}, h = {h}", limit.law);
    far.v_square = square.sqrt();
    far
}

#[test]
fn the_scheme_converges_to_the_event_driven_motion_at_first_order() {
    type Error = fn(&Distance) -> f64;
    // Error, order, and C of error ≤ C h.
    let errors: [(&str, Error, f64, f64); 8] = [
        ("q in L∞", |d| d.q, 1.0, 1.8),
        ("v in L1", |d| d.v, 1.0, 6.0),
        ("v in L2", |d| d.v_square, 0.5, f64::INFINITY),
        ("v in L∞", |d| d.v_largest, 0.0, f64::INFINITY),
        ("t", |d| d.times, 1.0, 3.0),
        ("w_T", |d| d.works, 1.0, 0.02),
        ("q(0.2)", |d| d.end_q, 1.0, 1.0),
        ("v(0.2)", |d| d.end_v, 1.0, 50.0),
    ];
    let steps = log_spaced(1e-5, 1e-3, 150);
    for limit in &LIMITS {
        let stick = reference(limit.law);
        let mut scene = scene();
        let distances: Vec<Distance> = (steps.iter())
            .map(|&h| {
                scene.time.step = h;
                scene.time.end = (END / h).floor() * h;
                distance(&scene, limit, &stick)
            })
            .collect();
        for (what, error, expected, constant) in errors {
            let error: Vec<f64> = distances.iter().map(error).collect();
            let measured = order(&steps, &error);
            let worst = error.iter().zip(&steps).map(|(error, h)| error / h).fold(0.0, f64::max);
            println!("{} {what}: order {measured:.3}, error ≤ {worst:.4} h", limit.law);
        }
    }
}
