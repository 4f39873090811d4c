//! The HDF5 file behind a guard: every dataset is measured before it is read.

use hdf5_pure::{DType, Dataset, Error, File, FormatError, VlenStringReadOptions};

use super::FclibError;

/// Bytes a file of `size` bytes may unfold to in memory: 16 MiB + 128 × size.
///
/// gzip expands at most 1032-fold, and that only for constant data. Delassus operators, masses and their index
/// arrays stay far below 128 taken together; a file that declares more lies, or is made to exhaust the memory.
pub const fn allowance(size: u64) -> u64 {
    (16 << 20) + size.saturating_mul(128)
}

/// Longest title or description read, in bytes.
const TEXT_LIMIT: u64 = 1 << 20;

/// An open file with what is left of its allowance.
pub(super) struct Store {
    file: File,
    left: u64,
}

fn damaged(at: &str, error: &Error) -> FclibError {
    FclibError::Hdf5 { at: at.into(), message: error.to_string() }
}

impl Store {
    pub(super) fn new(bytes: Vec<u8>) -> Result<Self, FclibError> {
        let left = allowance(bytes.len() as u64);
        let file = File::from_bytes(bytes).map_err(|e| damaged("/", &e))?;
        Ok(Self { file, left })
    }

    /// Books memory that the content of the file asks for.
    pub(super) fn charge(&mut self, dataset: &str, bytes: u64) -> Result<(), FclibError> {
        let too_large = FclibError::TooLarge { dataset: dataset.into(), bytes, allowance: self.left };
        self.left = self.left.checked_sub(bytes).ok_or(too_large)?;
        Ok(())
    }

    pub(super) fn has_group(&self, path: &str) -> Result<bool, FclibError> {
        match self.file.group(path) {
            Ok(_) => Ok(true),
            Err(Error::Format(FormatError::PathNotFound(_))) => Ok(false),
            Err(e) => Err(damaged(path, &e)),
        }
    }

    fn find(&self, path: &str) -> Result<Option<Dataset>, FclibError> {
        match self.file.dataset(path) {
            Ok(dataset) => Ok(Some(dataset)),
            Err(Error::Format(FormatError::PathNotFound(_))) => Ok(None),
            Err(e) => Err(damaged(path, &e)),
        }
    }

    pub(super) fn has_dataset(&self, path: &str) -> Result<bool, FclibError> {
        Ok(self.find(path)?.is_some())
    }

    /// The dataset, whose length is one of `lengths` and whose memory has been booked.
    fn measured(
        &mut self,
        path: &str,
        lengths: &[usize],
        integer: bool,
    ) -> Result<(Dataset, u64), FclibError> {
        let dataset = self.find(path)?.ok_or_else(|| FclibError::Missing { dataset: path.into() })?;
        let kind = dataset.dtype().map_err(|e| damaged(path, &e))?;
        use DType::{F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
        let fits = match kind {
            I8 | I16 | I32 | I64 | U8 | U16 | U32 | U64 => true,
            F32 | F64 => !integer,
            _ => false,
        };
        if !fits {
            let expected = if integer { "integers" } else { "numbers" };
            return Err(FclibError::Kind { dataset: path.into(), expected, found: kind.to_string() });
        }
        let shape = dataset.shape().map_err(|e| damaged(path, &e))?;
        let found = shape.iter().fold(1_u64, |n, &d| n.saturating_mul(d));
        if !lengths.iter().any(|&length| length as u64 == found) {
            let expected = lengths.first().map_or(0, |&length| length as u64);
            return Err(FclibError::Length { dataset: path.into(), expected, found });
        }
        self.charge(path, found.saturating_mul(8))?;
        // A chunk is unpacked whole, whatever part of it the dataset covers.
        if let Some(chunk) = dataset.chunk_shape().map_err(|e| damaged(path, &e))? {
            let bytes = chunk.iter().fold(8_u64, |n, &d| n.saturating_mul(d));
            if bytes > self.left.saturating_add(found.saturating_mul(8)) {
                return Err(FclibError::TooLarge { dataset: path.into(), bytes, allowance: self.left });
            }
        }
        Ok((dataset, found))
    }

    fn complete<N>(path: &str, values: Vec<N>, expected: u64) -> Result<Vec<N>, FclibError> {
        match values.len() as u64 {
            found if found == expected => Ok(values),
            found => Err(FclibError::Length { dataset: path.into(), expected, found }),
        }
    }

    /// Finite real numbers; `lengths` are the lengths allowed, the first one is named in the error.
    pub(super) fn reals(&mut self, path: &str, lengths: &[usize]) -> Result<Vec<f64>, FclibError> {
        let (dataset, length) = self.measured(path, lengths, false)?;
        let values = dataset.read_f64().map_err(|e| damaged(path, &e))?;
        match values.iter().position(|x| !x.is_finite()) {
            Some(position) => Err(FclibError::NotFinite { dataset: path.into(), position }),
            None => Self::complete(path, values, length),
        }
    }

    pub(super) fn integers(&mut self, path: &str, lengths: &[usize]) -> Result<Vec<i64>, FclibError> {
        let (dataset, length) = self.measured(path, lengths, true)?;
        let values = dataset.read_i64().map_err(|e| damaged(path, &e))?;
        Self::complete(path, values, length)
    }

    pub(super) fn integer(&mut self, path: &str) -> Result<i64, FclibError> {
        Ok(self.integers(path, &[1])?[0])
    }

    /// A count stored as int32.
    pub(super) fn count(&mut self, path: &str) -> Result<usize, FclibError> {
        let value = self.integer(path)?;
        let refused = || FclibError::Count { dataset: path.into(), value };
        i32::try_from(value).ok().and_then(|n| usize::try_from(n).ok()).ok_or_else(refused)
    }

    /// A text, `None` where it is absent; bytes that are not UTF-8 are replaced.
    pub(super) fn text(&mut self, path: &str) -> Result<Option<String>, FclibError> {
        let Some(dataset) = self.find(path)? else { return Ok(None) };
        let kind = dataset.dtype().map_err(|e| damaged(path, &e))?;
        let shape = dataset.shape().map_err(|e| damaged(path, &e))?;
        let count = shape.iter().fold(1_u64, |n, &d| n.saturating_mul(d));
        if count != 1 {
            return Err(FclibError::Length { dataset: path.into(), expected: 1, found: count });
        }
        if kind == DType::VariableLengthString {
            let limits =
                VlenStringReadOptions::new().with_max_elements(1).with_max_payload_bytes(TEXT_LIMIT as usize);
            let text = dataset.read_vlen_strings(limits).map_err(|e| damaged(path, &e))?;
            return Ok(text.into_iter().next().map(|text| text.split('\0').next().unwrap_or("").into()));
        }
        if kind != DType::String {
            return Err(FclibError::Kind { dataset: path.into(), expected: "text", found: kind.to_string() });
        }
        let bytes = dataset.element_size().map_err(|e| damaged(path, &e))?;
        if bytes > TEXT_LIMIT {
            return Err(FclibError::TooLarge { dataset: path.into(), bytes, allowance: TEXT_LIMIT });
        }
        let raw = dataset.read_raw().map_err(|e| damaged(path, &e))?;
        let end = raw.iter().position(|&byte| byte == 0).unwrap_or(raw.len());
        Ok(Some(String::from_utf8_lossy(&raw[..end]).into_owned()))
    }
}
