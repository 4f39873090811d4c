//! The rooms of the house: who may use whom, and that a law or a solver is one file and one line.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Which rooms of `src/core/` a room may name. A file that is not listed here fails the test: give it a room.
const ROOMS: &[(&str, &[&str])] = &[
    ("laws", &[]),
    ("scalar", &["laws"]),
    ("linalg", &["scalar"]),
    ("cone", &["laws", "linalg", "scalar"]),
    ("contact", &["laws", "linalg", "scalar"]),
    ("geometry", &["scalar"]),
    ("mesh", &["linalg"]),
    ("system", &["contact", "geometry", "linalg", "mesh", "scalar"]),
    ("solver", &["cone", "linalg", "scalar"]),
    ("registry", &["laws", "scalar", "solver"]),
    ("energy", &["contact", "scalar", "system"]),
    ("scheme", &["cone", "contact", "energy", "laws", "linalg", "scalar", "solver", "system"]),
    ("adaptive", &["contact", "laws", "linalg", "scalar", "scheme", "solver", "system"]),
    ("event_driven", &["cone", "contact", "energy", "laws", "linalg", "solver", "system"]),
    ("file", &[]),
    ("plot", &["file"]),
    (
        "observe",
        &["contact", "energy", "file", "laws", "linalg", "mesh", "plot", "scalar", "scheme", "system"],
    ),
    ("fclib", &["cone", "file", "linalg", "scalar"]),
    (
        "simulate",
        &["adaptive", "contact", "energy", "fclib", "linalg", "mesh", "observe", "scalar", "scheme"],
    ),
    ("planar", &["laws", "observe", "scalar", "scheme", "simulate", "solver", "system"]),
    (
        "scene",
        &[
            "adaptive",
            "contact",
            "energy",
            "event_driven",
            "geometry",
            "laws",
            "linalg",
            "mesh",
            "observe",
            "registry",
            "scalar",
            "scheme",
            "simulate",
            "solver",
            "system",
        ],
    ),
    ("collection", &["cone", "fclib", "file", "plot", "registry", "scalar", "solver"]),
    (
        "run",
        &[
            "adaptive", "contact", "fclib", "file", "mesh", "observe", "plot", "registry", "scalar", "scene",
            "scheme", "simulate",
        ],
    ),
    (
        "study",
        &[
            "adaptive",
            "collection",
            "energy",
            "event_driven",
            "fclib",
            "file",
            "laws",
            "observe",
            "plot",
            "registry",
            "scalar",
            "scene",
            "scheme",
            "simulate",
            "solver",
            "system",
        ],
    ),
    ("suite", &["cone", "contact", "laws", "linalg", "scalar", "scheme", "solver", "system"]),
    (
        "cli",
        &[
            "collection",
            "laws",
            "observe",
            "plot",
            "registry",
            "run",
            "scalar",
            "scene",
            "simulate",
            "solver",
            "study",
        ],
    ),
];

/// What the crate of the laws may stand on; of the core it may use the room `laws` alone.
const LAW_DEPENDENCIES: &[&str] = &["nalgebra", "nonsmooth-core"];

/// Longest source file, in lines.
const LONGEST: usize = 500;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every Rust file below `folder`, with its text.
fn sources(folder: &str) -> Vec<(PathBuf, String)> {
    let (mut open, mut files) = (vec![root().join(folder)], Vec::new());
    while let Some(folder) = open.pop() {
        for entry in
            fs::read_dir(&folder).expect("a folder of the crate").map(|e| e.expect("readable").path())
        {
            if entry.is_dir() {
                open.push(entry);
            } else if entry.extension().is_some_and(|extension| extension == "rs") {
                let text = fs::read_to_string(&entry).expect("source files are UTF-8");
                files.push((entry.strip_prefix(root()).expect("inside").to_path_buf(), text));
            }
        }
    }
    files.sort();
    assert!(!files.is_empty(), "no source below {folder}");
    files
}

/// The room of a file of `src/core/`: its folder or its stem.
fn room(path: &Path) -> String {
    let inside = path.strip_prefix("src/core").expect("a file of the core");
    let first = inside.components().next().expect("a name").as_os_str().to_string_lossy();
    first.trim_end_matches(".rs").to_string()
}

/// The text without comments, and with the contents of string literals when `strings`, blanked out when not.
fn code(text: &str, strings: bool) -> String {
    let (mut out, mut rest) = (String::new(), text);
    while let Some(c) = rest.chars().next() {
        let mut taken = c.len_utf8();
        if rest.starts_with("//") {
            taken = rest.find('\n').unwrap_or(rest.len());
        } else if rest.starts_with("/*") {
            taken = rest.find("*/").map_or(rest.len(), |end| end + 2);
        } else if c == '"' {
            let mut escaped = false;
            let end = rest[1..].find(|c| {
                let ends = c == '"' && !escaped;
                escaped = c == '\\' && !escaped;
                ends
            });
            taken = end.map_or(rest.len(), |end| end + 2);
            out.push_str(if strings { &rest[..taken] } else { "\"\"" });
        } else if rest.starts_with("'\"'") || rest.starts_with("'\\\"'") {
            taken = if rest.starts_with("'\"'") { 3 } else { 4 };
        } else {
            out.push(c);
        }
        rest = &rest[taken..];
    }
    out
}

/// The string literals of code from [`code`].
fn literals(code: &str) -> Vec<String> {
    let (mut found, mut current, mut escaped) = (Vec::new(), None::<String>, false);
    for c in code.chars() {
        let quote = c == '"' && !escaped;
        escaped = current.is_some() && c == '\\' && !escaped;
        current = match (current, quote) {
            (None, true) => Some(String::new()),
            (Some(text), true) => {
                found.push(text);
                None
            }
            (Some(text), false) => Some(text + c.encode_utf8(&mut [0; 4])),
            (None, false) => None,
        };
    }
    found
}

/// Words of letters, digits and underscores; a hyphen joins, so that `semismooth-newton` is one word.
fn words(text: &str) -> BTreeSet<String> {
    let in_word = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    text.split(|c: char| !in_word(c)).map(|word| word.trim_matches('-').to_string()).collect()
}

/// The rooms named in `code` by `crate::room`, `nonsmooth::room`, and `use crate::{room, …}`.
fn rooms_named(code: &str) -> BTreeSet<String> {
    let flat: String = code.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut rooms = BTreeSet::new();
    for prefix in ["crate::", "nonsmooth::"] {
        for (at, _) in flat.match_indices(prefix) {
            // `$crate::` and `my_crate::` are other things.
            if flat[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '$') {
                continue;
            }
            let rest = flat[at + prefix.len()..].trim_start();
            let name = |text: &str| {
                text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>()
            };
            if let Some(list) = rest.strip_prefix('{') {
                let mut depth = 0;
                for (i, c) in list.char_indices() {
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        _ => {}
                    }
                    let starts = list[..i].trim_end().ends_with(',') || list[..i].trim().is_empty();
                    if depth == 0 && starts && c.is_alphabetic() {
                        rooms.insert(name(&list[i..]));
                    }
                }
            } else {
                rooms.insert(name(rest));
            }
        }
    }
    rooms.remove("");
    rooms
}

#[test]
fn rooms_use_only_the_rooms_below_them() {
    let known: BTreeSet<&str> = ROOMS.iter().map(|(room, _)| *room).collect();
    let mut wrong = Vec::new();
    for (path, text) in sources("src/core") {
        if path == Path::new("src/core/lib.rs") {
            continue;
        }
        let room = room(&path);
        let Some((_, may)) = ROOMS.iter().find(|(name, _)| *name == room) else {
            wrong.push(format!(
                "{}: `{room}` is no room; add it to ROOMS with what it may use",
                path.display()
            ));
            continue;
        };
        for named in rooms_named(&code(&text, false)) {
            if known.contains(named.as_str()) && named != room && !may.contains(&named.as_str()) {
                wrong.push(format!(
                    "{}: `{room}` names `{named}`, which is not below it (it may use: {}); move the code to the \
                     room that may, or pass what it needs as an argument",
                    path.display(),
                    may.join(", "),
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "the import table of the rooms is broken:\n{}", wrong.join("\n"));
}

#[test]
fn the_import_table_has_no_cycle() {
    // In the order of the table every room uses rooms that were listed before it.
    let mut seen: Vec<&str> = Vec::new();
    for (room, may) in ROOMS {
        let late: Vec<_> = may.iter().filter(|below| !seen.contains(below)).collect();
        assert!(late.is_empty(), "`{room}` uses {late:?}, listed after it: order ROOMS from the bottom up");
        seen.push(room);
    }
}

#[test]
fn laws_stand_on_almost_nothing() {
    let manifest = fs::read_to_string(root().join("laws/Cargo.toml")).expect("the manifest of the laws");
    let mut in_dependencies = false;
    for line in manifest.lines() {
        if line.starts_with('[') {
            in_dependencies = line.contains("dependencies");
            continue;
        }
        let name = line.split(['.', '=', ' ']).next().unwrap_or_default();
        let allowed = name.is_empty() || name.starts_with('#') || LAW_DEPENDENCIES.contains(&name);
        assert!(
            !in_dependencies || allowed,
            "laws/Cargo.toml depends on `{name}`; a law is a few numbers in and a few out and may use {} only",
            LAW_DEPENDENCIES.join(", ")
        );
    }
    for (path, text) in sources("laws/src") {
        let code = code(&text, false);
        for (at, _) in code.match_indices("nonsmooth_core::") {
            let rest = &code[at + "nonsmooth_core::".len()..];
            assert!(rest.starts_with("laws::"), "{} names another room than `laws`", path.display());
        }
    }
}

/// `module::Type` pairs of a `register!` call.
fn registered(text: &str) -> Vec<(String, String)> {
    let start = text.rfind("register! {").expect("a register! call") + "register! {".len();
    let end = start + text[start..].find('}').expect("the end of the register! call");
    let lines =
        text[start..end].lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines
        .map(|line| {
            let (module, name) = line
                .trim_end_matches(',')
                .split_once("::")
                .unwrap_or_else(|| panic!("registration is one `module::Type` a line, this is `{line}`"));
            (module.to_string(), name.to_string())
        })
        .collect()
}

#[test]
fn a_law_is_one_file_and_one_line() {
    let registry = fs::read_to_string(root().join("laws/src/lib.rs")).expect("the page of the laws");
    let laws = registered(&registry);
    assert_eq!(laws.len(), nonsmooth::laws::LAWS.len());
    let names = laws.iter().flat_map(|(module, name)| [module.clone(), name.clone()]);
    let mut forbidden: Vec<String> = names.collect();
    forbidden.extend(nonsmooth::laws::LAWS.iter().map(|law| law.name.to_string()));
    for (path, text) in sources("src/core") {
        let identifiers = words(&code(&text, false));
        let literals: BTreeSet<String> =
            literals(&code(&text, true)).iter().flat_map(|literal| words(literal)).collect();
        // Newton's method shares its name with Newton's law, and so do the solver and the locals of that method.
        let numerics = ["cone", "linalg", "solver"].contains(&room(&path).as_str());
        let is_method = |name: &str| numerics && nonsmooth::solver::SOLVERS.iter().any(|s| s.name == name);
        for name in forbidden.iter().filter(|name| !is_method(name)) {
            assert!(
                !identifiers.contains(name) && !literals.contains(name),
                "{} names the law `{name}`: laws reach the program through the registry alone, ask \
                 `nonsmooth::laws` for what you need (a property of a law belongs to its trait or description)",
                path.display()
            );
        }
    }
    for (module, _) in &laws {
        let file = root().join(format!("laws/src/{module}.rs"));
        let text = code(&fs::read_to_string(&file).expect("the file of a registered law"), false);
        for (other, name) in laws.iter().filter(|(other, _)| other != module) {
            assert!(
                !words(&text).contains(name) && !words(&text).contains(other),
                "laws/src/{module}.rs names the law `{name}`: a law is one file; share code through law.rs or \
                 parameter.rs"
            );
        }
    }
}

#[test]
fn a_solver_is_one_line_of_the_registry() {
    let registry =
        fs::read_to_string(root().join("src/core/solver/registry.rs")).expect("the registry of solvers");
    let registered = registered(&registry);
    assert_eq!(registered.len(), nonsmooth::solver::SOLVERS.len() + missing_features());
    for (path, text) in sources("src/core/solver") {
        let code = code(&text, false);
        let flat = code.split_whitespace().collect::<Vec<_>>().join(" ");
        // `impl<…> Method<T, D> for Type<…>`.
        for (at, _) in flat.match_indices("> Method<T, D> for ") {
            let name: String = flat[at + "> Method<T, D> for ".len()..]
                .chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect();
            let stem = path.file_stem().expect("a file").to_string_lossy().to_string();
            assert!(
                registered.contains(&(stem.clone(), name.clone())),
                "{} holds the solver `{name}`, which the registry does not list: add the line `{stem}::{name},` to \
                 register! in src/core/solver/registry.rs",
                path.display()
            );
        }
    }
    for (module, name) in registered {
        assert!(
            root().join(format!("src/core/solver/{module}.rs")).exists(),
            "`{module}::{name}` is registered, but src/core/solver/{module}.rs does not exist: a solver is one file"
        );
    }
}

/// Registered solvers that this build leaves out.
fn missing_features() -> usize {
    usize::from(!cfg!(feature = "clarabel"))
}

#[test]
fn files_stay_readable() {
    for folder in ["src", "laws/src"] {
        for (path, text) in sources(folder) {
            let lines = text.lines().count();
            assert!(
                lines <= LONGEST,
                "{} has {lines} lines, more than {LONGEST}: split it by idea",
                path.display()
            );
        }
    }
}

#[test]
fn the_parser_of_this_test_sees_what_it_should() {
    let text = "use crate::{cone, linalg::{Factor, dot}, scalar}; // crate::plot\nlet x = \"crate::scene \\\" newton\";\n\
                let y = super::x::<crate::system::Body>('\"'); $crate::cli";
    let named = rooms_named(&code(text, false));
    let expected = ["cone", "linalg", "scalar", "system"].map(String::from);
    assert_eq!(named, expected.into_iter().collect());
    assert!(words(&literals(&code(text, true))[0]).contains("newton"));
    assert!(!words("semismooth-newton").contains("newton"));
}
