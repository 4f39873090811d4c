//! `nonsmooth run`: every law with every solver of a scene, its tables, summary and figures.

use std::error::Error;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use crate::contact::ContactId;
use crate::file::AtomicFile;
use crate::laws::ContactLaw as _;
use crate::mesh::Mesh;
use crate::observe::{
    AdaptiveSummary, CsvFiles, ObserveError, Rates, RunInfo, RunSeries, RunSummary, SeriesRecorder,
    SummaryRecorder, Units, comparison_figure, elastic_figure, mesh_figure, run_figure,
};
use crate::registry::Registry;
use crate::scalar::{Scalar, to_f64};
use crate::scene::{self, Overrides, PlanarStepper, Run, ScalarName, Scene};
use crate::simulate::{Outcome, SimulateError, Stepper, begin, end};
use crate::system::MechanicalSystem as _;
use serde::Serialize;

use super::checkpoint::{self, Checkpoint, Current};
use super::frames::Frames;
use super::progress::Progress;
use super::shown::shown;
use super::{FAILED, INTERRUPTED, RunArguments, interrupt_flag, report};

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
pub(super) fn run(arguments: &RunArguments, registry: &Registry) -> Result<ExitCode, Box<dyn Error>> {
    let mut scene = Scene::read(&arguments.scene)?;
    scene.override_with(&Overrides {
        laws: arguments.law.clone(),
        solvers: arguments.solver.clone(),
        theta: arguments.theta,
        step: arguments.step,
        adaptive: arguments.adaptive,
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
    let runs = scene.runs(registry)?;
    if scene.time.adaptive.is_some() && (arguments.checkpoint.is_some() || arguments.resume.is_some()) {
        return Err(
            "steps under error control leave no checkpoint: --checkpoint and --resume are for fixed steps"
                .into(),
        );
    }
    let interrupt = interrupt_flag()?;
    let session = Session { arguments, registry, scene: &scene, runs: &runs, interrupt };
    match (scene.scalar, scene::contact_dimension(&scene, &runs, registry)?) {
        (ScalarName::F64, 1) => session.execute::<f64, 1>(),
        (ScalarName::F64, _) => session.execute::<f64, 2>(),
        (ScalarName::F32, 1) => session.execute::<f32, 1>(),
        (ScalarName::F32, _) => session.execute::<f32, 2>(),
    }
}

struct Session<'a> {
    arguments: &'a RunArguments,
    registry: &'a Registry,
    scene: &'a Scene,
    runs: &'a [Run],
    interrupt: &'a AtomicBool,
}

impl Session<'_> {
    fn execute<T: Scalar, const D: usize>(&self) -> Result<ExitCode, Box<dyn Error>> {
        // Everything is built and every file opened before the first step: bad input touches no older result.
        let built = self.runs.iter().map(|run| scene::build::<T, D>(self.scene, run, self.registry));
        let mut schemes = built.collect::<Result<Vec<_>, _>>()?;
        let shown = match schemes.first_mut() {
            Some(scheme) => shown(self.scene, scheme)?,
            None => (Vec::new(), None),
        };
        let control = |scheme| Stepper::new(scheme, self.scene.time.adaptive_settings());
        let steppers = schemes.into_iter().map(control).collect::<Result<Vec<_>, _>>()?;
        let folder = self.folder();
        let mut checkpoint = self.checkpoint(&folder)?;
        std::fs::create_dir_all(&folder).map_err(|error| ObserveError::new(&folder, error))?;
        let output = &self.scene.output;
        let every = output.every.unwrap_or(1);
        let rates = Rates {
            trajectory: output.trajectory_every.unwrap_or(every),
            contacts: output.contacts_every.unwrap_or(1),
            energy: every,
        };
        let mut tables = match &checkpoint {
            None => CsvFiles::create(&folder, rates)?,
            Some(checkpoint) => {
                let drafts = checkpoint::folder(&folder);
                std::fs::create_dir_all(&drafts).map_err(|error| ObserveError::new(&drafts, error))?;
                CsvFiles::kept(&folder, rates, &drafts, &checkpoint.tables)?
            }
        };
        let path = folder.join("summary.json");
        let summary = AtomicFile::create(&path).map_err(|error| ObserveError::new(&path, error))?;
        let mut results = Results::default();
        let mut done = 0;
        if let Some(checkpoint) = &checkpoint {
            done = checkpoint.finished.len();
            (results.summaries, results.series) = checkpoint.finished.iter().cloned().unzip();
        }
        let mut mesh = None;
        for (run, mut stepper) in self.runs.iter().zip(steppers).skip(done) {
            mesh = stepper.scheme().system().geometry().cloned();
            self.one(run, &mut stepper, &shown, &mut tables, &mut checkpoint, &mut results)?;
            if results.interrupted {
                break;
            }
        }
        tables.commit()?;
        self.write(&folder, summary, &results, mesh.as_ref().map(|geometry| geometry.mesh()))?;
        if checkpoint.is_some() && !results.interrupted {
            let drafts = checkpoint::folder(&folder);
            std::fs::remove_dir_all(&drafts).map_err(|error| ObserveError::new(&drafts, error))?;
        }
        report::runs(&self.scene.title, &results.summaries, self.units())?;
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

    /// The checkpoint to go on from, or an empty one where checkpoints are to be left.
    fn checkpoint(&self, folder: &Path) -> Result<Option<Checkpoint>, Box<dyn Error>> {
        Ok(match (&self.arguments.resume, self.arguments.checkpoint) {
            (Some(results), _) => Some(Checkpoint::read(results, self.scene)?),
            (None, Some(every)) => {
                // One left by an earlier run would be resumed in place of this one.
                let old = checkpoint::folder(folder);
                if old.exists() {
                    std::fs::remove_dir_all(&old).map_err(|error| ObserveError::new(&old, error))?;
                }
                Some(Checkpoint::new(self.scene, every as usize)?)
            }
            (None, None) => None,
        })
    }

    fn one<T: Scalar, const D: usize>(
        &self,
        run: &Run,
        stepper: &mut PlanarStepper<T, D>,
        (dofs, contact): &(Vec<usize>, Option<ContactId>),
        tables: &mut CsvFiles,
        checkpoint: &mut Option<Checkpoint>,
        results: &mut Results,
    ) -> Result<(), Box<dyn Error>> {
        let laws = stepper.scheme().laws().iter().map(|law| law.name().to_string()).collect();
        let info = RunInfo::new(&run.law, &run.solver, laws, stepper.scheme().settings());
        let mut summary = SummaryRecorder::default();
        let mut series = SeriesRecorder::new(dofs.clone(), *contact);
        let folder = self.folder();
        let mut frames = Frames::new(self.scene, &folder, &self.name(&run.law, &run.solver));
        let current = checkpoint.as_mut().and_then(|checkpoint| checkpoint.current.take());
        let resumed = current.is_some();
        if let (Some(current), Some(scheme)) = (current, stepper.fixed()) {
            scheme.restore(&current.scheme)?;
            summary = SummaryRecorder::resume(current.summary);
            series = series.resume(current.series).ok_or("the checkpoint shows other contacts")?;
            frames = frames.resume(current.frames);
        }
        let label = format!("{} with {}", run.law, run.solver);
        let mut progress = match self.scene.time.adaptive {
            None => Progress::new(label, run.steps),
            Some(_) => Progress::over_time(label, self.scene.time.end),
        };
        let mut ended = match resumed {
            true => Ok(()),
            false => begin(
                stepper.scheme(),
                &info,
                &mut [&mut *tables, &mut summary, &mut series, &mut frames, &mut progress],
            ),
        }
        .map_err(SimulateError::from)
        .map(|()| Outcome::Completed);
        let every = checkpoint.as_ref().map_or(usize::MAX, |checkpoint| (checkpoint.every as usize).max(1));
        let is_adaptive = stepper.fixed().is_none();
        while matches!(ended, Ok(Outcome::Completed))
            && (is_adaptive || stepper.scheme().state().index < run.steps)
        {
            let index = stepper.scheme().state().index;
            let stretch = (every - index % every).min(run.steps.saturating_sub(index));
            ended = stepper.advance(
                stretch,
                &mut [&mut *tables, &mut summary, &mut series, &mut frames, &mut progress],
                self.interrupt,
            );
            if is_adaptive {
                break;
            }
            let index = stepper.scheme().state().index;
            if let (Some(checkpoint), Ok(Outcome::Completed)) = (checkpoint.as_mut(), &ended)
                && index.is_multiple_of(every)
                && index < run.steps
            {
                checkpoint.tables = tables.mark()?;
                checkpoint.current = Some(Current {
                    scheme: stepper.scheme().snapshot(),
                    summary: summary.mark(),
                    series: series.mark(),
                    frames: frames.times(),
                });
                checkpoint.write(&folder)?;
            }
        }
        let told =
            end(stepper.scheme(), &mut [&mut *tables, &mut summary, &mut series, &mut frames, &mut progress]);
        let ended = ended.and_then(|outcome| told.map(|()| outcome).map_err(SimulateError::from));
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
        let mut summary = summary.finish(stopped);
        summary.iter_mut().for_each(|summary| describe(stepper, summary));
        results.summaries.extend(summary);
        results.series.push(series.finish());
        if let (Some(checkpoint), false) = (checkpoint.as_mut(), results.interrupted) {
            let all = results.summaries.iter().cloned().zip(&results.series);
            checkpoint.finished = all.map(|(summary, series)| (summary, series.clone())).collect();
            checkpoint.current = None;
            checkpoint.tables = tables.mark()?;
            checkpoint.write(&folder)?;
        }
        Ok(())
    }

    /// Name of the files of a run.
    fn name(&self, law: &str, solver: &str) -> String {
        if self.scene.solvers.len() > 1 { format!("{law}-{solver}") } else { law.into() }
    }

    fn folder(&self) -> PathBuf {
        let stem = self.arguments.scene.file_stem().unwrap_or_default();
        let given = self.arguments.out.clone().or_else(|| self.arguments.resume.clone());
        given.unwrap_or_else(|| Path::new("out").join(stem))
    }

    fn units(&self) -> &'static Units {
        self.scene.units.units()
    }

    fn write(
        &self,
        folder: &Path,
        mut file: AtomicFile,
        results: &Results,
        mesh: Option<&Mesh>,
    ) -> Result<(), Box<dyn Error>> {
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
        let units = self.units();
        for series in &results.series {
            let figure =
                if mesh.is_some() { elastic_figure(series, units) } else { run_figure(series, units) };
            figure.save(&folder.join(self.name(&series.law, &series.solver)))?;
        }
        if let Some(mesh) = mesh {
            mesh_figure(mesh, units).save(&folder.join("mesh"))?;
        }
        if results.series.len() > 1 {
            comparison_figure(&results.series, units).save(&folder.join("comparison"))?;
        }
        Ok(())
    }
}

/// Adds what error control made of a run to its summary.
fn describe<T: Scalar, const D: usize>(stepper: &PlanarStepper<T, D>, summary: &mut RunSummary) {
    let Stepper::Adaptive(driver) = stepper else { return };
    let report = driver.report();
    if summary.steps > 0 {
        summary.step = to_f64(driver.scheme().state().time) / summary.steps as f64;
    }
    summary.adaptive = Some(AdaptiveSummary {
        tolerance: to_f64(driver.settings().tolerance),
        accepted: report.accepted,
        rejected: report.rejected,
        computed: report.computed,
        events: report.events,
        estimated_error: to_f64(report.estimated_error),
        smallest_step: to_f64(report.smallest_step),
        largest_step: to_f64(report.largest_step),
    });
}
