//! A warm step allocates nothing: counted by the allocator itself.

mod elastic;
mod random_problems;
mod scenes;

use std::ops::ControlFlow;

use allocation_counter::measure;
use nalgebra::{SVector, vector};
use nonsmooth::adaptive::{Adaptive, AdaptiveSettings};
use nonsmooth::cone::{ConeProblem, FactoredDelassus, Form};
use nonsmooth::laws::{ContactLaw, Fremond};
use nonsmooth::linalg::{BlockRows, Symmetric};
use nonsmooth::scalar::{Scalar, lit};
use nonsmooth::scheme::{Activation, ActivationRule, Settings, ThetaScheme};
use nonsmooth::solver::{ConeSolver, Method, Nsgs, NsgsSettings, Stopping, build};
use nonsmooth::system::{
    Body, BodyId, Forces, Lagrangian, Relative, RigidBodies, RoundSide, Signal, SmoothGap,
};
use random_problems::{Recipe, random};

/// Makes `warm_up` steps, then asserts that the next `steps` allocate nothing and that contacts were active in them.
fn assert_no_allocation<T: Scalar, const D: usize>(
    what: &str,
    scheme: &mut ThetaScheme<T, D>,
    warm_up: usize,
    steps: usize,
) {
    let what = format!("{what}, D = {D}, {}", T::NAME);
    for _ in 0..warm_up {
        scheme.step().unwrap_or_else(|error| panic!("{what}: {error}"));
    }
    let (mut active, mut failure) = (0, None);
    let allocated = measure(|| {
        for _ in 0..steps {
            match scheme.step() {
                Ok(step) => active += step.contacts.len(),
                Err(error) => {
                    failure = Some(error);
                    break;
                }
            }
        }
    });
    assert!(failure.is_none(), "{what}: {}", failure.expect("just seen"));
    assert!(active > 0, "{what}: no contact was active in the steps measured");
    let (count, bytes) = (allocated.count_total, allocated.bytes_total);
    assert_eq!(count, 0, "{what}: {count} allocations, {bytes} bytes, in {steps} warm steps; reuse a buffer");
}

#[test]
fn the_counter_counts() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![0u8; 10]))).count_total, 1);
}

/// The first impact (step 603) warms the buffers; the second (about step 1633) is among the steps measured.
fn stick<T: Scalar, const D: usize>() {
    for law in ["newton", "fremond"] {
        for solver in ["nsgs", "hybrid"] {
            let mut scheme = scenes::stick::<T, D>(law, solver);
            assert_no_allocation(&format!("stick, {law}, {solver}"), &mut scheme, 1000, 1000);
        }
    }
}

#[test]
fn the_stick_allocates_nothing() {
    stick::<f64, 2>();
    stick::<f32, 2>();
}

#[test]
fn the_frictionless_stick_allocates_nothing() {
    stick::<f64, 1>();
    stick::<f32, 1>();
}

/// About 50 discs in rows of up to `wide`, `high` rows of them; they rest after some 50 steps.
fn pile<T: Scalar, const D: usize>(wide: usize, high: usize, friction: f64, tolerance: f64) {
    let mut scheme = scenes::pile::<T, D>(wide, high, friction, "nsgs", Some(tolerance));
    assert_no_allocation("a pile of discs", &mut scheme, 300, 100);
}

/// Two links that hang from a pin and drag on a floor.
#[test]
fn joints_with_contacts_allocate_nothing() {
    let mut builder = RigidBodies::<f64>::builder();
    let (ends, ground) = (builder.group(), builder.group());
    let link = Body { mass: 1.0, inertia: 1.0 / 12.0 };
    let upper = builder.body("upper", link).expect("positive");
    let lower = builder.body("lower", link).expect("positive");
    builder.pin("hinge", upper, [-0.5, 0.0], None, [0.0; 2]).expect("finite");
    builder.pin("elbow", lower, [-0.5, 0.0], Some(upper), [0.5, 0.0]).expect("finite");
    builder.disc("tip", lower, [0.5, 0.0], 0.05, ends).expect("a disc");
    builder.half_plane("floor", [0.0, -1.0], [0.0, 1.0], ground).expect("a plane");
    builder.interface(ends, ground).expect("two groups");
    builder.gravity([0.0, -9.81]).expect("finite");
    let system = builder.build().expect("bodies");
    let laws: Vec<Box<dyn ContactLaw<f64, 2>>> = vec![Box::new(Fremond::new(0.0, 0.3).expect("in range"))];
    let solver: Box<dyn ConeSolver<f64, 2>> = build("nsgs", Stopping::to(1e-10)).expect("registered");
    let activation = Activation::new(ActivationRule::PredictedGap);
    let settings = Settings { activation, ..Settings::new(0.6, 1e-3) };
    let q = vec![0.5, 0.0, 0.0, 1.5, 0.0, 0.0];
    let mut scheme =
        ThetaScheme::new(Box::new(system), laws, solver, settings, 0.0, q, vec![0.0; 6]).expect("closed");
    assert_no_allocation("joints", &mut scheme, 3000, 1000);
}

#[test]
fn springs_motors_clutches_and_moving_obstacles_allocate_nothing() {
    let mut builder = RigidBodies::<f64>::builder();
    let (ends, ground) = (builder.group(), builder.group());
    let link = Body { mass: 1.0, inertia: 1.0 / 12.0 };
    let upper = builder.body("upper", link).expect("positive");
    let lower = builder.body("lower", link).expect("positive");
    builder.pin("hinge", upper, [-0.5, 0.0], None, [0.0; 2]).expect("finite");
    builder.pin("elbow", lower, [-0.5, 0.0], Some(upper), [0.5, 0.0]).expect("finite");
    builder.disc("tip", lower, [0.5, 0.0], 0.05, ends).expect("a disc");
    let sine = Signal::Sine { frequency: 3.0, phase: 0.0 };
    let still = || (0.0, Signal::Constant);
    let motion = [still(), (0.02, sine.clone()), still()];
    let plate = builder.moved_body("plate", [0.0, -1.0, 0.0], motion).expect("finite");
    builder.half_plane_of("top", plate, [0.0; 2], [0.0, 1.0], ground).expect("a plane");
    builder.arc("wall", BodyId::GROUND, ([0.0; 2], 1.9), RoundSide::Inside, None, ground).expect("a circle");
    builder.interface(ends, ground).expect("two groups");
    let (elbow, hinge) = ((lower, Some(upper)), (upper, None));
    builder.rub("friction", elbow, Relative::Angle, 0.3).expect("finite");
    builder.drive("motor", hinge, Relative::Angle, (1.0, Some(4.0)), sine).expect("finite");
    let limit = builder.limit("limit", elbow, Relative::Angle, [-1.5, 1.5]).expect("in order");
    let distance = Relative::Distance { at: [0.5, 0.0], on: [0.0, -0.5] };
    builder.spring_between("spring", (lower, Some(plate)), distance, (30.0, 0.5), 0.4).expect("finite");
    builder.gravity([0.0, -9.81]).expect("finite");
    let system = builder.build().expect("bodies");
    assert_eq!(limit, 1);
    let law = || -> Box<dyn ContactLaw<f64, 2>> { Box::new(Fremond::new(0.0, 0.3).expect("in range")) };
    let solver: Box<dyn ConeSolver<f64, 2>> = build("nsgs", Stopping::to(1e-10)).expect("registered");
    let activation = Activation::new(ActivationRule::PredictedGap);
    let settings = Settings { activation, ..Settings::new(0.6, 1e-3) };
    let q = vec![0.5, 0.0, 0.0, 1.5, 0.0, 0.0, 0.0, -1.0, 0.0];
    let mut scheme =
        ThetaScheme::new(Box::new(system), vec![law(), law()], solver, settings, 0.0, q, vec![0.0; 9])
            .expect("closed");
    assert_no_allocation("mechanism", &mut scheme, 3000, 1000);
}

#[test]
fn a_settled_pile_allocates_nothing() {
    // The subject is the buffers, not the digits: with friction Gauss–Seidel stalls near 1e-7 on a dense pile.
    pile::<f64, 2>(8, 7, 0.5, 1e-5);
    pile::<f64, 1>(26, 2, 0.0, 1e-8);
    // ‖b‖ of a pile at rest is g h √m; single precision resolves it to a few hundred ε of the speeds met.
    pile::<f32, 2>(8, 7, 0.5, 1e-3);
    pile::<f32, 1>(26, 2, 0.0, 1e-3);
}

/// A bar of `n` masses and springs over a floor, its lower end and its middle in contact: sparse K and C, so that
/// M̂ is factored by the sparse Cholesky.
fn bar<T: Scalar, const D: usize>(n: usize) -> ThetaScheme<T, D> {
    let chain = |scale: f64| {
        let mut triplets = Vec::new();
        for i in 0..n - 1 {
            for (row, column, x) in [(i, i, 1.0), (i + 1, i + 1, 1.0), (i, i + 1, -1.0), (i + 1, i, -1.0)] {
                triplets.push((row, column, lit::<T>(x * scale)));
            }
        }
        Symmetric::sparse(n, &triplets).expect("symmetric")
    };
    let mass = Symmetric::diagonal(vec![lit::<T>(1.0); n]).expect("finite");
    let mut bar = Lagrangian::new(mass).with_stiffness(chain(1e3)).expect("size");
    bar = bar.with_damping(chain(1.0)).expect("size");
    let weight = vec![lit::<T>(-10.0); n];
    let swing = move |t: T, f: &mut [T]| f[n - 1] += nalgebra::ComplexField::sin(t);
    bar = bar.with_forces(Forces::constant(weight).with_varying(swing)).expect("size");
    for (interface, dof) in [(0, 0), (1, n / 2)] {
        let gap = move |q: &[T]| q[dof];
        let row = move |_: &[T], push: &mut dyn FnMut(usize, SVector<T, D>)| {
            push(dof, SVector::from_fn(|i, _| if i == 0 { T::one() } else { T::zero() }));
            // The tangent looks along the next mass, so that friction has something to act on.
            push(dof + 1, SVector::from_fn(|i, _| if i == 1 { T::one() } else { T::zero() }));
        };
        bar = bar.with_contact(interface, SmoothGap::new(gap, row));
    }
    let friction = if D == 1 { 0.0 } else { 0.2 };
    let law = || -> Box<dyn ContactLaw<T, D>> {
        Box::new(Fremond::new(lit(0.0), lit(friction)).expect("in range"))
    };
    let mut settings = Settings::new(lit(1.0), lit(1e-3));
    settings.activation = Activation::new(ActivationRule::PredictedGap);
    let solver = Nsgs::solver(Stopping::default(), NsgsSettings::default()).expect("in range");
    let (q, v) = (vec![lit::<T>(1e-4); n], vec![T::zero(); n]);
    ThetaScheme::new(Box::new(bar), vec![law(), law()], Box::new(solver), settings, T::zero(), q, v)
        .expect("valid")
}

#[test]
fn sparse_stiffness_and_damping_allocate_nothing() {
    assert_no_allocation("an elastic bar", &mut bar::<f64, 2>(60), 400, 400);
    assert_no_allocation("an elastic bar", &mut bar::<f64, 1>(60), 400, 400);
    assert_no_allocation("an elastic bar", &mut bar::<f32, 2>(60), 400, 400);
    assert_no_allocation("an elastic bar", &mut bar::<f32, 1>(60), 400, 400);
}

#[test]
fn the_sliding_block_allocates_nothing() {
    use nonsmooth::mesh::Pattern;
    use nonsmooth::system::Hypothesis;
    for law in ["newton", "fremond"] {
        for solver in ["nsgs", "hybrid"] {
            let mesh = elastic::built_in_mesh(2.5, Pattern::Structured);
            let rule = ActivationRule::MoreauJean;
            let mut block = elastic::block_scheme(mesh, Hypothesis::PlaneStress, law, solver, rule);
            assert_no_allocation(&format!("sliding block, {law}, {solver}"), &mut block, 2000, 2000);
        }
    }
}

/// Runs a driver to `warm`, then to `end`: no allocation but where the scheme factors M̂ for a length it has not met.
fn assert_no_allocation_under_error_control<const D: usize>(
    what: &str,
    scheme: ThetaScheme<f64, D>,
    tolerance: f64,
    (warm, end): (f64, f64),
) {
    let mut driver = Adaptive::new(scheme, AdaptiveSettings::new(tolerance, end)).expect("in range");
    let go = |driver: &mut Adaptive<f64, D>, time| {
        let mut active = 0;
        let ended: Result<ControlFlow<()>, _> = driver.advance_to(time, |_, _, step| {
            active += step.contacts.len();
            ControlFlow::Continue(())
        });
        assert!(ended.is_ok(), "{what}: {ended:?}");
        active
    };
    go(&mut driver, warm);
    let (mut active, mut quiet, mut stretches) = (0, 0, 0);
    for i in 1..=100 {
        let (factored, to) = (driver.scheme().factorisations(), warm + (end - warm) * f64::from(i) / 100.0);
        let allocated = measure(|| active += go(&mut driver, to));
        stretches += 1;
        if driver.scheme().factorisations() == factored {
            quiet += 1;
            let (count, bytes) = (allocated.count_total, allocated.bytes_total);
            assert_eq!(count, 0, "{what}: {count} allocations, {bytes} bytes, until t = {to}");
        }
    }
    assert!(active > 0, "{what}: no contact was active in the steps measured");
    assert!(2 * quiet > stretches, "{what}: M̂ is factored again and again: {quiet} of {stretches} without");
}

#[test]
fn warm_steps_under_error_control_allocate_nothing() {
    for law in ["newton", "fremond"] {
        let stick = scenes::stick::<f64, 2>(law, "nsgs");
        assert_no_allocation_under_error_control(&format!("stick, {law}"), stick, 1e-6, (0.1, 0.2));
    }
    assert_no_allocation_under_error_control("an elastic bar", bar::<f64, 2>(20), 1e-2, (0.05, 0.1));
}

/// A second solve of the same problem, and of one with another b, finds every buffer in place.
fn warm_solves_allocate<const D: usize>(name: &str, m: usize) -> u64 {
    let recipe = Recipe { seed: 11, contacts: m, freedom: m * D + 3, friction: 0.5, decades: 1.0 };
    let problem = random::<f64, D>(&recipe);
    let mut solver = build::<f64, D>(name, Stopping::default()).expect("registered");
    let start = vec![SVector::zeros(); m];
    let mut r = start.clone();
    solver.solve(&problem, &start, &mut r).expect("solvable");
    measure(|| {
        solver.solve(&problem, &start, &mut r).expect("solvable");
    })
    .count_total
}

/// A beam of bricks on four points each: fewer velocities than percussions, so that W stays in factored form.
fn factored(bricks: usize) -> ConeProblem<f64, 3> {
    let mut h = BlockRows::new();
    for brick in 0..bricks {
        for (x, y) in [(-0.1, -0.05), (-0.1, 0.05), (0.1, -0.05), (0.1, 0.05)] {
            h.start_row();
            // Normal z, tangents x and y; the arm reaches from the centre to the bed joint 0.05 m below.
            let columns = [
                vector![0.0, 1.0, 0.0],
                vector![0.0, 0.0, 1.0],
                vector![1.0, 0.0, 0.0],
                vector![y, 0.0, 0.05],
                vector![-x, -0.05, 0.0],
                vector![0.0, -y, x],
            ];
            columns.into_iter().enumerate().for_each(|(k, column)| h.push(6 * brick + k, column));
        }
    }
    let mass =
        Symmetric::diagonal([4.0, 4.0, 4.0, 0.02, 0.02, 0.02].repeat(bricks)).expect("positive masses");
    let operator = FactoredDelassus::new(&h, &mass, 6).expect("six velocities per brick");
    let free: Vec<f64> = (0..6 * bricks).map(|i| [0.1, 0.05, -0.3, 0.2, 0.5, 0.1][i % 6]).collect();
    let b = (0..4 * bricks).map(|i| h.velocity(i, &free)).collect();
    ConeProblem::factored(operator, Form::Factored, b, vec![0.4; 4 * bricks]).expect("a problem")
}

#[test]
fn warm_solves_in_body_space_allocate_nothing() {
    for name in ["nsgs", "hybrid", "proximal-newton"] {
        let (problem, start) = (factored(6), vec![SVector::zeros(); 24]);
        let mut r = start.clone();
        let mut solver = build::<f64, 3>(name, Stopping::default()).expect("registered");
        solver.solve(&problem, &start, &mut r).expect("solvable");
        let again = measure(|| {
            solver.solve(&problem, &start, &mut r).expect("solvable");
        });
        assert_eq!(again.count_total, 0, "{name}: {} bytes", again.bytes_total);
    }
}

#[test]
fn warm_solves_of_gauss_seidel_and_newton_allocate_nothing() {
    for name in ["nsgs", "hybrid", "proximal-newton", "newton"] {
        for m in [1, 3, 20] {
            let counts = [
                warm_solves_allocate::<1>(name, m),
                warm_solves_allocate::<2>(name, m),
                warm_solves_allocate::<3>(name, m),
            ];
            assert_eq!(counts, [0; 3], "{name}, {m} contacts, D = 1, 2, 3");
        }
    }
}
