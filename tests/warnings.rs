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

/// Runs a scene, and finds each of the texts in one of its warnings; none where there are no texts.
fn tells(bench: &Bench, scene: &str, arguments: &[&str], says: &[&str]) {
    let arguments = [&["--no-figures"], arguments].concat();
    let output = bench.run(scene, &arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    let told = warnings(&bench.read());
    assert_eq!(told.is_empty(), says.is_empty(), "{told:?} of {scene}");
    for part in says {
        assert!(told.iter().any(|warning| warning.contains(part)), "`{part}` is missing in {told:?}");
    }
}

#[test]
fn a_parameter_that_no_law_of_the_runs_takes_is_told_with_those_they_have() {
    let bench = Bench::new();
    let scene =
        ball(0.1, 0.0, "step = 1e-3\nend = 0.01").replace("friction = 0.0", "friction = 0.0, rolling = 0.1");
    let idle =
        ["interface `ball` – `floor`: `rolling` acts nowhere", "`newton` has `restitution`, `friction`"];
    tells(&bench, &scene, &[], &idle);
    // One of several laws takes it; alone on the command line the other does not.
    let both = scene.replace("laws = [\"newton\"]", "laws = [\"newton\", \"fremond-rolling\"]");
    tells(&bench, &both, &[], &[]);
    tells(&bench, &both, &["--law", "fremond-rolling"], &[]);
    tells(&bench, &both, &["--law", "newton"], &idle);
    // The law that an interface keeps is its only one.
    let kept = both.replace("parameters =", "law = \"moreau\"\nparameters =");
    tells(&bench, &kept, &[], &["`rolling` acts nowhere", "`moreau` has"]);
    // What no law has at all is a slip of the pen.
    let output = bench.run(&scene.replace("rolling", "roling"), &["--no-figures"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("no law has a parameter `roling`"), "{}", stderr(&output));
    // A joint without limits has no law.
    let joint = "[[joints]]\nname = \"hinge\"\nbody = \"ball\"\non = [0.0, 0.5]\nparameters = { restitution = 0.5 }\n";
    let hinged = format!("{}{joint}", ball(0.5, 0.0, "step = 1e-3\nend = 0.01"));
    tells(&bench, &hinged, &[], &["joint `hinge` has no limits: its `restitution` act nowhere"]);
}

#[test]
fn a_step_longer_than_springs_and_waves_can_follow_is_told() {
    let bench = Bench::new();
    // ω² = (k₁ + k₂)/m of the ball between its spring and the ground alone: 2π √(2/2e7) = 1.987e-3 s.
    let scene = ball(0.5, 0.0, "step = 1e-3\nend = 0.01");
    let spring = |more: &str| {
        format!(
            "{scene}[[springs]]\nname = \"coil\"\nbody = \"ball\"\non = [0.0, 1.0]\nstiffness = 2e7\n{more}"
        )
    };
    tells(&bench, &spring(""), &[], &["long for the spring `coil`, whose period is 1.987e-3"]);
    tells(&bench, &spring("").replace("2e7", "2e5"), &[], &[]);
    // Off its centre the ball turns as well: 1/m + r²/I = 0.5 + 0.25, and in rotation 1/I = 100.
    tells(&bench, &spring("at = [0.05, 0.0]\naxis = [0.0, 1.0]\n"), &[], &["whose period is 1.622e-3"]);
    tells(&bench, &spring("angular = true\n").replace("2e7", "1e5"), &[], &["whose period is 1.987e-3"]);

    // Two masses of 1 kg and a stiff spring between them: ω² = 2 k/m.
    let two = |stiff: f64| {
        format!(
            "title = \"Chain\"\nlaws = [\"newton\"]\n[time]\nstep = 1e-3\nend = 0.1\n[lagrangian]\n\
             coordinates = [\"x\", \"y\"]\nmass = [[1.0, 0.0], [0.0, 1.0]]\n\
             stiffness = [[{stiff:?}, -{stiff:?}], [-{stiff:?}, {stiff:?}]]\nposition = [0.0, 1.0]\n"
        )
    };
    tells(&bench, &two(1e5), &[], &[]);
    tells(&bench, &two(5e6), &[], &["the springs of the Lagrangian system, whose period is 1.987e-3"]);

    // A bar of 1 m with c = √(E/ρ) = 100 m/s.
    let bar = |step: &str| {
        format!(
            "title = \"Bar\"\nlaws = [\"newton\"]\n[time]\nstep = {step}\nend = 0.1\n[solid]\nname = \"bar\"\n\
             young = 1e7\ndensity = 1e3\nvelocity = [1.0, 0.0]\n[solid.mesh]\ninterval = 1.0\nelements = 4\n"
        )
    };
    tells(&bench, &bar("9e-3"), &[], &[]);
    tells(
        &bench,
        &bar("2e-2"),
        &[],
        &["the step 2e-2 is long for the waves in `bar`, which cross it in 1.000e-2"],
    );
}

#[test]
fn bodies_drawn_into_each_other_are_not_told_to_take_a_shorter_step() {
    let bench = Bench::new();
    let scene = ball(0.08, 0.0, "step = 1e-3\nend = 0.05").replace("radius = 0.1", "radius = 0.12");
    tells(
        &bench,
        &scene,
        &[],
        &["overlap by 4.000e-2 when the run starts", "they overlapped by 4.000e-2 when the run started"],
    );
    let output = bench.run(&scene, &["--no-figures"]);
    assert!(!stderr(&output).contains("take a shorter step"), "{}", stderr(&output));
}

#[test]
fn a_chain_drawn_the_wrong_way_round_is_told_to_be_reversed() {
    let bench = Bench::new();
    let on = |points: &str, more: &str| {
        ball(0.1, 0.0, "step = 1e-3\nend = 0.01").replace(
            "[[half_planes]]\nname = \"floor\"\nnormal = [0.0, 1.0]\n",
            &format!("[[obstacles]]\nname = \"floor\"\nchains = [{{ name = \"top\", points = [{points}]{more} }}]\n"),
        )
    };
    let behind =
        ["`ball` start behind the chain `floor.top`", "free side is on the left", "reverse its points"];
    tells(&bench, &on("[-1.0, 0.0], [0.0, -0.01], [1.0, 0.0]", ""), &[], &[]);
    tells(&bench, &on("[1.0, 0.0], [0.0, -0.01], [-1.0, 0.0]", ""), &[], &behind);
    // A box that the ball is in, and a block that it should be around.
    let corners = ["[-1.0, -1.0]", "[1.0, -1.0]", "[1.0, 1.0]", "[-1.0, 1.0]"];
    tells(&bench, &on(&corners.join(", "), ", closed = true"), &[], &[]);
    let clockwise: Vec<&str> = corners.into_iter().rev().collect();
    tells(&bench, &on(&clockwise.join(", "), ", closed = true"), &[], &behind);
    // With another ball on the free side somebody meets the chain there.
    let two = on("[-1.0, -0.5], [1.0, -0.5]", "").replace(
        "[[obstacles]]",
        "[[bodies]]\nname = \"below\"\ngroups = [\"balls\"]\nmass = 1.0\ninertia = 0.01\nposition = [0.0, -3.0]\n\
         discs = [{ name = \"rim\", radius = 0.1 }]\n[[obstacles]]",
    );
    let two = two
        .replace("name = \"ball\"\n", "name = \"ball\"\ngroups = [\"balls\"]\n")
        .replace("between = [\"ball\", \"floor\"]", "between = [\"balls\", \"floor\"]");
    tells(&bench, &two, &[], &[]);
}

#[test]
fn results_that_cannot_be_a_folder_are_refused_in_words() {
    let bench = Bench::new();
    let scene = ball(0.1, 0.0, "step = 1e-3\nend = 0.01");
    fs::write(bench.results(), "a file").expect("a file");
    let output = bench.run(&scene, &["--no-figures"]);
    assert_eq!(output.status.code(), Some(2));
    for part in ["results", "it is a file; it must be a folder, or not exist"] {
        assert!(stderr(&output).contains(part), "{}", stderr(&output));
    }
    assert_eq!(fs::read_to_string(bench.results()).expect("as it was"), "a file");
}

#[test]
fn a_body_connected_with_itself_is_refused_by_name() {
    let bench = Bench::new();
    let scene = ball(0.1, 0.0, "step = 1e-3\nend = 0.01");
    for (kind, named) in [("joints", "joint `link`"), ("springs", "`link`")] {
        let more = if kind == "springs" { "stiffness = 1.0\n" } else { "" };
        let link = format!("{scene}[[{kind}]]\nname = \"link\"\nbody = \"ball\"\nto = \"ball\"\n{more}");
        let output = bench.run(&link, &["--no-figures"]);
        assert_eq!(output.status.code(), Some(2));
        let says = format!("{named} connects `ball` with `ball`: it wants two different bodies");
        assert!(stderr(&output).contains(&says), "{}", stderr(&output));
    }
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
