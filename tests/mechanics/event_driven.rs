//! The impacting stick solved event by event: ballistic flight in closed form, impact times by root finding, each
//! impact through the law at θ = ½. It is the limit h → 0 of the scheme.

use nalgebra::{Matrix2, Vector2, Vector3};
use nonsmooth::laws::ContactLaw;
use nonsmooth::scene::Scene;
use nonsmooth::solver::ConeSolver;

use crate::impact::{Impact, impact};

/// A flight: q(t) = q + v τ + ½ a τ², τ = t − start, and the impact that began it.
#[derive(Debug)]
pub(crate) struct Flight {
    pub(crate) start: f64,
    q: Vector3<f64>,
    v: Vector3<f64>,
    pub(crate) impact: Option<Impact>,
}

/// The motion of a stick of mass m and inertia I whose tip is `lever` below its centre of mass, (x, y, γ).
#[derive(Debug)]
pub(crate) struct Stick {
    gravity: Vector3<f64>,
    lever: f64,
    inverse_mass: Vector3<f64>,
    pub(crate) flights: Vec<Flight>,
}

/// Steps of the search for the next impact (s): far below the 0.1 s between impacts.
const SEARCH_STEP: f64 = 1e-4;

impl Stick {
    /// The motion of the first body of `scene` until `end`.
    pub(crate) fn new(
        scene: &Scene,
        law: &dyn ContactLaw<f64, 2>,
        solver: &mut dyn ConeSolver<f64, 2>,
        end: f64,
    ) -> Self {
        let body = &scene.bodies[0];
        let flight = Flight {
            start: 0.0,
            q: Vector3::new(body.position[0], body.position[1], body.angle),
            v: Vector3::new(body.velocity[0], body.velocity[1], body.spin),
            impact: None,
        };
        let mut stick = Self {
            gravity: Vector3::new(scene.gravity[0], scene.gravity[1], 0.0),
            lever: -body.discs[0].centre[1],
            inverse_mass: Vector3::new(body.mass, body.mass, body.inertia).map(f64::recip),
            flights: vec![flight],
        };
        while let Some(time) = stick.next_impact(end) {
            let (q, v) = stick.at(time);
            let (normal, tangent) = stick.frame(&q);
            let by_mass = |row: &Vector3<f64>| row.component_mul(&stick.inverse_mass);
            let coupling = normal.dot(&by_mass(&tangent));
            let w = Matrix2::new(
                normal.dot(&by_mass(&normal)),
                coupling,
                coupling,
                tangent.dot(&by_mass(&tangent)),
            );
            let before = Vector2::new(normal.dot(&v), tangent.dot(&v));
            let impact = impact(&w, &before, law, 0.5, solver);
            let [p_n, p_t] = impact.percussion.into();
            let v = v + by_mass(&(normal * p_n + tangent * p_t));
            let after = Vector2::new(normal.dot(&v), tangent.dot(&v));
            assert!(
                (after - impact.after).amax() < 1e-14,
                "H v⁺ = u⁺ to rounding: {after} and {}",
                impact.after
            );
            stick.flights.push(Flight { start: time, q, v, impact: Some(impact) });
        }
        stick
    }

    /// (q, v) at time t; at an impact, v is the velocity before it.
    pub(crate) fn at(&self, time: f64) -> (Vector3<f64>, Vector3<f64>) {
        let flight = self.flights.iter().rfind(|f| f.start < time).unwrap_or(&self.flights[0]);
        self.along(flight, time)
    }

    fn along(&self, flight: &Flight, time: f64) -> (Vector3<f64>, Vector3<f64>) {
        let tau = time - flight.start;
        (flight.q + flight.v * tau + self.gravity * (0.5 * tau * tau), flight.v + self.gravity * tau)
    }

    /// The rows of H: C = G + l (sin γ, −cos γ), u_N = ẏ + l sin γ γ̇, u_T = ẋ + l cos γ γ̇.
    fn frame(&self, q: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let (sin, cos) = q[2].sin_cos();
        (Vector3::new(0.0, 1.0, self.lever * sin), Vector3::new(1.0, 0.0, self.lever * cos))
    }

    /// The time at which the gap of the last flight next becomes negative, to the last digit.
    fn next_impact(&self, end: f64) -> Option<f64> {
        let flight = &self.flights[self.flights.len() - 1];
        let gap = |time: f64| {
            let (q, _) = self.along(flight, time);
            q[1] - self.lever * q[2].cos()
        };
        let mut open = flight.start + SEARCH_STEP;
        assert!(gap(open) > 0.0, "the tip leaves the floor after the impact at {}", flight.start);
        while gap(open + SEARCH_STEP) > 0.0 {
            open += SEARCH_STEP;
            if open > end {
                return None;
            }
        }
        let mut closed = open + SEARCH_STEP;
        for _ in 0..60 {
            let middle = 0.5 * (open + closed);
            if gap(middle) > 0.0 { open = middle } else { closed = middle }
        }
        (closed <= end).then_some(closed)
    }
}
