//! `nonsmooth study`: speed against error, over lists of settings.

use std::error::Error;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use crate::plot::{Figure, PlotError};
use crate::registry::Registry;
use crate::study::{ProblemStudy, SceneStudy, Study, StudyOptions, StudyProgress};

use super::progress::runs_bar;
use super::{FAILED, INTERRUPTED, interrupt_flag};

/// What `study` takes.
#[derive(Debug, clap::Args)]
pub(super) struct StudyArguments {
    /// Study file (TOML): lists of settings over a scene, or over a folder of cone problems.
    study: PathBuf,
    /// Folder of tables and figures [default: out/studies/<name of the study file>].
    #[arg(long)]
    out: Option<PathBuf>,
    /// Runs beside each other [default: the number of cores].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    threads: Option<u32>,
    /// Forget what an earlier study left in the folder.
    #[arg(long)]
    fresh: bool,
    /// Write no figures.
    #[arg(long)]
    no_figures: bool,
    /// Resolution of the PNG figures in dots per inch.
    #[arg(long, default_value_t = 300.0)]
    dpi: f64,
}

/// Runs a study.
pub(super) fn study(arguments: &StudyArguments, registry: &Registry) -> Result<ExitCode, Box<dyn Error>> {
    let study = Study::read(&arguments.study, registry)?;
    let default = StudyOptions::default();
    let threads = arguments.threads.map_or(default.threads, |threads| threads as usize);
    let stem = arguments.study.file_stem().unwrap_or_default();
    let session = Session {
        folder: arguments.out.clone().unwrap_or_else(|| Path::new("out/studies").join(stem)),
        options: StudyOptions { threads, fresh: arguments.fresh, ..default },
        figures: !arguments.no_figures,
        dpi: arguments.dpi,
        stop: interrupt_flag()?,
    };
    match &study {
        Study::Scene(study) => session.scene(study),
        Study::Problems(study) => session.problems(study),
    }
}

struct Session {
    folder: PathBuf,
    options: StudyOptions,
    figures: bool,
    dpi: f64,
    stop: &'static AtomicBool,
}

impl Session {
    fn scene(&self, study: &SceneStudy) -> Result<ExitCode, Box<dyn Error>> {
        let bar = runs_bar(study.runs());
        let results = study.run(&self.folder, &self.options, self.stop, &mut |progress| show(&bar, progress));
        bar.finish_and_clear();
        let results = results?;
        results.write_csv(&self.folder)?;
        results.write_table(&mut std::io::stdout().lock())?;
        if self.figures {
            self.save(&results.speed_figure(), "speed")?;
            self.save(&results.order_figure(), "order")?;
        }
        self.end(results.missing, results.complete())
    }

    fn problems(&self, study: &ProblemStudy) -> Result<ExitCode, Box<dyn Error>> {
        let bar = runs_bar(study.runs());
        let results = study.run(&self.folder, &self.options, self.stop, &mut |progress| show(&bar, progress));
        bar.finish_and_clear();
        let results = results?;
        results.sweep.write_csv(&self.folder)?;
        results.sweep.write_table(&mut std::io::stdout().lock())?;
        if self.figures {
            self.save(&results.sweep.precision_figure(), "precision")?;
            self.save(&results.sweep.residual_figure(), "residuals")?;
            self.save(&results.sweep.profile_figure(&study.budget.profiles), "profiles")?;
        }
        self.end(results.missing, true)
    }

    fn save(&self, figure: &Figure, name: &str) -> Result<(), PlotError> {
        figure.write_svg(&self.folder.join(name).with_extension("svg"))?;
        figure.write_png(&self.folder.join(name).with_extension("png"), self.dpi)
    }

    fn end(&self, missing: usize, complete: bool) -> Result<ExitCode, Box<dyn Error>> {
        writeln!(std::io::stdout(), "\ntables and figures in {}", self.folder.display())?;
        if missing > 0 {
            eprintln!("interrupted, {missing} runs are left: the same command goes on with them");
            return Ok(ExitCode::from(INTERRUPTED));
        }
        Ok(if complete { ExitCode::SUCCESS } else { ExitCode::from(FAILED) })
    }
}

fn show(bar: &indicatif::ProgressBar, progress: StudyProgress) {
    if progress.known > 0 && progress.done == progress.known {
        bar.println(format!("{} of {} runs are there already", progress.known, progress.total));
    }
    bar.set_position(progress.done as u64);
}
