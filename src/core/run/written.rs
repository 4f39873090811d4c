//! Runs of scenes with everything that is written of them: tables, summary, figures, pages, VTK series, checkpoints.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use serde::Serialize;

use super::checkpoint::{self, Checkpoint};
use super::manifest::Manifest;
use super::shown::shown;
use super::under_way::UnderWay;
use super::warnings::deepest_allowed;
use super::{Checkpoints, ResumeError, Warning, WriteOptions};
use crate::file::{AtomicFile, create_folder};
use crate::mesh::Mesh;
use crate::observe::{
    CsvFiles, ObserveError, Rates, RunSeries, RunSummary, comparison_figure, elastic_figure, mesh_figure,
    run_figure,
};
use crate::plot::PlotError;
use crate::registry::Registry;
use crate::scene::{PlannedRun, Scene, SceneError, contact_dimension};
use crate::scheme::RestoreError;
use crate::simulate::{SimulateError, Simulation, Sink};

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
    /// What a person should know of the runs, each once.
    pub warnings: Vec<Warning>,
    /// Files of cone problems that no solver solved.
    pub problems: Vec<PathBuf>,
}

impl Written {
    /// Adds a warning that is new.
    pub(super) fn warn(&mut self, warning: Warning) {
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }
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

/// Part of the depth that is told of a run, below which an overlap at its start is one of drawing.
const ROUNDING: f64 = 1e-6;

/// The file `summary.json`.
#[derive(Serialize)]
struct SummaryFile<'a> {
    title: &'a str,
    scene: &'a Path,
    /// What a person should know of the runs.
    warnings: Vec<String>,
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
    /// `energy.csv`, `summary.json`, the figures, the pages that show the motion, and what else the scene asks for. Everything is built and every file opened
    /// before the first step: what cannot be built touches no older result. Files that an earlier run left in the folder and
    /// this one does not write are removed at the end, and drafts of killed runs.
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
        let mut written =
            Written { warnings: self.all_warnings(registry, &mut simulations)?, ..Written::default() };
        let folder = &options.folder;
        let mut checkpoint = self.checkpoint(options)?;
        create_folder(folder).map_err(cannot_write(folder))?;
        let mut manifest = Manifest::open(folder);
        manifest.remove_drafts()?;
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
        let (mut series, mut done) = (Vec::new(), 0);
        let mesh = simulations.first().and_then(|simulation| simulation.mesh().cloned());
        manifest.announce(self.files(options, &runs, mesh.is_some()))?;
        if let Some(checkpoint) = &checkpoint {
            done = checkpoint.finished.len();
            (written.summaries, series) = checkpoint.finished.iter().cloned().unzip();
        }
        let page = |run: &PlannedRun| {
            let wanted = options.figures && self.output.html != Some(false);
            wanted.then(|| folder.join(format!("{}.html", self.file_name(&run.law, &run.solver))))
        };
        // Those of runs that were over before a resumption are there.
        let mut made: Vec<PathBuf> = runs.iter().take(done).filter_map(page).collect();
        let mut frames = BTreeMap::new();
        for (run, mut simulation) in runs.iter().zip(simulations).skip(done) {
            let mut under_way = UnderWay {
                scene: self,
                folder,
                failures: options.failures.as_deref(),
                page: page(run),
                run,
                simulation: &mut *simulation,
                tables: &mut tables,
                checkpoint: &mut checkpoint,
            };
            let (count, page) =
                under_way.make(&shown, &mut *watch(run), interrupt, &mut written, &mut series)?;
            made.extend(page);
            let name = self.file_name(&run.law, &run.solver);
            frames.insert(super::frames::of_contacts(name.clone()), count);
            frames.insert(name, count);
            if written.interrupted {
                break;
            }
        }
        tables.commit()?;
        #[cfg(feature = "hdf5")]
        if self.output.hdf5 {
            crate::observe::write_tables(folder)?;
        }
        self.write_summary(summary, options, &written)?;
        if options.figures {
            made.extend(self.write_figures(folder, &series, mesh.as_ref())?);
        }
        if checkpoint.is_some() && !written.interrupted {
            let drafts = checkpoint::folder(folder);
            std::fs::remove_dir_all(&drafts).map_err(cannot_write(&drafts))?;
        }
        // Frames of runs that were over before a resumption are all there.
        manifest.finish(&made, |name| frames.get(name).copied().unwrap_or(usize::MAX))?;
        Ok(written)
    }

    /// What is to be known before the first step.
    fn all_warnings(
        &self,
        registry: &Registry,
        simulations: &mut [Box<dyn Simulation>],
    ) -> Result<Vec<Warning>, SceneError> {
        let mut warnings: Vec<Warning> = self.warnings(registry)?.into_iter().map(Warning::Scene).collect();
        if self.output.vtk_every.is_some() && !cfg!(feature = "vtk") {
            warnings.push(Warning::NotBuilt { key: "output.vtk_every", feature: "vtk" });
        }
        if self.output.hdf5 && !cfg!(feature = "hdf5") {
            warnings.push(Warning::NotBuilt { key: "output.hdf5", feature: "hdf5" });
        }
        // The runs start from the same state.
        let Some(simulation) = simulations.first_mut() else { return Ok(warnings) };
        let notes = simulation.mesh().map(|mesh| mesh.notes().to_vec()).unwrap_or_default();
        warnings.extend(notes.into_iter().map(Warning::Mesh));
        let overlaps = simulation.overlaps();
        let smallest = deepest_allowed(self, simulation.mesh()) * ROUNDING;
        let deep = overlaps.iter().filter(|(_, gap)| -gap > smallest);
        if let Some((contact, gap)) = deep.clone().min_by(|a, b| a.1.total_cmp(&b.1)) {
            let (pairs, contact) = (deep.count(), contact.clone());
            warnings.push(Warning::StartsOverlapping { pairs, contact, depth: -gap });
        }
        Ok(warnings)
    }

    /// Names of the files that the runs may write.
    fn files(&self, options: &WriteOptions, runs: &[PlannedRun], has_mesh: bool) -> Vec<String> {
        let mut names: Vec<String> =
            ["trajectory.csv", "contacts.csv", "energy.csv", "summary.json"].map(String::from).into();
        let stems = runs.iter().map(|run| self.file_name(&run.law, &run.solver));
        if self.output.vtk_every.is_some() && cfg!(feature = "vtk") {
            let series = |name: String| [format!("{name}.pvd"), format!("{name}/*")];
            names.extend(stems.clone().flat_map(series));
            if self.solid.is_none() && self.lagrangian.is_none() {
                names.extend(stems.clone().map(super::frames::of_contacts).flat_map(series));
            }
        }
        if self.output.hdf5 && cfg!(feature = "hdf5") {
            names.push("tables.h5".into());
        }
        if options.figures && self.output.html != Some(false) {
            names.extend(stems.clone().map(|name| format!("{name}.html")));
        }
        if options.figures {
            let mesh = has_mesh.then(|| "mesh".to_string());
            let stems = stems.chain(mesh).chain((runs.len() > 1).then(|| "comparison".to_string()));
            names.extend(stems.flat_map(|name| [format!("{name}.svg"), format!("{name}.png")]));
        }
        names
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
    pub(super) fn file_name(&self, law: &str, solver: &str) -> String {
        if self.solvers.len() > 1 { format!("{law}-{solver}") } else { law.into() }
    }

    fn write_summary(
        &self,
        mut file: AtomicFile,
        options: &WriteOptions,
        written: &Written,
    ) -> Result<(), ObserveError> {
        use std::io::Write as _;
        let warnings = written.warnings.iter().map(ToString::to_string).collect();
        let (title, scene, runs) = (&self.title, &options.scene_file, &written.summaries);
        let summary = SummaryFile { title, scene, warnings, runs };
        let path = file.path().to_path_buf();
        serde_json::to_writer_pretty(&mut file, &summary).map_err(cannot_write(&path))?;
        file.write_all(b"\n").and_then(|()| file.commit()).map_err(cannot_write(&path))
    }

    fn write_figures(
        &self,
        folder: &Path,
        series: &[RunSeries],
        mesh: Option<&Mesh>,
    ) -> Result<Vec<PathBuf>, PlotError> {
        let (units, mut made) = (self.units.units(), Vec::new());
        for series in series {
            let figure =
                if mesh.is_some() { elastic_figure(series, units) } else { run_figure(series, units) };
            made.extend(figure.save(&folder.join(self.file_name(&series.law, &series.solver)))?);
        }
        if let Some(mesh) = mesh {
            made.extend(mesh_figure(mesh, units).save(&folder.join("mesh"))?);
        }
        if series.len() > 1 {
            made.extend(comparison_figure(series, units).save(&folder.join("comparison"))?);
        }
        Ok(made)
    }
}
