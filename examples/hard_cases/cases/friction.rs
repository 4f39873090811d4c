//! Friction: slide to roll, the block on an incline.

use nalgebra::Vector3;
use nonsmooth::linalg::Symmetric;
use nonsmooth::scalar::{Scalar, lit, to_f64};
use nonsmooth::system::{Body, Forces, Lagrangian, RigidBodies, SmoothGap, polygon_body};

use super::support::{Case, Choice, Outcome, drive, fastest, scheme};

pub(crate) const CASES: &[Case] = &[
    Case {
        name: "disc and sphere, slide → roll",
        number: "disc v = 2v₀/3 at v₀/(3μg); sphere 5v₀/7 at 2v₀/(7μg)",
        about: "v₀ = 1 m/s, μ = 0.2, g = 9.81 m/s², e = 0. The disc is a planar body (D = 2), the sphere a Lagrangian \
                system with six velocities (D = 3). v is that of the middle of the step, v_{k+θ}: under Frémond's law \
                at θ = ½ the slip of the last sliding step alternates in v_{k+1}.",
        peer: "closed form",
        runs: &[("f64", rolling::<f64>), ("f32", rolling::<f32>)],
    },
    Case {
        name: "block on an incline",
        number: "sticks exactly (‖v‖ ≤ 1e-12) iff tan a ≤ μ, else a = g(sin a − μ cos a)",
        about: "polygon 1 m × ½ m, μ = ½, tan a = μ/2, μ(1 − 1e-6), μ(1 + 1e-6), 3μ/2; e = 0, h = 1e-3 s, 1 s; \
                `predicted-gap`.",
        peer: "closed form",
        runs: &[("f64", incline::<f64>), ("f32", incline::<f32>)],
    },
];

const MU: f64 = 0.2;
const G: f64 = 9.81;

/// Time of the first step that does not slide, and v_{k+θ} at the end.
fn measure<T: Scalar, const D: usize>(
    mut scheme: super::support::Scheme<T, D>,
    steps: usize,
    outcome: &mut Outcome,
) -> Result<(f64, f64), String> {
    let (mut rolls, mut middle, mut before) = (None, 0.0, 1.0);
    let theta = to_f64(scheme.settings().theta);
    drive(&mut scheme, steps, outcome, |scheme| {
        let state = scheme.state();
        let v = to_f64(state.v[0]);
        middle = (1.0 - theta) * before + theta * v;
        before = v;
        let slides = scheme.last_step().contacts.iter().any(|contact| {
            let tangential = contact.percussion.rows(1, D - 1).norm();
            tangential >= contact.percussion[0] * lit::<T>(MU * (1.0 - 1e-5))
        });
        if !slides && rolls.is_none() {
            rolls = Some(to_f64(state.time));
        }
    })?;
    rolls.map(|rolls| (rolls, middle)).ok_or_else(|| "it never rolls".into())
}

fn rolling<T: Scalar>(choice: &Choice<'_>) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    let single = T::NAME == "f32";
    let h = if choice.full && !single { 1e-5 } else { 1e-4 };
    let tolerance = if single { 1e-5 } else { 1e-12 };
    let mut builder = RigidBodies::<T>::builder();
    let (disc, floor) = (builder.group(), builder.group());
    let body = builder.body("disc", Body { mass: lit(1.0), inertia: lit(0.5) }).expect("positive");
    builder.disc("disc", body, [lit(0.0); 2], lit(1.0), disc).expect("a disc");
    builder.half_plane("floor", [lit(0.0); 2], [lit(0.0), lit(1.0)], floor).expect("a plane");
    builder.interface(disc, floor).expect("two groups");
    builder.gravity([lit(0.0), lit(-G)]).expect("finite");
    let (q, v) = (vec![lit(0.0), lit(1.0), lit(0.0)], vec![lit(1.0), lit(0.0), lit(0.0)]);
    let system = builder.build().expect("a body");
    let planar = scheme::<T, 2, _>(choice, system, (0.0, MU), h, tolerance, q, v)?;
    let (time, speed) = measure(planar, (0.4 / h) as usize, &mut outcome)?;
    // The speed changes by 3μgh within the step in which sliding ends.
    let rounding = if single { 2e-4 } else { 0.0 };
    outcome.near("disc: rolls from (s)", time, 1.0 / (3.0 * MU * G), 2.0 * h);
    outcome.near("disc: v (m/s)", speed, 2.0 / 3.0, 3.0 * MU * G * h + rounding);

    let inertia = 0.4;
    let mass = Symmetric::diagonal([1.0, 1.0, 1.0, inertia, inertia, inertia].map(lit::<T>).to_vec());
    let weight = Forces::constant([0.0, 0.0, -G, 0.0, 0.0, 0.0].map(lit::<T>).to_vec());
    // Contact at −z: u_N = ż, u_T1 = ẋ − ω_y, u_T2 = ẏ + ω_x (radius 1).
    let gap = SmoothGap::new(
        |q: &[T]| q[2] - lit::<T>(1.0),
        |_, push| {
            push(2, Vector3::x());
            push(0, Vector3::y());
            push(4, -Vector3::y());
            push(1, Vector3::z());
            push(3, Vector3::z());
        },
    );
    let system = Lagrangian::<T, 3>::new(mass.expect("finite")).with_forces(weight).expect("six forces");
    let system = system.with_contact(0, gap).with_scales(lit(1.0), lit(1.0));
    let mut q = vec![lit::<T>(0.0); 6];
    q[2] = lit(1.0);
    let mut v = vec![lit::<T>(0.0); 6];
    v[0] = lit(1.0);
    let sphere = scheme::<T, 3, _>(choice, system, (0.0, MU), h, tolerance, q, v)?;
    let (time, speed) = measure(sphere, (0.4 / h) as usize, &mut outcome)?;
    outcome.near("sphere: rolls from (s)", time, 2.0 / (7.0 * MU * G), 2.0 * h);
    outcome.near("sphere: v (m/s)", speed, 5.0 / 7.0, 3.5 * MU * G * h + rounding);
    Ok(outcome)
}

fn incline<T: Scalar>(choice: &Choice<'_>) -> Result<Outcome, String> {
    let (mu, h) = (0.5, 1e-3);
    let single = T::NAME == "f32";
    let tolerance = if single { 1e-6 } else { 1e-13 };
    let mut outcome = Outcome::default();
    let near = if single { 1e-3 } else { 1e-6 };
    for tangent in [0.5 * mu, mu * (1.0 - near), mu * (1.0 + near), 1.5 * mu] {
        let a = f64::atan(tangent);
        let mut builder = RigidBodies::<T>::builder();
        let (block, slope) = (builder.group(), builder.group());
        let corners = [[-0.5, -0.25], [0.5, -0.25], [0.5, 0.25], [-0.5, 0.25]].map(|x| x.map(lit::<T>));
        let (body, vertices, _) = polygon_body(lit(1.0), &corners).expect("a rectangle");
        let body = builder.body("block", body).expect("positive");
        builder.polygon("block", body, &vertices, block).expect("convex");
        builder.half_plane("slope", [lit(0.0); 2], [-a.sin(), a.cos()].map(lit), slope).expect("a plane");
        builder.interface(block, slope).expect("two groups");
        builder.gravity([lit(0.0), lit(-G)]).expect("finite");
        let q = [-0.25 * a.sin(), 0.25 * a.cos(), a].map(lit::<T>).to_vec();
        let system = builder.build().expect("a body");
        let mut scheme = scheme::<T, 2, _>(choice, system, (0.0, mu), h, tolerance, q, vec![lit(0.0); 3])?;
        let mut largest = 0.0_f64;
        drive(&mut scheme, 1000, &mut outcome, |scheme| {
            largest = largest.max(fastest(&scheme.state().v));
        })?;
        let v = &scheme.state().v;
        let down = -(to_f64(v[0]) * a.cos() + to_f64(v[1]) * a.sin());
        let ratio = tangent / mu;
        if tangent <= mu {
            let bound = if single { 1e-6 } else { 1e-12 };
            outcome.small(format!("‖v‖∞, tan a = {ratio} μ (m/s)"), largest, bound);
        } else {
            let exact = G * (a.sin() - mu * a.cos());
            // The solver's tolerance on velocities of 1e-2 m/s, a thousand times.
            let bound = if single { 2e-3 } else { 1e-10 };
            outcome.near(format!("acceleration, tan a = {ratio} μ (m/s²)"), down, exact, bound);
        }
    }
    Ok(outcome)
}
