//! The time series that figures are drawn from, thinned as the run grows.

use std::any::Any;

use super::{Frame, ObserveError, Observer, RunInfo};
use crate::contact::ContactId;
use crate::laws::Rows;
use crate::linalg::BlockRows;
use crate::scalar::{Scalar, to_f64};

/// Samples kept: beyond twice this number neighbours are merged two by two.
const SAMPLES: usize = 20_000;

/// One body, one contact and the energies of a run over time; every column has the length of `time`.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "outputs", derive(serde::Serialize, serde::Deserialize))]
pub struct RunSeries {
    /// Law of the run.
    pub law: String,
    /// Cone solver.
    pub solver: String,
    /// Name and unit of the degrees of freedom shown.
    pub dofs: Vec<(String, String)>,
    /// Label of the contact shown.
    pub contact: Option<String>,
    /// Time (s).
    pub time: Vec<f64>,
    /// Displacement of each degree of freedom shown.
    pub q: Vec<Vec<f64>>,
    /// Velocity of each degree of freedom shown.
    pub v: Vec<Vec<f64>>,
    /// Local velocity of the contact shown, component by component (m/s).
    pub u: Vec<Vec<f64>>,
    /// Percussion of the contact shown (N s); of merged samples the largest.
    pub p: Vec<Vec<f64>>,
    /// Contact works of the step, [normal, tangential], summed over contacts (J); of merged samples the largest.
    pub work: [Vec<f64>; 2],
    /// Whether moments are among the components of the contacts.
    #[cfg_attr(feature = "outputs", serde(default))]
    pub rolls: bool,
    /// Largest tangential work of one contact in the step (J); of merged samples the largest.
    pub largest_work: Vec<f64>,
    /// Energies [kinetic, elastic, potential] (J).
    pub energy: [Vec<f64>; 3],
    /// Works since the start (J): [external and prescribed, damping and numerical, contact].
    pub sums: [Vec<f64>; 3],
}

impl RunSeries {
    /// Names of the components of a contact of dimension `dimension`.
    pub fn components(&self, dimension: usize) -> &'static [&'static str] {
        let rows = if self.rolls { Rows::Rolling } else { Rows::Tangent };
        rows.components(dimension)
    }
}

/// Records a [`RunSeries`].
#[derive(Debug)]
pub struct SeriesRecorder {
    series: RunSeries,
    dofs: Vec<usize>,
    contact: Option<ContactId>,
    stride: usize,
    pending: Option<Sample>,
    sums: [f64; 3],
    /// The row of the contact shown, a `BlockRows<T, D>` of the run.
    jacobian: Box<dyn Any + Send>,
}

/// Where a recorder stands, to go on from there.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "outputs", derive(serde::Serialize, serde::Deserialize))]
pub struct SeriesMark {
    series: RunSeries,
    stride: u64,
    /// p, then work, then the largest work.
    pending: Option<Vec<f64>>,
    sums: [f64; 3],
}

/// Impulsive quantities of the steps since the last sample: the ones of largest magnitude.
#[derive(Debug, Clone, Copy)]
struct Sample {
    p: [f64; MOST_COMPONENTS],
    work: [f64; 2],
    largest: f64,
}

/// Components of a percussion in the largest contact dimension; those a contact does not have are 0.
const MOST_COMPONENTS: usize = 6;

impl Sample {
    const ZERO: Self = Self { p: [0.0; MOST_COMPONENTS], work: [0.0; 2], largest: 0.0 };

    fn merge(&mut self, other: &Self) {
        self.p.iter_mut().zip(other.p).for_each(|(x, y)| *x = larger(*x, y));
        self.work.iter_mut().zip(other.work).for_each(|(x, y)| *x = larger(*x, y));
        self.largest = larger(self.largest, other.largest);
    }
}

fn larger(x: f64, y: f64) -> f64 {
    if y.abs() > x.abs() { y } else { x }
}

impl SeriesRecorder {
    /// Records the degrees of freedom `dofs` and the contact `contact`.
    pub fn new(dofs: Vec<usize>, contact: Option<ContactId>) -> Self {
        let jacobian = Box::new(());
        let (series, sums) = (RunSeries::default(), [0.0; 3]);
        Self { series, dofs, contact, stride: 1, pending: None, sums, jacobian }
    }

    /// Marks the place.
    pub fn mark(&self) -> SeriesMark {
        let flat = |sample: &Sample| {
            let all = sample.p[..self.series.p.len()]
                .iter()
                .chain(&sample.work)
                .chain(std::iter::once(&sample.largest));
            all.copied().collect()
        };
        SeriesMark {
            series: self.series.clone(),
            stride: self.stride as u64,
            pending: self.pending.as_ref().map(flat),
            sums: self.sums,
        }
    }

    /// Goes on from a mark of a recorder of the same degrees of freedom and contact; `None` where it is not one.
    pub fn resume(mut self, mark: SeriesMark) -> Option<Self> {
        let components = mark.series.p.len();
        let fits = mark.series.q.len() == self.dofs.len() && self.contact.is_some() == (components > 0);
        let sample = |flat: Vec<f64>| match &flat[..] {
            [p @ .., normal, tangential, largest]
                if p.len() == components && components <= MOST_COMPONENTS =>
            {
                let p = std::array::from_fn(|i| p.get(i).copied().unwrap_or(0.0));
                Some(Sample { p, work: [*normal, *tangential], largest: *largest })
            }
            _ => None,
        };
        self.pending = match mark.pending {
            None => None,
            Some(flat) => Some(sample(flat)?),
        };
        (self.series, self.stride, self.sums) = (mark.series, (mark.stride as usize).max(1), mark.sums);
        fits.then_some(self)
    }

    /// The series recorded.
    pub fn finish(self) -> RunSeries {
        self.series
    }

    fn sample<T: Scalar, const D: usize>(&mut self, frame: Frame<'_, T, D>) {
        let (state, step) = (frame.state, frame.step);
        let series = &mut self.series;
        series.time.push(to_f64(state.time));
        for (column, &dof) in self.dofs.iter().enumerate() {
            series.q[column].push(to_f64(state.q[frame.system.coordinate_of(dof)]));
            series.v[column].push(to_f64(state.v[dof]));
        }
        if let Some(contact) = self.contact {
            if !self.jacobian.is::<BlockRows<T, D>>() {
                self.jacobian = Box::new(BlockRows::<T, D>::new());
            }
            if let Some(row) = self.jacobian.downcast_mut::<BlockRows<T, D>>() {
                row.clear();
                frame.system.jacobian(contact, &state.q, row);
                let u = row.velocity(0, &state.v);
                series.u.iter_mut().zip(u.iter()).for_each(|(column, &u)| column.push(to_f64(u)));
            }
        }
        let impulsive = self.pending.take().unwrap_or(Sample::ZERO);
        series.p.iter_mut().zip(impulsive.p).for_each(|(column, p)| column.push(p));
        series.work.iter_mut().zip(impulsive.work).for_each(|(column, work)| column.push(work));
        series.largest_work.push(impulsive.largest);
        series.sums.iter_mut().zip(self.sums).for_each(|(column, sum)| column.push(sum));
        let energies = [step.energies.kinetic, step.energies.elastic, step.energies.potential];
        series.energy.iter_mut().zip(energies).for_each(|(column, e)| column.push(to_f64(e)));
        if series.time.len() >= 2 * SAMPLES {
            self.thin();
        }
    }

    fn thin(&mut self) {
        self.stride *= 2;
        let RunSeries { time, q, v, u, p, work, largest_work, energy, sums, .. } = &mut self.series;
        let smooth = [&mut *time].into_iter().chain(q).chain(v).chain(u).chain(energy).chain(sums);
        smooth.for_each(|column| halve(column, |first, _| first));
        p.iter_mut().chain(work).chain([largest_work]).for_each(|column| halve(column, larger));
    }
}

fn halve(column: &mut Vec<f64>, merge: impl Fn(f64, f64) -> f64) {
    for i in 0..column.len() / 2 {
        column[i] = merge(column[2 * i], column[2 * i + 1]);
    }
    column.truncate(column.len() / 2);
}

impl<T: Scalar, const D: usize> Observer<T, D> for SeriesRecorder {
    fn begin(&mut self, run: &RunInfo, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        let name = |&dof: &usize| (frame.system.dof_label(dof), frame.system.dof_unit(dof).to_string());
        let columns = |n: usize| vec![Vec::new(); n];
        let local = if self.contact.is_some() { D } else { 0 };
        self.series = RunSeries {
            law: run.law.clone(),
            solver: run.solver.clone(),
            rolls: run.rows == Rows::Rolling,
            dofs: self.dofs.iter().map(name).collect(),
            contact: self.contact.map(|contact| frame.system.contact_label(contact)),
            q: columns(self.dofs.len()),
            v: columns(self.dofs.len()),
            u: columns(local),
            p: columns(local),
            ..RunSeries::default()
        };
        self.sums = [0.0; 3];
        self.sample(frame);
        Ok(())
    }

    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        let step = frame.step;
        let shown = step.contacts.iter().find(|contact| Some(contact.id) == self.contact);
        let p = shown.map_or([0.0; MOST_COMPONENTS], |contact| {
            std::array::from_fn(|i| contact.percussion.get(i).map_or(0.0, |&p| to_f64(p)))
        });
        let work = [step.balance.normal_contact_work, step.balance.tangential_contact_work].map(to_f64);
        let largest = to_f64(step.largest_works()[1]);
        self.pending.get_or_insert(Sample::ZERO).merge(&Sample { p, work, largest });
        let balance = &step.balance;
        let sums = [
            balance.external_work + balance.prescribed_work,
            balance.damping_work + balance.numerical_dissipation,
            balance.normal_contact_work + balance.tangential_contact_work,
        ];
        self.sums.iter_mut().zip(sums).for_each(|(sum, x)| *sum += to_f64(x));
        if frame.state.index.is_multiple_of(self.stride) {
            self.sample(frame);
        }
        Ok(())
    }
}
