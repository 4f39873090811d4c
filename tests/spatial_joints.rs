//! Joints of bodies in space: what they keep, the closed forms of pendulums, tops and doors, and what drives them.

#[path = "mechanics/in_space.rs"]
mod in_space;
#[path = "mechanics/stream.rs"]
mod stream;

use in_space::{laws, scheme};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use nonsmooth::geometry::{Pose, Shape};
use nonsmooth::scheme::ThetaScheme;
use nonsmooth::system::{Contacts, Dynamics, Signal, SpatialBodies, SpatialBody, SpatialMotion};
use stream::Stream;

fn run(
    system: SpatialBodies<f64>,
    (law, e): (&str, f64),
    numbers: (f64, f64),
    state: (Vec<f64>, Vec<f64>),
) -> ThetaScheme<f64, 3> {
    let interfaces = Contacts::<f64, 3>::interfaces(&system);
    scheme(system, laws(law, e, 0.3, interfaces), numbers, state)
}

fn random_vector(random: &mut Stream, size: f64) -> [f64; 3] {
    [0; 3].map(|_| random.uniform(-size, size))
}

/// The moments of a homogeneous box of half sides a, b, c.
fn brick(mass: f64, [a, b, c]: [f64; 3]) -> SpatialBody<f64> {
    let moments = [b * b + c * c, a * a + c * c, a * a + b * b].map(|x| mass * x / 3.0);
    SpatialBody { mass, moments }
}

fn place(at: [f64; 3], turn: [f64; 4]) -> Vec<f64> {
    at.into_iter().chain(turn).collect()
}

/// Momentum (kg m/s) and angular momentum about the origin (kg m²/s).
fn momenta(bodies: &[SpatialBody<f64>], q: &[f64], v: &[f64]) -> [Vector3<f64>; 2] {
    let mut sum = [Vector3::zeros(); 2];
    for (i, body) in bodies.iter().enumerate() {
        let (q, v) = (&q[7 * i..], &v[6 * i..]);
        let turn = UnitQuaternion::new_unchecked(Quaternion::new(q[3], q[4], q[5], q[6]));
        let p = Vector3::new(v[0], v[1], v[2]) * body.mass;
        let spin = Vector3::new(v[3], v[4], v[5]).component_mul(&Vector3::from(body.moments));
        sum[0] += p;
        sum[1] += Vector3::new(q[0], q[1], q[2]).cross(&p) + turn * spin;
    }
    sum
}

struct Chain {
    system: SpatialBodies<f64>,
    bodies: Vec<SpatialBody<f64>>,
    q: Vec<f64>,
    v: Vec<f64>,
}

/// A chain of bodies in joints of every kind, with springs where it slides.
fn chain(random: &mut Stream, count: usize) -> Chain {
    let mut builder = SpatialBodies::builder();
    let (mut q, mut ids, mut bodies) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..count {
        let body = brick(random.uniform(0.5, 2.0), [0; 3].map(|_| random.uniform(0.1, 0.5)));
        bodies.push(body);
        ids.push(builder.body(&format!("b{i}"), body).expect("a body"));
        let turn = UnitQuaternion::new(Vector3::from(random_vector(random, 1.5)));
        let at = [i as f64, random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2)];
        q.extend(place(at, [turn.w, turn.i, turn.j, turn.k]));
    }
    for i in 1..count {
        let bodies = (ids[i], Some(ids[i - 1]));
        let point = [i as f64 - 0.5, random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2)];
        let axis = random_vector(random, 1.0);
        let label = format!("j{i}");
        match random.below(5) {
            0 => builder.ball(&label, bodies, point, &q).expect("a joint"),
            1 => {
                let free = builder.hinge(&label, bodies, (point, axis), &q).expect("a joint");
                builder.spring(&format!("s{i}"), free, (2.0, 0.0), 0.3).expect("a spring");
            }
            2 => builder.weld(&label, bodies, &q).expect("a joint"),
            3 => {
                let free = builder.slider(&label, bodies, (point, axis), &q).expect("a joint");
                builder.spring(&format!("s{i}"), free, (50.0, 0.0), 0.0).expect("a spring");
            }
            _ => {
                let other = [point[0] + 0.3, point[1] + 0.1, point[2]];
                builder.rod(&label, bodies, [point, other], &q).expect("a joint");
            }
        }
    }
    let system = builder.build().expect("a scene");
    let v = (0..6 * count).map(|_| random.uniform(-1.0, 1.0)).collect();
    Chain { system, bodies, q, v }
}

fn held(system: &dyn Dynamics<f64>, q: &[f64]) -> Vec<f64> {
    let joints = system.joints().expect("joints");
    let mut open = vec![0.0; joints.rows()];
    joints.residual(q, &mut open);
    (0..open.len()).filter(|&row| joints.label(row).starts_with('j')).map(|row| open[row]).collect()
}

#[test]
fn free_chains_keep_energy_momentum_and_their_joints() {
    let mut random = Stream(7);
    for case in 0..60 {
        let Chain { system, bodies, q, v } = chain(&mut random, 2 + case % 5);
        let (theta, step) = ([0.5, 0.5, 0.75][case % 3], [1e-3, 1e-2, 3e-2][case / 3 % 3]);
        let before = momenta(&bodies, &q, &v);
        let size = before[0].norm() + before[1].norm();
        let closed = held(&system, &q);
        let mut scheme = run(system, ("newton", 0.0), (theta, step), (q, v));
        let mut first = None;
        for k in 0..400 {
            scheme.step().unwrap_or_else(|error| panic!("case {case}, h = {step}: {error}"));
            let (state, made) = (scheme.state(), scheme.last_step());
            let total = made.energies.total();
            let first = *first.get_or_insert(total);
            // The passes leave 64 ε of the equations of motion, and the errors of the steps add up.
            let rounding = 64.0 * f64::EPSILON * f64::from(k + 1);
            assert!(made.balance.imbalance.abs() <= 1e-12 * total, "case {case}: {:?}", made.balance);
            let [linear, angular] = momenta(&bodies, &state.q, &state.v);
            assert!((linear - before[0]).norm() <= rounding * size, "case {case}: momentum");
            if theta == 0.5 {
                // The first step brings the velocities that the joints allow.
                assert!((total - first).abs() <= 10.0 * rounding * first, "case {case}: energy");
                assert!((angular - before[1]).norm() <= 10.0 * rounding * size, "case {case}: momentum");
            } else {
                assert!(total <= first * (1.0 + rounding), "case {case}: energy grows");
            }
            for (open, closed) in held(scheme.system(), &state.q).iter().zip(&closed) {
                assert!((open - closed).abs() <= 1e-13 * 5.0, "case {case}: a joint is open");
            }
        }
    }
}

/// A brick on a hinge through the origin along y, its centre at 0.6 m, against gravity along −z.
fn pendulum(limits: Option<[f64; 2]>) -> (SpatialBodies<f64>, Vec<f64>, SpatialBody<f64>) {
    let body = brick(2.0, [0.1, 0.05, 0.3]);
    let mut builder = SpatialBodies::builder();
    let id = builder.body("bob", body).expect("a body");
    let q = place([0.0, 0.0, -0.6], [1.0, 0.0, 0.0, 0.0]);
    let free = builder.hinge("pivot", (id, None), ([0.0; 3], [0.0, 1.0, 0.0]), &q).expect("a joint");
    if let Some(limits) = limits {
        builder.limit("pivot", free, limits).expect("limits");
    } else {
        builder.gravity([0.0, 0.0, -9.81]).expect("finite");
    }
    (builder.build().expect("a scene"), q, body)
}

/// Angle of a body that has turned about y.
fn about_y(q: &[f64]) -> f64 {
    2.0 * q[5].atan2(q[3])
}

#[test]
fn a_compound_pendulum_swings_as_its_equation_says_at_second_order() {
    let (start, end) = (2.5, 1.2_f64);
    let reach = |step: f64| {
        let (system, q, body) = pendulum(None);
        let inertia = body.moments[1] + body.mass * 0.36;
        let v = [-0.6 * start, 0.0, 0.0, 0.0, start, 0.0].to_vec();
        let mut scheme = run(system, ("newton", 0.0), (0.5, step), (q, v));
        let steps = (end / step).round() as usize;
        (0..steps).for_each(|_| assert!(scheme.step().is_ok()));
        // φ'' = −(m g ℓ/I) sin φ, by small Runge–Kutta steps.
        let rate = |(angle, speed): (f64, f64)| (speed, -body.mass * 9.81 * 0.6 / inertia * angle.sin());
        let add = |(a, b): (f64, f64), (c, d): (f64, f64), t: f64| (a + t * c, b + t * d);
        let (mut x, t) = ((0.0, start), 1e-5);
        for _ in 0..(end / t).round() as usize {
            let one = rate(x);
            let two = rate(add(x, one, t / 2.0));
            let three = rate(add(x, two, t / 2.0));
            let four = rate(add(x, three, t));
            let sum = add(add(one, two, 2.0), add(four, three, 2.0), 1.0);
            x = add(x, sum, t / 6.0);
        }
        (about_y(&scheme.state().q) - x.0).abs()
    };
    let (coarse, fine) = (reach(8e-3), reach(4e-3));
    assert!(fine < 2e-4 && (3.8..4.2).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
}

/// A symmetric top on a point precesses steadily at the rate Ω with J₁ cos α Ω² − J₃ ω₃ Ω + m g ℓ = 0, its moments those
/// about the point.
#[test]
fn a_heavy_top_precesses_at_the_steady_rate() {
    let (mass, arm, tilt, precession) = (1.0, 0.2, 0.5_f64, 2.0);
    let (own, axial) = (0.01, 0.005);
    let about_point = own + mass * arm * arm;
    let spin =
        (about_point * tilt.cos() * precession * precession + mass * 9.81 * arm) / (axial * precession);
    let drift = |step: f64| {
        let mut builder = SpatialBodies::builder();
        let body = SpatialBody { mass, moments: [own, own, axial] };
        let id = builder.body("top", body).expect("a body");
        let turn = UnitQuaternion::new(Vector3::y() * tilt);
        let at = turn * Vector3::new(0.0, 0.0, arm);
        let q = place(at.into(), [turn.w, turn.i, turn.j, turn.k]);
        builder.ball("tip", (id, None), [0.0; 3], &q).expect("a joint");
        builder.gravity([0.0, 0.0, -9.81]).expect("finite");
        // ω = Ω e_z + (ω₃ − Ω cos α) of the axis.
        let omega = Vector3::z() * precession;
        let velocity = omega.cross(&at);
        let mut own = turn.inverse() * omega;
        own.z = spin;
        let v = velocity.iter().chain(own.iter()).copied().collect();
        let mut scheme = run(builder.build().expect("a scene"), ("newton", 0.0), (0.5, step), (q, v));
        let steps = (0.5 / step).round() as usize;
        (0..steps).for_each(|_| assert!(scheme.step().is_ok()));
        let q = &scheme.state().q;
        let height = (q[2] / arm - tilt.cos()).abs();
        let angle = (q[1].atan2(q[0]) - 0.5 * precession).abs();
        (height, angle)
    };
    let (coarse, fine) = (drift(1e-3), drift(5e-4));
    assert!(fine.0 < 1e-3 && fine.1 < 1e-2, "{fine:?}");
    assert!((3.5..4.5).contains(&(coarse.1 / fine.1)), "{coarse:?} {fine:?}");
}

#[test]
fn a_door_comes_back_from_its_stop_with_the_restitution_of_the_law() {
    for law in ["newton", "fremond"] {
        let e = 0.5;
        let (system, q, _) = pendulum(Some([-2.0, 0.5]));
        let speed = 3.0;
        let v = [-0.6 * speed, 0.0, 0.0, 0.0, speed, 0.0].to_vec();
        let theta = 1.0 / (1.0 + e);
        let mut scheme = run(system, (law, e), (theta, 1e-3), (q, v));
        let mut before = speed;
        for _ in 0..400 {
            let now = scheme.state().v[4];
            before = if now > 0.0 { now } else { before };
            scheme.step().expect("a step");
            // θ > ½ takes energy from a centre on a circle.
            let after = scheme.state().v[4];
            let impact = now > 0.0 && after < 0.0;
            assert!(!impact || (after + e * before).abs() <= 1e-9 * speed, "{law}: {before} {after}");
            assert!(about_y(&scheme.state().q) <= 0.5 + speed * 1e-3, "{law}");
            assert!(scheme.last_step().balance.imbalance.abs() <= 1e-13 * 9.0, "{law}");
        }
        assert!(scheme.state().v[4] < -0.99 * e * speed, "{law}");
    }
}

/// A parallelogram of hinges in space: twenty rows hold one freedom of eighteen, three of them twice.
#[test]
fn a_four_bar_linkage_turns_though_its_hinges_hold_the_plane_three_times() {
    let mut builder = SpatialBodies::builder();
    let points = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [2.0, 0.0, 0.0]];
    let middle = |i: usize| [0, 1, 2].map(|k| 0.5 * (points[i][k] + points[i + 1][k]));
    let bodies: Vec<_> =
        (0..3).map(|i| brick(1.0, if i == 1 { [1.0, 0.05, 0.05] } else { [0.05, 0.05, 0.5] })).collect();
    let ids: Vec<_> = bodies.iter().map(|&body| builder.body("bar", body).expect("a body")).collect();
    let q: Vec<f64> = (0..3).flat_map(|i| place(middle(i), [1.0, 0.0, 0.0, 0.0])).collect();
    let axis = [0.0, 1.0, 0.0];
    for (label, bodies, point) in [
        ("a", (ids[0], None), points[0]),
        ("b", (ids[1], Some(ids[0])), points[1]),
        ("c", (ids[2], Some(ids[1])), points[2]),
        ("d", (ids[2], None), points[3]),
    ] {
        builder.hinge(label, bodies, (point, axis), &q).expect("a joint");
    }
    builder.gravity([0.0, 0.0, -9.81]).expect("finite");
    let omega = 4.0;
    let v = [0.5 * omega, 0.0, 0.0, 0.0, omega, 0.0, omega, 0.0, 0.0, 0.0, 0.0, 0.0].to_vec();
    let v = [v, vec![0.5 * omega, 0.0, 0.0, 0.0, omega, 0.0]].concat();
    let mut scheme = run(builder.build().expect("a scene"), ("newton", 0.0), (0.5, 2e-3), (q, v));
    let start = scheme.last_step().energies.total();
    let mut largest = 0.0_f64;
    for k in 0..2000 {
        scheme.step().unwrap_or_else(|error| panic!("step {k}: {error}"));
        let total = scheme.last_step().energies.total();
        assert!((total - start).abs() <= 1e-9 * start.abs(), "step {k}: {total} {start}");
        largest = largest.max(about_y(&scheme.state().q).abs());
    }
    assert!(largest > 1.0, "it moves: {largest}");
}

#[test]
fn a_motor_turns_as_told_and_its_work_is_in_the_balance() {
    let mut builder = SpatialBodies::builder();
    let id = builder.body("rotor", brick(2.0, [0.3, 0.1, 0.2])).expect("a body");
    let q = place([0.1, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]);
    let (at, axis) = ([0.0; 3], [0.0, 0.0, 1.0]);
    let free = builder.hinge("axle", (id, None), (at, axis), &q).expect("a joint");
    builder.drive("motor", free, (3.0, None), Signal::Constant).expect("a motor");
    let mut scheme = run(builder.build().expect("a scene"), ("newton", 0.0), (0.5, 1e-3), (q, vec![0.0; 6]));
    let (mut work, mut largest) = (0.0, 0.0);
    for _ in 0..1000 {
        let made = scheme.step().expect("a step");
        work += made.balance.external_work;
        largest = f64::max(largest, made.energies.total());
        assert!(made.balance.imbalance.abs() <= 1e-12 * largest, "{:?}", made.balance);
    }
    let q = &scheme.state().q;
    let angle = 2.0 * q[6].atan2(q[3]);
    // It has its speed from the end of the first step on, which starts at rest.
    // Within (ω h)³ of what the first step turns.
    assert!((angle - 3.0 * (1.0 - 0.5e-3)).abs() <= 2.7e-8, "{angle}");
    assert!((scheme.state().v[5] - 3.0).abs() <= 1e-5, "{:?}", scheme.state().v);
    let energy = scheme.last_step().energies.total();
    assert!((work - energy).abs() <= 1e-11 * largest, "{work} {energy}");
}

/// A box on a belt that slips reaches its speed after v/(μ g), and rides with it.
#[test]
fn a_box_on_a_belt_is_taken_along_to_the_speed_of_the_belt() {
    for law in ["newton", "fremond"] {
        let mut builder = SpatialBodies::builder();
        let (own, belt) = (builder.group(), builder.group());
        let block = brick(1.0, [0.1, 0.1, 0.1]);
        let id = builder.body("box", block).expect("a body");
        builder.gravity([0.0, 0.0, -9.81]).expect("finite");
        let mover = builder.body("belt", brick(10.0, [2.0, 1.0, 0.1])).expect("a body");
        let cube = |half: [f64; 3]| Shape::cuboid(half.into()).expect("a box");
        builder.shape("box", id, cube([0.1; 3]), Pose::identity(), own).expect("a shape");
        builder.shape("belt", mover, cube([2.0, 1.0, 0.1]), Pose::identity(), belt).expect("a shape");
        builder.interface(own, belt).expect("groups");
        let q =
            [place([0.0, 0.0, 0.2], [1.0, 0.0, 0.0, 0.0]), place([0.0; 3], [1.0, 0.0, 0.0, 0.0])].concat();
        let linear = Signal::Linear { rate: 1.0 };
        let displacements = vec![([0.5, 0.0, 0.0], linear)];
        let motion = SpatialMotion { displacements, axis: [0.0, 0.0, 1.0], angles: Vec::new() };
        builder.told(mover, &motion, &q).expect("a motion");
        let v = [vec![0.0; 6], vec![0.5, 0.0, 0.0, 0.0, 0.0, 0.0]].concat();
        let mut scheme = run(builder.build().expect("a scene"), (law, 0.0), (1.0, 1e-3), (q, v));
        let end = 0.5 / (0.3 * 9.81);
        for k in 0..400 {
            scheme.step().expect("a step");
            let made = scheme.last_step();
            assert!(
                made.balance.imbalance.abs() <= 1e-12 * made.energies.total(),
                "{law}, step {k}: {:?}",
                made.balance
            );
            let t = 1e-3 * f64::from(k + 1);
            let v = if t < end { 0.3 * 9.81 * t } else { 0.5 };
            assert!((scheme.state().v[0] - v).abs() <= 1e-3 * 9.81, "{law}, {t}: {}", scheme.state().v[0]);
        }
        assert!((scheme.state().v[0] - 0.5).abs() <= 1e-10, "{law}: {}", scheme.state().v[0]);
        assert!((scheme.state().q[2] - 0.2).abs() <= 1e-12, "{law}");
    }
}
