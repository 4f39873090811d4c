//! Which reference a study names, and how it is made.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::ball::Ball;
use super::bar::Bar;
use super::finest::Sampled;
use super::format::ReferenceSpec;
use super::job::Job;
use super::reference::Reference;
use super::{ReferenceError, StudyError};
use crate::event_driven::Settings;
use crate::registry::Registry;
use crate::scene::{PlannedRun, ScalarName, Scene, contact_dimension};
use crate::simulate::Ended;

/// A run of the same scene with a finer step.
pub(super) const FINEST: &str = "finest";

/// The motion of a scene and a run; an error says what the scene would have to be.
type ClosedForm = fn(&Scene, &PlannedRun, &Registry) -> Result<Arc<dyn Reference>, ReferenceError>;

/// References that are no run of the scheme.
const CLOSED_FORMS: [(&str, ClosedForm); 3] = [
    ("event-driven", event_driven_motion),
    ("bouncing-ball", |scene, run, registry| Ok(Arc::new(Ball::new(scene, run, registry)?))),
    ("impacting-bar", |scene, run, registry| Ok(Arc::new(Bar::new(scene, run, registry)?))),
];

fn event_driven_motion(
    scene: &Scene,
    run: &PlannedRun,
    registry: &Registry,
) -> Result<Arc<dyn Reference>, ReferenceError> {
    let settings = Settings::default();
    let motion = contact_dimension(scene, std::slice::from_ref(run), registry)
        .and_then(|dimension| scene.motion(run, dimension, registry, &settings))?;
    Ok(Arc::new(motion?))
}

/// Tolerance of the cone solver in the finest run, beside which no error of the study is small.
const TOLERANCE: f64 = 1e-12;

/// How much finer than the finest run of a study its reference is, where the study does not say.
const FINER: f64 = 8.0;

/// Memory of all the samples of a study (bytes).
const MEMORY: usize = 256 << 20;

/// How far a reference goes beyond the end of the runs, relative to it.
const BEYOND: f64 = 1e-5;

/// A step of reference scenes that make none.
const ANY_STEP: f64 = 1e-3;

/// Whether there is such a reference.
pub(super) fn check(spec: &ReferenceSpec) -> Result<(), String> {
    let finest = spec.kind == FINEST;
    if !finest && CLOSED_FORMS.iter().all(|(name, _)| *name != spec.kind) {
        let known: Vec<&str> = CLOSED_FORMS.iter().map(|(name, _)| *name).chain([FINEST]).collect();
        return Err(format!("no reference is called `{}` (known: {})", spec.kind, known.join(", ")));
    }
    if !finest && (spec.h.is_some() || spec.theta.is_some()) {
        return Err(format!("the reference `{}` has neither `h` nor `theta`", spec.kind));
    }
    Ok(())
}

/// A reference to be made: the scene without what its motion does not depend on.
#[derive(Debug, Clone)]
pub(super) struct Target {
    kind: String,
    scene: Scene,
    run: PlannedRun,
    dimension: usize,
    settings: String,
}

impl Target {
    /// The reference of a job, in a study whose smallest step is `least`.
    pub(super) fn new(
        registry: &Registry,
        spec: &ReferenceSpec,
        job: &Job,
        least: Option<f64>,
    ) -> Result<Self, StudyError> {
        let mut scene = job.scene.clone();
        scene.title.clear();
        scene.scalar = ScalarName::F64;
        scene.solvers = vec![crate::solver::DEFAULT.into()];
        scene.solver.tolerance = Some(TOLERANCE);
        let time = &mut scene.time;
        time.adaptive = None;
        if spec.kind == FINEST {
            time.step = spec.h.or(least.map(|h| h / FINER)).unwrap_or(time.step);
            time.theta = spec.theta.or(Some(job.run.theta));
        } else {
            // The continuous motion has no θ but that of the law in the limit, ½.
            (time.step, time.theta) = (ANY_STEP, Some(0.5));
        }
        // An end that is a multiple of h is reached but for rounding.
        time.end *= 1.0 + BEYOND;
        time.allow_unproved_theta = true;
        let combination =
            |source| StudyError::Combination { settings: job.settings.words(), source: Box::new(source) };
        let run = match <[PlannedRun; 1]>::try_from(scene.runs(registry).map_err(combination)?) {
            Ok([run]) => run,
            Err(_) => job.run.clone(),
        };
        Ok(Self {
            kind: spec.kind.clone(),
            scene,
            run,
            dimension: job.dimension,
            settings: job.settings.words(),
        })
    }

    /// What the reference depends on, as a number.
    pub(super) fn key(&self) -> std::io::Result<u64> {
        Ok(self.scene.fingerprint()?.and(self.kind.as_bytes()).number())
    }

    /// Makes the reference, one of `count` in memory; `None` where it was interrupted.
    pub(super) fn make(
        &self,
        registry: &Registry,
        count: usize,
        stop: &AtomicBool,
    ) -> Result<Option<Arc<dyn Reference>>, StudyError> {
        let failed = |source: ReferenceError| StudyError::Reference {
            reference: self.kind.clone(),
            settings: self.settings.clone(),
            source: Box::new(source),
        };
        if let Some((_, form)) = CLOSED_FORMS.iter().find(|(name, _)| *name == self.kind) {
            return form(&self.scene, &self.run, registry).map(Some).map_err(failed);
        }
        let memory = MEMORY / count.max(1);
        let sampled = self.sample(registry, memory, stop);
        Ok(sampled.map_err(failed)?.map(|sampled| Arc::new(sampled) as Arc<dyn Reference>))
    }

    fn sample(
        &self,
        registry: &Registry,
        memory: usize,
        stop: &AtomicBool,
    ) -> Result<Option<Sampled>, ReferenceError> {
        let mut simulation = (self.scene.simulation(&self.run, self.dimension, registry))?;
        let mut sampled = Sampled::new(simulation.dofs(), self.run.steps, memory);
        let ended = simulation.run(self.run.steps, &mut [&mut sampled], stop);
        match ended? {
            Ended::Completed => Ok(Some(sampled)),
            Ended::Interrupted => Ok(None),
        }
    }
}
