//! Files that appear whole or not at all, and drafts that outlive a killed program.

use std::fs::File;
use std::io::{self, Seek, Write};
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
        let draft = draft_in(folder)?;
        // Held while the draft is written, which tells it from one that a killed program left. Where there are no locks,
        // drafts that are left stay.
        #[cfg(unix)]
        let _without = draft.as_file().try_lock();
        Ok(Self { path: path.into(), draft })
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

/// Makes a folder and those above it, where they are not there.
///
/// # Errors
/// What the system says; a file in the place of one of them.
pub fn create_folder(folder: &Path) -> io::Result<()> {
    // What the system says of it is that a file exists.
    if let Some(file) = folder.ancestors().find(|path| path.is_file()) {
        let message = match file == folder {
            true => "it is a file; it must be a folder, or not exist".to_string(),
            false => format!("{} is a file; it must be a folder, or not exist", file.display()),
        };
        return Err(io::Error::new(io::ErrorKind::NotADirectory, message));
    }
    std::fs::create_dir_all(folder)
}

/// A new draft in a folder, which nobody holds; it is removed when it is dropped.
///
/// # Errors
/// What the system says.
pub fn draft_in(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).rand_bytes(RANDOM);
    // Results are for others to read, as far as the umask lets them.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// How the name of a draft begins, and how many letters and digits follow.
const PREFIX: &str = ".partial-";
const RANDOM: usize = 6;

/// Removes the drafts in a folder that killed programs left: those that nobody holds.
///
/// # Errors
/// What the system says of the folder, but for one that is not there.
pub fn remove_drafts(folder: &Path) -> io::Result<()> {
    let entries = match std::fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        entries => entries?,
    };
    for entry in entries {
        let path = entry?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let random = name.strip_prefix(PREFIX).unwrap_or_default();
        if random.len() != RANDOM || !random.bytes().all(|b| b.is_ascii_alphanumeric()) {
            continue;
        }
        // Another program may have moved it to its place in the meantime.
        let Ok(file) = File::open(&path) else { continue };
        if file.try_lock().is_ok() {
            let _gone = std::fs::remove_file(&path);
        }
    }
    Ok(())
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.draft.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.draft.flush()
    }
}

/// A draft that stays where it is when the program is killed, so that a later one goes on writing it;
/// [`commit`](Self::commit) copies it to its destination.
pub struct KeptDraft {
    draft: PathBuf,
    path: PathBuf,
    file: File,
}

impl KeptDraft {
    /// Opens `draft`, keeps its first `length` bytes and goes on behind them. Nothing of it is kept where `length`
    /// is 0.
    ///
    /// # Errors
    /// What the system says; a draft shorter than `length`.
    pub fn open(draft: &Path, path: &Path, length: u64) -> io::Result<Self> {
        let mut options = File::options();
        let file = options.write(true).read(true).create(length == 0).truncate(false).open(draft)?;
        let found = file.metadata()?.len();
        if found < length {
            let message = format!("{} has {found} bytes, {length} were written", draft.display());
            return Err(io::Error::new(io::ErrorKind::UnexpectedEof, message));
        }
        file.set_len(length)?;
        (&file).seek(io::SeekFrom::Start(length))?;
        Ok(Self { draft: draft.into(), path: path.into(), file })
    }

    /// The destination.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A second handle, which shares its place in the file with this one.
    ///
    /// # Errors
    /// What the system says.
    pub fn handle(&self) -> io::Result<File> {
        self.file.try_clone()
    }

    /// Bytes written so far, all of them on the disk.
    ///
    /// # Errors
    /// What the system says.
    pub fn position(&self) -> io::Result<u64> {
        self.file.sync_data()?;
        (&self.file).stream_position()
    }

    /// Copies the draft to its destination, whole or not at all.
    ///
    /// # Errors
    /// What the system says; what was there before then stays.
    pub fn commit(self) -> io::Result<()> {
        let mut copy = AtomicFile::create(&self.path)?;
        io::copy(&mut File::open(&self.draft)?, &mut copy)?;
        copy.commit()
    }
}
