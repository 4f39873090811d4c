//! From a scene in space to its system.

use std::collections::BTreeSet;
use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};

use super::shape::pose;
use super::{SpaceBodySpec, SpaceSpec};
use crate::geometry::{Compound, Part, Pose, Principal};
use crate::registry::Registry;
use crate::scalar::{Scalar, lit};
use crate::scene::build::{AnyLaw, Parts};
use crate::scene::names::{Directory, Groups};
use crate::scene::{PlannedRun, Scene, SceneError};
use crate::system::{BodyId, SpatialBodies, SpatialBody};

type Names = BTreeSet<String>;

/// What a shape, a body or a half-space answers to.
fn names(owner: &str, shape: &str, groups: &[String]) -> Names {
    [owner.to_string(), format!("{owner}.{shape}")].into_iter().chain(groups.iter().cloned()).collect()
}

/// A body in its principal frame.
struct Placed<T: Scalar> {
    body: SpatialBody<T>,
    parts: Vec<Part<T>>,
    pose: Pose<T>,
    velocity: Vector3<T>,
    spin: Vector3<T>,
}

impl SpaceBodySpec {
    fn placed<T: Scalar>(&self, folder: &Path) -> Result<Placed<T>, SceneError> {
        if let Some(repeat) = &self.repeat {
            let [x, y, z] = repeat.count;
            let what = format!("number of copies of `{}`", self.name);
            let value = x as f64 * y as f64 * z as f64;
            return Err(SceneError::OutOfRange { what, value, range: "from 1 to 1,000,000" });
        }
        let parts: Vec<Part<T>> = (self.shapes.iter().enumerate())
            .map(|(k, shape)| shape.part(&format!("{}.{}", self.name, shape.name(k)), folder))
            .collect::<Result<_, _>>()?;
        let frame = pose(&self.name, self.position, self.orientation)?;
        let mass_of = |source| SceneError::BodyMass { body: self.name.clone(), source };
        let (body, parts, own) = match (self.density, self.mass, self.inertia) {
            (None, Some(mass), Some(moments)) => {
                (SpatialBody { mass: lit(mass), moments: moments.map(lit) }, parts, Pose::identity())
            }
            (Some(density), None, None) => {
                let (compound, mass, Principal { moments, .. }, own) =
                    Compound::new(parts).into_principal(lit(density)).map_err(mass_of)?;
                (SpatialBody { mass, moments: moments.into() }, compound.parts().to_vec(), own)
            }
            (None, Some(mass), None) => {
                let (compound, unit, Principal { moments, .. }, own) =
                    Compound::new(parts).into_principal(T::one()).map_err(mass_of)?;
                let moments = moments * (lit::<T>(mass) / unit);
                (SpatialBody { mass: lit(mass), moments: moments.into() }, compound.parts().to_vec(), own)
            }
            _ => return Err(SceneError::MassOrDensity { body: self.name.clone() }),
        };
        let check = |what: &str, values: &[f64; 3]| match values.iter().find(|x| !x.is_finite()) {
            Some(&value) => {
                let what = format!("{what} of `{}`", self.name);
                Err(SceneError::OutOfRange { what, value, range: "finite" })
            }
            None => Ok(Vector3::from(values.map(lit::<T>))),
        };
        let orientation: UnitQuaternion<T> = frame.orientation() * own.orientation();
        let spin = check("spin", &self.spin)?;
        Ok(Placed {
            body,
            parts,
            pose: Pose::new(frame.place(own.position()), orientation),
            velocity: check("velocity", &self.velocity)?,
            spin: orientation.inverse() * spin,
        })
    }
}

impl SpaceSpec {
    /// Every name of the scene is taken once.
    fn check_names(&self, scene: &Scene) -> Result<(), SceneError> {
        let mut taken = BTreeSet::new();
        let mut known = BTreeSet::new();
        let owners = self.bodies.iter().map(|body| (&body.name, &body.shapes, &body.groups));
        let owners = owners.chain(self.obstacles.iter().map(|of| (&of.name, &of.shapes, &of.groups)));
        let mut take = |name: &String| {
            if taken.insert(name.clone()) {
                Ok(())
            } else {
                Err(SceneError::DuplicateName { name: name.clone() })
            }
        };
        for (owner, shapes, groups) in owners {
            take(owner)?;
            known.extend(groups.iter().cloned());
            known.insert(owner.clone());
            for (k, shape) in shapes.iter().enumerate() {
                let name = format!("{owner}.{}", shape.name(k));
                take(&name)?;
                known.insert(name);
            }
        }
        for half in &self.half_spaces {
            take(&half.name)?;
            known.insert(half.name.clone());
        }
        for interface in &scene.interfaces {
            if let Some(name) = interface.between.iter().find(|name| !known.contains(*name)) {
                let place = format!("interface {}", interface.label());
                let known = known.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
                return Err(SceneError::UnknownName { place, name: name.clone(), known });
            }
        }
        Ok(())
    }

    /// The system with its laws and its initial state.
    pub(in crate::scene) fn parts<T: Scalar, const D: usize>(
        &self,
        scene: &Scene,
        (run, registry): (&PlannedRun, &Registry),
    ) -> Result<Parts<T, D>, SceneError> {
        if self.bodies.is_empty() {
            return Err(SceneError::Empty { what: "body" });
        }
        self.check_names(scene)?;
        let mut groups = Groups::default();
        let mut group = |names: &Names| groups.of(Directory::sides(scene, names));
        let group_of = |owner: &str,
                        shapes: &[super::ShapeSpec],
                        of: &[String],
                        group: &mut dyn FnMut(&Names) -> usize| {
            let each = shapes.iter().enumerate();
            each.map(|(k, shape)| group(&names(owner, &shape.name(k), of))).collect::<Vec<_>>()
        };
        let of_bodies: Vec<_> =
            self.bodies.iter().map(|b| group_of(&b.name, &b.shapes, &b.groups, &mut group)).collect();
        let of_obstacles: Vec<_> =
            self.obstacles.iter().map(|o| group_of(&o.name, &o.shapes, &o.groups, &mut group)).collect();
        let of_halves: Vec<_> =
            self.half_spaces.iter().map(|half| group(&Names::from([half.name.clone()]))).collect();
        let sides = groups.into_sides();

        let mut builder = SpatialBodies::builder();
        let ids: Vec<_> = sides.iter().map(|_| builder.group()).collect();
        let (mut q, mut v) = (Vec::new(), Vec::new());
        for (spec, groups) in self.bodies.iter().zip(&of_bodies) {
            let Placed { body, parts, pose, velocity, spin } = spec.placed(&scene.folder)?;
            let id = builder.body(&spec.name, body)?;
            builder.force(id, spec.force.map(lit), spec.torque.map(lit))?;
            for load in &spec.loads {
                builder.load(id, load.force.map(lit), load.torque.map(lit), load.signal.cast())?;
            }
            for (k, (part, &group)) in parts.into_iter().zip(groups).enumerate() {
                let label = format!("{}.{}", spec.name, spec.shapes[k].name(k));
                builder.shape(&label, id, part.shape, part.pose, ids[group])?;
            }
            let turn = pose.orientation();
            q.extend(pose.position().iter().chain(&[turn.w, turn.i, turn.j, turn.k]));
            v.extend(velocity.iter().chain(spin.iter()));
        }
        builder.gravity(self.gravity.map(lit))?;
        for (spec, groups) in self.obstacles.iter().zip(&of_obstacles) {
            let frame = pose(&spec.name, spec.position, spec.orientation)?;
            for (k, (shape, &group)) in spec.shapes.iter().zip(groups).enumerate() {
                let label = format!("{}.{}", spec.name, shape.name(k));
                let Part { shape, pose } = shape.part::<T>(&label, &scene.folder)?;
                builder.shape(&label, BodyId::GROUND, shape, frame.part(&pose), ids[group])?;
            }
        }
        for (half, &group) in self.half_spaces.iter().zip(&of_halves) {
            builder.half_space(&half.name, half.point.map(lit), half.normal.map(lit), ids[group])?;
        }
        let mut laws: Vec<AnyLaw<T, D>> = Vec::new();
        for a in 0..sides.len() {
            for b in a..sides.len() {
                if let Some(interface) = Directory::interface_between(&sides[a], &sides[b]) {
                    builder.interface(ids[a], ids[b])?;
                    laws.push(scene.interfaces[interface].law(run, registry)?);
                }
            }
        }
        Ok((Box::new(builder.build()?), laws, q, v))
    }

    /// Names of the bodies that no interface lets touch anything.
    pub(in crate::scene) fn idle(&self, scene: &Scene) -> Vec<String> {
        let named = |names: &Names| {
            scene.interfaces.iter().any(|interface| interface.between.iter().any(|side| names.contains(side)))
        };
        let idle = self.bodies.iter().filter(|body| {
            let mut shapes = body.shapes.iter().enumerate();
            !shapes.any(|(k, shape)| named(&names(&body.name, &shape.name(k), &body.groups)))
        });
        idle.map(|body| body.name.clone()).collect()
    }

    /// Whether there is nothing that could be touched: one body alone.
    pub(in crate::scene) fn has_bodies_alone(&self) -> bool {
        self.bodies.len() == 1 && self.half_spaces.is_empty() && self.obstacles.is_empty()
    }

    /// The least size of a shape on a body (m), infinite without any.
    #[cfg(feature = "runs")]
    pub(crate) fn least_size(&self, folder: &Path) -> f64 {
        let shapes = self.bodies.iter().flat_map(|body| &body.shapes);
        let parts = shapes.filter_map(|shape| shape.part::<f64>("", folder).ok());
        let thickness = |part: Part<f64>| {
            let bounds = part.shape.bounds(&Pose::identity(), 0.0);
            (bounds.high - bounds.low).min()
        };
        parts.map(thickness).fold(f64::INFINITY, f64::min)
    }
}
