//! Impacts under error control: many in a short time, several at once, at the ends of the span; motions known in closed form.
#![cfg(feature = "scene")]

#[path = "mechanics/example.rs"]
#[allow(dead_code, reason = "the scenes here are written here")]
mod example;

use std::f64::consts::{PI, SQRT_2};
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::Path;

use nonsmooth::adaptive::{Adaptive, AdaptiveError, AdaptiveSettings, Report};
use nonsmooth::scalar::{Scalar, to_f64};
use nonsmooth::scene::Scene;

const LAWS: [&str; 2] = ["newton", "fremond"];
const RULES: [&str; 2] = ["moreau-jean", "predicted-gap"];
const RADIUS: f64 = 0.1;

/// Accuracy of the cone solver, relative to velocities.
const SOLVER: f64 = 1e-10;

/// Discs without friction, and half-planes; the scene's coefficient of restitution is one.
struct Scenery {
    restitution: f64,
    gravity: f64,
    end: f64,
    rule: &'static str,
    /// (mass, position, velocity).
    discs: Vec<(f64, [f64; 2], [f64; 2])>,
    /// (point, normal).
    walls: Vec<([f64; 2], [f64; 2])>,
}

impl Scenery {
    /// Discs on a line in front of a wall at x = 0: (mass, x, velocity).
    fn line(discs: &[(f64, f64, f64)], restitution: f64, end: f64) -> Self {
        let discs = discs.iter().map(|&(mass, x, v)| (mass, [x, 0.0], [v, 0.0])).collect();
        let walls = vec![([0.0, 0.0], [1.0, 0.0])];
        Self { restitution, gravity: 0.0, end, rule: "moreau-jean", discs, walls }
    }

    fn scene(&self) -> Scene {
        let Self { restitution, gravity, end, rule, discs, walls } = self;
        let mut text = format!(
            "title = \"discs\"\nlaws = [\"newton\", \"fremond\"]\ngravity = [0.0, {:?}]\n[time]\nstep = 1e-3\nend = {end:?}\n\
             theta = 0.5\nallow_unproved_theta = true\nactivation = \"{rule}\"\n",
            -gravity
        );
        let mut names = Vec::new();
        for (i, (mass, position, velocity)) in discs.iter().enumerate() {
            let inertia = 0.5 * mass * RADIUS * RADIUS;
            let _ = write!(
                text,
                "[[bodies]]\nname = \"b{i}\"\nmass = {mass:?}\ninertia = {inertia:?}\nposition = {position:?}\n\
                 velocity = {velocity:?}\nspin = 0.0\n[[bodies.discs]]\nname = \"rim\"\nradius = {RADIUS:?}\n"
            );
            names.push(format!("b{i}"));
        }
        for (i, (point, normal)) in walls.iter().enumerate() {
            let _ =
                write!(text, "[[half_planes]]\nname = \"w{i}\"\npoint = {point:?}\nnormal = {normal:?}\n");
            names.push(format!("w{i}"));
        }
        for (i, one) in names.iter().enumerate() {
            for other in names[i + 1..].iter().filter(|_| i < discs.len()) {
                let _ = write!(
                    text,
                    "[[interfaces]]\nbetween = [\"{one}\", \"{other}\"]\nparameters = {{ restitution = {restitution:?} }}\n"
                );
            }
        }
        Scene::parse(&text, Path::new("discs.toml")).unwrap_or_else(|error| panic!("{error}\n{text}"))
    }

    fn run(&self, law: &str, tolerance: f64) -> Result<End, AdaptiveError> {
        self.run_in::<f64>(law, AdaptiveSettings::new(tolerance, self.end))
    }

    fn run_in<T: Scalar>(&self, law: &str, settings: AdaptiveSettings<T>) -> Result<End, AdaptiveError> {
        let (scheme, _) = example::scheme::<T, 1>(&self.scene(), law, "hybrid");
        let mut driver = Adaptive::new(scheme, settings)?;
        let (mut impacts, mut last) = (0, 0.0);
        let _end: ControlFlow<()> = driver.advance_to(settings.end, |_, state, step| {
            let hits = step.contacts.iter().filter(|contact| to_f64(contact.percussion[0]) > 1e-3).count();
            impacts += hits;
            if hits > 0 {
                last = to_f64(state.time);
            }
            ControlFlow::Continue(())
        })?;
        let (state, report) = (driver.scheme().state(), driver.report());
        assert_eq!(to_f64(state.time), to_f64(settings.end), "the run ends at its end");
        let all = |x: &[T]| x.iter().map(|&x| to_f64(x)).collect();
        let report = Report {
            accepted: report.accepted,
            rejected: report.rejected,
            computed: report.computed,
            events: report.events,
            estimated_error: to_f64(report.estimated_error),
            smallest_step: to_f64(report.smallest_step),
            largest_step: to_f64(report.largest_step),
        };
        Ok(End { q: all(&state.q), v: all(&state.v), impacts, last, report })
    }
}

/// What a run came to; `impacts` and `last` count percussions above 1e-3 N s.
#[derive(Debug)]
struct End {
    q: Vec<f64>,
    v: Vec<f64>,
    impacts: usize,
    last: f64,
    report: Report<f64>,
}

/// A point in a wedge 0 ≤ φ ≤ α that is reflected at its sides, unfolded: it goes straight on through copies of the wedge.
struct Billiard {
    angle: f64,
    start: [f64; 2],
    /// Towards the apex, along the side φ = 0.
    speed: f64,
}

impl Billiard {
    /// Sides crossed: φ goes from that of the start to π.
    fn reflections(&self) -> usize {
        // π/α whole: the last side is parallel to the path.
        let sides = PI / self.angle;
        (sides * (1.0 - 1e-12)).floor() as usize
    }

    /// Position and velocity at time t.
    fn at(&self, time: f64) -> ([f64; 2], [f64; 2]) {
        let [x, y] = [self.start[0] - self.speed * time, self.start[1]];
        let (distance, unfolded) = (x.hypot(y), y.atan2(x));
        let sides = (unfolded / self.angle).floor();
        let fold = |angle: f64| {
            if sides % 2.0 == 0.0 { angle - sides * self.angle } else { (sides + 1.0) * self.angle - angle }
        };
        let (place, heading) = (fold(unfolded), fold(PI));
        let polar = |length: f64, angle: f64| [length * angle.cos(), length * angle.sin()];
        (polar(distance, place), polar(self.speed, heading))
    }

    /// Time of the last reflection.
    fn last(&self) -> f64 {
        let [x, y] = self.start;
        (x - y / (self.reflections() as f64 * self.angle).tan()) / self.speed
    }
}

/// A heavy ball at −1 m/s, a light one at rest, and a wall: gaps 0.9 m and 0.8 m.
fn two_balls(light: f64, heavy: f64) -> (Scenery, Billiard) {
    let discs = [(light, 0.9 + RADIUS, 0.0), (heavy, 1.7 + 3.0 * RADIUS, -1.0)];
    // In √M x₂, √m x₁ (of surfaces) kinetic energy is half a speed squared: contacts are the sides of a wedge.
    let billiard = Billiard {
        angle: (light / heavy).sqrt().atan(),
        start: [heavy.sqrt() * 1.7, light.sqrt() * 0.9],
        speed: heavy.sqrt(),
    };
    (Scenery::line(&discs, 1.0, 8.0), billiard)
}

#[test]
fn two_balls_and_a_wall_count_the_digits_of_pi() {
    let cases =
        [(1.0, 1.0, 3), (3.0, 1.0, 2), (1.0, 3.0, 5), (1.0, 100.0, 31), (1.0, 1000.0, 99), (1.0, 1e4, 314)];
    for (light, heavy, expected) in cases {
        let (mut scenery, billiard) = two_balls(light, heavy);
        assert_eq!(billiard.reflections(), expected, "the closed form");
        let ([x, y], [u, w]) = billiard.at(scenery.end);
        let exact = [y / light.sqrt() + RADIUS, x / heavy.sqrt() + 3.0 * RADIUS];
        let exact_v = [w / light.sqrt(), u / heavy.sqrt()];
        for tolerance in [1e-2, 1e-4, 1e-5, 1e-7, 1e-8, 1e-9] {
            for (law, rule) in LAWS.into_iter().zip(RULES).chain(LAWS.into_iter().rev().zip(RULES)) {
                scenery.rule = rule;
                let name = format!("{light}:{heavy}, {law}, {rule}, ε = {tolerance:e}");
                let end = scenery.run(law, tolerance).unwrap_or_else(|error| panic!("{name}: {error}"));
                assert_eq!(end.impacts, expected, "{name}: {end:?}");
                for (i, dof) in [0, 3].into_iter().enumerate() {
                    let far = (end.q[dof] - exact[i]).abs();
                    assert!(far <= 3.0 * tolerance, "{name}: body {i} is off by {far:e}, {end:?}");
                    // Every impact solves for a velocity to the solver's tolerance, of √(M/m) m/s at most.
                    let bound = SOLVER * expected as f64 * (1.0 + (heavy / light).sqrt());
                    let far = (end.v[dof] - exact_v[i]).abs();
                    assert!(far <= bound, "{name}: velocity {i} is off by {far:e} > {bound:e}");
                }
                let late = (end.last - billiard.last()).abs();
                assert!(late <= 3.0 * tolerance, "{name}: the last impact is off by {late:e} s");
                // Approach, impact and flight: some steps for each, however close they are.
                let most = 100 + 20 * expected;
                assert!(end.report.computed <= most, "{name}: {end:?}");
            }
        }
    }
}

#[test]
fn a_ball_between_converging_walls_is_sent_back_after_a_known_number_of_impacts() {
    for (angle, expected) in [(0.3_f64, 10), (0.05, 62), (1.0, 3)] {
        // The centre moves in a wedge of its own, a radius from the walls.
        let apex = [RADIUS * (1.0 + angle.cos()) / angle.sin(), RADIUS];
        let billiard = Billiard { angle, start: [1.0, 0.01], speed: 1.0 };
        assert_eq!(billiard.reflections(), expected);
        let scenery = Scenery {
            discs: vec![(1.0, [apex[0] + 1.0, apex[1] + 0.01], [-1.0, 0.0])],
            walls: vec![([0.0, 0.0], [0.0, 1.0]), ([0.0, 0.0], [angle.sin(), -angle.cos()])],
            ..Scenery::line(&[], 1.0, 3.0)
        };
        let (exact, exact_v) = billiard.at(3.0);
        for law in LAWS {
            for tolerance in [1e-3, 1e-6, 1e-9] {
                let name = format!("{angle} rad, {law}, ε = {tolerance:e}");
                let end = scenery.run(law, tolerance).unwrap_or_else(|error| panic!("{name}: {error}"));
                assert_eq!(end.impacts, expected, "{name}: {end:?}");
                for i in 0..2 {
                    let far = (end.q[i] - apex[i] - exact[i]).abs();
                    assert!(far <= 3.0 * tolerance, "{name}: off by {far:e}, {end:?}");
                    let far = (end.v[i] - exact_v[i]).abs();
                    assert!(far <= 10.0 * SOLVER * expected as f64, "{name}: velocity off by {far:e}");
                }
            }
        }
    }
}

/// A ball that comes at −1 m/s to others at rest with gaps between them, far from the wall.
fn cradle(balls: usize, gap: f64) -> Scenery {
    let place = |i: usize| 5.0 + i as f64 * (2.0 * RADIUS + gap);
    let mut discs: Vec<_> = (0..balls).map(|i| (1.0, place(i), 0.0)).collect();
    discs.push((1.0, place(balls) + 0.5, -1.0));
    Scenery::line(&discs, 1.0, 2.0)
}

#[test]
fn balls_in_a_row_hand_the_speed_on_through_gaps_that_are_seen() {
    // γ = 1e-4 ε L: the gaps are above it.
    for (gap, tolerance) in [(1e-9, 1e-7), (1e-6, 1e-4), (1e-6, 1e-8), (1e-3, 1e-2)] {
        for (law, rule) in LAWS.into_iter().zip(RULES).chain(LAWS.into_iter().rev().zip(RULES)) {
            for balls in [2, 5] {
                let scenery = Scenery { rule, ..cradle(balls, gap) };
                let name = format!("{balls} balls, gap {gap:e}, {law}, {rule}, ε = {tolerance:e}");
                let end = scenery.run(law, tolerance).unwrap_or_else(|error| panic!("{name}: {error}"));
                assert_eq!(end.impacts, balls, "{name}: {end:?}");
                let bound = 10.0 * SOLVER * balls as f64;
                for (i, v) in end.v.iter().step_by(3).enumerate() {
                    let exact = if i == 0 { -1.0 } else { 0.0 };
                    assert!((v - exact).abs() <= bound, "{name}: ball {i} has {v}");
                }
            }
        }
    }
}

#[test]
fn balls_in_a_row_that_touch_are_hit_at_once() {
    // Gaps of rounding are none: the law for impacts, with e = 1 at both contacts, gives 2/3, 2/3 and −1/3.
    for gap in [0.0, 1e-12] {
        for law in LAWS {
            for tolerance in [1e-3, 1e-6] {
                let name = format!("gap {gap:e}, {law}, ε = {tolerance:e}");
                let end =
                    cradle(2, gap).run(law, tolerance).unwrap_or_else(|error| panic!("{name}: {error}"));
                for (i, exact) in [-2.0 / 3.0, -2.0 / 3.0, 1.0 / 3.0].into_iter().enumerate() {
                    assert!((end.v[3 * i] - exact).abs() <= 10.0 * SOLVER, "{name}: {end:?}");
                }
                assert_eq!(end.impacts, 2, "{name}: {end:?}");
            }
        }
    }
}

#[test]
fn balls_that_land_at_the_same_instant_do_not_disturb_each_other() {
    let gravity = 10.0;
    for restitution in [0.0, 0.5, 1.0] {
        for (law, rule) in LAWS.into_iter().zip(RULES).chain(LAWS.into_iter().rev().zip(RULES)) {
            for (tolerance, apart) in [(1e-3, 0.0), (1e-6, 0.0), (1e-6, 1e-11), (1e-6, 1e-8)] {
                let heights = [1.0, 1.0 + apart];
                let scenery = Scenery {
                    gravity,
                    rule,
                    discs: (0..2)
                        .map(|i| (1.0 + i as f64, [i as f64, heights[i] + RADIUS], [0.0, 0.0]))
                        .collect(),
                    walls: vec![([0.0, 0.0], [0.0, 1.0])],
                    ..Scenery::line(&[], restitution, 0.8)
                };
                let name = format!("e = {restitution}, {law}, {rule}, ε = {tolerance:e}, {apart:e} m apart");
                let end = scenery.run(law, tolerance).unwrap_or_else(|error| panic!("{name}: {error}"));
                for (i, height) in heights.into_iter().enumerate() {
                    let landing = (2.0 * height / gravity).sqrt();
                    let (since, up) = (scenery.end - landing, restitution * gravity * landing);
                    let (y, v) = match restitution == 0.0 {
                        true => (0.0, 0.0),
                        false => (since * (up - 0.5 * gravity * since), up - gravity * since),
                    };
                    let far = (end.q[3 * i + 1] - RADIUS - y).abs();
                    assert!(far <= 3.0 * tolerance, "{name}: ball {i} is off by {far:e}, {end:?}");
                    // The velocity is wrong by the time of the impact, √2 ε L/|v| of it, times gravity.
                    let far = (end.v[3 * i + 1] - v).abs();
                    assert!(far <= 3.0 * SQRT_2 * gravity * tolerance, "{name}: {far:e}, {end:?}");
                }
            }
        }
    }
}

#[test]
fn an_impact_at_the_start_is_made_there() {
    for restitution in [0.0, 0.5, 1.0] {
        for (law, rule) in LAWS.into_iter().zip(RULES).chain(LAWS.into_iter().rev().zip(RULES)) {
            for tolerance in [1e-2, 1e-8] {
                let scenery = Scenery { rule, ..Scenery::line(&[(1.0, RADIUS, -1.0)], restitution, 2.0) };
                let name = format!("e = {restitution}, {law}, {rule}, ε = {tolerance:e}");
                let end = scenery.run(law, tolerance).unwrap_or_else(|error| panic!("{name}: {error}"));
                assert_eq!(end.impacts, 1, "{name}: {end:?}");
                assert!(end.last <= tolerance, "{name}: {end:?}");
                let far = (end.q[0] - RADIUS - 2.0 * restitution).abs();
                assert!(far <= tolerance, "{name}: {far:e}, {end:?}");
                assert!((end.v[0] - restitution).abs() <= 10.0 * SOLVER, "{name}: {end:?}");
            }
        }
    }
}

#[test]
fn an_impact_at_the_very_end_leaves_the_ball_at_the_wall() {
    for restitution in [0.0, 0.5, 1.0] {
        for law in LAWS {
            for tolerance in [1e-2, 1e-6, 1e-9] {
                let scenery = Scenery::line(&[(1.0, 2.0 + RADIUS, -1.0)], restitution, 2.0);
                let name = format!("e = {restitution}, {law}, ε = {tolerance:e}");
                let end = scenery.run(law, tolerance).unwrap_or_else(|error| panic!("{name}: {error}"));
                assert!((end.q[0] - RADIUS).abs() <= tolerance, "{name}: {end:?}");
                // Before the impact or after it: both are the motion to within ε.
                let either = [-1.0, restitution].into_iter().any(|v| (end.v[0] - v).abs() <= 10.0 * SOLVER);
                assert!(either && end.impacts <= 1, "{name}: {end:?}");
            }
        }
    }
}

#[test]
fn without_restitution_two_balls_stop_at_the_wall() {
    for (law, rule) in LAWS.into_iter().zip(RULES).chain(LAWS.into_iter().rev().zip(RULES)) {
        for tolerance in [1e-2, 1e-5, 1e-8] {
            let (scenery, _) = two_balls(1.0, 1.0);
            let scenery = Scenery { restitution: 0.0, rule, ..scenery };
            let name = format!("{law}, {rule}, ε = {tolerance:e}");
            let end = scenery.run(law, tolerance).unwrap_or_else(|error| panic!("{name}: {error}"));
            for (dof, place) in [(0, RADIUS), (3, 3.0 * RADIUS)] {
                assert!((end.q[dof] - place).abs() <= 3.0 * tolerance, "{name}: {end:?}");
                assert!(end.v[dof].abs() <= 10.0 * SOLVER, "{name}: {end:?}");
            }
        }
    }
}

#[test]
fn single_precision_counts_the_same_impacts() {
    for (heavy, expected) in [(1.0, 3), (100.0, 31)] {
        let (scenery, billiard) = two_balls(1.0, heavy);
        let ([_, y], _) = billiard.at(8.0);
        for law in LAWS {
            for tolerance in [1e-2, 1e-3] {
                let name = format!("1:{heavy}, {law}, ε = {tolerance:e}");
                let end = scenery
                    .run_in::<f32>(law, AdaptiveSettings::new(tolerance, 8.0))
                    .unwrap_or_else(|error| panic!("{name}: {error}"));
                assert_eq!(end.impacts, expected, "{name}: {end:?}");
                let far = (end.q[0] - RADIUS - y).abs();
                assert!(far <= 3.0 * f64::from(tolerance) * (1.0 + y), "{name}: {far:e}, {end:?}");
            }
        }
    }
}

#[test]
fn a_motion_that_takes_more_steps_than_allowed_ends_with_their_number() {
    let (scenery, billiard) = two_balls(1.0, 1000.0);
    let settings = AdaptiveSettings { max_steps: 8, ..AdaptiveSettings::new(1e-7, 8.0) };
    let ended = scenery.run_in("fremond", settings).expect_err("99 impacts need more");
    let AdaptiveError::TooManySteps { time, since, steps, most, .. } = ended else { panic!("{ended}") };
    assert!(steps > 8 && most == 8, "{steps} of {most}");
    // A thousandth of the span is not over.
    assert!(since <= time && time - since <= 8e-3 && time <= billiard.last(), "from {since} to {time}");
    let refused = scenery.run_in("fremond", AdaptiveSettings { max_steps: 0, ..settings }).expect_err("none");
    assert!(matches!(refused, AdaptiveError::OutOfRange { .. }), "{refused}");
}
