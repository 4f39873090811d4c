//! `nonsmooth run`: every law with every solver of a scene, its tables, summary and figures.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::progress::StepBar;
use super::{FAILED, INTERRUPTED, RunArguments, interrupt_flag, report};
use crate::registry::Registry;
use crate::run::{Checkpoints, WriteOptions};
use crate::scene::{Overrides, PlannedRun, Scene};
use crate::simulate::Sink;

/// Runs the scene named in `arguments`.
pub(super) fn run(arguments: &RunArguments, registry: &Registry) -> Result<ExitCode, Box<dyn Error>> {
    let mut scene = Scene::read(&arguments.scene)?;
    if arguments.mesh.is_some() && scene.solid.is_none() {
        return Err("--mesh takes the place of the mesh of [solid], and the scene has no [solid]".into());
    }
    scene.override_with(&Overrides {
        laws: arguments.law.clone(),
        solvers: arguments.solver.clone(),
        theta: arguments.theta,
        step: arguments.step,
        adaptive: arguments.adaptive,
        end: arguments.end,
        tolerance: arguments.tol,
        scalar: arguments.scalar,
        allow_unproved_theta: arguments.allow_unproved_theta,
        mesh: arguments.mesh.clone(),
    });
    if scene.time.adaptive.is_some() && (arguments.checkpoint.is_some() || arguments.resume.is_some()) {
        scene.runs(registry)?;
        return Err(
            "steps under error control leave no checkpoint: --checkpoint and --resume are for fixed steps"
                .into(),
        );
    }
    let options = WriteOptions::new(folder(arguments))
        .scene_file(&arguments.scene)
        .figures(!arguments.no_figures)
        .failures(arguments.save_failures.clone())
        .checkpoints(match (&arguments.resume, arguments.checkpoint) {
            (Some(_), _) => Checkpoints::Resume,
            (None, Some(every)) => Checkpoints::Every(every as usize),
            (None, None) => Checkpoints::None,
        });
    let end = scene.time.end;
    let mut watch = |run: &PlannedRun| -> Box<dyn Sink> {
        let label = format!("{} with {}", run.law, run.solver);
        // Under error control nobody knows the number of steps.
        Box::new(if run.steps > 0 { StepBar::new(label, run.steps) } else { StepBar::over_time(label, end) })
    };
    let written = scene.write(registry, &options, &mut watch, interrupt_flag()?)?;
    report::runs(&scene.title, &written.summaries, scene.units.units())?;
    println!("\nresults in {}", options.folder.display());
    for warning in &written.warnings {
        eprintln!("warning: {warning}");
    }
    if let Some((run, error)) = &written.failure {
        eprintln!("error: {run}: {error}");
    }
    for problem in &written.problems {
        eprintln!("the problem that was not solved is in {}", problem.display());
    }
    Ok(match (written.interrupted, written.failure.is_some()) {
        (true, _) => ExitCode::from(INTERRUPTED),
        (false, true) => ExitCode::from(FAILED),
        (false, false) => ExitCode::SUCCESS,
    })
}

/// Folder of the results.
fn folder(arguments: &RunArguments) -> PathBuf {
    let stem = arguments.scene.file_stem().unwrap_or_default();
    let given = arguments.out.clone().or_else(|| arguments.resume.clone());
    given.unwrap_or_else(|| Path::new("out").join(stem))
}
