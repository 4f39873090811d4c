//! The Delassus operator in block compressed rows.

use nalgebra::{SMatrix, SVector};

use crate::scalar::{Scalar, lit, to_f64};

/// A square matrix of D×D blocks in compressed block rows: full storage is the case where no block is absent.
///
/// Rows are filled in order with [`start_row`](Self::start_row) and [`push`](Self::push); the buffers are kept
/// from one filling to the next, so that a warm step allocates nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockMatrix<T: Scalar, const D: usize> {
    starts: Vec<usize>,
    columns: Vec<usize>,
    blocks: Vec<SMatrix<T, D, D>>,
    /// Place of W_αα in `blocks`; `usize::MAX` while a row has none.
    diagonal: Vec<usize>,
}

impl<T: Scalar, const D: usize> Default for BlockMatrix<T, D> {
    fn default() -> Self {
        Self { starts: vec![0], columns: Vec::new(), blocks: Vec::new(), diagonal: Vec::new() }
    }
}

impl<T: Scalar, const D: usize> BlockMatrix<T, D> {
    /// The empty matrix.
    pub fn new() -> Self {
        Self::default()
    }

    /// A matrix with every block present, from a function of the block row and the block column.
    pub fn from_fn(rows: usize, mut block: impl FnMut(usize, usize) -> SMatrix<T, D, D>) -> Self {
        let mut matrix = Self::new();
        for i in 0..rows {
            matrix.start_row();
            for j in 0..rows {
                matrix.push(j, block(i, j));
            }
        }
        matrix
    }

    /// Forgets the entries and keeps the memory.
    pub fn clear(&mut self) {
        self.starts.truncate(1);
        self.columns.clear();
        self.blocks.clear();
        self.diagonal.clear();
    }

    /// Opens the next block row.
    pub fn start_row(&mut self) {
        self.starts.push(self.blocks.len());
        self.diagonal.push(usize::MAX);
    }

    /// Appends a block to the open row; a column is given once per row.
    ///
    /// # Panics
    /// If no row was opened.
    pub fn push(&mut self, column: usize, block: SMatrix<T, D, D>) {
        let row = self.diagonal.len().checked_sub(1).expect("a row is opened before blocks are pushed");
        if column == row {
            self.diagonal[row] = self.blocks.len();
        }
        self.columns.push(column);
        self.blocks.push(block);
        self.starts[row + 1] = self.blocks.len();
    }

    /// The matrix in another arithmetic.
    pub fn cast<U: Scalar>(&self) -> BlockMatrix<U, D> {
        BlockMatrix {
            starts: self.starts.clone(),
            columns: self.columns.clone(),
            blocks: self.blocks.iter().map(|block| block.map(|x| lit(to_f64(x)))).collect(),
            diagonal: self.diagonal.clone(),
        }
    }

    /// Number of block rows.
    pub fn rows(&self) -> usize {
        self.diagonal.len()
    }

    /// Number of stored blocks.
    pub fn stored_blocks(&self) -> usize {
        self.blocks.len()
    }

    /// The stored blocks of row `row` with their columns.
    #[inline]
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, &SMatrix<T, D, D>)> {
        let range = self.starts[row]..self.starts[row + 1];
        self.columns[range.clone()].iter().copied().zip(&self.blocks[range])
    }

    /// The diagonal block of row `row`, `None` where it is not stored.
    #[inline]
    pub fn diagonal(&self, row: usize) -> Option<&SMatrix<T, D, D>> {
        self.blocks.get(self.diagonal[row])
    }

    /// Start of every row in the columns, and the columns.
    pub(crate) fn pattern(&self) -> (&[usize], &[usize]) {
        (&self.starts, &self.columns)
    }

    /// The stored blocks, row after row.
    pub(crate) fn blocks(&self) -> &[SMatrix<T, D, D>] {
        &self.blocks
    }

    /// Calls `change` with the row, the column and the block of every stored block.
    pub(crate) fn for_each_block(&mut self, mut change: impl FnMut(usize, usize, &mut SMatrix<T, D, D>)) {
        for row in 0..self.diagonal.len() {
            for entry in self.starts[row]..self.starts[row + 1] {
                change(row, self.columns[entry], &mut self.blocks[entry]);
            }
        }
    }

    /// (W r)_row.
    #[inline]
    pub fn row_product(&self, row: usize, r: &[SVector<T, D>]) -> SVector<T, D> {
        self.row(row).fold(SVector::zeros(), |sum, (j, block)| sum + block * r[j])
    }
}
