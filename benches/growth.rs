//! How a step of bodies in space grows with their number: seconds of detection, assembly and solve, and memory.
//!
//! ```text
//! cargo bench --bench growth            # 10², 10³, 10⁴ bodies
//! cargo bench --bench growth -- 100 400 # other numbers
//! ```
//!
//! Balls, or cubes that are yawed, fall a little onto each other and a floor within walls, from a grid with seeded jitter.

use std::path::Path;
use std::time::Instant;

use nonsmooth::scene::{Scene, build};
use nonsmooth::scheme::Part;

/// Steps that are made before those that are measured, and these.
const BEFORE: usize = 40;
const STEPS: usize = 10;

/// About `n` bodies of this shape, ten layers at least a tenth as wide as the grid.
fn scene(n: usize, shape: &str, turn: f64) -> Scene {
    let layers = ((n as f64).cbrt().round() as usize).max(1);
    let side = ((n as f64 / layers as f64).sqrt().round() as usize).max(1);
    let wall = 0.11 * side as f64;
    let mut text = format!(
        "title = \"growth\"\nlaws = [\"moreau\"]\nsolvers = [\"nsgs\"]\ngravity = [0.0, 0.0, -9.81]\n\
         [time]\nstep = 2e-3\nend = 1.0\ntheta = 1.0\n[solver]\ntolerance = 1e-3\n\
         [[bodies]]\nname = \"body\"\ndensity = 1000.0\nposition = [0.055, 0.055, 0.06]\nshapes = [{shape}]\n\
         repeat = {{ count = [{side}, {side}, {layers}], spacing = [0.11, 0.11, 0.11], jitter = 1e-3, turn = {turn}, seed = 1 }}\n\
         [[interfaces]]\nbetween = [\"body\", \"body\"]\nparameters = {{ restitution = 0.0, friction = 0.3 }}\n"
    );
    for (name, point, normal) in [
        ("floor", [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        ("left", [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ("right", [wall, 0.0, 0.0], [-1.0, 0.0, 0.0]),
        ("front", [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        ("back", [0.0, wall, 0.0], [0.0, -1.0, 0.0]),
    ] {
        text += &format!(
            "[[half_spaces]]\nname = \"{name}\"\npoint = {point:?}\nnormal = {normal:?}\n\
             [[interfaces]]\nbetween = [\"body\", \"{name}\"]\nparameters = {{ restitution = 0.0, friction = 0.3 }}\n"
        );
    }
    Scene::parse(&text, Path::new("growth.toml")).unwrap_or_else(|error| panic!("{error}"))
}

/// Memory of the program (bytes), where the system tells.
fn resident() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS"))?;
    Some(1024.0 * line.split_whitespace().nth(1)?.parse::<f64>().ok()?)
}

/// Seconds of one step by part (detection, free velocity, assembly, solve, next state), bodies, contacts, bytes.
fn measure(scene: &Scene) -> ([f64; 5], usize, f64, f64) {
    let registry = nonsmooth::registry();
    let before = resident();
    let run = &scene.runs(&registry).unwrap_or_else(|error| panic!("{error}"))[0];
    let built = build::<f64, 3>(scene, run, &registry);
    let mut scheme = built.unwrap_or_else(|error| panic!("{error}"));
    let bodies = scheme.state().v.len() / 6;
    let (mut parts, mut contacts) = ([0.0; 5], 0);
    for step in 0..BEFORE + STEPS {
        let mut clock = Instant::now();
        let mut spent = [0.0; 5];
        let made = scheme.step_with(|part| {
            let place = match part {
                Part::ActiveSet => 0,
                Part::FreeVelocity => 1,
                Part::ConeProblem => 2,
                Part::ConeSolution => 3,
                _ => 4,
            };
            spent[place] += clock.elapsed().as_secs_f64();
            clock = Instant::now();
        });
        let made = made.unwrap_or_else(|error| panic!("{error}"));
        if step >= BEFORE {
            contacts += made.contacts.len();
            parts.iter_mut().zip(spent).for_each(|(sum, x)| *sum += x / STEPS as f64);
        }
    }
    let memory = resident().zip(before).map_or(f64::NAN, |(after, before)| after - before);
    (parts, bodies, contacts as f64 / STEPS as f64, memory)
}

fn main() {
    let asked: Vec<usize> = std::env::args().filter_map(|word| word.parse().ok()).collect();
    let numbers = if asked.is_empty() { vec![100, 1_000, 10_000] } else { asked };
    for (name, shape, turn) in
        [("balls", "{ ball = 0.05 }", 0.0), ("cubes", "{ box = [0.1, 0.1, 0.1] }", 0.05)]
    {
        println!("{name}: ms per step");
        println!("bodies  contacts  detection  free vel.  assembly     solve  next state  kB per body");
        let mut last = None::<([f64; 5], f64)>;
        for &n in &numbers {
            let (parts, bodies, contacts, memory) = measure(&scene(n, shape, turn));
            let [detection, free, assembly, solve, next] = parts.map(|seconds| 1e3 * seconds);
            println!(
                "{bodies:>6}  {contacts:>8.0}  {detection:>9.3}  {free:>9.3}  {assembly:>8.3}  {solve:>8.3}  {next:>10.3}  {:>11.1}",
                memory / bodies as f64 / 1e3
            );
            if let Some((before, fewer)) = last {
                let by = |k: usize| (parts[k] / before[k]).ln() / (bodies as f64 / fewer).ln();
                println!(
                    "  exponent        {:>9.2}  {:>9.2}  {:>8.2}  {:>8.2}  {:>10.2}",
                    by(0),
                    by(1),
                    by(2),
                    by(3),
                    by(4)
                );
            }
            last = Some((parts, bodies as f64));
        }
    }
}
