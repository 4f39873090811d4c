//! What a scene says that has no effect, or hardly the one meant.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use super::names::Directory;
use super::{Scene, SceneError};
use crate::system::Signal;

/// A step longer than this part of a period does not follow it.
const OF_PERIOD: f64 = 0.25;

/// Shapes named in one warning.
const SHOWN: usize = 5;

/// What a scene says that has no effect, or hardly the one meant. It can be run all the same.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum SceneWarning {
    /// Shapes that no interface lets touch anything: their bodies pass through all others.
    TouchesNothing {
        /// The bodies all of whose shapes are meant, by name, and the other shapes as `body.shape`.
        names: Vec<String>,
    },
    /// An interface that governs no pair.
    UnusedInterface {
        /// The interface, as its two sides.
        interface: String,
        /// Its parameters, which act nowhere.
        parameters: Vec<String>,
        /// Whether all it names is one body.
        one_body: bool,
    },
    /// A step that is long for what moves in its own time.
    LongStep {
        /// What moves.
        what: String,
        /// Its period (s).
        period: f64,
        /// The step (s).
        step: f64,
    },
}

impl fmt::Display for SceneWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TouchesNothing { names } => {
                let shown = names.iter().take(SHOWN).map(|name| format!("`{name}`")).collect::<Vec<_>>();
                write!(f, "no interface lets {} touch anything", shown.join(", "))?;
                if names.len() > SHOWN {
                    write!(f, " (nor {} more)", names.len() - SHOWN)?;
                }
                write!(f, ": what no [[interfaces]] entry names passes through everything")
            }
            Self::UnusedInterface { interface, parameters, one_body } => {
                let why = if *one_body {
                    "its sides are one body, which does not touch itself"
                } else {
                    "it fits no pair of shapes, or interfaces before it govern those it fits"
                };
                write!(f, "interface {interface} has no effect: {why}")?;
                match parameters.is_empty() {
                    true => Ok(()),
                    false => write!(f, "; its {} act nowhere", parameters.join(", ")),
                }
            }
            Self::LongStep { what, period, step } => {
                write!(f, "the step {step:e} is long for {what}, whose period is {period:.3e}")
            }
        }
    }
}

/// What stands on the same sides of all interfaces: bodies (by index), and whether an obstacle or a half-plane is among it.
#[derive(Default)]
struct Alike {
    bodies: BTreeSet<usize>,
    other: bool,
}

impl Alike {
    /// Whether there is something else here than `body`.
    fn meets(&self, body: usize) -> bool {
        self.other || self.bodies.iter().any(|&other| other != body)
    }
}

impl Scene {
    /// What of the scene has no effect, or hardly the one meant.
    ///
    /// # Errors
    /// [`SceneError`]: names taken twice, interfaces that name nothing.
    pub fn warnings(&self) -> Result<Vec<SceneWarning>, SceneError> {
        let mut warnings = Vec::new();
        if let Some(solid) = &self.solid {
            if self.interfaces.is_empty() && !self.half_planes.is_empty() {
                warnings.push(SceneWarning::TouchesNothing { names: vec![solid.name.clone()] });
            }
        } else {
            self.warn_of_interfaces(&mut warnings)?;
        }
        if self.time.adaptive.is_none() {
            self.warn_of_step(&mut warnings);
        }
        Ok(warnings)
    }

    fn warn_of_interfaces(&self, warnings: &mut Vec<SceneWarning>) -> Result<(), SceneError> {
        let directory = Directory::new(self)?;
        directory.check_interfaces(self)?;
        let mut alike: BTreeMap<Vec<[bool; 2]>, Alike> = BTreeMap::new();
        for (body, shapes) in directory.contactors.iter().enumerate() {
            for names in shapes {
                alike.entry(Directory::sides(self, names)).or_default().bodies.insert(body);
            }
        }
        for names in directory.others() {
            alike.entry(Directory::sides(self, names)).or_default().other = true;
        }
        let mut names = Vec::new();
        for (own, (body, shapes)) in self.bodies.iter().zip(&directory.contactors).enumerate() {
            let index = names.len();
            let labels = (body.discs.iter().map(|disc| &disc.name))
                .chain(body.polygons.iter().map(|polygon| &polygon.name));
            for (label, known) in labels.zip(shapes) {
                let sides = Directory::sides(self, known);
                let touches = |(other, what): (&Vec<[bool; 2]>, &Alike)| {
                    Directory::interface_between(&sides, other).is_some() && what.meets(own)
                };
                if !alike.iter().any(touches) {
                    names.push(format!("{}.{label}", body.name));
                }
            }
            if !shapes.is_empty() && names.len() - index == shapes.len() {
                names.truncate(index);
                names.push(body.name.clone());
            }
        }
        if !names.is_empty() {
            warnings.push(SceneWarning::TouchesNothing { names });
        }
        let mut used = vec![false; self.interfaces.len()];
        for (a, of_a) in &alike {
            for (b, of_b) in &alike {
                if let Some(interface) = Directory::interface_between(a, b)
                    && of_a.bodies.iter().any(|&body| of_b.meets(body))
                {
                    used[interface] = true;
                }
            }
        }
        for (interface, _) in self.interfaces.iter().zip(&used).filter(|(_, used)| !**used) {
            let bodies: BTreeSet<usize> = (directory.contactors.iter().enumerate())
                .filter(|(_, shapes)| {
                    shapes.iter().any(|names| interface.between.iter().any(|side| names.contains(side)))
                })
                .map(|(body, _)| body)
                .collect();
            let others =
                directory.others().any(|names| interface.between.iter().any(|side| names.contains(side)));
            warnings.push(SceneWarning::UnusedInterface {
                interface: interface.label(),
                parameters: interface.parameters.keys().map(|name| format!("`{name}`")).collect(),
                one_body: bodies.len() == 1 && !others,
            });
        }
        Ok(())
    }

    fn warn_of_step(&self, warnings: &mut Vec<SceneWarning>) {
        let step = self.step_length();
        let mut look = |what: String, period: f64| {
            if step > OF_PERIOD * period {
                warnings.push(SceneWarning::LongStep { what, period, step });
            }
        };
        let turn = std::f64::consts::TAU;
        let of_signal = |signal: &Signal<f64>| match signal {
            Signal::Sine { frequency, .. } | Signal::Square { frequency, .. } => 1.0 / frequency,
            _ => f64::INFINITY,
        };
        for body in &self.bodies {
            let inertias = [body.mass, body.mass, body.inertia];
            let periods = body.stiffness.iter().zip(inertias).filter(|(k, _)| **k > 0.0);
            let shortest = periods.map(|(k, m)| turn * (m / k).sqrt()).fold(f64::INFINITY, f64::min);
            look(format!("the springs of `{}`", body.name), shortest);
            look(format!("the spin of `{}`", body.name), turn / body.spin.abs());
            let loads = body.loads.iter().map(|load| of_signal(&load.signal)).fold(f64::INFINITY, f64::min);
            look(format!("the loads on `{}`", body.name), loads);
        }
        if let Some(solid) = &self.solid {
            for (group, signal) in
                (solid.tractions.iter().map(|traction| (&traction.group, &traction.signal)))
                    .chain(solid.prescribed.iter().map(|prescribed| (&prescribed.group, &prescribed.signal)))
            {
                look(format!("the signal on `{group}`"), of_signal(signal));
            }
        }
    }
}
