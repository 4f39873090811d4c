//! The closed form of an elastic bar that hits a wall.

use super::ReferenceError;
use super::reference::Reference;
use crate::registry::Registry;
use crate::scene::{PlannedRun, Scene, build};
use crate::scheme::ThetaScheme;

/// The impacting bar of Doyen, Ern & Piperno (2011), doi:10.1137/100791440, by d'Alembert: a front leaves the wall at
/// the speed c = √(E/ρ) and stops the bar, comes back from the free end and throws it off at v₀. Contact lasts 2L/c with
/// the force ρ c A v₀.
///
/// It is the motion of the continuum: the runs of a mesh approach it as mesh and step are refined together.
#[derive(Debug)]
pub(super) struct Bar {
    /// Distance of each degree of freedom from the end that touches.
    places: Vec<f64>,
    /// +1 where the wall is on the left, −1 where it is on the right.
    side: f64,
    length: f64,
    speed: f64,
    /// c.
    celerity: f64,
    /// Start of the contact.
    contact: f64,
    force: f64,
    energy: f64,
}

impl Bar {
    /// The motion of a scene; an error says what the scene would have to be.
    pub(super) fn new(scene: &Scene, run: &PlannedRun, registry: &Registry) -> Result<Self, ReferenceError> {
        let (Some(solid), [plane], [_]) = (&scene.solid, &scene.half_planes[..], &scene.interfaces[..])
        else {
            return Err("a solid, one half-plane and one interface".into());
        };
        let free = solid.prescribed.is_empty()
            && solid.tractions.is_empty()
            && solid.preload.is_none()
            && solid.rayleigh == [0.0, 0.0]
            && scene.gravity == [0.0, 0.0];
        if !free {
            return Err("no forces, no damping, no preload and nothing prescribed".into());
        }
        let side = plane.normal[0].signum();
        if plane.normal[1] != 0.0 {
            return Err("a wall across the bar".into());
        }
        let scheme: ThetaScheme<f64, 1> = build(scene, run, registry)?;
        let geometry = scheme.system().geometry().ok_or("an elastic body")?;
        let nodes = geometry.mesh().nodes();
        if geometry.mesh().dimension() != 1 {
            return Err("a mesh of a line".into());
        }
        // Distance from the wall.
        let from_wall = |node: usize| side * (nodes[node].position[0] - plane.point[0]);
        let all = || (0..nodes.len()).map(from_wall);
        let (gap, far) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
        let touching: Vec<f64> = geometry.gaps(&vec![0.0; nodes.len()]).map(|(_, gap)| gap).collect();
        let speed = -side * solid.velocity[0];
        let hits = touching.len() == 1 && touching[0] == gap && gap >= 0.0 && speed > 0.0;
        if !hits {
            return Err("contact of the nearer end alone, in front of the wall and moving towards it".into());
        }
        let mut places = vec![0.0; nodes.len()];
        (0..nodes.len()).for_each(|node| places[geometry.dof(node, 0)] = from_wall(node) - gap);
        let (density, celerity) = (solid.density, (solid.young / solid.density).sqrt());
        let length = far - gap;
        Ok(Self {
            places,
            side,
            length,
            speed,
            celerity,
            contact: gap / speed,
            force: density * celerity * solid.section * speed,
            energy: 0.5 * density * solid.section * length * speed * speed,
        })
    }

    /// Displacement away from the wall and its rate at `place`, τ after the impact.
    fn motion(&self, place: f64, tau: f64) -> [f64; 2] {
        let (arrival, back) = (place / self.celerity, (2.0 * self.length - place) / self.celerity);
        if tau <= arrival {
            [-self.speed * tau, -self.speed]
        } else if tau <= back {
            [-self.speed * arrival, 0.0]
        } else {
            [self.speed * (tau - back - arrival), self.speed]
        }
    }
}

impl Reference for Bar {
    fn at(&self, time: f64, q: &mut [f64], v: &mut [f64]) {
        let tau = time - self.contact;
        let approach = -self.speed * self.contact;
        for ((&place, q), v) in self.places.iter().zip(q).zip(v) {
            let [moved, rate] = self.motion(place, tau);
            (*q, *v) = (self.side * (approach + moved), self.side * rate);
        }
    }

    fn percussion(&self, time: f64) -> f64 {
        self.force * (time - self.contact).clamp(0.0, 2.0 * self.length / self.celerity)
    }

    fn energy(&self, _time: f64) -> f64 {
        self.energy
    }
}
