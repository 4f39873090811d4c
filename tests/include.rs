//! Scene files that take others in.

use std::path::{Path, PathBuf};

use nonsmooth::scene::{IncludeError, Scene, SceneError};

struct Files(tempfile::TempDir);

impl Files {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            std::fs::write(path, text).expect("a file");
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn read(&self) -> Result<Scene, SceneError> {
        Scene::read(self.path("scene.toml"))
    }
}

const HEAD: &str = "title = \"own\"\nlaws = [\"newton\"]\ndimension = 3\n[time]\nstep = 1e-3\nend = 1.0\n";

const BALL: &str =
    "[[bodies]]\nname = \"NAME\"\nmass = 1.0\nposition = [0.0, 0.0, 1.0]\nshapes = [{ ball = 0.1 }]\n";

fn ball(name: &str) -> String {
    BALL.replace("NAME", name)
}

#[test]
fn what_a_file_says_wins_and_lists_go_on() {
    let main = format!("include = [\"a.toml\", \"sub/b.toml\"]\n{HEAD}{}", ball("one"));
    let a = format!(
        "title = \"a\"\ngravity = [0.0, 0.0, -1.0]\n{}[time]\nend = 5.0\nallow_unproved_theta = true\ntheta = 0.75\n",
        ball("two")
    );
    let b = format!("gravity = [0.0, 0.0, -2.0]\nsolvers = [\"nsgs\"]\n{}", ball("three"))
        + "[[half_spaces]]\nname = \"floor\"\nnormal = [0.0, 0.0, 1.0]\n\
           [[obstacles]]\nname = \"stone\"\nshapes = [{ file = \"stone.obj\" }]\n\
           [[interfaces]]\nbetween = [\"one\", \"floor\"]\nparameters = { restitution = 0.0, friction = 0.0 }\n";
    let stone = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    let files =
        Files::new(&[("scene.toml", &main), ("a.toml", &a), ("sub/b.toml", &b), ("sub/stone.obj", stone)]);
    let scene = files.read().expect("a scene");
    let space = scene.space.as_ref().expect("in space");
    let names: Vec<&str> = space.bodies.iter().map(|body| &*body.name).collect();
    assert_eq!(names, ["one", "two", "three"]);
    assert_eq!((&*scene.title, scene.time.end, scene.time.theta), ("own", 1.0, Some(0.75)));
    assert_eq!((space.gravity[2], &scene.solvers[..]), (-1.0, &["nsgs".to_string()][..]));
    assert_eq!((space.half_spaces.len(), scene.interfaces.len()), (1, 1));
    // A mesh is sought beside the file that names it.
    assert_eq!(scene.include, ["a.toml", "sub/b.toml"]);
    let registry = nonsmooth::registry();
    let run = &scene.runs(&registry).expect("runs")[0];
    scene.simulation(run, 1, &registry).map(drop).expect("a system");
    // A comment is no other scene, a number is.
    let before = scene.fingerprint().expect("read").number();
    std::fs::write(files.path("a.toml"), a.clone() + "# nothing\n").expect("a file");
    assert_eq!(files.read().expect("a scene").fingerprint().expect("read").number(), before);
    std::fs::write(files.path("a.toml"), a.replace("0.75", "0.8")).expect("a file");
    assert_ne!(files.read().expect("a scene").fingerprint().expect("read").number(), before);
}

#[test]
fn scenes_in_the_plane_take_files_in_too() {
    let main = "include = \"common.toml\"\ntitle = \"Ball\"\n[[bodies]]\nname = \"ball\"\nmass = 1.0\ninertia = 1.0\n\
                position = [0.0, 1.0]\n";
    let common = "laws = [\"newton\", \"fremond\"]\ngravity = [0.0, -10.0]\n[time]\nstep = 1e-3\nend = 1.0\n\
                  [[half_planes]]\nname = \"floor\"\nnormal = [0.0, 1.0]\n";
    let files = Files::new(&[("scene.toml", main), ("common.toml", common)]);
    let scene = files.read().expect("a scene");
    assert!(scene.space.is_none() && scene.laws.len() == 2 && scene.half_planes.len() == 1);
    let table = Scene::table(main, &files.path("scene.toml")).expect("a table");
    let changed = Scene::with_keys(&table, &files.path("scene.toml"), &[]).expect("a scene");
    assert_eq!((&changed.bodies, &changed.include), (&scene.bodies, &scene.include));
}

/// Where an error is said to be.
fn place(error: &SceneError) -> (String, usize, usize) {
    let (SceneError::Parse { path, line, column, .. } | SceneError::Include { path, line, column, .. }) =
        error
    else {
        panic!("{error}")
    };
    (path.file_name().expect("a file").to_string_lossy().into(), *line, *column)
}

#[test]
fn errors_name_the_file_they_are_in() {
    let main = format!("include = [\"a.toml\", \"b.toml\"]\n{HEAD}{}", ball("one"));
    let sound = ball("two");
    for (b, at, what) in [
        ("x = = 1\n", (1, 5), ""),
        ("\n\nwrong = 1\n", (3, 1), "unknown field `wrong`"),
        ("[[bodies]]\nname = \"c\"\nposition = [0.0, \"1\", 0.0]\n", (3, 18), "invalid type"),
        (
            "[[bodies]]\nname = \"c\"\nmasse = 1.0\nposition = [0.0, 1.0, 0.0]\n",
            (3, 1),
            "unknown field `masse`",
        ),
        ("include = 3\n", (1, 11), "the name of a file"),
        ("gravity = [0.0, 0.0, 0.0]\ninclude = [\"a.toml\", [1]]\n", (2, 22), "the name of a file"),
        ("include = \"none.toml\"\n", (1, 11), "cannot read"),
        ("include = \"scene.toml\"\n", (1, 11), "in a circle"),
        ("include = \"b.toml\"\n", (1, 11), "b.toml → "),
    ] {
        let files = Files::new(&[("scene.toml", &main), ("a.toml", &sound), ("b.toml", b)]);
        let error = files.read().expect_err("refused");
        assert_eq!(place(&error), ("b.toml".into(), at.0, at.1), "{b}: {error}");
        assert!(error.to_string().contains(what), "{error}");
    }
    // And those of the first file as ever.
    let files =
        Files::new(&[("scene.toml", &(main.clone() + "wrong = 1\n")), ("a.toml", ""), ("b.toml", "")]);
    assert_eq!(place(&files.read().expect_err("refused")).0, "scene.toml");
}

#[test]
fn circles_are_told_and_roads_that_meet_again_are_none() {
    let main = format!("include = [\"a.toml\", \"b.toml\"]\n{HEAD}");
    let ball = ball("one");
    let files = Files::new(&[
        ("scene.toml", &main),
        ("a.toml", "include = \"common.toml\""),
        ("b.toml", "include = \"./common.toml\""),
        ("common.toml", &ball),
    ]);
    assert_eq!(files.read().expect("a scene").space.expect("in space").bodies.len(), 1);
    std::fs::write(files.path("common.toml"), "include = \"b.toml\"").expect("a file");
    let error = files.read().expect_err("a circle");
    let SceneError::Include { source: IncludeError::Circle { chain }, .. } = &error else {
        panic!("{error}")
    };
    assert_eq!(chain.len(), 3, "{error}");
    // Not in a file: where it would be sought does not exist.
    let error = Scene::parse("include = \"x.toml\"\n", Path::new("no such/scene.toml")).expect_err("refused");
    assert!(matches!(error, SceneError::Include { source: IncludeError::Read { .. }, .. }), "{error}");
}
