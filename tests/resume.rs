//! A run that is killed goes on from its last checkpoint, and ends as if nothing had happened.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn nonsmooth() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_nonsmooth"));
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

fn run(arguments: &[&str]) {
    let output = nonsmooth().args(arguments).output().expect("the program starts");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Starts a run, waits until a checkpoint newer than `seen` stands, lets it go on for `more`, and kills it (SIGKILL).
/// Returns whether it was still alive to be killed.
fn kill_after_checkpoint(arguments: &[&str], folder: &Path, seen: Option<u64>, more: Duration) -> bool {
    let mut child = nonsmooth().args(arguments).spawn().expect("the program starts");
    let clock = Instant::now();
    while checkpoint_stamp(folder) == seen && clock.elapsed() < Duration::from_secs(60) {
        if child.try_wait().expect("a child").is_some() {
            return false;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    std::thread::sleep(more);
    let alive = child.try_wait().expect("a child").is_none();
    let _gone = child.kill();
    child.wait().expect("a child ends");
    alive
}

/// Changes with every checkpoint.
fn checkpoint_stamp(folder: &Path) -> Option<u64> {
    let bytes = std::fs::read(folder.join("checkpoint/state")).ok()?;
    Some(bytes.iter().fold(0_u64, |sum, &b| sum.wrapping_mul(31).wrapping_add(u64::from(b))))
}

fn fresh(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("resume").join(name);
    let _absent = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

/// Kills a run of `scene` several times, resumes it, and compares what it leaves with an undisturbed run, file by
/// file, byte by byte.
fn survives(name: &str, scene: &str, options: &[&str], every: &str, files: &[&str]) {
    survives_beside(name, scene, |_| (), options, every, files);
}

/// The same, of a scene with other files beside it, which `prepare` writes.
fn survives_beside(
    name: &str,
    scene: &str,
    prepare: impl FnOnce(&Path),
    options: &[&str],
    every: &str,
    files: &[&str],
) {
    let folder = fresh(name);
    prepare(&folder);
    let path = folder.join("scene.toml");
    std::fs::write(&path, scene).expect("a scene");
    let (whole, killed) = (folder.join("whole"), folder.join("killed"));
    let common = [&["run", text(&path), "--no-figures"][..], options].concat();
    run(&[&common[..], &["--out", text(&whole)]].concat());

    let start = [&common[..], &["--out", text(&killed), "--checkpoint", every]].concat();
    let mut kills = usize::from(kill_after_checkpoint(&start, &killed, None, Duration::from_millis(3)));
    let again = [&common[..], &["--resume", text(&killed)]].concat();
    for wait in [0, 7] {
        let seen = checkpoint_stamp(&killed);
        if seen.is_some() {
            kills += usize::from(kill_after_checkpoint(&again, &killed, seen, Duration::from_millis(wait)));
        }
    }
    assert!(kills > 0, "{name}: no run lived long enough to be killed");
    if killed.join("checkpoint").exists() {
        run(&again);
    }
    assert!(!killed.join("checkpoint").exists(), "{name}: a run that is over leaves no checkpoint");
    let names = |folder: &Path| {
        let entries =
            std::fs::read_dir(folder).expect("results").map(|entry| entry.expect("readable").file_name());
        entries.collect::<std::collections::BTreeSet<_>>()
    };
    assert_eq!(names(&killed), names(&whole), "{name}: kills left something behind");
    for file in files {
        let [a, b] = [&whole, &killed].map(|folder| untimed(&folder.join(file)));
        assert!(!a.is_empty() && a == b, "{name}: {file} differs after {kills} kills");
    }
}

/// The bytes of a result, without the lines of the summary that tell the time on the wall.
fn untimed(path: &Path) -> Vec<u8> {
    let bytes = std::fs::read(path).expect("a result");
    let timed = |line: &&[u8]| {
        ["\"wall_seconds\"", "\"us_per_step\""]
            .iter()
            .any(|key| line.windows(key.len()).any(|window| window == key.as_bytes()))
    };
    bytes.split(|&b| b == b'\n').filter(|line| !timed(line)).collect::<Vec<_>>().join(&b'\n')
}

const TABLES: [&str; 4] = ["summary.json", "trajectory.csv", "contacts.csv", "energy.csv"];

#[test]
fn a_rigid_scene_survives_kills() {
    let stick = include_str!("../examples/impacting_stick.toml");
    // Enough steps to be killed in, and a coarse table.
    survives("stick", stick, &["--step", "2e-6", "--end", "0.4"], "5000", &TABLES);
}

#[test]
fn a_pile_survives_kills() {
    let mut scene = String::from(
        "title = \"Pile\"\nlaws = [\"fremond\"]\nsolvers = [\"hybrid\"]\ngravity = [0.0, -10.0]\n\
         [time]\nstep = 1e-3\nend = 1.5\nactivation = \"predicted-gap\"\n\
         [[half_planes]]\nname = \"floor\"\nnormal = [0.0, 1.0]\n\
         [[half_planes]]\nname = \"left\"\nnormal = [1.0, 0.0]\n\
         [[half_planes]]\nname = \"right\"\npoint = [3.05, 0.0]\nnormal = [-1.0, 0.0]\n\
         [[interfaces]]\nbetween = [\"balls\", \"balls\"]\nparameters = { restitution = 0.0, friction = 0.3 }\n",
    );
    for plane in ["floor", "left", "right"] {
        scene += &format!(
            "[[interfaces]]\nbetween = [\"balls\", \"{plane}\"]\nparameters = {{ restitution = 0.2, friction = 0.3 }}\n"
        );
    }
    for i in 0..24 {
        let (x, y) = (0.5 + f64::from(i % 3) + 0.03 * f64::from(i / 3 % 2), 0.6 + 1.05 * f64::from(i / 3));
        scene += &format!(
            "[[bodies]]\nname = \"b{i}\"\ngroups = [\"balls\"]\nmass = 1.0\ninertia = 0.1\nposition = [{x}, {y}]\n\
             [[bodies.discs]]\nname = \"d\"\nradius = 0.5\n"
        );
    }
    survives("pile", &scene, &[], "100", &TABLES);
}

#[test]
fn an_elastic_scene_survives_kills() {
    let block = include_str!("../examples/sliding_block.toml").replace("size = 1.0", "size = 2.5");
    let files =
        [&TABLES[..], &["fremond.pvd", "newton/newton_00007.vtu", "fremond/fremond_00020.vtu"]].concat();
    survives("block", &block, &["--end", "0.25"], "150", &files);
}

/// A scene whose bodies stand in a file of their own, with frames.
#[cfg(feature = "vtk")]
const STACK: &str = "include = \"bodies/stack.toml\"\ntitle = \"Stack\"\n[output]\nvtk_every = 100\n";

#[cfg(feature = "vtk")]
fn stack(folder: &Path) {
    std::fs::create_dir_all(folder.join("bodies")).expect("a folder");
    let path = folder.join("bodies/stack.toml");
    std::fs::write(path, include_str!("../examples/cube_stack.toml")).expect("a scene");
}

#[test]
#[cfg(feature = "vtk")]
fn frames_of_bodies_in_space_survive_kills() {
    let frames = ["newton.pvd", "newton_contacts.pvd", "newton/newton_00007.vtu"];
    let contacts =
        ["newton_contacts/newton_contacts_00002.vtu", "fremond_contacts/fremond_contacts_00012.vtu"];
    let files = [&TABLES[..], &frames, &contacts].concat();
    survives_beside("stack", STACK, stack, &["--step", "5e-4"], "50", &files);
}

#[test]
#[cfg(feature = "vtk")]
fn a_changed_included_file_is_another_scene() {
    let folder = fresh("included");
    stack(&folder);
    let path = folder.join("scene.toml");
    std::fs::write(&path, STACK).expect("a scene");
    let out = folder.join("out");
    let start =
        ["run", text(&path), "--no-figures", "--step", "1e-4", "--out", text(&out), "--checkpoint", "50"];
    assert!(kill_after_checkpoint(&start, &out, None, Duration::ZERO), "killed in the middle");
    let changed =
        include_str!("../examples/cube_stack.toml").replace("[0.0, 0.0, 0.05]", "[0.0, 0.0, 0.051]");
    assert_ne!(changed, include_str!("../examples/cube_stack.toml"));
    std::fs::write(folder.join("bodies/stack.toml"), changed).expect("a scene");
    let resume = ["run", text(&path), "--no-figures", "--step", "1e-4", "--resume", text(&out)];
    let output = nonsmooth().args(resume).output().expect("the program starts");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("another scene"), "the reason is given");
}

#[test]
fn another_scene_is_not_resumed() {
    let folder = fresh("another");
    let path = folder.join("scene.toml");
    std::fs::write(&path, include_str!("../examples/impacting_stick.toml")).expect("a scene");
    let out = folder.join("out");
    let start =
        ["run", text(&path), "--no-figures", "--step", "1e-6", "--out", text(&out), "--checkpoint", "1000"];
    assert!(kill_after_checkpoint(&start, &out, None, Duration::ZERO), "killed in the middle");
    let resume = ["run", text(&path), "--no-figures", "--step", "2e-6", "--resume", text(&out)];
    let output = nonsmooth().args(resume).output().expect("the program starts");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("another scene"), "the reason is given");
}
