//! From a scene and a run to a scheme ready to step.

use std::borrow::Cow;
use std::collections::BTreeSet;

use nalgebra::SVector;

use super::format::InterfaceSpec;
use super::names::Directory;
use super::obstacles::check_obstacles;
use super::{
    GapSpec, JointSpec, LoadSpec, ObstacleSpec, PlannedRun, PreloadSpec, Scene, SceneError, SpaceJointSpec,
};
use crate::laws::{Approach, ContactLaw, Rows};
use crate::registry::Registry;
use crate::scalar::{Scalar, epsilon, lit};
use crate::scheme::{Activation, Settings, ThetaScheme, equilibrium};
use crate::solver::Stopping;
use crate::system::{Body, BodyId, Dynamics, RigidBodies, System};

/// Tolerance of the contacts of a preload, 64 ε for scalars that cannot resolve it.
const PRELOAD: f64 = 1e-13;

/// A law chosen by name.
pub(super) type AnyLaw<T, const D: usize> = Box<dyn ContactLaw<T, D>>;

/// A system of any kind.
pub(super) type AnySystem<T, const D: usize> = Box<dyn System<T, D>>;

impl InterfaceSpec {
    /// The two sides, for errors.
    pub fn label(&self) -> String {
        format!("`{}` – `{}`", self.between[0], self.between[1])
    }

    /// Names of its laws in runs of `laws`, each once.
    pub(super) fn laws_in<'a>(&'a self, laws: &'a [String]) -> Vec<&'a str> {
        match &self.law {
            Some(law) => vec![law],
            None => laws.iter().map(String::as_str).collect(),
        }
    }

    pub(super) fn law<T: Scalar, const D: usize>(
        &self,
        run: &PlannedRun,
        registry: &Registry,
    ) -> Result<AnyLaw<T, D>, SceneError> {
        self.law_of(&run.law, registry)
    }

    /// The law of the interface in the runs of `run_law`.
    pub(super) fn law_of<T: Scalar, const D: usize>(
        &self,
        run_law: &str,
        registry: &Registry,
    ) -> Result<AnyLaw<T, D>, SceneError> {
        let name = self.law.as_deref().unwrap_or(run_law);
        let error = |source| SceneError::Law { interface: self.label(), source };
        let family = registry.find_law(name).map_err(error)?;
        let description = family.description();
        let known = |parameter: &str| description.parameters.iter().any(|p| p.name == parameter);
        let given = self.parameters.iter().filter(|(p, _)| known(p)).map(|(p, &x)| (p.as_str(), x));
        let values = description.arrange(given).map_err(error)?;
        let values: Vec<T> = values.into_iter().map(lit).collect();
        family.build(&values).map_err(error)
    }
}

impl Scene {
    /// Whatever has a law: the interfaces, limits of joints and gaps of a Lagrangian system.
    pub(super) fn all_interfaces(&self) -> impl Iterator<Item = Cow<'_, InterfaceSpec>> {
        let limits = self.joints.iter().filter(|joint| joint.limits.is_some());
        let gaps = self.lagrangian.iter().flat_map(|lagrangian| &lagrangian.gaps);
        let spatial = self.space.iter().flat_map(|space| &space.joints);
        let spatial = spatial.filter(|joint| joint.limits.is_some()).map(SpaceJointSpec::interface);
        let own = limits.map(JointSpec::interface).chain(spatial).chain(gaps.map(GapSpec::interface));
        self.interfaces.iter().map(Cow::Borrowed).chain(own.map(Cow::Owned))
    }
}

/// Contact dimension the runs of a scene need: 1 where every law of every run is frictionless, 3 where one has rolling
/// resistance, else 2.
///
/// # Errors
/// A law that cannot be made, a parameter that no law of the registry has.
pub fn contact_dimension(
    scene: &Scene,
    runs: &[PlannedRun],
    registry: &Registry,
) -> Result<usize, SceneError> {
    let mut rows = Rows::Normal;
    for interface in scene.all_interfaces() {
        for run in runs {
            let law: AnyLaw<f64, 2> = interface.law(run, registry)?;
            rows = rows.max(law.rows());
        }
        // One that laws have which are not in the runs is no mistake of writing: it is told, see `Scene::warnings`.
        let known: BTreeSet<&str> =
            registry.laws().flat_map(|law| law.parameters.iter().map(|p| p.name)).collect();
        if let Some(parameter) = interface.parameters.keys().find(|p| !known.contains(p.as_str())) {
            let (interface, parameter) = (interface.label(), parameter.clone());
            let known = known.into_iter().collect::<Vec<_>>().join(", ");
            return Err(SceneError::UnusedParameter { interface, parameter, known });
        }
    }
    if let Some(solid) = &scene.solid
        && solid.mesh.mesh(&scene.folder)?.dimension() == 1
    {
        if rows != Rows::Normal {
            let what = "the friction of a bar".into();
            return Err(SceneError::OutOfRange { what, value: f64::NAN, range: "0: a line has no tangent" });
        }
        return Ok(1);
    }
    match rows {
        Rows::Normal => Ok(1),
        Rows::Tangent if scene.space.is_some() => Ok(3),
        Rows::Tangent => Ok(2),
        _ if scene.space.is_some() => Err(SceneError::RollingSpace { law: scene.laws.join(", ") }),
        _ if scene.solid.is_some() => Err(SceneError::RollingSolid),
        _ => Ok(3),
    }
}

/// A system with its laws, by interface, and its initial state (q, v).
pub(super) type Parts<T, const D: usize> = (AnySystem<T, D>, Vec<AnyLaw<T, D>>, Vec<T>, Vec<T>);

/// Builds the scheme of a run.
///
/// # Errors
/// [`SceneError`] naming what is wrong and its value.
pub fn build<T: Scalar, const D: usize>(
    scene: &Scene,
    run: &PlannedRun,
    registry: &Registry,
) -> Result<ThetaScheme<T, D>, SceneError> {
    let (system, laws, q, v) = parts(scene, run, registry)?;
    scene.check_theta(run, registry)?;
    let solver = registry.build_solver(&run.solver, stopping(scene))?;
    Ok(ThetaScheme::new(system, laws, solver, settings(scene, run), T::zero(), q, v)?)
}

/// What moves in a run, under which laws, from where.
pub(super) fn parts<T: Scalar, const D: usize>(
    scene: &Scene,
    run: &PlannedRun,
    registry: &Registry,
) -> Result<Parts<T, D>, SceneError> {
    check_state(scene)?;
    if let Some(space) = &scene.space {
        return space.parts(scene, (run, registry));
    }
    if let Some(lagrangian) = &scene.lagrangian {
        return lagrangian.parts(scene, (run, registry));
    }
    match &scene.solid {
        Some(solid) if scene.bodies.is_empty() && scene.obstacles.is_empty() => {
            let (mut body, interfaces) = solid.body::<T>(scene)?;
            let of = |&interface: &usize| scene.interfaces[interface].law(run, registry);
            let laws = interfaces.iter().map(of).collect::<Result<Vec<AnyLaw<T, D>>, _>>()?;
            let n = body.dofs();
            let q = match solid.preload {
                None => vec![T::zero(); n],
                Some(PreloadSpec { contacts, constant_forces }) => match contacts.support() {
                    Some(support) => body.preload(T::zero(), support, constant_forces)?,
                    None => {
                        let at_rest = Approach::impact(SVector::zeros(), lit(run.theta));
                        let friction: Vec<T> =
                            laws.iter().map(|law| law.respond(&at_rest).cone.friction()).collect();
                        // Where the run starts from, once: what is left there moves in every step.
                        let given = stopping(scene);
                        let precise =
                            nalgebra::RealField::max(lit::<T>(PRELOAD), lit::<T>(64.0) * epsilon::<T>());
                        let tolerance = nalgebra::RealField::min(given.tolerance, precise);
                        let stopping = Stopping { tolerance, ..given };
                        let mut solver = registry.build_solver::<T, D>(&run.solver, stopping)?;
                        equilibrium(&mut body, &friction, &mut *solver, T::zero(), constant_forces)?
                    }
                },
            };
            let mut v = vec![T::zero(); n];
            let geometry = body.geometry();
            for node in 0..geometry.mesh().nodes().len() {
                for axis in 0..geometry.mesh().dimension() {
                    v[geometry.dof(node, axis)] = lit(solid.velocity[axis]);
                }
            }
            Ok((Box::new(body), laws, q, v))
        }
        Some(_) => Err(SceneError::Mixed),
        None if scene.bodies.is_empty() => Err(SceneError::Empty { what: "body" }),
        None => {
            let (mut q, mut v) = (Vec::new(), Vec::new());
            for body in &scene.bodies {
                q.extend([body.position[0], body.position[1], body.angle].map(lit::<T>));
                v.extend([body.velocity[0], body.velocity[1], body.spin].map(lit::<T>));
            }
            for start in scene.obstacles.iter().filter_map(ObstacleSpec::start) {
                q.extend(start.map(lit::<T>));
                v.extend([T::zero(); 3]);
            }
            let (system, laws) = build_system(scene, run, registry, &q)?;
            Ok((Box::new(system), laws, q, v))
        }
    }
}

pub(super) fn stopping<T: Scalar>(scene: &Scene) -> Stopping<T> {
    let defaults = Stopping::default();
    Stopping {
        tolerance: scene.solver.tolerance.map_or(defaults.tolerance, lit),
        max_iterations: scene.solver.max_iterations,
        max_seconds: scene.solver.max_seconds,
    }
}

/// Checks what only the scene can name: gravity and the initial state.
fn check_state(scene: &Scene) -> Result<(), SceneError> {
    let check = |what: &dyn Fn() -> String, values: &[f64]| match values.iter().find(|x| !x.is_finite()) {
        Some(&value) => Err(SceneError::OutOfRange { what: what(), value, range: "finite" }),
        None => Ok(()),
    };
    check(&|| "gravity".into(), &scene.gravity)?;
    if let Some(value) = scene.dimension.filter(|&dimension| dimension != 2 && scene.space.is_none()) {
        let (what, range) = ("dimension".into(), "2 or 3");
        return Err(SceneError::OutOfRange { what, value: value.into(), range });
    }
    check_obstacles(scene)?;
    if let Some(solid) = &scene.solid {
        check(&|| format!("velocity of `{}`", solid.name), &solid.velocity)?;
    }
    for body in &scene.bodies {
        check(&|| format!("position of `{}`", body.name), &body.position)?;
        check(&|| format!("angle of `{}`", body.name), &[body.angle])?;
        check(&|| format!("velocity of `{}`", body.name), &body.velocity)?;
        check(&|| format!("spin of `{}`", body.name), &[body.spin])?;
    }
    Ok(())
}

fn settings<T: Scalar>(scene: &Scene, run: &PlannedRun) -> Settings<T> {
    let time = &scene.time;
    let activation = Activation {
        rule: time.activation,
        gap_tolerance: time.gap_tolerance.map(lit),
        velocity_tolerance: time.velocity_tolerance.map(lit),
    };
    Settings {
        theta: lit(run.theta),
        step: lit(scene.step_length()),
        activation,
        allow_unproved_theta: time.allow_unproved_theta,
        lasting: time.lasting,
        theta_rest: lit(time.theta_rest),
        sleep: time.sleep,
        joint_tolerance: time.joint_tolerance.map(lit),
    }
}

type SystemAndLaws<T, const D: usize> = (RigidBodies<T>, Vec<AnyLaw<T, D>>);

fn build_system<T: Scalar, const D: usize>(
    scene: &Scene,
    run: &PlannedRun,
    registry: &Registry,
    q: &[T],
) -> Result<SystemAndLaws<T, D>, SceneError> {
    let directory = Directory::new(scene)?;
    directory.check_interfaces(scene)?;
    let groups = directory.groups(scene);
    let mut builder = RigidBodies::builder();
    let ids: Vec<_> = groups.sides.iter().map(|_| builder.group()).collect();

    let mut bodies: Vec<BodyId> = Vec::new();
    for (body, groups) in scene.bodies.iter().zip(&groups.contactors) {
        let id = builder.body(&body.name, Body { mass: lit(body.mass), inertia: lit(body.inertia) })?;
        builder.force(id, body.force.map(lit), lit(body.torque))?;
        for LoadSpec { force, torque, signal } in &body.loads {
            builder.load(id, force.map(lit), lit(*torque), signal.cast())?;
        }
        builder.spring(id, body.stiffness.map(lit))?;
        builder.damper(id, body.damping.map(lit))?;
        for (disc, &group) in body.discs.iter().zip(groups) {
            let label = format!("{}.{}", body.name, disc.name);
            builder.disc(&label, id, disc.centre.map(lit), lit(disc.radius), ids[group])?;
        }
        for (polygon, &group) in body.polygons.iter().zip(&groups[body.discs.len()..]) {
            for (label, part) in polygon.parts(&format!("{}.{}", body.name, polygon.name))? {
                let vertices: Vec<[T; 2]> = part.iter().map(|x| x.map(lit)).collect();
                builder.polygon(&label, id, &vertices, ids[group])?;
            }
        }
        bodies.push(id);
    }
    let mut movers: Vec<Option<BodyId>> = Vec::new();
    for (obstacle, groups) in scene.obstacles.iter().zip(&groups.obstacles) {
        let groups: Vec<_> = groups.iter().map(|&group| ids[group]).collect();
        movers.push(obstacle.build(&mut builder, &groups)?);
    }
    // The interfaces of limits come first, in the order of the joints.
    let mut laws = Vec::new();
    for joint in &scene.joints {
        joint.build(scene, (run, registry), (&mut builder, (&bodies, &movers)), &mut laws)?;
    }
    for spring in &scene.springs {
        spring.build(scene, (&mut builder, (&bodies, &movers)), q)?;
    }
    builder.gravity(scene.gravity.map(lit))?;
    for (plane, &group) in scene.half_planes.iter().zip(&groups.planes) {
        builder.half_plane(&plane.name, plane.point.map(lit), plane.normal.map(lit), ids[group])?;
    }
    for ([a, b], interface) in groups.interfaces() {
        builder.interface(ids[a], ids[b])?;
        laws.push(scene.interfaces[interface].law(run, registry)?);
    }
    Ok((builder.build()?, laws))
}
