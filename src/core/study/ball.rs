//! The closed form of a body that bounces on a half-plane.

use super::ReferenceError;
use super::reference::{Reference, visit_between};
use crate::laws::{Approach, ContactLaw};
use crate::registry::Registry;
use crate::scene::{PlannedRun, Scene, build};
use crate::scheme::ThetaScheme;

/// A frictionless disc thrown on a half-plane: parabolas, impacts u⁺ = −e u⁻, and rest from the accumulation point on,
/// t₁ + (2 w/G) e/(1−e) with the speed w of the first impact at t₁ and the acceleration G towards the plane.
#[derive(Debug)]
pub(super) struct Ball {
    mass: f64,
    inertia: f64,
    position: [f64; 2],
    velocity: [f64; 2],
    angle: f64,
    spin: f64,
    acceleration: [f64; 2],
    spin_rate: f64,
    normal: [f64; 2],
    /// Initial gap and its rate.
    gap: [f64; 2],
    /// G.
    pull: f64,
    /// Times of the impacts, and the sum of their percussions up to and with each.
    times: Vec<f64>,
    sums: Vec<f64>,
    /// Speed after each impact.
    speeds: Vec<f64>,
    /// When the impacts have come to an end.
    rest: f64,
}

/// Impacts listed: with e = 1 there is no end to them.
const MOST_IMPACTS: usize = 1_000_000;

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

impl Ball {
    /// The motion of a scene; an error says what the scene would have to be.
    pub(super) fn new(scene: &Scene, run: &PlannedRun, registry: &Registry) -> Result<Self, ReferenceError> {
        let ([body], [plane], [_]) = (&scene.bodies[..], &scene.half_planes[..], &scene.interfaces[..])
        else {
            return Err("one body, one half-plane and one interface".into());
        };
        if !(scene.obstacles.is_empty() && scene.springs.is_empty()) {
            return Err("no obstacle and no spring".into());
        }
        let disc = match &body.discs[..] {
            [disc] if body.polygons.is_empty() && scene.joints.is_empty() && scene.solid.is_none() => disc,
            _ => return Err("a body with one disc, and no joint".into()),
        };
        if disc.centre != [0.0, 0.0] {
            return Err(format!("the disc centred in the body, not at {:?}", disc.centre).into());
        }
        let scheme: ThetaScheme<f64, 1> = build(scene, run, registry)?;
        let e = restitution(&*scheme.laws()[0])?;

        let length = plane.normal[0].hypot(plane.normal[1]);
        let normal = plane.normal.map(|x| x / length);
        let offset = [body.position[0] - plane.point[0], body.position[1] - plane.point[1]];
        let gap = [dot(normal, offset) - disc.radius, dot(normal, body.velocity)];
        let acceleration = [0, 1].map(|i| scene.gravity[i] + body.force[i] / body.mass);
        let pull = -dot(normal, acceleration);
        let touching = gap[0] >= 0.0 && pull > 0.0;
        if !touching {
            return Err(format!(
                "a gap ≥ 0 at the start and a pull towards the plane > 0, not {} and {pull}",
                gap[0]
            )
            .into());
        }
        let mut ball = Self {
            mass: body.mass,
            inertia: body.inertia,
            position: body.position,
            velocity: body.velocity,
            angle: body.angle,
            spin: body.spin,
            acceleration,
            spin_rate: body.torque / body.inertia,
            normal,
            gap,
            pull,
            times: Vec::new(),
            sums: Vec::new(),
            speeds: Vec::new(),
            rest: f64::INFINITY,
        };
        ball.bounce(e, scene.time.end);
        Ok(ball)
    }

    fn bounce(&mut self, e: f64, end: f64) {
        let impact = self.gap[1].hypot((2.0 * self.pull * self.gap[0]).sqrt());
        let first = (self.gap[1] + impact) / self.pull;
        if e < 1.0 {
            self.rest = first + 2.0 * impact / self.pull * e / (1.0 - e);
        }
        let (mut time, mut before, mut sum) = (first, impact, 0.0);
        // Beyond the end by a flight, so that a last step that reaches over it is known, too.
        while time <= 1.5 * end && self.times.len() < MOST_IMPACTS {
            sum += self.mass * (1.0 + e) * before;
            self.times.push(time);
            self.sums.push(sum);
            before *= e;
            self.speeds.push(before);
            let flight = 2.0 * before / self.pull;
            // The rest of the flights is shorter than the time is known.
            if flight <= f64::EPSILON * time {
                return;
            }
            time += flight;
        }
        if time > 1.5 * end {
            self.rest = self.rest.max(time);
        }
    }

    /// Gap, its rate, and the percussions so far.
    fn normal_motion(&self, time: f64) -> [f64; 3] {
        let flight = |gap: f64, rate: f64, tau: f64| {
            [gap + rate * tau - 0.5 * self.pull * tau * tau, rate - self.pull * tau]
        };
        let impacts = self.times.partition_point(|&impact| impact < time);
        if impacts == 0 {
            let [gap, rate] = flight(self.gap[0], self.gap[1], time);
            return [gap, rate, 0.0];
        }
        let sum = self.sums[impacts - 1];
        if time >= self.rest {
            return [0.0, 0.0, sum + self.mass * self.pull * (time - self.rest)];
        }
        let [gap, rate] = flight(0.0, self.speeds[impacts - 1], time - self.times[impacts - 1]);
        [gap, rate, sum]
    }
}

/// e of a law with u⁺ = −e u⁻ in frictionless impacts; it must not depend on the speed.
fn restitution(law: &dyn ContactLaw<f64, 1>) -> Result<f64, ReferenceError> {
    let of = |speed: f64| {
        let before = nalgebra::SVector::from([-speed]);
        -law.respond(&Approach::impact(before, 0.5)).b_shift(&before)[0] / speed
    };
    let e = of(1.0);
    let constant = (of(1e-3) - e).abs() <= 1e-12 && (0.0..=1.0).contains(&e);
    if constant { Ok(e) } else { Err("a restitution in [0, 1] that does not depend on the speed".into()) }
}

impl Reference for Ball {
    fn at(&self, time: f64, q: &mut [f64], v: &mut [f64]) {
        let [gap, rate, _] = self.normal_motion(time);
        let free = [
            self.gap[0] + self.gap[1] * time - 0.5 * self.pull * time * time,
            self.gap[1] - self.pull * time,
        ];
        for i in 0..2 {
            let flight = self.velocity[i] * time + 0.5 * self.acceleration[i] * time * time;
            q[i] = self.position[i] + flight + self.normal[i] * (gap - free[0]);
            v[i] = self.velocity[i] + self.acceleration[i] * time + self.normal[i] * (rate - free[1]);
        }
        q[2] = self.angle + self.spin * time + 0.5 * self.spin_rate * time * time;
        v[2] = self.spin + self.spin_rate * time;
    }

    fn jumps(&self, from: f64, to: f64, visit: &mut dyn FnMut(f64)) {
        visit_between(&self.times, |&time| time, (from, to), visit);
    }

    fn percussion(&self, time: f64) -> f64 {
        self.normal_motion(time)[2]
    }

    fn energy(&self, time: f64) -> f64 {
        let (mut q, mut v) = ([0.0; 3], [0.0; 3]);
        self.at(time, &mut q, &mut v);
        let kinetic = 0.5 * self.mass * (v[0] * v[0] + v[1] * v[1]) + 0.5 * self.inertia * v[2] * v[2];
        let work = self.mass * dot(self.acceleration, [q[0], q[1]]) + self.inertia * self.spin_rate * q[2];
        kinetic - work
    }
}
