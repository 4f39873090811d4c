//! No scene file, however damaged, makes the program panic: it is refused by name, runs, or stops with an error.

use std::ops::ControlFlow;
use std::path::Path;

use nonsmooth::adaptive::{Adaptive, AdaptiveSettings};
use nonsmooth::event_driven::Settings;
use nonsmooth::scalar::{Scalar, lit};
use nonsmooth::scene::{PlannedRun, ScalarName, Scene, build, contact_dimension, event_driven};
use proptest::prelude::*;

/// Every shape, densities, masses and inertias, turns, copies, half-spaces, hulls, height fields, joints, springs, motions.
const ALL_IN_SPACE: &str = "\
title = \"all\"
laws = [\"newton\"]
gravity = [0.0, 0.0, -9.81]
[time]
step = 1e-3
end = 0.1
[[bodies]]
name = \"box\"
density = 1000.0
position = [0.0, 0.0, 0.21]
orientation = [1.0, 0.1, 0.0, 0.0]
spin = [1.0, 2.0, 3.0]
shapes = [{ box = [0.4, 0.3, 0.2] }, { ball = 0.05, position = [0.1, 0.0, 0.1] }]
[[bodies]]
name = \"stone\"
mass = 2.0
position = [0.0, 0.6, 0.21]
velocity = [0.0, 0.0, -1.0]
[[bodies.shapes]]
hull = [[0.1, 0.0, 0.0], [-0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, -0.1, 0.0], [0.0, 0.0, 0.1], [0.0, 0.0, -0.1]]
orientation = [0.5, 0.5, 0.5, 0.5]
[[bodies]]
name = \"top\"
mass = 0.5
inertia = [0.01, 0.01, 0.015]
position = [0.5, 0.0, 0.11]
torque = [0.0, 0.1, 0.0]
fixed_torque = [0.1, 0.0, 0.0]
loads = [{ force = [1.0, 0.0, 0.0], signal = { sine = { frequency = 3.0 } } }]
shapes = [{ capsule = [0.1, 0.3] }]
[[bodies]]
name = \"copy\"
density = 500.0
position = [-0.8, -0.4, 0.1]
shapes = [{ cylinder = [0.1, 0.2] }, { cone = [0.1, 0.2], position = [0.0, 0.0, 0.15] }]
repeat = { count = [2, 1, 2], spacing = [0.3, 0.3, 0.4], jitter = 0.01, turn = 0.1, seed = 7 }
[[half_spaces]]
name = \"floor\"
point = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
[[obstacles]]
name = \"ground\"
position = [-1.0, -1.0, 0.0]
orientation = [1.0, 0.0, 0.0, 0.0]
shapes = [{ heights = { rows = [[0.0, 0.1, 0.0], [0.1, 0.0, 0.1], [0.0, 0.1, 0.0]], cell = [1.0, 1.0], origin = [0.0, 0.0] } }]
[[obstacles]]
name = \"paddle\"
position = [0.5, 0.9, 0.3]
motion_axis = [0.0, 0.0, 1.0]
motion = [{ angle = 0.5, signal = { sine = { frequency = 2.0 } } }, { displacement = [0.1, 0.0, 0.0], signal = { linear = { rate = 1.0 } } }]
shapes = [{ box = [0.2, 0.1, 0.3] }]
[[joints]]
name = \"arm\"
kind = \"hinge\"
body = \"stone\"
to = \"top\"
point = [0.2, 0.3, 0.2]
axis = [0.0, 0.0, 1.0]
limits = [-0.5, 0.5]
parameters = { restitution = 0.5 }
friction = 0.1
motor = { speed = 1.0, most = 2.0, signal = { sine = { frequency = 5.0 } } }
[[joints]]
name = \"rope\"
kind = \"rod\"
body = \"stone\"
point = [0.0, 0.6, 0.3]
on = [0.0, 0.6, 1.0]
[[springs]]
name = \"spring\"
body = \"top\"
point = [0.5, 0.0, 0.2]
on = [0.5, 0.0, 1.0]
stiffness = 10.0
damping = 1.0
[[interfaces]]
between = [\"box\", \"floor\"]
parameters = { restitution = 0.5, friction = 0.4 }
[[interfaces]]
between = [\"top\", \"ground\"]
parameters = { restitution = 0.0, friction = 0.4 }
[[interfaces]]
between = [\"stone\", \"ground\"]
parameters = { restitution = 0.0, friction = 0.4 }
[[interfaces]]
between = [\"copy\", \"ground\"]
parameters = { restitution = 0.0, friction = 0.4 }
[[interfaces]]
between = [\"copy\", \"copy\"]
parameters = { restitution = 0.0, friction = 0.4 }
";

const SPACE: [&str; 4] = [
    ALL_IN_SPACE,
    include_str!("../examples/tippe_top.toml"),
    include_str!("../examples/cube_stack.toml"),
    include_str!("../examples/dominoes.toml"),
];

/// Discs and polygons, loads, joints, elastic bodies, error control.
const SCENES: [&str; 7] = [
    include_str!("../examples/impacting_stick.toml"),
    include_str!("../examples/bouncing_ball.toml"),
    include_str!("../examples/stick_slip.toml"),
    include_str!("../examples/rocking_block.toml"),
    include_str!("../examples/double_pendulum.toml"),
    include_str!("../examples/impacting_bar.toml"),
    include_str!("../examples/sliding_block.toml"),
];

/// Meshes with fewer elements, so that many damages are tried.
const COARSER: [(&str, &str); 2] = [("elements = 200", "elements = 12"), ("size = 1.0", "size = 8.0")];

fn scene(which: usize) -> String {
    COARSER.iter().fold(SCENES[which].into(), |text: String, (fine, coarse)| text.replace(fine, coarse))
}

/// What numbers become.
const NUMBERS: [&str; 12] =
    ["nan", "inf", "-inf", "-1", "0", "1", "1e308", "-1e308", "1e-308", "1e40", "0.5", "\"text\""];

/// Steps made of a scene that is accepted.
const STEPS: usize = 5;

/// What a solve in space may take (s); sound ones of these scenes take a thousandth.
const SECONDS: f64 = 0.1;

/// Most unknowns of a scene that is stepped: damage may make a mesh that is fine and large.
const MOST_UNKNOWNS: usize = 1_000;

#[derive(Debug, Clone)]
enum Damage {
    Delete(usize),
    Duplicate(usize),
    Swap(usize, usize),
    Number(usize, usize),
    Truncate(usize),
    Letter(usize, char),
}

/// Where the numbers of a text are.
fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let (mut found, mut start) = (Vec::new(), None);
    let mut previous = ' ';
    for (i, c) in text.char_indices() {
        let inside = c.is_ascii_digit() || c == '.' || (c == 'e' || c == '-') && start.is_some();
        match (start, inside) {
            (None, true) if !previous.is_alphanumeric() => start = Some(i),
            (Some(from), false) => {
                found.push(from..i);
                start = None;
            }
            _ => {}
        }
        previous = c;
    }
    found
}

fn damage(text: &str, damage: &Damage) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let join = |lines: Vec<&str>| lines.join("\n") + "\n";
    if lines.is_empty() {
        return text.into();
    }
    match *damage {
        Damage::Delete(i) => {
            let mut lines = lines;
            lines.remove(i % lines.len());
            join(lines)
        }
        Damage::Duplicate(i) => {
            let mut lines = lines;
            let i = i % lines.len();
            lines.insert(i, lines[i]);
            join(lines)
        }
        Damage::Swap(i, j) => {
            let mut lines = lines;
            let n = lines.len();
            lines.swap(i % n, j % n);
            join(lines)
        }
        Damage::Number(i, j) => {
            let numbers = numbers(text);
            let Some(range) = numbers.get(i % numbers.len().max(1)) else { return text.into() };
            let mut text = text.to_string();
            text.replace_range(range.clone(), NUMBERS[j % NUMBERS.len()]);
            text
        }
        Damage::Truncate(i) => text.chars().take(i % (text.chars().count() + 1)).collect(),
        Damage::Letter(i, c) => {
            let at = i % text.chars().count().max(1);
            text.chars().enumerate().map(|(k, old)| if k == at { c } else { old }).collect()
        }
    }
}

fn damages() -> impl Strategy<Value = Damage> {
    prop_oneof![
        2 => any::<usize>().prop_map(Damage::Delete),
        2 => any::<usize>().prop_map(Damage::Duplicate),
        1 => any::<(usize, usize)>().prop_map(|(i, j)| Damage::Swap(i, j)),
        8 => any::<(usize, usize)>().prop_map(|(i, j)| Damage::Number(i, j)),
        1 => any::<usize>().prop_map(Damage::Truncate),
        1 => (any::<usize>(), any::<char>()).prop_map(|(i, c)| Damage::Letter(i, c)),
    ]
}

/// Reads, builds and steps; the message of what went wrong, empty where nothing did.
fn attempt<T: Scalar, const D: usize>(scene: &Scene) -> String {
    let Ok(runs) = scene.runs(&nonsmooth::registry()) else {
        return scene.runs(&nonsmooth::registry()).expect_err("just seen").to_string();
    };
    for run in &runs {
        let mut scheme = match build::<T, D>(scene, run, &nonsmooth::registry()) {
            Ok(scheme) => scheme,
            Err(error) => return error.to_string(),
        };
        if scheme.state().q.len() > MOST_UNKNOWNS {
            return String::new();
        }
        for _ in 0..run.steps.min(STEPS) {
            let made = match scheme.step() {
                Ok(step) => step,
                Err(error) => return error.to_string(),
            };
            let energies = [made.energies.total(), made.balance.imbalance];
            assert!(
                nonsmooth::scalar::all_finite(&energies),
                "a step with energies {energies:?} was accepted"
            );
        }
        if let Err(error) = adapt::<T, D>(scene, run) {
            return error;
        }
    }
    String::new()
}

/// The beginning of the run under error control.
fn adapt<T: Scalar, const D: usize>(scene: &Scene, run: &PlannedRun) -> Result<(), String> {
    let scheme = build::<T, D>(scene, run, &nonsmooth::registry()).map_err(|error| error.to_string())?;
    let end = lit::<T>(scene.time.step * STEPS as f64);
    let Ok(mut driver) = Adaptive::new(scheme, AdaptiveSettings::new(lit(1e-2), end)) else { return Ok(()) };
    let mut steps = 0;
    let made = driver.advance_to(end, |_, _, step| {
        steps += 1;
        let energies = [step.energies.total(), step.balance.imbalance];
        assert!(nonsmooth::scalar::all_finite(&energies), "energies {energies:?} were accepted");
        if steps < 10 * STEPS { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    made.map(drop).map_err(|error| error.to_string())
}

/// The beginning of the event-driven motions.
fn follow(scene: &Scene, dimension: usize) {
    let mut scene = scene.clone();
    scene.time.end = scene.time.end.min(scene.time.step * STEPS as f64);
    let Ok(runs) = scene.runs(&nonsmooth::registry()) else { return };
    let settings = Settings { max_events: 200, max_steps: 200, ..Settings::default() };
    for run in &runs {
        let ended = match dimension {
            1 => event_driven::<1>(&scene, run, &nonsmooth::registry())
                .map(|motion| motion.integrate(&settings)),
            _ => event_driven::<2>(&scene, run, &nonsmooth::registry())
                .map(|motion| motion.integrate(&settings)),
        };
        if let Ok(Ok(motion)) = ended {
            let energy = motion.energy(motion.end()).total();
            assert!(energy.is_finite(), "a motion of energy {energy} was found");
        }
    }
}

fn read(text: &str) -> String {
    let mut scene = match Scene::parse(text, Path::new("scene.toml")) {
        Ok(scene) => scene,
        Err(error) => return error.to_string(),
    };
    let runs = match scene.runs(&nonsmooth::registry()) {
        Ok(runs) => runs,
        Err(error) => return error.to_string(),
    };
    let mut told = String::new();
    match contact_dimension(&scene, &runs, &nonsmooth::registry()) {
        Err(error) => return error.to_string(),
        Ok(dimension) => {
            follow(&scene, dimension);
            if dimension == 3 {
                // Heaps that damage wedges into each other are told to be unsolved, and not worked at.
                scene.solver.max_seconds = Some(SECONDS);
                told = attempt::<f64, 3>(&scene);
                return if told.is_empty() { attempt::<f32, 3>(&scene) } else { told };
            }
            for scalar in [ScalarName::F64, ScalarName::F32] {
                scene.scalar = scalar;
                told = match (scalar, dimension) {
                    (ScalarName::F64, 1) => attempt::<f64, 1>(&scene),
                    (ScalarName::F64, _) => attempt::<f64, 2>(&scene),
                    (ScalarName::F32, 1) => attempt::<f32, 1>(&scene),
                    (ScalarName::F32, _) => attempt::<f32, 2>(&scene),
                };
            }
        }
    }
    told
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn damaged_scenes_never_panic(
        which in 0..SCENES.len(),
        damages in proptest::collection::vec(damages(), 1..4),
    ) {
        let text = damages.iter().fold(scene(which), |text, d| damage(&text, d));
        read(&text);
    }

    #[test]
    fn damaged_scenes_in_space_never_panic(
        which in prop_oneof![3 => Just(0), 1 => 1..SPACE.len()],
        damages in proptest::collection::vec(damages(), 1..4),
    ) {
        let text = damages.iter().fold(SPACE[which].to_string(), |text, d| damage(&text, d));
        let begun = std::time::Instant::now();
        read(&text);
        // Built for tests, and beside others.
        prop_assert!(begun.elapsed().as_secs() < 60, "{:?}", begun.elapsed());
    }
}

#[test]
fn the_undamaged_scenes_run() {
    for (fine, _) in COARSER {
        assert!(SCENES.iter().any(|text| text.contains(fine)));
    }
    for which in 0..SCENES.len() {
        assert_eq!(read(&scene(which)), "");
    }
    for (which, text) in SPACE.iter().enumerate() {
        let told = read(text);
        assert!(told.is_empty() || told.contains("in space"), "{which}: {told}");
    }
}

#[test]
fn every_number_of_the_scene_is_found() {
    let text = "step = 1e-4 # h\nq = [-0.5, 0.1]\nf64 = 3\n";
    let found: Vec<&str> = numbers(text).into_iter().map(|range| &text[range]).collect();
    assert_eq!(found, ["1e-4", "0.5", "0.1", "3"]);
}
