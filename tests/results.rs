//! What a run leaves in its folder, and what its numbers mean.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// A folder for one scene and its results.
struct Bench(tempfile::TempDir);

impl Bench {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    fn results(&self) -> PathBuf {
        self.0.path().join("results")
    }

    fn run(&self, scene: &str, arguments: &[&str]) -> Output {
        let path = self.0.path().join("scene.toml");
        fs::write(&path, scene).expect("a scene");
        let mut command = Command::new(env!("CARGO_BIN_EXE_nonsmooth"));
        command.current_dir(self.0.path()).arg("run").arg(path).arg("--out").arg(self.results());
        command.args(arguments).output().expect("the program starts")
    }

    /// The summary of a run that goes well.
    fn summary(&self, scene: &str, arguments: &[&str]) -> Value {
        let output = self.run(scene, arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        self.read()
    }

    fn read(&self) -> Value {
        let bytes = fs::read(self.results().join("summary.json")).expect("a summary");
        serde_json::from_slice(&bytes).expect("JSON")
    }

    /// Files below the results, as relative paths.
    fn files(&self) -> BTreeSet<String> {
        let (mut open, mut found) = (vec![self.results()], BTreeSet::new());
        while let Some(folder) = open.pop() {
            for entry in fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("readable").path())
            {
                if entry.is_dir() {
                    open.push(entry);
                } else {
                    let path = entry.strip_prefix(self.results()).expect("inside");
                    found.insert(path.to_string_lossy().replace('\\', "/"));
                }
            }
        }
        found
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn warnings(summary: &Value) -> Vec<String> {
    let all = summary["warnings"].as_array().expect("a list");
    all.iter().map(|warning| warning.as_str().expect("a text").to_string()).collect()
}

/// A ball of radius 0.1 m and 2 kg at rest at a height, with a floor and any time table.
fn ball(height: f64, restitution: f64, time: &str) -> String {
    format!(
        "title = \"Ball\"\nlaws = [\"newton\"]\ngravity = [0.0, -10.0]\n[time]\n{time}\nallow_unproved_theta = true\n\
         [[bodies]]\nname = \"ball\"\nmass = 2.0\ninertia = 0.01\nposition = [0.0, {height}]\n\
         [[bodies.discs]]\nname = \"rim\"\nradius = 0.1\n\
         [[half_planes]]\nname = \"floor\"\nnormal = [0.0, 1.0]\n\
         [[interfaces]]\nbetween = [\"ball\", \"floor\"]\nparameters = {{ restitution = {restitution}, friction = 0.0 }}\n"
    )
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} is a number: {value}"))
}

#[test]
fn a_ball_with_e_1_has_the_same_energy_at_start_and_end() {
    let bench = Bench::new();
    let summary = bench.summary(&ball(1.1, 1.0, "step = 1e-3\nend = 2.0"), &["--no-figures"]);
    let run = &summary["runs"][0];
    // m g h over the origin; the θ-step with θ = ½ keeps it to rounding.
    let energy = 2.0 * 10.0 * 1.1;
    for key in ["initial_energy", "final_energy", "max_energy"] {
        assert!((number(run, key) - energy).abs() < 1e-11 * energy, "{key}: {run}");
    }
    let table = fs::read_to_string(bench.results().join("energy.csv")).expect("a table");
    let total = table.lines().next().expect("a header").split(',').position(|name| name == "total");
    for row in table.lines().skip(1) {
        let value: f64 =
            row.split(',').nth(total.expect("a column")).expect("a field").parse().expect("a number");
        assert!((value - energy).abs() < 1e-11 * energy, "{row}");
    }
}

#[test]
fn what_rests_has_no_impact_and_what_falls_has_one() {
    let bench = Bench::new();
    let count = |height: f64, e: f64| {
        let summary = bench.summary(&ball(height, e, "step = 1e-3\nend = 1.0"), &["--no-figures"]);
        summary["runs"][0]["impact_count"].as_u64().expect("a count")
    };
    assert_eq!(count(0.1, 0.0), 0, "a ball that rests");
    assert_eq!(count(0.1, 0.5), 0, "a ball that rests, under a law that bounces");
    assert_eq!(count(0.3, 0.0), 1, "a ball that falls once");
    // Falls from 0.2 m at t = 0.2 s, flights of 0.2, 0.1, 0.05 … s; all of them fit, those below 2 g h do not count.
    let speeds = (0..).map(|n| 2.0 * 0.5_f64.powi(n)).take_while(|speed| *speed > 2e-2).count() as u64;
    let found = count(0.3, 0.5);
    assert!(
        found.abs_diff(speeds) <= 1,
        "{found} impacts, {speeds} faster than what rest makes in two steps"
    );
}

#[test]
fn penetration_is_that_of_the_configurations() {
    let bench = Bench::new();
    // Under this rule what overlaps at the end of a step is an impact of the next.
    let scene = ball(1.1, 1.0, "step = 3e-3\nend = 0.6\nactivation = \"current-gap\"");
    let run = bench.summary(&scene, &["--no-figures"])["runs"][0].clone();
    let penetration = &run["penetration"];
    // The lowest centre in the table of motions says how deep the ball was.
    let table = fs::read_to_string(bench.results().join("trajectory.csv")).expect("a table");
    let heights: Vec<f64> = table
        .lines()
        .skip(1)
        .map(|row| row.split(',').nth(5).expect("y").parse().expect("a number"))
        .collect();
    let deepest = heights.iter().map(|y| 0.1 - y).fold(0.0, f64::max);
    assert!((number(penetration, "largest") - deepest).abs() < 1e-12, "{penetration}, {deepest}");
    assert_eq!(number(penetration, "last"), 0.0);
    assert_eq!(penetration["contact"], "ball.rim|floor");
    assert!(deepest > 1e-4, "{deepest}");
}

#[test]
fn the_last_step_ends_where_the_run_does() {
    let bench = Bench::new();
    let times = |time: &str| -> Vec<f64> {
        bench.summary(&ball(9.0, 0.0, time), &["--no-figures"]);
        let table = fs::read_to_string(bench.results().join("trajectory.csv")).expect("a table");
        let last: Vec<&str> = table.lines().last().expect("a row").split(',').collect();
        [2, 3, 5].iter().map(|&column| last[column].parse().expect("a number")).collect()
    };
    // Free fall: the θ-step with θ = ½ is exact at every step, whatever the steps are.
    let fell = |t: f64| 9.0 - 5.0 * t * t;
    for (time, steps, end) in [
        ("step = 0.3\nend = 1.0", 4.0, 1.0),
        ("step = 0.25\nend = 1.0", 4.0, 1.0),
        ("step = 5.0\nend = 1.0", 1.0, 1.0),
        ("step = 0.3\nend = 1.0\nwhole_steps = true", 4.0, 1.2),
        ("step = 1.2\nend = 1.0\nwhole_steps = true", 1.0, 1.2),
        // Bodies that may sleep need steps of one length.
        ("step = 0.3\nend = 1.0\nsleep = true", 3.0, 0.9),
    ] {
        let [index, t, y] = times(time)[..] else { panic!("three numbers") };
        assert_eq!(index, steps, "{time}");
        assert!((t - end).abs() < 1e-15 && (y - fell(end)).abs() < 1e-13, "{time}: t = {t}, y = {y}");
    }
    let told = warnings(&bench.read());
    assert!(
        told.iter().any(|warning| warning.contains("and not at 1e0, which is no multiple of the step 3e-1")),
        "{told:?}"
    );
}

const TWO_LAWS: &str = "laws = [\"newton\", \"moreau\"]";

#[test]
fn a_run_takes_away_what_an_earlier_one_wrote_and_nothing_else() {
    let bench = Bench::new();
    let scene = ball(0.3, 0.0, "step = 1e-2\nend = 0.1");
    bench.summary(&scene.replace("laws = [\"newton\"]", TWO_LAWS), &[]);
    let first = bench.files();
    for name in ["newton.svg", "moreau.svg", "moreau.png", "comparison.svg", "summary.json"] {
        assert!(first.contains(name), "{first:?}");
    }
    // Files of others, one of which has a name like ours, and a draft of a program that was killed.
    for name in ["notes.txt", "mesh.svg", ".partial-notes", ".partial-a1B2c3"] {
        fs::write(bench.results().join(name), "mine").expect("a file");
    }
    bench.summary(&scene, &[]);
    let left = bench.files();
    let named = |names: &[&str]| names.iter().all(|name| left.contains(*name));
    assert!(named(&["newton.svg", "notes.txt", "mesh.svg", ".partial-notes"]), "{left:?}");
    for name in ["moreau.svg", "moreau.png", "comparison.svg", ".partial-a1B2c3"] {
        assert!(!left.contains(name), "{name} is of the earlier run: {left:?}");
    }
    bench.summary(&scene, &["--no-figures"]);
    assert!(!bench.files().contains("newton.svg"), "figures of the earlier run");
    // A manifest cannot name what lies outside.
    let outside = bench.0.path().join("outside.txt");
    fs::write(&outside, "mine").expect("a file");
    let lines = format!("../outside.txt\n{}\n", outside.display());
    fs::write(bench.results().join(".nonsmooth-files"), lines).expect("a manifest");
    bench.summary(&scene, &["--no-figures"]);
    assert!(outside.exists());
}

#[test]
#[cfg(feature = "vtk")]
fn frames_of_a_longer_run_do_not_stay_behind_those_of_a_shorter() {
    let bench = Bench::new();
    let without = include_str!("../examples/bouncing_bar.toml");
    let text = without.replace("[solid]\n", "[output]\nvtk_every = 100\n[solid]\n");
    bench.summary(&text, &["--no-figures", "--end", "0.5"]);
    let many = bench.files().iter().filter(|name| name.ends_with(".vtu")).count();
    bench.summary(&text, &["--no-figures", "--end", "0.2"]);
    let few = bench.files().iter().filter(|name| name.ends_with(".vtu")).count();
    let listed: usize = (bench.files().iter().filter(|name| name.ends_with(".pvd")))
        .map(|name| {
            fs::read_to_string(bench.results().join(name)).expect("a list").matches("<DataSet ").count()
        })
        .sum();
    assert!(few < many && few == listed, "{many} frames, then {few}, {listed} listed");
    bench.summary(without, &["--no-figures", "--end", "0.2"]);
    assert!(bench.files().iter().all(|name| !name.ends_with(".vtu") && !name.ends_with(".pvd")));
}

#[test]
#[cfg(feature = "fclib")]
fn a_problem_that_no_solver_solves_is_kept_where_asked() {
    let bench = Bench::new();
    let scene = ball(0.1, 0.0, "step = 1e-2\nend = 0.5")
        .replace("friction = 0.0", "friction = 0.3")
        .replace("position = [0.0, 0.1]", "position = [0.0, 0.0999]\nvelocity = [3.0, -1.0]\nspin = 20.0")
        .replace(
            "[[half_planes]]",
            "[[bodies.discs]]\nname = \"other\"\ncentre = [0.3, 0.0]\nradius = 0.1\n[[half_planes]]",
        );
    let kept = bench.0.path().join("kept");
    // A tolerance that no arithmetic reaches.
    let output = bench.run(&scene, &["--no-figures", "--save-failures", "kept", "--tol", "1e-300"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let files: Vec<PathBuf> =
        fs::read_dir(&kept).expect("the folder").map(|entry| entry.expect("readable").path()).collect();
    assert_eq!(files.len(), 1, "{files:?}");
    assert!(stderr(&output).contains("newton-hybrid-step"), "{}", stderr(&output));
    let problem = nonsmooth::fclib::read(&files[0]).expect("a problem");
    assert!(problem.dimension == 2 && problem.contacts() > 0, "{} contacts", problem.contacts());
    assert!(problem.info.description.is_some_and(|text| text.contains("contacts")));
    let again = Command::new(env!("CARGO_BIN_EXE_nonsmooth")).arg("solve").arg(&files[0]).output();
    assert!(again.expect("the program starts").status.success(), "the default tolerance is reached");
}

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
    assert!(!Path::new(&bench.results()).exists());
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

#[test]
#[cfg(feature = "hdf5")]
fn the_binary_table_has_the_rows_of_the_csv_to_the_last_bit() {
    let bench = Bench::new();
    let scene = ball(0.3, 0.5, "step = 1e-3\nend = 0.5").replace("[time]", "[output]\nhdf5 = true\n[time]");
    bench.summary(
        &scene.replace("laws = [\"newton\"]", "laws = [\"newton\", \"fremond\"]"),
        &["--no-figures"],
    );
    let file = hdf5_pure::File::open(bench.results().join("tables.h5")).expect("a file");
    for name in ["trajectory", "contacts", "energy"] {
        let mut reader =
            csv::Reader::from_path(bench.results().join(name).with_extension("csv")).expect("a table");
        let header = reader.headers().expect("a header").clone();
        let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.expect("a row")).collect();
        let dataset = file.dataset(name).expect("a table");
        assert_eq!(dataset.shape().expect("a shape"), [rows.len() as u64], "{name}");
        let hdf5_pure::Datatype::Compound { size, members } = dataset.datatype().expect("a type") else {
            panic!("{name} is no table");
        };
        assert!(header.iter().eq(members.iter().map(|member| member.name.as_str())), "{name}");
        let raw = dataset.read_raw().expect("rows");
        for (row, bytes) in rows.iter().zip(raw.chunks_exact(size as usize)) {
            for (field, member) in row.iter().zip(&members) {
                let own = &bytes[member.byte_offset as usize..];
                match member.datatype {
                    hdf5_pure::Datatype::FloatingPoint { .. } => {
                        let x = f64::from_le_bytes(own[..8].try_into().expect("eight bytes"));
                        assert_eq!(x.to_bits(), field.parse::<f64>().expect("a number").to_bits(), "{name}");
                    }
                    hdf5_pure::Datatype::String { size, .. } => {
                        let text = String::from_utf8_lossy(&own[..size as usize]).into_owned();
                        assert_eq!(text.trim_end_matches('\0'), field, "{name}");
                    }
                    _ if member.name == "step" => {
                        let step = u64::from_le_bytes(own[..8].try_into().expect("eight bytes"));
                        assert_eq!(step.to_string(), field, "{name}");
                    }
                    _ => assert_eq!(u8::from(field == "true"), own[0], "{name}"),
                }
            }
        }
    }
}
