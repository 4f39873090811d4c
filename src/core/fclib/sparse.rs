//! A sparse matrix of scalars in compressed rows, as the files hold it.

use super::FclibError;
use super::store::Store;

/// Rows in order, columns ascending within a row, each column once.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseMatrix {
    columns: usize,
    starts: Vec<usize>,
    indices: Vec<u32>,
    values: Vec<f64>,
}

impl SparseMatrix {
    /// A matrix from entries in any order; entries of one place are added up.
    ///
    /// # Panics
    /// If an entry lies outside, or if there are more than 2³² columns.
    pub fn from_entries(rows: usize, columns: usize, entries: &[(u32, u32, f64)]) -> Self {
        assert!(columns <= u32::MAX as usize, "columns are counted in 32 bits");
        let mut starts = vec![0_usize; rows + 1];
        entries.iter().for_each(|&(row, _, _)| starts[row as usize + 1] += 1);
        (0..rows).for_each(|row| starts[row + 1] += starts[row]);
        let mut next = starts.clone();
        let mut sorted = vec![(0_u32, 0.0); entries.len()];
        for &(row, column, value) in entries {
            assert!((column as usize) < columns, "column {column} of {columns}");
            let place = &mut next[row as usize];
            sorted[*place] = (column, value);
            *place += 1;
        }
        let (mut indices, mut values) =
            (Vec::with_capacity(entries.len()), Vec::with_capacity(entries.len()));
        let mut begin = 0;
        for row in 0..rows {
            let end = starts[row + 1];
            let line = &mut sorted[begin..end];
            line.sort_by_key(|&(column, _)| column);
            starts[row] = indices.len();
            for &(column, value) in &*line {
                if indices.len() > starts[row] && indices.last() == Some(&column) {
                    *values.last_mut().expect("as many values as indices") += value;
                } else {
                    indices.push(column);
                    values.push(value);
                }
            }
            begin = end;
        }
        starts[rows] = indices.len();
        Self { columns, starts, indices, values }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Number of stored entries.
    pub fn stored(&self) -> usize {
        self.values.len()
    }

    /// Columns and values of a row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> + Clone {
        let range = self.starts[row]..self.starts[row + 1];
        self.indices[range.clone()].iter().map(|&j| j as usize).zip(self.values[range].iter().copied())
    }

    /// Every entry as (row, column, value), row by row.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        (0..self.rows()).flat_map(|i| self.row(i).map(move |(j, x)| (i, j, x)))
    }

    /// y ← y + A x.
    ///
    /// # Panics
    /// If `x` or `y` has the wrong length.
    pub fn multiply_add(&self, x: &[f64], y: &mut [f64]) {
        assert_eq!((x.len(), y.len()), (self.columns, self.rows()), "lengths of x and y");
        for (i, y) in y.iter_mut().enumerate() {
            *y += self.row(i).map(|(j, a)| a * x[j]).sum::<f64>();
        }
    }

    /// y ← y + Aᵀ x.
    ///
    /// # Panics
    /// If `x` or `y` has the wrong length.
    pub fn multiply_add_transposed(&self, x: &[f64], y: &mut [f64]) {
        assert_eq!((x.len(), y.len()), (self.rows(), self.columns), "lengths of x and y");
        self.entries().for_each(|(i, j, a)| y[j] += a * x[i]);
    }

    /// Row starts, column indices and values: compressed rows, 0-based.
    pub(super) fn parts(&self) -> (&[usize], &[u32], &[f64]) {
        (&self.starts, &self.indices, &self.values)
    }
}

/// The size of a stored matrix, read before anything is allocated for it.
pub(super) struct Header {
    path: String,
    pub(super) rows: usize,
    pub(super) columns: usize,
    nz: i64,
    nzmax: usize,
}

impl Header {
    pub(super) fn read(store: &mut Store, path: &str) -> Result<Self, FclibError> {
        let rows = store.count(&format!("{path}/m"))?;
        let columns = store.count(&format!("{path}/n"))?;
        let nzmax = store.count(&format!("{path}/nzmax"))?;
        let nz = store.integer(&format!("{path}/nz"))?;
        if nz < -2 {
            return Err(FclibError::Storage { dataset: format!("{path}/nz"), value: nz });
        }
        if nz > nzmax as i64 {
            return Err(FclibError::Length {
                dataset: format!("{path}/nzmax"),
                expected: nz.unsigned_abs(),
                found: nzmax as u64,
            });
        }
        Ok(Self { path: path.into(), rows, columns, nz, nzmax })
    }

    pub(super) fn refuse(&self, expected: impl Into<String>) -> FclibError {
        let (rows, columns) = (self.rows, self.columns);
        FclibError::Shape { matrix: self.path.clone(), rows, columns, expected: expected.into() }
    }

    /// Reads the entries.
    pub(super) fn body(&self, store: &mut Store) -> Result<SparseMatrix, FclibError> {
        let names = ["i", "p", "x"].map(|name| format!("{}/{name}", self.path));
        let [name_i, name_p, name_x] = &names;
        // The row starts of the result.
        store.charge(&self.path, 16 * (self.rows as u64 + 1))?;
        let (rows, columns, used) = match self.nz {
            -2 | -1 => {
                let (major, minor) =
                    if self.nz == -2 { (self.rows, self.columns) } else { (self.columns, self.rows) };
                let starts = store.integers(name_p, &[major + 1])?;
                let used = check_starts(name_p, &starts, self.nzmax)?;
                let minors = store.integers(name_i, &[self.nzmax])?;
                let minors = check_indices(name_i, &minors[..used], minor)?;
                store.charge(name_p, 4 * used as u64)?;
                let majors: Vec<u32> = (0_u32..)
                    .zip(starts.windows(2))
                    .flat_map(|(line, ends)| (ends[0]..ends[1]).map(move |_| line))
                    .collect();
                if self.nz == -2 { (majors, minors, used) } else { (minors, majors, used) }
            }
            nz => {
                let used = nz as usize;
                let rows = store.integers(name_i, &[used, self.nzmax])?;
                let columns = store.integers(name_p, &[used, self.nzmax])?;
                (
                    check_indices(name_i, &rows[..used], self.rows)?,
                    check_indices(name_p, &columns[..used], self.columns)?,
                    used,
                )
            }
        };
        let values = store.reals(name_x, &[self.nzmax])?;
        store.charge(&self.path, 16 * used as u64)?;
        let entries: Vec<_> =
            rows.into_iter().zip(columns).zip(values).map(|((i, j), x)| (i, j, x)).collect();
        Ok(SparseMatrix::from_entries(self.rows, self.columns, &entries))
    }
}

fn check_starts(dataset: &str, starts: &[i64], nzmax: usize) -> Result<usize, FclibError> {
    let mut previous = 0;
    for (position, &value) in starts.iter().enumerate() {
        let ascends = if position == 0 { value == 0 } else { value >= previous };
        if !ascends || value > nzmax as i64 {
            return Err(FclibError::Start { dataset: dataset.into(), position, value, bound: nzmax });
        }
        previous = value;
    }
    Ok(previous as usize)
}

fn check_indices(dataset: &str, indices: &[i64], bound: usize) -> Result<Vec<u32>, FclibError> {
    let narrow = |(position, &value): (usize, &i64)| match u32::try_from(value) {
        Ok(index) if (index as usize) < bound => Ok(index),
        _ => Err(FclibError::Index { dataset: dataset.into(), position, value, bound }),
    };
    indices.iter().enumerate().map(narrow).collect()
}
