//! `trajectory.csv`, `contacts.csv` and `energy.csv`, all runs of a scene one after the other.

use std::fmt::LowerExp;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use ::csv::Writer;

use serde::{Deserialize, Serialize};

use super::{Frame, ObserveError, Observer, RunInfo};
use crate::energy::{Balance, Energies};
use crate::file::{AtomicFile, KeptDraft};
use crate::scalar::{Scalar, to_f64};

/// Where a table is written until it is whole.
enum Draft {
    Hidden(AtomicFile),
    Kept(KeptDraft),
}

impl Draft {
    fn path(&self) -> &Path {
        match self {
            Self::Hidden(file) => file.path(),
            Self::Kept(draft) => draft.path(),
        }
    }
}

/// A table written beside its destination and moved there whole, so that older results stay until then.
struct Table {
    file: Draft,
    writer: Writer<BufWriter<File>>,
    /// Columns that name the run, first in every row.
    prefix: [String; 2],
    cell: String,
    has_header: bool,
}

impl Table {
    /// A hidden draft, or one kept in the folder `drafts` with its first bytes.
    fn create(folder: &Path, name: &str, drafts: Option<(&Path, u64)>) -> Result<Self, ObserveError> {
        let path = folder.join(name);
        let open = || -> std::io::Result<_> {
            let (file, handle) = match drafts {
                None => {
                    let file = AtomicFile::create(&path)?;
                    let handle = file.handle()?;
                    (Draft::Hidden(file), handle)
                }
                Some((drafts, length)) => {
                    let draft = KeptDraft::open(&drafts.join(name), &path, length)?;
                    let handle = draft.handle()?;
                    (Draft::Kept(draft), handle)
                }
            };
            // Rows differ in nothing but their number of columns, which the code fixes.
            let writer = ::csv::WriterBuilder::new()
                .flexible(true)
                .from_writer(BufWriter::with_capacity(1 << 16, handle));
            Ok((file, writer))
        };
        let (file, writer) = open().map_err(|error| ObserveError::new(&path, error))?;
        let prefix = [String::new(), String::new()];
        let has_header = drafts.is_some_and(|(_, length)| length > 0);
        Ok(Self { file, writer, prefix, cell: String::new(), has_header })
    }

    /// Bytes on the disk; 0 for a hidden draft, which nobody finds again.
    fn position(&mut self) -> Result<u64, ObserveError> {
        self.writer.flush().map_err(|e| self.error(e))?;
        match &self.file {
            Draft::Hidden(_) => Ok(0),
            Draft::Kept(draft) => draft.position().map_err(|e| self.error(e)),
        }
    }

    fn begin(&mut self, run: &RunInfo, columns: impl Iterator<Item = String>) -> Result<(), ObserveError> {
        self.prefix = [run.law.clone(), run.solver.clone()];
        if self.has_header {
            return Ok(());
        }
        self.has_header = true;
        let header: Vec<String> = ["law", "solver", "step", "time"].map(String::from).into_iter().collect();
        self.writer.write_record(header.into_iter().chain(columns)).map_err(|e| self.error(e))
    }

    fn start_row<T: Scalar>(&mut self, step: usize, time: T) -> Result<(), ObserveError> {
        for i in 0..2 {
            self.writer.write_field(&self.prefix[i]).map_err(|e| ObserveError::new(self.file.path(), e))?;
        }
        self.text(&step.to_string())?;
        self.number(time)
    }

    fn text(&mut self, text: &str) -> Result<(), ObserveError> {
        self.writer.write_field(text).map_err(|e| self.error(e))
    }

    /// Numbers are written with the fewest digits that read back to the same value.
    fn number<T: Scalar>(&mut self, x: T) -> Result<(), ObserveError> {
        use std::fmt::Write as _;
        self.cell.clear();
        let x: &dyn LowerExp = &to_f64(x);
        let _infallible = write!(self.cell, "{x:e}");
        self.writer.write_field(&self.cell).map_err(|e| ObserveError::new(self.file.path(), e))
    }

    fn numbers<'a, T: Scalar>(&mut self, xs: impl IntoIterator<Item = &'a T>) -> Result<(), ObserveError> {
        xs.into_iter().try_for_each(|&x| self.number(x))
    }

    fn end_row(&mut self) -> Result<(), ObserveError> {
        self.writer.write_record(None::<&[u8]>).map_err(|e| self.error(e))
    }

    fn commit(mut self) -> Result<(), ObserveError> {
        self.writer.flush().map_err(|e| self.error(e))?;
        let path = self.file.path().to_path_buf();
        let done = match self.file {
            Draft::Hidden(file) => file.commit(),
            Draft::Kept(draft) => draft.commit(),
        };
        done.map_err(|error| ObserveError::new(&path, error))
    }

    fn error(&self, error: impl std::error::Error + Send + Sync + 'static) -> ObserveError {
        ObserveError::new(self.file.path(), error)
    }
}

/// The three tables of a scene.
pub struct CsvFiles {
    trajectory: Table,
    contacts: Table,
    energy: Table,
    rates: Rates,
    /// Step of the last row of the trajectory, and of the energies.
    written: [Option<usize>; 2],
    cumulated: [f64; WORKS],
    laws: Vec<String>,
}

/// Every how many steps each table gets a row; the first state and the last have one in all but the contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rates {
    /// `trajectory.csv`.
    pub trajectory: usize,
    /// `contacts.csv`, a row for every contact active in the step.
    pub contacts: usize,
    /// `energy.csv`.
    pub energy: usize,
}

impl Default for Rates {
    /// Every step.
    fn default() -> Self {
        Self { trajectory: 1, contacts: 1, energy: 1 }
    }
}

/// Where the tables stand, to go on from there: bytes, and sums of works.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CsvMark {
    lengths: [u64; 3],
    written: [Option<u64>; 2],
    cumulated: [f64; WORKS],
    prefix: [String; 2],
    laws: Vec<String>,
}

/// Works in the balance, with what is left over.
const WORKS: usize = 8;

const ENERGY_COLUMNS: [&str; 22] = [
    "kinetic",
    "elastic",
    "potential",
    "external_work",
    "damping_work",
    "numerical_dissipation",
    "normal_contact_work",
    "tangential_contact_work",
    "imbalance",
    "residual",
    "sum_external_work",
    "sum_damping_work",
    "sum_numerical_dissipation",
    "sum_normal_contact_work",
    "sum_tangential_contact_work",
    "sum_imbalance",
    "prescribed_work",
    "sum_prescribed_work",
    "largest_normal_work",
    "largest_tangential_work",
    "position_work",
    "sum_position_work",
];

impl CsvFiles {
    /// Opens the tables in `folder`, which must exist. Nothing that is there is touched before
    /// [`commit`](Self::commit).
    ///
    /// # Errors
    /// [`ObserveError`] where the folder cannot be written to.
    pub fn create(folder: &Path, rates: Rates) -> Result<Self, ObserveError> {
        Self::open(folder, rates, None)
    }

    /// Opens the tables with drafts kept in the folder `drafts`, at the place of `mark`: what stands behind it, from
    /// a run that was killed, is dropped.
    ///
    /// # Errors
    /// [`ObserveError`] where a folder cannot be written to, or a draft is shorter than its mark.
    pub fn kept(folder: &Path, rates: Rates, drafts: &Path, mark: &CsvMark) -> Result<Self, ObserveError> {
        Self::open(folder, rates, Some((drafts, mark)))
    }

    fn open(folder: &Path, rates: Rates, kept: Option<(&Path, &CsvMark)>) -> Result<Self, ObserveError> {
        let table = |i: usize, name| {
            let draft = kept.map(|(drafts, mark)| (drafts, mark.lengths[i]));
            let mut table = Table::create(folder, name, draft)?;
            if let Some((_, mark)) = kept {
                table.prefix.clone_from(&mark.prefix);
            }
            Ok(table)
        };
        let mark = kept.map(|(_, mark)| mark.clone()).unwrap_or_default();
        let at_least_one = |rate: usize| rate.max(1);
        Ok(Self {
            trajectory: table(0, "trajectory.csv")?,
            contacts: table(1, "contacts.csv")?,
            energy: table(2, "energy.csv")?,
            rates: Rates {
                trajectory: at_least_one(rates.trajectory),
                contacts: at_least_one(rates.contacts),
                energy: at_least_one(rates.energy),
            },
            written: mark.written.map(|step| step.map(|step| step as usize)),
            cumulated: mark.cumulated,
            laws: mark.laws,
        })
    }

    /// Writes what is pending to the disk and marks the place.
    ///
    /// # Errors
    /// [`ObserveError`] where a file cannot be written.
    pub fn mark(&mut self) -> Result<CsvMark, ObserveError> {
        Ok(CsvMark {
            lengths: [self.trajectory.position()?, self.contacts.position()?, self.energy.position()?],
            written: self.written.map(|step| step.map(|step| step as u64)),
            cumulated: self.cumulated,
            prefix: self.trajectory.prefix.clone(),
            laws: self.laws.clone(),
        })
    }

    /// Moves the tables to their places.
    ///
    /// # Errors
    /// [`ObserveError`] where a file cannot be written.
    pub fn commit(self) -> Result<(), ObserveError> {
        self.trajectory.commit()?;
        self.contacts.commit()?;
        self.energy.commit()
    }

    fn write_state<T: Scalar, const D: usize>(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        let state = frame.state;
        self.written[0] = Some(state.index);
        self.trajectory.start_row(state.index, state.time)?;
        self.trajectory.numbers(state.q.iter().chain(&state.v))?;
        self.trajectory.end_row()
    }

    fn write_energy<T: Scalar, const D: usize>(
        &mut self,
        frame: Frame<'_, T, D>,
    ) -> Result<(), ObserveError> {
        let (state, step) = (frame.state, frame.step);
        self.written[1] = Some(state.index);
        let Energies { kinetic, elastic, potential } = step.energies;
        self.energy.start_row(state.index, state.time)?;
        self.energy.numbers(&[kinetic, elastic, potential])?;
        let [works @ .., prescribed, position] = terms(&step.balance);
        self.energy.numbers(&works)?;
        self.energy.number(step.solution.map_or(T::zero(), |solution| solution.residual.scaled))?;
        let [sums @ .., sum_prescribed, sum_position] = self.cumulated;
        self.energy.numbers(&sums)?;
        self.energy.number(prescribed)?;
        self.energy.number(sum_prescribed)?;
        let [normal, tangential] = step.largest_works();
        self.energy.numbers(&[normal, tangential, position])?;
        self.energy.number(sum_position)?;
        self.energy.end_row()
    }
}

/// The works of the balance and what is left over.
fn terms<T: Scalar>(balance: &Balance<T>) -> [T; WORKS] {
    [
        balance.external_work,
        balance.damping_work,
        balance.numerical_dissipation,
        balance.normal_contact_work,
        balance.tangential_contact_work,
        balance.imbalance,
        balance.prescribed_work,
        balance.position_work,
    ]
}

impl<T: Scalar, const D: usize> Observer<T, D> for CsvFiles {
    fn begin(&mut self, run: &RunInfo, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        let q = (0..frame.state.q.len()).map(|i| frame.system.coordinate_label(i));
        let v = (0..frame.state.v.len()).map(|i| format!("v.{}", frame.system.dof_label(i)));
        self.trajectory.begin(run, q.chain(v))?;
        self.energy.begin(run, ENERGY_COLUMNS.iter().map(|s| s.to_string()))?;
        let local = |name: &str| {
            run.rows.components(D).iter().map(|axis| format!("{name}_{axis}")).collect::<Vec<_>>()
        };
        let vectors = ["u_before", "u_after", "p"].into_iter().flat_map(local);
        let contact = ["contact", "gap", "contact_law"].map(String::from).into_iter();
        let works = ["normal_work", "tangential_work"].map(String::from);
        self.contacts.begin(run, contact.chain(vectors).chain(works))?;
        self.cumulated = [0.0; WORKS];
        self.laws.clone_from(&run.interface_laws);
        self.write_state(frame)?;
        self.write_energy(frame)
    }

    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        let added = terms(&frame.step.balance).map(to_f64);
        self.cumulated.iter_mut().zip(added).for_each(|(sum, x)| *sum += x);
        let index = frame.state.index;
        let shown = if index.is_multiple_of(self.rates.contacts) { &*frame.step.contacts } else { &[] };
        for contact in shown {
            self.contacts.start_row(frame.state.index, frame.state.time)?;
            self.contacts.text(&frame.system.contact_label(contact.id))?;
            self.contacts.number(contact.gap)?;
            self.contacts.text(self.laws.get(contact.interface).map_or("", |law| law))?;
            let vectors = contact.before.iter().chain(contact.after.iter()).chain(contact.percussion.iter());
            self.contacts.numbers(vectors)?;
            self.contacts.numbers(&[contact.normal_work, contact.tangential_work])?;
            self.contacts.end_row()?;
        }
        if index.is_multiple_of(self.rates.trajectory) {
            self.write_state(frame)?;
        }
        if index.is_multiple_of(self.rates.energy) { self.write_energy(frame) } else { Ok(()) }
    }

    fn end(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        let due = self.written.map(|written| written != Some(frame.state.index));
        if due[0] {
            self.write_state(frame)?;
        }
        if due[1] { self.write_energy(frame) } else { Ok(()) }
    }
}
