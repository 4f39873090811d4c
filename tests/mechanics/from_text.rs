//! Schemes of scenes given as text.

use std::path::Path;

use nonsmooth::scene::{Scene, SceneError, build};
use nonsmooth::scheme::ThetaScheme;

/// The scheme of the first run of a scene, and its number of steps.
pub(crate) fn try_scheme<const D: usize>(text: &str) -> Result<(ThetaScheme<f64, D>, usize), SceneError> {
    let scene = Scene::parse(text, Path::new("scene.toml"))?;
    let registry = nonsmooth::registry();
    let runs = scene.runs(&registry)?;
    Ok((build(&scene, &runs[0], &registry)?, runs[0].steps))
}

/// As [`try_scheme`], of a scene that is sound.
#[allow(dead_code)]
pub(crate) fn scheme<const D: usize>(text: &str) -> (ThetaScheme<f64, D>, usize) {
    try_scheme(text).unwrap_or_else(|error| panic!("{error}"))
}

/// The largest imbalance of the energy balance in a run, after `watch` has seen the scheme behind every step.
#[allow(dead_code)]
pub(crate) fn follow<const D: usize>(text: &str, mut watch: impl FnMut(&ThetaScheme<f64, D>)) -> f64 {
    let (mut scheme, steps) = scheme::<D>(text);
    let mut worst = 0.0_f64;
    for step in 0..steps {
        let made = scheme.step().unwrap_or_else(|error| panic!("step {step}: {error}"));
        worst = worst.max(made.balance.imbalance.abs());
        watch(&scheme);
    }
    worst
}

/// Times at which a sampled quantity crosses zero upwards, by linear interpolation of (time, value).
#[allow(dead_code)]
pub(crate) fn upcrossings(samples: &[(f64, f64)]) -> Vec<f64> {
    let crossing = |pair: &[(f64, f64)]| {
        let [(t, x), (u, y)] = [pair[0], pair[1]];
        (x < 0.0 && y >= 0.0).then(|| t + (u - t) * x / (x - y))
    };
    samples.windows(2).filter_map(crossing).collect()
}
