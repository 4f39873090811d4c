//! From a scene in space to its system.

use std::path::{Path, PathBuf};

use nalgebra::{UnitQuaternion, Vector3};

use super::joints::Ids;
use super::shape::pose;
use super::{ShapeSpec, SpaceBodySpec, SpaceObstacleSpec, SpaceSpec};
use crate::geometry::{Compound, Part, Pose, Principal};
use crate::registry::Registry;
use crate::scalar::{Scalar, lit};
use crate::scene::build::{AnyLaw, Parts};
use crate::scene::names::{Directory, Owner};
use crate::scene::warnings::length;
use crate::scene::{PlannedRun, Scene, SceneError, SceneWarning};
use crate::system::{BodyId, Signal, SpatialBodies, SpatialBodiesBuilder, SpatialBody, SpatialMotion};

/// A body in its principal frame, and where that frame stands in its own.
struct Solid<T: Scalar> {
    body: SpatialBody<T>,
    parts: Vec<Part<T>>,
    frame: Pose<T>,
}

impl SpaceBodySpec {
    /// Whether the solid of another body is the same, as that of copies is.
    fn is_like(&self, other: &Self) -> bool {
        (&self.shapes, self.density, self.mass, self.inertia)
            == (&other.shapes, other.density, other.mass, other.inertia)
    }

    fn solid<T: Scalar>(&self, folder: &Path) -> Result<Solid<T>, SceneError> {
        if let Some(repeat) = &self.repeat {
            let [x, y, z] = repeat.count;
            let what = format!("number of copies of `{}`", self.name);
            let value = x as f64 * y as f64 * z as f64;
            return Err(SceneError::OutOfRange { what, value, range: "from 1 to 1,000,000" });
        }
        let parts: Vec<Part<T>> = (self.shapes.iter().enumerate())
            .map(|(k, shape)| shape.part(&format!("{}.{}", self.name, shape.name(k)), folder))
            .collect::<Result<_, _>>()?;
        // The density, or the mass that a density of 1 is scaled to.
        let (density, mass) = match (self.density, self.mass, self.inertia) {
            (None, Some(mass), Some(moments)) => {
                let body = SpatialBody { mass: lit(mass), moments: moments.map(lit) };
                return Ok(Solid { body, parts, frame: Pose::identity() });
            }
            (Some(density), None, None) => (lit(density), None),
            (None, Some(mass), None) => (T::one(), Some(lit::<T>(mass))),
            _ => return Err(SceneError::MassOrDensity { body: self.name.clone() }),
        };
        let error = |source| SceneError::BodyMass { body: self.name.clone(), source };
        let (compound, own, Principal { moments, .. }, frame) =
            Compound::new(parts).into_principal(density).map_err(error)?;
        let mass = mass.unwrap_or(own);
        let body = SpatialBody { mass, moments: (moments * (mass / own)).into() };
        Ok(Solid { body, parts: compound.parts().to_vec(), frame })
    }

    /// q and v at the start, of a body with its principal frame at `own` in its own.
    fn start<T: Scalar>(&self, own: &Pose<T>) -> Result<([T; 7], [T; 6]), SceneError> {
        let check = |what: &str, values: &[f64; 3]| match values.iter().find(|x| !x.is_finite()) {
            Some(&value) => {
                let what = format!("{what} of `{}`", self.name);
                Err(SceneError::OutOfRange { what, value, range: "finite" })
            }
            None => Ok(Vector3::from(values.map(lit::<T>))),
        };
        let frame = pose(&self.name, self.position, self.orientation)?;
        let turn: UnitQuaternion<T> = frame.orientation() * own.orientation();
        let place = frame.place(own.position());
        let velocity = check("velocity", &self.velocity)?;
        let spin = turn.inverse() * check("spin", &self.spin)?;
        let q = [place.x, place.y, place.z, turn.w, turn.i, turn.j, turn.k];
        Ok((q, [velocity.x, velocity.y, velocity.z, spin.x, spin.y, spin.z]))
    }
}

impl SpaceObstacleSpec {
    /// The body of an obstacle that moves as told, of the mean mass of the others: it counts in the kinetic energy, and in nothing
    /// else. Its velocity at the start is that of its motion.
    fn mover<T: Scalar>(
        &self,
        frame: &Pose<T>,
        scene: &Scene,
        (builder, q, v): (&mut SpatialBodiesBuilder<T>, &mut Vec<T>, &mut Vec<T>),
    ) -> Result<Option<BodyId>, SceneError> {
        if self.motion.is_empty() {
            return Ok(None);
        }
        let turns = self.motion.iter().any(|motion| motion.angle != 0.0);
        let axis = match self.motion_axis {
            Some(axis) => axis,
            None if turns => return Err(SceneError::MotionAxis { obstacle: self.name.clone() }),
            None => [0.0, 0.0, 1.0],
        };
        let body = builder.body(&self.name, builder.mean_body())?;
        let (at, turn) = (frame.position(), frame.orientation());
        let (first, dofs) = (q.len(), v.len());
        q.extend([at.x, at.y, at.z, turn.w, turn.i, turn.j, turn.k]);
        v.resize(dofs + 6, T::zero());
        let turning = self.motion.iter().filter(|motion| motion.angle != 0.0);
        let shifts = self.motion.iter().map(|motion| (motion.displacement.map(lit), motion.signal.cast()));
        let motion = SpatialMotion {
            displacements: shifts.collect(),
            axis: axis.map(lit),
            angles: turning.map(|motion| (lit(motion.angle), motion.signal.cast())).collect(),
        };
        builder.told(body, &motion, q)?;
        motion.start(lit(scene.time.step), &mut q[first..], &mut v[dofs..]);
        Ok(Some(body))
    }
}

impl SpaceSpec {
    /// The bodies, the obstacles and the half-spaces.
    pub(in crate::scene) fn owners(&self) -> [Vec<Owner>; 3] {
        let owner = |name: &str, shapes: &[ShapeSpec], groups: &[String]| Owner {
            name: name.into(),
            shapes: shapes.iter().enumerate().map(|(k, shape)| shape.name(k)).collect(),
            groups: groups.to_vec(),
        };
        let bodies = self.bodies.iter().map(|body| owner(&body.name, &body.shapes, &body.groups));
        let obstacles = self.obstacles.iter().map(|of| owner(&of.name, &of.shapes, &of.groups));
        let halves = self.half_spaces.iter().map(|half| Owner::alone(&half.name));
        [bodies.collect(), obstacles.collect(), halves.collect()]
    }

    /// Files of shapes.
    pub(in crate::scene) fn files(&self) -> impl Iterator<Item = &PathBuf> {
        let bodies = self.bodies.iter().map(|body| &body.shapes);
        let all = bodies.chain(self.obstacles.iter().map(|obstacle| &obstacle.shapes));
        all.flatten().flat_map(ShapeSpec::files)
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
        let directory = Directory::new(scene)?;
        directory.check_interfaces(scene)?;
        let groups = directory.groups(scene);
        let mut builder = SpatialBodies::builder();
        let ids: Vec<_> = groups.sides.iter().map(|_| builder.group()).collect();
        let (mut q, mut v, mut bodies) = (Vec::new(), Vec::new(), Vec::new());
        let mut last: Option<(&SpaceBodySpec, Solid<T>)> = None;
        for (spec, groups) in self.bodies.iter().zip(&groups.contactors) {
            // Copies share their shapes: files are read once.
            let (_, solid) = match last.take().filter(|(other, _)| other.is_like(spec)) {
                Some(same) => last.insert(same),
                None => last.insert((spec, spec.solid(&scene.folder)?)),
            };
            let start = spec.start(&solid.frame)?;
            q.extend(start.0);
            v.extend(start.1);
            let id = builder.body(&spec.name, solid.body)?;
            bodies.push(id);
            // The body's own axes need not be its principal ones.
            let own = |torque: [f64; 3]| solid.frame.turn_back(&Vector3::from(torque.map(lit::<T>))).into();
            builder.force(id, spec.force.map(lit), own(spec.torque))?;
            builder.torque(id, spec.fixed_torque.map(lit), Signal::Constant)?;
            for load in &spec.loads {
                builder.load(id, load.force.map(lit), own(load.torque), load.signal.cast())?;
                if load.fixed_torque != [0.0; 3] {
                    builder.torque(id, load.fixed_torque.map(lit), load.signal.cast())?;
                }
            }
            for (k, (part, &group)) in solid.parts.iter().zip(groups).enumerate() {
                let label = format!("{}.{}", spec.name, spec.shapes[k].name(k));
                builder.shape(&label, id, part.shape.clone(), part.pose, ids[group])?;
            }
        }
        builder.gravity(self.gravity.map(lit))?;
        let mut movers = Vec::new();
        for (spec, groups) in self.obstacles.iter().zip(&groups.obstacles) {
            let frame = pose(&spec.name, spec.position, spec.orientation)?;
            let mover = spec.mover(&frame, scene, (&mut builder, &mut q, &mut v))?;
            movers.push(mover);
            let (body, frame) = match mover {
                Some(body) => (body, Pose::identity()),
                None => (BodyId::GROUND, frame),
            };
            for (k, (shape, &group)) in spec.shapes.iter().zip(groups).enumerate() {
                let label = format!("{}.{}", spec.name, shape.name(k));
                let Part { shape, pose } = shape.part::<T>(&label, &scene.folder)?;
                builder.shape(&label, body, shape, frame.part(&pose), ids[group])?;
            }
        }
        for (half, &group) in self.half_spaces.iter().zip(&groups.planes) {
            builder.half_space(&half.name, half.point.map(lit), half.normal.map(lit), ids[group])?;
        }
        let mut laws: Vec<AnyLaw<T, D>> = Vec::new();
        // The interfaces of limits come first, in the order of the joints.
        let names = Ids { scene: self, bodies: &bodies, movers: &movers };
        for joint in &self.joints {
            joint.build((run, registry), (&mut builder, &names, &q), &mut laws)?;
        }
        for spring in &self.springs {
            spring.build((&mut builder, &names, &q))?;
        }
        for ([a, b], interface) in groups.interfaces() {
            builder.interface(ids[a], ids[b])?;
            laws.push(scene.interfaces[interface].law(run, registry)?);
        }
        Ok((Box::new(builder.build()?), laws, q, v))
    }

    /// The least thickness of a shape on a body (m), infinite without any.
    pub(crate) fn least_size(&self, folder: &Path) -> f64 {
        thinnest(self.bodies.iter().map(|body| body.shapes.as_slice()), folder)
    }

    /// Whether a body starts so fast that it may pass the thinnest obstacle, or another body, within a step. Half-spaces have
    /// no other side.
    pub(in crate::scene) fn passes(&self, step: f64, folder: &Path) -> Option<SceneWarning> {
        let way = |body: &SpaceBodySpec| step * length(&body.velocity);
        let fastest = self.bodies.iter().max_by(|a, b| way(a).total_cmp(&way(b)))?;
        let fixed = thinnest(self.obstacles.iter().map(|of| of.shapes.as_slice()), folder);
        let moving = if self.bodies.len() > 1 { self.least_size(folder) } else { f64::INFINITY };
        // Half of a body may be below a terrain before it is lost.
        let ground = self.obstacles.iter().any(|of| of.shapes.iter().any(ShapeSpec::is_ground));
        let depth = if ground { 0.5 * self.least_size(folder) } else { f64::INFINITY };
        let (way, thickness) = (way(fastest), fixed.min(moving).min(depth));
        (way > thickness).then(|| SceneWarning::Passes { body: fastest.name.clone(), way, thickness })
    }
}

/// The least thickness along its axes of a shape (m), infinite without any; equal ones in a row are made once.
fn thinnest<'a>(shapes: impl Iterator<Item = &'a [ShapeSpec]>, folder: &Path) -> f64 {
    let mut kinds: Vec<&[ShapeSpec]> = shapes.collect();
    kinds.dedup();
    let solid = kinds.into_iter().flatten().filter(|shape| !shape.is_ground());
    let parts = solid.filter_map(|shape| shape.part::<f64>("", folder).ok());
    let thickness = |part: Part<f64>| {
        let bounds = part.shape.bounds(&Pose::identity(), 0.0);
        (bounds.high - bounds.low).min()
    };
    parts.map(thickness).fold(f64::INFINITY, f64::min)
}
