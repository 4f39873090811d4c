//! Bodies of revolution: cylinders and cones.

use nalgebra::Vector3;

use super::error::HullError;
use super::polyhedron::Polyhedron;
use super::real::{abs, direction, infinity, max, sqrt};
use crate::scalar::{Scalar, epsilon, from_usize, lit};

/// A convex body of revolution about z, given by its profile, and the polyhedron inscribed in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Round<T: Scalar> {
    /// Radius and height of its rims, upwards; the last one of radius 0 where it ends in a point.
    pub(super) rims: Vec<[T; 2]>,
    pub(super) facets: Polyhedron<T>,
}

impl<T: Scalar> Round<T> {
    /// The round with these rims, and `sides` facets inscribed.
    ///
    /// # Errors
    ///
    /// [`HullError`] where it has no volume.
    pub(super) fn new(rims: Vec<[T; 2]>, sides: usize) -> Result<Self, HullError> {
        let turn = lit::<T>(std::f64::consts::TAU) / from_usize::<T>(sides);
        let mut vertices = Vec::new();
        for &[radius, height] in &rims {
            if radius == T::zero() {
                vertices.push(Vector3::new(T::zero(), T::zero(), height));
                continue;
            }
            vertices.extend((0..sides).map(|k| {
                let (sin, cos) = nalgebra::ComplexField::sin_cos(turn * from_usize::<T>(k));
                Vector3::new(radius * cos, radius * sin, height)
            }));
        }
        Ok(Self { facets: Polyhedron::hull(&vertices)?, rims })
    }

    /// The polyhedron inscribed, with vertices on the rims.
    pub fn facets(&self) -> &Polyhedron<T> {
        &self.facets
    }

    /// Radius and height of rim `rim` (m), from below; `None` where there is no such rim.
    pub fn rim(&self, rim: usize) -> Option<[T; 2]> {
        self.rims.get(rim).copied()
    }

    /// Sides of the profile: the lower face, the mantles, the upper face; each from one point to the next.
    fn profile(&self) -> impl Iterator<Item = (super::Feature, [T; 2], [T; 2])> + '_ {
        let (first, last) = (self.rims[0], self.rims[self.rims.len() - 1]);
        let lower = (super::Feature::Face(0), [T::zero(), first[1]], first);
        let mantles = self.rims.windows(2).enumerate();
        let mantles = mantles.map(|(k, pair)| (super::Feature::Mantle(k as u32), pair[0], pair[1]));
        let upper = (super::Feature::Face(1), last, [T::zero(), last[1]]);
        std::iter::once(lower).chain(mantles).chain((last[0] > T::zero()).then_some(upper))
    }

    /// The point of the axis half-plane (ρ, z) of `p`, and the direction of ρ: x on the axis itself.
    fn meridian(p: &Vector3<T>) -> ([T; 2], Vector3<T>) {
        let across = Vector3::new(p.x, p.y, T::zero());
        let radial = direction(&across).unwrap_or_else(Vector3::x);
        ([across.dot(&radial), p.z], radial)
    }

    /// The feature that is next to `p`, exactly: of the profile in the half-plane of `p`.
    ///
    /// Inside, the side of the profile that is nearest; sides win ties.
    pub(super) fn nearest(&self, p: &Vector3<T>) -> super::Feature {
        let ([rho, z], _) = Self::meridian(p);
        let height = |from: [T; 2], to: [T; 2]| {
            let normal = outward(from, to);
            normal[0] * (rho - from[0]) + normal[1] * (z - from[1])
        };
        let mut highest = (-infinity::<T>(), super::Feature::Face(0));
        for (feature, from, to) in self.profile() {
            let height = height(from, to);
            if height > highest.0 {
                highest = (height, feature);
            }
        }
        if !(highest.0 > T::zero()) {
            return highest.1;
        }
        let (mut best, tie) = ((infinity::<T>(), highest.1), lit::<T>(64.0) * epsilon::<T>() * self.radius());
        for (feature, from, to) in self.profile() {
            let share =
                ((to[0] - from[0]) * (rho - from[0]) + (to[1] - from[1]) * (z - from[1])) / squared(from, to);
            // A face ends on the axis in its own middle.
            let low = share >= T::zero() || feature == super::Feature::Face(0);
            let high = share <= T::one() || feature == super::Feature::Face(1);
            let (distance, found, tie) = if low && high {
                (abs(height(from, to)), feature, tie)
            } else {
                let end = if low { to } else { from };
                let rim = self.rims.iter().position(|rim| *rim == end).unwrap_or(0);
                (sqrt(squared(end, [rho, z])), super::Feature::Rim(rim as u32), -tie)
            };
            if distance < best.0 + tie {
                best = (distance, found);
            }
        }
        best.1
    }

    /// Outward normal and distance of `p` from one feature, or from the surface that continues it; `None` where there is none.
    pub(super) fn at_feature(&self, feature: super::Feature, p: &Vector3<T>) -> Option<(Vector3<T>, T)> {
        let ([rho, z], radial) = Self::meridian(p);
        if let super::Feature::Rim(rim) = feature {
            let [radius, height] = self.rim(rim as usize)?;
            let out = radial * (rho - radius) + Vector3::z() * (z - height);
            let normal = direction(&out)?;
            return Some((normal, normal.dot(&out)));
        }
        let (_, from, to) = self.profile().find(|side| side.0 == feature)?;
        let normal = outward(from, to);
        let distance = normal[0] * (rho - from[0]) + normal[1] * (z - from[1]);
        Some((radial * normal[0] + Vector3::z() * normal[1], distance))
    }

    /// The point of rim `rim` that is lowest along the unit vector `n` of its frame, and how steep the rim's plane is to n, as
    /// a sine; where it is level the point on the x axis.
    pub(super) fn lowest(&self, rim: usize, n: &Vector3<T>) -> Option<(Vector3<T>, T)> {
        let [radius, height] = self.rim(rim)?;
        let across = Vector3::new(n.x, n.y, T::zero());
        let steep = sqrt(across.dot(&across));
        let out = direction(&across).map_or_else(Vector3::x, |d| -d);
        Some((out * radius + Vector3::z() * height, steep))
    }

    /// Radius of the sphere around the origin that holds it (m).
    pub(super) fn radius(&self) -> T {
        self.rims.iter().fold(T::zero(), |r, &[radius, z]| max(r, sqrt(radius * radius + z * z)))
    }
}

fn squared<T: Scalar>(from: [T; 2], to: [T; 2]) -> T {
    (to[0] - from[0]) * (to[0] - from[0]) + (to[1] - from[1]) * (to[1] - from[1])
}

/// Outward normal of a side of the profile: right of its way up.
fn outward<T: Scalar>(from: [T; 2], to: [T; 2]) -> [T; 2] {
    let length = sqrt(squared(from, to));
    [(to[1] - from[1]) / length, -(to[0] - from[0]) / length]
}
