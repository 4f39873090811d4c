//! The scenes of `examples/`, run by the library.

use std::path::Path;

use nonsmooth::scalar::Scalar;
use nonsmooth::scene::{PlannedRun, Scene, build};
use nonsmooth::scheme::ThetaScheme;

/// The scene `examples/NAME.toml`.
pub(crate) fn scene(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name).with_extension("toml");
    Scene::read(&path).unwrap_or_else(|error| panic!("{error}"))
}

/// The run of a scene with one law and one solver.
pub(crate) fn run(scene: &Scene, law: &str, solver: &str) -> PlannedRun {
    let runs = Scene { laws: vec![law.into()], solvers: vec![solver.into()], ..scene.clone() }
        .runs(&nonsmooth::registry());
    let [run] = <[PlannedRun; 1]>::try_from(runs.expect("registered names")).expect("one law, one solver");
    run
}

/// The scheme of a scene with one law and one solver, and its number of steps.
#[allow(dead_code)]
pub(crate) fn scheme<T: Scalar, const D: usize>(
    scene: &Scene,
    law: &str,
    solver: &str,
) -> (ThetaScheme<T, D>, usize) {
    let run = run(scene, law, solver);
    (build(scene, &run, &nonsmooth::registry()).expect("an example builds"), run.steps)
}
