//! Runs of scenes with everything that is written of them: tables, summary, figures, VTK series, checkpoints.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use serde::Serialize;

use super::ResumeError;
use super::checkpoint::{self, Checkpoint, Current};
use super::frames::Frames;
use super::shown::shown;
use crate::contact::ContactId;
use crate::file::AtomicFile;
use crate::mesh::Mesh;
use crate::observe::{
    AdaptiveSummary, CsvFiles, ObserveError, Rates, RunSeries, RunSummary, SeriesRecorder, SummaryRecorder,
    comparison_figure, elastic_figure, mesh_figure, run_figure,
};
use crate::plot::PlotError;
use crate::registry::Registry;
use crate::scene::{PlannedRun, Scene, SceneError, contact_dimension};
use crate::scheme::RestoreError;
use crate::simulate::{Ended, SimulateError, Simulation, Sink};

/// What is written, and where.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct WriteOptions {
    /// Folder of the results; it is made where it does not exist.
    pub folder: PathBuf,
    /// The scene file, for `summary.json`.
    pub scene_file: PathBuf,
    /// Whether figures are drawn. Default yes.
    pub figures: bool,
    /// Whether checkpoints are left, or gone on from. Default none.
    pub checkpoints: Checkpoints,
}

/// Checkpoints of a run, below the folder of its results; those of error control do not exist.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Checkpoints {
    /// None are left.
    #[default]
    None,
    /// One every so many steps, in place of any that is there.
    Every(usize),
    /// Goes on from the one that is there, as often as the run that left it.
    Resume,
}

impl WriteOptions {
    /// Everything in `folder`, without checkpoints.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
            scene_file: PathBuf::new(),
            figures: true,
            checkpoints: Checkpoints::None,
        }
    }

    /// With this scene file in `summary.json`.
    #[must_use]
    pub fn scene_file(self, path: impl Into<PathBuf>) -> Self {
        Self { scene_file: path.into(), ..self }
    }

    /// With figures or without.
    #[must_use]
    pub fn figures(self, figures: bool) -> Self {
        Self { figures, ..self }
    }

    /// With checkpoints, or from one.
    #[must_use]
    pub fn checkpoints(self, checkpoints: Checkpoints) -> Self {
        Self { checkpoints, ..self }
    }
}

/// What all runs of a scene left, beside the files.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct Written {
    /// The figures of each run made.
    pub summaries: Vec<RunSummary>,
    /// The first run that ended before its end time, `law with solver`, and why.
    pub failure: Option<(String, SimulateError)>,
    /// Whether the interrupt flag was raised; later runs were not begun.
    pub interrupted: bool,
}

/// Why the runs of a scene could not be written. Runs that end early are no such error, see [`Written::failure`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The scene cannot be built.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A file cannot be written.
    #[error(transparent)]
    Output(#[from] ObserveError),
    /// A figure cannot be written.
    #[error(transparent)]
    Figure(#[from] PlotError),
    /// There is nothing to resume.
    #[error(transparent)]
    Resume(#[from] ResumeError),
    /// The checkpoint is of another run.
    #[error(transparent)]
    Restore(#[from] RestoreError),
    /// The mesh file of the scene cannot be read again.
    #[error(transparent)]
    Mesh(#[from] std::io::Error),
    /// Error control keeps more than a checkpoint holds.
    #[error("steps under error control leave no checkpoint: checkpoints are for fixed steps")]
    AdaptiveCheckpoint,
}

/// The file `summary.json`.
#[derive(Serialize)]
struct SummaryFile<'a> {
    title: &'a str,
    scene: &'a Path,
    runs: &'a [RunSummary],
}

/// A file that cannot be written.
fn cannot_write<'a, E: Into<Box<dyn std::error::Error + Send + Sync>>>(
    path: &'a Path,
) -> impl Fn(E) -> ObserveError + 'a {
    move |error| ObserveError::new(path, error)
}

impl Scene {
    /// Makes every run of the scene, every law with every solver, and writes `trajectory.csv`, `contacts.csv`,
    /// `energy.csv`, `summary.json`, the figures and what else the scene asks for. Everything is built and every file opened
    /// before the first step: what cannot be built touches no older result.
    ///
    /// `watch` is asked for one more sink for each run.
    ///
    /// # Errors
    /// [`WriteError`].
    pub fn write(
        &self,
        registry: &Registry,
        options: &WriteOptions,
        watch: &mut dyn FnMut(&PlannedRun) -> Box<dyn Sink>,
        interrupt: &AtomicBool,
    ) -> Result<Written, WriteError> {
        if self.time.adaptive.is_some() && options.checkpoints != Checkpoints::None {
            return Err(WriteError::AdaptiveCheckpoint);
        }
        let runs = self.runs(registry)?;
        let dimension = contact_dimension(self, &runs, registry)?;
        let built = runs.iter().map(|run| self.simulation(run, dimension, registry));
        let mut simulations = built.collect::<Result<Vec<_>, _>>()?;
        let shown = match simulations.first_mut() {
            Some(simulation) => shown(self, &mut **simulation)?,
            None => (Vec::new(), None),
        };
        let folder = &options.folder;
        let mut checkpoint = self.checkpoint(options)?;
        std::fs::create_dir_all(folder).map_err(cannot_write(folder))?;
        let rates = Rates {
            trajectory: self.output.trajectory_every(),
            contacts: self.output.contacts_every.unwrap_or(1),
            energy: self.output.every.unwrap_or(1),
        };
        let mut tables = match &checkpoint {
            None => CsvFiles::create(folder, rates)?,
            Some(checkpoint) => {
                let drafts = checkpoint::folder(folder);
                std::fs::create_dir_all(&drafts).map_err(cannot_write(&drafts))?;
                CsvFiles::kept(folder, rates, &drafts, &checkpoint.tables)?
            }
        };
        let path = folder.join("summary.json");
        let summary = AtomicFile::create(&path).map_err(cannot_write(&path))?;
        let (mut written, mut series, mut done) = (Written::default(), Vec::new(), 0);
        if let Some(checkpoint) = &checkpoint {
            done = checkpoint.finished.len();
            (written.summaries, series) = checkpoint.finished.iter().cloned().unzip();
        }
        let mesh = simulations.first().and_then(|simulation| simulation.mesh().cloned());
        for (run, mut simulation) in runs.iter().zip(simulations).skip(done) {
            let mut under_way = UnderWay {
                scene: self,
                folder,
                run,
                simulation: &mut *simulation,
                tables: &mut tables,
                checkpoint: &mut checkpoint,
            };
            under_way.make(&shown, &mut *watch(run), interrupt, &mut written, &mut series)?;
            if written.interrupted {
                break;
            }
        }
        tables.commit()?;
        self.write_summary(summary, options, &written.summaries)?;
        if options.figures {
            self.write_figures(folder, &series, mesh.as_ref())?;
        }
        if checkpoint.is_some() && !written.interrupted {
            let drafts = checkpoint::folder(folder);
            std::fs::remove_dir_all(&drafts).map_err(cannot_write(&drafts))?;
        }
        Ok(written)
    }

    /// The checkpoint to go on from, or an empty one where checkpoints are to be left.
    fn checkpoint(&self, options: &WriteOptions) -> Result<Option<Checkpoint>, WriteError> {
        Ok(match options.checkpoints {
            Checkpoints::Resume => Some(Checkpoint::read(&options.folder, self)?),
            Checkpoints::Every(every) => {
                // One left by an earlier run would be resumed in place of this one.
                let old = checkpoint::folder(&options.folder);
                if old.exists() {
                    std::fs::remove_dir_all(&old).map_err(cannot_write(&old))?;
                }
                Some(Checkpoint::new(self, every)?)
            }
            Checkpoints::None => None,
        })
    }

    /// Name of the files of a run.
    fn file_name(&self, law: &str, solver: &str) -> String {
        if self.solvers.len() > 1 { format!("{law}-{solver}") } else { law.into() }
    }

    fn write_summary(
        &self,
        mut file: AtomicFile,
        options: &WriteOptions,
        runs: &[RunSummary],
    ) -> Result<(), ObserveError> {
        use std::io::Write as _;
        let summary = SummaryFile { title: &self.title, scene: &options.scene_file, runs };
        let path = file.path().to_path_buf();
        serde_json::to_writer_pretty(&mut file, &summary).map_err(cannot_write(&path))?;
        file.write_all(b"\n").and_then(|()| file.commit()).map_err(cannot_write(&path))
    }

    fn write_figures(
        &self,
        folder: &Path,
        series: &[RunSeries],
        mesh: Option<&Mesh>,
    ) -> Result<(), PlotError> {
        let units = self.units.units();
        for series in series {
            let figure =
                if mesh.is_some() { elastic_figure(series, units) } else { run_figure(series, units) };
            figure.save(&folder.join(self.file_name(&series.law, &series.solver)))?;
        }
        if let Some(mesh) = mesh {
            mesh_figure(mesh, units).save(&folder.join("mesh"))?;
        }
        if series.len() > 1 {
            comparison_figure(series, units).save(&folder.join("comparison"))?;
        }
        Ok(())
    }
}

/// One run of a scene, and what it writes to.
struct UnderWay<'a> {
    scene: &'a Scene,
    folder: &'a Path,
    run: &'a PlannedRun,
    simulation: &'a mut dyn Simulation,
    tables: &'a mut CsvFiles,
    checkpoint: &'a mut Option<Checkpoint>,
}

impl UnderWay<'_> {
    fn make(
        &mut self,
        (dofs, contact): &(Vec<usize>, Option<ContactId>),
        watching: &mut dyn Sink,
        interrupt: &AtomicBool,
        written: &mut Written,
        all_series: &mut Vec<RunSeries>,
    ) -> Result<(), WriteError> {
        let Self { scene, folder, run, simulation, tables, checkpoint } = self;
        let mut summary = SummaryRecorder::default();
        let mut series = SeriesRecorder::new(dofs.clone(), *contact);
        let mut frames = Frames::new(scene, folder, &scene.file_name(&run.law, &run.solver));
        let current = checkpoint.as_mut().and_then(|checkpoint| checkpoint.current.take());
        let resumed = current.is_some();
        if let Some(current) = current {
            simulation.restore(&current.scheme)?;
            summary = SummaryRecorder::resume(current.summary);
            series = series.resume(current.series).ok_or(ResumeError::Contacts)?;
            frames = frames.resume(current.frames);
        }
        let mut ended = match resumed {
            true => Ok(Ended::Completed),
            false => simulation
                .begin(&mut [&mut **tables, &mut summary, &mut series, &mut frames, watching])
                .map(|()| Ended::Completed)
                .map_err(SimulateError::from),
        };
        let every = checkpoint.as_ref().map_or(usize::MAX, |checkpoint| (checkpoint.every as usize).max(1));
        let adaptive = simulation.is_adaptive();
        while matches!(ended, Ok(Ended::Completed)) && (adaptive || simulation.index() < run.steps) {
            let index = simulation.index();
            let stretch = (every - index % every).min(run.steps.saturating_sub(index));
            ended = simulation.advance(
                stretch,
                &mut [&mut **tables, &mut summary, &mut series, &mut frames, watching],
                interrupt,
            );
            if adaptive {
                break;
            }
            let index = simulation.index();
            if let (Some(checkpoint), Ok(Ended::Completed), Some(scheme)) =
                (checkpoint.as_mut(), &ended, simulation.snapshot())
                && index.is_multiple_of(every)
                && index < run.steps
            {
                checkpoint.tables = tables.mark()?;
                let (summary, series) = (summary.mark(), series.mark());
                checkpoint.current = Some(Current { scheme, summary, series, frames: frames.times() });
                checkpoint.write(folder)?;
            }
        }
        let told = simulation.end(&mut [&mut **tables, &mut summary, &mut series, &mut frames, watching]);
        let ended = ended.and_then(|ended| told.map(|()| ended).map_err(SimulateError::from));
        let stopped = match ended {
            Ok(Ended::Completed) => None,
            Ok(Ended::Interrupted) => {
                written.interrupted = true;
                Some("interrupted".to_string())
            }
            Err(error) => {
                let message = error.to_string();
                written.failure.get_or_insert((format!("{} with {}", run.law, run.solver), error));
                Some(message)
            }
        };
        let mut summary = summary.finish(stopped);
        summary.iter_mut().for_each(|summary| add_control(&**simulation, summary));
        written.summaries.extend(summary);
        all_series.push(series.finish());
        if let (Some(checkpoint), false) = (checkpoint.as_mut(), written.interrupted) {
            let all = written.summaries.iter().cloned().zip(all_series.iter().cloned());
            checkpoint.finished = all.collect();
            checkpoint.current = None;
            checkpoint.tables = tables.mark()?;
            checkpoint.write(folder)?;
        }
        Ok(())
    }
}

/// Adds what error control made of a run to its summary.
fn add_control(simulation: &dyn Simulation, summary: &mut RunSummary) {
    let Some((tolerance, report)) = simulation.control() else { return };
    if summary.steps > 0 {
        summary.step = simulation.time() / summary.steps as f64;
    }
    summary.adaptive = Some(AdaptiveSummary {
        tolerance,
        accepted: report.accepted,
        rejected: report.rejected,
        computed: report.computed,
        events: report.events,
        estimated_error: report.estimated_error,
        smallest_step: report.smallest_step,
        largest_step: report.largest_step,
    });
}
