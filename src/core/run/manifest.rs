//! What the program has written to a folder of results, so that a later run can take away what it does not write itself.

use std::collections::BTreeSet;
use std::io::Write as _;
use std::path::{Component, Path, PathBuf};

use crate::file::{AtomicFile, remove_drafts};
use crate::observe::ObserveError;

/// Name of the file in the folder of results: a path below it on each line, `name/*` for a series `name/name_00000.vtu`.
const NAME: &str = ".nonsmooth-files";

/// The files of a folder of results.
pub(super) struct Manifest {
    folder: PathBuf,
    /// Those of earlier runs, and those announced.
    known: BTreeSet<String>,
    /// Those of this run.
    own: BTreeSet<String>,
}

/// Whether a line names something below the folder, and not the way out of it.
fn is_below(line: &str) -> bool {
    let path = Path::new(line);
    !line.is_empty() && path.components().all(|part| matches!(part, Component::Normal(_)))
}

impl Manifest {
    /// The manifest of a folder, empty where there is none.
    pub(super) fn open(folder: &Path) -> Self {
        let text = std::fs::read_to_string(folder.join(NAME)).unwrap_or_default();
        let known = text.lines().filter(|line| is_below(line)).map(String::from).collect();
        Self { folder: folder.into(), known, own: BTreeSet::new() }
    }

    /// Says what this run is going to write, before it does.
    pub(super) fn announce(&mut self, names: impl IntoIterator<Item = String>) -> Result<(), ObserveError> {
        self.own.extend(names);
        self.known.extend(self.own.iter().cloned());
        self.save(&self.known)
    }

    fn save(&self, names: &BTreeSet<String>) -> Result<(), ObserveError> {
        let path = self.folder.join(NAME);
        let write = || -> std::io::Result<()> {
            let mut file = AtomicFile::create(&path)?;
            names.iter().try_for_each(|name| writeln!(file, "{name}"))?;
            file.commit()
        };
        write().map_err(|error| ObserveError::new(&path, error))
    }

    /// Removes what killed programs left half written.
    pub(super) fn remove_drafts(&self) -> Result<(), ObserveError> {
        let series = self.known.iter().filter_map(|name| name.strip_suffix("/*"));
        let folders = series.map(|name| self.folder.join(name));
        for folder in
            [self.folder.clone(), super::checkpoint::folder(&self.folder)].into_iter().chain(folders)
        {
            remove_drafts(&folder).map_err(|error| ObserveError::new(&folder, error))?;
        }
        Ok(())
    }

    /// Removes the files of earlier runs that this one did not write: figures and pages that are not among those made, and of a series
    /// what `frames` does not count.
    pub(super) fn finish(
        mut self,
        figures: &[PathBuf],
        frames: impl Fn(&str) -> usize,
    ) -> Result<(), ObserveError> {
        let is_figure = |name: &str| [".svg", ".png", ".html"].iter().any(|end| name.ends_with(end));
        self.own.retain(|name| !is_figure(name) || figures.contains(&self.folder.join(name)));
        let remove = |path: &Path| match std::fs::remove_file(path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(ObserveError::new(path, error)),
            _ => Ok(()),
        };
        for line in &self.known {
            if let Some(name) = line.strip_suffix("/*") {
                let written = if self.own.contains(line) { frames(name) } else { 0 };
                let folder = self.folder.join(name);
                for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
                    if frame_number(name, &entry.path()).is_some_and(|number| number >= written) {
                        remove(&entry.path())?;
                    }
                }
                if written == 0 {
                    // It may hold files of others.
                    let _kept = std::fs::remove_dir(&folder);
                }
            } else if !self.own.contains(line) {
                remove(&self.folder.join(line))?;
            }
        }
        self.save(&self.own)
    }
}

/// n of a file `name_n.vtu`.
fn frame_number(name: &str, path: &Path) -> Option<usize> {
    let file = path.file_name()?.to_str()?;
    file.strip_prefix(name)?.strip_prefix('_')?.strip_suffix(".vtu")?.parse().ok()
}
