//! A run of a study.

use super::settings::RunSettings;
use crate::scene::{Fingerprint, PlannedRun, Scene};

/// A run of a study.
#[derive(Debug, Clone)]
pub(super) struct Job {
    pub(super) settings: RunSettings,
    /// The scene with the settings.
    pub(super) scene: Scene,
    pub(super) run: PlannedRun,
    pub(super) dimension: usize,
    /// What all of the run depends on.
    pub(super) key: Fingerprint,
}
