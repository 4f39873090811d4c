//! Single impacts with friction, to the last digit published: the exact rod, Kane's double pendulum, the Painlevé rod,
//! and how often random rods gain energy.

#[path = "mechanics/impact.rs"]
mod impact;
#[path = "../examples/kane.rs"]
mod kane;
#[path = "mechanics/stream.rs"]
mod stream;

use impact::{Impact, impact, law, solver, try_impact};
use kane::Pendulum;
use nalgebra::{Matrix2, Vector2};
use nonsmooth::cone::{BlockMatrix, ConeProblem, Status, status};
use nonsmooth::solver::{ConeSolver, SOLVERS, SolveError};
use stream::Stream;

/// W of a slender rod, m = l = 1, at the angle γ from the upright: I = 1/12, levers (½ sin γ, ½ cos γ).
fn rod(gamma: f64) -> Matrix2<f64> {
    let (sin, cos) = gamma.sin_cos();
    Matrix2::new(1.0 + 3.0 * sin * sin, 3.0 * sin * cos, 3.0 * sin * cos, 1.0 + 3.0 * cos * cos)
}

/// u = (N, T) of the tip of that rod with velocity (ẋ, ẏ, γ̇).
fn tip(gamma: f64, v: [f64; 3]) -> Vector2<f64> {
    Vector2::new(v[1] + 0.5 * gamma.sin() * v[2], v[0] + 0.5 * gamma.cos() * v[2])
}

/// |x − y| ≤ 3e-13: the solvers stop at 2e-14 ‖b‖ with ‖b‖ ≤ 2.3, which the condition of W, at most 6, magnifies.
fn assert_close(what: &str, x: f64, y: f64) {
    assert!((x - y).abs() <= 3e-13, "{what}: {x:.17e}, exact {y:.17e}");
}

#[test]
fn newton_lifts_the_energy_of_the_exact_rod_where_fremond_keeps_it() {
    // All four stick: W p is (1 + e, 0.6) with Newton and (1 + e, 1.2) with Frémond.
    let cases = [
        ("newton", 1.0, [1.025, -0.375], 0.1125),
        ("fremond", 1.0, [0.8, 0.0], 0.0),
        ("newton", 0.9, [0.9625, -0.3375], 0.053125),
        ("fremond", 0.9, [0.7375, 0.0375], -0.036875),
    ];
    let gamma = std::f64::consts::FRAC_PI_4;
    let (w, before) = (rod(gamma), tip(gamma, [-0.6, -1.0, 0.0]));
    for (name, e, [normal, tangential], energy) in cases {
        for description in SOLVERS {
            let place = format!("{name}, e = {e}, {}", description.name);
            let rod = impact(&w, &before, &*law(name, e, 0.5), 0.5, &mut *solver(description.name));
            assert_close(&format!("{place}: p_N"), rod.percussion[0], normal);
            assert_close(&format!("{place}: p_T"), rod.percussion[1], tangential);
            assert_close(&format!("{place}: ΔE"), rod.energy_change, energy);
        }
    }
}

/// Newton can create energy only if e > √(1 − W_NT²/(W_NN W_TT)), which is 0.8 for W_NT²/(W_NN W_TT) = 0.36.
#[test]
fn newton_creates_energy_only_above_the_threshold_of_restitution() {
    let gamma = std::f64::consts::FRAC_PI_4;
    let w = rod(gamma);
    let threshold = (1.0 - w[(0, 1)] * w[(0, 1)] / (w[(0, 0)] * w[(1, 1)])).sqrt();
    assert_close("threshold", threshold, 0.8);
    // The worst over slip before the impact and friction.
    let worst = |e: f64| {
        let cases =
            (-400..=400).flat_map(|i| (0..=40).map(move |j| (f64::from(i) / 100.0, f64::from(j) / 10.0)));
        let energy = |(slip, friction): (f64, f64)| {
            let before = Vector2::new(-1.0, slip);
            let mut nsgs = solver("nsgs");
            impact(&w, &before, &*law("newton", e, friction), 0.5, &mut *nsgs).energy_change
        };
        cases.map(energy).fold(f64::NEG_INFINITY, f64::max)
    };
    for e in [0.0, 0.3, 0.6, 0.75, 0.79, 0.8] {
        assert!(worst(e) <= 64.0 * f64::EPSILON, "e = {e}: {}", worst(e));
    }
    for e in [0.81, 0.85, 0.9, 1.0] {
        assert!(worst(e) > 1e-3, "e = {e}: {}", worst(e));
    }
}

#[test]
fn kanes_pendulum_gains_energy_with_newton_and_loses_it_with_fremond() {
    let pendulum = Pendulum::at_the_impact();
    assert_close("E⁻", pendulum.energy(), 0.02318141086346);
    // 13 digits printed; percussions of this size round to 1e-12 relative.
    let close = |what: &str, x: f64, y: f64| {
        assert!((x - y).abs() <= 1e-12 * y.abs(), "{what}: {x:.13e}, published {y:.13e}");
    };
    for description in SOLVERS {
        let mut solver = solver(description.name);
        let mut run = |name: &str, e: f64, mu: f64| {
            kane::impact(&pendulum, &*law(name, e, mu), &mut *solver).expect("one contact")
        };
        for (name, e, mu, energy) in kane::PUBLISHED {
            let outcome = run(name, e, mu);
            close(&format!("{name}, e = {e}, {}: ΔE", description.name), outcome.work.sum(), energy);
            close("u_N⁺ = −e u_N⁻", outcome.after[0], -e * pendulum.before()[0]);
        }
        let newton = run("newton", 0.5, 0.5);
        assert_eq!(newton.status, Status::Stick);
        close("p_N", newton.percussion[0], 0.5679798804836);
        close("p_T", newton.percussion[1], -0.2445965910226);
        let fremond = run("fremond", 0.5, 0.5);
        assert_eq!(fremond.status, Status::Slide);
        close("p_N", fremond.percussion[0], 0.1137167320167);
        close("p_T", fremond.percussion[1], 0.05685836600836);
        assert_eq!(run("newton", 0.7, 0.5).status, Status::Slide);
    }
}

#[test]
fn the_example_of_kanes_pendulum_runs() {
    kane::main().expect("the example runs");
}

/// Solvers that follow the residual downhill: at rest it is 4e-4 of the solution's, and they may end there. They must
/// then say so.
const FIRST_ORDER: [&str; 2] = ["admm", "extragradient"];

/// Painlevé's rod: tan γ = ½, μ = 2 > W_NN/W_NT = 4/3, sliding at u_T = 1 under g = 10 over a step h = 1e-4.
#[test]
fn the_painleve_rod_sticks_without_collision() {
    let w = rod(0.5_f64.atan());
    assert_close("W_NN", w[(0, 0)], 1.6);
    assert_close("W_NT", w[(0, 1)], 1.2);
    assert_close("W_TT", w[(1, 1)], 3.4);
    let (before, free) = (Vector2::new(0.0, 1.0), Vector2::new(-10.0 * 1e-4, 1.0));
    // u_N⁻ = 0, so e plays no part. b_N < 0: the solution is unique, and it is stick.
    let cases = [("newton", [0.30085, -0.4003], 0.0, -0.20015), ("fremond", [0.60085, -0.8003], -1.0, 0.0)];
    for (name, percussion, slip, work) in cases {
        for description in SOLVERS {
            let place = format!("{name}, {}", description.name);
            let law = law(name, 0.5, 2.0);
            let rod = match try_impact(&w, &before, &free, &*law, 0.5, &mut *solver(description.name)) {
                Ok(rod) => rod,
                Err(SolveError::NotConverged { .. }) if FIRST_ORDER.contains(&description.name) => continue,
                Err(error) => panic!("{place}: {error}"),
            };
            assert_eq!(status(&rod.percussion, 2.0, 1e-9), Status::Stick, "{place}");
            assert_close(&format!("{place}: p_N"), rod.percussion[0], percussion[0]);
            assert_close(&format!("{place}: p_T"), rod.percussion[1], percussion[1]);
            assert_close(&format!("{place}: u_N⁺"), rod.after[0], 0.0);
            assert_close(&format!("{place}: u_T⁺"), rod.after[1], slip);
            assert_close(&format!("{place}: work"), rod.work.sum(), work);
        }
    }
}

/// Where the free motion opens the Painlevé rod (b_N > 0), take-off, sliding and stick all solve the cone problem;
/// every solver takes the one without percussion.
#[test]
fn of_three_painleve_solutions_the_rod_takes_off() {
    let (w, mu) = (rod(0.5_f64.atan()), 2.0);
    let b = Vector2::new(1e-3, 1.0);
    let blocks = BlockMatrix::from_fn(1, |_, _| w);
    let problem = ConeProblem::new(blocks, vec![b], vec![mu]).expect("W is positive definite");
    let slide = b[0] / (mu * w[(0, 1)] - w[(0, 0)]);
    let solutions =
        [Vector2::zeros(), Vector2::new(slide, -mu * slide), -w.try_inverse().expect("W ≻ 0") * b];
    for (solution, kind) in solutions.iter().zip([Status::TakeOff, Status::Slide, Status::Stick]) {
        let residual = problem.residual(&[*solution]).scaled;
        assert!(residual <= 16.0 * f64::EPSILON, "{kind:?}: {residual:e}");
        assert_eq!(status(solution, mu, 1e-9), kind);
    }
    for description in SOLVERS {
        for start in solutions {
            let mut p = [start];
            solver(description.name).solve(&problem, &[start], &mut p).expect("three solutions");
            assert_eq!(p, [Vector2::zeros()], "{}", description.name);
        }
    }
}

/// A slender rod at an impact, drawn at random: γ uniform in [0, π/2], each of ẋ, ẏ, γ̇ uniform in [−1, 1] (m = l = 1),
/// kept where the tip approaches the floor; e uniform in [0, 1], μ in [0, 2].
struct RandomRod {
    w: Matrix2<f64>,
    before: Vector2<f64>,
    restitution: f64,
    friction: f64,
    share: f64,
}

impl RandomRod {
    fn draw(stream: &mut Stream) -> Self {
        let (gamma, before) = loop {
            let gamma = stream.uniform(0.0, std::f64::consts::FRAC_PI_2);
            let before = tip(gamma, std::array::from_fn(|_| stream.uniform(-1.0, 1.0)));
            if before[0] < 0.0 {
                break (gamma, before);
            }
        };
        let (restitution, friction) = (stream.uniform(0.0, 1.0), stream.uniform(0.0, 2.0));
        Self { w: rod(gamma), before, restitution, friction, share: stream.uniform(0.0, 1.0) }
    }

    fn impact(&self, name: &str, theta: f64, solver: &mut dyn ConeSolver<f64, 2>) -> Impact {
        let law = law(name, self.restitution, self.friction);
        impact(&self.w, &self.before, &*law, theta, solver)
    }

    /// What is more than rounding, against the energy 2 u⁻·W⁻¹u⁻ that the impact may turn over.
    fn positive(&self, work: f64) -> bool {
        let mobility = self.w[(0, 0)] + self.w[(1, 1)];
        work > 1e-13 * self.before.norm_squared() * (1.0 + mobility)
    }
}

/// Take-off, stick and the two slides that solve the cone problem of one planar contact.
fn solutions(w: &Matrix2<f64>, b: &Vector2<f64>, mu: f64) -> usize {
    let stick = -w.try_inverse().expect("W ≻ 0") * b;
    let slides = [-mu, mu].into_iter().filter(|side| {
        let normal = -b[0] / (w[(0, 0)] + side * w[(0, 1)]);
        let slip = b[1] + (w[(0, 1)] + side * w[(1, 1)]) * normal;
        normal > 0.0 && slip * side < 0.0
    });
    usize::from(b[0] >= 0.0) + usize::from(stick[1].abs() <= mu * stick[0]) + slides.count()
}

#[test]
fn a_rod_has_one_solution_or_in_painleves_case_three() {
    const DRAWS: usize = 100_000;
    let (mut stream, mut three) = (Stream(1895), 0);
    for _ in 0..DRAWS {
        let RandomRod { w, before, friction, .. } = RandomRod::draw(&mut stream);
        // The free motion may open the contact as well as close it.
        let b = Vector2::new(before[0] * stream.uniform(-1.0, 1.0), before[1]);
        let count = solutions(&w, &b, friction);
        let painleve = b[0] >= 0.0 && w[(0, 0)] <= friction * w[(0, 1)].abs();
        assert!(count == 1 || (count == 3 && painleve), "{count} solutions: W {w} b {b} μ {friction}");
        three += usize::from(count == 3);
    }
    assert!(three > DRAWS / 1000, "{three} of {DRAWS} have three solutions");
}

/// `count` of `draws` agrees with a published fraction that is exact to `digit`: 5 σ of the binomial distribution.
fn assert_fraction(what: &str, count: usize, draws: usize, fraction: f64, digit: f64) {
    let n = draws as f64;
    let bound = 5.0 * (n * fraction * (1.0 - fraction)).sqrt() + n * digit;
    let miss = count as f64 - n * fraction;
    assert!(miss.abs() <= bound, "{what}: {count} of {draws}, published {fraction}, bound ±{bound:.1}");
}

#[test]
fn random_rods_gain_energy_as_often_as_published() {
    const DRAWS: usize = 100_000;
    let (mut stream, mut solver) = (Stream(2024), solver("nsgs"));
    let mut count = [0; 8];
    for _ in 0..DRAWS {
        let rod = RandomRod::draw(&mut stream);
        let newton = rod.impact("newton", 0.5, &mut *solver);
        let theta = 0.5 + rod.share * (1.0 / (1.0 + rod.restitution) - 0.5);
        let proved = rod.impact("fremond", theta, &mut *solver);
        let mut fremond = |theta: f64| rod.impact("fremond", theta, &mut *solver);
        let (above, one) = (fremond(0.55), fremond(1.0));
        let (quarter, below) = (fremond(0.25), fremond(0.4));
        let events = [
            newton.energy_change,
            newton.work[1],
            proved.energy_change,
            proved.work.sum(),
            above.work.sum(),
            one.work.sum(),
            quarter.energy_change,
            below.energy_change,
        ];
        events.iter().zip(&mut count).for_each(|(&work, count)| *count += usize::from(rod.positive(work)));
        let contact_work = quarter.work.sum().max(below.work.sum());
        assert!(!rod.positive(contact_work), "below ½ e* > e, and contact work stays negative");
    }
    assert_fraction("Newton creates energy", count[0], DRAWS, 0.017234, 0.5e-6);
    assert_fraction("Newton's tangential work is positive", count[1], DRAWS, 0.1568, 0.5e-4);
    assert_eq!(count[2..4], [0, 0], "Frémond with θ in [½, 1/(1+e)] creates energy, or contact work");
    assert_fraction("Frémond's contact work is positive at θ = 0.55", count[4], DRAWS, 0.093, 0.5e-3);
    assert_fraction("Frémond's contact work is positive at θ = 1", count[5], DRAWS, 0.72, 0.5e-2);
    // The energy grows by (½−θ)‖v_{k+1}−v_k‖²_M alone.
    assert_fraction("Frémond's energy grows at θ = 0.25", count[6], DRAWS, 0.21, 0.5e-2);
    assert_fraction("Frémond's energy grows at θ = 0.4", count[7], DRAWS, 0.10, 0.5e-2);
}
