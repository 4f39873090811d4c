//! The page of a run: what is in it, that it is small, that it needs nothing else, and that a browser shows it.

mod outcome;
#[path = "page/mod.rs"]
mod page;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use nonsmooth::observe::{Frame, MOST_FRAMES, ObserveError, Observer};
use nonsmooth::run::{Checkpoints, WriteOptions};
use nonsmooth::scalar::Scalar;
use nonsmooth::scene::Scene;
use nonsmooth::simulate::Sink;
use outcome::{Bench, ball, stderr};
use page::{Page, marbles, split};

/// x, y and the angle of the first body, by time, from the table of a run.
fn trajectory(bench: &Bench) -> Vec<(f64, [f64; 3])> {
    let table = std::fs::read_to_string(bench.results().join("trajectory.csv")).expect("a table");
    let number = |cell: &str| cell.parse::<f64>().expect("a number");
    let row = |row: &str| {
        let cells: Vec<&str> = row.split(',').collect();
        (number(cells[3]), [4, 5, 6].map(|column| number(cells[column])))
    };
    table.lines().skip(1).map(row).collect()
}

#[test]
fn a_page_has_the_motion_of_the_run() {
    let bench = Bench::new();
    let scene = ball(1.1, 0.5, "step = 1e-3\nend = 1.9").replace("position", "spin = 3.0\nposition");
    let output = bench.run(&scene, &[]);
    assert!(output.status.success(), "{}", stderr(&output));
    let page = Page::read(&bench.results().join("newton.html"));
    assert_eq!(page.head["title"], "Ball");
    assert_eq!((page.bodies, page.head["shapes"]["planar"].as_bool()), (1, Some(true)));
    // 1,900 steps: every fourth, and the first.
    assert_eq!(page.frames, 476);
    let states = trajectory(&bench);
    assert_eq!(page.times.last(), states.last().map(|(time, _)| time));
    let quantum = page.grids[0][3];
    assert!(quantum < 2e-5, "{quantum}");
    for (k, time) in page.times.iter().enumerate() {
        let (_, [x, y, angle]) = states.iter().find(|(t, _)| t == time).expect("a step of the run");
        let (position, turn) = page.pose(k, 0);
        for (found, wanted) in position.into_iter().zip([*x, *y, 0.0]) {
            assert!((found - wanted).abs() < 0.6 * quantum + 1e-6, "{time}: {found}, {wanted}");
        }
        let across = (0.5 * angle).cos() * turn[0] + (0.5 * angle).sin() * turn[3];
        assert!(
            across.abs() > 1.0 - 1e-8 && turn[1].abs() < 2e-5 && turn[2].abs() < 2e-5,
            "{time}: {turn:?}"
        );
    }
    // No percussion is lost by thinning: together they took the weight and turned the ball round.
    let pushed: f64 = page.forces.iter().flatten().map(|(_, force)| f64::from(force[1])).sum();
    let table = std::fs::read_to_string(bench.results().join("contacts.csv")).expect("a table");
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let column = rows.headers().expect("a header").iter().position(|name| name == "p_N").expect("p_N");
    let given = |row: csv::StringRecord| row[column].parse::<f64>().expect("a number");
    let wanted: f64 = rows.records().map(|row| given(row.expect("a row"))).sum();
    assert!(wanted > 1.0 && (pushed - wanted).abs() < 1e-3 * wanted, "{pushed}, {wanted}");
    // The energies are those of the table.
    let total: f64 = page.energies.iter().map(|energy| energy[0]).sum();
    assert!((total - 22.045).abs() < 1e-9, "{total}");
}

#[test]
fn a_page_needs_nothing_else_and_can_be_left_out() {
    let bench = Bench::new();
    let scene = ball(0.3, 0.0, "step = 1e-2\nend = 0.1").replace("\"Ball\"", "\"A <b> & \\\"c\\\"\"");
    bench.summary(&scene, &[]);
    let text = std::fs::read_to_string(bench.results().join("newton.html")).expect("a page");
    let (before, data, after) = split(&text);
    for outside in ["http", "src=", "import ", "@import", "url(", "fetch(", "{{"] {
        assert!(!before.contains(outside) && !after.contains(outside), "{outside}");
    }
    assert!(data.bytes().all(|b| b.is_ascii_alphanumeric() || b"+/=".contains(&b)));
    assert!(before.contains("<title>A &lt;b&gt; &amp; &quot;c&quot; – newton</title>"));

    // Left out by either switch, and what an earlier run left is taken away.
    bench.summary(&scene, &["--no-figures"]);
    assert!(!bench.files().contains("newton.html"));
    bench.summary(&scene, &[]);
    assert!(bench.files().contains("newton.html"));
    bench.summary(&scene.replace("[time]", "[output]\nhtml = false\n[time]"), &[]);
    assert!(!bench.files().contains("newton.html") && bench.files().contains("newton.svg"));
}

#[test]
fn what_has_no_bodies_has_no_page() {
    let bench = Bench::new();
    bench.summary(include_str!("../examples/woodpecker.toml"), &["--end", "0.1"]);
    let files = bench.files();
    assert!(files.iter().all(|name| !name.ends_with(".html")), "{files:?}");
}

#[test]
fn the_marbles_are_small_and_right() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("marbles.html");
    // More steps than frames: 1,999 is no multiple of four, and the last step is there all the same.
    let (seconds, seen) = marbles(1000, 1999, &path);
    let bytes = std::fs::metadata(&path).expect("a page").len();
    let page = Page::read(&path);
    println!("{} frames of {} bodies: {bytes} bytes, {:.2} ms a frame", page.frames, page.bodies, {
        1e3 * seconds / page.frames as f64
    });
    assert_eq!((page.bodies, page.frames), (1000, MOST_FRAMES + 1));
    assert!(bytes <= 10_000_000, "{bytes} bytes");
    // One geometry for all, and the floor.
    assert_eq!(page.head["shapes"]["meshes"].as_array().map(Vec::len), Some(2));
    for (k, time) in
        page.times.iter().enumerate().step_by(50).chain([(page.frames - 1, &page.times[page.frames - 1])])
    {
        for body in (0..1000).step_by(7) {
            let (wanted, turned) = seen(body, *time);
            let (position, turn) = page.pose(k, body);
            let quantum = page.grids[body][3];
            for (found, wanted) in position.into_iter().zip(wanted) {
                assert!((found - wanted).abs() < 0.6 * quantum, "{body} at {time}: {found}, {wanted}");
            }
            let across: f64 = turn.iter().zip(turned).map(|(a, b)| a * b).sum();
            // 1 − cos of half the angle between them.
            assert!(across.abs() > 1.0 - 1e-8, "{body} at {time}: {turn:?}, {turned:?}");
        }
    }
}

/// Raises a flag at a step.
struct Stop(usize, Arc<AtomicBool>);

impl<T: Scalar, const D: usize> Observer<T, D> for Stop {
    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        if frame.state.index == self.0 {
            self.1.store(true, Ordering::Relaxed);
        }
        Ok(())
    }
}

#[test]
fn a_resumed_run_has_the_whole_motion() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = ball(1.1, 0.5, "step = 1e-3\nend = 1.9").replace("[\"newton\"]", "[\"newton\", \"moreau\"]");
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).expect("a scene");
    let scene = Scene::read(&path).expect("a scene");
    let registry = nonsmooth::registry();
    let page = |name: &str, law: &str| std::fs::read(folder.path().join(name).join(law)).expect("a page");
    let options = |name: &str| WriteOptions::new(folder.path().join(name));
    let mut alone = |_: &_| Box::new(Stop(usize::MAX, Arc::default())) as Box<dyn Sink>;
    let go = AtomicBool::new(false);
    scene.write(&registry, &options("whole"), &mut alone, &go).expect("a run");
    for (law, at) in [("newton", 777), ("moreau", 1234)] {
        let name = format!("resumed-{law}");
        let raised = Arc::new(AtomicBool::new(false));
        let mut stop = |run: &nonsmooth::scene::PlannedRun| {
            Box::new(Stop(if run.law == law { at } else { usize::MAX }, raised.clone())) as Box<dyn Sink>
        };
        let every = options(&name).checkpoints(Checkpoints::Every(100));
        assert!(scene.write(&registry, &every, &mut stop, &raised).expect("a part of a run").interrupted);
        let part = Page::read(&folder.path().join(&name).join(format!("{law}.html")));
        assert_eq!(part.times.last().map(|t| (t * 1e3).round()), Some(at as f64), "what was done is shown");
        let again = options(&name).checkpoints(Checkpoints::Resume);
        scene.write(&registry, &again, &mut alone, &go).expect("the rest");
        for law in ["newton.html", "moreau.html"] {
            assert!(page("whole", law) == page(&name, law), "{law} differs in {name}");
        }
    }
}

/// A browser, where there is one.
fn browser() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    let all = names.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    all.into_iter().find(|path| path.is_file())
}

/// The page as a browser leaves it, and a picture of it where a file for one is given.
fn shown(browser: &Path, page: &Path, hash: &str, picture: Option<&Path>) -> String {
    let profile = tempfile::tempdir().expect("a folder");
    let mut command = Command::new(browser);
    command.args(["--headless", "--no-sandbox", "--disable-gpu-sandbox", "--use-angle=swiftshader"]);
    command.args(["--enable-unsafe-swiftshader", "--hide-scrollbars", "--window-size=1200,860"]);
    command.args(["--virtual-time-budget=10000", "--disable-background-networking"]);
    command.arg(format!("--user-data-dir={}", profile.path().display()));
    match picture {
        Some(picture) => command.arg(format!("--screenshot={}", picture.display())),
        None => command.arg("--dump-dom"),
    };
    command.arg(format!("file://{}{hash}", page.display()));
    let output = command.output().expect("the browser starts");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The value of an attribute of the root of a page.
fn attribute(dom: &str, name: &str) -> Option<String> {
    let root = &dom[dom.find("<html")?..];
    let root = &root[..root.find('>')?];
    let value = root.split(&format!("{name}=\"")).nth(1)?;
    value.split('"').next().map(String::from)
}

#[test]
fn a_browser_shows_the_page() {
    let Some(browser) = browser() else {
        println!("skipped: no browser");
        return;
    };
    let bench = Bench::new();
    let output =
        bench.run(include_str!("../examples/rocking_block.toml"), &["--end", "1.0", "--step", "1e-3"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let marbles_page = bench.0.path().join("marbles.html");
    marbles(60, 100, &marbles_page);
    for (path, frames) in [(bench.results().join("newton.html"), 502), (marbles_page.clone(), 101)] {
        for hash in ["", "#t=0.3&theme=dark"] {
            let dom = shown(&browser, &path, hash, None);
            let start: String = dom.chars().take(300).collect();
            assert_eq!(attribute(&dom, "data-error"), None, "{}{hash}", path.display());
            let ready = attribute(&dom, "data-ready").and_then(|x| x.parse::<usize>().ok());
            let ready = ready.unwrap_or_else(|| panic!("{}{hash} is not ready: {start}", path.display()));
            assert!(ready > frames / 2 && ready <= frames, "{ready} frames");
        }
    }
    // An error in the page does not go unseen.
    let text = std::fs::read_to_string(bench.results().join("newton.html")).expect("a page");
    let broken = bench.0.path().join("broken.html");
    std::fs::write(
        &broken,
        text.replace("function drawCurves() {", "function drawCurves() { nothing.there();"),
    )
    .expect("a page");
    let dom = shown(&browser, &broken, "", None);
    assert!(
        attribute(&dom, "data-error").is_some_and(|error| error.contains("nothing")),
        "the error is told"
    );
    // PICTURES=folder keeps pictures, for people to look at.
    if let Some(folder) = std::env::var_os("PICTURES").map(PathBuf::from) {
        std::fs::create_dir_all(&folder).expect("a folder");
        let page = bench.results().join("newton.html");
        shown(&browser, &page, "#t=0.3", Some(&folder.join("rocking_block.png")));
        shown(&browser, &marbles_page, "#t=0.8", Some(&folder.join("marbles.png")));
    }
}
