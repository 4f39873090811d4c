//! Joints: bilateral rows of the cone problem, closed to rounding and workless.

#[path = "../examples/hard_cases/cases/double_pendulum.rs"]
#[allow(dead_code)]
mod double_pendulum;

use double_pendulum::{DoublePendulum, RATES, START};
use nonsmooth::laws;
use nonsmooth::scheme::{Activation, ActivationRule, Settings, SetupError, StepError, ThetaScheme};
use nonsmooth::solver::{self, SOLVERS, SolveError, Stopping};
use nonsmooth::system::{
    Body, BodyId, Joints, NonlinearLagrangian, RigidBodies, RigidBodiesBuilder, System, SystemError,
    polygon_body,
};

type Scheme = ThetaScheme<f64, 2>;

fn scheme<S: System<f64, 2> + 'static>(
    system: S,
    (law, e, mu): (&str, f64, f64),
    solver: &str,
    (theta, h): (f64, f64),
    (q, v): (Vec<f64>, Vec<f64>),
) -> Result<Scheme, SetupError> {
    let laws = (0..system.interfaces()).map(|_| laws::build(law, &[e, mu]).expect("registered")).collect();
    let solver = solver::build(solver, Stopping::to(1e-12)).expect("registered");
    let activation = Activation::new(ActivationRule::PredictedGap);
    let settings = Settings { activation, ..Settings::new(theta, h) };
    ThetaScheme::new(Box::new(system), laws, solver, settings, 0.0, q, v)
}

const ROD: Body<f64> = Body { mass: 1.0, inertia: 1.0 / 12.0 };

/// Kane's double pendulum as two rods and two pins, over a floor `height` below the hinge. A rod's angle is that from
/// hanging down.
fn pinned(height: f64, gravity: f64) -> RigidBodiesBuilder<f64> {
    let mut builder = RigidBodies::builder();
    let (tip, floor) = (builder.group(), builder.group());
    let upper = builder.body("upper", ROD).expect("positive");
    let lower = builder.body("lower", ROD).expect("positive");
    builder.pin("hinge", upper, [0.0, 0.5], None, [0.0, 0.0]).expect("finite");
    builder.pin("elbow", lower, [0.0, 0.5], Some(upper), [0.0, -0.5]).expect("finite");
    builder.disc("tip", lower, [0.0, -0.5], 0.0, tip).expect("a point");
    builder.half_plane("floor", [0.0, -height], [0.0, 1.0], floor).expect("a plane");
    builder.interface(tip, floor).expect("two groups");
    builder.gravity([0.0, -gravity]).expect("finite");
    builder
}

/// Cartesian state of both rods for two angles and rates.
fn rods(q: [f64; 2], v: [f64; 2]) -> (Vec<f64>, Vec<f64>) {
    let [(s1, c1), (s2, c2)] = q.map(f64::sin_cos);
    let positions = vec![0.5 * s1, -0.5 * c1, q[0], s1 + 0.5 * s2, -c1 - 0.5 * c2, q[1]];
    let velocities = vec![
        0.5 * c1 * v[0],
        0.5 * s1 * v[0],
        v[0],
        c1 * v[0] + 0.5 * c2 * v[1],
        s1 * v[0] + 0.5 * s2 * v[1],
        v[1],
    ];
    (positions, velocities)
}

fn opening(scheme: &Scheme) -> f64 {
    let mut open = vec![0.0; scheme.system().joints().map_or(0, Joints::rows)];
    scheme.system().joints().expect("joints").residual(&scheme.state().q, &mut open);
    open.iter().fold(0.0, |most, x| f64::max(most, x.abs()))
}

#[test]
fn with_joints_kanes_impact_is_that_of_minimal_coordinates_under_every_solver() {
    let height: f64 = START.iter().map(|a| a.to_radians().cos()).sum();
    for (law, expected) in [("newton", 1.361895571782e-2), ("fremond", -1.014349887098e-2)] {
        for description in SOLVERS {
            let system = pinned(height, 0.0).build().expect("two rods");
            let state = rods(START.map(f64::to_radians), RATES);
            let mut scheme =
                scheme(system, (law, 0.5, 0.5), description.name, (0.5, 1e-9), state).expect("a valid setup");
            let balance = match scheme.step() {
                Ok(step) => step.balance,
                // First-order methods end within rounding of the tolerance, on either side of it.
                Err(StepError::Solve {
                    source: SolveError::NotConverged { residual, tolerance, .. },
                    ..
                }) => {
                    assert!(residual <= 1.01 * tolerance, "{}: {residual:e}", description.name);
                    continue;
                }
                Err(error) => panic!("{}: {error}", description.name),
            };
            let change = balance.normal_contact_work + balance.tangential_contact_work;
            // The rods turn by 1e-10 rad, the solver's tolerance is 1e-12.
            assert!((change - expected).abs() < 1e-9, "{law}, {}: {change}", description.name);
        }
    }
}

#[test]
fn joints_stay_closed_and_do_no_work() {
    for (law, e, theta) in [("fremond", 0.5, 0.5), ("fremond", 0.2, 0.7), ("moreau", 0.5, 2.0 / 3.0)] {
        let state = rods([1.2, 0.4], [0.0, 2.0]);
        let system = pinned(1.7, 9.81).build().expect("two rods");
        let mut scheme =
            scheme(system, (law, e, 0.3), "hybrid", (theta, 1e-3), state).expect("a valid setup");
        let (mut impacts, mut passes) = (0, 0);
        for k in 0..5000 {
            let step = scheme.step().unwrap_or_else(|error| panic!("{law}: {error}"));
            assert!(step.balance.imbalance.abs() <= 1e-12, "{law}, step {k}: {:?}", step.balance);
            let work = step.balance.normal_contact_work + step.balance.tangential_contact_work;
            assert!(work <= 1e-11, "{law}, step {k}: {work:e}");
            impacts += usize::from(step.contacts.iter().any(|contact| contact.percussion[0] > 0.0));
            passes = passes.max(scheme.passes());
        }
        assert!(impacts > 0 && passes <= 12, "{law}: {impacts} impacts, {passes} passes");
        // 64 ε of the length for each step at most.
        assert!(opening(&scheme) <= 64.0 * f64::EPSILON * 5000.0, "{law}: open by {:e}", opening(&scheme));
    }
}

#[test]
fn the_pinned_pendulum_moves_as_the_one_of_minimal_coordinates() {
    let (start, rates) = ([1.0, -0.5], [0.0, 1.0]);
    let difference = |h: f64| {
        let system = pinned(10.0, 9.81).build().expect("two rods");
        let mut joints =
            scheme(system, ("newton", 0.5, 0.0), "nsgs", (0.5, h), rods(start, rates)).expect("valid");
        let free =
            NonlinearLagrangian::<f64, 2>::new(DoublePendulum { gravity: 9.81 }, &start).expect("symmetric");
        let state = (start.to_vec(), rates.to_vec());
        let mut minimal = scheme(free, ("newton", 0.5, 0.0), "nsgs", (0.5, h), state).expect("valid");
        for _ in 0..(1.0 / h).round() as usize {
            joints.step().expect("no contact");
            minimal.step().expect("no contact");
        }
        let (q, exact) = (&joints.state().q, &minimal.state().q);
        (q[2] - exact[0]).abs().max((q[5] - exact[1]).abs())
    };
    let (coarse, fine) = (difference(1e-2), difference(5e-3));
    let order = (coarse / fine).log2();
    assert!(fine < 1e-3 && (order - 2.0).abs() < 0.2, "differences {coarse:e}, {fine:e}: order {order}");
}

#[test]
fn two_halves_welded_bounce_as_the_whole() {
    let scene = |welded: bool| {
        let mut builder = RigidBodies::builder();
        let (stone, floor) = (builder.group(), builder.group());
        let (mut q, mut v) = (Vec::new(), Vec::new());
        let outlines: &[[[f64; 2]; 4]] = if welded {
            &[
                [[-1.0, -0.5], [0.0, -0.5], [0.0, 0.5], [-1.0, 0.5]],
                [[0.0, -0.5], [1.0, -0.5], [1.0, 0.5], [0.0, 0.5]],
            ]
        } else {
            &[[[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]]]
        };
        let (angle, spin) = (0.3_f64, 1.0);
        let (sin, cos) = angle.sin_cos();
        let mut bodies: Vec<BodyId> = Vec::new();
        for outline in outlines {
            let (body, vertices, centre) = polygon_body(1.0, outline).expect("a rectangle");
            let body = builder.body("half", body).expect("positive");
            builder.polygon("half", body, &vertices, stone).expect("convex");
            bodies.push(body);
            let arm = [cos * centre[0] - sin * centre[1], sin * centre[0] + cos * centre[1]];
            q.extend([arm[0], 1.5 + arm[1], angle]);
            v.extend([0.5 - spin * arm[1], spin * arm[0], spin]);
        }
        if let [left, right] = bodies[..] {
            builder.weld("weld", left, [0.5, 0.0], Some(right), [-0.5, 0.0], 0.0).expect("finite");
        }
        builder.half_plane("floor", [0.0; 2], [0.0, 1.0], floor).expect("a plane");
        builder.interface(stone, floor).expect("two groups");
        builder.gravity([0.0, -10.0]).expect("finite");
        let system = builder.build().expect("bodies");
        let mut scheme =
            scheme(system, ("fremond", 0.5, 0.4), "hybrid", (0.5, 1e-3), (q, v)).expect("a valid setup");
        let mut impacts = 0;
        for _ in 0..400 {
            impacts += scheme.step().expect("contacts").contacts.len();
        }
        assert!(impacts > 0, "it fell on a corner");
        scheme.state().q.clone()
    };
    let (whole, halves) = (scene(false), scene(true));
    let centre = [0.5 * (halves[0] + halves[3]), 0.5 * (halves[1] + halves[4]), halves[2]];
    let difference = centre.iter().zip(&whole).fold(0.0, |d, (a, b)| f64::max(d, (a - b).abs()));
    // Two bodies on one rigid path: the weld constrains the middle of the step, a second-order difference.
    assert!(difference < 1e-4, "{centre:?}, {whole:?}");
}

#[test]
fn joints_that_cannot_be_are_refused() {
    let state = || rods([0.0, 0.0], [0.0, 0.0]);
    let fails = |builder: RigidBodiesBuilder<f64>, theta: f64, state: (Vec<f64>, Vec<f64>)| {
        let system = builder.build().expect("two rods");
        match scheme(system, ("newton", 0.5, 0.0), "nsgs", (theta, 1e-2), state) {
            Ok(mut scheme) => scheme.step().map(drop).map_err(|error| error.to_string()),
            Err(error) => Err(error.to_string()),
        }
    };
    let open = (vec![0.0, -0.6, 0.0, 0.0, -1.5, 0.0], vec![0.0; 6]);
    let error = fails(pinned(10.0, 9.81), 0.5, open).expect_err("open");
    assert!(error.contains("hinge") && error.contains("open"), "{error}");
    let error = fails(pinned(10.0, 9.81), 0.0, state()).expect_err("θ = 0");
    assert!(error.contains("θ > 0"), "{error}");

    let mut builder = RigidBodies::<f64>::builder();
    let body = builder.body("rod", ROD).expect("positive");
    let itself = builder.pin("itself", body, [0.0; 2], Some(body), [0.0; 2]);
    assert!(matches!(itself, Err(SystemError::OneBody { .. })), "{itself:?}");
    let nan = builder.pin("nowhere", body, [f64::NAN, 0.0], None, [0.0; 2]);
    assert!(matches!(nan, Err(SystemError::OutOfRange { .. })), "{nan:?}");
}

#[test]
fn a_pin_that_is_there_twice_holds_as_one_does() {
    let motion = |pins: usize| {
        let mut builder = RigidBodies::builder();
        let body = builder.body("rod", ROD).expect("positive");
        for name in &["pin", "same pin"][..pins] {
            builder.pin(name, body, [0.0, 0.5], None, [0.0, 0.0]).expect("finite");
        }
        builder.gravity([0.3, -10.0]).expect("finite");
        let system = builder.build().expect("a rod");
        let state = (vec![0.0, -0.5, 0.0], vec![0.0; 3]);
        let mut scheme = scheme(system, ("newton", 0.5, 0.0), "nsgs", (0.5, 1e-2), state).expect("closed");
        for _ in 0..200 {
            let step = scheme.step().expect("S is singular, the pins agree");
            assert!(step.balance.imbalance.abs() < 1e3 * f64::EPSILON, "{:?}", step.balance);
        }
        scheme.state().q.clone()
    };
    let (once, twice) = (motion(1), motion(2));
    // 200 steps that close to 64 ε each.
    let difference = once.iter().zip(&twice).fold(0.0, |most: f64, (x, y)| most.max((x - y).abs()));
    assert!(difference < 200.0 * 64.0 * f64::EPSILON, "{once:?}, {twice:?}");
}
