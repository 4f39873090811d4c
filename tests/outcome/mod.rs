//! A folder for a scene, the program that runs it there, and what it leaves.
#![allow(dead_code, reason = "each test uses a part of it")]

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use serde_json::Value;

/// A folder for one scene and its results.
pub(crate) struct Bench(pub(crate) tempfile::TempDir);

impl Bench {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    pub(crate) fn results(&self) -> PathBuf {
        self.0.path().join("results")
    }

    pub(crate) fn run(&self, scene: &str, arguments: &[&str]) -> Output {
        let path = self.0.path().join("scene.toml");
        fs::write(&path, scene).expect("a scene");
        let mut command = Command::new(env!("CARGO_BIN_EXE_nonsmooth"));
        command.current_dir(self.0.path()).arg("run").arg(path).arg("--out").arg(self.results());
        command.args(arguments).output().expect("the program starts")
    }

    /// The summary of a run that goes well.
    pub(crate) fn summary(&self, scene: &str, arguments: &[&str]) -> Value {
        let output = self.run(scene, arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        self.read()
    }

    pub(crate) fn read(&self) -> Value {
        let bytes = fs::read(self.results().join("summary.json")).expect("a summary");
        serde_json::from_slice(&bytes).expect("JSON")
    }

    /// Files below the results, as relative paths.
    pub(crate) fn files(&self) -> BTreeSet<String> {
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

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub(crate) fn warnings(summary: &Value) -> Vec<String> {
    let all = summary["warnings"].as_array().expect("a list");
    all.iter().map(|warning| warning.as_str().expect("a text").to_string()).collect()
}

/// A ball of radius 0.1 m and 2 kg at rest at a height, with a floor and any time table.
pub(crate) fn ball(height: f64, restitution: f64, time: &str) -> String {
    format!(
        "title = \"Ball\"\nlaws = [\"newton\"]\ngravity = [0.0, -10.0]\n[time]\n{time}\nallow_unproved_theta = true\n\
         [[bodies]]\nname = \"ball\"\nmass = 2.0\ninertia = 0.01\nposition = [0.0, {height}]\n\
         [[bodies.discs]]\nname = \"rim\"\nradius = 0.1\n\
         [[half_planes]]\nname = \"floor\"\nnormal = [0.0, 1.0]\n\
         [[interfaces]]\nbetween = [\"ball\", \"floor\"]\nparameters = {{ restitution = {restitution}, friction = 0.0 }}\n"
    )
}

pub(crate) fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} is a number: {value}"))
}
