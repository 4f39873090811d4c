//! The figures of a run that scripts read: `summary.json`.

use std::time::Instant;

use nalgebra::SVector;
use serde::{Deserialize, Serialize};

use super::penetration::{Depths, Penetration};
use super::{Frame, ObserveError, Observer, RunInfo};
use crate::contact::ContactId;
use crate::scalar::{Scalar, to_f64};
use crate::scheme::ContactStep;

/// Impacts listed one by one; further ones are counted.
const LISTED_IMPACTS: usize = 10_000;

/// A contact that closes, or closes again, and is no [lasting](crate::scheme::ContactStep::lasting) one: it carries a
/// percussion, carried none in the step before, and approached faster than twice what the forces make of rest in one step;
/// or more slowly, where another contact has an impact in the same step that it passes on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Impact {
    /// Number of the step.
    pub step: usize,
    /// Time at the end of the step (s).
    pub time: f64,
    /// Label of the contact.
    pub contact: String,
    /// Local velocity u_k (m/s), in the order (N, T).
    pub u_before: Vec<f64>,
    /// Local velocity u_{k+1} (m/s).
    pub u_after: Vec<f64>,
    /// Percussion p (N s).
    pub percussion: Vec<f64>,
    /// u_{N,k+θ} p_N (J).
    pub normal_work: f64,
    /// u_{T,k+θ}·p_T (J).
    pub tangential_work: f64,
}

/// What error control made of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AdaptiveSummary {
    /// ε, as a share of the scene's length.
    pub tolerance: f64,
    /// Steps kept.
    pub accepted: usize,
    /// Trials given up.
    pub rejected: usize,
    /// θ-steps made in all.
    pub computed: usize,
    /// Impacts that steps were placed at, and bounces that ended in rest.
    pub events: usize,
    /// Sum of the estimated errors, as a share of the scene's length.
    pub estimated_error: f64,
    /// Smallest step kept (s).
    pub smallest_step: f64,
    /// Largest step kept (s).
    pub largest_step: f64,
}

/// The figures of a run. Energies are kinetic, elastic and that of the potential of the constant forces
/// ([`Energies::total`](crate::energy::Energies::total)).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunSummary {
    /// Law of the run.
    pub law: String,
    /// Cone solver.
    pub solver: String,
    /// θ.
    pub theta: f64,
    /// Time step h (s); under error control the mean of the steps kept.
    pub step: f64,
    /// Error control; `None` for fixed steps.
    pub adaptive: Option<AdaptiveSummary>,
    /// Steps made.
    pub steps: usize,
    /// Arithmetic.
    pub scalar: String,
    /// Wall time of the run with its outputs (s).
    pub wall_seconds: f64,
    /// Wall time per step (µs).
    pub us_per_step: f64,
    /// Energy at the start (J).
    pub initial_energy: f64,
    /// Energy at the end (J).
    pub final_energy: f64,
    /// Largest energy met (J).
    pub max_energy: f64,
    /// Largest tangential contact work of a contact in a step (J); 0 without contact.
    pub max_tangential_work: f64,
    /// Largest normal contact work of a contact in a step (J); 0 without contact.
    pub max_normal_work: f64,
    /// Steps in which a contact work is positive beyond what the solver's tolerance explains
    /// ([`ContactStep::creates_energy`](crate::scheme::ContactStep::creates_energy)).
    pub positive_work_steps: usize,
    /// Steps in which a tangential contact work is.
    pub tangential_work_steps: usize,
    /// Contact works, normal and tangential, summed over the run (J).
    pub contact_work: f64,
    /// Works of external forces and prescribed displacements, summed over the run (J).
    pub external_work: f64,
    /// Largest |imbalance| of (56) in a step (J).
    pub max_imbalance: f64,
    /// Largest scaled residual of a cone problem.
    pub max_residual: f64,
    /// Iterations of the cone solver, summed.
    pub solver_iterations: usize,
    /// Steps whose cone problem the chosen solver missed and another start or method solved
    /// ([`rescue`](crate::solver::rescue)).
    #[serde(default)]
    pub rescues: usize,
    /// How deep bodies were in each other.
    #[serde(default)]
    pub penetration: Penetration,
    /// Number of impacts.
    pub impact_count: usize,
    /// The first impacts, at most 10,000.
    pub impacts: Vec<Impact>,
    /// Why the run ended before its end time, if it did.
    pub stopped: Option<String>,
}

/// Records a [`RunSummary`].
#[derive(Debug, Default)]
pub struct SummaryRecorder {
    summary: Option<RunSummary>,
    started: Option<Instant>,
    /// Wall time before a resumption (s).
    seconds: f64,
    touching: Vec<ContactId>,
    works: Option<(f64, f64)>,
    depths: Depths,
}

/// Where a recorder stands, to go on from there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SummaryMark {
    summary: Option<RunSummary>,
    seconds: f64,
    touching: Vec<ContactId>,
    works: Option<(f64, f64)>,
}

impl SummaryRecorder {
    /// A recorder that goes on from a mark.
    pub fn resume(mark: SummaryMark) -> Self {
        let SummaryMark { summary, seconds, touching, works } = mark;
        let depths = Depths::resume(summary.as_ref().map(|s| s.penetration.clone()).unwrap_or_default());
        Self { summary, started: Some(Instant::now()), seconds, touching, works, depths }
    }

    /// Marks the place.
    pub fn mark(&self) -> SummaryMark {
        let penetration = self.depths.found.clone();
        SummaryMark {
            summary: self.summary.clone().map(|summary| RunSummary { penetration, ..summary }),
            seconds: self.elapsed(),
            touching: self.touching.clone(),
            works: self.works,
        }
    }

    /// Wall time (s), of the runs before a resumption as well.
    fn elapsed(&self) -> f64 {
        self.seconds + self.started.map_or(0.0, |started| started.elapsed().as_secs_f64())
    }

    /// The summary of the run watched; `stopped` says why it ended early. `None` where no run began.
    pub fn finish(self, stopped: Option<String>) -> Option<RunSummary> {
        let mut summary = self.summary?;
        let (tangential, normal) = self.works.unwrap_or_default();
        summary.max_tangential_work = tangential;
        summary.max_normal_work = normal;
        summary.penetration = self.depths.found;
        summary.us_per_step = summary.wall_seconds * 1e6 / summary.steps.max(1) as f64;
        summary.stopped = stopped;
        Some(summary)
    }
}

impl<T: Scalar, const D: usize> Observer<T, D> for SummaryRecorder {
    fn begin(&mut self, run: &RunInfo, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        let energy = to_f64(frame.step.energies.total());
        self.summary = Some(RunSummary {
            law: run.law.clone(),
            solver: run.solver.clone(),
            theta: run.theta,
            step: run.step,
            adaptive: None,
            steps: 0,
            scalar: run.scalar.into(),
            wall_seconds: 0.0,
            us_per_step: 0.0,
            initial_energy: energy,
            final_energy: energy,
            max_energy: energy,
            max_tangential_work: 0.0,
            max_normal_work: 0.0,
            positive_work_steps: 0,
            tangential_work_steps: 0,
            contact_work: 0.0,
            external_work: 0.0,
            max_imbalance: 0.0,
            max_residual: 0.0,
            solver_iterations: 0,
            rescues: 0,
            penetration: Penetration::default(),
            impact_count: 0,
            impacts: Vec::new(),
            stopped: None,
        });
        self.started = Some(Instant::now());
        self.depths = Depths::default();
        self.depths.start(frame);
        Ok(())
    }

    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        let Some(summary) = self.summary.as_mut() else { return Ok(()) };
        let (state, step) = (frame.state, frame.step);
        summary.steps += 1;
        summary.final_energy = to_f64(step.energies.total());
        summary.max_energy = summary.max_energy.max(summary.final_energy);
        summary.max_imbalance = summary.max_imbalance.max(to_f64(step.balance.imbalance).abs());
        let balance = &step.balance;
        summary.contact_work += to_f64(balance.normal_contact_work + balance.tangential_contact_work);
        summary.external_work += to_f64(balance.external_work + balance.prescribed_work);
        if let Some(solution) = &step.solution {
            summary.max_residual = summary.max_residual.max(to_f64(solution.residual.scaled));
            summary.solver_iterations += solution.iterations;
            summary.rescues += usize::from(solution.rescued_by.is_some());
        }
        self.depths.step(frame, &self.touching);
        let is_new = |contact: &ContactStep<T, D>| {
            let carries = contact.percussion[0] > T::zero() && !contact.lasting;
            carries && self.touching.binary_search(&contact.id).is_err()
        };
        // Bodies that lie still when a run starts carry percussions, and have met nothing.
        let meets = step.contacts.iter().any(|contact| is_new(contact) && contact.before[0] < T::zero());
        let mut creates = [false; 2];
        for contact in &step.contacts {
            let (tangential, normal) = (to_f64(contact.tangential_work), to_f64(contact.normal_work));
            let largest = self.works.get_or_insert((tangential, normal));
            *largest = (largest.0.max(tangential), largest.1.max(normal));
            let [by_normal, by_tangential] = contact.creates_energy();
            creates = [creates[0] | by_normal, creates[1] | by_tangential];
            if !(meets && is_new(contact)) {
                continue;
            }
            summary.impact_count += 1;
            if summary.impacts.len() < LISTED_IMPACTS {
                summary.impacts.push(Impact {
                    step: state.index,
                    time: to_f64(state.time),
                    contact: frame.system.contact_label(contact.id),
                    u_before: components(&contact.before),
                    u_after: components(&contact.after),
                    percussion: components(&contact.percussion),
                    normal_work: normal,
                    tangential_work: tangential,
                });
            }
        }
        summary.positive_work_steps += usize::from(creates[0] | creates[1]);
        summary.tangential_work_steps += usize::from(creates[1]);
        self.touching.clear();
        let pressing = step.contacts.iter().filter(|contact| contact.percussion[0] > T::zero());
        self.touching.extend(pressing.map(|contact| contact.id));
        Ok(())
    }

    fn end(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        self.depths.end(frame);
        let elapsed = self.elapsed();
        if let Some(summary) = self.summary.as_mut() {
            summary.wall_seconds = elapsed;
        }
        Ok(())
    }
}

/// Components of a local vector as `f64`.
fn components<T: Scalar, const D: usize>(x: &SVector<T, D>) -> Vec<f64> {
    x.iter().map(|&x| to_f64(x)).collect()
}
