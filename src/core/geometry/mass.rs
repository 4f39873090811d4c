//! Mass, centre and inertia of solids.

use nalgebra::{Matrix3, Vector3};

use super::polyhedron::Polyhedron;
use super::pose::Pose;
use crate::scalar::{Scalar, from_usize, lit};

/// Mass, centre of mass and inertia of a solid, in the frame of its shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties<T: Scalar> {
    /// Mass (kg).
    pub mass: T,
    /// Centre of mass (m).
    pub centre: Vector3<T>,
    /// Inertia about the centre of mass, along the axes of the frame (kg m²).
    pub inertia: Matrix3<T>,
}

impl<T: Scalar> MassProperties<T> {
    /// Nothing.
    pub fn zero() -> Self {
        Self { mass: T::zero(), centre: Vector3::zeros(), inertia: Matrix3::zeros() }
    }

    /// The same solid seen from the frame in which its own stands at `pose`.
    #[must_use]
    pub fn placed(&self, pose: &Pose<T>) -> Self {
        let r = pose.rotation();
        Self { centre: pose.place(&self.centre), inertia: r * self.inertia * r.transpose(), ..*self }
    }

    /// Both solids together (Huygens and Steiner), in one frame.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        if !(mass > T::zero()) {
            return *self;
        }
        let apart = other.centre - self.centre;
        let reduced = self.mass * (other.mass / mass);
        Self {
            mass,
            centre: self.centre + apart * (other.mass / mass),
            inertia: self.inertia + other.inertia + about(&apart) * reduced,
        }
    }

    /// A solid with moments `moments` (kg m²) along its axes, at the origin.
    pub(super) fn axial(mass: T, moments: [T; 3]) -> Self {
        let inertia = Matrix3::from_diagonal(&Vector3::from(moments));
        Self { mass, centre: Vector3::zeros(), inertia }
    }
}

/// |d|² 1 − d dᵀ: the inertia of a unit mass at d.
fn about<T: Scalar>(d: &Vector3<T>) -> Matrix3<T> {
    Matrix3::identity() * d.dot(d) - d * d.transpose()
}

/// Sums over the tetrahedra between the triangles of the faces and a point inside.
///
/// For a tetrahedron 0abc of volume V = a·(b × c)/6: ∫x = V s/4 with s = a + b + c, and
/// ∫x xᵀ = V (aaᵀ + bbᵀ + ccᵀ + ssᵀ)/20. Taken from the mean of the vertices, so that all volumes are positive.
fn of_polyhedron<T: Scalar>(polyhedron: &Polyhedron<T>, density: T) -> MassProperties<T> {
    let vertices = polyhedron.vertices();
    let sum = vertices.iter().fold(Vector3::<T>::zeros(), |sum, x| sum + x);
    let origin: Vector3<T> = sum / from_usize::<T>(vertices.len().max(1));
    let (mut volume, mut first, mut second) = (T::zero(), Vector3::<T>::zeros(), Matrix3::<T>::zeros());
    for face in 0..polyhedron.faces() {
        let corners = polyhedron.corners(face);
        let at = |k: usize| vertices[corners[k] as usize] - origin;
        for k in 1..corners.len().saturating_sub(1) {
            let [a, b, c]: [Vector3<T>; 3] = [at(0), at(k), at(k + 1)];
            let six = a.dot(&b.cross(&c));
            let sum = a + b + c;
            volume += six;
            first += sum * six;
            second +=
                (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose()) * six;
        }
    }
    if !(volume > T::zero()) {
        return MassProperties::zero();
    }
    let centre = first / (volume * lit::<T>(4.0));
    let mass = density * volume / lit::<T>(6.0);
    let products = second * (density / lit::<T>(120.0)) - centre * centre.transpose() * mass;
    let inertia: Matrix3<T> = Matrix3::identity() * products.trace() - products;
    let symmetric = (inertia + inertia.transpose()) * lit::<T>(0.5);
    MassProperties { mass, centre: centre + origin, inertia: symmetric }
}

impl<T: Scalar> Polyhedron<T> {
    /// Mass (kg), centre and inertia of the solid of `density` (kg/m³): sums over tetrahedra, exact to rounding.
    pub fn mass_properties(&self, density: T) -> MassProperties<T> {
        of_polyhedron(self, density)
    }
}
