//! Studies: orders against references, the same numbers whatever kills them and whoever shares the work, and files that
//! are none.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use nonsmooth::scene::{Scene, contact_dimension, event_driven};
use nonsmooth::study::{
    Line, MEASURES, ProblemResults, SceneResults, Study, StudyError, StudyOptions, StudyProgress,
};

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples")
}

/// A folder of one test with a study in it.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    /// A study of an example scene; `text` stands below its title and scene.
    fn new(scene: &str, text: &str) -> Self {
        let bench = Self { folder: tempfile::tempdir().expect("a temporary folder") };
        let scene = examples().join(scene).with_extension("toml");
        bench.write(&format!("title = \"Test\"\nscene = '{}'\n{text}", scene.display()));
        bench
    }

    fn write(&self, study: &str) {
        std::fs::write(self.study(), study).expect("a study");
    }

    fn study(&self) -> PathBuf {
        self.folder.path().join("study.toml")
    }

    fn out(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs the study into a folder, writes its tables, and tells how far it was from the beginning on.
    fn run(&self, out: &str, threads: usize) -> (SceneResults, StudyProgress) {
        let Study::Scene(study) =
            Study::read(&self.study(), &nonsmooth::registry()).unwrap_or_else(|error| panic!("{error}"))
        else {
            panic!("a study of a scene");
        };
        let (mut first, never) = (None, AtomicBool::new(false));
        let results = study
            .run(&self.out(out), &options(threads), &never, &mut |progress| {
                first.get_or_insert(progress);
            })
            .unwrap_or_else(|error| panic!("{error}"));
        results.write_csv(&self.out(out)).expect("a writable folder");
        (results, first.expect("told at the start"))
    }

    /// `runs.csv` without the three columns of times, and `orders.csv`.
    fn tables(&self, out: &str) -> (String, String) {
        let read = |name: &str| std::fs::read_to_string(self.out(out).join(name)).expect(name);
        (untimed(&read("runs.csv"), 3), read("orders.csv"))
    }
}

/// Errors alone are looked at: nothing is repeated for its time.
fn options(threads: usize) -> StudyOptions {
    StudyOptions { threads, timed: 0.0, ..StudyOptions::default() }
}

/// A table without its last columns.
fn untimed(table: &str, columns: usize) -> String {
    let cut = |line: &str| line.rsplitn(columns + 1, ',').last().unwrap_or_default().to_string() + "\n";
    table.lines().map(cut).collect()
}

const STICK: &str =
    "reference = { kind = \"event-driven\" }\n[[runs]]\nlaw = [\"newton\", \"fremond\"]\nsolver = \"nsgs\"\n";

fn find<'a>(lines: &'a [Line], words: &str) -> &'a Line {
    lines.iter().find(|line| line.label == words).unwrap_or_else(|| {
        panic!("no line `{words}` among {:?}", lines.iter().map(|line| &line.label).collect::<Vec<_>>())
    })
}

#[test]
fn the_stick_converges_at_first_order_until_single_precision_ends() {
    let text =
        format!("{STICK}scalar = [\"f64\", \"f32\"]\nh = {{ from = 1e-2, to = 1e-5, per_decade = 12 }}\n");
    let (results, _) = Bench::new("impacting_stick", &text).run("out", 2);
    assert!(results.complete() && results.rows.len() == 4 * 36, "{} runs", results.rows.len());
    let lines = results.lines();
    for law in ["newton", "fremond"] {
        let [double, single] = ["f64", "f32"].map(|scalar| find(&lines, &format!("{law}, {scalar}")));
        // The published constant of q; that of v, 6, is of the ends of the steps: the steps of the two impacts add up to
        // their jumps of the spin, 1.6 and 1.9 rad/s.
        for (measure, constant) in MEASURES[..2].iter().zip([1.8, 6.0 + 3.5]) {
            let order = double.order(measure).expect("36 runs");
            let place = format!("{law}: {}: {order:?}", measure.name);
            // The saw-tooth spreads ln(error) by about 0.8, 36 steps over three decades the slope by 0.07: two of it.
            assert!((order.slope - 1.0).abs() <= 0.15 && order.nominal == 1.0, "{place}");
            assert!(order.constant <= constant, "{place}");

            // Down to 1e-3 the arithmetic does not show; at 1e-5 rounding, ε √(steps) on a position of 1 m and more by
            // what impacts make of it, is far above h.
            let bins = |line: &Line| line.envelope(measure);
            for (a, b) in bins(double).iter().zip(bins(single)).filter(|(a, _)| a.step > 1e-3) {
                assert!((a.error / b.error).ln().abs() < 0.05, "{law}: {}: {a:?}, f32 {b:?}", measure.name);
            }
            let last = |line: &Line| bins(line).last().expect("bins").error;
            assert!(last(single) > 3.0 * last(double), "{law}: {}: a floor", measure.name);
        }
    }
}

#[test]
fn adaptive_runs_stand_beside_those_of_fixed_steps() {
    let text = format!(
        "{STICK}epsilon = [1e-2, 1e-3, 1e-4, 1e-5]\nh = {{ from = 1e-3, to = 1e-4, per_decade = 4 }}\n"
    );
    let (results, _) = Bench::new("impacting_stick", &text).run("out", 2);
    assert!(results.complete() && results.rows.len() == 2 * (4 + 4));
    let lines = results.lines();
    for law in ["newton", "fremond"] {
        let adaptive = find(&lines, &format!("{law}, adaptive"));
        assert!(adaptive.adaptive && !find(&lines, law).adaptive);
        for point in &adaptive.points {
            // ε is a share of the scene's length, a metre at most; three of it are promised.
            assert!(
                point.errors.q <= 3.0 * point.value && point.errors.v <= 3.0 * point.value,
                "{law}: {point:?}"
            );
            assert!(point.step > 1e-3, "long flights are few steps: {point:?}");
        }
    }
    assert!(!results.order_figure().svg().expect("a figure").contains("adaptive"));
    assert!(results.speed_figure().svg().expect("a figure").contains("newton, adaptive"));
}

#[test]
fn the_closed_form_of_the_ball_is_its_event_driven_motion() {
    // Off the vertical, on a slope, with a spin and a radius; θ = 1/(1 + e), the claim of the law.
    let scene = "title = \"Ball\"\nlaws = [\"moreau\"]\ngravity = [0.3, -10.0]\n[time]\nstep = 1e-3\nend = 2.0\n\
        [[bodies]]\nname = \"ball\"\nmass = 2.0\ninertia = 0.3\nposition = [0.1, 0.9]\nvelocity = [0.2, 0.4]\nspin = 1.0\n\
        [[bodies.discs]]\nname = \"d\"\nradius = 0.1\n[[half_planes]]\nname = \"floor\"\nnormal = [-0.2, 1.0]\n\
        [[interfaces]]\nbetween = [\"ball\", \"floor\"]\nparameters = { restitution = 0.6 }\n";
    let bench = Bench::new("bouncing_ball", "");
    let path = bench.out("ball.toml");
    std::fs::write(&path, scene).expect("a scene");
    // Measured against each other by a run: the errors of one against both references are the same.
    let errors = ["bouncing-ball", "event-driven"].map(|kind| {
        bench.write(&format!(
            "title = \"Ball\"\nscene = '{}'\nreference = {{ kind = \"{kind}\" }}\n[[runs]]\ntheta = 0.625\nh = [1e-2, 1e-3]\n",
            path.display()
        ));
        bench.run(kind, 1).0
    });
    let [closed, driven] = &errors;
    assert!(closed.complete() && driven.complete());
    for (a, b) in closed.rows.iter().zip(&driven.rows) {
        for measure in MEASURES {
            let [a, b] = [a, b].map(|row| (measure.absolute)(&row.outcome.errors));
            // The integrator lets the ball rest where its speed is 1e-13 of the scene's, 1e-12 s too early: m g 1e-12 s
            // of percussion.
            assert!(
                a.is_finite() && a > 0.0 && (a - b).abs() <= 1e-9 * a + 2e-11,
                "{}: {a}, {b}",
                measure.name
            );
        }
    }
}

#[test]
fn the_bar_approaches_the_continuum_as_mesh_and_step_are_refined() {
    let text = "reference = { kind = \"impacting-bar\" }\n[[runs]]\nlaw = \"fremond\"\nh = 1e-3\n\
                \"solid.mesh.elements\" = [25, 50, 100, 200]\n";
    let (results, _) = Bench::new("impacting_bar", text).run("out", 2);
    assert!(results.complete());
    for measure in &MEASURES[..3] {
        let errors: Vec<f64> =
            results.rows.iter().map(|row| (measure.relative)(&row.outcome.errors)).collect();
        // Fronts are smeared over some elements: q is of first order in Δx at best and v of order ½, and at least half of
        // that is seen over a factor of 8.
        let order = (errors[0] / errors[3]).ln() / 8.0_f64.ln();
        assert!(order > 0.25, "{}: {errors:?}", measure.name);
        assert!(errors[3] < 0.1, "{}: {errors:?}", measure.name);
    }
}

#[test]
fn the_finest_run_stands_in_for_a_reference() {
    let steps = "h = { from = 1e-2, to = 1e-3, per_decade = 6 }\n";
    let exact = Bench::new("impacting_stick", &format!("{STICK}{steps}")).run("out", 2).0;
    let h = 2e-5;
    let text =
        format!("{STICK}{steps}").replace("kind = \"event-driven\"", &format!("kind = \"finest\", h = {h}"));
    let finest = Bench::new("impacting_stick", &text).run("out", 2).0;
    for (a, b) in exact.rows.iter().zip(&finest.rows) {
        // The finest run is itself as far from the motion as the constants of the stick say.
        for (measure, constant) in MEASURES[..2].iter().zip([1.8, 9.5]) {
            let [a, b] = [a, b].map(|row| (measure.absolute)(&row.outcome.errors));
            assert!((a - b).abs() <= constant * h, "{}: {a} against the motion, {b}", measure.name);
            assert!(a > 5.0 * (a - b).abs(), "{}: {a}, {b}", measure.name);
        }
    }
}

#[test]
fn two_threads_give_the_numbers_of_one() {
    let text = format!(
        "{STICK}scalar = [\"f64\", \"f32\"]\nh = {{ from = 1e-2, to = 1e-4, per_decade = 5 }}\n\
         \"interfaces.0.parameters.friction\" = [0.01, 0.3]\n\"time.activation\" = [\"moreau-jean\", \"predicted-gap\"]\n"
    );
    let bench = Bench::new("impacting_stick", &text);
    for (out, threads) in [("one", 1), ("two", 2), ("more", 5)] {
        assert!(bench.run(out, threads).0.complete());
    }
    let one = bench.tables("one");
    assert_eq!(one.0.lines().count(), 1 + 2 * 2 * 10 * 2 * 2);
    assert_eq!(one, bench.tables("two"));
    assert_eq!(one, bench.tables("more"));
}

/// Lines of the journal, the last perhaps half written.
fn journal(out: &Path) -> Vec<u8> {
    std::fs::read(out.join("journal.csv")).unwrap_or_default()
}

#[test]
fn a_study_killed_at_any_moment_ends_with_the_same_table() {
    let text = format!("{STICK}h = {{ from = 1e-2, to = 1e-4, per_decade = 12 }}\n");
    let bench = Bench::new("impacting_stick", &text);
    bench.run("whole", 2);

    let killed = bench.out("killed");
    let program = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_nonsmooth"));
        command.arg("study").arg(bench.study()).arg("--out").arg(&killed).arg("--no-figures");
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        command
    };
    let mut kills = 0;
    for (wait, more) in [(1, 0), (5, 3), (11, 11), (20, 30)] {
        let mut child = program().spawn().expect("the program starts");
        let clock = Instant::now();
        let lines = || journal(&killed).iter().filter(|&&byte| byte == b'\n').count();
        while lines() < wait && clock.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(more));
        kills += usize::from(child.try_wait().expect("a child").is_none());
        let _gone = child.kill();
        child.wait().expect("a child ends");
    }
    assert!(kills >= 2, "the study lived long enough to be killed: {kills} times");
    // Killed in the middle of a line, too.
    let mut bytes = journal(&killed);
    let whole = bytes.len();
    bytes.truncate(whole - 7);
    std::fs::write(killed.join("journal.csv"), bytes).expect("a writable folder");

    let output = program().output().expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(bench.tables("whole"), bench.tables("killed"), "after {kills} kills");
    // All is known now, and nothing of it is done again.
    assert_eq!(bench.run("killed", 1).1.known, 2 * 24);
}

#[test]
fn an_interrupted_study_ends_in_order_and_goes_on() {
    let text = format!("{STICK}h = {{ from = 1e-2, to = 1e-3, per_decade = 12 }}\n");
    let bench = Bench::new("impacting_stick", &text);
    bench.run("whole", 1);
    let Ok(Study::Scene(study)) = Study::read(&bench.study(), &nonsmooth::registry()) else {
        panic!("a study of a scene")
    };
    let stop = AtomicBool::new(false);
    let results = study.run(&bench.out("interrupted"), &options(2), &stop, &mut |progress| {
        stop.store(progress.done >= 5, Ordering::Relaxed);
    });
    let results = results.expect("an orderly end");
    assert!(results.missing > 0 && results.rows.len() >= 5 && !results.complete());
    let (results, progress) = bench.run("interrupted", 2);
    assert!(progress.known >= 5 && results.missing == 0);
    assert_eq!(bench.tables("whole"), bench.tables("interrupted"));
}

#[test]
fn a_changed_study_makes_again_what_changed() {
    let study = |friction: f64, steps: &str| {
        format!("{STICK}h = [{steps}]\n\"interfaces.0.parameters.friction\" = {friction}\n")
    };
    let bench = Bench::new("impacting_stick", &study(0.01, "1e-2, 1e-3"));
    assert_eq!(bench.run("out", 1).1.known, 0);
    let again = |text: &str| {
        let scene = examples().join("impacting_stick.toml");
        bench.write(&format!("title = \"Another title\"\nscene = '{}'\n{text}", scene.display()));
        bench.run("out", 1).1.known
    };
    assert_eq!(again(&study(0.01, "2e-2, 1e-2, 1e-3, 5e-4")), 4, "two steps under two laws");
    assert_eq!(again(&study(0.02, "1e-2, 1e-3")), 0);
    assert_eq!(again(&study(0.01, "1e-2")), 2, "what was known is not forgotten");
    let finest = study(0.01, "1e-2").replace("kind = \"event-driven\"", "kind = \"finest\", h = 1e-4");
    assert_eq!(again(&finest), 0, "errors against another reference");
}

#[test]
fn a_run_that_fails_is_a_row_with_its_message() {
    // At e = 1 a θ beyond ½ is in the claim of no law.
    let text = "reference = { kind = \"event-driven\" }\n[[runs]]\nlaw = \"fremond\"\ntheta = [0.5, 0.75]\nh = [1e-2, 1e-3]\n";
    let bench = Bench::new("impacting_stick", text);
    let (results, _) = bench.run("out", 2);
    assert!(!results.complete() && results.missing == 0);
    let ok: Vec<bool> = results.rows.iter().map(|row| row.outcome.ok).collect();
    assert_eq!(ok, [true, true, false, false]);
    assert!(results.rows[2].outcome.message.contains("0.75"), "{}", results.rows[2].outcome.message);
    assert_eq!(results.lines().len(), 1);
    let mut table = Vec::new();
    results.write_table(&mut table).expect("memory");
    assert!(String::from_utf8(table).expect("UTF-8").contains("2 of 4 runs failed"));
}

#[test]
fn figures_tell_every_line_and_its_order() {
    let text = format!(
        "mark = {{ label = \"marked\", law = \"fremond\" }}\n{STICK}scalar = [\"f64\", \"f32\"]\n\
         h = {{ from = 1e-2, to = 1e-3, per_decade = 4 }}\n"
    );
    let (results, _) = Bench::new("impacting_stick", &text).run("out", 2);
    let speed = results.speed_figure().svg().expect("a figure");
    assert!(["newton", "fremond (marked)", "dotted: f32"].iter().all(|words| speed.contains(words)));
    let order = results.order_figure().svg().expect("a figure");
    let slope = find(&results.lines(), "newton, f64").order(&MEASURES[0]).expect("4 runs").slope;
    assert!(order.contains(&format!("newton: {slope:.2} (f32: ")));
}

#[test]
fn figures_name_the_time_of_their_scene() {
    let scene = std::fs::read_to_string(examples().join("impacting_stick.toml")).expect("an example");
    let bench = Bench::new("impacting_stick", "");
    std::fs::write(bench.folder.path().join("scene.toml"), format!("units = \"mm-ms-g\"\n{scene}"))
        .expect("a scene");
    bench.write("title = \"Test\"\nscene = \"scene.toml\"\n[[runs]]\nh = { from = 1e-2, to = 1e-3, per_decade = 4 }\n");
    let (results, _) = bench.run("out", 1);
    let order = results.order_figure().svg().expect("a figure");
    assert!(order.contains("h (ms)") && !order.contains("h (s)"));
    assert!(results.speed_figure().svg().expect("a figure").contains("CPU time (s)"));
}

/// The message of a study that cannot be read.
fn refused(bench: &Bench, study: &str) -> StudyError {
    bench.write(study);
    Study::read(&bench.study(), &nonsmooth::registry()).expect_err(study)
}

#[test]
fn a_file_that_is_no_study_is_refused_with_its_place() {
    let bench = Bench::new("impacting_stick", "");
    let head = format!("title = \"t\"\nscene = '{}'\n", examples().join("impacting_stick.toml").display());
    // What stands below the first two lines, where the fault is, and a word of the message.
    let cases = [
        ("[[runs]]\nh = []", (4, 5), "empty"),
        ("[[runs]]\nh = \"small\"", (4, 5), "not a number"),
        ("[[runs]]\nh = [1e-3, -1e-3]", (4, 5), "time.step"),
        ("[[runs]]\nh = { from = 1e-2, to = 0.0, per_decade = 3 }", (4, 5), "to is 0"),
        ("[[runs]]\nh = { from = 1e-2, to = 1e-3 }", (4, 5), "per_decade"),
        ("[[runs]]\nh = { from = 1e-2, to = 1e-30, per_decade = 1e6 }", (4, 5), "values"),
        ("[[runs]]\ntheta = \"half\"", (4, 9), "not a number"),
        ("[[runs]]\nepsilon = [1e-3, 0.0]", (4, 11), "in (0, 0.5]"),
        ("[[runs]]\n\"time.tolerance\" = 1e-3", (4, 20), "`epsilon`"),
        ("[[runs]]\nlaw = [\"newton\", \"nobody\"]", (4, 7), "nobody"),
        ("[[runs]]\nlaw = 3", (4, 7), "string"),
        ("[[runs]]\nsolver = \"nobody\"", (4, 10), "nobody"),
        ("[[runs]]\nscalar = \"f16\"", (4, 10), "f16"),
        ("[[runs]]\nhh = 1e-3", (4, 6), "hh"),
        ("[[runs]]\n\"time.stop\" = 1.0", (4, 15), "stop"),
        ("[[runs]]\n\"interfaces.1.parameters.friction\" = 1.0", (4, 38), "no `1`"),
        ("[[runs]]\n\"interfaces.0.parameters.friction\" = \"much\"", (4, 38), "friction"),
        ("[[runs]]\n\"title.x\" = 1.0", (4, 13), "no `x`"),
        ("[[runs]]\n\"time.theta\" = 0.5", (4, 16), "`theta`"),
        ("unknown = 1", (3, 1), "unknown"),
        ("[[runs]\n", (3, 8), "array"),
        ("reference = { kind = \"true\" }", (1, 1), "true"),
        ("reference = { kind = \"event-driven\", h = 1e-3 }", (1, 1), "neither"),
        ("mark = { label = \"x\", solve = \"nsgs\" }", (1, 1), "solve"),
        ("problems = \".\"", (1, 1), "either"),
        ("budget = { repeat = 1 }", (1, 1), "budget"),
    ];
    for (text, (line, column), word) in cases {
        let error = refused(&bench, &format!("{head}{text}\n"));
        let message = error.to_string();
        let at = match error {
            StudyError::Parse { line, column, .. } | StudyError::Value { line, column, .. } => (line, column),
            other => panic!("{text}: {other:?}"),
        };
        assert_eq!(at, (line, column), "{text}: {message}");
        assert!(message.contains(word), "{text}: {message}");
    }
    let unused = refused(&bench, &format!("{head}[[runs]]\n\"interfaces.0.parameters.colour\" = 1.0\n"));
    assert!(
        matches!(unused, StudyError::Combination { .. }) && unused.to_string().contains("colour"),
        "{unused}"
    );
    let twice = refused(&bench, &format!("{head}[[runs]]\nh = [1e-3]\n[[runs]]\nh = [1e-2, 1e-3]\n"));
    assert!(matches!(twice, StudyError::Twice { .. }), "{twice}");
    let list = "[0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]";
    let keys = ["bodies.0.mass", "bodies.0.inertia", "bodies.0.spin", "bodies.0.torque", "time.end"];
    let many: String =
        keys.iter().map(|key| format!("\"{key}\" = {}\n", list.replace("0.0", "1.0"))).collect();
    let many = refused(
        &bench,
        &format!("{head}[[runs]]\n{many}h = {{ from = 1e-2, to = 1e-3, per_decade = 20 }}\n"),
    );
    assert!(matches!(many, StudyError::TooMany { .. }), "{many}");
    let absent = refused(&bench, "title = \"t\"\nscene = \"nowhere.toml\"\n");
    assert!(matches!(absent, StudyError::Io { .. }) && absent.to_string().contains("nowhere"), "{absent}");
}

#[test]
fn a_reference_that_does_not_know_the_motion_says_what_it_knows() {
    for (kind, scene) in [
        ("bouncing-ball", "impacting_bar"),
        ("impacting-bar", "bouncing_ball"),
        ("event-driven", "double_pendulum"),
    ] {
        let text = format!("reference = {{ kind = \"{kind}\" }}\n[[runs]]\nlaw = \"newton\"\nh = 1e-2\n");
        let bench = Bench::new(scene, &text);
        let Ok(Study::Scene(study)) = Study::read(&bench.study(), &nonsmooth::registry()) else {
            panic!("{kind}: a study")
        };
        let result = study.run(&bench.out("out"), &options(1), &AtomicBool::new(false), &mut |_| {});
        assert!(matches!(result, Err(StudyError::Reference { .. })), "{kind}");
    }
}

#[test]
fn two_studies_do_not_write_into_one_folder() {
    let bench = Bench::new("bouncing_ball", "[[runs]]\nh = [1e-2, 1e-3]\n");
    let Ok(Study::Scene(study)) = Study::read(&bench.study(), &nonsmooth::registry()) else {
        panic!("a study")
    };
    let never = AtomicBool::new(false);
    let mut second = None;
    let first = study.run(&bench.out("out"), &options(1), &never, &mut |_| {
        second.get_or_insert_with(|| study.run(&bench.out("out"), &options(1), &never, &mut |_| {}));
    });
    assert!(first.is_ok());
    assert!(matches!(second, Some(Err(StudyError::Busy { .. }))));
}

#[test]
fn the_example_studies_can_be_read() {
    let folder = examples().join("studies");
    let mut count = 0;
    for entry in std::fs::read_dir(&folder).expect("the studies") {
        let path = entry.expect("readable").path();
        Study::read(&path, &nonsmooth::registry()).unwrap_or_else(|error| panic!("{error}"));
        count += 1;
    }
    assert!(count >= 4);
}

/// A study of two solvers over some of our problems.
fn problems(bench: &Bench, out: &str, threads: usize) -> ProblemResults {
    let Ok(Study::Problems(study)) = Study::read(&bench.study(), &nonsmooth::registry()) else {
        panic!("a study of problems")
    };
    let results = study.run(&bench.out(out), &options(threads), &AtomicBool::new(false), &mut |_| {});
    let results = results.unwrap_or_else(|error| panic!("{error}"));
    results.sweep.write_csv(&bench.out(out)).expect("a writable folder");
    results
}

#[test]
fn solvers_are_swept_over_tolerances_in_both_arithmetics() {
    let bench = Bench::new("impacting_stick", "");
    let folder = bench.out("problems");
    std::fs::create_dir(&folder).expect("a folder");
    for name in ["planar-ten", "planar-slide", "spatial-three", "spatial-ten-global"] {
        let file = format!("{name}.hdf5");
        let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(&file);
        std::fs::copy(from, folder.join(file)).expect("a copy");
    }
    bench.write(
        "title = \"Solvers\"\nproblems = \"problems\"\n[budget]\nprofiles = [1e-3]\n[[runs]]\n\
         solver = [\"hybrid\", \"nsgs\"]\ntolerance = [1e-9, 1e-3, 1e-6]\nscalar = [\"f64\", \"f32\"]\n",
    );
    let results = problems(&bench, "one", 1);
    assert_eq!((results.missing, results.sweep.measurements.len()), (0, 4 * 2 * 3 * 2));
    assert_eq!(results.sweep.tolerances(), [1e-3, 1e-6, 1e-9]);
    for solver in ["hybrid", "nsgs"] {
        for tolerance in [1e-3, 1e-6, 1e-9] {
            let (solved, seconds) = results.sweep.solved((solver, "f64"), tolerance);
            assert!(solved == 4 && seconds.is_some_and(|seconds| seconds > 0.0), "{solver} to {tolerance}");
        }
        // Single precision knows seven digits.
        assert_eq!(results.sweep.solved((solver, "f32"), 1e-3).0, 4, "{solver}");
        assert_eq!(results.sweep.solved((solver, "f32"), 1e-9), (0, None), "{solver}");
    }
    for m in results.sweep.measurements.iter().filter(|m| m.solved) {
        assert!(m.residual <= m.tolerance && m.scaled_residual <= m.tolerance, "{m:?}");
    }
    problems(&bench, "two", 2);
    // The time is the last column.
    let table = |out: &str| std::fs::read_to_string(bench.out(out).join("results.csv")).expect("a table");
    assert_eq!(untimed(&table("one"), 1), untimed(&table("two"), 1));
    // What is known is read back digit by digit.
    let known = table("one");
    problems(&bench, "one", 2);
    assert_eq!(known, table("one"));
    let profile = results.sweep.profile_figure(&[1e-3]).svg().expect("a figure");
    let precision = results.sweep.precision_figure().svg().expect("a figure");
    assert!(profile.contains("f32 to 1e-3") && profile.contains("f64 to 1e-3"));
    assert!(precision.contains("dotted: f32") && precision.contains("nsgs"));
    assert!(results.sweep.residual_figure().svg().expect("a figure").contains("spatial-ten-global"));
}

#[test]
fn a_study_of_problems_that_is_none_is_refused() {
    let bench = Bench::new("impacting_stick", "");
    std::fs::create_dir(bench.out("problems")).expect("a folder");
    for (text, word) in [
        ("[[runs]]\nlaw = \"newton\"", "`solver`, `tolerance` and `scalar`"),
        ("[[runs]]\nsolver = [3]", "names"),
        ("[[runs]]\nsolver = [\"nobody\"]", "nobody"),
        ("[[runs]]\ntolerance = [-1.0]", "tolerance"),
        ("[[runs]]\nscalar = \"f16\"", "neither"),
        ("[[runs]]\nscalar = \"f64\"\n[[runs]]\nscalar = \"f32\"", "one block"),
        ("[budget]\nmax_seconds = 0.0", "max_seconds"),
        ("[budget]\nprofiles = [0.5]", "among"),
        ("reference = { kind = \"finest\" }", "reference"),
    ] {
        let error = refused(&bench, &format!("title = \"t\"\nproblems = \"problems\"\n{text}\n"));
        assert!(
            matches!(error, StudyError::Parse { .. }) && error.to_string().contains(word),
            "{text}: {error}"
        );
    }
    let absent = refused(&bench, "title = \"t\"\nproblems = \"nowhere\"\n");
    assert!(absent.to_string().contains("nowhere"), "{absent}");
}

#[test]
fn a_value_of_the_study_is_a_value_of_the_scene() {
    // A key of a study and the same value in the scene file give the same motion.
    let path = examples().join("impacting_stick.toml");
    let text = std::fs::read_to_string(&path).expect("the scene");
    let changed = Scene::parse(&text.replace("friction = 0.01", "friction = 0.3"), &path).expect("a scene");
    let runs = changed.runs(&nonsmooth::registry()).expect("two laws");
    assert_eq!(contact_dimension(&changed, &runs, &nonsmooth::registry()).expect("laws"), 2);
    let motion = event_driven::<2>(&changed, &runs[0], &nonsmooth::registry())
        .expect("a scene")
        .integrate(&Default::default());
    let motion = motion.expect("a motion");
    let study = "reference = { kind = \"event-driven\" }\n[[runs]]\nlaw = \"newton\"\nh = 1e-4\n\
                 \"interfaces.0.parameters.friction\" = [0.3]\n";
    let (results, _) = Bench::new("impacting_stick", study).run("out", 1);
    let errors = &results.rows[0].outcome.errors;
    let percussion = motion.percussion(changed.time.end)[0];
    let scale = errors.percussion / errors.percussion_relative;
    assert!((scale - percussion).abs() <= 1e-9 * percussion, "{scale}, {percussion}");
    assert!(errors.q <= 1e-3, "{errors:?}");
}
