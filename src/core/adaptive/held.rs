//! What a run under error control holds between and within its steps.

use super::AdaptiveSettings;
use super::control::Control;
use super::path::Path;
use crate::contact::{Candidate, ContactId};
use crate::scalar::Scalar;
use crate::scheme::{Saved, State, Step, ThetaScheme};

/// Share of ε for the smooth motion, and for jumps. Errors of the velocity count for the time that is left, half the span in
/// the mean: the estimates of a run add up to about half of it.
pub(super) const SMOOTH: f64 = 1.0;
pub(super) const JUMPS: f64 = 0.5;

/// What a run under error control has cost, and what it thinks of its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report<T> {
    /// Steps kept.
    pub accepted: usize,
    /// Trials given up, for their error or for an event in them.
    pub rejected: usize,
    /// θ-steps made in all: kept, compared with, given up.
    pub computed: usize,
    /// Impacts that steps were placed at, and bounces that ended in rest.
    pub events: usize,
    /// Sum of the estimated errors of the steps kept, in q and in v until T, as a share of the scene's length.
    pub estimated_error: T,
    /// Smallest step kept (s).
    pub smallest_step: T,
    /// Largest step kept (s).
    pub largest_step: T,
}

/// A step kept, until it is told of.
#[derive(Debug)]
pub(super) struct Record<T: Scalar, const D: usize> {
    pub(super) state: State<T>,
    pub(super) step: Step<T, D>,
}

/// A [`ThetaScheme`] under error control; the [module](super) says how.
///
/// Warm steps allocate nothing, but where the scheme has to factor M̂ for a length it has not met.
#[derive(Debug)]
pub struct Adaptive<T: Scalar, const D: usize> {
    pub(super) scheme: ThetaScheme<T, D>,
    pub(super) settings: AdaptiveSettings<T>,
    pub(super) span: T,
    pub(super) least: T,
    /// What a component of q or v is multiplied with to be a share of the scene's length.
    pub(super) weights: Vec<T>,
    /// γ (m).
    pub(super) closed: T,
    /// Whether lengths are the span over powers of two and thirds of them.
    pub(super) on_ladder: bool,
    pub(super) control: Control<T>,
    pub(super) start: Saved<T, D>,
    /// Length of the step that led to the start, where it was one of a smooth motion; 0 else.
    pub(super) came_by: T,
    /// End of the one step of 3h.
    pub(super) ahead: (Vec<T>, Vec<T>),
    /// Motions between configurations, and other vectors over the degrees of freedom.
    pub(super) motions: [Vec<T>; 3],
    pub(super) path: Path<T>,
    pub(super) records: [Record<T, D>; 3],
    pub(super) near: Vec<Near<T>>,
    /// Whether gaps are to be looked at within trials.
    pub(super) watches: bool,
    pub(super) candidates: Vec<Candidate<T>>,
    pub(super) point: Vec<T>,
    /// ε for jumps that is left.
    pub(super) for_jumps: T,
    /// Largest acceleration met on the last path, in lengths of the scene (1/s²).
    pub(super) acceleration: T,
    pub(super) report: Report<T>,
    /// Trials from the present start whose error was too large.
    pub(super) trials: usize,
    /// Estimate and length of the last trial; error per unit of time of the last one kept.
    pub(super) last_trial: (T, T),
    pub(super) density: T,
    /// Estimate of the last trial, and its share.
    pub(super) last_error: (T, T),
    /// Time, what was left until T, and the steps computed when the last thousandth of the span was over.
    pub(super) mark: (T, T, usize),
}

/// A candidate near the state a step starts from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Near<T> {
    pub(super) id: ContactId,
    /// Gap (m) and u_N (m/s) at the start.
    pub(super) gap: T,
    pub(super) rate: T,
    /// Gaps at the start and after each of three steps; the last one known stands for those beyond the reach.
    pub(super) gaps: [T; 4],
    pub(super) seen: bool,
}

/// Where a trial is to end instead.
#[derive(Debug, Clone, Copy)]
pub(super) enum Meeting<T> {
    /// Just before a contact closes.
    At(T),
    /// After a bounce too low to be resolved, all of which a step this long makes.
    Rest(T),
}
