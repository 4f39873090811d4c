//! What a comparison says: a summary per solver, ratios to peers, profiles, and the same as CSV.

use std::io::Write;
use std::path::Path;

use serde::Serialize;

use super::{Benchmark, CollectionError, Measurement, Profile, profile};
use crate::file::{AtomicFile, create_folder};

/// A solver over all problems.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SolverSummary {
    /// Name of the solver.
    pub solver: String,
    /// Problems it solved.
    pub solved: usize,
    /// Problems it was tried on.
    pub tried: usize,
    /// Iterations over the problems it solved.
    pub iterations: usize,
    /// CPU time over the problems it solved (s).
    pub cpu_seconds: f64,
    /// Median CPU time of the problems it solved (s); not a number where there is none.
    pub median_seconds: f64,
    /// Largest natural-map residual of the problems it solved.
    pub worst_residual: f64,
    /// Largest scaled residual of the problems it solved; not a number for a peer.
    pub worst_scaled_residual: f64,
    /// Problems it did not solve.
    pub failed: Vec<String>,
}

/// A solver against the fastest peer on one problem.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ratio {
    /// Name of the problem.
    pub problem: String,
    /// Number of contacts.
    pub contacts: usize,
    /// CPU time of the solver (s), `None` where it did not solve the problem.
    pub seconds: Option<f64>,
    /// The fastest peer that solved it.
    pub peer: Option<String>,
    /// CPU time of that peer (s).
    pub peer_seconds: Option<f64>,
    /// Peer time over solver time, where both solved it: above 1 the solver is faster.
    pub ratio: Option<f64>,
}

/// A number for people, a dash where there is none.
fn number(value: f64) -> String {
    if value.is_nan() { "—".into() } else { format!("{value:.1e}") }
}

/// Middle of a set of numbers; not a number where it is empty.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match (values.len(), values.len() / 2) {
        (0, _) => f64::NAN,
        (n, half) if n % 2 == 1 => values[half],
        (_, half) => 0.5 * (values[half - 1] + values[half]),
    }
}

impl Benchmark {
    /// The solvers in the order in which they were first measured.
    pub fn solvers(&self) -> Vec<String> {
        self.names(|m| &m.solver)
    }

    /// The problems in the order in which they were first measured.
    pub fn problems(&self) -> Vec<String> {
        self.names(|m| &m.problem)
    }

    fn names(&self, name: impl Fn(&Measurement) -> &String) -> Vec<String> {
        let mut seen = std::collections::BTreeSet::new();
        self.measurements.iter().map(name).filter(|name| seen.insert(*name)).cloned().collect()
    }

    /// One summary per solver.
    pub fn summaries(&self) -> Vec<SolverSummary> {
        let summary = |solver: String| {
            let tried: Vec<_> = self.measurements.iter().filter(|m| m.solver == solver).collect();
            let solved: Vec<_> = tried.iter().filter(|m| m.solved).collect();
            let worst = |value: fn(&Measurement) -> f64| {
                // Unknown stays unknown.
                solved.iter().map(|m| value(m)).fold(0.0_f64, |a, b| if b.is_nan() { b } else { a.max(b) })
            };
            SolverSummary {
                solved: solved.len(),
                tried: tried.len(),
                iterations: solved.iter().map(|m| m.iterations).sum(),
                cpu_seconds: solved.iter().map(|m| m.cpu_seconds).sum(),
                median_seconds: median(solved.iter().map(|m| m.cpu_seconds).collect()),
                worst_residual: worst(|m| m.residual),
                worst_scaled_residual: worst(|m| m.scaled_residual),
                failed: tried.iter().filter(|m| !m.solved).map(|m| m.problem.clone()).collect(),
                solver,
            }
        };
        self.solvers().into_iter().map(summary).collect()
    }

    /// Dolan–Moré profiles of the CPU times over all problems.
    ///
    /// Solvers that were tried on some problems only are compared on all of them: what was not tried was not solved.
    pub fn profiles(&self) -> Vec<Profile> {
        let (solvers, problems) = (self.solvers(), self.problems());
        let place: std::collections::BTreeMap<&str, usize> =
            problems.iter().enumerate().map(|(k, name)| (name.as_str(), k)).collect();
        let line = |solver: &String| {
            let mut times = vec![None; problems.len()];
            for m in self.measurements.iter().filter(|m| m.solved && &m.solver == solver) {
                times[place[m.problem.as_str()]] = Some(m.cpu_seconds);
            }
            times
        };
        let times: Vec<_> = solvers.iter().map(line).collect();
        profile::profiles(&solvers, &times)
    }

    /// `solver` against the fastest peer, problem by problem; empty where no peer was added.
    pub fn ratios(&self, solver: &str) -> Vec<Ratio> {
        if !self.measurements.iter().any(|m| m.peer) {
            return Vec::new();
        }
        let of = |own: &Measurement| {
            let peers = self.measurements.iter().filter(|m| m.peer && m.solved && m.problem == own.problem);
            let best = peers.min_by(|a, b| a.cpu_seconds.total_cmp(&b.cpu_seconds));
            let seconds = own.solved.then_some(own.cpu_seconds);
            let peer_seconds = best.map(|m| m.cpu_seconds);
            Ratio {
                problem: own.problem.clone(),
                contacts: own.contacts,
                seconds,
                peer: best.map(|m| m.solver.clone()),
                peer_seconds,
                ratio: seconds.zip(peer_seconds).map(|(own, peer)| peer / own),
            }
        };
        self.measurements.iter().filter(|m| !m.peer && m.solver == solver).map(of).collect()
    }

    /// The median of [`ratios`](Self::ratios) over the problems with more than `contacts` contacts.
    pub fn median_ratio(&self, solver: &str, contacts: usize) -> f64 {
        let ratios = self.ratios(solver).into_iter().filter(|r| r.contacts > contacts);
        median(ratios.filter_map(|r| r.ratio).collect())
    }

    /// The table of the terminal: solvers over all problems, then ratios to peers where there are any.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_table(&self, solver: &str, out: &mut dyn Write) -> std::io::Result<()> {
        let width = self.solvers().iter().map(|s| s.chars().count()).max().unwrap_or(0).max(6);
        writeln!(
            out,
            "{:width$} {:>9} {:>10} {:>11} {:>11} {:>9} {:>9}  not solved",
            "solver", "solved", "iterations", "CPU (s)", "median (s)", "residual", "scaled"
        )?;
        for s in self.summaries() {
            let share = format!("{}/{}", s.solved, s.tried);
            write!(
                out,
                "{:width$} {share:>9} {:>10} {:>11.3e} {:>11.3e}",
                s.solver, s.iterations, s.cpu_seconds, s.median_seconds
            )?;
            write!(out, " {:>9} {:>9}  ", number(s.worst_residual), number(s.worst_scaled_residual))?;
            let shown = s.failed.len().min(3);
            write!(out, "{}", s.failed[..shown].join(", "))?;
            if s.failed.len() > shown {
                write!(out, " and {} more", s.failed.len() - shown)?;
            }
            writeln!(out)?;
        }
        let ratios = self.ratios(solver);
        if ratios.is_empty() {
            return Ok(());
        }
        let width = ratios.iter().map(|r| r.problem.chars().count()).max().unwrap_or(0).max(7);
        let time = |seconds: Option<f64>| seconds.map_or("—".into(), |s| format!("{s:.3e}"));
        writeln!(
            out,
            "\n{:width$} {:>8} {solver:>12} {:>12} {:>10}  fastest peer",
            "problem", "contacts", "peer (s)", "ratio"
        )?;
        for r in &ratios {
            let ratio = r.ratio.map_or("—".into(), |x| format!("{x:.1}"));
            let (own, peer, name) = (
                time(r.seconds),
                time(r.peer_seconds),
                r.peer.as_deref().unwrap_or("none solved it, or none was tried"),
            );
            writeln!(out, "{:width$} {:>8} {own:>12} {peer:>12} {ratio:>10}  {name}", r.problem, r.contacts)?;
        }
        let median = self.median_ratio(solver, 20);
        let median = if median.is_nan() { "—".into() } else { format!("{median:.1}") };
        writeln!(out, "median ratio over the problems with more than 20 contacts: {median}")
    }

    /// Writes `results.csv` (a line per problem and solver), `curves.csv` (residual against time), `profile.csv`
    /// (Dolan–Moré) and `ratios.csv` (`solver` against peers, where there are any) into a folder.
    ///
    /// # Errors
    /// [`CollectionError::Io`] for the folder, [`CollectionError::Table`] for a table.
    pub fn write_csv(&self, solver: &str, folder: &Path) -> Result<(), CollectionError> {
        create_folder(folder).map_err(|source| CollectionError::Io { path: folder.into(), source })?;
        table(&folder.join("results.csv"), self.measurements.iter())?;
        #[derive(Serialize)]
        struct CurvePoint<'a> {
            problem: &'a str,
            solver: &'a str,
            iterations: usize,
            seconds: f64,
            residual: f64,
        }
        let points = self.measurements.iter().flat_map(|m| {
            m.curve.iter().map(|point| CurvePoint {
                problem: &m.problem,
                solver: &m.solver,
                iterations: point.iterations,
                seconds: point.seconds,
                residual: point.residual,
            })
        });
        table(&folder.join("curves.csv"), points)?;
        #[derive(Serialize)]
        struct Step<'a> {
            solver: &'a str,
            ratio: f64,
            share: f64,
        }
        let profiles = self.profiles();
        let steps = profiles.iter().flat_map(|p| {
            let step = |(&ratio, &share)| Step { solver: &p.solver, ratio, share };
            p.ratios.iter().zip(&p.shares).map(step)
        });
        table(&folder.join("profile.csv"), steps)?;
        let ratios = self.ratios(solver);
        if !ratios.is_empty() {
            table(&folder.join("ratios.csv"), ratios.iter())?;
        }
        Ok(())
    }
}

pub(super) fn table<R: Serialize>(path: &Path, rows: impl Iterator<Item = R>) -> Result<(), CollectionError> {
    let failed = |source| CollectionError::Table { path: path.into(), source };
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).map_err(failed)?;
    }
    let bytes = writer.into_inner().map_err(|error| failed(error.into_error().into()))?;
    let write = || {
        let mut file = AtomicFile::create(path)?;
        file.write_all(&bytes)?;
        file.commit()
    };
    write().map_err(|source: std::io::Error| CollectionError::Io { path: path.into(), source })
}
