//! A mass on a spring and a damper under c + F sin(Ωt + φ) against the wall x ≥ 0: exact between impacts.

use std::f64::consts::TAU;

use nonsmooth::scene::Scene;

use super::Motion;

/// ẍ + 2βẋ + ω²x = c + F sin(Ωt + φ), one free motion after each impact.
struct Oscillator {
    decay: f64,
    frequency: f64,
    constant: f64,
    /// Particular motion s sin Ωt + k cos Ωt.
    drive: f64,
    sine: f64,
    cosine: f64,
    /// Start, and coefficients of e^(−βτ) cos and e^(−βτ) sin.
    flights: Vec<(f64, f64, f64)>,
}

/// Steps of the search for the next impact (s); the periods are seconds.
const SEARCH: f64 = 1e-3;

/// A speed below which a contact grazes: the steady motion goes on.
const GRAZES: f64 = 1e-6;

impl Oscillator {
    fn particular(&self, time: f64) -> (f64, f64) {
        let (sin, cos) = (self.drive * time).sin_cos();
        let position = self.constant + self.sine * sin + self.cosine * cos;
        (position, self.drive * (self.sine * cos - self.cosine * sin))
    }

    fn along(&self, flight: (f64, f64, f64), time: f64) -> (f64, f64) {
        let (start, a, b) = flight;
        let tau = time - start;
        let (position, velocity) = self.particular(time);
        let fading = (-self.decay * tau).exp();
        let (sin, cos) = (self.frequency * tau).sin_cos();
        let free = fading * (a * cos + b * sin);
        let rate = fading * self.frequency * (b * cos - a * sin) - self.decay * free;
        (position + free, velocity + rate)
    }

    fn fly(&mut self, time: f64, position: f64, velocity: f64) {
        let (x, v) = self.particular(time);
        let a = position - x;
        let b = (velocity - v + self.decay * a) / self.frequency;
        self.flights.push((time, a, b));
    }
}

pub(super) fn motion(scene: &Scene) -> Motion {
    let body = &scene.bodies[0];
    let load = &body.loads[0];
    let nonsmooth::system::Signal::Sine { frequency, phase } = load.signal else {
        panic!("the load is a sine");
    };
    let (mass, stiffness, damping) = (body.mass, body.stiffness[0], body.damping[0]);
    let (decay, square) = (0.5 * damping / mass, stiffness / mass);
    let drive = TAU * frequency;
    let amplitude = load.force[0] / mass;
    // F sin(Ωt + φ) = S sin Ωt + C cos Ωt, and the response to each.
    let (force_sine, force_cosine) = (amplitude * (TAU * phase).cos(), amplitude * (TAU * phase).sin());
    let (stiff, lossy) = (square - drive * drive, 2.0 * decay * drive);
    let determinant = stiff * stiff + lossy * lossy;
    let mut oscillator = Oscillator {
        decay,
        frequency: (square - decay * decay).sqrt(),
        constant: (scene.gravity[0] + body.force[0] / mass) / square,
        drive,
        sine: (stiff * force_sine + lossy * force_cosine) / determinant,
        cosine: (stiff * force_cosine - lossy * force_sine) / determinant,
        flights: Vec::new(),
    };
    let restitution = scene.interfaces[0].parameters["restitution"];
    oscillator.fly(0.0, body.position[0], body.velocity[0]);
    let mut time = SEARCH;
    while time < scene.time.end {
        let flight = oscillator.flights[oscillator.flights.len() - 1];
        if oscillator.along(flight, time).0 >= 0.0 {
            time += SEARCH;
            continue;
        }
        let (mut open, mut closed) = (time - SEARCH, time);
        for _ in 0..60 {
            let middle = 0.5 * (open + closed);
            if oscillator.along(flight, middle).0 > 0.0 { open = middle } else { closed = middle }
        }
        let speed = oscillator.along(flight, closed).1;
        if speed < -GRAZES {
            oscillator.fly(closed, 0.0, -restitution * speed);
        }
        time = closed + SEARCH;
    }
    Box::new(move |time, q, v| {
        let flight = oscillator.flights.iter().rfind(|flight| flight.0 < time);
        let (x, rate) = oscillator.along(*flight.unwrap_or(&oscillator.flights[0]), time);
        q.fill(0.0);
        v.fill(0.0);
        (q[0], v[0]) = (x, rate);
    })
}
