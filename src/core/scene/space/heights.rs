//! Height fields as scene files write them.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::shape::{read, refuse};
use crate::geometry::{SurfaceError, Terrain};
use crate::scalar::{Scalar, lit};
use crate::scene::SceneError;

/// Heights over a grid, given by `rows` or by a `file`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeightsSpec {
    /// Rows of heights, along x in a row and along y from row to row (m).
    pub rows: Option<Vec<Vec<f64>>>,
    /// Text file with a row in each line, numbers between blanks, commas or semicolons; `#` begins a comment.
    pub file: Option<PathBuf>,
    /// Distance between heights along x and along y (m).
    pub cell: [f64; 2],
    /// Place of the first height (m).
    #[serde(default)]
    pub origin: [f64; 2],
}

impl HeightsSpec {
    pub(super) fn terrain<T: Scalar>(
        &self,
        label: &str,
        folder: &Path,
    ) -> Result<Result<Terrain<T>, SurfaceError>, SceneError> {
        let rows = match (&self.rows, &self.file) {
            (Some(rows), None) => rows.clone(),
            (None, Some(file)) => {
                let text = read(label, &folder.join(file))?;
                numbers(&String::from_utf8_lossy(&text)).map_err(|source| refuse(label, file, source))?
            }
            _ => {
                let message = "give either `rows` or a `file`".into();
                return Ok(Err(SurfaceError::Heights { message }));
            }
        };
        let rows: Vec<Vec<T>> = rows.iter().map(|row| row.iter().map(|&z| lit(z)).collect()).collect();
        Ok(Terrain::heights(&rows, self.cell.map(lit), self.origin.map(lit)))
    }
}

/// The numbers of a text, row by row.
fn numbers(text: &str) -> Result<Vec<Vec<f64>>, SurfaceError> {
    let mut rows = Vec::new();
    for (line, content) in (1..).zip(text.lines()) {
        let content = content.split('#').next().unwrap_or_default();
        let words = content.split(|c: char| c.is_whitespace() || c == ',' || c == ';');
        let number = |word: &str| {
            word.parse().map_err(|_| SurfaceError::Text { line, message: format!("`{word}` is no number") })
        };
        let row: Vec<f64> = words.filter(|word| !word.is_empty()).map(number).collect::<Result<_, _>>()?;
        if !row.is_empty() {
            rows.push(row);
        }
    }
    Ok(rows)
}
