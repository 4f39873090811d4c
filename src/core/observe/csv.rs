//! `trajectory.csv`, `contacts.csv` and `energy.csv`, all runs of a scene one after the other.

use std::collections::HashMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::table::Table;
use super::{Frame, ObserveError, Observer, RunInfo};
use crate::contact::ContactId;
use crate::energy::{Balance, Energies};
use crate::scalar::{Scalar, to_f64};

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
    /// Names of the contacts met.
    labels: HashMap<ContactId, String>,
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

const ENERGY_COLUMNS: [&str; 23] = [
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
    "total",
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
                table.set_prefix(mark.prefix.clone());
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
            labels: HashMap::new(),
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
        self.trajectory.start_row(state.index, state.time);
        self.trajectory.numbers(state.q.iter().chain(&state.v));
        self.trajectory.end_row()
    }

    fn write_energy<T: Scalar, const D: usize>(
        &mut self,
        frame: Frame<'_, T, D>,
    ) -> Result<(), ObserveError> {
        let (state, step) = (frame.state, frame.step);
        self.written[1] = Some(state.index);
        let Energies { kinetic, elastic, potential } = step.energies;
        self.energy.start_row(state.index, state.time);
        self.energy.numbers(&[kinetic, elastic, potential]);
        let [works @ .., prescribed, position] = terms(&step.balance);
        self.energy.numbers(&works);
        self.energy.number(step.solution.map_or(T::zero(), |solution| solution.residual.scaled));
        let [sums @ .., sum_prescribed, sum_position] = self.cumulated;
        self.energy.numbers(&sums);
        self.energy.number(prescribed);
        self.energy.number(sum_prescribed);
        let [normal, tangential] = step.largest_works();
        self.energy.numbers(&[normal, tangential, position]);
        self.energy.number(sum_position);
        self.energy.number(step.energies.total());
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
        let facts = ["normal_work", "tangential_work", "theta", "lasting"].map(String::from);
        self.contacts.begin(run, contact.chain(vectors).chain(facts))?;
        self.cumulated = [0.0; WORKS];
        self.labels.clear();
        self.laws.clone_from(&run.interface_laws);
        self.write_state(frame)?;
        self.write_energy(frame)
    }

    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        let added = terms(&frame.step.balance).map(to_f64);
        self.cumulated.iter_mut().zip(added).for_each(|(sum, x)| *sum += x);
        let index = frame.state.index;
        let shown = if index.is_multiple_of(self.rates.contacts) { &*frame.step.contacts } else { &[] };
        let Self { contacts: table, labels, laws, .. } = self;
        for contact in shown {
            let label = labels.entry(contact.id).or_insert_with(|| frame.system.contact_label(contact.id));
            table.start_row(frame.state.index, frame.state.time);
            table.text(label);
            table.number(contact.gap);
            table.text(laws.get(contact.interface).map_or("", |law| law));
            table.numbers(contact.before.iter().chain(contact.after.iter()).chain(contact.percussion.iter()));
            table.numbers(&[contact.normal_work, contact.tangential_work, contact.theta]);
            table.text(if contact.lasting { "true" } else { "false" });
            table.end_row()?;
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
