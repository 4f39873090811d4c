//! Small models of the literature as `lagrangian` blocks of scene files.
#![cfg(feature = "scene")]

#[path = "mechanics/example.rs"]
mod example;
#[path = "mechanics/from_text.rs"]
mod from_text;

use std::f64::consts::PI;

use from_text::{follow, scheme, try_scheme};

/// ẍ + x = F sin(ωt + φ) over a wall at 0 with restitution e.
fn oscillator(
    velocity: f64,
    (amplitude, omega, phase): (f64, f64, f64),
    (e, end, step): (f64, f64, f64),
) -> String {
    format!(
        r#"
        title = "impact oscillator"
        laws = ["newton"]
        [time]
        theta = 0.5
        step = {step:?}
        end = {end:?}
        [lagrangian]
        coordinates = ["x"]
        mass = [[1.0]]
        stiffness = [[1.0]]
        velocity = [{velocity:?}]
        loads = [{{ force = [{amplitude:?}], signal = {{ sine = {{ frequency = {:?}, phase = {:?} }} }} }}]
        gaps = [{{ name = "wall", normal = [1.0], parameters = {{ restitution = {e:?}, friction = 0.0 }} }}]
        "#,
        omega / (2.0 * PI),
        phase / (2.0 * PI)
    )
}

#[test]
fn the_impact_oscillator_stays_on_its_orbit_of_one_impact_a_period() {
    // Between impacts x = α cos t + β sin t + B sin(ωt + φ), B = F/(1 − ω²); x = 0 at both ends of a period T and
    // ẋ(0) = −e ẋ(T) give α, β and φ (Shaw & Holmes 1983, doi:10.1016/0022-460X(83)90407-8).
    let (e, omega, amplitude) = (0.6, 2.2, 1.0_f64);
    let period = 2.0 * PI / omega;
    let (s, c) = period.sin_cos();
    let b = amplitude / (1.0 - omega * omega);
    let kappa = (1.0 - c) / s;
    let m = (kappa + e * (kappa * c - s)) / ((1.0 + e) * omega);
    let alpha = |sign: f64| sign * b.abs() / (1.0 + m * m).sqrt();
    let speed = |alpha: f64| alpha * kappa - omega * alpha * m;
    let alpha = if speed(alpha(1.0)) > 0.0 { alpha(1.0) } else { alpha(-1.0) };
    let (start, phase) = (speed(alpha), (-alpha / b).atan2(-alpha * m / b));
    assert!(start > 0.1, "{start}");

    let step = period / 2000.0;
    let text = oscillator(start, (amplitude, omega, phase), (e, 60.0 * period, step));
    let (mut rebounds, mut last) = (Vec::new(), f64::NEG_INFINITY);
    let imbalance = follow::<1>(&text, |scheme| {
        let made = scheme.last_step();
        let time = scheme.state().time;
        if made.contacts.iter().any(|contact| contact.percussion[0] > 0.0) && time - last > 0.5 * period {
            rebounds.push(scheme.state().v[0]);
            last = time;
        }
    });
    assert!(imbalance < 64.0 * f64::EPSILON, "{imbalance}");
    assert!((59..=61).contains(&rebounds.len()), "{} impacts", rebounds.len());
    for rebound in &rebounds[5..] {
        // An impact is a step late at most: h of acceleration 1, twice for either side of it.
        assert!((rebound - start).abs() < 8.0 * step, "{rebound}, exact {start}");
    }
}

#[test]
fn the_woodpecker_pecks_its_way_down_on_its_limit_cycle() {
    let scene = example::scene("woodpecker");
    let (mut scheme, steps) = example::scheme::<f64, 2>(&scene, "newton", "hybrid");
    assert_eq!(scheme.system().dof_label(1), "sleeve");
    let start = (scheme.state().q.clone(), scheme.state().v.clone());
    let half = steps / 2;
    let (mut pecks, mut at, mut heights, mut nearest) =
        (Vec::new(), f64::NEG_INFINITY, Vec::new(), f64::INFINITY);
    let mut imbalance = 0.0_f64;
    for step in 0..steps {
        let made = scheme.step().expect("a woodpecker");
        imbalance = imbalance.max(made.balance.imbalance.abs());
        let pecked = made.contacts.iter().any(|contact| {
            contact.interface == 0 && contact.percussion[0] > 0.0 && contact.before[0] < -1e-3
        });
        let state = scheme.state();
        if pecked && state.time - at > 0.05 {
            at = state.time;
            pecks.push(at);
            heights.push(state.q[0]);
        }
        if step > half {
            // Against the published state of the cycle, but for the height it has come down.
            let angles = (state.q[1] - start.0[1]).abs() / 0.1036 + (state.q[2] - start.0[2]).abs() / 0.2788;
            let rates = (state.v[0] - start.1[0]).abs() / 0.3411
                + (state.v[1] - start.1[1]).abs() / 7.4583
                + (state.v[2] - start.1[2]).abs() / 7.4583;
            nearest = nearest.min(angles + rates);
        }
    }
    // Energies of m g · 5 mm = 2e-4 J, and less.
    assert!(imbalance < 64.0 * f64::EPSILON * 1e-3, "{imbalance}");
    let periods: Vec<f64> = pecks.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let drops: Vec<f64> = heights.windows(2).map(|pair| pair[0] - pair[1]).collect();
    let (last, drop) = (periods[periods.len() - 1], drops[drops.len() - 1]);
    // After a few periods every one is as the one before, to the steps it has.
    for (period, down) in periods.iter().zip(&drops).skip(3) {
        assert!((period / last - 1.0).abs() < 5e-3, "{periods:?}");
        assert!((down / drop - 1.0).abs() < 1e-2 && *down > 0.0, "{drops:?}");
    }
    // The state published for the cycle (Glocker, Set-Valued Force Laws, 2001) comes back, to 1 % of each number.
    assert!(nearest < 0.05, "{nearest}");
    assert!(periods.len() > 5 && (0.1..0.2).contains(&last), "{periods:?}");
}

#[test]
fn two_masses_on_springs_with_a_load_move_as_their_modes_do() {
    // M = 1, K = [[2, −1], [−1, 2]]: modes (1, 1) at 1 and (1, −1) at √3 rad/s.
    let text = r#"
        title = "chain"
        laws = ["fremond"]
        [time]
        theta = 0.5
        step = 1e-3
        end = 3.0
        [lagrangian]
        coordinates = ["left", "right"]
        mass = [[1.0, 0.0], [0.0, 1.0]]
        stiffness = [[2.0, -1.0], [-1.0, 2.0]]
        position = [1.0, 0.0]
        "#;
    let (mut scheme, steps) = scheme::<1>(text);
    for _ in 0..steps {
        scheme.step().expect("linear");
    }
    let (t, slow) = (scheme.state().time, 3.0_f64.sqrt());
    let exact = [0.5 * (t.cos() + (slow * t).cos()), 0.5 * (t.cos() - (slow * t).cos())];
    // (ω h)²/12 · ω t
    for (found, exact) in scheme.state().q.iter().zip(exact) {
        assert!((found - exact).abs() < 2e-6, "{found}, {exact}");
    }
}

#[test]
fn a_lagrangian_block_that_is_none_is_refused_in_words() {
    let text = oscillator(1.0, (1.0, 2.0, 0.0), (0.5, 1.0, 1e-2));
    for (change, said) in [
        (("mass = [[1.0]]", "mass = [[-1.0]]"), "mass"),
        (("mass = [[1.0]]", "mass = [[1.0, 2.0]]"), "mass has size 2, the system has 1 degrees of freedom"),
        (("mass = [[1.0]]", "mass = []"), "mass has size 0"),
        (("stiffness = [[1.0]]", "stiffness = [[inf]]"), "stiffness"),
        (("velocity = [1.0]", "velocity = [1.0, 2.0]"), "the velocity has size 2"),
        (("velocity = [1.0]", "velocity = [nan]"), "the velocity is NaN, it must be finite"),
        (("normal = [1.0]", "normal = [0.0]"), "the normal of gap `wall`"),
        (("normal = [1.0]", "normal = [1.0, 0.0]"), "the normal of a gap has size 2"),
        (("coordinates = [\"x\"]", "coordinates = []"), "no coordinate"),
        (
            ("[lagrangian]", "[[half_planes]]\nname = 'p'\nnormal = [0.0, 1.0]\n[lagrangian]"),
            "and half-planes",
        ),
        (("laws", "gravity = [0.0, -9.81]\nlaws"), "and gravity"),
        (("restitution = 0.5", "restitutoin = 0.5"), "needs the parameter `restitution`"),
    ] {
        let changed = text.replace(change.0, change.1);
        assert_ne!(changed, text, "{}", change.0);
        let outcome = try_scheme::<1>(&changed).map(drop).map_err(|error| error.to_string());
        let registry = nonsmooth::registry();
        // Parameters are checked with the dimension of the contacts.
        let checked = nonsmooth::scene::Scene::parse(&changed, std::path::Path::new("scene.toml"))
            .map_err(|error| error.to_string())
            .and_then(|scene| {
                let runs = scene.runs(&registry).map_err(|error| error.to_string())?;
                nonsmooth::scene::contact_dimension(&scene, &runs, &registry)
                    .map_err(|error| error.to_string())
            });
        let error = outcome.err().or(checked.err()).unwrap_or_default();
        assert!(error.contains(said), "{change:?}: {error}");
    }
}
