//! The bouncing ball of `examples/bouncing_ball.toml`: infinitely many impacts in finite time, then rest.
//!
//! Between impacts the scheme at θ = ½ follows the parabola exactly. An impact at speed s, the share σ ∈ [0, 1] of a
//! step after t_k, is placed at t_{k+1}: it leaves the ball s (1+e)(σ − ½)h too high and g h ((1−σ) − eσ) too fast. The
//! error of the speed at the next landing is thus e times that at the last plus g h (1 − (1+e)/(2e) + σ(1+e)(1/e − 1)),
//! which for e = ½ is g h (1.5σ − ½): it stays in [−1, 2] g h, the rebound's in [−1, 2] g h too, and each flight, their
//! sum over g, is at most 4h too long.
#![cfg(feature = "scene")]

#[path = "mechanics/example.rs"]
mod example;
#[path = "mechanics/regression.rs"]
mod regression;

use nonsmooth::scene::Scene;
use nonsmooth::scheme::ActivationRule;
use regression::{log_spaced, order};

const GRAVITY: f64 = 10.0;
const HEIGHT: f64 = 1.0;
const RESTITUTION: f64 = 0.5;

/// Time of the first impact; impact n + 1 follows impact n after 2 eⁿ t₁.
fn first_impact() -> f64 {
    (2.0 * HEIGHT / GRAVITY).sqrt()
}

fn impact_time(n: i32) -> f64 {
    first_impact() * (1.0 + 2.0 * (RESTITUTION - RESTITUTION.powi(n)) / (1.0 - RESTITUTION))
}

fn rest_time() -> f64 {
    first_impact() * (1.0 + RESTITUTION) / (1.0 - RESTITUTION)
}

/// Bounces until the speed falls to g h, where the steps no longer resolve them.
fn bounces(step: f64) -> f64 {
    (GRAVITY * first_impact() / (GRAVITY * step)).log2()
}

fn scene(step: f64) -> Scene {
    let mut scene = example::scene("bouncing_ball");
    scene.time.step = step;
    scene
}

/// The rule of the active set taken literally.
fn literal(step: f64) -> Scene {
    let mut scene = scene(step);
    scene.time.lasting = false;
    scene
}

/// A run: times of the impacts, and (t, y, ẏ) from the exact time of rest on.
struct Run {
    impacts: Vec<f64>,
    rest: Vec<[f64; 3]>,
    end: f64,
}

fn run(scene: &Scene, law: &str) -> Run {
    let (mut scheme, steps) = example::scheme::<f64, 1>(scene, law, "nsgs");
    let mut run = Run { impacts: Vec::new(), rest: Vec::new(), end: 0.0 };
    for _ in 0..steps {
        let step = scheme.step().expect("one contact");
        let impact = step.contacts.iter().any(|contact| contact.percussion[0] > 0.0);
        let state = scheme.state();
        if impact {
            run.impacts.push(state.time);
        }
        if state.time >= rest_time() {
            run.rest.push([state.time, state.q[1], state.v[1]]);
        }
        run.end = state.time;
    }
    run
}

/// Largest |row[i]| over the rest.
fn largest(run: &Run, i: usize) -> f64 {
    run.rest.iter().fold(0.0, |largest: f64, row| largest.max(row[i].abs()))
}

#[test]
fn the_impacts_converge_to_the_geometric_series() {
    // The fifth impact comes at 0.28 m/s, still 28 times the g h of the largest step.
    const IMPACTS: usize = 5;
    let steps = log_spaced(1e-5, 1e-3, 60);
    for law in ["newton", "fremond"] {
        let runs: Vec<Run> = steps.iter().map(|&h| run(&scene(h), law)).collect();
        for n in 1..=IMPACTS {
            let error = |run: &Run| (run.impacts[n - 1] - impact_time(n as i32)).abs();
            let errors: Vec<f64> = runs.iter().map(error).collect();
            for (error, h) in errors.iter().zip(&steps) {
                // At most a step late, after n − 1 flights.
                let bound = (4.0 * (n - 1) as f64 + 1.0) * h;
                assert!(*error <= bound, "{law}, h = {h}, impact {n}: {error:e}");
            }
            let order = order(&steps, &errors);
            assert!((order - 1.0).abs() <= 0.15, "{law}, impact {n}: order {order}");
        }
    }
}

/// Rule (55) with e < 1 lets the ball at rest alternate between −g h/(1+e) and e g h/(1+e), and sink by
/// g h² (1−e)/(1+e) every two steps.
fn sinking_speed(step: f64) -> f64 {
    0.5 * GRAVITY * step * (1.0 - RESTITUTION) / (1.0 + RESTITUTION)
}

#[test]
fn under_the_literal_rule_the_ball_rests_within_first_order_of_the_step() {
    let steps = log_spaced(1e-5, 1e-3, 60);
    for law in ["newton", "fremond"] {
        let (mut heights, mut speeds) = (Vec::new(), Vec::new());
        for &h in &steps {
            let run = run(&literal(h), law);
            // N flights at most 4h too long leave a time of 4Nh to bounce: a speed of 2Nh g, a height of 2N²h² g.
            let late = bounces(h) * h;
            for &[time, y, v] in &run.rest {
                let sunk = sinking_speed(h) * (time - rest_time());
                let height = 2.0 * GRAVITY * late * late;
                assert!(-sunk - height <= y && y <= height, "{law}, h = {h}, t = {time}: y = {y:e}");
                assert!(v.abs() <= 2.0 * GRAVITY * late, "{law}, h = {h}, t = {time}: v = {v:e}");
            }
            heights.push(largest(&run, 1));
            // Late by N steps: N is not part of the order.
            speeds.push(largest(&run, 2) / bounces(h));
        }
        for (what, errors) in [("y", heights), ("v", speeds)] {
            let order = order(&steps, &errors);
            assert!((order - 1.0).abs() <= 0.15, "{law}: {what} of order {order}");
        }
    }
}

#[test]
fn on_the_floor_the_papers_rule_sinks_and_the_predicted_gap_does_not() {
    let h = 1e-4;
    let sink = |rule| {
        let mut scene = literal(h);
        scene.time.activation = rule;
        let run = run(&scene, "fremond");
        let [time, y, _] = run.rest[run.rest.len() / 2];
        let [end, last, _] = run.rest[run.rest.len() - 1];
        (y - last) / (end - time)
    };
    let (paper, gap) = (sink(ActivationRule::MoreauJean), sink(ActivationRule::PredictedGap));
    // The two steps of the alternation, in the 3,000 observed.
    assert!((paper / sinking_speed(h) - 1.0).abs() <= 1e-3, "{paper:e}, exact {:e}", sinking_speed(h));
    // At rest but for rounding: 64 ε of the speed the other rule sinks at.
    assert!(gap.abs() <= 64.0 * f64::EPSILON * sinking_speed(h), "{gap:e}");
}

/// By default a contact that lasts is no impact: the ball comes to rest at once, on the floor, and stays.
#[test]
fn after_the_last_impact_the_ball_stands_still() {
    for h in log_spaced(1e-5, 1e-3, 20) {
        for law in ["newton", "fremond"] {
            let run = run(&scene(h), law);
            let late = bounces(h) * h;
            let (mut moving, mut deepest) = (0.0_f64, 0.0_f64);
            for &[time, y, v] in &run.rest {
                deepest = deepest.min(y);
                if v.abs() > 0.0 || y.abs() > 1e-12 * HEIGHT {
                    moving = time;
                }
            }
            // N flights at most 4h too long, and a few steps in which the gap closes.
            assert!(moving <= rest_time() + (4.0 * late + 4.0 * h), "{law}, h = {h}: moves until {moving}");
            // Within a step of the speed that rests.
            assert!(deepest >= -2.0 * GRAVITY * h * h, "{law}, h = {h}: {deepest:e}");
        }
    }
}
