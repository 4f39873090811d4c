//! Rolling resistance: the geometry of its cones, one contact alone, and a disc that slows down and stands still.

use nalgebra::{SMatrix, SVector};
use nonsmooth::cone::{
    Cone, Status, contains, de_saxce, dual_gauge, largest_eigenvalue, natural_map, project,
    solve_one_contact, status,
};
use nonsmooth::laws::FremondRolling;
use nonsmooth::scheme::{Settings, ThetaScheme};
use nonsmooth::solver::{self, SOLVERS, Stopping};
use nonsmooth::system::{Body, RigidBodies};
use proptest::collection::vec;
use proptest::prelude::*;

const GRAVITY: f64 = 9.81;

fn cones() -> impl Strategy<Value = Cone<f64>> {
    let coefficient = || prop_oneof![1 => Just(0.0), 6 => 0.0..1.5f64];
    (coefficient(), coefficient(), coefficient()).prop_map(|(friction, rolling, spinning)| Cone::Rolling {
        friction,
        rolling,
        spinning,
    })
}

/// p = proj_K(x): p ∈ K, p − x ∈ K*, p ⟂ p − x.
fn is_projection<const D: usize>(x: &SVector<f64, D>, cone: Cone<f64>) -> Result<(), TestCaseError> {
    let p = project(x, cone);
    let size = 1e-13 * x.norm();
    prop_assert!(contains(&p, cone, size), "{p:?} is not in {cone:?}");
    let rest = p - x;
    prop_assert!(rest[0] >= dual_gauge(&rest, cone) - 4.0 * size, "{rest:?} is not in the dual of {cone:?}");
    prop_assert!(p.dot(&rest).abs() <= 4.0 * size * x.norm());
    // The natural map is the same projection without its cancellations.
    let natural = natural_map(&p, &(p - x), cone);
    prop_assert!(natural.norm() <= 8.0 * size, "{natural:?}");
    Ok(())
}

/// W = A Aᵀ + diagonal, b: the residual of the exact solution is rounding.
fn is_solved<const D: usize>(entries: &[f64], b: &[f64], cone: Cone<f64>) -> Result<(), TestCaseError> {
    let a = SMatrix::<f64, D, D>::from_column_slice(&entries[..D * D]);
    let w = a * a.transpose() + SMatrix::identity() * 0.05;
    let b = SVector::<f64, D>::from_column_slice(&b[..D]);
    let r = solve_one_contact(&w, &b, cone);
    let size = largest_eigenvalue(&w);
    let spectrum = nalgebra::DMatrix::from_column_slice(D, D, w.as_slice()).symmetric_eigenvalues();
    prop_assert!((size - spectrum.max()).abs() <= 1e-12 * size, "{size}, {spectrum}");
    let phi = de_saxce(&(w * r + b), cone) / size;
    let residual = natural_map(&r, &phi, cone).norm() * size / b.norm();
    prop_assert!(residual <= 1e-11, "{residual:e}: {r:?}, {cone:?}");
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn projections_are_those_on_the_cone(x in vec(-2.0..2.0f64, 6), cone in cones()) {
        is_projection(&SVector::<f64, 3>::from_column_slice(&x[..3]), cone)?;
        is_projection(&SVector::<f64, 6>::from_column_slice(&x), cone)?;
    }

    #[test]
    fn one_contact_is_solved(entries in vec(-1.0..1.0f64, 36), b in vec(-1.0..1.0f64, 6), cone in cones()) {
        is_solved::<3>(&entries, &b, cone)?;
        is_solved::<6>(&entries, &b, cone)?;
    }

    /// Without resistance against rolling the contact in the plane is Coulomb's with a moment of 0.
    #[test]
    fn no_resistance_is_coulombs_contact(entries in vec(-1.0..1.0f64, 9), b in vec(-1.0..1.0f64, 3), friction in 0.0..1.5f64) {
        let a = SMatrix::<f64, 3, 3>::from_column_slice(&entries);
        let w = a * a.transpose() + SMatrix::identity() * 0.05;
        let b = SVector::<f64, 3>::from_column_slice(&b);
        let rolling = solve_one_contact(&w, &b, Cone::rolling(friction, 0.0));
        let part = w.fixed_view::<2, 2>(0, 0).into_owned();
        let coulomb = solve_one_contact(&part, &b.fixed_rows::<2>(0).into_owned(), friction);
        prop_assert!((rolling.fixed_rows::<2>(0) - coulomb).norm() <= 1e-11 * (1.0 + coulomb.norm()));
        prop_assert_eq!(rolling[2], 0.0);
    }
}

#[test]
fn a_contact_rolls_where_a_moment_is_on_its_boundary() {
    let cone = Cone::rolling(0.5, 0.1);
    let state = |t: f64, m: f64| status(&SVector::<f64, 3>::new(1.0, t, m), cone, 1e-9);
    assert_eq!(state(0.3, 0.05), Status::Stick);
    assert_eq!(state(0.3, -0.1), Status::Roll);
    assert_eq!(state(-0.5, 0.05), Status::Slide);
    assert_eq!(status(&SVector::<f64, 3>::zeros(), cone, 1e-9), Status::TakeOff);
}

/// A disc of 2 kg and radius R on a plane that falls by `slope` (rad), rolling at the speed `speed`.
fn disc(solver: &str, rolling: f64, (radius, slope): (f64, f64), speed: f64, h: f64) -> ThetaScheme<f64, 3> {
    let mut scene = RigidBodies::builder();
    let (wheel, ground) = (scene.group(), scene.group());
    let body = scene.body("disc", Body { mass: 2.0, inertia: radius * radius }).expect("a body");
    scene.disc("disc", body, [0.0, 0.0], radius, wheel).expect("a disc");
    scene.half_plane("ground", [0.0, 0.0], [0.0, 1.0], ground).expect("a plane");
    scene.interface(wheel, ground).expect("two groups");
    scene.gravity([GRAVITY * slope.sin(), -GRAVITY * slope.cos()]).expect("finite");
    let law = FremondRolling::new(0.0, 0.8, rolling, 0.0).expect("in range");
    let solver = solver::build::<f64, 3>(solver, Stopping::to(1e-12)).expect("registered");
    let (q, v) = (vec![0.0, radius, 0.0], vec![speed, 0.0, -speed / radius]);
    let system = Box::new(scene.build().expect("a scene"));
    ThetaScheme::new(system, vec![Box::new(law)], solver, Settings::new(0.5, h), 0.0, q, v).expect("a scheme")
}

#[test]
fn a_disc_slows_down_and_stands_still_by_every_solver() {
    // v̇ = −(2/3) g μ_R/R, whatever the mass: at rest after v₀/that.
    for solver in SOLVERS {
        for radius in [0.5, 0.01] {
            let (rolling, v0, h) = (0.02 * radius, 0.3, 1e-3);
            let deceleration = 2.0 / 3.0 * GRAVITY * rolling / radius;
            let mut scheme = disc(solver.name, rolling, (radius, 0.0), v0, h);
            let rest = v0 / deceleration;
            for _ in 0..(0.8 * rest / h) as usize {
                scheme.step().unwrap_or_else(|error| panic!("{}: {error}", solver.name));
                let (t, v) = (scheme.state().time, &scheme.state().v);
                // The first step is an impact of θ = ½ and may lag by one step.
                assert!(
                    (v[0] - (v0 - deceleration * t)).abs() <= 2.0 * deceleration * h,
                    "{}: {} m/s at {t}",
                    solver.name,
                    v[0]
                );
                assert!((v[0] + radius * v[2]).abs() <= 1e-8, "{} slips", solver.name);
            }
            for _ in 0..(0.4 * rest / h) as usize {
                scheme.step().unwrap_or_else(|error| panic!("{}: {error}", solver.name));
            }
            let v = &scheme.state().v;
            assert!(v.iter().all(|v| v.abs() <= 1e-8), "{} stands: {v:?}", solver.name);
        }
    }
}

#[test]
fn a_disc_holds_on_a_slope_that_falls_by_less_than_its_rolling_resistance() {
    let (radius, rolling) = (0.2, 0.01);
    let steepest = f64::atan(rolling / radius);
    for solver in SOLVERS {
        let end = |slope: f64| {
            let mut scheme = disc(solver.name, rolling, (radius, slope), 0.0, 1e-3);
            for _ in 0..500 {
                scheme.step().unwrap_or_else(|error| panic!("{}: {error}", solver.name));
            }
            scheme.state().v[0]
        };
        assert!(end(0.99 * steepest).abs() <= 1e-8, "{} holds", solver.name);
        // It rolls down by (2/3) g (sin a − cos a μ_R/R).
        let slope = 1.5 * steepest;
        let expected = 2.0 / 3.0 * GRAVITY * (slope.sin() - slope.cos() * rolling / radius) * 0.5;
        let speed = end(slope);
        assert!((speed - expected).abs() <= 0.01 * expected, "{}: {speed} m/s for {expected}", solver.name);
    }
}

#[test]
fn the_work_of_a_rolling_disc_is_what_its_energy_loses() {
    let (radius, rolling, v0) = (0.5, 0.02, 0.4);
    let mut scheme = disc("hybrid", rolling, (radius, 0.0), v0, 1e-3);
    let first = 0.75 * 2.0 * v0 * v0;
    let (mut lost, mut numerical) = (0.0, 0.0);
    for _ in 0..400 {
        let step = scheme.step().expect("a step");
        for contact in &step.contacts {
            assert!(contact.tangential_work <= 1e-12, "{:e}", contact.tangential_work);
            lost += contact.tangential_work + contact.normal_work;
        }
        numerical += step.balance.numerical_dissipation;
        assert!(step.balance.imbalance.abs() <= 1e-12 * first);
    }
    let energy = scheme.last_step().energies.kinetic;
    assert!(
        (energy - first - lost - numerical).abs() <= 1e-10 * first,
        "{energy} J, {lost} J, {numerical} J"
    );
}

/// The same disc from a scene file: the third component of its contact is the moment.
#[cfg(feature = "scene")]
#[test]
fn a_scene_with_rolling_resistance_has_contacts_that_roll() {
    use nonsmooth::scene::Scene;

    let scene = Scene::parse(
        r#"
        title = "A disc that resists rolling"
        laws = ["fremond-rolling"]
        solvers = ["hybrid", "nsgs"]
        gravity = [0.0, -9.81]

        [time]
        step = 1e-3
        end = 0.5
        theta = 0.5

        [[bodies]]
        name = "disc"
        mass = 2.0
        inertia = 0.04
        position = [0.0, 0.2]
        velocity = [0.5, 0.0]
        spin = -2.5

        [[bodies.discs]]
        name = "rim"
        radius = 0.2

        [[half_planes]]
        name = "floor"
        normal = [0.0, 1.0]

        [[interfaces]]
        between = ["disc", "floor"]
        parameters = { restitution = 0.0, friction = 0.6, rolling = 0.004 }
        "#,
        std::path::Path::new("disc.toml"),
    )
    .expect("a scene");
    let registry = nonsmooth::registry();
    for run in scene.run(&registry).expect("two runs") {
        let deceleration = 2.0 / 3.0 * GRAVITY * 0.004 / 0.2;
        let (t, v) = (run.times[run.times.len() - 1], &run.v[run.v.len() - 1]);
        assert!((v[0] - (0.5 - deceleration * t)).abs() <= 2e-3 * deceleration, "{}: {v:?}", run.solver);
        let moments = run.contacts.iter().flatten().map(|contact| contact.percussion[2].abs());
        let largest = moments.fold(0.0, f64::max);
        // m h = μ_R N h, in N m s, whatever arm the cone problem measures it at.
        assert!((largest - 0.004 * 2.0 * GRAVITY * 1e-3).abs() <= 1e-9, "{largest}");
    }
}
