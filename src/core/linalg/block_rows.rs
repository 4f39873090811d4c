//! Sparse block rows: the Jacobian H of a set of contacts.

use nalgebra::SVector;

use crate::scalar::Scalar;

/// A matrix of D-row blocks over n columns, H = [H^1; …; H^m], each block row a short list of (column, D-vector).
///
/// Rows are filled in order with [`start_row`](Self::start_row) and [`push`](Self::push); the buffers are kept,
/// so that a warm refill allocates nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockRows<T: Scalar, const D: usize> {
    starts: Vec<usize>,
    columns: Vec<usize>,
    entries: Vec<SVector<T, D>>,
}

impl<T: Scalar, const D: usize> Default for BlockRows<T, D> {
    fn default() -> Self {
        Self { starts: vec![0], columns: Vec::new(), entries: Vec::new() }
    }
}

impl<T: Scalar, const D: usize> BlockRows<T, D> {
    /// No rows.
    pub fn new() -> Self {
        Self::default()
    }

    /// Forgets the rows and keeps the memory.
    pub fn clear(&mut self) {
        self.truncate(0);
    }

    /// Becomes `other`, in the memory at hand.
    pub fn copy_from(&mut self, other: &Self) {
        self.starts.clone_from(&other.starts);
        self.columns.clone_from(&other.columns);
        self.entries.clone_from(&other.entries);
    }

    /// Keeps the first `rows` block rows.
    pub fn truncate(&mut self, rows: usize) {
        self.starts.truncate(rows + 1);
        let end = self.starts[self.starts.len() - 1];
        self.columns.truncate(end);
        self.entries.truncate(end);
    }

    /// Moves the entries of block row `row` `by` columns on: from the columns of a part to those of the whole.
    pub fn shift_row(&mut self, row: usize, by: usize) {
        if by > 0 {
            let (start, end) = (self.starts[row], self.starts[row + 1]);
            self.columns[start..end].iter_mut().for_each(|column| *column += by);
        }
    }

    /// Opens the next block row.
    pub fn start_row(&mut self) {
        self.starts.push(self.columns.len());
    }

    /// Appends the entry of one column to the open row.
    ///
    /// # Panics
    /// If no row was opened.
    pub fn push(&mut self, column: usize, entry: SVector<T, D>) {
        assert!(self.starts.len() > 1, "a row is opened before entries are pushed");
        self.columns.push(column);
        self.entries.push(entry);
        if let Some(end) = self.starts.last_mut() {
            *end = self.columns.len();
        }
    }

    /// Number of block rows m.
    pub fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// The entries of block row `row` with their columns.
    #[inline]
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, &SVector<T, D>)> {
        let range = self.starts[row]..self.starts[row + 1];
        self.columns[range.clone()].iter().copied().zip(&self.entries[range])
    }

    /// The entry at place `index` in the order of filling.
    #[inline]
    pub fn entry(&self, index: usize) -> &SVector<T, D> {
        &self.entries[index]
    }

    /// u = H^row v, the local velocity.
    #[inline]
    pub fn velocity(&self, row: usize, v: &[T]) -> SVector<T, D> {
        self.row(row).fold(SVector::zeros(), |u, (j, h)| u + h * v[j])
    }

    /// f ← f + (H^row)ᵀ p, the generalised impulse of a percussion.
    #[inline]
    pub fn add_transpose(&self, row: usize, p: &SVector<T, D>, f: &mut [T]) {
        self.row(row).for_each(|(j, h)| f[j] += h.dot(p));
    }

    /// The largest column of block row `row`; `None` for a row without entries.
    pub fn largest_column(&self, row: usize) -> Option<usize> {
        self.columns[self.starts[row]..self.starts[row + 1]].iter().copied().max()
    }
}
