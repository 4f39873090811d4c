//! A CSV table written beside its destination and moved there whole.

use std::fs::File;
use std::io::Write as _;
use std::path::Path;

use super::{ObserveError, RunInfo};
use crate::file::{AtomicFile, KeptDraft};
use crate::scalar::{Scalar, to_f64};

/// Bytes gathered before they go to the file.
const BUFFER: usize = 1 << 16;

/// Where a table is written until it is whole.
enum Draft {
    Hidden(AtomicFile),
    Kept(KeptDraft),
}

impl Draft {
    fn path(&self) -> &Path {
        match self {
            Self::Hidden(file) => file.path(),
            Self::Kept(draft) => draft.path(),
        }
    }
}

/// A table written beside its destination and moved there whole, so that older results stay until then.
pub(super) struct Table {
    draft: Draft,
    handle: File,
    /// Rows not yet in the file.
    rows: Vec<u8>,
    /// What names the run, first in every row.
    pub(super) prefix: [String; 2],
    /// The same as it is written.
    begins: Vec<u8>,
    has_header: bool,
    digits: zmij::Buffer,
}

/// Appends a text as a field, with quotes where it needs them.
fn push_text(out: &mut Vec<u8>, text: &str) {
    if text.contains([',', '"', '\n', '\r']) {
        out.push(b'"');
        for byte in text.bytes() {
            if byte == b'"' {
                out.push(b'"');
            }
            out.push(byte);
        }
        out.push(b'"');
    } else {
        out.extend_from_slice(text.as_bytes());
    }
}

impl Table {
    /// A hidden draft, or one kept in the folder `drafts` with its first bytes.
    pub(super) fn create(
        folder: &Path,
        name: &str,
        drafts: Option<(&Path, u64)>,
    ) -> Result<Self, ObserveError> {
        let path = folder.join(name);
        let open = || -> std::io::Result<_> {
            Ok(match drafts {
                None => {
                    let file = AtomicFile::create(&path)?;
                    let handle = file.handle()?;
                    (Draft::Hidden(file), handle)
                }
                Some((drafts, length)) => {
                    let draft = KeptDraft::open(&drafts.join(name), &path, length)?;
                    let handle = draft.handle()?;
                    (Draft::Kept(draft), handle)
                }
            })
        };
        let (draft, handle) = open().map_err(|error| ObserveError::new(&path, error))?;
        Ok(Self {
            draft,
            handle,
            rows: Vec::with_capacity(2 * BUFFER),
            prefix: [String::new(), String::new()],
            begins: Vec::new(),
            has_header: drafts.is_some_and(|(_, length)| length > 0),
            digits: zmij::Buffer::new(),
        })
    }

    /// Names the run that the rows to come are of.
    pub(super) fn set_prefix(&mut self, prefix: [String; 2]) {
        self.begins.clear();
        for name in &prefix {
            push_text(&mut self.begins, name);
            self.begins.push(b',');
        }
        self.prefix = prefix;
    }

    /// Bytes on the disk; 0 for a hidden draft, which nobody finds again.
    pub(super) fn position(&mut self) -> Result<u64, ObserveError> {
        self.flush()?;
        match &self.draft {
            Draft::Hidden(_) => Ok(0),
            Draft::Kept(draft) => draft.position().map_err(|e| self.error(e)),
        }
    }

    pub(super) fn begin(
        &mut self,
        run: &RunInfo,
        columns: impl Iterator<Item = String>,
    ) -> Result<(), ObserveError> {
        self.set_prefix([run.law.clone(), run.solver.clone()]);
        if self.has_header {
            return Ok(());
        }
        self.has_header = true;
        self.rows.extend_from_slice(b"law,solver,step,time,");
        columns.for_each(|column| self.text(&column));
        self.end_row()
    }

    pub(super) fn start_row<T: Scalar>(&mut self, step: usize, time: T) {
        self.rows.extend_from_slice(&self.begins);
        // Writing to memory does not fail.
        let _infallible = write!(self.rows, "{step},");
        self.number(time);
    }

    pub(super) fn text(&mut self, text: &str) {
        push_text(&mut self.rows, text);
        self.rows.push(b',');
    }

    /// Numbers are written with the fewest digits that read back to the same value.
    pub(super) fn number<T: Scalar>(&mut self, x: T) {
        self.rows.extend_from_slice(self.digits.format(to_f64(x)).as_bytes());
        self.rows.push(b',');
    }

    pub(super) fn numbers<'a, T: Scalar>(&mut self, xs: impl IntoIterator<Item = &'a T>) {
        xs.into_iter().for_each(|&x| self.number(x));
    }

    /// Ends the row, whose last field left a comma.
    pub(super) fn end_row(&mut self) -> Result<(), ObserveError> {
        if let Some(last) = self.rows.last_mut() {
            *last = b'\n';
        }
        if self.rows.len() >= BUFFER { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), ObserveError> {
        let written = self.handle.write_all(&self.rows);
        self.rows.clear();
        written.map_err(|e| self.error(e))
    }

    pub(super) fn commit(mut self) -> Result<(), ObserveError> {
        self.flush()?;
        let path = self.draft.path().to_path_buf();
        let done = match self.draft {
            Draft::Hidden(file) => file.commit(),
            Draft::Kept(draft) => draft.commit(),
        };
        done.map_err(|error| ObserveError::new(&path, error))
    }

    fn error(&self, error: impl std::error::Error + Send + Sync + 'static) -> ObserveError {
        ObserveError::new(self.draft.path(), error)
    }
}
