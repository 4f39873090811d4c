//! Checkpoints: what a killed program goes on from.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::file::AtomicFile;
use crate::observe::{CsvMark, HtmlMark, ObserveError, RunSeries, RunSummary, SeriesMark, SummaryMark};
use crate::scene::Scene;
use crate::scheme::Snapshot;
use serde::{Deserialize, Serialize};

/// Layout of the file; another one is refused.
const LAYOUT: u32 = 3;

/// The place of a run: everything the rest of it depends on.
#[derive(Serialize, Deserialize)]
pub(super) struct Checkpoint {
    layout: u32,
    /// Of the scene with its overrides and its mesh, and of the program.
    fingerprint: u64,
    /// Steps between checkpoints.
    pub(super) every: u64,
    pub(super) finished: Vec<(RunSummary, RunSeries)>,
    pub(super) tables: CsvMark,
    /// The run under way; `None` between two.
    pub(super) current: Option<Current>,
}

/// The run under way.
#[derive(Serialize, Deserialize)]
pub(super) struct Current {
    pub(super) scheme: Snapshot,
    pub(super) summary: SummaryMark,
    pub(super) series: SeriesMark,
    pub(super) frames: Vec<f64>,
    pub(super) page: Option<HtmlMark>,
}

/// Why a run cannot be resumed.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum ResumeError {
    /// The checkpoint cannot be read, or the mesh file of its scene.
    #[error("nothing to resume in {}: {source}", path.display())]
    Read {
        /// The checkpoint.
        path: PathBuf,
        /// What the system says.
        source: Arc<std::io::Error>,
    },
    /// The file is no checkpoint, or is cut off.
    #[error("nothing to resume in {}: {source}", path.display())]
    Malformed {
        /// The checkpoint.
        path: PathBuf,
        /// What is wrong with it.
        source: postcard::Error,
    },
    /// The checkpoint has another layout.
    #[error("{} was written by another version of this program", path.display())]
    Layout {
        /// The checkpoint.
        path: PathBuf,
    },
    /// The checkpoint is one of other runs.
    #[error(
        "{} belongs to another scene, mesh or set of options: resume with those the run was started with",
        path.display()
    )]
    Scene {
        /// The checkpoint.
        path: PathBuf,
    },
    /// The figures of the checkpoint show other contacts than those of the scene.
    #[error("the checkpoint shows other contacts")]
    Contacts,
}

/// The folder of drafts and checkpoint below that of the results.
pub(super) fn folder(results: &Path) -> PathBuf {
    results.join("checkpoint")
}

impl Checkpoint {
    pub(super) fn new(scene: &Scene, every: usize) -> std::io::Result<Self> {
        Ok(Self {
            layout: LAYOUT,
            fingerprint: scene.fingerprint()?.number(),
            every: every as u64,
            finished: Vec::new(),
            tables: CsvMark::default(),
            current: None,
        })
    }

    fn path(results: &Path) -> PathBuf {
        folder(results).join("state")
    }

    /// Writes the checkpoint in place of the last, whole or not at all.
    pub(super) fn write(&self, results: &Path) -> Result<(), ObserveError> {
        let path = Self::path(results);
        let write = || -> std::io::Result<()> {
            let bytes = postcard::to_stdvec(self).map_err(std::io::Error::other)?;
            let mut file = AtomicFile::create(&path)?;
            file.write_all(&bytes)?;
            file.commit()
        };
        write().map_err(|error| ObserveError::new(&path, error))
    }

    /// Reads the checkpoint of a run of `scene`.
    pub(super) fn read(results: &Path, scene: &Scene) -> Result<Self, ResumeError> {
        let path = Self::path(results);
        let unreadable = |error| ResumeError::Read { path: path.clone(), source: Arc::new(error) };
        let malformed = |source| ResumeError::Malformed { path: path.clone(), source };
        let bytes = std::fs::read(&path).map_err(unreadable)?;
        let (layout, _) = postcard::take_from_bytes::<u32>(&bytes).map_err(malformed)?;
        if layout != LAYOUT {
            return Err(ResumeError::Layout { path });
        }
        let checkpoint: Self = postcard::from_bytes(&bytes).map_err(malformed)?;
        let own = scene.fingerprint().map_err(unreadable)?;
        if checkpoint.fingerprint != own.number() {
            return Err(ResumeError::Scene { path });
        }
        Ok(checkpoint)
    }
}
