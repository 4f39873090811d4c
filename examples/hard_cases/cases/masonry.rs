//! Masonry: the semicircular arch, the rocking block.

use nonsmooth::scalar::{Scalar, lit, to_f64};
use nonsmooth::system::{RigidBodies, polygon_body};

use super::support::{
    Case, Choice, Law, Outcome, Scheme, drive, fastest, law, scheme, scheme_of, solver, theta,
};

pub(crate) const CASES: &[Case] = &[
    Case {
        name: "semicircular arch of voussoirs",
        number: "stands at t/R = 0.12, falls at t/R = 0.10 (limit 0.1075, Milankovitch), μ large",
        about: "27 voussoirs (polygons) of mean radius 1 m on a plane, μ = 5, e = 0, h = 1e-3 s, 2 s from rest, \
                `predicted-gap` with a gap tolerance of 1 µm, solver tolerance 1e-8, warm-started.",
        peer: "limits of t/R: Milankovitch (1907) 0.1075; Couplet and Heyman 0.106",
        runs: &[("f64", arch_case)],
    },
    Case {
        name: "rocking block, Housner",
        number: "angular velocity ratio 1 − 1.5 sin²α (e = 0, no slip, no bounce)",
        about: "rectangle 1 m × 4 m (tan α = ¼), μ = 5. Impact alone: one step without gravity from rotation about one \
                corner. Rocking: released at 0.9 α with gravity, h = 1e-5 s.",
        peer: "Housner (1963), 1 − 1.5 sin²α = 0.911765",
        runs: &[("f64", rocking)],
    },
];

const G: f64 = 9.81;

/// A semicircular arch of mean radius 1 and thickness `thickness`, of `voussoirs` equal stones.
pub(crate) fn arch<T: Scalar>(
    choice: &Choice<'_>,
    thickness: f64,
    voussoirs: usize,
    h: f64,
    tolerance: f64,
) -> Result<Scheme<T, 2>, String> {
    let mut builder = RigidBodies::<T>::builder();
    let (stone, ground) = (builder.group(), builder.group());
    let (inner, outer) = (1.0 - 0.5 * thickness, 1.0 + 0.5 * thickness);
    let mut q = Vec::new();
    for i in 0..voussoirs {
        let angle = |k: usize| std::f64::consts::PI * k as f64 / voussoirs as f64;
        let at = |radius: f64, k: usize| {
            // The springings on the ground to the last digit.
            let sin = if k == 0 || k == voussoirs { 0.0 } else { angle(k).sin() };
            [radius * angle(k).cos(), radius * sin].map(lit::<T>)
        };
        let corners = [at(inner, i), at(outer, i), at(outer, i + 1), at(inner, i + 1)];
        let (body, vertices, centre) = polygon_body(lit(1000.0), &corners).expect("a voussoir");
        let name = format!("voussoir {i}");
        let body = builder.body(&name, body).expect("positive");
        builder.polygon(&name, body, &vertices, stone).expect("convex");
        q.extend([centre[0], centre[1], lit(0.0)]);
    }
    builder.half_plane("ground", [lit(0.0); 2], [lit(0.0), lit(1.0)], ground).expect("a plane");
    builder.interface(stone, stone).expect("a group");
    builder.interface(stone, ground).expect("two groups");
    builder.gravity([lit(0.0), lit(-G)]).expect("finite");
    let v = vec![lit(0.0); 3 * voussoirs];
    let system = builder.build().expect("bodies");
    let laws: Vec<Law<T, 2>> = (0..2).map(|_| law(choice, 0.0, 5.0)).collect();
    // Faces a micrometre apart still touch: were the tolerance of rounding, a stone whose joint opened by 1e-11 m would
    // fall freely for a step, and the thrust with it.
    let theta = to_f64(theta(&*laws[0]));
    scheme_of(system, laws, solver(choice, tolerance), (theta, h), (Some(1e-6), false), (q, v))
}

/// Voussoirs of the case: odd, so that the crown is a stone's middle, and enough that hinges find their place.
pub(crate) const VOUSSOIRS: usize = 27;

fn arch_case(choice: &Choice<'_>) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    let steps = if choice.full { 2000 } else { 150 };
    for thickness in [0.12, 0.10] {
        let mut scheme = arch::<f64>(choice, thickness, VOUSSOIRS, 1e-3, 1e-8)?;
        let start = scheme.state().q.clone();
        drive(&mut scheme, steps, &mut outcome, |_| ())?;
        let state = scheme.state();
        let moved = state.q.iter().zip(&start).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        if thickness > 0.11 {
            // The faces' tolerance is all it may use up.
            outcome.small("t/R = 0.12: moved (m)", moved, 1e-6);
            outcome.small("t/R = 0.12: speed at the end (m/s)", fastest(&state.v), 1e-6);
        } else if choice.full {
            outcome.at_least("t/R = 0.10: moved (m)", moved, 0.1);
        } else {
            // In its first moments it has only begun to fall.
            outcome.at_least("t/R = 0.10: moved (m)", moved, 1e-5);
        }
    }
    Ok(outcome)
}

/// A block of 1 m × 4 m at `angle`, turning at `spin` about its corner on the ground: the right one for angle ≤ 0.
fn block(
    choice: &Choice<'_>,
    (width, height): (f64, f64),
    angle: f64,
    spin: f64,
    gravity: f64,
    h: f64,
) -> Result<Scheme<f64, 2>, String> {
    let mut builder = RigidBodies::<f64>::builder();
    let (stone, ground) = (builder.group(), builder.group());
    let (a, b) = (0.5 * width, 0.5 * height);
    let (body, vertices, _) = polygon_body(1.0, &[[-a, -b], [a, -b], [a, b], [-a, b]]).expect("a rectangle");
    let body = builder.body("block", body).expect("positive");
    builder.polygon("block", body, &vertices, stone).expect("convex");
    builder.half_plane("ground", [0.0; 2], [0.0, 1.0], ground).expect("a plane");
    builder.interface(stone, ground).expect("two groups");
    builder.gravity([0.0, -gravity]).expect("finite");
    // About the right corner (a, −b), at the origin: G − P = R (−a, b).
    let (sin, cos) = angle.sin_cos();
    let arm = [-a * cos - b * sin, -a * sin + b * cos];
    let q = vec![arm[0], arm[1], angle];
    let v = vec![-spin * arm[1], spin * arm[0], spin];
    let mut choice = *choice;
    choice.full = true;
    scheme::<f64, 2, _>(&choice, builder.build().expect("a body"), (0.0, 5.0), h, 1e-13, q, v)
}

fn rocking(choice: &Choice<'_>) -> Result<Outcome, String> {
    let size: (f64, f64) = (1.0, 4.0);
    let alpha = (size.0 / size.1).atan();
    let ratio = 1.0 - 1.5 * alpha.sin().powi(2);
    let mut outcome = Outcome::default();
    // Flat on the ground, rotating about the right corner so that the left one comes down: ω > 0.
    let mut impact = block(choice, size, 0.0, 1.0, 0.0, 1e-6)?;
    drive(&mut impact, 1, &mut outcome, |_| ())?;
    outcome.near("ω⁺/ω⁻, impact alone", impact.state().v[2], ratio, 1e-12);
    let lifted = {
        let v = &impact.state().v;
        // Velocity of the corner it stood on: it must leave the ground for the ratio to hold.
        v[1] + v[2] * 0.5 * size.0
    };
    outcome.at_least("the other corner lifts (m/s)", lifted, 0.1);

    let h = if choice.full { 1e-5 } else { 1e-4 };
    let mut rocking = block(choice, size, -0.9 * alpha, 0.0, G, h)?;
    let (mut before, mut found) = (0.0_f64, None);
    drive(&mut rocking, (2.5 / h) as usize, &mut outcome, |scheme| {
        let state = scheme.state();
        let spin = state.v[2];
        if found.is_none() && before > 0.1 && spin < before * 0.99 {
            found = Some(spin / before);
        }
        before = spin;
    })?;
    let found = found.ok_or("the block never came down")?;
    // ω and the impact's place are off by O(h): g h / r against ω ~ 1.
    outcome.near(format!("ω⁺/ω⁻, rocking, h = {h:e}"), found, ratio, 100.0 * h);
    Ok(outcome)
}
