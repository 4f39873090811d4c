//! The event-driven motion against exact solutions.
#![cfg(feature = "scene")]

#[path = "mechanics/exact.rs"]
mod exact;
#[path = "mechanics/example.rs"]
mod example;
#[path = "mechanics/limits.rs"]
mod limits;
#[path = "mechanics/motion.rs"]
mod motion;

use exact::{FrictionOscillator, bisect};
use motion::{balances, before, close, hybrid, law, motion, rounding, state};
use nalgebra::Vector1;
use nonsmooth::event_driven::{EventError, EventFailure, Mode, Motion, Settings, integrate};
use nonsmooth::linalg::Symmetric;
use nonsmooth::scene::{Scene, event_driven};
use nonsmooth::system::{
    Body, BodyId, Forces, Lagrangian, RigidBodies, RigidBodiesBuilder, Signal, SmoothGap,
};

fn run<const D: usize>(scene: &Scene, law: &str, settings: &Settings) -> Result<Motion, EventError> {
    let run = example::run(scene, law, "hybrid");
    event_driven::<D>(scene, &run, &nonsmooth::registry()).expect("an example builds").integrate(settings)
}

fn example_motion<const D: usize>(name: &str, law: &str) -> Motion {
    run::<D>(&example::scene(name), law, &Settings::default())
        .unwrap_or_else(|error| panic!("{name}, {law}: {error}"))
}

/// One body of one contact point at its centre of mass above a floor, g = 10 m/s², with a mass of 2 kg.
fn point_on_floor() -> (RigidBodiesBuilder<f64>, BodyId) {
    let mut builder = RigidBodies::builder();
    let (points, floors) = (builder.group(), builder.group());
    let body = builder.body("point", Body { mass: 2.0, inertia: 1.0 }).expect("positive");
    builder.disc("point", body, [0.0; 2], 0.0, points).expect("a point");
    builder.half_plane("floor", [0.0; 2], [0.0, 1.0], floors).expect("a floor");
    builder.interface(points, floors).expect("groups");
    builder.gravity([0.0, -10.0]).expect("finite");
    (builder, body)
}

#[test]
fn the_stick_reaches_its_limits() {
    for limit in &limits::LIMITS {
        let motion = example_motion::<2>("impacting_stick", limit.law);
        let impacts = motion.impacts();
        assert_eq!(impacts.len(), 2, "{}", limit.law);
        // The printed numbers have 15 digits.
        for (impact, (time, work)) in impacts.iter().zip(limit.times.iter().zip(limit.works)) {
            close("t", impact.time, *time, 1e-15);
            close("w_T", impact.contacts[0].work[1], work, 1e-17);
            close("w_N", impact.contacts[0].work[0], 0.0, 1e-16);
        }
        let (q, v) = state(&motion, limits::END);
        for i in 0..3 {
            close("q(0.2)", q[i], limit.q[i], 1e-14);
            close("v(0.2)", v[i], limit.v[i], 1e-13);
        }
        // At an impact the velocity jumps from u⁻ to u⁺, the configuration does not.
        let contact = impacts[0].contacts[0];
        let ((q, v), (p, w)) = (before(&motion, impacts[0].time), state(&motion, impacts[0].time));
        assert!(v != w && q.iter().zip(&p).all(|(a, b)| (a - b).abs() < rounding(1.0)));
        let jump = w[1] - v[1];
        close("m Δẏ = p_N", jump, contact.percussion[0], rounding(1.0));
        balances(&motion);
    }
}

#[test]
fn a_bouncing_ball_goes_through_its_accumulation_point() {
    for (restitution, name) in [(0.0, "fremond"), (0.5, "newton"), (0.5, "fremond"), (0.9, "moreau")] {
        let mut scene = example::scene("bouncing_ball");
        *scene.interfaces[0].parameters.get_mut("restitution").expect("given") = restitution;
        let (gravity, height) = (10.0_f64, 1.0);
        let first = (2.0 * height / gravity).sqrt();
        let rest = first * (1.0 + restitution) / (1.0 - restitution);
        scene.time.end = 1.2 * rest + 0.1;
        let motion = run::<1>(&scene, name, &Settings::default()).expect("a ball");
        // (y, ẏ) on the parabola after impact n at t_n with speed s eⁿ.
        let exact = |t: f64| {
            if t >= rest {
                return (0.0, 0.0);
            }
            let (mut start, mut speed) = (first, gravity * first);
            if t < first {
                return (height - 0.5 * gravity * t * t, -gravity * t);
            }
            loop {
                speed *= restitution;
                let flight = 2.0 * speed / gravity;
                if t < start + flight {
                    let tau = t - start;
                    return (tau * (speed - 0.5 * gravity * tau), speed - gravity * tau);
                }
                start += flight;
            }
        };
        for (n, impact) in motion.impacts().iter().enumerate() {
            let sum = if restitution > 0.0 {
                (restitution - restitution.powi(n as i32 + 1)) / (1.0 - restitution)
            } else {
                0.0
            };
            // Times add up: each has the rounding of the last.
            close(&format!("impact {n}"), impact.time, first * (1.0 + 2.0 * sum), 1e-14 * (1.0 + n as f64));
        }
        // Flights shorter than 2·1e-13·4.5 m/s over g are left out, their sum is 1/(1−e) of that.
        let change = motion.mode_changes().last().expect("it rests");
        assert_eq!(motion.mode_changes().len(), 1, "it comes to rest once");
        close("rest", change.time, rest, 1e-13 / (1.0 - restitution) + rounding(rest) * 10.0);
        let expected = if restitution > 0.0 { (1e-13_f64).ln() / restitution.ln() } else { 1.0 };
        close("impacts", motion.impacts().len() as f64, expected, 2.0);
        for i in 0..=400 {
            let time = scene.time.end * f64::from(i) / 400.0;
            let ((q, v), (y, speed)) = (state(&motion, time), exact(time));
            close("y", q[1], y, 1e-12);
            if motion.impacts().iter().all(|impact| (impact.time - time).abs() > 1e-12) {
                close("ẏ", v[1], speed, 1e-12 / (1.0 - restitution));
            }
            // Percussions and weight make the momentum, but for the last speed that is left out, 1e-13·4.5 m/s.
            close("p", motion.percussion(time)[0], gravity * time + v[1], 1e-12);
        }
        balances(&motion);
    }
}

#[test]
fn a_sliding_disc_begins_to_roll() {
    for name in ["newton", "fremond"] {
        let motion = example_motion::<2>("rolling_disc", name);
        // v₀ = 1, μg = 2, r = 0.1, I = m r²/2.
        let rolls = 1.0 / 6.0;
        let modes: Vec<(Mode, Mode)> = motion.mode_changes().iter().map(|c| (c.from, c.to)).collect();
        assert_eq!(modes, [(Mode::Open, Mode::Slide(1.0)), (Mode::Slide(1.0), Mode::Stick)]);
        close("t", motion.mode_changes()[1].time, rolls, 1e-15);
        for i in 0..=40 {
            let t = 0.01 * f64::from(i);
            let (q, v) = state(&motion, t);
            let slide = t.min(rolls);
            let roll = t - slide;
            close("x", q[0], slide - slide * slide + 2.0 / 3.0 * roll, 1e-15);
            close("ẋ", v[0], 1.0 - 2.0 * slide, 1e-15);
            close("angle", q[2], -20.0 * slide * slide - roll / 0.15, 1e-14);
            close("spin", v[2], -40.0 * slide, 1e-14);
            let [normal, tangential] = motion.percussion(t);
            close("p_N", normal, 10.0 * t, 1e-14);
            close("p_T", tangential, -2.0 * slide, 1e-14);
        }
        balances(&motion);
    }
}

#[test]
fn a_block_sticks_and_slips_on_a_shaken_incline() {
    let (g, angle, amplitude, mu) = (9.81, 10f64.to_radians(), 2.0, 0.3);
    let omega = std::f64::consts::TAU;
    let (pull, limit) = (g * angle.sin(), mu * g * angle.cos());
    // It slips from where pull + A sin ωt = μ g cos α; its velocity is then the integral of the difference.
    let slips = ((limit - pull) / amplitude).asin() / omega;
    let speed = |t: f64| {
        (pull - limit) * (t - slips) - amplitude / omega * ((omega * t).cos() - (omega * slips).cos())
    };
    let stops = bisect(speed, 0.4, 0.7);
    let path = |t: f64| {
        0.5 * (pull - limit) * (t - slips).powi(2)
            - amplitude / (omega * omega) * ((omega * t).sin() - (omega * slips).sin())
            + amplitude / omega * (omega * slips).cos() * (t - slips)
    };
    for name in ["newton", "fremond"] {
        let motion = example_motion::<2>("stick_slip", name);
        let mut times: Vec<f64> = motion.mode_changes().iter().map(|change| change.time).collect();
        times.dedup();
        assert_eq!(times.len(), 7, "three slips: {times:?}");
        for period in 0..3 {
            close("slip", times[2 * period + 1], slips + period as f64, 1e-14);
            close("stop", times[2 * period + 2], stops + period as f64, 1e-14);
        }
        for i in 0..=300 {
            let t = 0.01 * f64::from(i);
            let (q, v) = state(&motion, t);
            let (period, phase) = (t.floor(), t - t.floor());
            let now = phase.clamp(slips, stops);
            close("x", q[0], period * path(stops) + path(now), 1e-14);
            close("ẋ", v[0], if phase < stops { speed(now) } else { 0.0 }, 1e-14);
            close("y", q[1], 0.05, 1e-16);
            close("angle", q[2], 0.0, 1e-15);
            close("p_N", motion.percussion(t)[0], 2.0 * g * angle.cos() * t, 1e-13);
        }
        balances(&motion);
    }
}

#[test]
fn a_spring_on_a_rough_floor_loses_the_same_amplitude_at_every_swing() {
    let exact = FrictionOscillator { omega: 5.0, shift: 0.08, start: 0.87 };
    for name in ["newton", "fremond"] {
        let (mut builder, body) = point_on_floor();
        builder.spring(body, [50.0, 0.0, 0.0]).expect("positive");
        let system = builder.build().expect("a body");
        let motion = motion::<2>(system, law(name, 0.0, 0.2), (&[0.87, 0.0, 0.0], &[0.0; 3]), 5.0);
        let changes = motion.mode_changes();
        // Five half swings, each from one turning point to the next, and rest at 0.07 < 0.08.
        assert_eq!(changes.len(), 6, "{changes:?}");
        assert_eq!(changes[5].to, Mode::Stick);
        for (swing, change) in changes.iter().enumerate() {
            close("turn", change.time, swing as f64 * std::f64::consts::PI / 5.0, 1e-14);
        }
        for i in 0..=500 {
            let t = 0.01 * f64::from(i);
            let (q, v) = state(&motion, t);
            let (x, speed) = exact.at(t);
            close("x", q[0], x, 1e-14);
            close("ẋ", v[0], speed, 1e-13);
        }
        balances(&motion);
    }
}

#[test]
fn an_impact_oscillator_stays_on_its_periodic_orbit() {
    let exact = exact::PeriodicOrbit::new(1.7, 0.5);
    let motion = example_motion::<1>("impact_oscillator", "fremond");
    assert_eq!(motion.impacts().len(), 5);
    for (n, impact) in motion.impacts().iter().enumerate() {
        close("t", impact.time, (n + 1) as f64 * exact.period, 1e-14 * (n + 1) as f64);
        close("u⁻", impact.contacts[0].before[0], -2.0 * exact.speed, 1e-14);
    }
    for i in 0..1000 {
        let t = 0.02 * f64::from(i) + 1e-3;
        let (q, v) = state(&motion, t);
        let (x, speed) = exact.at(t);
        close("x", q[0], x, 1e-13);
        close("ẋ", v[0], speed, 1e-13);
    }
    balances(&motion);
}

#[test]
fn an_orbit_that_touches_the_wall_goes_on_as_if_there_were_none() {
    let motion = example_motion::<1>("grazing_oscillator", "newton");
    assert!(motion.impacts().is_empty() && motion.mode_changes().is_empty());
    for i in 0..=400 {
        let t = 0.01 * f64::from(i);
        let (q, v) = state(&motion, t);
        let (x, speed) = exact::grazing(2.0, 0.1, t);
        close("x", q[0], x, 1e-14);
        close("ẋ", v[0], speed, 1e-14);
    }
    balances(&motion);
    // A wall 1e-10 m further in is hit at the speed √(2 ẍ δ), a wall 1e-10 m further out is not.
    let acceleration = 4.0 * exact::grazing(2.0, 0.1, 0.0).0.max(0.330_409_300_227_544_9);
    for (depth, hit) in [(1e-10_f64, true), (-1e-10, false)] {
        let mut scene = example::scene("grazing_oscillator");
        scene.half_planes[0].point[0] = depth;
        let motion = run::<1>(&scene, "newton", &Settings::default()).expect("an oscillator");
        assert_eq!(motion.impacts().len(), usize::from(hit));
        if hit {
            let speed = -motion.impacts()[0].contacts[0].before[0];
            // Of the first order in √δ, and to the rounding of δ.
            close("u⁻", speed, (2.0 * acceleration * depth).sqrt(), 1e-5 * speed);
        }
    }
}

#[test]
fn a_mass_that_slides_down_a_hill_leaves_it_at_two_thirds_of_the_height() {
    // From rest at the angle a from the top of the unit circle: cos φ = ⅔ cos a where N = m (g cos φ − v²) = 0.
    let start = 0.1_f64;
    let distance = |q: &[f64]| q[0].hypot(q[1]);
    let gap = SmoothGap::new(
        move |q: &[f64]| distance(q) - 1.0,
        move |q: &[f64], push| {
            push(0, Vector1::new(q[0] / distance(q)));
            push(1, Vector1::new(q[1] / distance(q)));
        },
    );
    let mass = Symmetric::diagonal(vec![2.0; 2]).expect("finite");
    let weight = Forces::constant(vec![0.0, -20.0]);
    let hill = Lagrangian::<f64, 1>::new(mass).with_forces(weight).expect("finite").with_contact(0, gap);
    let motion = motion::<1>(hill, law("newton", 0.5, 0.0), (&[start.sin(), start.cos()], &[0.0; 2]), 1.5);
    let changes = motion.mode_changes();
    assert_eq!(changes.len(), 2, "{changes:?}");
    let leaves = changes[1].time;
    let (q, v) = state(&motion, leaves);
    let cosine = 2.0 / 3.0 * start.cos();
    // N falls at 3 m g sin φ φ̇ ≈ 35 N/s: its rounding of some 1e-14 m g moves the time by 1e-14 s.
    close("cos φ", q[1], cosine, 1e-13);
    close("v²", v[0] * v[0] + v[1] * v[1], 10.0 * cosine, 1e-12);
    // t = ∫ dφ/√(2g (cos a − cos φ)), with φ = a + s² to take the root out of the integrand.
    let time = exact::simpson(0.0, (cosine.acos() - start).sqrt(), 2000, |s| {
        let phi = start + s * s;
        let fall =
            2.0 * (0.5 * (phi + start)).sin() * if s > 0.0 { (0.5 * s * s).sin() / (s * s) } else { 0.5 };
        2.0 / (20.0 * fall).sqrt()
    });
    close("t", leaves, time, 1e-12);
    // And then a parabola.
    let (p, _) = state(&motion, 1.5);
    let tau = 1.5 - leaves;
    close("x", p[0], q[0] + v[0] * tau, 1e-14);
    close("y", p[1], q[1] + v[1] * tau - 5.0 * tau * tau, 1e-14);
    balances(&motion);
}

#[test]
fn a_square_wave_pushes_piece_by_piece() {
    // ±12 N at 2 Hz on 2 kg with μ m g = 4 N: from rest it is pushed at 4 m/s², then braked at 8 m/s² and pushed back.
    let (mut builder, body) = point_on_floor();
    let signal = Signal::Square { frequency: 2.0, phase: 0.0 };
    builder.load(body, [12.0, 0.0], 0.0, signal).expect("a load");
    let system = builder.build().expect("a body");
    let motion = motion::<2>(system, law("fremond", 0.0, 0.2), (&[0.0; 3], &[0.0; 3]), 0.75);
    // 1 m/s at 0.25; it stands at 0.375, slides back to −0.5 m/s at 0.5, stands at 0.5625, and is at 0.75 m/s at 0.75.
    for (time, x, speed) in [
        (0.25, 0.125, 1.0),
        (0.375, 0.1875, 0.0),
        (0.5, 0.15625, -0.5),
        (0.5625, 0.140625, 0.0),
        (0.75, 0.2109375, 0.75),
    ] {
        let (q, v) = state(&motion, time);
        close("x", q[0], x, 1e-15);
        close("ẋ", v[0], speed, 1e-14);
    }
    let turns: Vec<f64> = motion.mode_changes().iter().map(|change| change.time).collect();
    assert!(
        turns.len() == 3 && (turns[1] - 0.375).abs() < 1e-15 && (turns[2] - 0.5625).abs() < 1e-15,
        "{turns:?}"
    );
    balances(&motion);
}

#[test]
fn a_rocking_block_keeps_its_energy_and_loses_its_share_of_spin() {
    let motion = example_motion::<2>("rocking_block", "fremond");
    let alpha = 0.25_f64.atan();
    let share = 1.0 - 1.5 * alpha.sin().powi(2);
    assert_eq!(motion.impacts().len(), 4);
    // I₀ = m r² 4/3 about a corner, r² = 4.25; it falls from 0.9 α to 0.
    let (inertia, weight, radius) = (4.0 * 4.25 * 4.0 / 3.0, 4.0 * 9.81, 4.25_f64.sqrt());
    let fall = weight * radius * ((0.1 * alpha).cos() - alpha.cos());
    let mut spin = (2.0 * fall / inertia).sqrt();
    for impact in motion.impacts() {
        let (_, v) = before(&motion, impact.time);
        close("ω⁻", v[2].abs(), spin, 1e-12);
        let (_, v) = state(&motion, impact.time);
        spin *= share;
        close("ω⁺", v[2].abs(), spin, 1e-12);
    }
    balances(&motion);
}

#[test]
fn a_rod_pushed_into_the_floor_stops_in_an_impact_without_collision() {
    // tan γ = ½, μ = 2: W = [[1.6, 1.2], [1.2, 3.4]], sliding at 1 m/s. W_NN < μ W_NT: no force can keep it sliding.
    let angle = 0.5f64.atan();
    let rod = || {
        let mut builder = RigidBodies::builder();
        let (tips, floors) = (builder.group(), builder.group());
        let body = builder.body("rod", Body { mass: 1.0, inertia: 1.0 / 12.0 }).expect("positive");
        builder.disc("tip", body, [0.0, -0.5], 0.0, tips).expect("a point");
        builder.half_plane("floor", [0.0; 2], [0.0, 1.0], floors).expect("a floor");
        builder.interface(tips, floors).expect("groups");
        builder.gravity([0.0, -10.0]).expect("finite");
        builder.build().expect("a body")
    };
    let q = [0.0, 0.5 * angle.cos(), angle];
    for (name, percussion, after) in [("newton", [0.3, -0.4], 0.0), ("fremond", [0.6, -0.8], -1.0)] {
        let motion = motion::<2>(rod(), law(name, 0.0, 2.0), (&q, &[1.0, 0.0, 0.0]), 0.05);
        let [impact] = motion.impacts() else { panic!("{name}: {} impacts", motion.impacts().len()) };
        let contact = impact.contacts[0];
        close("t", impact.time, 0.0, 0.0);
        close("p_N", contact.percussion[0], percussion[0], 1e-15);
        close("p_T", contact.percussion[1], percussion[1], 1e-15);
        close("u_T", contact.after[1], after, 1e-15);
        balances(&motion);
        // Sliding the other way there is nothing to stop.
        let motion = self::motion::<2>(rod(), law(name, 0.0, 2.0), (&q, &[-1.0, 0.0, 0.0]), 0.05);
        assert!(motion.impacts().is_empty() && motion.mode_changes()[0].to == Mode::Slide(-1.0));
        balances(&motion);
    }
}

#[test]
fn the_error_of_the_dense_output_follows_the_tolerance() {
    let exact = exact::PeriodicOrbit::new(1.7, 0.5);
    let scene = example::scene("impact_oscillator");
    let mut last = f64::INFINITY;
    for tolerance in [1e-3, 1e-5, 1e-7, 1e-9, 1e-12, 1e-14] {
        let settings = Settings { tolerance, ..Settings::default() };
        let motion = run::<1>(&scene, "fremond", &settings).expect("an oscillator");
        let mut worst = 0.0_f64;
        for i in 0..1000 {
            let t = 0.02 * f64::from(i) + 1e-3;
            let ((q, v), (x, speed)) = (state(&motion, t), exact.at(t));
            worst = worst.max((q[0] - x).abs()).max((v[0] - speed).abs());
        }
        // The first coefficients left out are smaller than the last kept, on an orbit that forgets what was left out.
        assert!(worst <= tolerance.max(rounding(1.0)), "{tolerance:e}: {worst:e}");
        assert!(worst < last || last < rounding(1.0), "{tolerance:e}: {worst:e} after {last:e}");
        last = worst;
    }
}

#[test]
fn what_it_cannot_do_is_refused_and_what_was_done_is_kept() {
    let scene = example::scene("double_pendulum");
    let error = run::<2>(&scene, "newton", &Settings::default()).expect_err("joints");
    assert!(matches!(error.failure, EventFailure::Unsupported { what: "joints" }) && error.motion.is_none());

    let ball = |e: f64, q: &[f64], v: &[f64], end: f64, settings: Settings| {
        let system = point_on_floor().0.build().expect("a body");
        integrate::<2>(
            Box::new(system),
            vec![law("newton", e, 0.0)],
            hybrid(),
            0.0,
            q.to_vec(),
            v.to_vec(),
            end,
            &settings,
        )
        .map_err(|error| (error.to_string(), error))
    };
    let (q, v, settings) = ([0.0, 1.0, 0.0], [0.0; 3], Settings::default());
    let overlap = ball(0.5, &[0.0, -0.1, 0.0], &v, 1.0, settings).expect_err("it is in the floor").1;
    assert!(matches!(overlap.failure, EventFailure::Overlap { gap, .. } if gap == -0.1), "{overlap}");
    let size = ball(0.5, &q[..2], &v, 1.0, settings).expect_err("two coordinates").1;
    assert!(matches!(size.failure, EventFailure::Size { what: "q", given: 2, expected: 3 }));
    for (end, q, settings) in [
        (0.0, q, settings),
        (f64::NAN, q, settings),
        (1.0, [0.0, f64::NAN, 0.0], settings),
        (1.0, q, Settings { tolerance: 0.0, ..settings }),
        (1.0, q, Settings { largest_step: f64::NAN, ..settings }),
    ] {
        let error = ball(0.5, &q, &v, end, settings).expect_err("out of range").1;
        assert!(matches!(error.failure, EventFailure::OutOfRange { .. }), "{error}");
    }
    // A ball that never rests runs out of events, and has its motion up to there.
    let settings = Settings { max_events: 25, ..settings };
    let (text, error) = ball(1.0, &q, &v, 1000.0, settings).expect_err("more than 25 events");
    assert!(matches!(error.failure, EventFailure::TooMany { limit: 25 }) && text.contains("25"), "{text}");
    let motion = error.motion.expect("the motion so far");
    assert!(motion.impacts().len() >= 10 && motion.end() == error.time);
    balances(&motion);
    // Nor is more kept of a motion than the steps allowed.
    let settings = Settings { max_steps: 3, ..Settings::default() };
    let (text, error) = ball(1.0, &q, &v, 1000.0, settings).expect_err("more than three steps");
    assert!(matches!(error.failure, EventFailure::TooManySteps { limit: 3, .. }), "{text}");
    assert!(error.motion.is_some_and(|motion| motion.end() == error.time));
}
