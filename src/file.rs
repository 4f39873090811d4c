//! Files that appear whole or not at all.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// A file written beside its destination and moved there by [`commit`](Self::commit): what was there before stays
/// until then, whatever interrupts the writing.
pub struct AtomicFile {
    path: PathBuf,
    draft: NamedTempFile,
}

impl AtomicFile {
    /// Opens a draft in the folder of `path`.
    ///
    /// # Errors
    /// What the system says, where the folder cannot be written to; a folder in the place of the file.
    pub fn create(path: &Path) -> io::Result<Self> {
        // Known now, and not when the results are there and nowhere to put them.
        if path.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "a folder is in its place"));
        }
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".partial-");
        // Results are for others to read, as far as the umask lets them.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        Ok(Self { path: path.into(), draft: builder.tempfile_in(folder)? })
    }

    /// The destination.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A second handle on the draft, for a buffered writer.
    ///
    /// # Errors
    /// What the system says.
    pub fn handle(&self) -> io::Result<File> {
        self.draft.reopen()
    }

    /// Moves the draft to its destination.
    ///
    /// # Errors
    /// What the system says; what was there before then stays.
    pub fn commit(self) -> io::Result<()> {
        self.draft.as_file().sync_all()?;
        self.draft.persist(&self.path).map(drop).map_err(|error| error.error)
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.draft.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.draft.flush()
    }
}
