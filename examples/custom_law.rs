//! A law written outside the crate: restitution that falls with the speed of the impact.
//!
//! Steel on steel bounces less the harder it hits. With the speed c at which e has fallen to ½,
//!
//! ```text
//!   e(u_N) = c / (c + |u_N|)
//! ```
//!
//! in the place of the constant e of Frémond's law keeps its proof: e ≤ 1 ≤ e* at θ = ½, whatever the speed. The law
//! passes the property suite of the built-in ones and then bounces in a scheme, chosen like any other.
//!
//! Run with `cargo run --example custom_law`.

use std::ops::RangeInclusive;

use nalgebra::SVector;
use nonsmooth::laws::{Approach, ContactLaw, Response, Scalar};
use nonsmooth::scheme::{Settings, ThetaScheme};
use nonsmooth::solver::{self, Stopping};
use nonsmooth::suite::{Suite, check_law};
use nonsmooth::system::{Body, RigidBodies};

/// Frémond's law with the restitution e(u_N) = c/(c + |u_N|).
#[derive(Debug, Clone, Copy)]
struct SpeedDependent<T> {
    /// Speed c > 0 at which e = ½ (m/s).
    half_speed: T,
    /// Coefficient of friction μ ≥ 0.
    friction: T,
}

impl<T: Scalar, const D: usize> ContactLaw<T, D> for SpeedDependent<T> {
    fn name(&self) -> &str {
        "speed-dependent"
    }

    fn respond(&self, at: &Approach<T, D>) -> Response<T, D> {
        if at.lasting {
            return Response::lasting(at, self.friction);
        }
        let mut shift = SVector::zeros();
        if at.before[0] <= T::zero() {
            let restitution = self.half_speed / (self.half_speed - at.before[0]);
            shift[0] = (at.theta * (T::one() + restitution) - T::one()) * at.before[0];
        }
        Response::new(at.theta, shift, self.friction)
    }

    // e reaches 1 at rest, so of the interval [½, 1/(1+e)] only θ = ½ is left for every state.
    fn dissipative_theta(&self) -> Option<RangeInclusive<T>> {
        let half = nalgebra::convert(0.5);
        Some(half..=half)
    }

    // Contacts that last have no restitution to lose.
    fn lasting_theta(&self) -> Option<RangeInclusive<T>> {
        Some(nalgebra::convert(0.5)..=T::one())
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let suite = Suite::default();
    check_law(&suite, 2, |unit| SpeedDependent { half_speed: 0.1 + unit[0], friction: 2.0 * unit[1] })?;
    println!("the law keeps its claim in dimensions 1, 2 and 3, with every solver\n");

    let mut scene = RigidBodies::builder();
    let (ball, floor) = (scene.group(), scene.group());
    let body = scene.body("ball", Body { mass: 1.0, inertia: 0.4e-2 })?;
    scene.disc("ball", body, [0.0, 0.0], 0.1, ball)?;
    scene.half_plane("floor", [0.0, 0.0], [0.0, 1.0], floor)?;
    scene.interface(ball, floor)?;
    scene.gravity([0.0, -10.0])?;
    let law = SpeedDependent { half_speed: 1.0, friction: 0.3 };
    let solver = solver::build::<f64, 2>(solver::DEFAULT, Stopping::default())?;
    let (q, v) = (vec![0.0, 1.1, 0.0], vec![1.0, 0.0, 0.0]);
    let mut scheme = ThetaScheme::new(
        Box::new(scene.build()?),
        vec![Box::new(law)],
        solver,
        Settings::new(0.5, 1e-4),
        0.0,
        q,
        v,
    )?;
    println!("{:>8}  {:>9}  {:>9}  {:>5}  {:>11}", "t (s)", "u_N- (m/s)", "u_N+ (m/s)", "e", "work (J)");
    while scheme.state().time < 1.5 {
        let step = scheme.step()?.clone();
        for contact in step.contacts.iter().filter(|contact| contact.before[0] < -0.25) {
            let restitution = -contact.after[0] / contact.before[0];
            println!(
                "{:>8.4}  {:>10.5}  {:>10.5}  {restitution:>5.3}  {:>+11.4e}",
                scheme.state().time,
                contact.before[0],
                contact.after[0],
                contact.normal_work + contact.tangential_work
            );
        }
    }
    Ok(())
}
