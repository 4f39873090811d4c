//! What is written of the runs of a scene, and where.

use std::path::PathBuf;

/// What is written, and where.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct WriteOptions {
    /// Folder of the results; it is made where it does not exist.
    pub folder: PathBuf,
    /// The scene file, for `summary.json`.
    pub scene_file: PathBuf,
    /// Whether figures are drawn, and pages that show the motion are written. Default yes.
    pub figures: bool,
    /// Whether checkpoints are left, or gone on from. Default none.
    pub checkpoints: Checkpoints,
    /// Folder that cone problems no solver solved are written to as FCLIB files; they are not kept where absent.
    pub failures: Option<PathBuf>,
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
            failures: None,
        }
    }

    /// With this scene file in `summary.json`.
    #[must_use]
    pub fn scene_file(self, path: impl Into<PathBuf>) -> Self {
        Self { scene_file: path.into(), ..self }
    }

    /// With figures and pages or without.
    #[must_use]
    pub fn figures(self, figures: bool) -> Self {
        Self { figures, ..self }
    }

    /// With checkpoints, or from one.
    #[must_use]
    pub fn checkpoints(self, checkpoints: Checkpoints) -> Self {
        Self { checkpoints, ..self }
    }

    /// With cone problems that no solver solved kept in a folder, which is made where it does not exist; needs the feature
    /// `fclib`.
    #[must_use]
    pub fn failures(self, folder: Option<PathBuf>) -> Self {
        Self { failures: folder, ..self }
    }
}
