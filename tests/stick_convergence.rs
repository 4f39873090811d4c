//! The impacting stick converges to its event-driven motion, impact for impact and over time.
#![cfg(feature = "scene")]

#[path = "mechanics/example.rs"]
mod example;
#[path = "mechanics/limits.rs"]
mod limits;
#[path = "mechanics/regression.rs"]
mod regression;

use limits::{END, LIMITS, Limit};
use nalgebra::Vector3;
use nonsmooth::event_driven::{Motion, Settings};
use nonsmooth::scene::{Scene, event_driven};
use regression::{log_spaced, order};

fn scene() -> Scene {
    example::scene("impacting_stick")
}

fn reference(law: &str) -> Motion {
    let scene = scene();
    let run = example::run(&scene, law, "nsgs");
    event_driven::<2>(&scene, &run, &nonsmooth::registry())
        .expect("the stick")
        .integrate(&Settings::default())
        .expect("two impacts")
}

/// (q, v) at time t; at an impact, v is the velocity before it.
fn before(motion: &Motion, time: f64) -> (Vector3<f64>, Vector3<f64>) {
    let (mut q, mut v) = (Vector3::zeros(), Vector3::zeros());
    motion.before(time, q.as_mut_slice(), v.as_mut_slice());
    (q, v)
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
    /// Of the last state.
    end_q: f64,
    end_v: f64,
}

fn distance(scene: &Scene, limit: &Limit, stick: &Motion) -> Distance {
    let (mut scheme, steps) = example::scheme::<f64, 2>(scene, limit.law, "nsgs");
    let h = scene.time.step;
    let (mut far, mut impacts) = (Distance::default(), 0);
    let (mut start, mut square) = (before(stick, 0.0).1, 0.0);
    for _ in 0..steps {
        let work = scheme.step().expect("a step").contacts.first().map(|contact| contact.tangential_work);
        let state = scheme.state();
        let (q, v) = before(stick, state.time);
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
    // Error, order, and C of error ≤ C h. An impact is placed up to a step late, and at e = 1 leaves the tip up to
    // u_N h off the parabola and g h off its speed: the next one is up to (1 + 1 + 2) h late, u_N⁻ is off by g h, p by
    // 2 g h/W_NN ≤ 8 h, the spin by 6 times that, and w_T by g h p_T. Those of q and v are the published ones.
    let errors: [(&str, Error, f64, f64); 8] = [
        ("q in L∞", |d| d.q, 1.0, 1.8),
        ("v in L1", |d| d.v, 1.0, 6.0),
        ("v in L2", |d| d.v_square, 0.5, f64::INFINITY),
        ("v in L∞", |d| d.v_largest, 0.0, f64::INFINITY),
        ("t", |d| d.times, 1.0, 4.0),
        ("w_T", |d| d.works, 1.0, 0.037),
        ("q at the end", |d| d.end_q, 1.0, 1.8),
        ("v at the end", |d| d.end_v, 1.0, 48.0),
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
            let place = format!("{}: {what}: order {measured:.3}, error ≤ {worst:.4} h", limit.law);
            // The saw-tooth spreads ln(error) by about 0.8, 150 steps over two decades the slope by 0.05: three of it.
            assert!((measured - expected).abs() <= 0.15, "{place}");
            assert!(worst <= constant, "{place}");
        }
    }
}
