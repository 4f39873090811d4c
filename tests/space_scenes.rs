//! Scenes in space as files: what they say, what they refuse, and that they run as they stand.
#![cfg(feature = "scene")]

use std::path::Path;

use nonsmooth::scene::{Overrides, Scene, SceneError, contact_dimension};

/// A box on a floor.
const BOX: &str = "\
title = \"box\"
laws = [\"newton\", \"fremond\"]
gravity = [0.0, 0.0, -9.81]
[time]
step = 1e-3
end = 0.2
[[bodies]]
name = \"box\"
density = 1000.0
position = [0.0, 0.0, 0.1]
shapes = [{ box = [0.4, 0.3, 0.2] }]
[[half_spaces]]
name = \"floor\"
normal = [0.0, 0.0, 1.0]
[[interfaces]]
between = [\"box\", \"floor\"]
parameters = { restitution = 0.0, friction = 0.4 }
";

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse(text, Path::new("scene.toml"))
}

/// Parses and builds every run, and makes `steps` steps of each: the configurations reached.
fn run(text: &str, steps: usize) -> Result<Vec<Vec<f64>>, SceneError> {
    let scene = parse(text)?;
    let registry = nonsmooth::registry();
    let runs = scene.runs(&registry)?;
    let dimension = contact_dimension(&scene, &runs, &registry)?;
    let mut reached = Vec::new();
    for run in &runs {
        let mut scheme = match dimension {
            1 => return frictionless(&scene, steps),
            _ => nonsmooth::scene::build::<f64, 3>(&scene, run, &registry)?,
        };
        for _ in 0..steps {
            scheme.step().unwrap_or_else(|error| panic!("{}: {error}", run.law));
        }
        reached.push(scheme.state().q.clone());
    }
    Ok(reached)
}

fn frictionless(scene: &Scene, steps: usize) -> Result<Vec<Vec<f64>>, SceneError> {
    let registry = nonsmooth::registry();
    let mut reached = Vec::new();
    for run in &scene.runs(&registry)? {
        let mut scheme = nonsmooth::scene::build::<f64, 1>(scene, run, &registry)?;
        for _ in 0..steps {
            scheme.step().unwrap_or_else(|error| panic!("{}: {error}", run.law));
        }
        reached.push(scheme.state().q.clone());
    }
    Ok(reached)
}

/// The text with one part of it replaced.
fn with(from: &str, to: &str) -> String {
    assert!(BOX.contains(from), "{from}");
    BOX.replace(from, to)
}

#[test]
fn a_box_of_a_density_stands_on_the_floor_under_every_law() {
    for q in run(BOX, 200).expect("a scene") {
        assert!((q[2] - 0.1).abs() <= 1e-12, "{q:?}");
        assert!(q[0].abs().max(q[1].abs()) <= 1e-12);
        assert_eq!(q.len(), 7);
    }
}

#[test]
fn frictionless_scenes_in_space_have_contacts_of_one_component() {
    let text = with("friction = 0.4", "friction = 0.0");
    let scene = parse(&text).expect("a scene");
    let registry = nonsmooth::registry();
    let runs = scene.runs(&registry).expect("runs");
    assert_eq!(contact_dimension(&scene, &runs, &registry).expect("laws"), 1);
    run(&text, 100).expect("stands");
}

#[test]
fn mass_alone_is_that_of_a_homogeneous_body_of_the_shapes() {
    let [dense, heavy] = ["density = 1000.0", "mass = 24.0"].map(|mass| {
        let scene = parse(&with("density = 1000.0", mass)).expect("a scene");
        let registry = nonsmooth::registry();
        let run = &scene.runs(&registry).expect("runs")[0];
        let scheme = nonsmooth::scene::build::<f64, 3>(&scene, run, &registry).expect("builds");
        scheme.system().mass().entries().map(|(_, _, m)| m).collect::<Vec<f64>>()
    });
    for (a, b) in dense.iter().zip(&heavy) {
        assert!((a - b).abs() <= 1e-14 * a.abs(), "{dense:?}, {heavy:?}");
    }
}

#[test]
fn the_position_is_that_of_the_frame_and_q_that_of_the_centre_of_mass() {
    // An L of two boxes, its frame at the corner: q starts at the common centre, in the principal axes.
    let shapes = "shapes = [{ name = \"foot\", box = [0.4, 0.2, 0.2], position = [0.2, 0.1, 0.1] }, \
                  { name = \"leg\", box = [0.2, 0.2, 0.4], position = [0.1, 0.1, 0.4] }]";
    let text =
        with("shapes = [{ box = [0.4, 0.3, 0.2] }]", shapes).replace("0.0, 0.0, 0.1]", "1.0, 2.0, 0.0]");
    for q in run(&text, 200).expect("a scene") {
        // Two equal masses at (0.2, 0.1, 0.1) and (0.1, 0.1, 0.4).
        for (q, centre) in q[..3].iter().zip([1.15, 2.1, 0.25]) {
            assert!((q - centre).abs() <= 1e-11, "{q} m, {centre} m");
        }
    }
}

#[test]
fn copies_stand_on_their_grid_and_answer_to_the_name_they_are_copies_of() {
    let repeat =
        "shapes = [{ box = [0.4, 0.3, 0.2] }]\nrepeat = { count = [2, 3, 2], spacing = [0.5, 0.4, 0.2] }";
    let text = with("shapes = [{ box = [0.4, 0.3, 0.2] }]", repeat)
        + "[[interfaces]]\nbetween = [\"box\", \"box\"]\nparameters = { restitution = 0.0, friction = 0.4 }\n";
    for q in run(&text, 100).expect("a scene") {
        assert_eq!(q.len(), 7 * 12);
        let last = &q[7 * 11..];
        for (q, place) in last.iter().zip([0.5, 0.8, 0.3]) {
            assert!((q - place).abs() <= 1e-11, "{last:?}");
        }
    }
    // The same seed gives the same places, another one others.
    let places = |seed: &str| {
        let jitter = format!(
            "repeat = {{ count = [2, 1, 1], spacing = [0.5, 0.0, 0.0], jitter = 0.01, seed = {seed} }}"
        );
        let text =
            with("shapes = [{ box = [0.4, 0.3, 0.2] }]", &format!("shapes = [{{ ball = 0.1 }}]\n{jitter}"));
        run(&text, 0).expect("a scene")
    };
    assert_eq!(places("1"), places("1"));
    assert_ne!(places("1"), places("2"));
}

#[test]
fn what_is_wrong_in_a_scene_in_space_is_said_by_name() {
    let shape = "shapes = [{ box = [0.4, 0.3, 0.2] }]";
    let cases = [
        ("density = 1000.0", "", "density, or a mass"),
        ("density = 1000.0", "density = 1.0\nmass = 2.0", "density, or a mass"),
        ("density = 1000.0", "density = -1.0", "density is -1e0"),
        ("density = 1000.0", "mass = 1.0\ninertia = [1.0, 1.0, 3.0]", "box"),
        (shape, "shapes = [{ ball = 0.0 }]", "radius of a ball"),
        (shape, "shapes = [{ ball = 1.0, box = [1.0, 1.0, 1.0] }]", "ball, box"),
        (shape, "shapes = [{ }]", "no geometry"),
        (shape, "shapes = [{ ball = 1.0, scale = 2.0 }]", "a scale"),
        (shape, "shapes = [{ file = \"absent.stl\" }]", "absent.stl"),
        (shape, "shapes = [{ hull = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] }]", "box.1"),
        (
            shape,
            "shapes = [{ ball = 0.1 }]\nrepeat = { count = [0, 1, 1], spacing = [0.0, 0.0, 0.0] }",
            "copies",
        ),
        (
            shape,
            "shapes = [{ ball = 0.1 }]\nrepeat = { count = [9999, 9999, 9999], spacing = [0.0, 0.0, 0.0] }",
            "copies",
        ),
        (
            "position = [0.0, 0.0, 0.1]",
            "position = [0.0, 0.0, 0.1]\norientation = [0.0, 0.0, 0.0, 0.0]",
            "length 0",
        ),
        (
            shape,
            "shapes = [{ heights = { rows = [[0.0, 0.0], [0.0, 0.0]], cell = [1.0, 1.0] } }]",
            "a terrain has no finite volume",
        ),
        (
            shape,
            "shapes = [{ ball = 0.1 }]\nrepeat = { count = [2, 1, 1], spacing = [nan, 0.0, 0.0] }",
            "not finite",
        ),
        (
            shape,
            "shapes = [{ ball = 0.1 }]\nrepeat = { count = [2, 1, 1], spacing = [1.0, 0.0, 0.0], turn = inf }",
            "not finite",
        ),
        ("position = [0.0, 0.0, 0.1]", "position = [0.0, nan, 0.1]", "not finite"),
        ("position = [0.0, 0.0, 0.1]", "position = [0.0, 0.0, 0.1]\nspin = [inf, 0.0, 0.0]", "spin of `box`"),
        ("normal = [0.0, 0.0, 1.0]", "normal = [0.0, 0.0, 0.0]", "normal of `floor`"),
        ("[\"box\", \"floor\"]", "[\"box\", \"flor\"]", "`flor`"),
        ("name = \"floor\"", "name = \"box\"", "box"),
        ("gravity = [0.0, 0.0, -9.81]", "gravity = [0.0, -9.81]", "length 3"),
    ];
    for (from, to, says) in cases {
        let error = run(&with(from, to), 1).expect_err(to).to_string();
        assert!(error.contains(says), "{to}: {error}");
    }
    let Err(SceneError::Parse { line, .. }) = parse(&with("density = 1000.0", "densty = 1000.0")) else {
        panic!("an unknown key is refused where it stands");
    };
    assert_eq!(line, 9);
    let planar = "title = \"x\"\ndimension = 4\nlaws = [\"newton\"]\n[time]\nstep = 1e-3\nend = 1.0\n";
    let error = run(planar, 1).expect_err("four dimensions").to_string();
    assert!(error.contains("dimension"), "{error}");
}

#[test]
fn a_grain_stands_on_a_body_a_million_times_as_large() {
    let ground = "[[obstacles]]\nname = \"floor\"\nposition = [0.0, 0.0, -500.0]\nshapes = [{ box = [1000.0, 1000.0, 1000.0] }]\n";
    let half = BOX.find("[[half_spaces]]").expect("a floor");
    let rest = BOX.find("[[interfaces]]").expect("an interface");
    let text = [&BOX[..half], ground, &BOX[rest..]].concat();
    for (shape, height) in
        [("ball = 5e-4", 5e-4), ("box = [1e-3, 1e-3, 1e-3]", 5e-4), ("capsule = [5e-4, 1e-3]", 1e-3)]
    {
        let text = text
            .replace("box = [0.4, 0.3, 0.2]", shape)
            .replace("position = [0.0, 0.0, 0.1]", &format!("position = [3.0, 2.0, {height:e}]"))
            .replace("step = 1e-3", "step = 1e-4");
        for q in run(&text, 200).expect("a scene") {
            assert!((q[2] - height).abs() <= 1e-9 * height.max(1e-3), "{shape}: {q:?}");
        }
    }
}

/// An octahedron of radius `r` as OBJ, or with one face turned inside out.
fn octahedron(r: f64, inverted: bool) -> String {
    let points =
        [[r, 0.0, 0.0], [0.0, r, 0.0], [-r, 0.0, 0.0], [0.0, -r, 0.0], [0.0, 0.0, r], [0.0, 0.0, -r]];
    let mut text: String = points.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    for i in 0..4 {
        let (a, b) = (i + 1, (i + 1) % 4 + 1);
        let upper = if inverted && i == 0 { [b, a, 5] } else { [a, b, 5] };
        for [a, b, c] in [upper, [b, a, 6]] {
            text += &format!("f {a} {b} {c}\n");
        }
    }
    text
}

#[test]
fn shapes_of_files_are_read_from_beside_the_scene_and_belong_to_its_fingerprint() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |text: String| std::fs::write(folder.path().join("stone.obj"), text).expect("written");
    let text = with(
        "shapes = [{ box = [0.4, 0.3, 0.2] }]",
        "shapes = [{ file = \"stone.obj\", scale = 0.1 }]\n\
                    repeat = { count = [3, 1, 1], spacing = [0.5, 0.0, 0.0] }",
    );
    let scene = Scene::parse(&text, &folder.path().join("scene.toml")).expect("a scene");
    let registry = nonsmooth::registry();
    let run = &scene.runs(&registry).expect("runs")[0];
    let build = || nonsmooth::scene::build::<f64, 3>(&scene, run, &registry);
    write(octahedron(1.0, false));
    let first = scene.fingerprint().expect("read");
    let scheme = build().expect("three stones");
    // V = 4/3 r³ and J = m r²/5 of an octahedron of radius 0.1 m.
    let mass = 1000.0 * 4.0 / 3.0 * 1e-3;
    let found: Vec<f64> = scheme.system().mass().entries().map(|(_, _, m)| m).collect();
    assert_eq!(found.len(), 18);
    for (m, expected) in found.iter().zip([mass, mass, mass, 0.2 * mass * 0.01].iter().cycle().take(4)) {
        assert!((m - expected).abs() <= 1e-12 * expected, "{found:?}");
    }
    write(octahedron(1.1, false));
    assert_ne!(scene.fingerprint().expect("read").number(), first.number());
    write(octahedron(1.0, true));
    let refused = build().expect_err("an inverted face").to_string();
    assert!(refused.contains("stone.obj") && refused.contains("box.1"), "{refused}");
}

#[test]
fn interfaces_and_bodies_in_space_without_effect_are_told() {
    let registry = nonsmooth::registry();
    let text = with("[\"box\", \"floor\"]", "[\"box\", \"box\"]");
    let warnings = parse(&text).expect("a scene").warnings(&registry).expect("names");
    let told: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    assert!(told.iter().any(|text| text.contains("no interface lets `box` touch anything")), "{told:?}");
    assert!(told.iter().any(|text| text.contains("its sides are one body")), "{told:?}");
    // A half-space has no other side to come out of; a plate has.
    let fast = with("density", "velocity = [0.0, 0.0, 300.0]\ndensity");
    assert!(parse(&fast).expect("a scene").warnings(&registry).expect("names").is_empty());
    let plate = "[[obstacles]]\nname = \"plate\"\nshapes = [{ box = [1.0, 1.0, 0.02], position = [0.0, 0.0, 0.9] }]\n";
    let text = fast + plate;
    let warnings = parse(&text).expect("a scene").warnings(&registry).expect("names");
    let told: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    assert!(
        told[0].contains("`box` starts with 3.000e-1 in a step") && told[0].contains("2.000e-2"),
        "{told:?}"
    );
    assert!(parse(BOX).expect("a scene").warnings(&registry).expect("names").is_empty());
}

#[test]
fn error_control_refuses_bodies_in_space_by_name() {
    let mut scene = parse(BOX).expect("a scene");
    scene.override_with(&Overrides { adaptive: Some(1e-6), ..Overrides::default() });
    let registry = nonsmooth::registry();
    let run = &scene.runs(&registry).expect("runs")[0];
    let Err(error) = scene.simulation(run, 3, &registry) else { panic!("refused") };
    assert!(error.to_string().contains("in space"), "{error}");
}

#[test]
fn the_examples_in_space_run_as_they_stand() {
    for (name, steps) in [
        ("tippe_top", 300),
        ("cube_stack", 150),
        ("poured_balls", 20),
        ("dominoes", 100),
        ("hills", 20),
        ("drum", 60),
        ("crank_with_clearance", 100),
    ] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("examples/{name}.toml"));
        let text = std::fs::read_to_string(path).expect("an example");
        let reached = run(&text, steps).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(reached.iter().flatten().all(|q| q.is_finite()), "{name}");
    }
}
