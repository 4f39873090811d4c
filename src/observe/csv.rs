//! `trajectory.csv`, `contacts.csv` and `energy.csv`, all runs of a scene one after the other.

use std::fmt::LowerExp;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use ::csv::Writer;

use super::{Frame, ObserveError, Observer, RunInfo};
use crate::energy::{Balance, Energies};
use crate::file::AtomicFile;
use crate::scalar::Scalar;

/// A table written beside its destination and moved there whole, so that older results stay until then.
struct Table {
    file: AtomicFile,
    writer: Writer<BufWriter<File>>,
    /// Columns that name the run, first in every row.
    prefix: [String; 2],
    cell: String,
    has_header: bool,
}

impl Table {
    fn create(folder: &Path, name: &str) -> Result<Self, ObserveError> {
        let path = folder.join(name);
        let open = || -> std::io::Result<_> {
            let file = AtomicFile::create(&path)?;
            let writer = Writer::from_writer(BufWriter::with_capacity(1 << 16, file.handle()?));
            Ok((file, writer))
        };
        let (file, writer) = open().map_err(|error| ObserveError::new(&path, error))?;
        let prefix = [String::new(), String::new()];
        Ok(Self { file, writer, prefix, cell: String::new(), has_header: false })
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
        let x: &dyn LowerExp = &crate::scalar::to_f64(x);
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
        self.file.commit().map_err(|error| ObserveError::new(&path, error))
    }

    fn error(&self, error: impl std::fmt::Display) -> ObserveError {
        ObserveError::new(self.file.path(), error)
    }
}

/// The three tables of a scene.
pub struct CsvFiles {
    trajectory: Table,
    contacts: Table,
    energy: Table,
    every: usize,
    written: Option<usize>,
    cumulated: [f64; 6],
    laws: Vec<String>,
}

const ENERGY_COLUMNS: [&str; 16] = [
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
];

const FRAME: [&str; 3] = ["N", "T1", "T2"];

impl CsvFiles {
    /// Opens the tables in `folder`, which must exist; the trajectory and the energies get a row every `every`
    /// steps. Nothing that is there is touched before [`commit`](Self::commit).
    ///
    /// # Errors
    /// [`ObserveError`] where the folder cannot be written to.
    pub fn create(folder: &Path, every: usize) -> Result<Self, ObserveError> {
        Ok(Self {
            trajectory: Table::create(folder, "trajectory.csv")?,
            contacts: Table::create(folder, "contacts.csv")?,
            energy: Table::create(folder, "energy.csv")?,
            every: every.max(1),
            written: None,
            cumulated: [0.0; 6],
            laws: Vec::new(),
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
        let (state, step) = (frame.state, frame.step);
        self.written = Some(state.index);
        self.trajectory.start_row(state.index, state.time)?;
        self.trajectory.numbers(state.q.iter().chain(&state.v))?;
        self.trajectory.end_row()?;

        let Energies { kinetic, elastic, potential } = step.energies;
        self.energy.start_row(state.index, state.time)?;
        self.energy.numbers(&[kinetic, elastic, potential])?;
        self.energy.numbers(&terms(&step.balance))?;
        self.energy.number(step.solution.map_or(T::zero(), |solution| solution.residual.scaled))?;
        self.energy.numbers(&self.cumulated)?;
        self.energy.end_row()
    }
}

/// The works of the balance and what is left over.
fn terms<T: Scalar>(balance: &Balance<T>) -> [T; 6] {
    [
        balance.external_work,
        balance.damping_work,
        balance.numerical_dissipation,
        balance.normal_contact_work,
        balance.tangential_contact_work,
        balance.imbalance,
    ]
}

impl<T: Scalar, const D: usize> Observer<T, D> for CsvFiles {
    fn begin(&mut self, run: &RunInfo, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        let n = frame.system.dofs();
        let q = (0..n).map(|i| frame.system.dof_label(i));
        let v = (0..n).map(|i| format!("v.{}", frame.system.dof_label(i)));
        self.trajectory.begin(run, q.chain(v))?;
        self.energy.begin(run, ENERGY_COLUMNS.iter().map(|s| s.to_string()))?;
        let local = |name: &str| FRAME[..D].iter().map(|axis| format!("{name}_{axis}")).collect::<Vec<_>>();
        let vectors = ["u_before", "u_after", "p"].into_iter().flat_map(local);
        let contact = ["contact", "gap", "contact_law"].map(String::from).into_iter();
        let works = ["normal_work", "tangential_work"].map(String::from);
        self.contacts.begin(run, contact.chain(vectors).chain(works))?;
        self.cumulated = [0.0; 6];
        self.laws.clone_from(&run.interface_laws);
        self.write_state(frame)
    }

    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        let added = terms(&frame.step.balance).map(crate::scalar::to_f64);
        self.cumulated.iter_mut().zip(added).for_each(|(sum, x)| *sum += x);
        for contact in &frame.step.contacts {
            self.contacts.start_row(frame.state.index, frame.state.time)?;
            self.contacts.text(&frame.system.contact_label(contact.id))?;
            self.contacts.number(contact.gap)?;
            self.contacts.text(self.laws.get(contact.interface).map_or("", |law| law))?;
            let vectors = contact.before.iter().chain(contact.after.iter()).chain(contact.percussion.iter());
            self.contacts.numbers(vectors)?;
            self.contacts.numbers(&[contact.normal_work, contact.tangential_work])?;
            self.contacts.end_row()?;
        }
        if frame.state.index.is_multiple_of(self.every) { self.write_state(frame) } else { Ok(()) }
    }

    fn end(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        if self.written == Some(frame.state.index) { Ok(()) } else { self.write_state(frame) }
    }
}
