//! Speed against error: the runs of a study, their errors against a reference, and what they cost.
//!
//! A study is a TOML file that names a scene and lists of settings; the product of the lists is run:
//!
//! ```toml
//! title = "Falling stick"
//! scene = "../impacting_stick.toml"           # from the folder of the study
//! reference = { kind = "event-driven" }       # `finest` where absent; `h` and `theta` of the finest run may be given
//! mark = { label = "the paper's", law = "fremond", theta = 0.5, scalar = "f64" }
//!
//! [[runs]]                                    # any number of blocks, each a product
//! law = ["newton", "fremond"]
//! theta = [0.5, 1.0]
//! h = { from = 1e-2, to = 1e-5, per_decade = 20 }
//! solver = "nsgs"                             # a value is a list of one
//! tolerance = [1e-8, 1e-10]
//! scalar = ["f64", "f32"]
//! "time.allow_unproved_theta" = true          # and any other key of the scene by its path
//! "interfaces.0.parameters.friction" = [0.01, 0.1]
//! ```
//!
//! `epsilon` is the list of tolerances of [`crate::adaptive`] runs, beside or in place of `h`. What a block does not name is as in
//! the scene. In place of a list stands `{ from, to, per_decade }`: values at the middle of equal cells of the logarithm,
//! which no impact time is a multiple of. That matters, as the error of an event-capturing scheme saw-tooths with the
//! place of the impacts in their steps: it varies 27-fold at the same h, so that two steps say nothing about the order. A
//! study takes many and tells both the regression and the envelope.
//!
//! # Errors
//!
//! With the motion (q*, v*) of the [`Reference`]:
//!
//! | error | what it is |
//! |---|---|
//! | q | max_k ‖q_k − q*(t_k)‖, relative to max_k ‖q*(t_k) − q*(0)‖ |
//! | v | ∫ ‖v − v*‖ dt, relative to ∫ ‖v*‖ dt |
//! | percussion | \|Σ p_N − P*\| at the end, relative to P*: normal percussions of all contacts |
//! | energy | 1/t ∫ \|E − E*\| dt, relative to the largest kinetic and elastic energy of the run |
//!
//! ‖·‖ is the largest component for rigid bodies, the root mean square over the degrees of freedom for elastic ones
//! ([`Norm`]). v is linear over a step without percussions and v_{k+1} over a step with some; the integrals are split at
//! the jumps of v* and computed by Gauss's rule with two points.
//!
//! The velocity is measured in L1 over time and not in its largest value: a scheme places an impact up to a step late,
//! and in between its velocity is off by the whole jump, however small the step. In L∞(t) no scheme that does not find
//! the impact times converges; in L2(t) the order is ½, in L1(t) it is that of the jump times, 1. The same holds for the
//! energy where impacts dissipate, which is why it is averaged.
//!
//! # References
//!
//! | kind | motion |
//! |---|---|
//! | `event-driven` | that of [`crate::event_driven`], to rounding: rigid bodies without joints, and others of few unknowns |
//! | `finest` | a run of the scheme in `f64` with an eighth of the smallest h of the study, or the h given, sampled |
//! | `bouncing-ball` | a disc thrown on a half-plane without friction, through the accumulation of its impacts |
//! | `impacting-bar` | an elastic bar that hits a wall, by d'Alembert; the runs approach it as the mesh is refined, too |
//!
//! Against closed forms a law is its limit at θ = ½; a law whose limit depends on θ keeps a distance from it at others.
//! `finest` takes the θ of each run, unless one is given.
//!
//! # Times
//!
//! CPU seconds are those of the thread over the steps alone, without observers and without the setup (factorisation, mesh):
//! runs are repeated until 0.02 s are reached, and the least counts. Runs beside each other share caches and memory, which
//! disturbs CPU seconds by some per cent; `--threads 1` does not. Wall seconds mean something only there.
//!
//! # Results
//!
//! `runs.csv` has a row for each run: settings, `ok` or the message of the failure, steps, iterations of the cone solver,
//! errors; the times are the last three columns, so that without them two runs of a study are the same byte for byte,
//! whatever the number of threads. `orders.csv` has a row for each line of the figures and each error ([`Line`]).
//! `journal.csv` is what a killed study goes on from: outcomes by a fingerprint of all they depend on, so that a changed
//! study makes again what changed, and nothing else.
//!
//! # Solvers
//!
//! A study that names `problems`, a folder of FCLIB files, in place of a scene, solves each problem with every `solver`
//! to every `tolerance` (1e-2, 1e-3, …, 1e-12 where absent) in every `scalar`: residual against time, and Dolan–Moré
//! profiles. See [`ProblemStudy`].

mod ball;
mod bar;
mod engine;
mod error;
mod errors;
mod figures;
mod finest;
mod format;
mod job;
mod journal;
mod lines;
mod plan;
mod problems;
mod reference;
mod references;
mod run;
mod runner;
mod scene;
mod settings;
mod tables;

use std::path::Path;

use crate::registry::Registry;

pub use error::{ReferenceError, StudyError};
pub use errors::{ErrorRecorder, Errors, Norm};
pub use format::{BudgetSpec, MarkSpec, ReferenceSpec};
pub use lines::{Bin, Line, MEASURES, Measure, Order, Point};
pub use plan::SceneStudy;
pub use problems::{ProblemResults, ProblemStudy};
pub use reference::Reference;
pub use run::RunOutcome;
pub use scene::{Row, SceneResults};
pub use settings::{RunSettings, Stepping};

/// How a study is run.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyOptions {
    /// Runs beside each other.
    pub threads: usize,
    /// Whether what is known of an earlier study in the same folder is forgotten. Default no.
    pub fresh: bool,
    /// CPU time that the timed runs of one setting reach together at least (s), so that the grain of the clock does not
    /// count. Default 0.02.
    pub timed: f64,
}

impl Default for StudyOptions {
    fn default() -> Self {
        Self {
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            fresh: false,
            timed: 0.02,
        }
    }
}

/// How far a study is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StudyProgress {
    /// Runs whose outcome is there.
    pub done: usize,
    /// Those of them that an earlier study left.
    pub known: usize,
    /// All runs.
    pub total: usize,
}

/// A study, read from its file.
#[derive(Debug)]
pub enum Study {
    /// Runs of a scene.
    Scene(Box<SceneStudy>),
    /// Solvers over problems.
    Problems(ProblemStudy),
}

impl Study {
    /// Reads a study, its scene and all combinations of settings.
    ///
    /// # Errors
    /// [`StudyError`] with the place of what is wrong.
    pub fn read(path: &Path, registry: &Registry) -> Result<Self, StudyError> {
        let text = std::fs::read_to_string(path).map_err(|source| StudyError::io(path, source))?;
        let (file, blocks) = format::StudyFile::parse(&text, path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        if let Some(scene) = &file.scene {
            let scene = folder.join(scene);
            return Ok(Self::Scene(Box::new(SceneStudy::new(registry, file, blocks, &text, path, scene)?)));
        }
        Ok(Self::Problems(ProblemStudy::new(registry, file, &blocks, &text, path)?))
    }
}
