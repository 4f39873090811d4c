//! Distances of a run from its reference, measured step by step.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::reference::Reference;
use crate::observe::{Frame, ObserveError, Observer, RunInfo};
use crate::scalar::{Scalar, to_f64};

/// How the components of a vector make one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Norm {
    /// The largest component, metres beside radians: of rigid bodies.
    Largest,
    /// The root of the mean square: of elastic bodies, where the velocity jumps across wave fronts and no scheme
    /// converges in every node.
    RootMeanSquare,
}

impl Norm {
    /// |x − y|.
    fn distance(self, x: &[f64], y: &[f64]) -> f64 {
        let differences = x.iter().zip(y).map(|(x, y)| x - y);
        match self {
            // A NaN stays one.
            Self::Largest => differences
                .fold(0.0, |most: f64, d| if d.abs() > most || d.is_nan() { d.abs() } else { most }),
            Self::RootMeanSquare => {
                (differences.map(|d| d * d).sum::<f64>() / (x.len().max(1) as f64)).sqrt()
            }
        }
    }
}

/// Distances of a run from its reference, see [`crate::study`]; not a number where they are not known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Largest |q − q*| at the ends of the steps.
    pub q: f64,
    /// ∫ |v − v*| dt.
    pub v: f64,
    /// Difference of the normal percussions, summed over contacts and time (N s).
    pub percussion: f64,
    /// Mean over time of the difference of the energies (J).
    pub energy: f64,
    /// `q` over the largest |q* − q*(0)|.
    pub q_relative: f64,
    /// `v` over ∫ |v*| dt.
    pub v_relative: f64,
    /// `percussion` over that of the reference.
    pub percussion_relative: f64,
    /// `energy` over the largest kinetic and elastic energy of the run.
    pub energy_relative: f64,
}

impl Errors {
    /// Of a run that failed.
    pub const UNKNOWN: Self = Self {
        q: f64::NAN,
        v: f64::NAN,
        percussion: f64::NAN,
        energy: f64::NAN,
        q_relative: f64::NAN,
        v_relative: f64::NAN,
        percussion_relative: f64::NAN,
        energy_relative: f64::NAN,
    };
}

/// Measures [`Errors`], in memory that does not grow.
#[derive(Debug)]
pub struct ErrorRecorder {
    reference: Arc<dyn Reference>,
    norm: Norm,
    end: f64,
    /// Where the last step ended: time, velocity, energy.
    time: f64,
    velocity: Vec<f64>,
    energy: f64,
    /// State of the run and of the reference.
    q: Vec<f64>,
    v: Vec<f64>,
    q_true: Vec<f64>,
    v_true: Vec<f64>,
    zero: Vec<f64>,
    q_start: Vec<f64>,
    /// Ends of the pieces of the step on which the reference is smooth.
    pieces: Vec<f64>,
    errors: Errors,
    percussion: f64,
    q_scale: f64,
    v_scale: f64,
    energy_scale: f64,
}

/// Abscissae of the Gauss rule with two points on [0, 1], each of weight ½: exact for cubics.
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

impl ErrorRecorder {
    /// Errors up to the time `end`; what a run does later is not looked at.
    pub fn new(reference: Arc<dyn Reference>, norm: Norm, end: f64) -> Self {
        Self {
            reference,
            norm,
            end,
            time: 0.0,
            velocity: Vec::new(),
            energy: 0.0,
            q: Vec::new(),
            v: Vec::new(),
            q_true: Vec::new(),
            v_true: Vec::new(),
            zero: Vec::new(),
            q_start: Vec::new(),
            pieces: Vec::new(),
            errors: Errors { q: 0.0, v: 0.0, percussion: 0.0, energy: 0.0, ..Errors::UNKNOWN },
            percussion: 0.0,
            q_scale: 0.0,
            v_scale: 0.0,
            energy_scale: 0.0,
        }
    }

    /// The errors so far.
    pub fn errors(&self) -> Errors {
        let Self { errors, time, .. } = *self;
        let percussion_true = self.reference.percussion(time);
        let percussion = (self.percussion - percussion_true).abs();
        let energy = errors.energy / time;
        Errors {
            percussion,
            energy,
            q_relative: errors.q / self.q_scale,
            v_relative: errors.v / self.v_scale,
            percussion_relative: percussion / percussion_true.abs(),
            energy_relative: energy / self.energy_scale,
            ..errors
        }
    }

    /// Integrals over a step to `time`; in steps with percussions `velocity` and `energy` hold over the whole step, in
    /// others they are linear.
    fn integrate(&mut self, time: f64, energy: f64, jumps: bool) {
        self.pieces.clear();
        self.pieces.push(self.time);
        let pieces = &mut self.pieces;
        self.reference.jumps(self.time, time, &mut |jump| pieces.push(jump));
        self.pieces.push(time);
        let step = time - self.time;
        for piece in 0..self.pieces.len() - 1 {
            let (from, to) = (self.pieces[piece], self.pieces[piece + 1]);
            for abscissa in GAUSS {
                let at = from + abscissa * (to - from);
                let weight = 0.5 * (to - from);
                let share = if jumps { 1.0 } else { (at - self.time) / step };
                self.reference.at(at, &mut self.q_true, &mut self.v_true);
                let between = self.velocity.iter().zip(&self.v).map(|(a, b)| a + share * (b - a));
                self.q.iter_mut().zip(between).for_each(|(x, v)| *x = v);
                self.errors.v += weight * self.norm.distance(&self.q, &self.v_true);
                self.v_scale += weight * self.norm.distance(&self.v_true, &self.zero);
                let own = self.energy + share * (energy - self.energy);
                self.errors.energy += weight * (own - self.reference.energy(at)).abs();
            }
        }
    }

    fn take<T: Scalar, const D: usize>(&mut self, frame: &Frame<'_, T, D>) {
        let copy = |from: &[T], to: &mut Vec<f64>| {
            to.clear();
            to.extend(from.iter().map(|&x| to_f64(x)));
        };
        copy(&frame.state.q, &mut self.q);
        copy(&frame.state.v, &mut self.v);
    }

    fn compare(&mut self, time: f64) {
        self.reference.at(time, &mut self.q_true, &mut self.v_true);
        let far = self.norm.distance(&self.q, &self.q_true);
        if far > self.errors.q || far.is_nan() {
            self.errors.q = far;
        }
        self.q_scale = self.q_scale.max(self.norm.distance(&self.q_true, &self.q_start));
    }
}

impl<T: Scalar, const D: usize> Observer<T, D> for ErrorRecorder {
    fn begin(&mut self, _run: &RunInfo, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        self.take(&frame);
        let zero = vec![0.0; self.q.len()];
        (self.q_true, self.v_true, self.zero, self.q_start) =
            (zero.clone(), zero.clone(), zero.clone(), zero);
        self.time = to_f64(frame.state.time);
        self.reference.at(self.time, &mut self.q_true, &mut self.v_true);
        self.q_start.clone_from(&self.q_true);
        self.compare(self.time);
        self.velocity.clone_from(&self.v);
        let energies = &frame.step.energies;
        (self.energy, self.energy_scale) = (to_f64(energies.total()), to_f64(energies.mechanical()));
        Ok(())
    }

    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        let time = to_f64(frame.state.time);
        // An end that is a multiple of h but for rounding is reached.
        if time > self.end * (1.0 + 1e-6) || time <= self.time {
            return Ok(());
        }
        self.take(&frame);
        self.compare(time);
        let (step, energies) = (frame.step, &frame.step.energies);
        let energy = to_f64(energies.total());
        let percussion: f64 = step.contacts.iter().map(|contact| to_f64(contact.percussion[0])).sum();
        self.percussion += percussion;
        self.integrate(time, energy, percussion > 0.0);
        self.energy_scale = self.energy_scale.max(to_f64(energies.mechanical()));
        (self.time, self.energy) = (time, energy);
        std::mem::swap(&mut self.velocity, &mut self.v);
        Ok(())
    }
}
