//! Cone problems from plain arrays, as other programs hold them.

use nalgebra::{SMatrix, SVector};

use super::{BlockMatrix, ConeProblem, ProblemError};
use crate::scalar::Scalar;

/// Arrays that make no cone problem.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ArraysError {
    /// An array has another length than the numbers of contacts and of dimensions ask for.
    #[error("{what} has {given} entries, {expected} are expected")]
    Length {
        /// The array.
        what: &'static str,
        /// Entries expected.
        expected: usize,
        /// Entries given.
        given: usize,
    },
    /// The row starts of compressed rows do not rise from 0 to the number of values.
    #[error("row {row} of W starts at entry {start} and ends at entry {end} of {entries}")]
    RowStart {
        /// Scalar row of W.
        row: usize,
        /// Where it starts.
        start: usize,
        /// Where it ends.
        end: usize,
        /// Number of values.
        entries: usize,
    },
    /// A column outside of W.
    #[error("row {row} of W names column {column}, there are {columns}")]
    Column {
        /// Scalar row of W.
        row: usize,
        /// The column.
        column: usize,
        /// Number of columns.
        columns: usize,
    },
    /// The numbers are no cone problem.
    #[error(transparent)]
    Problem(#[from] ProblemError),
}

fn check_length(what: &'static str, expected: usize, given: usize) -> Result<(), ArraysError> {
    if expected == given { Ok(()) } else { Err(ArraysError::Length { what, expected, given }) }
}

/// Blocks of D consecutive entries, one per contact.
fn blocks<T: Scalar, const D: usize>(entries: &[T]) -> Vec<SVector<T, D>> {
    entries.chunks_exact(D).map(SVector::from_column_slice).collect()
}

impl<T: Scalar, const D: usize> ConeProblem<T, D> {
    /// The problem with a dense W, row after row: (m D)² entries for m contacts, the components of a contact beside each
    /// other and ordered (N, T1, T2). `b` has m D entries and `friction` m.
    ///
    /// ```
    /// use nonsmooth::cone::ConeProblem;
    /// use nonsmooth::solver::{self, Stopping};
    ///
    /// // A mass of 2 kg that hits the ground at 3 m/s and slides at 1 m/s, μ = 0.1.
    /// let problem = ConeProblem::<f64, 2>::from_dense(&[0.5, 0.0, 0.0, 0.5], &[-3.0, 1.0], &[0.1])?;
    /// let mut solver = solver::build(solver::DEFAULT, Stopping::default())?;
    /// let mut percussions = vec![nalgebra::zero(); problem.contacts()];
    /// solver.solve(&problem, &percussions.clone(), &mut percussions)?;
    /// assert!((percussions[0][0] - 6.0).abs() < 1e-9 && (percussions[0][1] + 0.6).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ArraysError`].
    pub fn from_dense(delassus: &[T], b: &[T], friction: &[T]) -> Result<Self, ArraysError> {
        let contacts = friction.len();
        let size = contacts * D;
        check_length("W", size * size, delassus.len())?;
        check_length("b", size, b.len())?;
        let entry = |row: usize, column: usize| delassus[row * size + column];
        let matrix = BlockMatrix::from_fn(contacts, |i, j| {
            SMatrix::from_fn(|row, column| entry(i * D + row, j * D + column))
        });
        Ok(Self::new(matrix, blocks(b), friction.to_vec())?)
    }

    /// The problem with W in compressed sparse rows of scalars: the entries of row i are `columns` and `values` from
    /// `starts[i]` up to `starts[i + 1]`, in any order, those given twice added. Rows and columns are ordered as in
    /// [`from_dense`](Self::from_dense).
    ///
    /// # Errors
    /// [`ArraysError`].
    pub fn from_csr(
        starts: &[usize],
        columns: &[usize],
        values: &[T],
        b: &[T],
        friction: &[T],
    ) -> Result<Self, ArraysError> {
        let size = friction.len() * D;
        check_length("the row starts of W", size + 1, starts.len())?;
        check_length("the columns of W", values.len(), columns.len())?;
        check_length("b", size, b.len())?;
        let entries = values.len();
        for (row, ends) in starts.windows(2).enumerate() {
            let (start, end) = (ends[0], ends[1]);
            let first = row > 0 || start == 0;
            let last = row + 1 < size || end == entries;
            if !(first && last && start <= end && end <= entries) {
                return Err(ArraysError::RowStart { row, start, end, entries });
            }
            let outside = columns[start..end].iter().find(|&&column| column >= size);
            if let Some(&column) = outside {
                return Err(ArraysError::Column { row, column, columns: size });
            }
        }
        let mut matrix = BlockMatrix::new();
        // Place of each block column in the row being filled.
        let mut places = vec![usize::MAX; friction.len()];
        let mut row: Vec<(usize, SMatrix<T, D, D>)> = Vec::new();
        for contact in 0..friction.len() {
            row.clear();
            for component in 0..D {
                let at = contact * D + component;
                for entry in starts[at]..starts[at + 1] {
                    let (block, column) = (columns[entry] / D, columns[entry] % D);
                    if places[block] == usize::MAX {
                        places[block] = row.len();
                        row.push((block, SMatrix::zeros()));
                    }
                    row[places[block]].1[(component, column)] += values[entry];
                }
            }
            row.iter().for_each(|&(block, _)| places[block] = usize::MAX);
            row.sort_unstable_by_key(|&(block, _)| block);
            matrix.start_row();
            row.iter().for_each(|&(block, entries)| matrix.push(block, entries));
        }
        Ok(Self::new(matrix, blocks(b), friction.to_vec())?)
    }
}
