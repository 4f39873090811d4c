//! Joints of bodies in space: what they keep, the closed forms of pendulums, tops and doors, and what drives them.

#[path = "mechanics/stream.rs"]
mod stream;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use nonsmooth::laws::{ContactLaw, Fremond, NewtonCoulomb};
use nonsmooth::scheme::{Settings, ThetaScheme};
use nonsmooth::solver::{self, Stopping};
use nonsmooth::system::{Contacts, Dynamics, SpatialBodies, SpatialBody};
use stream::Stream;

fn laws(name: &str, e: f64, friction: f64, count: usize) -> Vec<Box<dyn ContactLaw<f64, 3>>> {
    let law = || -> Box<dyn ContactLaw<f64, 3>> {
        match name {
            "newton" => Box::new(NewtonCoulomb::new(e, friction).expect("in range")),
            _ => Box::new(Fremond::new(e, friction).expect("in range")),
        }
    };
    (0..count).map(|_| law()).collect()
}

fn scheme(
    system: SpatialBodies<f64>,
    laws: Vec<Box<dyn ContactLaw<f64, 3>>>,
    (theta, step): (f64, f64),
    (q, v): (Vec<f64>, Vec<f64>),
) -> ThetaScheme<f64, 3> {
    let solver = solver::build("hybrid", Stopping::to(1e-12)).expect("registered");
    ThetaScheme::new(Box::new(system), laws, solver, Settings::new(theta, step), 0.0, q, v).expect("valid")
}

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
    for case in 0..40 {
        let Chain { system, bodies, q, v } = chain(&mut random, 2 + case % 5);
        let (theta, step) = ([0.5, 0.5, 0.75][case % 3], [1e-3, 1e-2, 3e-2][case / 3 % 3]);
        let before = momenta(&bodies, &q, &v);
        let closed = held(&system, &q);
        let mut scheme = run(system, ("newton", 0.0), (theta, step), (q, v));
        let mut last = None;
        let mut worst = [0.0_f64; 4];
        for _ in 0..400 {
            scheme.step().unwrap_or_else(|error| panic!("case {case}, h = {step}: {error}"));
            let (state, made) = (scheme.state(), scheme.last_step());
            let total = made.energies.total();
            // The first step brings the velocities that the joints allow.
            if let (Some(last), true) = (last, theta == 0.5) {
                worst[0] = worst[0].max(f64::abs(total - last) / total);
            }
            last = last.or(Some(total));
            worst[1] = worst[1].max(made.balance.imbalance.abs() / total);
            let now = momenta(&bodies, &state.q, &state.v);
            let size = before[0].norm() + before[1].norm();
            worst[2] = worst[2].max((now[0] - before[0]).norm() / size);
            if theta == 0.5 {
                worst[2] = worst[2].max((now[1] - before[1]).norm() / size);
            }
            let open = held(scheme.system(), &state.q);
            open.iter().zip(&closed).for_each(|(x, y)| worst[3] = worst[3].max((x - y).abs()));
        }
        println!("{case} h {step} passes {} {worst:?}", scheme.passes());
    }
}
