//! Solvers over problems, tolerances and arithmetics: what accuracy costs.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;

use super::tables::table;
use super::{Benchmark, CollectionError, Measurement};
use crate::scalar::Scalar;

/// Measurements of the same solvers on the same problems to several tolerances, in `f64`, `f32` or both.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sweep {
    /// One per problem, solver, tolerance and arithmetic.
    pub measurements: Vec<Measurement>,
}

impl Sweep {
    /// The tolerances, the coarsest first.
    pub fn tolerances(&self) -> Vec<f64> {
        let mut all: Vec<f64> = self.measurements.iter().map(|m| m.tolerance).collect();
        all.sort_by(|a, b| b.total_cmp(a));
        all.dedup();
        all
    }

    /// The problems with their numbers of contacts, the largest first.
    pub fn problems(&self) -> Vec<(usize, &str)> {
        let all: BTreeSet<_> = self.measurements.iter().map(|m| (m.contacts, m.problem.as_str())).collect();
        all.into_iter().rev().collect()
    }

    /// Solvers with their arithmetics, in the order in which they were first measured.
    pub fn solvers(&self) -> Vec<(&str, &str)> {
        let mut seen = BTreeSet::new();
        let names = self.measurements.iter().map(|m| (m.solver.as_str(), m.scalar.as_str()));
        names.filter(|name| seen.insert(*name)).collect()
    }

    /// The comparison at one tolerance in one arithmetic.
    pub fn at(&self, tolerance: f64, scalar: &str) -> Benchmark {
        let here = self.measurements.iter().filter(|m| m.tolerance == tolerance && m.scalar == scalar);
        Benchmark { measurements: here.cloned().collect(), tolerance }
    }

    /// Number of problems a solver solved to a tolerance, and the CPU time (s) in which it solved half of all problems, to
    /// the nearest one; `None` where it did not solve that many.
    pub fn solved(&self, (solver, scalar): (&str, &str), tolerance: f64) -> (usize, Option<f64>) {
        let own = |m: &&Measurement| m.solver == solver && m.scalar == scalar && m.tolerance == tolerance;
        let solved = self.measurements.iter().filter(own).filter(|m| m.solved);
        let mut times: Vec<f64> = solved.map(|m| m.cpu_seconds).collect();
        times.sort_by(f64::total_cmp);
        let half = self.problems().len().div_ceil(2);
        (times.len(), half.checked_sub(1).and_then(|place| times.get(place).copied()))
    }

    /// The table of the terminal: problems solved, and the time for half of them, at every tolerance.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_table(&self, out: &mut dyn Write) -> std::io::Result<()> {
        let (solvers, problems) = (self.solvers(), self.problems().len());
        let names: Vec<String> = solvers.iter().map(|(solver, scalar)| full_name(solver, scalar)).collect();
        let width = names.iter().map(|name| name.chars().count()).max().unwrap_or(0).max(6);
        let head = |out: &mut dyn Write, title: &str| {
            write!(out, "{title:width$}")?;
            self.tolerances().iter().try_for_each(|tolerance| write!(out, " {tolerance:>8.0e}"))?;
            writeln!(out)
        };
        head(out, "solver")?;
        for (name, solver) in names.iter().zip(&solvers) {
            write!(out, "{name:width$}")?;
            for tolerance in self.tolerances() {
                write!(out, " {:>8}", self.solved(*solver, tolerance).0)?;
            }
            writeln!(out)?;
        }
        writeln!(out, "problems solved of {problems}\n")?;
        head(out, "solver")?;
        for (name, solver) in names.iter().zip(&solvers) {
            write!(out, "{name:width$}")?;
            for tolerance in self.tolerances() {
                let time =
                    self.solved(*solver, tolerance).1.map_or("—".into(), |time| format!("{time:.1e}"));
                write!(out, " {time:>8}")?;
            }
            writeln!(out)?;
        }
        writeln!(out, "CPU time (s) in which a solver solves half of the problems")
    }

    /// Writes `results.csv`, a row per problem, solver, tolerance and arithmetic, into a folder.
    ///
    /// # Errors
    /// [`CollectionError::Io`], [`CollectionError::Table`].
    pub fn write_csv(&self, folder: &Path) -> Result<(), CollectionError> {
        table(&folder.join("results.csv"), self.measurements.iter())
    }
}

/// Name of a solver in an arithmetic; double precision goes without saying.
pub(super) fn full_name(solver: &str, scalar: &str) -> String {
    if scalar == f64::NAME { solver.into() } else { format!("{solver} {scalar}") }
}
