//! What is wrong with an operator, or with its factors.

/// Why a matrix is not the operator it should be.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OperatorError {
    /// A NaN or an infinity.
    #[error("entry ({row}, {column}) is not finite")]
    NotFinite {
        /// Row.
        row: usize,
        /// Column.
        column: usize,
    },
    /// Not square.
    #[error("the matrix is {rows}×{columns}, it must be square")]
    NotSquare {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
    },
    /// A_ij ≠ A_ji.
    #[error(
        "the matrix is not symmetric: entries ({row}, {column}) and ({column}, {row}) differ by {difference:e}"
    )]
    NotSymmetric {
        /// Row.
        row: usize,
        /// Column.
        column: usize,
        /// A_ij − A_ji.
        difference: f64,
    },
    /// An index outside the matrix.
    #[error("entry ({row}, {column}) lies outside a matrix of size {size}")]
    OutOfBounds {
        /// Row.
        row: usize,
        /// Column.
        column: usize,
        /// Size n.
        size: usize,
    },
}

/// Why an operator could not be factored.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FactorError {
    /// A pivot is not positive.
    #[error("not positive definite: pivot {pivot} is not positive")]
    NotPositiveDefinite {
        /// Index of the pivot, in elimination order.
        pivot: usize,
    },
    /// More unknowns than the index type of the sparse factors counts.
    #[error("sparse factorisation: {unknowns} unknowns are more than 2³²")]
    TooLarge {
        /// Number of unknowns.
        unknowns: usize,
    },
    /// The sparse backend failed (sizes beyond its index type, memory).
    #[error("sparse factorisation failed")]
    Backend(#[source] faer::sparse::FaerError),
    /// The sparse backend chose another kind of factors than the one asked for.
    #[error("sparse factorisation: no supernodal factors although they were asked for")]
    NotSupernodal,
}

/// A pattern that is not that of compressed rows, ascending, symmetric, with the diagonal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("row {row} of the pattern does not ascend, lacks its diagonal, or is not symmetric")]
pub struct PatternError {
    /// The first row at fault.
    pub row: usize,
}

/// A matrix that has no factors: all pivots of a node are zero or not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("no pivot at node {node}")]
pub struct NoPivot {
    /// The node.
    pub node: usize,
}
