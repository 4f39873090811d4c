//! Shapes of bodies.

use std::sync::Arc;

use nalgebra::Vector3;

use super::bounds::Bounds;
use super::error::HullError;
use super::mass::MassProperties;
use super::polyhedron::Polyhedron;
use super::pose::Pose;
use super::real::{infinity, max, sqrt};
use super::round::Round;
use super::terrain::Terrain;
use crate::scalar::{Scalar, lit, to_f64};

/// Why a shape is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeError {
    /// A length that is not positive and finite.
    #[error("the {what} of a {shape} is {value:e} m, it must be positive and finite")]
    Length {
        /// The shape.
        shape: &'static str,
        /// Which length.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// Too few facets, or more than 1000.
    #[error("a {shape} of {sides} facets: there must be 3 to 1000")]
    Facets {
        /// The shape.
        shape: &'static str,
        /// Their number.
        sides: usize,
    },
    /// No hull.
    #[error(transparent)]
    Hull(#[from] HullError),
    /// A half-space, or no part at all, has no finite volume.
    #[error("a {shape} has no finite volume, and so no mass")]
    NoVolume {
        /// The shape.
        shape: &'static str,
    },
    /// A density that is not positive and finite.
    #[error("the density is {density:e} kg/m³, it must be positive and finite")]
    Density {
        /// The density.
        density: f64,
    },
}

/// A shape, in a frame of its own; copies share their tables.
///
/// | shape | frame | contacts |
/// |---|---|---|
/// | ball | centre | exact |
/// | capsule | centre, axis z | exact |
/// | cuboid | centre, edges along the axes | exact |
/// | polyhedron | that of its vertices | exact |
/// | half-space | solid where z ≤ 0 | exact |
/// | terrain | that of its points | balls and capsules exact; a polyhedron with its vertices, its faces over sharp corners, its edges over sharp sides |
/// | cylinder, cone | centre of mass, axis z | exact with balls and half-spaces; with others those of the inscribed polyhedron of n facets, at most r (1 − cos(π/n)) inside |
#[derive(Debug, Clone, PartialEq)]
pub struct Shape<T: Scalar> {
    pub(super) kind: Kind<T>,
    /// Radius of a sphere that holds it, around the origin or the centre of a polyhedron; infinite for a half-space or a terrain.
    pub(super) radius: T,
}

/// The kinds of shapes there are.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind<T: Scalar> {
    /// All points within `radius` (m) of the origin.
    Ball {
        /// Radius (m).
        radius: T,
    },
    /// All points within `radius` of the segment from (0, 0, −`half_length`) to (0, 0, `half_length`) (m).
    Capsule {
        /// Radius (m).
        radius: T,
        /// Half the length of the segment (m).
        half_length: T,
    },
    /// The points with z ≤ 0.
    HalfSpace,
    /// A box.
    Cuboid(Arc<Polyhedron<T>>),
    /// A convex polyhedron.
    Polyhedron(Arc<Polyhedron<T>>),
    /// A cylinder or a cone.
    Round(Arc<Round<T>>),
    /// A surface of triangles that stands still.
    Terrain(Arc<Terrain<T>>),
}

fn positive<T: Scalar>(shape: &'static str, what: &'static str, value: T) -> Result<(), ShapeError> {
    if value > T::zero() && value < infinity() {
        return Ok(());
    }
    Err(ShapeError::Length { shape, what, value: to_f64(value) })
}

fn facets(shape: &'static str, sides: usize) -> Result<(), ShapeError> {
    if (3..=1000).contains(&sides) { Ok(()) } else { Err(ShapeError::Facets { shape, sides }) }
}

impl<T: Scalar> Shape<T> {
    /// A ball of `radius` (m).
    ///
    /// # Errors
    ///
    /// [`ShapeError::Length`] for a radius that is not positive and finite.
    pub fn ball(radius: T) -> Result<Self, ShapeError> {
        positive("ball", "radius", radius)?;
        Ok(Self { kind: Kind::Ball { radius }, radius })
    }

    /// A capsule along z: all points within `radius` (m) of a segment of half the length `half_length` (m).
    ///
    /// # Errors
    ///
    /// [`ShapeError::Length`] for a length that is not positive and finite.
    pub fn capsule(radius: T, half_length: T) -> Result<Self, ShapeError> {
        positive("capsule", "radius", radius)?;
        positive("capsule", "half length", half_length)?;
        let kind = Kind::Capsule { radius, half_length };
        Ok(Self { kind, radius: radius + half_length })
    }

    /// A box of half extents `half` (m).
    ///
    /// # Errors
    ///
    /// [`ShapeError::Length`] for one that is not positive and finite.
    pub fn cuboid(half: Vector3<T>) -> Result<Self, ShapeError> {
        for &extent in half.iter() {
            positive("box", "half extent", extent)?;
        }
        let hull = Polyhedron::cuboid(half)?;
        Ok(Self { radius: hull.radius(), kind: Kind::Cuboid(Arc::new(hull)) })
    }

    /// The half-space z ≤ 0 of its frame.
    pub fn half_space() -> Self {
        Self { kind: Kind::HalfSpace, radius: infinity() }
    }

    /// A terrain; it is no shape of a body.
    pub fn terrain(terrain: Terrain<T>) -> Self {
        Self { radius: infinity(), kind: Kind::Terrain(Arc::new(terrain)) }
    }

    /// A convex polyhedron.
    pub fn polyhedron(hull: Polyhedron<T>) -> Self {
        Self { radius: hull.radius(), kind: Kind::Polyhedron(Arc::new(hull)) }
    }

    /// A cylinder of `radius` and half the height `half_height` (m), with `sides` facets inscribed for contacts with polyhedra,
    /// capsules and rounds.
    ///
    /// # Errors
    ///
    /// [`ShapeError::Length`], and [`ShapeError::Facets`] outside of 3 to 1000.
    pub fn cylinder(radius: T, half_height: T, sides: usize) -> Result<Self, ShapeError> {
        positive("cylinder", "radius", radius)?;
        positive("cylinder", "half height", half_height)?;
        facets("cylinder", sides)?;
        Self::round(Round::new(vec![[radius, -half_height], [radius, half_height]], sides)?)
    }

    /// A cone of `radius` and `height` (m), its tip up, with `sides` facets inscribed, see [`cylinder`](Self::cylinder). Its base
    /// is a quarter of the height below the origin.
    ///
    /// # Errors
    ///
    /// As [`cylinder`](Self::cylinder).
    pub fn cone(radius: T, height: T, sides: usize) -> Result<Self, ShapeError> {
        positive("cone", "radius", radius)?;
        positive("cone", "height", height)?;
        facets("cone", sides)?;
        let quarter = height / lit::<T>(4.0);
        Self::round(Round::new(vec![[radius, -quarter], [T::zero(), height - quarter]], sides)?)
    }

    fn round(round: Round<T>) -> Result<Self, ShapeError> {
        Ok(Self { radius: round.radius(), kind: Kind::Round(Arc::new(round)) })
    }

    /// What it is.
    pub fn kind(&self) -> &Kind<T> {
        &self.kind
    }

    /// Its polyhedron: a box's own, that inscribed in a cylinder or cone; `None` for balls, capsules, half-spaces and terrain.
    pub fn as_polyhedron(&self) -> Option<&Polyhedron<T>> {
        match &self.kind {
            Kind::Cuboid(hull) | Kind::Polyhedron(hull) => Some(hull),
            Kind::Round(round) => Some(&round.facets),
            Kind::Ball { .. } | Kind::Capsule { .. } | Kind::HalfSpace | Kind::Terrain(_) => None,
        }
    }

    /// A length of the shape: radius of a sphere that holds it (m); infinite for a half-space.
    pub fn size(&self) -> T {
        self.radius
    }

    /// Mass, centre and inertia of the solid of `density` (kg/m³): closed forms, those of the exact cylinder and cone.
    ///
    /// # Errors
    ///
    /// [`ShapeError::Density`], and [`ShapeError::NoVolume`] for a half-space.
    pub fn mass_properties(&self, density: T) -> Result<MassProperties<T>, ShapeError> {
        if !(density > T::zero() && density < infinity()) {
            return Err(ShapeError::Density { density: to_f64(density) });
        }
        let pi = lit::<T>(std::f64::consts::PI);
        let l = lit::<T>;
        Ok(match &self.kind {
            &Kind::Ball { radius: r } => {
                let mass = density * pi * r * r * r * l(4.0) / l(3.0);
                MassProperties::axial(mass, [mass * r * r * l(0.4); 3])
            }
            &Kind::Capsule { radius: r, half_length: h } => {
                let tube = density * pi * r * r * (h + h);
                let ball = density * pi * r * r * r * l(4.0) / l(3.0);
                // Each half of the ball has its centre 3r/8 beyond the end of the tube.
                let across = tube * (r * r / l(4.0) + h * h / l(3.0))
                    + ball * (r * r * l(0.4) + h * h + h * r * l(0.75));
                MassProperties::axial(tube + ball, [across, across, r * r * (tube * l(0.5) + ball * l(0.4))])
            }
            Kind::HalfSpace => return Err(ShapeError::NoVolume { shape: "half-space" }),
            Kind::Terrain(_) => return Err(ShapeError::NoVolume { shape: "terrain" }),
            Kind::Cuboid(hull) => {
                let x = hull.vertices()[7];
                let mass = density * x.x * x.y * x.z * l(8.0);
                let third = mass / l(3.0);
                let [a, b, c] = [x.x * x.x, x.y * x.y, x.z * x.z];
                MassProperties::axial(mass, [third * (b + c), third * (a + c), third * (a + b)])
            }
            Kind::Polyhedron(hull) => hull.mass_properties(density),
            Kind::Round(round) => {
                let ([r, low], [top, high]) = (round.rims[0], round.rims[1]);
                let height = high - low;
                if top > T::zero() {
                    let mass = density * pi * r * r * height;
                    let across = mass * (r * r / l(4.0) + height * height / l(12.0));
                    MassProperties::axial(mass, [across, across, mass * r * r * l(0.5)])
                } else {
                    let mass = density * pi * r * r * height / l(3.0);
                    let across = mass * (r * r * l(0.15) + height * height * l(0.0375));
                    MassProperties::axial(mass, [across, across, mass * r * r * l(0.3)])
                }
            }
        })
    }

    /// The smallest box along the fixed axes that holds the shape at `pose`, grown by `reach` (m); all of space for a half-space.
    pub fn bounds(&self, pose: &Pose<T>, reach: T) -> Bounds<T> {
        let origin = pose.position() + pose.arm();
        match &self.kind {
            &Kind::Ball { radius } => Bounds::around(origin, Vector3::repeat(radius + reach)),
            &Kind::Capsule { radius, half_length } => {
                let axis = pose.rotation().column(2) * half_length;
                Bounds::around(origin, axis.abs().add_scalar(radius + reach))
            }
            Kind::HalfSpace => Bounds::everywhere(),
            Kind::Cuboid(hull) => {
                let half = pose.rotation().abs() * hull.vertices()[7];
                Bounds::around(origin, half.add_scalar(reach))
            }
            Kind::Polyhedron(hull) => Bounds::of(hull.vertices().iter().map(|x| pose.turn(x)), origin, reach),
            Kind::Terrain(terrain) => {
                let Bounds { low, high } = terrain.bounds();
                let half = lit::<T>(0.5);
                let around = pose.rotation().abs() * ((high - low) * half);
                Bounds::around(origin + pose.turn(&((high + low) * half)), around.add_scalar(reach))
            }
            Kind::Round(round) => {
                let axis = pose.rotation().column(2).into_owned();
                let across = axis.map(|c| sqrt(max(T::one() - c * c, T::zero())));
                let rims = round
                    .rims
                    .iter()
                    .flat_map(|&[radius, z]| [axis * z + across * radius, axis * z - across * radius]);
                Bounds::of(rims, origin, reach)
            }
        }
    }
}
