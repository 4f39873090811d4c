//! Scenes whose motion is known: exact flights, slides and vibrations between events that are found to rounding.
#![allow(dead_code, reason = "the test and the bench use parts of it")]

mod bar;
mod oscillator;

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use nonsmooth::adaptive::{Adaptive, AdaptiveError, AdaptiveSettings, Report};
use nonsmooth::event_driven::Settings;
use nonsmooth::scene::{Scene, event_driven};
use nonsmooth::scheme::{State, Step, ThetaScheme};

use crate::example;

/// (q, v) at time t.
pub(crate) type Motion = Box<dyn Fn(f64, &mut [f64], &mut [f64])>;

/// A scene, a law, and the motion they make.
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) scene: Scene,
    pub(crate) law: &'static str,
    pub(crate) motion: Motion,
}

/// The cases without friction, and those with it.
pub(crate) struct Cases {
    pub(crate) frictionless: Vec<Case>,
    pub(crate) frictional: Vec<Case>,
}

/// The cases of one law: ball, two oscillators, bar; stick, disc, block on the incline.
pub(crate) fn cases(laws: &[&'static str]) -> Cases {
    let mut all = Cases { frictionless: Vec::new(), frictional: Vec::new() };
    for &law in laws {
        let case = |name: &str, motion: Motion| Case {
            name: format!("{name}, {law}"),
            scene: example::scene(name),
            law,
            motion,
        };
        let oscillators = ["impact_oscillator", "grazing_oscillator"];
        all.frictionless.push(case("bouncing_ball", Box::new(ball)));
        all.frictionless
            .extend(oscillators.map(|name| case(name, oscillator::motion(&example::scene(name)))));
        let scene = bar::scene();
        let motion = bar::motion(&scene);
        all.frictionless.push(Case { name: format!("bar, {law}"), scene, law, motion });
        all.frictional.push(case("impacting_stick", stick(law)));
        all.frictional.push(case("rolling_disc", Box::new(disc)));
        all.frictional.push(case("stick_slip", Box::new(incline)));
    }
    all
}

/// The ball of `examples/bouncing_ball.toml`: impact n + 1 follows impact n after 2 eⁿ t₁.
fn ball(time: f64, q: &mut [f64], v: &mut [f64]) {
    let (gravity, height, restitution): (f64, f64, f64) = (10.0, 1.0, 0.5);
    q.fill(0.0);
    v.fill(0.0);
    let first = (2.0 * height / gravity).sqrt();
    if time <= first {
        (q[1], v[1]) = (height - 0.5 * gravity * time * time, -gravity * time);
        return;
    }
    let (mut start, mut speed) = (first, gravity * first * restitution);
    while speed > 1e-14 {
        let flight = 2.0 * speed / gravity;
        let since = time - start;
        if since <= flight {
            (q[1], v[1]) = (since * (speed - 0.5 * gravity * since), speed - gravity * since);
            return;
        }
        (start, speed) = (start + flight, speed * restitution);
    }
}

/// The disc of `examples/rolling_disc.toml`: it slides until v₀/(3μg), then rolls at 2v₀/3.
fn disc(time: f64, q: &mut [f64], v: &mut [f64]) {
    let (speed, friction, gravity, radius) = (1.0, 0.2, 10.0, 0.1);
    let braking = friction * gravity;
    let rolls = speed / (3.0 * braking);
    let sliding = time.min(rolls);
    v[0] = speed - braking * sliding;
    // I = m r²/2: the spin grows twice as fast, negative to the right.
    v[2] = -2.0 * braking * sliding / radius;
    q[0] = sliding * (speed - 0.5 * braking * sliding) + v[0] * (time - sliding);
    q[2] = -braking * sliding * sliding / radius + v[2] * (time - sliding);
    (q[1], v[1]) = (radius, 0.0);
}

/// The block of `examples/stick_slip.toml`: each period it slides from where the load exceeds friction to rest.
fn incline(time: f64, q: &mut [f64], v: &mut [f64]) {
    let (gravity, friction): (f64, f64) = (9.81, 0.3);
    let (sin, cos) = (10f64.to_radians().sin(), 10f64.to_radians().cos());
    let drive = gravity * sin - friction * gravity * cos;
    let start = (-drive / 2.0).asin() / TAU;
    let speed = |since: f64| drive * since + ((TAU * start).cos() - (TAU * (start + since)).cos()) / PI;
    let path = |since: f64| {
        let swing = ((TAU * (start + since)).sin() - (TAU * start).sin()) / TAU;
        0.5 * drive * since * since + ((TAU * start).cos() * since - swing) / PI
    };
    // The load falls below friction half-way, and the block has stopped before the next period.
    let (mut slides, mut rests) = (0.5 - 2.0 * start, 1.0 - start);
    for _ in 0..60 {
        let middle = 0.5 * (slides + rests);
        if speed(middle) > 0.0 { slides = middle } else { rests = middle }
    }
    let periods = (time - start).floor().max(-1.0);
    let since = time - start - periods;
    let gone = if periods < 0.0 { 0.0 } else { periods * path(slides) };
    let sliding = if periods < 0.0 { 0.0 } else { since.min(slides) };
    (q[0], q[1], q[2]) = (gone + path(sliding), 0.05, 0.0);
    v.fill(0.0);
    v[0] = if sliding < slides { speed(sliding) } else { 0.0 };
}

/// The stick of `examples/impacting_stick.toml`, event by event.
fn stick(law: &'static str) -> Motion {
    let scene = example::scene("impacting_stick");
    let prepared = event_driven::<2>(&scene, &example::run(&scene, law, "hybrid"), &nonsmooth::registry())
        .expect("an example builds");
    let motion = prepared.integrate(&Settings::default()).expect("flights and impacts");
    Box::new(move |time, q, v| motion.at(time, q, v))
}

/// Errors over a run, as shares of the scene's length: of q, the largest at the ends of steps; of v, which is linear over a
/// step, the integral over time.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Errors {
    pub(crate) q: f64,
    pub(crate) v: f64,
}

impl Errors {
    pub(crate) fn largest(&self) -> f64 {
        self.q.max(self.v)
    }
}

/// Nodes and weights of Gauss–Legendre on [0, 1].
const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Measures the errors of a run from its states.
pub(crate) struct Measure<'a> {
    motion: &'a Motion,
    weights: Vec<f64>,
    exact: (Vec<f64>, Vec<f64>),
    time: f64,
    velocity: Vec<f64>,
    pub(crate) errors: Errors,
}

impl<'a> Measure<'a> {
    pub(crate) fn new(motion: &'a Motion, weights: &[f64], start: &State<f64>) -> Self {
        let (weights, zeros) = (weights.to_vec(), vec![0.0; weights.len()]);
        let (exact, velocity) = ((zeros.clone(), zeros), start.v.clone());
        Self { motion, weights, exact, time: start.time, velocity, errors: Errors::default() }
    }

    pub(crate) fn take(&mut self, state: &State<f64>) {
        let (q, v) = &mut self.exact;
        (self.motion)(state.time, q, v);
        let terms = state.q.iter().zip(&*q).zip(&self.weights);
        self.errors.q = terms.map(|((x, y), w)| w * (x - y).abs()).fold(self.errors.q, f64::max);
        let step = state.time - self.time;
        for (node, weight) in GAUSS {
            (self.motion)(self.time + node * step, q, v);
            let speeds = self.velocity.iter().zip(&state.v).map(|(from, to)| from + node * (to - from));
            let far = speeds.zip(&*v).zip(&self.weights).map(|((x, y), w)| w * (x - y).abs());
            self.errors.v += weight * step * far.fold(0.0, f64::max);
        }
        self.time = state.time;
        self.velocity.copy_from_slice(&state.v);
    }
}

/// The scheme of a case.
pub(crate) fn scheme<const D: usize>(case: &Case) -> ThetaScheme<f64, D> {
    example::scheme::<f64, D>(&case.scene, case.law, "nsgs").0
}

/// The driver of a case.
pub(crate) fn adaptive<const D: usize>(
    case: &Case,
    tolerance: f64,
) -> Result<Adaptive<f64, D>, AdaptiveError> {
    Adaptive::new(scheme(case), AdaptiveSettings::new(tolerance, case.scene.time.end))
}

/// Runs a case under error control, and tells of every step kept.
pub(crate) fn run<const D: usize>(
    case: &Case,
    tolerance: f64,
    mut kept: impl FnMut(&State<f64>, &Step<f64, D>),
) -> Result<(Errors, Report<f64>), AdaptiveError> {
    let mut driver = adaptive::<D>(case, tolerance)?;
    let mut measure = Measure::new(&case.motion, driver.weights(), driver.scheme().state());
    let _end: ControlFlow<()> = driver.advance_to(case.scene.time.end, |_, state, step| {
        measure.take(state);
        kept(state, step);
        ControlFlow::Continue(())
    })?;
    Ok((measure.errors, *driver.report()))
}
