//! Rigid bodies in space: what a free body keeps, what impacts and friction do to momentum and energy, and closed forms of
//! bodies that roll, slide, spin, stand and topple.

#[path = "mechanics/in_space.rs"]
mod in_space;
#[path = "mechanics/stream.rs"]
mod stream;

use in_space::{laws, scheme};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use nonsmooth::geometry::{Pose, Shape};
use nonsmooth::scheme::{Settings, ThetaScheme};
use nonsmooth::solver::{self, Stopping};
use nonsmooth::system::{BodyId, Dynamics, SpatialBodies, SpatialBodiesBuilder, SpatialBody};
use stream::Stream;

const GRAVITY: f64 = 9.81;
const UPRIGHT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

/// What the momentum of a scene is asked of.
fn bodies_of(build: impl FnOnce(&mut SpatialBodiesBuilder<f64>)) -> SpatialBodies<f64> {
    let mut builder = SpatialBodies::builder();
    build(&mut builder);
    builder.build().expect("a scene")
}

/// θ that a law with restitution e claims for itself.
fn claimed(law: &str, e: f64) -> f64 {
    if law == "newton" { 1.0 / (1.0 + e) } else { 0.5 }
}

/// q of bodies at these places, turned so.
fn configuration(places: &[([f64; 3], [f64; 4])]) -> Vec<f64> {
    places.iter().flat_map(|(x, turn)| x.iter().chain(turn).copied()).collect()
}

fn turned(axis: [f64; 3], angle: f64) -> [f64; 4] {
    let turn = UnitQuaternion::new(Vector3::from(axis).normalize() * angle);
    [turn.w, turn.i, turn.j, turn.k]
}

/// Mass and principal moments of a homogeneous shape.
fn solid(shape: &Shape<f64>, density: f64) -> SpatialBody<f64> {
    let of = shape.mass_properties(density).expect("a solid");
    SpatialBody { mass: of.mass, moments: of.inertia.diagonal().into() }
}

fn cuboid(half: [f64; 3]) -> Shape<f64> {
    Shape::cuboid(half.into()).expect("a box")
}

/// A body of one shape, in the group of its own and against a floor z = 0 under its weight.
fn on_a_floor(shape: &Shape<f64>, slope: f64) -> SpatialBodies<f64> {
    bodies_of(|builder| {
        let body = builder.body("body", solid(shape, 1000.0)).expect("a body");
        let (own, floor) = (builder.group(), builder.group());
        builder.shape("body", body, shape.clone(), Pose::identity(), own).expect("a shape");
        builder.half_space("floor", [0.0; 3], [0.0, 0.0, 1.0], floor).expect("a floor");
        builder.interface(own, floor).expect("both groups");
        builder.gravity([GRAVITY * slope.sin(), 0.0, -GRAVITY * slope.cos()]).expect("finite");
    })
}

fn kinetic(system: &SpatialBodies<f64>, v: &[f64]) -> f64 {
    let mut momentum = v.to_vec();
    system.mass().multiply(v, &mut momentum);
    0.5 * v.iter().zip(&momentum).map(|(a, b)| a * b).sum::<f64>()
}

fn free_top() -> SpatialBodies<f64> {
    bodies_of(|builder| {
        builder.body("top", SpatialBody { mass: 1.0, moments: [1.0, 2.0, 2.5] }).expect("a body");
    })
}

#[test]
fn a_free_body_keeps_energy_and_angular_momentum_for_any_theta_and_step() {
    for theta in [0.0, 0.5, 0.8, 1.0] {
        for step in [1e-3, 1e-2, 0.3] {
            let start = (configuration(&[([0.0; 3], UPRIGHT)]), vec![0.3, 0.0, 0.0, 0.7, 1.0, -0.4]);
            let system = free_top();
            let (energy, momentum) =
                (kinetic(&system, &start.1), system.angular_momentum(&start.0, &start.1));
            let mut scheme = scheme(free_top(), Vec::new(), (theta, step), start);
            for _ in 0..20_000 {
                scheme.step().expect("flies");
            }
            let state = scheme.state();
            let change = kinetic(&system, &state.v) - energy;
            assert!(change.abs() <= 1e-12 * energy, "θ = {theta}, h = {step}: {change:e} J of {energy} J");
            let now = system.angular_momentum(&state.q, &state.v);
            let size = Vector3::from(momentum).norm();
            let change = (Vector3::from(now) - Vector3::from(momentum)).norm();
            assert!(change <= 1e-12 * size, "θ = {theta}, h = {step}: {change:e} of {size} kg m²/s");
            // The unit quaternion stays one.
            let q = &state.q;
            let length = Quaternion::new(q[3], q[4], q[5], q[6]).norm();
            assert!((length - 1.0).abs() <= 1e-15);
        }
    }
}

/// K(k) by the arithmetic-geometric mean.
fn elliptic(modulus_squared: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - modulus_squared).sqrt());
    for _ in 0..60 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    std::f64::consts::FRAC_PI_2 / a
}

#[test]
fn the_flip_period_of_a_free_body_is_that_of_euler_with_order_two() {
    // Near the middle axis: the component of ω along it changes its sign twice in a period.
    let moments = [1.0_f64, 2.0, 2.5];
    let spin = [0.2, 2.0, 0.1];
    let energy = moments.iter().zip(&spin).map(|(j, w)| 0.5 * j * w * w).sum::<f64>();
    let square = moments.iter().zip(&spin).map(|(j, w)| (j * w) * (j * w)).sum::<f64>();
    let [i1, i2, i3] = moments;
    // The axis of the separatrix side: L² against 2 E I₂.
    let (one, three) = if square > 2.0 * energy * i2 { (i1, i3) } else { (i3, i1) };
    let (a, b) = ((three - i2) * (square - 2.0 * energy * one), (i2 - one) * (2.0 * energy * three - square));
    let period = 4.0 * elliptic(b / a) * (i1 * i2 * i3 / a).sqrt();
    let measured = |step: f64| {
        let start = (configuration(&[([0.0; 3], UPRIGHT)]), vec![0.0, 0.0, 0.0, spin[0], spin[1], spin[2]]);
        let mut scheme = scheme(free_top(), Vec::new(), (0.5, step), start);
        let mut crossings: Vec<f64> = Vec::new();
        let mut before = (0.0, spin[1]);
        while crossings.len() < 3 {
            scheme.step().expect("flies");
            let now = (scheme.state().time, scheme.state().v[4]);
            if before.1 * now.1 < 0.0 {
                crossings.push(before.0 + (now.0 - before.0) * before.1 / (before.1 - now.1));
            }
            before = now;
        }
        crossings[2] - crossings[0]
    };
    let errors = [4e-3, 2e-3].map(|step| (measured(step) - period).abs() / period);
    assert!(errors[0] <= 2e-4, "{errors:?} of {period} s");
    let order = (errors[0] / errors[1]).log2();
    assert!((1.8..2.3).contains(&order), "order {order}, {errors:?}");
}

/// Two boxes that fly at each other, edges and corners first.
fn two_boxes() -> (SpatialBodies<f64>, Vec<f64>) {
    let shapes = [cuboid([0.5, 0.3, 0.2]), cuboid([0.2, 0.4, 0.3])];
    let system = bodies_of(|builder| {
        let group = builder.group();
        for (name, shape) in ["one", "other"].into_iter().zip(&shapes) {
            let body = builder.body(name, solid(shape, 1000.0)).expect("a body");
            builder.shape(name, body, shape.clone(), Pose::identity(), group).expect("a shape");
        }
        builder.interface(group, group).expect("a group");
    });
    let places = [
        ([-0.8, 0.05, 0.02], turned([1.0, 2.0, 3.0], 0.7)),
        ([0.8, -0.04, 0.05], turned([-2.0, 1.0, 0.5], 1.1)),
    ];
    (system, configuration(&places))
}

#[test]
fn frictional_impacts_of_spinning_boxes_keep_momentum_exactly_and_the_balance_closes() {
    for (law, theta) in [("newton", claimed("newton", 0.2)), ("fremond", 0.5), ("fremond", 0.8)] {
        let (asking, q) = two_boxes();
        let v = vec![2.0, 0.1, 0.0, 1.0, -2.0, 0.5, -2.5, 0.0, 0.1, -0.5, 1.5, 2.0];
        let start = asking.angular_momentum(&q, &v);
        let energy = kinetic(&asking, &v);
        let (system, _) = two_boxes();
        let mut scheme = scheme(system, laws(law, 0.2, 0.3, 1), (theta, 1e-2), (q, v));
        let mut impacts = 0;
        for _ in 0..200 {
            let step = scheme.step().expect("an impact has a solution");
            impacts += usize::from(step.contacts.iter().any(|contact| contact.percussion[0] > 0.0));
            let balance = &step.balance;
            assert!(balance.imbalance.abs() <= 1e-13 * energy, "{law}: {:e} J", balance.imbalance);
            for contact in &step.contacts {
                assert!(contact.normal_work <= contact.work_bound, "{law}: {contact:?}");
                assert!(
                    law == "newton" || contact.tangential_work <= contact.work_bound,
                    "{law}: {contact:?}"
                );
            }
        }
        assert!(impacts >= 1, "{law}: they meet");
        let state = scheme.state();
        let now = asking.angular_momentum(&state.q, &state.v);
        let change = (Vector3::from(now) - Vector3::from(start)).norm();
        let size = Vector3::from(start).norm();
        assert!(change <= 1e-12 * size, "{law}, θ = {theta}: {change:e} of {size} kg m²/s");
    }
}

fn ball(radius: f64) -> Shape<f64> {
    Shape::ball(radius).expect("a ball")
}

#[test]
fn a_ball_slides_and_then_rolls_with_five_sevenths_of_its_speed() {
    let (radius, friction, speed) = (0.1, 0.2, 3.0);
    let stop = 2.0 * speed / (7.0 * friction * GRAVITY);
    let way = 12.0 * speed * speed / (49.0 * friction * GRAVITY);
    for law in ["newton", "fremond"] {
        let start = (configuration(&[([0.0, 0.0, radius], UPRIGHT)]), vec![speed, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let mut scheme = scheme(
            on_a_floor(&ball(radius), 0.0),
            laws(law, 0.0, friction, 1),
            (claimed(law, 0.0), 1e-3),
            start,
        );
        while scheme.state().time < 1.2 {
            scheme.step().expect("slides");
        }
        let state = scheme.state();
        let (velocity, spin) = (state.v[0], state.v[4]);
        assert!((velocity - 5.0 / 7.0 * speed).abs() <= 1e-10 * speed, "{law}: {velocity} m/s");
        // The ball may have turned: its spin is about the fixed y axis.
        let turn =
            UnitQuaternion::new_unchecked(Quaternion::new(state.q[3], state.q[4], state.q[5], state.q[6]));
        let about = turn * Vector3::new(state.v[3], spin, state.v[5]);
        assert!((about.y * radius - velocity).abs() <= 1e-10 * speed, "{law}: {about:?}");
        let place = state.q[0] - 5.0 / 7.0 * speed * (state.time - stop);
        // First order where sliding ends: a step's part of the change of acceleration.
        let accuracy = friction * GRAVITY * 1e-3 * stop;
        assert!((place - way).abs() <= accuracy, "{law}: {place} m, {way} m");
    }
}

#[test]
fn a_ball_bounces_off_obliquely_as_its_law_says() {
    let (radius, friction, e) = (0.1, 0.5, 0.6);
    let normal = -4.0;
    let bounce = |law: &str, e: f64, tangent: f64| {
        let start = (
            configuration(&[([0.0, 0.0, radius + 1e-3], UPRIGHT)]),
            vec![tangent, 0.0, normal, 0.0, 0.0, 0.0],
        );
        let mut scheme =
            scheme(on_a_floor(&ball(radius), 0.0), laws(law, e, friction, 1), (claimed(law, e), 1e-3), start);
        loop {
            let step = scheme.step().expect("bounces");
            if let Some(contact) = step.contacts.first() {
                return (contact.before, contact.after);
            }
        }
    };
    for (law, e, kept) in [("newton", e, 5.0 / 7.0), ("fremond", 1.0, 3.0 / 7.0)] {
        let (before, after) = bounce(law, e, 2.0);
        let (fast, slow) = (before.fixed_rows::<2>(1).norm(), after.fixed_rows::<2>(1));
        // The point of contact sticks under Newton's law, and turns back under Frémond's; the centre keeps its part.
        let along = slow.dot(&before.fixed_rows::<2>(1)) / fast;
        let centre = fast + (along - fast) * 2.0 / 7.0;
        assert!((centre - kept * fast).abs() <= 1e-12 * fast, "{law}: {centre} of {fast}");
    }
    // Beyond the limit it slides: the centre loses μ (1+e) |v_N|.
    let (before, after) = bounce("newton", e, 20.0);
    let lost = before.fixed_rows::<2>(1).norm() - after.fixed_rows::<2>(1).norm();
    // The weight of the step presses as well.
    let expected = 3.5 * friction * ((1.0 + e) * before[0].abs() + GRAVITY * 1e-3);
    assert!((lost - expected).abs() <= 1e-11 * expected, "{lost} m/s, {expected} m/s");
}

#[test]
fn a_block_on_four_points_slides_beyond_the_friction_angle_only() {
    let friction: f64 = 0.4;
    for law in ["newton", "fremond"] {
        for (slope, slides) in [(friction.atan() - 1e-6, false), (friction.atan() + 1e-3, true)] {
            let start = (configuration(&[([0.0, 0.0, 0.1], turned([0.0, 0.0, 1.0], 0.3))]), vec![0.0; 6]);
            let mut scheme = scheme(
                on_a_floor(&cuboid([0.3, 0.2, 0.1]), slope),
                laws(law, 0.0, friction, 1),
                (claimed(law, 0.0), 1e-3),
                start,
            );
            for _ in 0..1000 {
                assert!(scheme.step().expect("stands").contacts.len() == 4);
            }
            let state = scheme.state();
            let expected = if slides { GRAVITY * (slope.sin() - friction * slope.cos()) } else { 0.0 };
            assert!((state.v[0] - expected).abs() <= 1e-9, "{law}: {} m/s, expected {expected}", state.v[0]);
            assert!((state.q[2] - 0.1).abs() <= 1e-12, "{law}: {:e} m", state.q[2] - 0.1);
        }
    }
}

/// A block under its weight and a torque about the vertical.
fn twisted(half: [f64; 3], torque: f64) -> SpatialBodies<f64> {
    let shape = cuboid(half);
    bodies_of(|builder| {
        let body = builder.body("body", solid(&shape, 1000.0)).expect("a body");
        let (own, floor) = (builder.group(), builder.group());
        builder.shape("body", body, shape.clone(), Pose::identity(), own).expect("a shape");
        builder.half_space("floor", [0.0; 3], [0.0, 0.0, 1.0], floor).expect("a floor");
        builder.interface(own, floor).expect("both groups");
        builder.gravity([0.0, 0.0, -GRAVITY]).expect("finite");
        builder.force(body, [0.0; 3], [0.0, 0.0, torque]).expect("finite");
    })
}

#[test]
fn a_block_on_four_points_turns_beyond_the_twist_that_friction_holds() {
    let (half, friction) = ([0.3, 0.2, 0.1], 0.4);
    let mass = 8000.0 * half[0] * half[1] * half[2];
    let most = friction * mass * GRAVITY * f64::hypot(half[0], half[1]);
    for (share, turns) in [(0.999, false), (1.01, true)] {
        let start = (configuration(&[([0.0, 0.0, 0.1], UPRIGHT)]), vec![0.0; 6]);
        let mut scheme =
            scheme(twisted(half, share * most), laws("newton", 0.0, friction, 1), (1.0, 1e-3), start);
        for _ in 0..200 {
            scheme.step().expect("stands or turns");
        }
        let spin = scheme.state().v[5];
        assert!((spin > 1e-3) == turns, "{share}: {spin} rad/s");
        assert!(turns || spin.abs() <= 1e-9, "{share}: {spin} rad/s");
    }
}

fn cubes(n: [usize; 3]) -> (SpatialBodies<f64>, Vec<f64>, usize) {
    let shape = cuboid([0.05; 3]);
    let mut places = Vec::new();
    let mut interfaces = 0;
    let system = bodies_of(|builder| {
        let (own, floor) = (builder.group(), builder.group());
        for level in 0..n[2] {
            for i in 0..n[0] {
                for j in 0..n[1] {
                    let name = format!("cube {i} {j} {level}");
                    let body = builder.body(&name, solid(&shape, 2000.0)).expect("a body");
                    builder.shape(&name, body, shape.clone(), Pose::identity(), own).expect("a shape");
                    let place = [0.15 * i as f64, 0.15 * j as f64, 0.05 + 0.1 * level as f64];
                    places.push((place, UPRIGHT));
                }
            }
        }
        builder.half_space("floor", [0.0; 3], [0.0, 0.0, 1.0], floor).expect("a floor");
        interfaces = 1 + builder
            .interface(own, own)
            .expect("a group")
            .max(builder.interface(own, floor).expect("a group"));
        builder.gravity([0.0, 0.0, -GRAVITY]).expect("finite");
    });
    (system, configuration(&places), interfaces)
}

#[test]
fn a_stack_of_ten_cubes_stands_and_its_contacts_keep_their_names() {
    for (law, e) in [("newton", 0.0), ("newton", 0.5), ("fremond", 0.0)] {
        let (system, q, interfaces) = cubes([1, 1, 10]);
        let v = vec![0.0; 60];
        let mut scheme =
            scheme(system, laws(law, e, 0.5, interfaces), (claimed(law, e), 5e-3), (q.clone(), v));
        scheme.step().expect("stands");
        let names: Vec<_> = scheme.last_step().contacts.iter().map(|contact| contact.id).collect();
        assert_eq!(names.len(), 40);
        for _ in 0..500 {
            let step = scheme.step().expect("stands");
            let now: Vec<_> = step.contacts.iter().map(|contact| contact.id).collect();
            assert_eq!(now, names, "{law}");
        }
        let moved = scheme.state().q.iter().zip(&q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(moved <= 1e-11, "{law}, e = {e}: {moved:e} m");
    }
}

#[test]
fn every_level_of_cubes_carries_the_weight_above_it() {
    for (law, theta) in [("fremond", 0.5), ("newton", 1.0)] {
        let (system, q, interfaces) = cubes([3, 3, 3]);
        let weight = 2.0 * GRAVITY;
        let bodies = q.len() / 7;
        let mut scheme =
            scheme(system, laws(law, 0.0, 0.5, interfaces), (theta, 5e-3), (q, vec![0.0; 6 * bodies]));
        for _ in 0..100 {
            scheme.step().expect("stands");
        }
        let step = scheme.last_step();
        let carried: f64 = step.contacts.iter().map(|contact| contact.percussion[0]).sum();
        // Each of nine columns carries 3 + 2 + 1 cubes.
        let expected = 9.0 * 6.0 * weight * 5e-3;
        assert!((carried - expected).abs() <= 1e-8 * expected, "θ = {theta}: {carried} N s, {expected} N s");
        let deepest = step.contacts.iter().map(|contact| contact.gap).fold(0.0, f64::min);
        assert!(deepest >= -1e-10, "θ = {theta}: {deepest:e} m");
    }
}

#[test]
fn cubes_dropped_askew_come_down_without_creating_energy() {
    let mut stream = Stream(7);
    for law in ["newton", "fremond"] {
        let (system, mut q, interfaces) = cubes([3, 3, 2]);
        for place in q.chunks_exact_mut(7) {
            let turn =
                turned([stream.uniform(-1.0, 1.0), stream.uniform(-1.0, 1.0), 0.3], stream.uniform(0.0, 0.4));
            place[2] = place[2] * 1.8 + 0.05;
            place[3..].copy_from_slice(&turn);
        }
        let bodies = q.len() / 7;
        let mut scheme = scheme(
            system,
            laws(law, 0.2, 0.5, interfaces),
            (claimed(law, 0.2), 2e-3),
            (q, vec![0.0; 6 * bodies]),
        );
        let start = scheme.last_step().energies.total();
        let mut energy = start;
        let mut deepest: f64 = 0.0;
        for k in 0..1000 {
            let step = scheme.step().unwrap_or_else(|error| panic!("{law}, step {k}: {error}"));
            let now = step.energies.total();
            assert!(law == "newton" || now <= energy + 1e-9 * start, "{law}: {energy} J to {now} J");
            assert!(step.balance.imbalance.abs() <= 1e-12 * start, "{law}: {:e} J", step.balance.imbalance);
            deepest = step.contacts.iter().map(|contact| contact.gap).fold(deepest, f64::min);
            energy = now;
        }
        assert!(energy < start, "{law}");
        assert!(deepest >= -5e-3, "{law}: {deepest} m");
    }
}

#[test]
fn a_tippe_top_keeps_the_integral_of_jellett() {
    // A ball of radius R whose centre of mass is a below its middle, spinning fast: L·(arm to the point of contact) stays.
    let (mass, radius, below, spin) = (6e-3, 15e-3, 3e-3, 180.0);
    let moments = [8e-7, 8e-7, 7e-7];
    let shape = ball(radius);
    let build = || {
        bodies_of(|builder| {
            let body = builder.body("top", SpatialBody { mass, moments }).expect("a body");
            let (own, floor) = (builder.group(), builder.group());
            let middle = Pose::new(Vector3::new(0.0, 0.0, below), UnitQuaternion::identity());
            builder.shape("top", body, shape.clone(), middle, own).expect("a shape");
            builder.half_space("floor", [0.0; 3], [0.0, 0.0, 1.0], floor).expect("a floor");
            builder.interface(own, floor).expect("both groups");
            builder.gravity([0.0, 0.0, -GRAVITY]).expect("finite");
        })
    };
    let tilt = 0.1_f64;
    let turn = turned([1.0, 0.0, 0.0], tilt);
    let q = configuration(&[([0.0, 0.0, radius - below * tilt.cos()], turn)]);
    let v = vec![0.0, 0.0, 0.0, 0.0, spin * tilt.sin(), spin * tilt.cos()];
    // L·(a e₃ − R z) about the centre of mass, with e₃ the axis of the top.
    let jellett = |q: &[f64], v: &[f64]| {
        let turn = UnitQuaternion::new_unchecked(Quaternion::new(q[3], q[4], q[5], q[6]));
        let momentum = Vector3::from(moments).component_mul(&Vector3::new(v[3], v[4], v[5]));
        (turn * momentum).dot(&(turn * Vector3::z() * below - Vector3::z() * radius))
    };
    let start = jellett(&q, &v);
    let run = |lasting: bool| {
        let settings = Settings { lasting, ..Settings::new(0.5, 1e-3) };
        let solver = solver::build("hybrid", Stopping::to(1e-12)).expect("registered");
        let (system, laws) = (Box::new(build()), laws("fremond", 0.0, 0.3, 1));
        let mut scheme =
            ThetaScheme::new(system, laws, solver, settings, 0.0, q.clone(), v.clone()).expect("valid");
        let (mut most, mut inverted) = (0.0_f64, 0.0_f64);
        for _ in 0..3000 {
            let step = scheme.step().expect("spins");
            assert!(step.balance.imbalance.abs() <= 1e-12 * step.energies.kinetic.max(1e-3));
            let state = scheme.state();
            most = most.max((jellett(&state.q, &state.v) - start).abs());
            let q = &state.q;
            let turn = UnitQuaternion::new_unchecked(Quaternion::new(q[3], q[4], q[5], q[6]));
            inverted = inverted.max((turn * Vector3::z()).z.acos());
        }
        assert!(inverted.to_degrees() > 90.0, "it turns over: {} degrees", inverted.to_degrees());
        most / start.abs()
    };
    // Percussions and flights keep it to rounding.
    let literal = run(false);
    assert!(literal <= 1e-12, "Jellett's integral drifts by {literal:e}");
    // The correction of positions turns the top by what it opens, which is of the order of h.
    let lasting = run(true);
    assert!(lasting <= 1e-3, "Jellett's integral drifts by {lasting:e}");
}

#[test]
fn impossible_bodies_and_shapes_are_refused_by_name() {
    let mut builder = SpatialBodies::<f64>::builder();
    let refused = builder.body("needle", SpatialBody { mass: 1.0, moments: [1.0, 1.0, 3.0] });
    assert!(refused.unwrap_err().to_string().contains("needle"));
    assert!(builder.body("nothing", SpatialBody { mass: 0.0, moments: [1.0; 3] }).is_err());
    let body = builder.body("body", SpatialBody { mass: 1.0, moments: [1.0; 3] }).expect("a body");
    let group = builder.group();
    assert!(builder.shape("ground", body, Shape::half_space(), Pose::identity(), group).is_err());
    assert!(builder.half_space("floor", [0.0; 3], [0.0; 3], group).is_err());
    assert!(builder.force(BodyId::GROUND, [0.0; 3], [0.0; 3]).is_err());
    assert!(builder.force(body, [f64::NAN, 0.0, 0.0], [0.0; 3]).is_err());
    assert!(SpatialBodies::<f64>::builder().build().is_err());
}
