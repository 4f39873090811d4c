//! The tables of a study of a scene.

use std::io::Write;
use std::path::Path;

use super::lines::MEASURES;
use super::scene::SceneResults;
use super::settings::number;
use super::{Line, StudyError};
use crate::file::AtomicFile;

/// Relative errors whose price the terminal shows.
const LEVELS: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

/// Columns of `runs.csv` behind those of the settings; the last three are times.
const COLUMNS: [&str; 15] = [
    "ok",
    "message",
    "steps",
    "iterations",
    "error_q",
    "error_v",
    "error_percussion",
    "error_energy",
    "relative_q",
    "relative_v",
    "relative_percussion",
    "relative_energy",
    "cpu_seconds",
    "wall_seconds",
    "repeats",
];

/// A number for a table, empty where it is not known.
fn cell(x: f64) -> String {
    if x.is_finite() { number(x) } else { String::new() }
}

impl SceneResults {
    /// Writes `runs.csv` and `orders.csv` into a folder.
    ///
    /// # Errors
    /// [`StudyError::Io`], [`StudyError::Table`].
    pub fn write_csv(&self, folder: &Path) -> Result<(), StudyError> {
        self.write_runs(&folder.join("runs.csv"))?;
        self.write_orders(&folder.join("orders.csv"))
    }

    fn write_runs(&self, path: &Path) -> Result<(), StudyError> {
        let fields = |row: &super::Row| row.settings.fields(&self.keys);
        let heads = self.rows.first().map(|row| fields(row).into_iter().map(|(name, _)| name));
        let header: Vec<String> = heads.into_iter().flatten().chain(COLUMNS.map(String::from)).collect();
        let rows = self.rows.iter().map(|row| {
            let outcome = &row.outcome;
            let mut cells: Vec<String> = fields(row).into_iter().map(|(_, value)| value).collect();
            cells.extend([outcome.ok.to_string(), outcome.message.clone()]);
            cells.extend([outcome.steps.to_string(), outcome.iterations.to_string()]);
            cells.extend(MEASURES.iter().map(|measure| cell((measure.absolute)(&outcome.errors))));
            cells.extend(MEASURES.iter().map(|measure| cell((measure.relative)(&outcome.errors))));
            cells.extend([
                cell(outcome.cpu_seconds),
                cell(outcome.wall_seconds),
                outcome.repeats.to_string(),
            ]);
            cells
        });
        write(path, std::iter::once(header).chain(rows))
    }

    fn write_orders(&self, path: &Path) -> Result<(), StudyError> {
        let lines = self.lines();
        let names = lines.first().map(|line| line.settings.iter().map(|(name, _)| name.clone()));
        let columns = [
            "error",
            "points",
            "order",
            "deviation",
            "nominal",
            "constant",
            "constant_relative",
            "least_relative",
        ];
        let header: Vec<String> = names.into_iter().flatten().chain(columns.map(String::from)).collect();
        let row = |line: &Line, measure: &super::Measure| {
            let order = line.order(measure)?;
            let mut cells: Vec<String> = line.settings.iter().map(|(_, value)| value.clone()).collect();
            cells.extend([measure.name.to_string(), order.points.to_string()]);
            let numbers = [order.slope, order.deviation, order.nominal, order.constant];
            cells.extend(numbers.into_iter().chain([order.constant_relative, order.least]).map(cell));
            Some(cells)
        };
        let rows =
            lines.iter().flat_map(|line| MEASURES.iter().filter_map(move |measure| row(line, measure)));
        write(path, std::iter::once(header).chain(rows))
    }

    /// The table of the terminal: orders, envelopes and prices of every line, then what failed.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_table(&self, out: &mut dyn Write) -> std::io::Result<()> {
        let lines = self.lines();
        let width = lines.iter().map(|line| line.label.chars().count()).max().unwrap_or(0).max(4);
        writeln!(out, "{}\n", self.title)?;
        write!(out, "{:width$} {:>4}  {:>21}  {:>21}", "line", "runs", "q: order, error", "v: order, error")?;
        writeln!(out, "  {:>8} {:>8}  CPU (s) for q to", "least q", "least v")?;
        write!(out, "{:width$} {:>4}  {:>21}  {:>21}  {:>8} {:>8} ", "", "", "", "", "", "")?;
        LEVELS.iter().try_for_each(|level| write!(out, " {level:>8.0e}"))?;
        writeln!(out)?;
        for line in &lines {
            write!(out, "{:width$} {:>4}", line.label, line.points.len())?;
            let orders = [&MEASURES[0], &MEASURES[1]].map(|measure| line.order(measure));
            for order in &orders {
                let step = if line.adaptive { "ε" } else { "h" };
                let text = order.map_or("—".into(), |order| {
                    let power = match order.nominal {
                        0.0 => String::new(),
                        1.0 => format!(" {step}"),
                        p => format!(" {step}^{p}"),
                    };
                    format!("{:.2}±{:.2}, ≤ {:.2e}{power}", order.slope, order.deviation, order.constant)
                });
                write!(out, "  {text:>21}")?;
            }
            let least =
                |place: usize| orders[place].map_or("—".into(), |order| format!("{:.1e}", order.least));
            write!(out, "  {:>8} {:>8} ", least(0), least(1))?;
            for level in LEVELS {
                let cost = line.cost(&MEASURES[0], level).map_or("—".into(), |cost| format!("{cost:.1e}"));
                write!(out, " {cost:>8}")?;
            }
            writeln!(
                out,
                "{}",
                self.mark
                    .as_ref()
                    .filter(|_| line.marked)
                    .map_or(String::new(), |mark| { format!("  {}", mark.label) })
            )?;
        }
        let failed: Vec<_> = self.rows.iter().filter(|row| !row.outcome.ok).collect();
        if let Some(first) = failed.first() {
            let words = first.settings.words();
            writeln!(
                out,
                "\n{} of {} runs failed, the first: {words}: {}",
                failed.len(),
                self.rows.len(),
                first.outcome.message
            )?;
        }
        Ok(())
    }

    /// Whether every run of the study was made and reached its end.
    pub fn complete(&self) -> bool {
        self.missing == 0 && self.rows.iter().all(|row| row.outcome.ok)
    }
}

/// Writes rows as CSV, whole or not at all.
pub(super) fn write(path: &Path, rows: impl Iterator<Item = Vec<String>>) -> Result<(), StudyError> {
    let table = |source| StudyError::Table { path: path.into(), source };
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.write_record(&row).map_err(table)?;
    }
    let bytes = writer.into_inner().map_err(|error| table(error.into_error().into()))?;
    let put = || {
        let mut file = AtomicFile::create(path)?;
        file.write_all(&bytes)?;
        file.commit()
    };
    put().map_err(|source: std::io::Error| StudyError::io(path, source))
}
