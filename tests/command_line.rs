//! The program from outside: exit codes, messages, what it writes and what it leaves alone.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

const STICK: &str = include_str!("../examples/impacting_stick.toml");

fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nonsmooth"));
    command.stdin(Stdio::null());
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("messages are UTF-8")
}

/// A folder with the stick's scene and results of an older run to keep.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let bench = Self { folder };
        fs::create_dir(bench.results()).expect("a new folder");
        for name in
            ["trajectory.csv", "contacts.csv", "energy.csv", "summary.json", "newton.svg", "comparison.png"]
        {
            fs::write(bench.results().join(name), format!("older {name}")).expect("a new file");
        }
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn results(&self) -> PathBuf {
        self.path("results")
    }

    fn scene(&self, text: &str) -> PathBuf {
        let path = self.path("scene.toml");
        fs::write(&path, text).expect("a new file");
        path
    }

    /// Every file below the results, with its bytes.
    fn contents(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let files = fs::read_dir(self.results()).expect("the results");
        files
            .map(|entry| entry.expect("readable").path())
            // A draft may have moved to its place in the meantime, while a program runs.
            .filter_map(|path| Some((path.clone(), fs::read(&path).ok()?)))
            .collect()
    }

    fn run(&self, scene: &Path, arguments: &[&str]) -> Output {
        let mut command = program();
        command.arg("run").arg(scene).arg("--out").arg(self.results()).args(arguments);
        command.output().expect("the program starts")
    }

    /// The run is refused: exit code 2, a message with every one of `says`, no panic, older results untouched.
    fn assert_refused(&self, scene: &Path, arguments: &[&str], says: &[&str]) {
        let before = self.contents();
        let output = self.run(scene, arguments);
        assert_usage_error(&output, says);
        assert!(before == self.contents(), "older results were touched by a run that was refused: {says:?}");
    }

    /// As [`assert_refused`](Self::assert_refused) for the stick with `from` replaced by `to`.
    fn assert_edit_refused(&self, from: &str, to: &str, says: &[&str]) {
        assert!(STICK.contains(from), "the scene has no `{from}`");
        self.assert_refused(&self.scene(&STICK.replace(from, to)), &[], says);
    }

    fn summary(&self) -> Value {
        let file = fs::read_to_string(self.results().join("summary.json")).expect("a summary");
        serde_json::from_str(&file).expect("the summary is JSON")
    }
}

fn assert_usage_error(output: &Output, says: &[&str]) {
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "exit code; stderr: {message}");
    assert!(!message.contains("panicked"), "{message}");
    for part in says {
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
}

#[test]
fn numbers_out_of_range_are_refused_with_their_value() {
    let bench = Bench::new();
    for (from, to, says) in [
        ("mass = 1.0 ", "mass = -1.0 ", ["mass of `stick`", "-1"]),
        ("mass = 1.0 ", "mass = nan ", ["mass of `stick`", "NaN"]),
        ("mass = 1.0 ", "mass = 0.0 ", ["mass of `stick`", "is 0"]),
        ("inertia = 0.08333333333333333", "inertia = inf", ["inertia of `stick`", "inf"]),
        ("gravity = [0.0, -10.0]", "gravity = [0.0, nan]", ["gravity", "NaN"]),
        ("gravity = [0.0, -10.0]", "gravity = [inf, 0.0]", ["gravity", "inf"]),
        ("0.36355339059327380]", "nan]", ["position of `stick`", "NaN"]),
        ("angle = 0.78539816339744831", "angle = inf", ["angle of `stick`", "inf"]),
        ("velocity = [-0.5, 0.1]", "velocity = [-inf, 0.1]", ["velocity of `stick`", "-inf"]),
        ("velocity = [-0.5, 0.1]", "velocity = [1e200, 0.1]", ["energy", "inf"]),
        ("spin = 0.1 ", "spin = nan ", ["spin of `stick`", "NaN"]),
        ("spin = 0.1 ", "torque = nan ", ["force on `stick`", "NaN"]),
        ("centre = [0.0, -0.5]", "centre = [0.0, inf]", ["centre of `stick.tip`", "inf"]),
        ("centre = [0.0, -0.5]", "radius = -0.5", ["radius of `stick.tip`", "-0.5"]),
        ("normal = [0.0, 1.0]", "normal = [0.0, 0.0]", ["normal of `floor`", "is 0"]),
        ("normal = [0.0, 1.0]", "point = [nan, 0.0]\nnormal = [0.0, 1.0]", ["point of `floor`", "NaN"]),
        ("theta = 0.5", "theta = 1.5", ["θ = 1.5", "[0, 1]"]),
        ("theta = 0.5", "theta = -0.1", ["θ = -0.1", "[0, 1]"]),
        ("theta = 0.5", "theta = nan", ["θ = NaN", "[0, 1]"]),
        ("theta = 0.5", "theta = 0.75", ["θ = 0.75", "`fremond`"]),
        ("step = 1e-4 ", "step = 0.0 ", ["time.step", "is 0"]),
        ("step = 1e-4 ", "step = -1e-4 ", ["time.step", "-0.0001"]),
        ("step = 1e-4 ", "step = 1e-30 ", ["number of steps", "at most"]),
        ("end = 0.2 ", "end = inf ", ["time.end", "inf"]),
        ("theta = 0.5", "gap_tolerance = 0.0", ["gap tolerance", "is 0"]),
        ("theta = 0.5", "velocity_tolerance = nan", ["velocity tolerance", "NaN"]),
        ("[time]", "[solver]\ntolerance = 0.0\n[time]", ["solver tolerance", "is 0"]),
        ("[time]", "[solver]\ntolerance = nan\n[time]", ["solver tolerance", "NaN"]),
        ("[time]", "[solver]\nmax_seconds = -1.0\n[time]", ["time budget", "-1"]),
        ("[time]", "[output]\nevery = 0\n[time]", ["output.every", "is 0"]),
        ("restitution = 1.0", "restitution = 1.5", ["restitution = 1.5", "[0, 1]"]),
        ("restitution = 1.0", "restitution = nan", ["restitution = NaN", "`stick.tip`"]),
        ("friction = 0.01", "friction = -0.01", ["friction = -0.01", "`floor`"]),
        ("friction = 0.01", "friction = inf", ["friction = inf", "finite"]),
    ] {
        bench.assert_edit_refused(from, to, &says);
    }
}

#[test]
fn single_precision_refuses_what_it_cannot_hold() {
    let bench = Bench::new();
    let heavy = bench.scene(&STICK.replace("mass = 1.0 ", "mass = 1e300 "));
    bench.assert_refused(&heavy, &["--scalar", "f32"], &["mass of `stick`", "inf"]);
    let brief =
        bench.scene(&STICK.replace("step = 1e-4 ", "step = 1e-60 ").replace("end = 0.2 ", "end = 1e-59 "));
    bench.assert_refused(&brief, &["--scalar", "f32"], &["time step", "is 0"]);
}

#[test]
fn names_that_mean_nothing_or_two_things_are_refused() {
    let bench = Bench::new();
    for (from, to, says) in [
        ("\"newton\", \"fremond\"", "\"nwton\"", ["`nwton`", "newton, fremond"]),
        ("\"newton\", \"fremond\"", "\"newton\", \"newton\"", ["`newton`", "twice"]),
        ("\"newton\", \"fremond\"", "", ["no law", "names"]),
        ("[time]", "solvers = [\"simplex\"]\n[time]", ["`simplex`", "nsgs"]),
        ("[time]", "solvers = []\n[time]", ["no solver", "names"]),
        ("name = \"floor\"", "name = \"stick\"", ["`stick`", "twice"]),
        ("name = \"tip\" ", "name = \"tip\"\n[[bodies.discs]]\nname = \"tip\" ", ["`stick.tip`", "twice"]),
        ("\"stick.tip\", \"floor\"", "\"stick.top\", \"floor\"", ["`stick.top`", "known: floor"]),
        ("friction = 0.01", "grip = 0.01", ["`grip`", "`stick.tip`"]),
        ("restitution = 1.0, ", "", ["`restitution`", "needs"]),
        ("[time]", "[output]\nfigure_body = \"ball\"\n[time]", ["figure_body", "`ball`"]),
        ("[time]", "[output]\nfigure_contact = \"a|b\"\n[time]", ["figure_contact", "`a|b`"]),
    ] {
        bench.assert_edit_refused(from, to, &says);
    }
}

#[test]
fn keys_are_refused_with_line_and_column() {
    let bench = Bench::new();
    // (replacement, what the message says); the scene has `theta` on line 14.
    let line = STICK.lines().position(|line| line.starts_with("theta")).expect("a line of the scene") + 1;
    let at = format!("scene.toml:{line}:1:");
    for (to, says) in [("thta = 0.5", "`thta`"), ("theta = 0.5\ntheta = 0.5", "duplicate key")] {
        // The second of two equal keys is the one that is wrong.
        let at = if to.contains('\n') { format!("scene.toml:{}:1:", line + 1) } else { at.clone() };
        bench.assert_edit_refused("theta = 0.5", to, &[&at, says]);
    }
    let column = format!("scene.toml:{line}:9:");
    bench.assert_edit_refused("theta = 0.5", "theta = \"half\"", &[&column, "expected f64"]);
    bench.assert_edit_refused("theta = 0.5", "activation = \"nearest\"", &["`nearest`", "`moreau-jean`"]);
    bench.assert_edit_refused("end = 0.2 ", "# end = 0.2 ", &["scene.toml:", "missing field `end`"]);
    bench.assert_edit_refused("mass = 1.0 ", "# mass = 1.0 ", &["scene.toml:", "missing field `mass`"]);
    bench.assert_edit_refused("title", "titel", &["scene.toml:", "`titel`"]);
    bench.assert_edit_refused("[time]", "[time", &["scene.toml:", "]"]);
}

#[test]
fn scenes_that_cannot_be_read_are_refused() {
    let bench = Bench::new();
    bench.assert_refused(bench.folder.path(), &[], &["cannot read the scene", "directory"]);
    bench.assert_refused(&bench.path("absent.toml"), &[], &["cannot read the scene", "absent.toml"]);
    let binary = bench.path("binary.toml");
    fs::write(&binary, [0xff, 0x00, 0xfe, 0x80]).expect("a new file");
    bench.assert_refused(&binary, &[], &["cannot read the scene", "binary.toml", "UTF-8"]);
    let empty = bench.path("empty.toml");
    fs::write(&empty, "").expect("a new file");
    bench.assert_refused(&empty, &[], &["empty.toml:1:1:", "missing field"]);
}

#[test]
fn options_out_of_range_are_refused() {
    let bench = Bench::new();
    let scene = bench.scene(STICK);
    for (arguments, says) in [
        (["--theta", "2"], ["θ = 2", "[0, 1]"]),
        (["--theta", "nan"], ["θ = NaN", "[0, 1]"]),
        (["--theta", "half"], ["half", "--theta"]),
        (["--step", "-1"], ["time.step", "-1"]),
        (["--step", "-inf"], ["time.step", "-inf"]),
        (["--step", "inf"], ["time.step", "inf"]),
        (["--end", "0"], ["time.end", "is 0"]),
        (["--tol", "-1e-10"], ["solver tolerance", "-0.0000000001"]),
        (["--law", "nwton"], ["`nwton`", "fremond"]),
        (["--law", "newton,newton"], ["`newton`", "twice"]),
        (["--solver", "simplex"], ["`simplex`", "nsgs"]),
        (["--scalar", "f16"], ["f16", "f64"]),
        (["--colour", "red"], ["--colour", "unexpected"]),
    ] {
        bench.assert_refused(&scene, &arguments, &says);
    }
}

#[test]
fn an_output_folder_that_cannot_be_written_is_refused() {
    let bench = Bench::new();
    let scene = bench.scene(STICK);
    let before = bench.contents();
    let file = bench.results().join("summary.json");
    for folder in [file.clone(), file.join("below")] {
        let output = program().arg("run").arg(&scene).arg("--out").arg(&folder).output().expect("starts");
        assert_usage_error(&output, &["cannot write", "summary.json"]);
    }
    assert!(before == bench.contents());
    // A folder where a file should go: found before the first step, and the other files stay.
    for name in ["energy.csv", "summary.json"] {
        let bench = Bench::new();
        let obstacle = bench.results().join(name);
        fs::remove_file(&obstacle).expect("an older result");
        fs::create_dir(&obstacle).expect("a new folder");
        let output = bench.run(&scene, &[]);
        assert_usage_error(&output, &["cannot write", name]);
        for kept in ["trajectory.csv", "contacts.csv", "newton.svg"] {
            let bytes = fs::read(bench.results().join(kept)).expect("an older result");
            assert_eq!(bytes, format!("older {kept}").as_bytes());
        }
    }
}

/// The rows of a table, header first; every row has the columns of the header.
fn table(path: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_path(path).expect("a table");
    let rows: Result<Vec<csv::StringRecord>, _> = reader.records().collect();
    let rows = rows.expect("every row has the columns of the header");
    rows.iter().map(|row| row.iter().map(String::from).collect()).collect()
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().expect("an object").keys().map(String::as_str).collect()
}

#[test]
fn the_summary_has_the_keys_it_promises() {
    let bench = Bench::new();
    let output = bench.run(&bench.scene(STICK), &["--no-figures", "--solver", "nsgs", "--end", "0.07"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let summary = bench.summary();
    assert_eq!(keys(&summary), ["runs", "scene", "title", "warnings"]);
    let runs = summary["runs"].as_array().expect("a list");
    assert_eq!(runs.len(), 2);
    for run in runs {
        let mut promised = vec![
            "law",
            "solver",
            "theta",
            "step",
            "steps",
            "scalar",
            "wall_seconds",
            "us_per_step",
            "initial_energy",
            "final_energy",
            "max_tangential_work",
            "max_normal_work",
            "positive_work_steps",
            "max_imbalance",
            "max_residual",
            "solver_iterations",
            "impacts",
        ];
        // Beyond the promise: the scale of round-off, impacts not listed one by one, and why a run stopped early.
        promised.extend(["max_energy", "impact_count", "penetration", "stopped"]);
        promised.extend(["adaptive", "contact_work", "external_work", "tangential_work_steps", "rescues"]);
        promised.sort_unstable();
        assert_eq!(keys(run), promised);
        assert_eq!(run["steps"], 700);
        assert_eq!(run["scalar"], "f64");
        let numbers = run.as_object().expect("an object").values().filter(|value| value.is_null()).count();
        assert_eq!(numbers, 2, "only `adaptive` and `stopped` are null, every number is finite");
        let impacts = run["impacts"].as_array().expect("a list");
        assert_eq!(impacts.len(), 1);
        assert_eq!(impacts[0]["step"], 603);
        let promised = [
            "contact",
            "normal_work",
            "percussion",
            "step",
            "tangential_work",
            "time",
            "u_after",
            "u_before",
        ];
        assert_eq!(keys(&impacts[0]), promised);
    }
    let rows = table(&bench.results().join("trajectory.csv"));
    assert_eq!(rows.len(), 1 + 2 * 701);
    assert_eq!(rows[0][..5], ["law", "solver", "step", "time", "stick.x"]);
}

#[test]
fn an_old_result_is_replaced_whole() {
    let bench = Bench::new();
    let output = bench.run(&bench.scene(STICK), &["--no-figures", "--end", "0.01"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    for name in ["trajectory.csv", "contacts.csv", "energy.csv"] {
        assert_eq!(table(&bench.results().join(name))[0][0], "law");
    }
    let drafts = bench.contents().into_keys().filter(|path| path.to_string_lossy().contains(".partial-"));
    assert_eq!(drafts.count(), 0, "a draft was left behind");
}

/// A row of discs that press on each other and on the floor: many contacts in one cone problem.
fn row_of_discs(count: usize) -> String {
    let mut scene = String::from(
        "title = \"row\"\nlaws = [\"newton\"]\ngravity = [0.0, -10.0]\n[time]\nstep = 1e-3\nend = 1.0\n",
    );
    for i in 0..count {
        // Neighbours overlap by 1 mm, and roll apart under friction.
        let x = 0.199 * i as f64;
        scene += &format!(
            "[[bodies]]\nname = \"b{i}\"\ngroups = [\"row\"]\nmass = 1.0\ninertia = 0.005\n\
             position = [{x}, 0.0999]\nvelocity = [{}, -1.0]\n[[bodies.discs]]\nname = \"d\"\nradius = 0.1\n",
            1.0 - 2.0 * (i as f64) / count as f64
        );
    }
    scene += "[[half_planes]]\nname = \"floor\"\nnormal = [0.0, 1.0]\n";
    for pair in ["\"row\", \"row\"", "\"row\", \"floor\""] {
        scene += &format!(
            "[[interfaces]]\nbetween = [{pair}]\nparameters = {{ restitution = 0.3, friction = 0.4 }}\n"
        );
    }
    scene
}

#[test]
fn a_step_that_its_solver_misses_is_solved_otherwise_and_counted() {
    let bench = Bench::new();
    let scene = row_of_discs(30).replace("[time]", "[solver]\nmax_iterations = 1\n[time]");
    let output = bench.run(&bench.scene(&scene), &["--no-figures", "--solver", "nsgs"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let run = &bench.summary()["runs"][0];
    // One sweep is too little while 30 discs press on each other.
    assert!(run["rescues"].as_u64().expect("a count") > 0, "{run}");
    assert!(run["max_residual"].as_f64().expect("a number") <= 1e-10, "{run}");
    let report = text(&output.stdout);
    assert!(report.contains("solved by another start or method: "), "{report}");
}

#[test]
fn a_failed_solve_exits_with_1_and_keeps_what_was_computed() {
    // Tolerances that no arithmetic reaches.
    for (settings, arguments) in
        [("", vec!["--tol", "1e-300"]), ("[solver]\nmax_iterations = 3\n", vec!["--tol", "1e-18"])]
    {
        let bench = Bench::new();
        let scene = bench.scene(&row_of_discs(30).replace("[time]", &format!("{settings}[time]")));
        let output =
            bench.run(&scene, &[&["--no-figures", "--solver", "nsgs"], arguments.as_slice()].concat());
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{message}");
        for part in ["residual", "tolerance", "nsgs", "contacts", "step "] {
            assert!(message.contains(part), "`{part}` is missing in: {message}");
        }
        let run = &bench.summary()["runs"][0];
        let steps = run["steps"].as_u64().expect("a count");
        assert!(run["stopped"].as_str().expect("the reason").contains("tolerance"));
        for name in ["trajectory.csv", "energy.csv"] {
            let rows = table(&bench.results().join(name));
            assert_eq!(rows.len() as u64, 1 + steps + 1, "header, initial state and {steps} steps in {name}");
            assert_eq!(rows.last().expect("a row")[2], steps.to_string());
        }
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_complete_files_of_what_was_done() {
    let bench = Bench::new();
    // Two laws and far more steps than can be made: the first run is interrupted, the second does not start.
    let scene = bench.scene(&STICK.replace("end = 0.2 ", "end = 1e6 "));
    let mut child = program()
        .args(["run", "--solver", "nsgs", "--out"])
        .args([&bench.results(), &scene])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    let drafts = || {
        bench
            .contents()
            .into_iter()
            .filter(|(path, bytes)| path.to_string_lossy().contains(".partial-") && bytes.len() > 1 << 17)
    };
    let clock = Instant::now();
    while drafts().count() == 0 {
        assert!(clock.elapsed() < Duration::from_secs(120), "the run writes nothing");
        assert!(child.try_wait().expect("the child").is_none(), "the run ended by itself");
        std::thread::sleep(Duration::from_millis(20));
    }
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(sent.success());
    let output = child.wait_with_output().expect("ends");
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));

    let summary = bench.summary();
    let runs = summary["runs"].as_array().expect("a list");
    assert_eq!(runs.len(), 1, "the second law is not started");
    assert_eq!(runs[0]["stopped"], "interrupted");
    let steps = runs[0]["steps"].as_u64().expect("a count");
    assert!(steps > 0);
    for name in ["trajectory.csv", "energy.csv"] {
        let rows = table(&bench.results().join(name));
        assert_eq!(rows.len() as u64, steps + 2, "header, initial state and {steps} steps in {name}");
    }
    let contacts = table(&bench.results().join("contacts.csv"));
    assert!(contacts.iter().all(|row| row.len() == contacts[0].len()));
    let left = bench.contents().into_keys().filter(|path| path.to_string_lossy().contains(".partial-"));
    assert_eq!(left.count(), 0, "a draft was left behind");
}

#[test]
fn the_lists_name_every_law_and_every_solver() {
    let laws = program().arg("laws").output().expect("starts");
    assert_eq!(laws.status.code(), Some(0));
    let shown = text(&laws.stdout);
    for law in nonsmooth::laws::LAWS {
        for part in [law.name, law.title, law.equation, law.claim, law.reference] {
            assert!(shown.contains(part), "`{part}` is missing in: {shown}");
        }
        for parameter in law.parameters {
            assert!(shown.contains(parameter.name) && shown.contains(parameter.meaning));
        }
    }
    let solvers = program().arg("solvers").output().expect("starts");
    assert_eq!(solvers.status.code(), Some(0));
    let shown = text(&solvers.stdout);
    for solver in nonsmooth::solver::SOLVERS {
        for part in [solver.name, solver.title, solver.when, solver.reference] {
            assert!(shown.contains(part), "`{part}` is missing in: {shown}");
        }
    }
    assert!(shown.contains(&format!("{} (default)", nonsmooth::solver::DEFAULT)));
}

#[test]
fn help_names_the_commands_and_every_option() {
    let help = program().arg("--help").output().expect("starts");
    assert_eq!(help.status.code(), Some(0));
    for command in ["run", "laws", "solvers"] {
        assert!(text(&help.stdout).contains(command));
    }
    let help = program().args(["run", "--help"]).output().expect("starts");
    assert_eq!(help.status.code(), Some(0));
    for option in ["--law", "--solver", "--theta", "--step", "--end", "--tol", "--out"] {
        assert!(text(&help.stdout).contains(option), "{option}");
    }
    let nothing = program().output().expect("starts");
    assert_eq!(nothing.status.code(), Some(2));
    assert!(text(&nothing.stderr).contains("Usage"));
}

const BALL: &str = include_str!("../examples/bouncing_ball.toml");

#[test]
fn error_control_is_asked_for_in_the_scene_or_on_the_command_line() {
    let bench = Bench::new();
    let adaptive = BALL.replace("step = 1e-4 ", "step = \"adaptive\"\ntolerance = 1e-3 ");
    for (text, arguments, tolerance) in
        [(adaptive.as_str(), &[][..], 1e-3), (BALL, &["--adaptive", "1e-5"][..], 1e-5)]
    {
        let scene = bench.scene(text);
        let mut command = program();
        command.arg("run").arg(&scene).arg("--out").arg(bench.results()).arg("--no-figures").args(arguments);
        let output = command.output().expect("the program runs");
        assert!(output.status.success(), "{}", self::text(&output.stderr));
        let summary: Value =
            serde_json::from_slice(&fs::read(bench.results().join("summary.json")).expect("a summary"))
                .expect("JSON");
        for run in summary["runs"].as_array().expect("two runs") {
            let control = &run["adaptive"];
            assert_eq!(control["tolerance"].as_f64(), Some(tolerance));
            let steps = run["steps"].as_u64().expect("a number");
            assert_eq!(control["accepted"].as_u64(), Some(steps));
            assert!(
                steps < 100 && control["rejected"].as_u64().is_some_and(|rejected| rejected > 0),
                "{control}"
            );
            assert!(control["estimated_error"].as_f64().is_some_and(|error| error <= tolerance), "{control}");
        }
        // The last row of the trajectory is at the end, and there is one for the start and for every step.
        let rows = fs::read_to_string(bench.results().join("trajectory.csv")).expect("a table");
        assert!(rows.lines().last().is_some_and(|row| row.contains(",2.0,")), "{rows}");
        assert!(self::text(&output.stdout).contains("steps kept of"), "{}", self::text(&output.stdout));
    }
    for option in ["--checkpoint=10", "--resume=results"] {
        let output = program().arg("run").arg(bench.scene(&adaptive)).arg(option).output().expect("it runs");
        assert_eq!(output.status.code(), Some(2));
        assert!(self::text(&output.stderr).contains("leave no checkpoint"), "{}", self::text(&output.stderr));
    }
    let output =
        program().arg("run").arg(bench.scene(BALL)).args(["--adaptive", "0"]).output().expect("it runs");
    assert_eq!(output.status.code(), Some(2));
    assert!(
        self::text(&output.stderr).contains("the tolerance of adaptive steps is 0e0"),
        "{}",
        self::text(&output.stderr)
    );
}
