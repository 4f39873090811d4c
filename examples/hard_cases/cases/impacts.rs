//! Impacts: the bouncing ball, three balls, the Painlevé rod.

use nalgebra::{Matrix2, Vector2};
use nonsmooth::cone::{BlockMatrix, ConeProblem, Status, status};
use nonsmooth::contact::pose;
use nonsmooth::laws::Approach;
use nonsmooth::scalar::{Scalar, lit, to_f64};
use nonsmooth::system::{Body, RigidBodies};

use super::support::{Case, Choice, Outcome, drive, fastest, law, numbers, scheme, solver};

pub(crate) const CASES: &[Case] = &[
    Case {
        name: "bouncing ball, Zeno",
        number: "rest at √(2h/g)(1+e)/(1−e) = 1.341640786 s, then exactly at rest",
        about: "drop height 1 m, e = ½, g = 10 m/s²; D = 1, `predicted-gap`. Rest counts from the last time the speed \
                exceeds 4gh; each of the log₂ impacts is placed within 4h, so that the error is first order in h.",
        peer: "closed form",
        runs: &[("f64", zeno::<f64>), ("f32", zeno::<f32>)],
    },
    Case {
        name: "three touching balls, e = 1",
        number: "v = (−1/3, 2/3, 2/3) v₀",
        about: "equal discs in touch, hit from the left, one step; D = 1.",
        peer: "closed form",
        runs: &[("f64", balls::<f64>), ("f32", balls::<f32>)],
    },
    Case {
        name: "Painlevé rod around μ_crit",
        number: "a solution at every step, μ from ½ to 2 μ_crit(α), α = 30°…75°; in the inconsistent case the impact \
                 without collision p = −W⁻¹b",
        about: "rod sliding on its tip, both directions, 0.1 s of h = 1e-4 s each. Inconsistent case: the unique \
                solution is stick. Three solutions (b_N > 0): take-off, as `ConeSolver::solve` tests it first.",
        peer: "Painlevé (1895), least μ_crit 4/3; census of 200,000 planar contacts: 1 or 3 solutions, never 0",
        runs: &[("f64", painleve::<f64>), ("f32", painleve::<f32>)],
    },
];

fn zeno<T: Scalar>(choice: &Choice<'_>) -> Result<Outcome, String> {
    let (g, e) = (10.0, 0.5);
    let single = T::NAME == "f32";
    let h: f64 = if single {
        1e-3
    } else if choice.full {
        1e-5
    } else {
        1e-4
    };
    let mut builder = RigidBodies::<T>::builder();
    let (ball, floor) = (builder.group(), builder.group());
    let body = builder.body("ball", Body { mass: lit(1.0), inertia: lit(1.0) }).expect("positive");
    builder.disc("ball", body, [lit(0.0); 2], lit(0.0), ball).expect("a point");
    builder.half_plane("floor", [lit(0.0); 2], [lit(0.0), lit(1.0)], floor).expect("a plane");
    builder.interface(ball, floor).expect("two groups");
    builder.gravity([lit(0.0), lit(-g)]).expect("finite");
    let (q, v) = (vec![lit(0.0), lit(1.0), lit(0.0)], vec![lit(0.0); 3]);
    let system = builder.build().expect("a body");
    let mut scheme = scheme::<T, 1, _>(choice, system, (e, 0.0), h, 1e-12, q, v)?;
    let mut outcome = Outcome::default();
    let (mut last_fast, mut rest_speed, mut heights) = (0.0, 0.0_f64, Vec::new());
    drive(&mut scheme, (2.0 / h).round() as usize, &mut outcome, |scheme| {
        let state = scheme.state();
        let (time, speed) = (to_f64(state.time), fastest(&state.v));
        if speed > 4.0 * g * h {
            last_fast = time;
        }
        if time > 1.6 {
            rest_speed = rest_speed.max(speed);
            heights.push(to_f64(state.q[1]));
        }
    })?;
    let exact = (2.0 / g).sqrt() * (1.0 + e) / (1.0 - e);
    let bounces = ((2.0 / g).sqrt() / h).log2();
    outcome.near(format!("time of rest (s), h = {h:e}"), last_fast, exact, (4.0 * bounces + 8.0) * h);
    outcome.small("largest speed at rest (m/s)", rest_speed, if single { 1e-6 } else { 1e-12 });
    let creep = heights[heights.len() - 1] - heights[0];
    outcome.small("creep over 0.4 s (m)", creep, if single { 1e-6 } else { 1e-12 });
    Ok(outcome)
}

fn balls<T: Scalar>(choice: &Choice<'_>) -> Result<Outcome, String> {
    let mut builder = RigidBodies::<T>::builder();
    let group = builder.group();
    builder.interface(group, group).expect("a group");
    let mut q = Vec::new();
    for i in 0..3 {
        let name = format!("ball {i}");
        let body = builder.body(&name, Body { mass: lit(1.0), inertia: lit(1.0) }).expect("positive");
        builder.disc(&name, body, [lit(0.0); 2], lit(0.5), group).expect("a disc");
        q.extend([f64::from(i), 0.0, 0.0].map(lit::<T>));
    }
    let mut v = vec![lit::<T>(0.0); 9];
    v[0] = lit(1.0);
    let system = builder.build().expect("bodies");
    let mut scheme = scheme::<T, 1, _>(choice, system, (1.0, 0.0), 1e-3, 1e-15, q, v)?;
    let mut outcome = Outcome::default();
    drive(&mut scheme, 1, &mut outcome, |_| ())?;
    let v = numbers(&scheme.state().v);
    let rounding = 1e3 * to_f64(nonsmooth::scalar::epsilon::<T>());
    for (i, expected) in [-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0].into_iter().enumerate() {
        outcome.near(format!("v{} / v₀", i + 1), v[3 * i], expected, rounding);
    }
    Ok(outcome)
}

/// A slender rod of unit mass and length on its tip, inclined by `alpha` to the horizontal, sliding at `speed`.
fn rod<T: Scalar>(
    choice: &Choice<'_>,
    alpha: f64,
    mu: f64,
    speed: f64,
) -> Result<super::support::Scheme<T, 2>, String> {
    let mut builder = RigidBodies::<T>::builder();
    let (tip, floor) = (builder.group(), builder.group());
    let body = builder.body("rod", Body { mass: lit(1.0), inertia: lit(1.0 / 12.0) }).expect("positive");
    builder.disc("tip", body, [lit(0.0), lit(-0.5)], lit(0.0), tip).expect("a point");
    builder.half_plane("floor", [lit(0.0); 2], [lit(0.0), lit(1.0)], floor).expect("a plane");
    builder.interface(tip, floor).expect("two groups");
    builder.gravity([lit(0.0), lit(-10.0)]).expect("finite");
    let gamma = std::f64::consts::FRAC_PI_2 - alpha;
    let q = [0.0, 0.5 * gamma.cos(), gamma].map(lit).to_vec();
    let v = [speed, 0.0, 0.0].map(lit).to_vec();
    let tolerance = if T::NAME == "f32" { 1e-5 } else { 1e-12 };
    scheme::<T, 2, _>(choice, builder.build().expect("a body"), (0.0, mu), 1e-4, tolerance, q, v)
}

fn painleve<T: Scalar>(choice: &Choice<'_>) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    let single = T::NAME == "f32";
    let steps = if choice.full { 1000 } else { 200 };
    let (mut worst, mut failures, mut first) = (f64::MIN, 0, None);
    let tan_two = 2.0_f64.atan();
    for alpha in [30.0_f64.to_radians(), 45.0_f64.to_radians(), tan_two, 75.0_f64.to_radians()] {
        let critical = (1.0 + 3.0 * alpha.cos().powi(2)) / (3.0 * alpha.sin() * alpha.cos());
        for ratio in [0.5, 0.95, 1.0, 1.05, 2.0] {
            for speed in [1.0, -1.0] {
                let mut scheme = rod::<T>(choice, alpha, ratio * critical, speed)?;
                let run = drive(&mut scheme, steps, &mut outcome, |scheme| {
                    let balance = &scheme.last_step().balance;
                    let work = to_f64(balance.normal_contact_work + balance.tangential_contact_work);
                    worst = worst.max(work / 0.5);
                });
                if let Err(error) = run {
                    failures += 1;
                    first
                        .get_or_insert(format!("α = {alpha:.3}, μ = {ratio} μ_crit, u_T = {speed}: {error}"));
                }
            }
        }
    }
    outcome.near("runs of 40 with a step unsolved", f64::from(failures), 0.0, 0.0);
    outcome.notes.extend(first);
    if choice.law != "newton" {
        outcome.small("largest contact work / E", worst.max(0.0), if single { 1e-6 } else { 1e-13 });
    } else {
        outcome.note(format!("largest contact work / E = {worst:.3e}"));
    }
    // tan γ = ½, μ = 2: W = [[1.6, ±1.2], [±1.2, 3.4]], b = (−gh, u_T) + δ.
    for speed in [1.0, -1.0] {
        let mut scheme = rod::<T>(choice, tan_two, 2.0, speed)?;
        drive(&mut scheme, 1, &mut outcome, |_| ())?;
        let contact = scheme.last_step().contacts.first().ok_or("no contact")?;
        let [p_n, p_t] = [contact.percussion[0], contact.percussion[1]].map(to_f64);
        let before = Vector2::new(0.0, speed);
        let law = law::<f64, 2>(choice, 0.0, 2.0);
        let theta = super::support::theta(&*law);
        let free = Vector2::new(-1e-3, speed);
        let (b, _) = pose(&*law, &Approach::impact(before, theta), &free).map_err(|e| e.to_string())?;
        let w = Matrix2::new(1.6, 1.2, 1.2, 3.4);
        let stick = -w.try_inverse().expect("regular") * b;
        let bound = if single { 1e-5 } else { 1e-10 };
        if speed > 0.0 {
            outcome.near("p_N, inconsistent case (N s)", p_n, stick[0], bound);
            outcome.near("p_T, inconsistent case (N s)", p_t, stick[1], bound);
        } else {
            // Slides away from the paradox: p_N = gh/(W_NN + μ W_NT), p_T = μ p_N.
            outcome.near("p_N, sliding the other way (N s)", p_n, 1e-3 / (1.6 + 2.0 * 1.2), bound);
        }
    }
    // b_N > 0: take-off, stick and slide are all solutions.
    let w = Matrix2::new(1.6, 1.2, 1.2, 3.4).map(lit::<T>);
    let b = Vector2::new(lit(0.01), lit(1.0));
    let blocks = BlockMatrix::from_fn(1, |_, _| w);
    let problem = ConeProblem::new(blocks, vec![b], vec![lit::<T>(2.0)]).map_err(|e| e.to_string())?;
    let mut r = [Vector2::zeros()];
    let mut solver = solver::<T, 2>(choice, 1e-12);
    solver.solve(&problem, &[Vector2::zeros()], &mut r).map_err(|e| e.to_string())?;
    let chosen = status(&r[0], lit::<T>(2.0), lit(1e-5));
    outcome.near("take-off chosen of three solutions", f64::from(chosen == Status::TakeOff), 1.0, 0.0);
    Ok(outcome)
}
