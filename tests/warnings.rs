//! What the program says of scenes that are not what was meant: warnings, and refusals that tell the way out.

mod outcome;

use std::fs;

use outcome::{Bench, ball, number, stderr, warnings};

#[test]
fn what_has_no_effect_is_told_on_the_terminal_and_in_the_summary() {
    let bench = Bench::new();
    let time = "step = 1e-3\nend = 0.01";
    let told = |scene: &str, says: &[&str]| {
        let output = bench.run(scene, &["--no-figures"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let warnings = warnings(&bench.read());
        assert_eq!(warnings.len(), usize::from(!says.is_empty()), "{warnings:?} of {scene}");
        for part in says {
            assert!(warnings[0].contains(part), "`{part}` is missing in {warnings:?}");
            assert!(stderr(&output).contains(part), "`{part}` is missing in {}", stderr(&output));
        }
    };
    let scene = ball(0.1, 0.0, time);
    told(&scene, &[]);
    let start = scene.find("[[interfaces]]").expect("an interface");
    told(&scene[..start], &["no interface lets `ball` touch anything"]);
    told(&ball(0.08, 0.0, time), &["ball.rim|floor overlap by 2.000e-2 when the run starts"]);
    let itself = format!(
        "{scene}[[interfaces]]\nbetween = [\"ball\", \"ball\"]\nparameters = {{ friction = 0.3, restitution = 0.0 }}\n"
    );
    told(
        &itself,
        &[
            "interface `ball` – `ball` has no effect",
            "does not touch itself",
            "`friction`, `restitution` act nowhere",
        ],
    );
    let twice = format!(
        "{scene}[[interfaces]]\nbetween = [\"floor\", \"ball\"]\nparameters = {{ friction = 0.3, restitution = 0.0 }}\n"
    );
    told(&twice, &["interface `floor` – `ball` has no effect", "interfaces before it govern"]);
    let fast = scene.replace("position", "spin = 2000.0\nposition");
    told(&fast, &["the step 1e-3 is long for the spin of `ball`, whose period is 3.142e-3"]);
    // An obstacle is something to touch.
    let step = "[[obstacles]]\nname = \"step\"\npolygons = [{ name = \"s\", vertices = [[-1.0, -1.0], [1.0, -1.0], [1.0, 0.0], \
        [-1.0, 0.0]] }]\n";
    let floor = "[[half_planes]]\nname = \"floor\"\nnormal = [0.0, 1.0]\n";
    let on_step = scene.replace(floor, step).replace("\"floor\"", "\"step\"");
    assert!(on_step.contains("[[obstacles]]") && !on_step.contains("floor"));
    told(&on_step, &[]);
    let stiff = scene.replace("position", "stiffness = [2e7, 0.0, 0.0]\nposition");
    told(&stiff, &["long for the springs of `ball`", "1.987e-3"]);
    told(
        &ball(1.1, 1.0, "step = 0.02\nend = 0.6\nactivation = \"current-gap\""),
        &["newton with hybrid: ball.rim|floor overlapped by", "take a shorter step"],
    );
}

#[test]
fn a_mesh_for_a_scene_without_an_elastic_body_is_refused() {
    let bench = Bench::new();
    let output = bench.run(&ball(0.1, 0.0, "step = 1e-3\nend = 0.01"), &["--mesh", "block.msh"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("the scene has no [solid]"), "{}", stderr(&output));
    assert!(!bench.results().exists());
}

#[test]
fn a_mesh_without_groups_makes_a_scene_by_selectors() {
    let bench = Bench::new();
    let mesh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n9 5 5 0\n$EndNodes\n\
        $Elements\n2\n2 2 2 0 6 1 3 2\n3 2 2 0 6 1 4 3\n$EndElements\n";
    fs::write(bench.0.path().join("square.msh"), mesh).expect("a mesh");
    let scene = "title = \"Square\"\nlaws = [\"fremond\"]\ngravity = [0.0, -10.0]\n[time]\nstep = 1e-3\nend = 0.2\n\
        [solid]\nname = \"block\"\nyoung = 1e5\npoisson = 0.3\ndensity = 10.0\n\
        [solid.mesh]\nfile = \"square.msh\"\ngroups = { \"normal -y\" = \"sole\" }\n\
        [[solid.tractions]]\ngroup = \"top\"\nstress = [0.0, -10.0]\n\
        [[half_planes]]\nname = \"floor\"\npoint = [0.0, 0.0]\nnormal = [0.0, 1.0]\n\
        [[interfaces]]\nbetween = [\"block.y < 1e-6\", \"floor\"]\nparameters = { restitution = 0.0, friction = 0.0 }\n";
    let summary = bench.summary(scene, &["--no-figures"]);
    let told = warnings(&summary);
    assert!(
        told.iter().any(|w| w.contains("belong to no element") && w.contains("node 9 at (5, 5)")),
        "{told:?}"
    );
    assert!(told.iter().any(|w| w.contains("run clockwise are turned: 2")), "{told:?}");
    // Two nodes carry the block: the mean of their percussions per step is half its weight and load.
    let table = fs::read_to_string(bench.results().join("contacts.csv")).expect("a table");
    let header: Vec<&str> = table.lines().next().expect("a header").split(',').collect();
    let column = header.iter().position(|name| *name == "p_N").expect("percussions");
    let impulse: f64 = table
        .lines()
        .skip(1)
        .map(|row| row.split(',').nth(column).expect("p_N").parse::<f64>().expect("a number"))
        .sum();
    let force = impulse / 0.2;
    assert!((force - 110.0).abs() < 0.1 * 110.0, "the floor carries {force} N of 110 N");
    for (from, to, says) in [
        ("\"normal -y\" = \"sole\"", "\"cellar\" = \"sole\"", "no group `cellar`"),
        ("\"top\"", "\"roof\"", "no group `roof`"),
        ("block.y < 1e-6", "block.roof", "nothing is called `block.roof`"),
        (
            "file = \"square.msh\"",
            "file = \"square.msh\"\nsize = 0.1",
            "mesh.size goes with mesh.rectangle alone",
        ),
        ("block.y < 1e-6", "block.y < -3", "`y < -3` has no element"),
    ] {
        assert!(scene.contains(from));
        let output = bench.run(&scene.replace(from, to), &["--no-figures"]);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(stderr(&output).contains(says), "{}", stderr(&output));
    }
}

#[test]
fn inelastic_laws_run_with_a_theta_that_suits_them() {
    let bench = Bench::new();
    let default = ball(0.3, 0.0, "step = 1e-3\nend = 0.5").replace("allow_unproved_theta = true\n", "");
    let scene = default.replace("laws = [\"newton\"]", "laws = [\"newton\", \"fremond\", \"moreau\"]");
    let summary = bench.summary(&scene, &["--no-figures"]);
    let thetas: Vec<f64> =
        summary["runs"].as_array().expect("runs").iter().map(|run| number(run, "theta")).collect();
    assert_eq!(thetas, [1.0, 0.5, 1.0], "where each law is proved dissipative for e = 0");
    let refused = |scene: &str, says: &[&str]| {
        let output = bench.run(scene, &["--no-figures"]);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        for part in says {
            assert!(stderr(&output).contains(part), "`{part}` is missing in {}", stderr(&output));
        }
    };
    refused(
        &default.replace("end = 0.5", "end = 0.5\ntheta = 0.5"),
        &[
            "`ball` – `floor`",
            "`newton`",
            "θ = 0.5 is outside [1, 1]",
            "leave time.theta out",
            "time.allow_unproved_theta = true",
        ],
    );
    // A second floor whose law wants another θ.
    let two = format!(
        "{default}[[half_planes]]\nname = \"wall\"\npoint = [-5.0, 0.0]\nnormal = [1.0, 0.0]\n\
         [[interfaces]]\nbetween = [\"ball\", \"wall\"]\nlaw = \"moreau\"\nparameters = {{ restitution = 1.0, friction = 0.0 }}\n"
    );
    refused(
        &two,
        &["`ball` – `wall`", "`moreau`", "θ in [0.5, 0.5]", "one in [1, 1]", "allow_unproved_theta"],
    );
}

/// An L of two bars, 3 m by 3 m by 1 m, at rest on the floor.
fn ell(decompose: &str) -> String {
    ball(0.0, 0.0, "step = 1e-2\nend = 1.0")
        .replace("position = [0.0, 0]", "position = [0.0, 1.1]")
        .replace("inertia = 0.01", "inertia = 3.0")
        .replace(
            "[[bodies.discs]]\nname = \"rim\"\nradius = 0.1\n",
            &format!(
                "[[bodies.polygons]]\nname = \"ell\"\n{decompose}vertices = [[-1.1, -1.1], [1.9, -1.1], [1.9, -0.1], \
                 [-0.1, -0.1], [-0.1, 1.9], [-1.1, 1.9]]\n"
            ),
        )
}

#[test]
fn a_concave_outline_is_called_concave_and_stands_when_decomposed() {
    let bench = Bench::new();
    let output = bench.run(&ell(""), &["--no-figures"]);
    assert_eq!(output.status.code(), Some(2));
    for part in ["polygon `ball.ell`, vertex 3", "concave", "decompose = true"] {
        assert!(stderr(&output).contains(part), "{}", stderr(&output));
    }
    bench.summary(&ell("decompose = true\n"), &["--no-figures"]);
    let table = fs::read_to_string(bench.results().join("trajectory.csv")).expect("a table");
    let last: Vec<f64> = table
        .lines()
        .last()
        .expect("a row")
        .split(',')
        .skip(4)
        .map(|x| x.parse().expect("a number"))
        .collect();
    let still = [0.0, 1.1, 0.0, 0.0, 0.0, 0.0];
    assert!(last.iter().zip(still).all(|(x, y)| (x - y).abs() < 1e-9), "{last:?}");
    let clockwise = ell("").replace("[1.9, -0.1], [-0.1, -0.1], ", "").replace(
        "[[-1.1, -1.1], [1.9, -1.1], [-0.1, 1.9], [-1.1, 1.9]]",
        "[[-1.1, 1.9], [-0.1, 1.9], [1.9, -1.1], [-1.1, -1.1]]",
    );
    let output = bench.run(&clockwise, &["--no-figures"]);
    assert!(stderr(&output).contains("runs clockwise"), "{}", stderr(&output));
}

/// An outline with a step in it, on its corner at the origin.
const ELL: &str = "[[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]]";

#[test]
fn concave_obstacles_stand_when_decomposed_as_bodies_do() {
    let bench = Bench::new();
    let scene = ball(1.15, 0.0, "step = 1e-3\nend = 0.4").replace(
        "[[half_planes]]\nname = \"floor\"\nnormal = [0.0, 1.0]\n",
        &format!("[[obstacles]]\nname = \"floor\"\nposition = [-2.0, 0.0]\npolygons = [{{ name = \"l\", vertices = {ELL} }}]\n"),
    );
    let output = bench.run(&scene, &["--no-figures"]);
    assert!(stderr(&output).contains("decompose = true"), "{}", stderr(&output));
    let decomposed = scene.replace(" }]\n[[interfaces]]", ", decompose = true }]\n[[interfaces]]");
    let summary = bench.summary(&decomposed, &["--no-figures"]);
    assert_eq!(warnings(&summary), Vec::<String>::new());
    // It lands on the low part, in the notch: 0.05 m of 2 kg × 10 m/s² are lost.
    let run = &summary["runs"][0];
    let lost = number(run, "initial_energy") - number(run, "final_energy");
    assert!((lost - 1.0).abs() < 1e-6, "{lost} J");
}

#[test]
fn gaps_of_lagrangian_systems_have_a_say_in_theta() {
    let bench = Bench::new();
    let scene = "title = \"Oscillator\"\nlaws = [\"newton\"]\n[time]\nstep = 1e-3\nend = 1.0\n\
        [lagrangian]\ncoordinates = [\"x\"]\nmass = [[1.0]]\nstiffness = [[10.0]]\nposition = [1.0]\n\
        [[lagrangian.gaps]]\nname = \"wall\"\nnormal = [1.0]\nparameters = { restitution = 0.0, friction = 0.0 }\n";
    bench.summary(scene, &["--no-figures"]);
    let given = scene.replace("step = 1e-3", "step = 1e-3\ntheta = 0.5");
    let output = bench.run(&given, &["--no-figures"]);
    assert!(stderr(&output).contains("`wall`"), "the gap is named: {}", stderr(&output));
}
