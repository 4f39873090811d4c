//! Schemes of scene files in space, for tests.

use std::path::Path;

use nonsmooth::scene::{Scene, SceneError, build};
use nonsmooth::scheme::ThetaScheme;

/// The scheme of a scene in f64, under law number `law` of its runs.
pub(crate) fn scheme(text: &str, law: usize) -> Result<ThetaScheme<f64, 3>, SceneError> {
    let scene = Scene::parse(text, Path::new("scene.toml"))?;
    let registry = nonsmooth::registry();
    build(&scene, &scene.runs(&registry)?[law], &registry)
}
