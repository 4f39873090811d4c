//! Mechanisms drawn at random: they are computed, closed, and balanced.

use nonsmooth::adaptive::{Adaptive, AdaptiveError, AdaptiveSettings};
use nonsmooth::laws::{self, ContactLaw};
use nonsmooth::scheme::{Settings, SetupError, ThetaScheme};
use nonsmooth::solver::{self, ConeSolver, Stopping};
use nonsmooth::system::{Body, BodyId, Contacts, Joints, RigidBodies, RigidBodiesBuilder};

type Scheme = ThetaScheme<f64, 2>;

const LENGTH: f64 = 0.3;

/// Numbers in [0, 1) from a seed (SplitMix64).
struct Draw(u64);

impl Draw {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * (((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64)
    }

    fn chance(&mut self, p: f64) -> bool {
        self.within(0.0, 1.0) < p
    }
}

/// Rods being put together, and their state.
struct Rods {
    builder: RigidBodiesBuilder<f64>,
    group: nonsmooth::system::GroupId,
    bodies: Vec<BodyId>,
    q: Vec<f64>,
    v: Vec<f64>,
    lowest: f64,
}

impl Rods {
    fn new() -> Self {
        let mut builder = RigidBodies::builder();
        let group = builder.group();
        Self { builder, group, bodies: Vec::new(), q: Vec::new(), v: Vec::new(), lowest: f64::INFINITY }
    }

    /// A rod from a point that moves, at an angle and a rate; its end and the velocity of that.
    fn rod(&mut self, start: [f64; 2], moves: [f64; 2], angle: f64, rate: f64) -> ([f64; 2], [f64; 2]) {
        let body = Body { mass: 1.0, inertia: LENGTH * LENGTH / 12.0 };
        let id = self.builder.body(&format!("rod {}", self.bodies.len()), body).expect("positive");
        for (name, x) in [("s", -0.5 * LENGTH), ("e", 0.5 * LENGTH)] {
            self.builder.disc(name, id, [x, 0.0], 0.02, self.group).expect("a disc");
        }
        self.bodies.push(id);
        let (sin, cos) = angle.sin_cos();
        let at = |x: f64| {
            ([start[0] + x * cos, start[1] + x * sin], [moves[0] - rate * x * sin, moves[1] + rate * x * cos])
        };
        let ((centre, velocity), end) = (at(0.5 * LENGTH), at(LENGTH));
        self.q.extend([centre[0], centre[1], angle]);
        self.v.extend([velocity[0], velocity[1], rate]);
        self.lowest = self.lowest.min(start[1]).min(end.0[1]);
        end
    }

    fn pin(&mut self, body: usize, to: usize) {
        let (a, b, half) = (self.bodies[body], self.bodies[to], 0.5 * LENGTH);
        self.builder.pin(&format!("pin {body}"), a, [-half, 0.0], Some(b), [half, 0.0]).expect("finite");
    }

    fn scheme(
        mut self,
        law: (&str, f64, f64),
        floor: Option<f64>,
        (theta, h): (f64, f64),
    ) -> Result<Scheme, SetupError> {
        self.builder.gravity([0.0, -9.81]).expect("finite");
        if let Some(below) = floor {
            let group = self.builder.group();
            let point = [0.0, self.lowest - 0.03 - below];
            self.builder.half_plane("floor", point, [0.0, 1.0], group).expect("a plane");
            self.builder.interface(self.group, group).expect("two groups");
        }
        let system = self.builder.build().expect("bodies");
        let interfaces = Contacts::<f64, 2>::interfaces(&system);
        let laws =
            (0..interfaces).map(|_| laws::build(law.0, &[law.1, law.2]).expect("registered")).collect();
        let solver = solver::build("hybrid", Stopping::default()).expect("registered");
        ThetaScheme::new(Box::new(system), laws, solver, Settings::new(theta, h), 0.0, self.q, self.v)
    }
}

fn opening(scheme: &Scheme) -> f64 {
    let mut open = vec![0.0; scheme.system().joints().map_or(0, Joints::rows)];
    scheme.system().joints().expect("joints").residual(&scheme.state().q, &mut open);
    open.iter().fold(0.0, |most, x| f64::max(most, x.abs()))
}

/// Steps, each balanced to 1e-9 of the energies at hand: what the cone solver leaves (1e-10 of the velocities) acts through
/// joints whose multipliers are far larger than the percussions.
fn run(scheme: &mut Scheme, steps: usize, name: &str) {
    let extent = scheme.state().q.iter().fold(1.0, |most, x| f64::max(most, x.abs()));
    for _ in 0..steps {
        let step = scheme.step().unwrap_or_else(|error| panic!("{name}: {error}"));
        let scale = 1.0 + step.energies.kinetic.abs() + step.energies.potential.abs();
        assert!(step.balance.imbalance.abs() <= 1e-9 * scale, "{name}: {:?}", step.balance);
    }
    let extent = scheme.state().q.iter().fold(extent, |most, x| f64::max(most, x.abs()));
    // The tolerance, and what its closure at the start left: it does not add up.
    let bound = 4.0 * 64.0 * f64::EPSILON * (1.0 + extent);
    assert!(opening(scheme) <= bound, "{name}: open by {:e}, allowed {bound:e}", opening(scheme));
}

#[test]
fn random_chains_trees_and_rings_over_a_floor_are_computed() {
    for seed in 0..24 {
        let mut draw = Draw(seed);
        let mut rods = Rods::new();
        let h = 10.0_f64.powf(draw.within(-4.0, -2.4));
        let fastest = f64::min(10.0_f64.powf(draw.within(0.0, 1.7)), 0.2 / h);
        let count = 2 + draw.within(0.0, 9.0) as usize;
        let kind = seed % 3;
        if kind == 2 {
            let (count, rate) = (count.max(4), draw.within(-fastest, fastest));
            let radius = 0.5 * LENGTH / (std::f64::consts::PI / count as f64).sin();
            for i in 0..count {
                let turn = std::f64::consts::TAU * i as f64 / count as f64;
                let start = [radius * turn.cos(), radius * turn.sin()];
                let angle = turn + std::f64::consts::PI * (0.5 + 1.0 / count as f64);
                rods.rod(start, [-rate * start[1], rate * start[0]], angle, rate);
            }
            (0..count).for_each(|i| rods.pin((i + 1) % count, i));
        } else {
            let mut ends = vec![([0.0, 1.0], [draw.within(-2.0, 2.0), 0.0])];
            let mut angle = draw.within(-3.0, 3.0);
            for i in 0..count {
                // A tree goes on from any rod before, a chain from the last.
                let from = if kind == 1 && i > 0 { 1 + draw.within(0.0, i as f64) as usize } else { i };
                let (start, moves) = ends[from];
                angle += draw.within(-1.0, 1.0);
                ends.push(rods.rod(start, moves, angle, draw.within(-fastest, fastest)));
                if i > 0 {
                    rods.pin(i, from - 1);
                }
            }
        }
        let floor = draw.chance(0.7).then(|| draw.within(0.0, 0.3));
        let e = [0.0, 0.3, 0.5, 0.9][draw.within(0.0, 4.0) as usize];
        let (law, theta) = if draw.chance(0.5) { ("fremond", 0.5) } else { ("newton", 1.0 / (1.0 + e)) };
        let name = format!("seed {seed}: {count} rods, h = {h:e}, rates to {fastest}, {law}, e = {e}");
        let mut scheme =
            rods.scheme((law, e, 0.3), floor, (theta, h)).unwrap_or_else(|e| panic!("{name}: {e}"));
        run(&mut scheme, 200, &name);
    }
}

#[test]
fn a_chain_of_forty_links_swings_from_a_pin() {
    let mut rods = Rods::new();
    let mut end = ([0.0; 2], [0.0; 2]);
    for i in 0..40 {
        end = rods.rod(end.0, end.1, 0.0, 0.0);
        if i > 0 {
            rods.pin(i, i - 1);
        }
    }
    let first = rods.bodies[0];
    rods.builder.pin("hinge", first, [-0.5 * LENGTH, 0.0], None, [0.0; 2]).expect("finite");
    let mut scheme = rods.scheme(("newton", 0.0, 0.0), None, (0.5, 1e-3)).expect("closed");
    let before = scheme.last_step().energies.total();
    run(&mut scheme, 3000, "forty links");
    let drift = (scheme.last_step().energies.total() - before).abs();
    // Gravity is linear and θ is ½: energy is kept but for rounding, of some 12 m of links that fall by as much: ~ 700 J.
    assert!(drift <= 1e-9 * 700.0, "the energy drifts by {drift:e}");
}

#[test]
fn a_joint_does_not_drift_in_a_hundred_thousand_steps() {
    let mut rods = Rods::new();
    let (end, moves) = rods.rod([0.0; 2], [0.0; 2], 0.0, 20.0);
    rods.rod(end, moves, 1.0, -30.0);
    rods.pin(1, 0);
    let first = rods.bodies[0];
    rods.builder.pin("hinge", first, [-0.5 * LENGTH, 0.0], None, [0.0; 2]).expect("finite");
    let mut scheme = rods.scheme(("newton", 0.0, 0.0), None, (0.5, 1e-3)).expect("closed");
    run(&mut scheme, 100_000, "double pendulum");
}

#[test]
fn a_tolerance_of_joints_below_rounding_is_refused_by_name() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-18] {
        let mut rods = Rods::new();
        rods.rod([0.0; 2], [0.0; 2], 0.0, 1.0);
        let first = rods.bodies[0];
        rods.builder.pin("hinge", first, [-0.5 * LENGTH, 0.0], None, [0.0; 2]).expect("finite");
        let system = rods.builder.build().expect("a rod");
        let settings = Settings { joint_tolerance: Some(bad), ..Settings::new(0.5, 1e-3) };
        let solver: Box<dyn ConeSolver<f64, 2>> =
            solver::build("nsgs", Stopping::default()).expect("registered");
        let laws: Vec<Box<dyn ContactLaw<f64, 2>>> = Vec::new();
        let error = ThetaScheme::new(Box::new(system), laws, solver, settings, 0.0, rods.q, rods.v)
            .expect_err("refused");
        assert!(matches!(error, SetupError::JointTolerance { .. }), "{error}");
        assert!(error.to_string().contains("rounding"), "{error}");
    }
}

#[test]
fn error_control_over_joints_is_refused_by_name() {
    let mut rods = Rods::new();
    rods.rod([0.0; 2], [0.0; 2], 0.0, 1.0);
    let first = rods.bodies[0];
    rods.builder.pin("hinge", first, [-0.5 * LENGTH, 0.0], None, [0.0; 2]).expect("finite");
    let scheme = rods.scheme(("newton", 0.0, 0.0), None, (0.5, 1e-3)).expect("closed");
    let error = Adaptive::new(scheme, AdaptiveSettings::new(1e-4, 1.0)).expect_err("refused");
    assert!(matches!(error, AdaptiveError::Setup(SetupError::JointsAdaptive)), "{error}");
}
