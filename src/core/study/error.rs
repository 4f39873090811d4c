//! Why a study could not be read or run.

use std::path::{Path, PathBuf};

use crate::collection::CollectionError;
use crate::event_driven::EventError;
use crate::scene::{SceneError, line_and_column};
use crate::simulate::SimulateError;

/// Why a reference could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReferenceError {
    /// A closed form does not know the motion of this scene.
    #[error("{needs}")]
    Unknown {
        /// What the scene would have to be.
        needs: String,
    },
    /// The scene cannot be built.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The event-driven integration failed.
    #[error(transparent)]
    Motion(#[from] EventError),
    /// The run with the finest step failed.
    #[error(transparent)]
    Run(#[from] SimulateError),
}

impl From<&str> for ReferenceError {
    fn from(needs: &str) -> Self {
        Self::Unknown { needs: needs.into() }
    }
}

impl From<String> for ReferenceError {
    fn from(needs: String) -> Self {
        Self::Unknown { needs }
    }
}

/// Why a study could not be read or run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not a study.
    #[error("{}:{line}:{column}: {message}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong there.
        message: String,
    },
    /// The scene with a value of the study is none.
    #[error("{}:{line}:{column}: {key}: {source}", path.display())]
    Value {
        /// The file of the study.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The key.
        key: String,
        /// What the scene says.
        source: Box<SceneError>,
    },
    /// The scene cannot be used.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The values of a combination are all right one by one, and not together.
    #[error("{settings}: {source}")]
    Combination {
        /// The combination.
        settings: String,
        /// What the scene says.
        source: Box<SceneError>,
    },
    /// Two blocks of runs ask for the same run.
    #[error("the study asks twice for {settings}")]
    Twice {
        /// The settings of the run.
        settings: String,
    },
    /// More runs than a study may have.
    #[error("the study has {runs} runs or more, at most {most} are made")]
    TooMany {
        /// Runs counted.
        runs: usize,
        /// Largest number.
        most: usize,
    },
    /// The reference does not know the motion of the scene.
    #[error("the reference `{reference}` does not know this motion ({settings}): {source}")]
    Reference {
        /// Name of the reference.
        reference: String,
        /// The settings it was asked for.
        settings: String,
        /// Why.
        source: Box<ReferenceError>,
    },
    /// Another program is at work in the folder of the results.
    #[error("{}: another study writes here", path.display())]
    Busy {
        /// The journal.
        path: PathBuf,
    },
    /// A table could not be written.
    #[error("{}: {source}", path.display())]
    Table {
        /// The table.
        path: PathBuf,
        /// What went wrong.
        source: csv::Error,
    },
    /// A problem file or a solver cannot be used.
    #[error(transparent)]
    Collection(#[from] CollectionError),
}

impl StudyError {
    pub(super) fn parse(path: &Path, text: &str, at: usize, message: impl std::fmt::Display) -> Self {
        let (line, column) = line_and_column(text, at);
        let message = message.to_string().trim().replace('\n', " ");
        Self::Parse { path: path.into(), line, column, message }
    }

    pub(super) fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io { path: path.into(), source }
    }
}
