//! Shapes in space and where they meet: pure functions of poses.
//!
//! | item | what it is |
//! |---|---|
//! | [`Pose`], [`frame`] | where a body is; the frame of a normal |
//! | [`Shape`], [`Polyhedron`], [`Compound`] | balls, capsules, boxes, cylinders, cones, half-spaces, convex hulls; unions of them |
//! | [`Surface`] | surfaces from STL and OBJ files |
//! | [`Terrain`] | triangles and height fields that stand still |
//! | [`MassProperties`], [`Principal`] | mass, centre, inertia from shape and density; principal axes, and what is no inertia |
//! | [`NarrowPhase`], [`resolve`] | the [`Contact`]s of two shapes; one of them followed as the shapes move |
//! | [`BroadPhase`], [`Bounds`] | the pairs that are near |
//!
//! # Contacts
//!
//! Every contact is a function of the two poses alone: nothing is kept from call to call, nothing is iterated, no margin is
//! added. A contact says which features meet ([`Meeting`]), its unit normal n from the first shape to the second (the first is
//! the obstacle, the second the body, so that a closing contact has u_N < 0), its gap
//!
//! ```text
//!   g = n·((x_B − x_A) + R_B b − R_A a)
//! ```
//!
//! with centres subtracted first, and the arms to both points. Its error is a few ε (distance + size).
//!
//! Two polyhedra meet along the axis of largest separation: normals of faces, and of pairs of edges whose arcs cross on the
//! Gauss map. Faces win ties; two edges must be better by 1e-8 of the size of the smaller shape, and more than 6° off the face,
//! else they are one more point of the face. Face on face, all corners of the part they share are contacts: a vertex has the
//! normal of the face it is on, two sides that cross their common normal. Where polyhedra overlap the gap is the separation;
//! where they are apart and one is over the other it is the distance along the normal; past each other's corners it is the
//! distance of the two faces next to each other.
//!
//! Identities ([`Meeting::id`]) name the vertex or the edges that meet, never the face that serves as reference, so that
//! rounding does not change them; lengths within 1e-9 of the size of the smaller shape coincide.
//!
//! Balls, capsules, boxes, polyhedra and half-spaces meet exactly; how far cylinders and cones do stands with [`Shape`].
//!
//! ```
//! use nalgebra::{UnitQuaternion, Vector3};
//! use nonsmooth::geometry::{NarrowPhase, Pose, Shape};
//!
//! let cube = Shape::cuboid(Vector3::new(0.5, 0.5, 0.5))?;
//! let below = Pose::identity();
//! let above = Pose::new(Vector3::new(0.0, 0.0, 1.0), UnitQuaternion::identity());
//! let mut contacts = Vec::new();
//! NarrowPhase::new().contacts((&cube, &below), (&cube, &above), 1e-3, &mut contacts);
//! assert_eq!(contacts.len(), 4);
//! assert!(contacts.iter().all(|contact| contact.gap == 0.0 && contact.normal == Vector3::z()));
//! # Ok::<(), nonsmooth::geometry::ShapeError>(())
//! ```

mod bounds;
mod broad;
mod compound;
mod error;
mod feature;
mod hull;
mod inertia;
mod mass;
mod merge;
mod narrow;
mod obj;
mod polyhedron;
mod pose;
mod real;
mod round;
mod shape;
mod stl;
mod surface;
mod terrain;
mod triangle;

pub use bounds::Bounds;
pub use broad::BroadPhase;
pub use compound::{Compound, CompoundError, Part};
pub use error::HullError;
pub use feature::{Carrier, Contact, Feature, Meeting};
pub use inertia::{InertiaError, Principal};
pub use mass::MassProperties;
pub use narrow::{NarrowPhase, resolve};
pub use polyhedron::{Edge, Polyhedron};
pub use pose::{Pose, PoseError, frame};
pub use round::Round;
pub use shape::{Kind, Shape, ShapeError};
pub use surface::{Surface, SurfaceError};
pub use terrain::Terrain;
