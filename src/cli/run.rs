//! `nonsmooth run`: every law with every solver of a scene, its tables, summary and figures.

use std::error::Error;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use nonsmooth::contact::ContactId;
use nonsmooth::file::AtomicFile;
use nonsmooth::laws::ContactLaw as _;
use nonsmooth::observe::{
    CsvFiles, ObserveError, RunInfo, RunSeries, RunSummary, SeriesRecorder, SummaryRecorder,
    comparison_figure, run_figure,
};
use nonsmooth::scalar::Scalar;
use nonsmooth::scene::{self, Overrides, Planar, Run, ScalarName, Scene, SceneError};
use nonsmooth::simulate::{Outcome, simulate};
use nonsmooth::system::MechanicalSystem;
use serde::Serialize;

use super::progress::Progress;
use super::{RunArguments, report};

/// A run ended before its end time because a step failed.
const FAILED: u8 = 1;
/// Interrupted by Ctrl-C.
const INTERRUPTED: u8 = 130;

/// The file `summary.json`.
#[derive(Serialize)]
struct Summary<'a> {
    title: &'a str,
    scene: &'a Path,
    runs: &'a [RunSummary],
}

/// What all runs of a scene left.
#[derive(Default)]
struct Results {
    summaries: Vec<RunSummary>,
    series: Vec<RunSeries>,
    failure: Option<String>,
    interrupted: bool,
}

/// Runs the scene named in `arguments`.
pub(super) fn run(arguments: &RunArguments) -> Result<ExitCode, Box<dyn Error>> {
    let mut scene = Scene::read(&arguments.scene)?;
    scene.override_with(&Overrides {
        laws: arguments.law.clone(),
        solvers: arguments.solver.clone(),
        theta: arguments.theta,
        step: arguments.step,
        end: arguments.end,
        tolerance: arguments.tol,
        scalar: match arguments.scalar.as_deref() {
            Some("f32") => Some(ScalarName::F32),
            Some(_) => Some(ScalarName::F64),
            None => None,
        },
        allow_unproved_theta: arguments.allow_unproved_theta,
        mesh: arguments.mesh.clone(),
    });
    let runs = scene.runs()?;
    let interrupt = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupt);
    ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed))?;
    let session = Session { arguments, scene: &scene, runs: &runs, interrupt: &interrupt };
    match (scene.scalar, scene::contact_dimension(&scene, &runs)?) {
        (ScalarName::F64, 1) => session.execute::<f64, 1>(),
        (ScalarName::F64, _) => session.execute::<f64, 2>(),
        (ScalarName::F32, 1) => session.execute::<f32, 1>(),
        (ScalarName::F32, _) => session.execute::<f32, 2>(),
    }
}

struct Session<'a> {
    arguments: &'a RunArguments,
    scene: &'a Scene,
    runs: &'a [Run],
    interrupt: &'a AtomicBool,
}

impl Session<'_> {
    fn execute<T: Scalar, const D: usize>(&self) -> Result<ExitCode, Box<dyn Error>> {
        // Everything is built and every file opened before the first step: bad input touches no older result.
        let built = self.runs.iter().map(|run| scene::build::<T, D>(self.scene, run));
        let mut schemes = built.collect::<Result<Vec<_>, _>>()?;
        let shown = match schemes.first_mut() {
            Some(scheme) => shown(self.scene, scheme)?,
            None => (Vec::new(), None),
        };
        let folder = self.folder();
        std::fs::create_dir_all(&folder).map_err(|error| ObserveError::new(&folder, error))?;
        let mut tables = CsvFiles::create(&folder, self.scene.output.every.unwrap_or(1))?;
        let path = folder.join("summary.json");
        let summary = AtomicFile::create(&path).map_err(|error| ObserveError::new(&path, error))?;
        let mut results = Results::default();
        for (run, mut scheme) in self.runs.iter().zip(schemes) {
            self.one(run, &mut scheme, &shown, &mut tables, &mut results)?;
            if results.interrupted {
                break;
            }
        }
        tables.commit()?;
        self.write(&folder, summary, &results)?;
        report::runs(&self.scene.title, &results.summaries)?;
        println!("\nresults in {}", folder.display());
        if let Some(failure) = &results.failure {
            eprintln!("error: {failure}");
        }
        Ok(match (results.interrupted, results.failure.is_some()) {
            (true, _) => ExitCode::from(INTERRUPTED),
            (false, true) => ExitCode::from(FAILED),
            (false, false) => ExitCode::SUCCESS,
        })
    }

    fn one<T: Scalar, const D: usize>(
        &self,
        run: &Run,
        scheme: &mut Planar<T, D>,
        (dofs, contact): &(Vec<usize>, Option<ContactId>),
        tables: &mut CsvFiles,
        results: &mut Results,
    ) -> Result<(), ObserveError> {
        let laws = scheme.laws().iter().map(|law| law.name().to_string()).collect();
        let info = RunInfo::new(&run.law, &run.solver, laws, scheme.settings());
        let mut summary = SummaryRecorder::default();
        let mut series = SeriesRecorder::new(dofs.clone(), *contact);
        let mut progress = Progress::new(format!("{} with {}", run.law, run.solver), run.steps);
        let ended = simulate(
            scheme,
            run.steps,
            &info,
            &mut [tables, &mut summary, &mut series, &mut progress],
            self.interrupt,
        );
        let stopped = match ended {
            Ok(Outcome::Completed) => None,
            Ok(Outcome::Interrupted) => {
                results.interrupted = true;
                Some("interrupted".to_string())
            }
            Err(error) => {
                let message = format!("{} with {}: {error}", run.law, run.solver);
                results.failure.get_or_insert(message);
                Some(error.to_string())
            }
        };
        results.summaries.extend(summary.finish(stopped));
        results.series.push(series.finish());
        Ok(())
    }

    fn folder(&self) -> PathBuf {
        let stem = self.arguments.scene.file_stem().unwrap_or_default();
        self.arguments.out.clone().unwrap_or_else(|| Path::new("out").join(stem))
    }

    fn write(&self, folder: &Path, mut file: AtomicFile, results: &Results) -> Result<(), Box<dyn Error>> {
        let summary =
            Summary { title: &self.scene.title, scene: &self.arguments.scene, runs: &results.summaries };
        let path = file.path().to_path_buf();
        let write = || -> Result<(), Box<dyn Error>> {
            serde_json::to_writer_pretty(&mut file, &summary)?;
            file.write_all(b"\n")?;
            Ok(file.commit()?)
        };
        write().map_err(|error| ObserveError::new(&path, error))?;
        if self.arguments.no_figures {
            return Ok(());
        }
        for series in &results.series {
            let name = if self.scene.solvers.len() > 1 {
                format!("{}-{}", series.law, series.solver)
            } else {
                series.law.clone()
            };
            run_figure(series).save(&folder.join(name))?;
        }
        if results.series.len() > 1 {
            comparison_figure(&results.series).save(&folder.join("comparison"))?;
        }
        Ok(())
    }
}

/// Bodies up to which every pair is looked at when the first contact is sought.
const FEW_BODIES: usize = 200;

/// The degrees of freedom and the contact that figures show.
fn shown<T: Scalar, const D: usize>(
    scene: &Scene,
    scheme: &mut Planar<T, D>,
) -> Result<(Vec<usize>, Option<ContactId>), SceneError> {
    let unknown = |place: &str, name: &String, known: Vec<String>| SceneError::UnknownName {
        place: place.into(),
        name: name.clone(),
        known: known.join(", "),
    };
    let body = match &scene.output.figure_body {
        None => 0,
        Some(name) => scene.bodies.iter().position(|body| &body.name == name).ok_or_else(|| {
            unknown("output.figure_body", name, scene.bodies.iter().map(|b| b.name.clone()).collect())
        })?,
    };
    let few = scene.bodies.len() <= FEW_BODIES || scene.output.figure_contact.is_some();
    let candidates = scheme.candidates(if few { T::infinity_impl() } else { T::zero() }).to_vec();
    let system: &dyn MechanicalSystem<T, D> = scheme.system();
    let contact = match &scene.output.figure_contact {
        None => candidates.iter().map(|candidate| candidate.id).min(),
        Some(name) => {
            let labels: Vec<_> = candidates.iter().map(|c| (c.id, system.contact_label(c.id))).collect();
            let found = labels.iter().find(|(_, label)| label == name).map(|&(id, _)| id);
            let known = || labels.iter().take(20).map(|(_, label)| label.clone()).collect();
            Some(found.ok_or_else(|| unknown("output.figure_contact", name, known()))?)
        }
    };
    Ok(((3 * body..3 * body + 3).collect(), contact))
}
