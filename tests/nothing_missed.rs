//! Fast bodies meet what stands in their way: no step is long enough to pass through it.

#[path = "mechanics/motion.rs"]
#[allow(dead_code)]
mod motion;

use std::ops::ControlFlow;

use motion::{close, hybrid, law};
use nonsmooth::adaptive::{Adaptive, AdaptiveSettings};
use nonsmooth::scheme::{Activation, ActivationRule, Settings, ThetaScheme};
use nonsmooth::system::{Body, BodyId, Contacts, RigidBodies, RigidBodiesBuilder};

type Scheme = ThetaScheme<f64, 2>;

const STEP: f64 = 1e-3;
const RADIUS: f64 = 0.005;

/// Rounding of positions and speeds after some dozens of steps, relative to the path and the speed: thousands of ε; and where
/// the solver has more than one contact to solve, its tolerance of 1e-10 instead.
const ROUNDING: f64 = 1e-11;
const SOLVED: f64 = 1e-8;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    Disc,
    Point,
    Square,
    Plate,
}

const SHAPES: [Shape; 4] = [Shape::Disc, Shape::Point, Shape::Square, Shape::Plate];

impl Shape {
    /// Half its thickness.
    fn half(self) -> f64 {
        if self == Self::Point { 0.0 } else { RADIUS }
    }
}

/// Bodies that all touch each other under one law.
struct Bodies {
    builder: RigidBodiesBuilder<f64>,
    group: nonsmooth::system::GroupId,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl Bodies {
    fn new() -> Self {
        let mut builder = RigidBodies::builder();
        let group = builder.group();
        builder.interface(group, group).expect("the group exists");
        Self { builder, group, q: Vec::new(), v: Vec::new() }
    }

    fn add(&mut self, shape: Shape, mass: f64, [x, y]: [f64; 2], velocity: [f64; 3]) -> BodyId {
        let inertia = mass * if shape == Shape::Plate { 0.1 } else { RADIUS * RADIUS };
        let body = self.builder.body("body", Body { mass, inertia }).expect("positive");
        let rectangle = |a: f64, b: f64| [[-a, -b], [a, -b], [a, b], [-a, b]];
        match shape {
            Shape::Disc => self.builder.disc("disc", body, [0.0; 2], RADIUS, self.group),
            Shape::Point => self.builder.disc("point", body, [0.0; 2], 0.0, self.group),
            Shape::Square => self.builder.polygon("square", body, &rectangle(RADIUS, RADIUS), self.group),
            Shape::Plate => self.builder.polygon("plate", body, &rectangle(RADIUS, 0.5), self.group),
        }
        .expect("a shape");
        self.q.extend([x, y, 0.0]);
        self.v.extend(velocity);
        body
    }

    fn fixed(&mut self, shape: Shape, at: [f64; 2]) {
        let body = self.add(shape, 1.0, at, [0.0; 3]);
        self.builder.weld("weld", body, [0.0; 2], None, at, 0.0).expect("a joint");
    }

    fn scheme(self, name: &str, restitution: f64, rule: ActivationRule, sleep: bool) -> Scheme {
        let activation = Activation::new(rule);
        let settings = Settings { activation, sleep, allow_unproved_theta: true, ..Settings::new(0.5, STEP) };
        let laws = vec![law(name, restitution, 0.0)];
        let system = self.builder.build().expect("bodies");
        ThetaScheme::new(Box::new(system), laws, hybrid(), settings, 0.0, self.q, self.v)
            .expect("a valid setup")
    }
}

#[test]
fn a_bullet_of_any_shape_rebounds_at_any_speed_from_where_it_met_its_target() {
    let rules = [ActivationRule::MoreauJean, ActivationRule::PredictedGap, ActivationRule::CurrentGap];
    for bullet in SHAPES {
        for target in SHAPES {
            if bullet == Shape::Point && target == Shape::Point {
                continue;
            }
            for (i, speed) in [10.0, 37.0, 100.0, 1e3, 1e4, 1e5].into_iter().enumerate() {
                for restitution in [0.0, 0.5, 1.0] {
                    let mut bodies = Bodies::new();
                    bodies.add(bullet, 0.01, [-0.3, 0.0], [speed, 0.0, 0.0]);
                    bodies.fixed(target, [0.0; 2]);
                    let name = ["newton", "fremond"][i % 2];
                    let mut scheme = bodies.scheme(name, restitution, rules[i % 3], false);
                    let meets = -bullet.half() - target.half();
                    let to_go = (meets + 0.3) / speed;
                    let steps = (to_go / STEP).ceil() + 3.0;
                    for _ in 0..steps as usize {
                        scheme.step().expect("two bodies");
                    }
                    let what = format!("{bullet:?} at {speed} m/s on {target:?}, e = {restitution}");
                    let state = scheme.state();
                    let after = -restitution * speed;
                    close(&what, state.v[0], after, SOLVED * speed);
                    // An overlap at the end of the path of less than half of the bodies' half thicknesses is an ordinary
                    // impact, placed to h|u_N|, and a step later where the gaps of the start decide; any other is exact.
                    let deep = ((to_go / STEP).ceil() * STEP - to_go) * speed > 1.01 * RADIUS;
                    let place = if deep { SOLVED * steps } else { 2.0 } * speed * STEP;
                    close(&what, state.q[0], meets + after * (steps * STEP - to_go), place);
                    assert!(state.q[0] <= meets + speed * STEP, "{what}: beyond, {:?}", state.q);
                }
            }
        }
    }
}

#[test]
fn an_oblique_impact_of_discs_has_the_normal_of_the_place_where_they_meet() {
    for part in [-0.9, -0.3, 0.0, 0.5, 0.8] {
        let mut bodies = Bodies::new();
        let (speed, restitution) = (2e3, 0.5);
        bodies.add(Shape::Disc, 0.01, [-1.3, part * 2.0 * RADIUS], [speed, 0.0, 0.0]);
        bodies.fixed(Shape::Disc, [0.0; 2]);
        let mut scheme = bodies.scheme("newton", restitution, ActivationRule::MoreauJean, false);
        scheme.step().expect("two discs");
        let normal = [-f64::sqrt(1.0 - part * part), part];
        let change = -(1.0 + restitution) * speed * normal[0];
        for i in 0..2 {
            let before = [speed, 0.0][i];
            close(
                &format!("{part}, v[{i}]"),
                scheme.state().v[i],
                before + change * normal[i],
                SOLVED * speed,
            );
        }
    }
}

#[test]
fn bullets_that_meet_head_on_exchange_their_velocities() {
    for shape in [Shape::Disc, Shape::Square] {
        for speed in [1e2, 1e3, 1e5] {
            let mut bodies = Bodies::new();
            bodies.add(shape, 0.01, [-0.04, 0.0], [speed, 0.0, 0.0]);
            bodies.add(shape, 0.01, [0.04, 0.0], [-0.5 * speed, 0.0, 0.0]);
            let mut scheme = bodies.scheme("newton", 1.0, ActivationRule::MoreauJean, true);
            for _ in 0..3 {
                scheme.step().expect("two bullets");
            }
            let (q, v) = (&scheme.state().q, &scheme.state().v);
            close("the first", v[0], -0.5 * speed, SOLVED * speed);
            close("the second", v[3], speed, SOLVED * speed);
            assert!(q[3] - q[0] >= 2.0 * RADIUS, "{shape:?} at {speed} m/s: {q:?}");
        }
    }
}

#[test]
fn of_two_plates_in_a_row_only_the_first_is_hit() {
    let (speed, mass, restitution) = (1e3, 0.01, 0.5);
    let mut bodies = Bodies::new();
    bodies.add(Shape::Disc, mass, [-0.5, 0.0], [speed, 0.0, 0.0]);
    bodies.add(Shape::Plate, 1.0, [0.1, 0.0], [0.0; 3]);
    bodies.add(Shape::Plate, 1.0, [0.0, 0.0], [0.0; 3]);
    let mut scheme = bodies.scheme("newton", restitution, ActivationRule::MoreauJean, false);
    scheme.step().expect("three bodies");
    let v = &scheme.state().v;
    let common = mass * speed / (mass + 1.0);
    close("the plate", v[6], common * (1.0 + restitution), ROUNDING * speed);
    close("the bullet", v[0], common * (1.0 + restitution) - restitution * speed, ROUNDING * speed);
    assert!(v[3].abs() <= f64::EPSILON, "the second plate stands: {v:?}");
}

#[test]
fn a_heavy_bullet_leaves_no_light_plate_behind() {
    let mut bodies = Bodies::new();
    bodies.add(Shape::Square, 100.0, [-0.5, 0.0], [1e3, 0.0, 0.0]);
    bodies.add(Shape::Plate, 0.01, [0.0, 0.0], [0.0; 3]);
    bodies.add(Shape::Plate, 0.01, [0.2, 0.0], [0.0; 3]);
    let mut scheme = bodies.scheme("newton", 0.5, ActivationRule::MoreauJean, false);
    for _ in 0..5 {
        scheme.step().expect("three bodies");
        let q = &scheme.state().q;
        assert!(q[0] <= q[3].min(q[6]), "a plate is behind the bullet: {q:?}");
    }
    let v = &scheme.state().v;
    assert!(v[0] > 0.9e3 && v[3] >= v[0] && v[6] >= v[0], "{v:?}");
}

#[test]
fn a_spinning_bar_hits_a_post_however_far_it_turns_in_a_step() {
    for turn in [0.3, 0.9, 1.7, 2.5, 20.0] {
        let mut bodies = Bodies::new();
        let bar = bodies.add(Shape::Plate, 1.0, [0.0; 2], [0.0, 0.0, turn / STEP]);
        bodies.builder.pin("hub", bar, [0.0; 2], None, [0.0; 2]).expect("a joint");
        // The bar stands upright; the post is a quarter of a radian ahead of it.
        let (sin, cos) = f64::sin_cos(0.25);
        bodies.fixed(Shape::Disc, [-0.4 * sin, 0.4 * cos]);
        let mut scheme = bodies.scheme("newton", 0.5, ActivationRule::MoreauJean, false);
        scheme.step().expect("a bar and a post");
        let state = scheme.state();
        let spin = turn / STEP;
        close(&format!("{turn} rad per step"), state.v[2], -0.5 * spin, SOLVED * spin);
        // Bar and post are 1 cm thick: they meet 1 cm/0.4 m before their middles do.
        assert!(state.q[2] <= 0.25 - 0.0249, "the bar is through: {} rad", state.q[2]);
    }
}

#[test]
fn what_moves_less_than_others_are_thick_is_left_to_the_ordinary_candidates() {
    let mut bodies = Bodies::new();
    for (i, shape) in SHAPES.into_iter().chain(SHAPES).enumerate() {
        bodies.add(shape, 1.0, [0.009 * i as f64, 0.001], [0.0; 3]);
    }
    let mut system = bodies.builder.build().expect("bodies");
    let (q, n) = (bodies.q, bodies.v.len());
    // Half the least half thickness, between the two of a pair: 0.5·RADIUS/2 each, less what the spin of a plate adds.
    let speed = 0.24 * RADIUS / STEP;
    let v: Vec<f64> =
        (0..n).map(|i| if i % 3 == 0 { speed * f64::powi(-1.0, i as i32) } else { 0.0 }).collect();
    let mut out = Vec::new();
    Contacts::<f64, 2>::candidates(&mut system, &q, 0.1, &mut out);
    let (before, mut times) = (out.clone(), Vec::new());
    let mut sweep = |v: &[f64], out: &mut Vec<_>, times: &mut Vec<_>| {
        Contacts::<f64, 2>::swept_candidates(&mut system, &q, (STEP, v), &[], out, times);
    };
    sweep(&v, &mut out, &mut times);
    assert!(!before.is_empty() && times.is_empty() && out == before, "{times:?}");
    // Ten times as fast, the same bodies do cross each other.
    let v: Vec<f64> = v.iter().map(|v| 40.0 * v).collect();
    sweep(&v, &mut out, &mut times);
    assert!(!times.is_empty());
    let mut ids: Vec<_> = out.iter().map(|candidate| candidate.id).collect();
    ids.sort_unstable();
    assert!(ids.windows(2).all(|pair| pair[0] != pair[1]), "a contact is listed twice");
}

#[test]
fn a_bullet_stays_in_its_box_however_often_it_would_cross_it_in_a_step() {
    for shape in [Shape::Disc, Shape::Point, Shape::Square] {
        for (speed, restitution) in [(50.0, 1.0), (1e3, 0.9), (1e4, 1.0), (1e5, 0.5)] {
            let mut bodies = Bodies::new();
            bodies.add(shape, 0.01, [0.03, 0.0], [speed, 0.0, 0.0]);
            bodies.fixed(Shape::Plate, [0.1, 0.0]);
            bodies.fixed(Shape::Plate, [-0.1, 0.0]);
            let mut scheme = bodies.scheme("newton", restitution, ActivationRule::MoreauJean, false);
            let mut turns = 0;
            for _ in 0..50 {
                let before = scheme.state().v[0];
                scheme.step().expect("three bodies");
                let state = scheme.state();
                let room = 0.1 - RADIUS - shape.half();
                // Ordinary impacts overlap by less than half of the half thicknesses.
                assert!(state.q[0].abs() <= room + RADIUS, "{shape:?} at {speed} m/s: out, {:?}", state.q);
                turns += usize::from(before * state.v[0] < 0.0);
            }
            assert!(turns >= 3, "{shape:?} at {speed} m/s: {turns} impacts");
        }
    }
}

#[test]
fn a_body_that_is_hit_does_not_leave_through_its_neighbour_in_the_same_step() {
    for distance in [0.02, 0.1, 0.6] {
        let mut bodies = Bodies::new();
        bodies.add(Shape::Disc, 0.01, [-0.3, 0.0], [1e3, 0.0, 0.0]);
        bodies.add(Shape::Disc, 0.01, [0.0, 0.0], [0.0; 3]);
        bodies.fixed(Shape::Plate, [distance, 0.0]);
        let mut scheme = bodies.scheme("newton", 1.0, ActivationRule::MoreauJean, false);
        for _ in 0..6 {
            scheme.step().expect("three bodies");
            let q = &scheme.state().q;
            assert!(q[0] < q[3] && q[3] < distance, "{distance}: {q:?}");
        }
        // It came back and hit the first, which leaves as it came.
        let v = &scheme.state().v;
        close("the first", v[0], -1e3, SOLVED * 1e3);
        close("the second", v[3], 0.0, SOLVED * 1e3);
    }
}

#[test]
fn the_balance_closes_where_bodies_on_springs_under_gravity_meet_within_a_step() {
    let mut bodies = Bodies::new();
    let speed = 1e3;
    let bullet = bodies.add(Shape::Disc, 0.01, [-0.3, 0.0], [speed, 0.0, 0.0]);
    bodies.fixed(Shape::Plate, [0.0; 2]);
    bodies.builder.spring(bullet, [100.0, 50.0, 0.0]).expect("positive");
    bodies.builder.gravity([2.0, -10.0]).expect("finite");
    let mut scheme = bodies.scheme("newton", 1.0, ActivationRule::MoreauJean, false);
    let start = scheme.last_step().energies.total();
    let mut made = 0.0;
    for _ in 0..5 {
        let step = scheme.step().expect("two bodies");
        assert!(step.balance.imbalance.abs() <= ROUNDING * start.abs(), "{:?}", step.balance);
        made += step.balance.position_work;
    }
    // With e = 1 and θ = ½ nothing is lost: the energy changes by the position work alone.
    let end = scheme.last_step().energies.total();
    close("energy", end - start, made, SOLVED * start);
    assert!(made.abs() > 1e-6 * start, "the springs do position work: {made:e} J of {start:e} J");
    assert!(scheme.state().q[0] < -2.0 * RADIUS && scheme.state().v[0] < 0.0, "{:?}", scheme.state());
}

#[test]
fn a_force_does_not_drive_a_body_through_a_plate_in_one_step() {
    let mut bodies = Bodies::new();
    let bullet = bodies.add(Shape::Disc, 0.01, [-0.05, 0.0], [0.0; 3]);
    bodies.fixed(Shape::Plate, [0.0; 2]);
    // h² F/m = 1 m.
    bodies.builder.force(bullet, [1e4, 0.0], 0.0).expect("finite");
    let mut scheme = bodies.scheme("fremond", 0.0, ActivationRule::PredictedGap, false);
    for _ in 0..10 {
        scheme.step().expect("two bodies");
        let q = &scheme.state().q;
        assert!(q[0] <= -RADIUS, "through the plate: {q:?}");
    }
}

/// A bullet 1 m before a plate, for half a second.
fn shot(bullet: Shape, target: Shape, speed: f64, gravity: f64) -> Bodies {
    let mut bodies = Bodies::new();
    bodies.add(bullet, 0.01, [-1.0, 0.0], [speed, 0.0, 0.0]);
    bodies.fixed(target, [0.0; 2]);
    bodies.builder.gravity([0.0, -gravity]).expect("finite");
    bodies
}

#[test]
fn error_control_meets_the_target_at_every_tolerance() {
    for bullet in [Shape::Disc, Shape::Point, Shape::Square] {
        for target in [Shape::Plate, Shape::Disc] {
            for (i, tolerance) in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6].into_iter().enumerate() {
                // Gravity only where the target is high enough to be met by what falls.
                let gravity = if target == Shape::Plate { 5.0 } else { 0.0 };
                let speed = [10.0, 23.0, 300.0][i % 3];
                let scheme = shot(bullet, target, speed, gravity).scheme(
                    "newton",
                    0.5,
                    ActivationRule::MoreauJean,
                    false,
                );
                let settings = AdaptiveSettings::new(tolerance, 0.5);
                let mut driver = Adaptive::new(scheme, settings).expect("a valid setup");
                let what = format!("{bullet:?} at {speed} m/s on {target:?}, ε = {tolerance}");
                let _end: ControlFlow<()> = driver
                    .advance_to(0.5, |_, _, _| ControlFlow::Continue(()))
                    .unwrap_or_else(|error| panic!("{what}: {error}"));
                let state = driver.scheme().state();
                close(&what, state.v[0], -0.5 * speed, SOLVED * speed);
                let meets = -bullet.half() - target.half();
                let exact = meets - 0.5 * speed * (0.5 - (meets + 1.0) / speed);
                // ε is a share of the scene's length, here the range of the bullet.
                close(&what, state.q[0], exact, tolerance * 0.5 * speed);
            }
        }
    }
}

#[test]
fn the_event_driven_motion_meets_the_target() {
    for bullet in [Shape::Disc, Shape::Point, Shape::Square] {
        for target in [Shape::Plate, Shape::Disc, Shape::Square] {
            for speed in [10.0, 1e3] {
                // A free target of great mass: the event-driven motion has no joints.
                let mut bodies = Bodies::new();
                let mass = 1e9;
                bodies.add(bullet, 0.01, [-1.0, 0.0], [speed, 0.0, 0.0]);
                bodies.add(target, mass, [0.0; 2], [0.0; 3]);
                let system = bodies.builder.build().expect("bodies");
                let found = motion::motion::<2>(system, law("newton", 0.5, 0.0), (&bodies.q, &bodies.v), 0.5);
                let (_, v) = motion::state(&found, 0.5);
                let what = format!("{bullet:?} at {speed} m/s on {target:?}");
                // The target moves by m/M = 1e-11 of the speed.
                close(&what, v[0], -0.5 * speed, SOLVED * speed);
            }
        }
    }
}
