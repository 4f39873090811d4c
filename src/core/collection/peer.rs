//! Results of other programs on the same problems, one JSON object per line.

use std::path::Path;

use serde::Deserialize;

use super::{Benchmark, CollectionError, Measurement};

/// A line of a peer: what a benchmark script printed for one problem and one of its solvers.
#[derive(Deserialize)]
struct Line {
    problem: String,
    solver: String,
    #[serde(default)]
    nc: usize,
    #[serde(default)]
    dim: usize,
    tol: f64,
    converged: bool,
    time: Option<f64>,
    residual: Option<f64>,
    iterations: Option<usize>,
}

impl Benchmark {
    /// Adds the results of a peer at the tolerance of this comparison, its solvers named `peer/SOLVER`.
    ///
    /// The file has one JSON object per line with the keys `problem`, `solver`, `tol`, `converged`, `time` (CPU s or null),
    /// `residual` (natural map or null), `iterations`, `nc` and `dim`; problems are matched by name, lines of other
    /// problems and tolerances are passed over.
    ///
    /// # Errors
    /// [`CollectionError::Io`], [`CollectionError::Peer`] with the line that is malformed.
    pub fn add_peer(&mut self, peer: &str, path: &Path) -> Result<usize, CollectionError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| CollectionError::Io { path: path.into(), source })?;
        let known: std::collections::BTreeSet<String> =
            self.measurements.iter().map(|m| m.problem.clone()).collect();
        let mut added = 0;
        for (number, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
            // Python writes numbers that JSON does not have.
            let line = [": NaN", ": Infinity", ": -Infinity"]
                .iter()
                .fold(line.to_string(), |line, value| line.replace(value, ": null"));
            let line: Line = serde_json::from_str(&line).map_err(|error| CollectionError::Peer {
                path: path.into(),
                line: number + 1,
                message: error.to_string(),
            })?;
            // The same decimal number in two programs may differ in its last bit.
            let same = (line.tol - self.tolerance).abs() <= 1e-6 * self.tolerance;
            if !same || !known.contains(&line.problem) {
                continue;
            }
            added += 1;
            self.measurements.push(Measurement {
                problem: line.problem,
                contacts: line.nc,
                dimension: line.dim,
                solver: format!("{peer}/{}", line.solver),
                peer: true,
                scalar: <f64 as crate::scalar::Scalar>::NAME.into(),
                tolerance: self.tolerance,
                // Converged without a time is of no use to a comparison of times.
                solved: line.converged && line.time.is_some_and(|t| t >= 0.0),
                iterations: line.iterations.unwrap_or(0),
                residual: line.residual.unwrap_or(f64::NAN),
                scaled_residual: f64::NAN,
                cpu_seconds: line.time.unwrap_or(f64::NAN),
                curve: Vec::new(),
            });
        }
        Ok(added)
    }
}
