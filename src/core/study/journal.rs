//! What a study that was killed goes on from.

use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::io::{Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::StudyError;
use crate::file::create_folder;

/// The outcomes of a study as they come, one line each behind the fingerprint of everything the outcome depends on.
///
/// A line is written in one piece; one that was cut short when the program was killed is dropped. Lines whose
/// fingerprint the study no longer asks for stay, for when it does again.
#[derive(Debug)]
pub(super) struct Journal {
    path: PathBuf,
    file: File,
}

impl Journal {
    /// Opens the journal of a folder, and reads what stands in it; an empty one where `fresh`.
    pub(super) fn open<R: DeserializeOwned>(
        folder: &Path,
        fresh: bool,
    ) -> Result<(Self, BTreeMap<u64, R>), StudyError> {
        create_folder(folder).map_err(|source| StudyError::io(folder, source))?;
        let path = folder.join("journal.csv");
        let io = |source| StudyError::io(&path, source);
        let mut file =
            File::options().read(true).write(true).create(true).truncate(false).open(&path).map_err(io)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(StudyError::Busy { path }),
            // A file system that cannot lock.
            Err(TryLockError::Error(error)) if error.kind() == std::io::ErrorKind::Unsupported => {}
            Err(TryLockError::Error(error)) => return Err(StudyError::io(&path, error)),
        }
        let bytes = if fresh { Vec::new() } else { std::fs::read(&path).map_err(io)? };
        let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |last| last + 1);
        file.set_len(whole as u64).map_err(io)?;
        file.seek(SeekFrom::End(0)).map_err(io)?;
        let mut known = BTreeMap::new();
        let mut reader =
            csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(&bytes[..whole]);
        // A line of another version of the program is none of ours.
        for line in reader.deserialize::<(u64, R)>().flatten() {
            known.insert(line.0, line.1);
        }
        Ok((Self { path, file }, known))
    }

    /// Adds an outcome.
    pub(super) fn add<R: Serialize>(&mut self, key: u64, outcome: &R) -> Result<(), StudyError> {
        let table = |source| StudyError::Table { path: self.path.clone(), source };
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        writer.serialize((key, outcome)).map_err(table)?;
        let line = writer.into_inner().map_err(|error| table(error.into_error().into()))?;
        self.file.write_all(&line).map_err(|source| StudyError::io(&self.path, source))
    }
}
