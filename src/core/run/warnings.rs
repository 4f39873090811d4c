//! What a person should know of a run that went through.

use std::fmt;

use crate::mesh::{Mesh, MeshNote};
use crate::observe::Penetration;
use crate::scene::{Scene, SceneWarning};

/// Depth of overlap that is told, as a share of the smallest shape.
pub(super) const DEEP: f64 = 0.1;

/// What a person should know of a run that went through: its numbers are sound, but perhaps not of what was meant.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// What the scene says that has no effect, or hardly the one meant.
    Scene(SceneWarning),
    /// What was done to the mesh.
    Mesh(MeshNote),
    /// Shapes that overlap when the run starts.
    StartsOverlapping {
        /// How many pairs.
        pairs: usize,
        /// The deepest.
        contact: String,
        /// Its depth (m).
        depth: f64,
    },
    /// Bodies were deeper in each other than a tenth of the smallest shape.
    Penetration {
        /// Law and solver of the run.
        run: String,
        /// How deep, where and when.
        found: Penetration,
        /// How deep the same pair was at the start (m), 0 where it was apart.
        start: f64,
        /// The depth from which it is told (m).
        bound: f64,
    },
    /// Steps of one length do not meet the end time.
    StopsBeforeEnd {
        /// Where the run stopped (s).
        time: f64,
        /// Where it should (s).
        end: f64,
        /// The step (s).
        step: f64,
    },
    /// The program was built without what the scene asks for.
    NotBuilt {
        /// The key.
        key: &'static str,
        /// The feature.
        feature: &'static str,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scene(warning) => warning.fmt(f),
            Self::Mesh(note) => note.fmt(f),
            Self::StartsOverlapping { pairs: 1, contact, depth } => {
                write!(
                    f,
                    "{contact} overlap by {depth:.3e} when the run starts, and stay so until they separate"
                )
            }
            Self::StartsOverlapping { pairs, contact, depth } => write!(
                f,
                "{pairs} pairs overlap when the run starts, and stay so until they separate; the deepest is {contact}, \
                 by {depth:.3e}"
            ),
            Self::Penetration { run, found: Penetration { largest, time, contact, .. }, start, bound } => {
                write!(
                    f,
                    "{run}: {contact} overlapped by {largest:.3e} at t = {time:e}, more than {bound:.3e}, a tenth of \
                     the smallest shape: "
                )?;
                // What was drawn into each other no step takes apart.
                match largest - start > *bound {
                    true => f.write_str("take a shorter step"),
                    false => write!(f, "they overlapped by {start:.3e} when the run started"),
                }
            }
            Self::StopsBeforeEnd { time, end, step } => write!(
                f,
                "the run stops at t = {time:e} and not at {end:e}, which is no multiple of the step {step:e}: where \
                 displacements move or bodies may sleep steps have one length"
            ),
            Self::NotBuilt { key, feature } => {
                write!(f, "`{key}` has no effect: this program was built without the feature `{feature}`")
            }
        }
    }
}

/// A tenth of the smallest shape (m); without shapes nothing is too deep.
pub(super) fn deepest_allowed(scene: &Scene, mesh: Option<&Mesh>) -> f64 {
    if let Some(space) = &scene.space {
        return DEEP * space.least_size(&scene.folder);
    }
    let sizes = scene.bodies.iter().flat_map(|body| {
        let discs = body.discs.iter().map(|disc| 2.0 * disc.radius);
        let polygons = body.polygons.iter().map(|polygon| {
            let extent = |axis: usize| {
                let along = || polygon.vertices.iter().map(|vertex| vertex[axis]);
                along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
            };
            extent(0).min(extent(1))
        });
        discs.chain(polygons)
    });
    let of_mesh = mesh.map(|mesh| mesh.extent().into_iter().filter(|&extent| extent > 0.0));
    let sizes = sizes.filter(|&size| size > 0.0).chain(of_mesh.into_iter().flatten());
    DEEP * sizes.fold(f64::INFINITY, f64::min)
}
