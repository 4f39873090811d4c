//! Several shapes on one body.

use super::bounds::Bounds;
use super::inertia::{InertiaError, Principal};
use super::mass::MassProperties;
use super::pose::Pose;
use super::shape::{Shape, ShapeError};
use crate::scalar::Scalar;

/// A shape and where it sits on its body.
#[derive(Debug, Clone, PartialEq)]
pub struct Part<T: Scalar> {
    /// The shape.
    pub shape: Shape<T>,
    /// Its frame in that of the body.
    pub pose: Pose<T>,
}

/// A union of shapes on a body: it need not be convex. Where parts overlap their masses add.
#[derive(Debug, Clone, PartialEq)]
pub struct Compound<T: Scalar> {
    parts: Vec<Part<T>>,
}

/// Why a union has no frame of its own.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CompoundError {
    /// A shape without mass.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// An inertia that no body has.
    #[error(transparent)]
    Inertia(#[from] InertiaError),
}

impl<T: Scalar> Compound<T> {
    /// A union of `parts`.
    pub fn new(parts: Vec<Part<T>>) -> Self {
        Self { parts }
    }

    /// The parts.
    pub fn parts(&self) -> &[Part<T>] {
        &self.parts
    }

    /// The sum of the parts' masses, each of `density` (kg/m³), their common centre and inertia in the frame of the union.
    ///
    /// # Errors
    ///
    /// [`ShapeError`] of a part; [`ShapeError::NoVolume`] without parts.
    pub fn mass_properties(&self, density: T) -> Result<MassProperties<T>, ShapeError> {
        if self.parts.is_empty() {
            return Err(ShapeError::NoVolume { shape: "union of no parts" });
        }
        let mut sum = MassProperties::zero();
        for part in &self.parts {
            sum = part.shape.mass_properties(density)?.placed(&part.pose).with(&sum);
        }
        Ok(sum)
    }

    /// The same union in its principal frame, at its centre of mass; with the mass (kg), the principal moments (kg m²), and
    /// where that frame stands in the one it was given in.
    ///
    /// # Errors
    ///
    /// [`CompoundError`] where a part has no mass, or the sum no inertia.
    pub fn into_principal(self, density: T) -> Result<(Self, T, Principal<T>, Pose<T>), CompoundError> {
        let MassProperties { mass, centre, inertia } = self.mass_properties(density)?;
        let principal = Principal::of(&inertia)?;
        let frame = Pose::new(centre, principal.axes);
        let parts = self.parts.into_iter().map(|Part { shape, pose }| {
            let position = frame.turn_back(&(pose.position() + pose.arm() - centre));
            Part { shape, pose: Pose::new(position, principal.axes.inverse() * pose.orientation()) }
        });
        Ok((Self { parts: parts.collect() }, mass, principal, frame))
    }

    /// The smallest box along the fixed axes that holds the boxes of all parts, grown by `reach` (m).
    pub fn bounds(&self, pose: &Pose<T>, reach: T) -> Bounds<T> {
        let boxes = self.parts.iter().map(|part| part.shape.bounds(&pose.part(&part.pose), reach));
        boxes
            .reduce(|a, b| a.union(&b))
            .unwrap_or_else(|| Bounds::around(*pose.position(), nalgebra::Vector3::repeat(reach)))
    }
}
