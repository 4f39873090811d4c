//! What can be wrong with an FCLIB file.

use std::path::PathBuf;

use crate::cone::ProblemError;

/// Why a file is not an FCLIB problem, or could not be written.
#[derive(Debug, thiserror::Error)]
pub enum FclibError {
    /// The file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The bytes are not HDF5, or a part of the file that is needed is damaged.
    #[error("HDF5, {at}: {message}")]
    Hdf5 {
        /// Dataset or group, `/` for the file as a whole.
        at: String,
        /// What the HDF5 reader found.
        message: String,
    },
    /// Neither `/fclib_local` nor `/fclib_global` is there.
    #[error("the file holds neither /fclib_local nor /fclib_global")]
    NotFclib,
    /// A dataset the layout asks for is absent.
    #[error("{dataset} is missing")]
    Missing {
        /// Path inside the file.
        dataset: String,
    },
    /// A dataset does not hold what the layout asks for.
    #[error("{dataset} holds {found}, {expected} are asked for")]
    Kind {
        /// Path inside the file.
        dataset: String,
        /// What the layout asks for.
        expected: &'static str,
        /// Type found.
        found: String,
    },
    /// A dataset has a length that contradicts the rest of the file.
    #[error("{dataset} has {found} values, {expected} are asked for")]
    Length {
        /// Path inside the file.
        dataset: String,
        /// Length the rest of the file implies.
        expected: u64,
        /// Length found.
        found: u64,
    },
    /// The file declares more data than a file of its size can honestly hold.
    #[error("{dataset} declares {bytes} bytes, the file's allowance is {allowance}")]
    TooLarge {
        /// Path inside the file.
        dataset: String,
        /// Bytes the dataset would take in memory.
        bytes: u64,
        /// Bytes left of the allowance, see [`allowance`](super::allowance).
        allowance: u64,
    },
    /// `spacedim` is neither 2 nor 3.
    #[error("{dataset} is {value}, it must be 2 or 3")]
    Dimension {
        /// Path inside the file.
        dataset: String,
        /// The value refused.
        value: i64,
    },
    /// A count is negative or beyond what the format can store (int32).
    #[error("{dataset} is {value}, it must be between 0 and 2147483647")]
    Count {
        /// Path inside the file.
        dataset: String,
        /// The value refused.
        value: i64,
    },
    /// `nz` names none of the three storages.
    #[error(
        "{dataset} is {value}: -2 (compressed rows), -1 (compressed columns) or ≥ 0 (triplets) are known"
    )]
    Storage {
        /// Path inside the file.
        dataset: String,
        /// The value refused.
        value: i64,
    },
    /// A matrix has the wrong shape.
    #[error("{matrix} is {rows} × {columns}, {expected} is asked for")]
    Shape {
        /// Path inside the file.
        matrix: String,
        /// Rows declared.
        rows: usize,
        /// Columns declared.
        columns: usize,
        /// What is asked for, in words.
        expected: String,
    },
    /// A row or column index is outside the matrix.
    #[error("{dataset}[{position}] is {value}, it must be between 0 and {bound} (excluded)")]
    Index {
        /// Path inside the file.
        dataset: String,
        /// Place in the dataset.
        position: usize,
        /// The index refused.
        value: i64,
        /// Number of rows or columns.
        bound: usize,
    },
    /// The starts of the compressed rows or columns do not ascend from 0 to at most `nzmax`.
    #[error("{dataset}[{position}] is {value}: starts ascend from 0 to at most {bound}")]
    Start {
        /// Path inside the file.
        dataset: String,
        /// Place in the dataset.
        position: usize,
        /// The start refused.
        value: i64,
        /// Number of entries stored.
        bound: usize,
    },
    /// A NaN or an infinity.
    #[error("{dataset}[{position}] is not finite")]
    NotFinite {
        /// Path inside the file.
        dataset: String,
        /// Place in the dataset.
        position: usize,
    },
    /// μ < 0.
    #[error("the coefficient of friction of contact {contact} is {value}, it must be ≥ 0")]
    NegativeFriction {
        /// Index of the contact.
        contact: usize,
        /// The value refused.
        value: f64,
    },
    /// A matrix that must be inverted to reach a local problem is singular to working precision.
    #[error("{matrix} is singular to working precision at row {row}")]
    Singular {
        /// Name of the matrix.
        matrix: &'static str,
        /// A row of the singular part.
        row: usize,
    },
    /// W = Hᵀ M⁻¹ H would have too many entries.
    #[error("the condensed W has {entries} entries, more than {limit}: use a solver that keeps M and H")]
    Dense {
        /// Entries W would have.
        entries: u64,
        /// Largest number accepted, see [`CONDENSED_LIMIT`](super::CONDENSED_LIMIT).
        limit: u64,
    },
    /// A contact with rolling resistance, which the layout does not know.
    #[error("contact {contact} has rolling resistance, which FCLIB files do not hold")]
    Rolling {
        /// Index of the contact.
        contact: usize,
    },
    /// The data were read, but they are not a cone problem.
    #[error(transparent)]
    Problem(#[from] ProblemError),
}
