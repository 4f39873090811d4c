//! What a run leaves in its folder, and what its numbers mean.

mod outcome;

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use outcome::{Bench, ball, number, stderr, warnings};

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
#[cfg(feature = "vtk")]
fn rigid_bodies_leave_frames_of_their_surfaces_and_contacts() {
    let bench = Bench::new();
    let plane = ball(0.1, 0.0, "step = 1e-2\nend = 0.1").replace("[time]", "[output]\nvtk_every = 5\n[time]");
    let space = include_str!("../examples/cube_stack.toml").replace("[output]", "[output]\nvtk_every = 5");
    for (scene, names) in [(plane, ["ball.rim", "floor"]), (space, ["cube.3.1", "floor"])] {
        bench.summary(&scene, &["--no-figures", "--end", "0.1"]);
        for (name, tuples) in [("newton", "\"spin\""), ("newton_contacts", "\"percussion\"")] {
            let list = fs::read_to_string(bench.results().join(format!("{name}.pvd"))).expect("a list");
            let frames: Vec<&str> =
                list.split("file=\"").skip(1).map(|rest| rest.split('"').next().expect("a name")).collect();
            assert!(frames.len() >= 3, "{list}");
            assert!(name != "newton" || names.iter().all(|name| list.contains(name)), "{list}");
            for frame in frames {
                let text = fs::read_to_string(bench.results().join(frame)).expect("a frame");
                assert!(text.contains(tuples) && text.contains("NumberOfPoints="), "{frame}");
                assert_eq!(
                    name != "newton" && frame.contains("_00000"),
                    text.contains("NumberOfPoints=\"0\"")
                );
            }
        }
    }
    let without = ball(0.1, 0.0, "step = 1e-2\nend = 0.1");
    bench.summary(&without, &["--no-figures"]);
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
