//! One run of a scene, and what it writes to.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use super::checkpoint::{Checkpoint, Current};
use super::frames::Frames;
use super::warnings::{Warning, deepest_allowed};
use super::{ResumeError, WriteError, Written};
use crate::contact::ContactId;
use crate::observe::{
    AdaptiveSummary, CsvFiles, HtmlPage, ObserveError, RunSeries, RunSummary, SeriesRecorder, SummaryRecorder,
};
use crate::scene::{PlannedRun, Scene};
use crate::simulate::{Ended, SimulateError, Simulation, Sink};

/// One run of a scene, and what it writes to.
pub(super) struct UnderWay<'a> {
    pub(super) scene: &'a Scene,
    pub(super) folder: &'a Path,
    pub(super) failures: Option<&'a Path>,
    /// File of the page that shows the motion.
    pub(super) page: Option<PathBuf>,
    pub(super) run: &'a PlannedRun,
    pub(super) simulation: &'a mut dyn Simulation,
    pub(super) tables: &'a mut CsvFiles,
    pub(super) checkpoint: &'a mut Option<Checkpoint>,
}

impl UnderWay<'_> {
    /// Makes the run; the number of its VTK frames, and its page where it has one.
    pub(super) fn make(
        &mut self,
        (dofs, contact): &(Vec<usize>, Option<ContactId>),
        watching: &mut dyn Sink,
        interrupt: &AtomicBool,
        written: &mut Written,
        all_series: &mut Vec<RunSeries>,
    ) -> Result<(usize, Option<PathBuf>), WriteError> {
        let Self { scene, folder, failures, page, run, simulation, tables, checkpoint } = self;
        let mut summary = SummaryRecorder::default();
        let mut series = SeriesRecorder::new(dofs.clone(), *contact);
        let mut frames = Frames::new(scene, folder, &scene.file_name(&run.law, &run.solver));
        let mut page = page.take().map(|path| HtmlPage::new(&path, &scene.title, *scene.units.units()));
        // Before anything of a checkpoint is restored: what overlaps when the run starts.
        let overlaps = simulation.overlaps();
        let current = checkpoint.as_mut().and_then(|checkpoint| checkpoint.current.take());
        let resumed = current.is_some();
        if let Some(current) = current {
            simulation.restore(&current.scheme)?;
            summary = SummaryRecorder::resume(current.summary);
            series = series.resume(current.series).ok_or(ResumeError::Contacts)?;
            frames = frames.resume(current.frames);
            page = page.zip(current.page).map(|(page, mark)| page.resume(mark));
        }
        let mut ended = match resumed {
            true => Ok(Ended::Completed),
            false => simulation
                .begin(&mut [&mut **tables, &mut summary, &mut series, &mut frames, &mut page, watching])
                .map(|()| Ended::Completed)
                .map_err(SimulateError::from),
        };
        let every = checkpoint.as_ref().map_or(usize::MAX, |checkpoint| (checkpoint.every as usize).max(1));
        let adaptive = simulation.is_adaptive();
        while matches!(ended, Ok(Ended::Completed)) && (adaptive || simulation.index() < run.steps) {
            let before = simulation.index();
            let stretch = (every - before % every).min(run.steps.saturating_sub(before));
            ended = simulation.advance(
                stretch,
                &mut [&mut **tables, &mut summary, &mut series, &mut frames, &mut page, watching],
                interrupt,
            );
            let index = simulation.index();
            // Without a step made, the last is one that cannot be shortened.
            if adaptive || index == before {
                break;
            }
            if let (Some(checkpoint), Ok(Ended::Completed), Some(scheme)) =
                (checkpoint.as_mut(), &ended, simulation.snapshot())
                && index.is_multiple_of(every)
                && index < run.steps
            {
                checkpoint.tables = tables.mark()?;
                let (summary, series) = (summary.mark(), series.mark());
                let (frames, page) = (frames.times(), page.as_ref().map(HtmlPage::mark));
                checkpoint.current = Some(Current { scheme, summary, series, frames, page });
                checkpoint.write(folder)?;
            }
        }
        let told =
            simulation.end(&mut [&mut **tables, &mut summary, &mut series, &mut frames, &mut page, watching]);
        let ended = ended.and_then(|ended| told.map(|()| ended).map_err(SimulateError::from));
        if !adaptive && matches!(ended, Ok(Ended::Completed)) && simulation.index() < run.steps {
            let (end, time, step) = (scene.time.end, simulation.time(), scene.time.step);
            written.warn(Warning::StopsBeforeEnd { time, end, step });
        }
        let stopped = match ended {
            Ok(Ended::Completed) => None,
            Ok(Ended::Interrupted) => {
                written.interrupted = true;
                Some("interrupted".to_string())
            }
            Err(error) => {
                let message = error.to_string();
                if let Some(folder) = failures {
                    written.problems.extend(save_problem(folder, run, &**simulation, &error)?);
                }
                written.failure.get_or_insert((format!("{} with {}", run.law, run.solver), error));
                Some(message)
            }
        };
        let mut summary = summary.finish(stopped);
        if let Some(summary) = &mut summary {
            add_control(&**simulation, summary);
            let bound = deepest_allowed(scene, simulation.mesh());
            if summary.penetration.largest > bound {
                let run = format!("{} with {}", run.law, run.solver);
                let found = summary.penetration.clone();
                let of_pair = overlaps.iter().filter(|(contact, _)| pair(contact) == pair(&found.contact));
                let start = of_pair.fold(0.0_f64, |deepest, (_, gap)| deepest.max(-gap));
                let start = if found.time > 0.0 { start } else { found.largest };
                written.warn(Warning::Penetration { run, found, start, bound });
            }
        }
        written.summaries.extend(summary);
        all_series.push(series.finish());
        if let (Some(checkpoint), false) = (checkpoint.as_mut(), written.interrupted) {
            let all = written.summaries.iter().cloned().zip(all_series.iter().cloned());
            checkpoint.finished = all.collect();
            checkpoint.current = None;
            checkpoint.tables = tables.mark()?;
            checkpoint.write(folder)?;
        }
        Ok((frames.times().len(), page.and_then(|page| page.written().map(Path::to_path_buf))))
    }
}

/// Writes the cone problem that a run failed on; its file, `None` where it failed on something else.
#[cfg(feature = "fclib")]
fn save_problem(
    folder: &Path,
    run: &PlannedRun,
    simulation: &dyn Simulation,
    error: &SimulateError,
) -> Result<Option<PathBuf>, ObserveError> {
    use crate::adaptive::AdaptiveError;
    use crate::fclib::{Info, WriteOptions, write};
    use crate::scheme::StepError;

    let (SimulateError::Step(source) | SimulateError::Adaptive(AdaptiveError::Step(source))) = error else {
        return Ok(None);
    };
    if !matches!(source, StepError::Solve { .. }) {
        return Ok(None);
    }
    let step = simulation.index() + 1;
    let path = folder.join(format!("{}-{}-step{step}.hdf5", run.law, run.solver));
    let info = Info {
        title: Some(format!("step {step} of a run under {} with {}", run.law, run.solver)),
        description: Some(error.to_string()),
        ..Info::default()
    };
    let failed = |error: crate::fclib::FclibError| ObserveError::new(&path, error);
    let problem = simulation.cone_problem(info).map_err(failed)?;
    std::fs::create_dir_all(folder).map_err(|error| ObserveError::new(folder, error))?;
    write(&path, &problem, WriteOptions::default()).map_err(failed)?;
    Ok(Some(path))
}

#[cfg(not(feature = "fclib"))]
fn save_problem(
    folder: &Path,
    _: &PlannedRun,
    _: &dyn Simulation,
    _: &SimulateError,
) -> Result<Option<PathBuf>, ObserveError> {
    Err(ObserveError::new(folder, "problem files need the feature `fclib`"))
}

/// The two shapes of a contact, whatever their features that touch.
fn pair(contact: &str) -> Vec<&str> {
    let shape = |side: &'_ str| match side.rsplit_once('/') {
        Some((shape, feature)) if feature.bytes().all(|byte| byte.is_ascii_digit()) => shape.len(),
        _ => side.len(),
    };
    let mut shapes: Vec<&str> = contact.split('|').map(|side| &side[..shape(side)]).collect();
    shapes.sort_unstable();
    shapes
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
