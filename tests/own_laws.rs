//! Laws written outside the crate: friction that depends on the speed of slip, laws that remember.

use nalgebra::SVector;
use nonsmooth::adaptive::{Adaptive, AdaptiveSettings};
use nonsmooth::laws::{Approach, ContactLaw, Passage, Response, Scalar};
use nonsmooth::linalg::Symmetric;
use nonsmooth::scheme::{Settings, ThetaScheme};
use nonsmooth::solver::{self, Stopping};
use nonsmooth::system::{Forces, Lagrangian, SmoothGap};

const GRAVITY: f64 = 10.0;

/// No restitution, and friction μ = a + b ‖u_T‖ at the velocity of the start of the step: Stribeck's where b < 0.
#[derive(Debug, Clone, Copy)]
struct SpeedDependent {
    a: f64,
    b: f64,
}

/// No restitution, and friction that wears: μ = μ₀ − c s after the distance s of slip.
#[derive(Debug, Clone, Copy)]
struct Wearing {
    friction: f64,
    wear: f64,
}

/// Restitution that falls with every impact: e/(1 + n) after n of them.
#[derive(Debug, Clone, Copy)]
struct Damaged {
    restitution: f64,
}

fn slip<T: Scalar, const D: usize>(u: &SVector<T, D>) -> T {
    nalgebra::ComplexField::sqrt(u.iter().skip(1).fold(T::zero(), |sum, &x| sum + x * x))
}

impl<const D: usize> ContactLaw<f64, D> for SpeedDependent {
    fn name(&self) -> &str {
        "speed-dependent friction"
    }

    fn respond(&self, at: &Approach<f64, D>) -> Response<f64, D> {
        Response::lasting(at, self.a + self.b * slip(&at.before))
    }
}

impl<const D: usize> ContactLaw<f64, D> for Wearing {
    fn name(&self) -> &str {
        "wearing friction"
    }

    fn respond(&self, at: &Approach<f64, D>) -> Response<f64, D> {
        Response::lasting(at, (self.friction - self.wear * at.memory[0]).max(0.0))
    }

    fn memory(&self) -> usize {
        1
    }

    fn remember(&self, done: &Passage<f64, D>, memory: &mut [f64]) {
        memory[0] += done.step * slip(&done.mean_velocity());
    }
}

impl<const D: usize> ContactLaw<f64, D> for Damaged {
    fn name(&self) -> &str {
        "damaged restitution"
    }

    fn respond(&self, at: &Approach<f64, D>) -> Response<f64, D> {
        if at.lasting {
            return Response::lasting(at, 0.0);
        }
        let mut shift = SVector::zeros();
        shift[0] = self.restitution / (1.0 + at.memory[0]) * at.before[0];
        Response::new(1.0, shift, 0.0)
    }

    fn memory(&self) -> usize {
        1
    }

    fn remember(&self, done: &Passage<f64, D>, memory: &mut [f64]) {
        if !done.lasting && done.percussion[0] > 0.0 {
            memory[0] += 1.0;
        }
    }
}

/// A point of 2 kg above the ground y = 0, in the state (x, y), (ẋ, ẏ).
fn point(
    law: impl ContactLaw<f64, 2> + 'static,
    h: f64,
    theta: f64,
    state: ([f64; 2], [f64; 2]),
) -> ThetaScheme<f64, 2> {
    let value = |q: &[f64]| q[1];
    let jacobian = |_: &[f64], push: &mut dyn FnMut(usize, SVector<f64, 2>)| {
        push(0, SVector::<f64, 2>::new(0.0, 1.0));
        push(1, SVector::<f64, 2>::new(1.0, 0.0));
    };
    let system = Lagrangian::new(Symmetric::diagonal(vec![2.0; 2]).expect("masses"))
        .with_forces(Forces::constant(vec![0.0, -2.0 * GRAVITY]))
        .expect("two forces")
        .with_scales(1.0, 1.0)
        .with_contact(0, SmoothGap::new(value, jacobian));
    let solver = solver::build::<f64, 2>("nsgs", Stopping::to(1e-14)).expect("registered");
    let settings = Settings::new(theta, h);
    let (q, v) = (state.0.to_vec(), state.1.to_vec());
    ThetaScheme::new(Box::new(system), vec![Box::new(law)], solver, settings, 0.0, q, v).expect("a scheme")
}

#[test]
fn friction_that_depends_on_the_speed_of_slip_stops_a_block_as_its_equation_says() {
    // v̇ = −g (a + b v): v = (v₀ + a/b) exp(−b g t) − a/b, at rest at t = ln(1 + b v₀/a)/(b g).
    for (a, b) in [(0.5, -0.1), (0.3, 0.2)] {
        let (h, v0) = (1e-4, 2.0);
        let mut scheme = point(SpeedDependent { a, b }, h, 1.0, ([0.0; 2], [v0, 0.0]));
        let rest = f64::ln(1.0 + b * v0 / a) / (b * GRAVITY);
        let steps = (0.9 * rest / h) as usize;
        for _ in 0..steps {
            scheme.step().expect("a step");
        }
        let t = scheme.state().time;
        let exact = (v0 + a / b) * f64::exp(-b * GRAVITY * t) - a / b;
        // What the law was asked to do, step by step: μ is that of the start of the step.
        let discrete = (v0 + a / b) * (1.0 - b * GRAVITY * h).powi(steps as i32) - a / b;
        let v = scheme.state().v[0];
        assert!((v - discrete).abs() <= 1e-10 * v0, "{v}, {discrete}");
        assert!((v - exact).abs() <= 2.0 * h * GRAVITY, "{v}, {exact}");
        for _ in 0..(0.3 * rest / h) as usize {
            scheme.step().expect("a step");
        }
        assert!(scheme.state().v[0].abs() <= 1e-12, "it stands: {:e}", scheme.state().v[0]);
    }
}

#[test]
fn friction_that_wears_lets_a_block_slide_as_far_as_its_equation_says() {
    // v dv/ds = −g (μ₀ − c s): v² = v₀² − 2 g (μ₀ s − ½ c s²), at rest at s = (μ₀ − √(μ₀² − c v₀²/g))/c.
    let (friction, wear, v0, h) = (0.5, 0.2, 2.0, 1e-4);
    let law = Wearing { friction, wear };
    let mut scheme = point(law, h, 1.0, ([0.0; 2], [v0, 0.0]));
    let distance = (friction - f64::sqrt(friction * friction - wear * v0 * v0 / GRAVITY)) / wear;
    while scheme.state().v[0].abs() > 1e-9 {
        let contact = scheme.step().expect("a step").contacts[0].id;
        let (x, worn) = (scheme.state().q[0], scheme.memory(contact, 0)[0]);
        // With θ = 1 the point moves by h u_{k+1}.
        assert!((x - worn).abs() <= 1e-12, "{x}, {worn}");
        assert!(x < 2.0 * distance);
    }
    let x = scheme.state().q[0];
    assert!((x - distance).abs() <= 2.0 * h * v0, "{x} m, {distance} m");
}

#[test]
fn restitution_that_falls_with_every_impact_does_so_through_flights_and_resumed_runs() {
    let bounce = |scheme: &mut ThetaScheme<f64, 2>, seen: &mut Vec<f64>, steps: usize| {
        for _ in 0..steps {
            let step = scheme.step().expect("a step");
            let impacts =
                step.contacts.iter().filter(|contact| !contact.lasting && contact.percussion[0] > 0.0);
            seen.extend(impacts.map(|contact| -contact.after[0] / contact.before[0]));
        }
    };
    let start = ([0.0, 1.0], [0.0; 2]);
    let mut scheme = point(Damaged { restitution: 0.8 }, 1e-3, 0.5, start);
    let mut seen = Vec::new();
    bounce(&mut scheme, &mut seen, 700);
    let snapshot = scheme.snapshot();
    let early = seen.len();
    bounce(&mut scheme, &mut seen, 900);
    assert!(early >= 1 && seen.len() >= 3, "{seen:?}");
    for (n, e) in seen.iter().take(4).enumerate() {
        assert!((e - 0.8 / (1.0 + n as f64)).abs() <= 1e-9, "impact {n}: {e}");
    }
    let mut resumed = point(Damaged { restitution: 0.8 }, 1e-3, 0.5, start);
    resumed.restore(&snapshot).expect("of the same scheme");
    let mut again = seen[..early].to_vec();
    bounce(&mut resumed, &mut again, 900);
    assert_eq!((again, &resumed.state().q), (seen, &scheme.state().q));
}

#[test]
fn a_step_that_error_control_rejects_leaves_no_trace_in_the_memory() {
    let (restitution, end) = (0.8, 1.2);
    let scheme = point(Damaged { restitution }, 1e-3, 0.5, ([0.0, 1.0], [0.0; 2]));
    let mut driver = Adaptive::new(scheme, AdaptiveSettings::new(1e-6, end)).expect("in range");
    let mut seen = Vec::new();
    let ended = driver.advance_to(end, |_, _, step| {
        let impacts = step.contacts.iter().filter(|contact| contact.percussion[0] > 0.0);
        seen.extend(impacts.map(|contact| -contact.after[0] / contact.before[0]));
        std::ops::ControlFlow::<()>::Continue(())
    });
    assert!(ended.is_ok(), "{ended:?}");
    assert!(seen.len() >= 2, "{seen:?}");
    for (n, e) in seen.iter().take(2).enumerate() {
        assert!((e - restitution / (1.0 + n as f64)).abs() <= 1e-6, "impact {n}: {e} of {seen:?}");
    }
}
