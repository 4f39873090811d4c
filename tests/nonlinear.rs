//! Nonlinear Lagrangian systems: the discrete balance closes, laws keep their sign, and the motion is the right one.

#[path = "../examples/hard_cases/cases/double_pendulum.rs"]
#[allow(dead_code)]
mod double_pendulum;

use double_pendulum::{DoublePendulum, RATES, START, pendulum};
use nalgebra::{DMatrix, Vector2};
use nonsmooth::laws;
use nonsmooth::scheme::{Activation, ActivationRule, Settings, SetupError, StepError, ThetaScheme};
use nonsmooth::solver::{Method, Nsgs, NsgsSettings, Stopping};
use nonsmooth::system::{Contacts, Forces, NonlinearLagrangian, NonlinearTerms, SmoothGap};

type Law = Box<dyn laws::ContactLaw<f64, 2>>;
type Scheme = ThetaScheme<f64, 2>;

fn try_scheme(
    system: NonlinearLagrangian<f64, 2>,
    (law, e, mu): (&str, f64, f64),
    (theta, h): (f64, f64),
    (q, v): (&[f64], &[f64]),
) -> Result<Scheme, SetupError> {
    let laws: Vec<Law> = (0..Contacts::<f64, 2>::interfaces(&system))
        .map(|_| laws::build(law, &[e, mu]).expect("registered"))
        .collect();
    let solver = Nsgs::solver(Stopping::to(1e-13), NsgsSettings::default()).expect("in range");
    let activation = Activation::new(ActivationRule::PredictedGap);
    let settings = Settings { activation, allow_unproved_theta: true, ..Settings::new(theta, h) };
    ThetaScheme::new(Box::new(system), laws, Box::new(solver), settings, 0.0, q.to_vec(), v.to_vec())
}

fn scheme(
    system: NonlinearLagrangian<f64, 2>,
    law: (&str, f64, f64),
    scheme: (f64, f64),
    state: (&[f64], &[f64]),
) -> Scheme {
    try_scheme(system, law, scheme, state).expect("a valid setup")
}

/// A rod of unit mass and length by the coordinates of its tip, (x, y, γ): M depends on γ.
#[derive(Debug)]
struct Rod;

const HALF: f64 = 0.5;
const GRAVITY: f64 = 10.0;

impl NonlinearTerms<f64> for Rod {
    fn mass(&self, q: &[f64], out: &mut DMatrix<f64>) {
        let (sin, cos) = q[2].sin_cos();
        let (x, y) = (-HALF * cos, -HALF * sin);
        out.copy_from_slice(&[1.0, 0.0, x, 0.0, 1.0, y, x, y, HALF * HALF + 1.0 / 12.0]);
    }

    fn mass_derivative(&self, q: &[f64], i: usize, out: &mut DMatrix<f64>) {
        let (sin, cos) = if i == 2 { q[2].sin_cos() } else { (0.0, 0.0) };
        let (x, y) = (HALF * sin, -HALF * cos);
        out.copy_from_slice(&[0.0, 0.0, x, 0.0, 0.0, y, x, y, 0.0]);
    }

    fn potential(&self, q: &[f64]) -> f64 {
        GRAVITY * (q[1] + HALF * q[2].cos())
    }

    fn potential_gradient(&self, q: &[f64], out: &mut [f64]) {
        out.copy_from_slice(&[0.0, GRAVITY, -GRAVITY * HALF * q[2].sin()]);
    }
}

/// The impacting stick of section 5.1, in the coordinates of its tip: e = 1, μ = 0.01.
fn stick(law: &str, theta: f64, h: f64) -> Scheme {
    let gap = SmoothGap::new(
        |q: &[f64]| q[1],
        |_, push| {
            push(1, Vector2::x());
            push(0, Vector2::y());
        },
    );
    let start = [0.0, 0.0, std::f64::consts::FRAC_PI_4];
    let system = NonlinearLagrangian::new(Rod, &start).expect("symmetric").with_contact(0, gap);
    // Centre at (½/√2, ½/√2 + 0.01), with the velocity (−0.5, 0.1) and the spin 0.1: C = G + ½ (sin γ, −cos γ).
    let half = HALF * std::f64::consts::FRAC_1_SQRT_2;
    let q = [2.0 * half, 0.01, start[2]];
    let v = [-0.5 + 0.1 * half, 0.1 + 0.1 * half, 0.1];
    scheme(system.with_scales(1.0, 1.0), (law, 1.0, 0.01), (theta, h), (&q, &v))
}

#[test]
fn the_spinning_rod_bounces_as_the_rigid_body_does_and_its_balance_closes() {
    // Event-driven limits of the tangential works at the two impacts; the scheme reaches them with order one.
    let h = 1e-5;
    for (law, expected) in [
        ("newton", [7.07557531928671e-4, -5.96201880021998e-4]),
        ("fremond", [-6.77436191397145e-4, -6.24721696746364e-4]),
    ] {
        let mut rod = stick(law, 0.5, h);
        let (mut works, mut passes) = (Vec::new(), 0);
        for _ in 0..20_000 {
            let step = rod.step().expect("one contact");
            let energy = step.energies.mechanical();
            assert!(step.balance.imbalance.abs() <= 64.0 * f64::EPSILON * energy, "{:?}", step.balance);
            for contact in step.contacts.iter().filter(|contact| contact.percussion[0] > 0.0) {
                works.push(contact.tangential_work);
                // e = 1: the normal does no work.
                assert!(contact.normal_work.abs() <= 1e-13, "{contact:?}");
            }
            passes = passes.max(rod.passes());
        }
        assert_eq!(works.len(), 2, "{law}: two impacts in 0.2 s");
        for (work, expected) in works.iter().zip(expected) {
            // Where the impact falls within its step changes the velocities by g h.
            assert!((work - expected).abs() <= 10.0 * GRAVITY * h * expected.abs(), "{law}: {works:?}");
        }
        // q(0.2) of the table, from the tip: x = x_G + ½ sin γ.
        if law == "newton" {
            let [x, y, angle] = [0.252917082969242, 0.247184152996499, 1.08198050693022_f64];
            let tip = [x + HALF * angle.sin(), y - HALF * angle.cos(), angle];
            let q = &rod.state().q;
            assert!(q.iter().zip(tip).all(|(q, exact)| (q - exact).abs() <= 5.0 * h), "{q:?}, {tip:?}");
        }
        assert!(passes <= 6, "{law}: {passes} passes");
    }
}

/// The double pendulum with damping d = c v and a periodic force on the first rod.
#[derive(Debug)]
struct Damped(DoublePendulum);

impl NonlinearTerms<f64> for Damped {
    fn mass(&self, q: &[f64], out: &mut DMatrix<f64>) {
        self.0.mass(q, out);
    }
    fn mass_derivative(&self, q: &[f64], i: usize, out: &mut DMatrix<f64>) {
        self.0.mass_derivative(q, i, out);
    }
    fn potential(&self, q: &[f64]) -> f64 {
        self.0.potential(q)
    }
    fn potential_gradient(&self, q: &[f64], out: &mut [f64]) {
        self.0.potential_gradient(q, out);
    }
    fn other_forces(&self, _t: f64, _q: &[f64], v: &[f64], out: &mut [f64]) {
        out[0] = 0.3 * v[0] + 0.1 * v[0].abs() * v[0];
        out[1] = 0.2 * v[1];
    }
}

#[test]
fn the_midpoint_conserves_the_energy_of_the_free_double_pendulum_at_any_step() {
    for h in [1e-3, 1e-2, 5e-2] {
        let free =
            NonlinearLagrangian::new(DoublePendulum { gravity: 9.81 }, &[0.0, 0.0]).expect("symmetric");
        let mut scheme = scheme(free, ("newton", 0.0, 0.0), (0.5, h), (&[2.0, -1.0], &[0.0, 3.0]));
        let start = scheme.last_step().energies.mechanical();
        for k in 0..2000 {
            let step = scheme.step().expect("no contact");
            // 64 ε of momenta and forces per step, one way at worst.
            let drift = (step.energies.mechanical() - start).abs();
            assert!(drift <= 64.0 * f64::EPSILON * f64::from(k + 1) * 100.0, "h = {h}, step {k}: {drift:e}");
        }
    }
}

#[test]
fn the_balance_closes_for_any_theta_with_damping_and_a_force() {
    for theta in [0.5, 0.7, 1.0] {
        let force = Forces::constant(vec![0.3, -0.2]).with_varying(|t: f64, f| f[0] += 2.0 * (5.0 * t).sin());
        let system = NonlinearLagrangian::new(Damped(DoublePendulum { gravity: 9.81 }), &[0.0, 0.0])
            .and_then(|system| system.with_forces(force))
            .expect("two forces");
        let mut scheme = scheme(system, ("newton", 0.0, 0.0), (theta, 1e-2), (&[2.0, -1.0], &[0.0, 3.0]));
        let (mut damped, mut dissipated, mut worked) = (0.0, 0.0, 0.0_f64);
        for _ in 0..500 {
            let balance = &scheme.step().expect("no contact").balance;
            assert!(balance.imbalance.abs() <= 1e-12, "θ = {theta}: {balance:?}");
            assert!(balance.damping_work <= 0.0 && balance.numerical_dissipation <= 0.0, "{balance:?}");
            damped += balance.damping_work;
            dissipated += balance.numerical_dissipation;
            worked += balance.external_work.abs();
        }
        assert!(damped < -1.0 && worked > 1.0, "every term took part: {damped}, {worked}");
        assert!((theta > 0.5) == (dissipated < 0.0), "θ = {theta}: {dissipated}");
    }
}

#[test]
fn the_free_motion_converges_with_order_two() {
    let end = |h: f64| {
        let free =
            NonlinearLagrangian::new(DoublePendulum { gravity: 9.81 }, &[0.0, 0.0]).expect("symmetric");
        let mut scheme = scheme(free, ("newton", 0.0, 0.0), (0.5, h), (&[1.0, -0.5], &[0.0, 1.0]));
        for _ in 0..(1.0 / h).round() as usize {
            scheme.step().expect("no contact");
        }
        scheme.state().q.clone()
    };
    let exact = end(1e-4);
    let error = |h: f64| end(h).iter().zip(&exact).fold(0.0, |e, (a, b)| f64::max(e, (a - b).abs()));
    let order = (error(1e-2) / error(5e-3)).log2();
    assert!((order - 2.0).abs() < 0.1, "order {order}");
}

#[test]
fn fremond_never_gains_at_kanes_pendulum_for_any_theta_it_claims() {
    for (theta, e) in [(0.5, 0.7), (0.5, 1.0), (0.55, 0.8), (0.8, 0.25), (1.0, 0.0)] {
        let q = START.map(f64::to_radians);
        let mut scheme = scheme(pendulum(9.81), ("fremond", e, 0.5), (theta, 1e-3), (&q, &RATES));
        for k in 0..2000 {
            let balance = &scheme.step().expect("one contact").balance;
            let work = balance.normal_contact_work + balance.tangential_contact_work;
            assert!(work <= 1e-13, "θ = {theta}, e = {e}, step {k}: {work:e}");
            assert!(balance.imbalance.abs() <= 1e-12, "θ = {theta}, e = {e}, step {k}: {balance:?}");
        }
    }
}

/// A mass that is not positive definite beyond q = 1.
#[derive(Debug)]
struct Failing;

impl NonlinearTerms<f64> for Failing {
    fn mass(&self, q: &[f64], out: &mut DMatrix<f64>) {
        out.fill(1.0 - q[0]);
    }
    fn mass_derivative(&self, _: &[f64], _: usize, out: &mut DMatrix<f64>) {
        out.fill(-1.0);
    }
}

#[test]
fn a_step_that_cannot_be_made_says_why_and_leaves_the_state() {
    let system = NonlinearLagrangian::new(Failing, &[0.0]).expect("symmetric");
    let mut scheme = scheme(system, ("newton", 0.0, 0.0), (0.5, 1e-1), (&[0.0], &[1.0]));
    let error = (0..100).find_map(|_| scheme.step().err()).expect("the mass vanishes on the way");
    let of_the_mass = matches!(error, StepError::Mass { .. } | StepError::Iteration { .. });
    let typed = of_the_mass || matches!(error, StepError::State { .. } | StepError::Energy { .. });
    assert!(typed, "{error}");
    let state = scheme.state().clone();
    assert!(state.q[0] < 1.0 + 1e-6 && scheme.step().is_err() && *scheme.state() == state);

    let system = NonlinearLagrangian::<f64, 2>::new(Failing, &[2.0]).expect("symmetric");
    let refused = try_scheme(system, ("newton", 0.0, 0.0), (0.5, 1e-1), (&[2.0], &[1.0]));
    assert!(matches!(refused, Err(SetupError::Mass(_))), "M(2) = −1");
}
