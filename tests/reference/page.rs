//! The page about scene files.

use std::fmt::Write as _;

use super::source::{Field, Item, attribute, item, renamed, text, value_of};

/// Where the types of scene files are.
const FILES: [&str; 18] = [
    "src/core/scene/format.rs",
    "src/core/scene/joints.rs",
    "src/core/scene/lagrangian.rs",
    "src/core/scene/obstacles.rs",
    "src/core/scene/solid.rs",
    "src/core/scene/space/format.rs",
    "src/core/scene/space/heights.rs",
    "src/core/scene/space/joints.rs",
    "src/core/scene/space/repeat.rs",
    "src/core/scene/space/shape.rs",
    "src/core/scene/time.rs",
    "src/core/scheme/activation.rs",
    "src/core/system/rigid_bodies/curves.rs",
    "src/core/system/signal.rs",
    "src/core/system/elastic/material.rs",
    "src/core/system/elastic/mod.rs",
    "src/core/system/elastic/builder.rs",
    "src/core/mesh/rectangle.rs",
];

/// Units a number may have; `–` where it is dimensionless.
const UNITS: [&str; 27] = [
    "m",
    "s",
    "kg",
    "N",
    "rad",
    "m/s",
    "m/s²",
    "kg m²",
    "N m",
    "rad/s",
    "Pa",
    "kg/m³",
    "1/s",
    "m²",
    "N/m, N/m, N m/rad",
    "N s/m, N s/m, N m s",
    "m or rad",
    "m/s or rad/s",
    "N or N m",
    "N/m or N m/rad",
    "N s/m or N m s",
    "m; of a bar m²",
    "1/s, s",
    "dimensionless",
    "of each parameter its own",
    "of each coordinate its own",
    "m per unit of each",
];

const HEAD: &str = "\
# Scene files

<!-- Made by `UPDATE=1 cargo test --test scene_reference` from the types that read scene files. Do not edit. -->

A scene is a TOML file. Numbers are in SI units, or in any other consistent set: nothing is converted. A key that is not listed
here is refused with its line and column. A key without a default must be given; `none` means that it may be left out.

";

pub(crate) fn page() -> String {
    let source = text(&FILES);
    let mut page = Page { source, out: HEAD.into(), done: Vec::new() };
    page.section("Scene", "");
    page.section("SpaceScene", "");
    page.signals();
    page.registry();
    page.out
}

struct Page {
    source: String,
    out: String,
    done: Vec<String>,
}

impl Page {
    fn item(&self, name: &str) -> Option<Item> {
        // `[time]` is read as a flat table, whose keys are documented where they end up.
        if name != "TimeSpec" {
            return item(&self.source, name);
        }
        let (spec, adaptive) = (item(&self.source, name)?, item(&self.source, "AdaptiveSpec")?);
        let mut written = item(&self.source, "TimeFields")?;
        for field in &mut written.fields {
            let documented =
                spec.fields.iter().chain(&adaptive.fields).find(|other| other.name == field.name);
            field.doc = documented
                .unwrap_or_else(|| panic!("`time.{}` is documented nowhere", field.name))
                .doc
                .clone();
        }
        Some(Item { doc: spec.doc, ..written })
    }

    /// The table of a struct at a place of the file, and those of the structs in it.
    fn section(&mut self, name: &str, place: &str) {
        if self.done.iter().any(|done| done == name) {
            return;
        }
        self.done.push(name.into());
        let item = self.item(name).unwrap_or_else(|| panic!("no type {name}"));
        let title = if name == "SpaceScene" {
            "In space: the top of the file".into()
        } else if place.is_empty() {
            "The top of the file".into()
        } else {
            format!("`{place}`")
        };
        let _ = write!(self.out, "## {title}\n\n{}\n\n", links_out(&item.doc));
        self.out.push_str("| key | value | unit | default | meaning |\n|---|---|---|---|---|\n");
        let mut inner = Vec::new();
        for field in &item.fields {
            if field.serde.contains("skip") {
                continue;
            }
            let (core, optional) = match field.kind.strip_prefix("Option<") {
                Some(rest) => (rest.strip_suffix('>').unwrap_or(rest).to_string(), true),
                None => (field.kind.clone(), false),
            };
            let value = self.value(&core, &field.name, place);
            let default = self.default(field, &core, optional);
            let unit = self.unit(name, field, &core);
            let meaning = self.meaning(field, &core);
            let key = attribute(&field.serde, "rename").unwrap_or(&field.name);
            let _ = writeln!(self.out, "| `{key}` | {value} | {unit} | {default} | {meaning} |");
            let element = core.strip_prefix("Vec<").map_or(&*core, |rest| rest.trim_end_matches('>'));
            if element.ends_with("Spec") {
                let path = if place.is_empty() {
                    String::new()
                } else {
                    format!("{}.", place.trim_matches(['[', ']']))
                };
                let listed = core.starts_with("Vec<");
                let (open, close) = if listed { ("[[", "]]") } else { ("[", "]") };
                inner.push((element.to_string(), format!("{open}{path}{}{close}", field.name)));
            }
        }
        self.out.push('\n');
        for (name, place) in inner {
            self.section(&name, &place);
        }
    }

    fn value(&self, core: &str, name: &str, place: &str) -> String {
        let dotted = if place.is_empty() {
            name.to_string()
        } else {
            format!("{}.{name}", place.trim_matches(['[', ']']))
        };
        match core {
            "f64" => "number".into(),
            "usize" | "u8" | "u64" => "whole number".into(),
            "[usize; 3]" => "three whole numbers".into(),
            "bool" => "`true` or `false`".into(),
            "String" | "PathBuf" => "text".into(),
            "StepField" => "number, or `\"adaptive\"`".into(),
            "[f64; 2]" => "two numbers".into(),
            "[f64; 3]" => "three numbers".into(),
            "[f64; 4]" => "four numbers".into(),
            "Vec<Vec<f64>>" => "list of rows of numbers".into(),
            "Vec<[f64; 3]>" => "list of triples of numbers".into(),
            "[String; 2]" => "two texts".into(),
            "Vec<String>" => "list of texts".into(),
            "Vec<[f64; 2]>" => "list of pairs of numbers".into(),
            "BTreeMap<String, f64>" => "table of numbers".into(),
            "BTreeMap<String, String>" => "table of texts".into(),
            "Signal<f64>" => "[signal](#signals)".into(),
            list if list.starts_with("Vec<") => format!("tables `[[{dotted}]]`"),
            spec if spec.ends_with("Spec") => format!("table `[{dotted}]`"),
            other => {
                let item =
                    self.item(other).unwrap_or_else(|| panic!("`{name}` has the unknown type {other}"));
                let names: Vec<String> =
                    self.names(&item).iter().map(|name| format!("`\"{name}\"`")).collect();
                names.join(", ")
            }
        }
    }

    /// The names of the variants of an enum in scene files.
    fn names(&self, item: &Item) -> Vec<String> {
        let rule = attribute(&item.serde, "rename_all");
        let name = |variant: &super::source::Variant| {
            attribute(&variant.serde, "rename").map_or_else(|| renamed(&variant.name, rule), String::from)
        };
        item.variants.iter().map(name).collect()
    }

    fn default(&self, field: &Field, core: &str, optional: bool) -> String {
        if optional {
            return "none".into();
        }
        if let Some(function) = attribute(&field.serde, "default") {
            let value = match function {
                "default_solvers" => format!("[\"{}\"]", nonsmooth::solver::DEFAULT),
                function => value_of(&self.source, function),
            };
            return format!("`{value}`");
        }
        if !field.serde.contains("default") {
            return "–".into();
        }
        match core {
            "f64" | "u64" => "`0`".into(),
            "bool" => "`false`".into(),
            "[f64; 2]" => "`[0, 0]`".into(),
            "[f64; 3]" => "`[0, 0, 0]`".into(),
            "Signal<f64>" => "`\"constant\"`".into(),
            list if list.starts_with("Vec<") || list.starts_with("BTreeMap<") => "empty".into(),
            spec if spec.ends_with("Spec") => "its defaults".into(),
            other => {
                let item = self.item(other).unwrap_or_else(|| panic!("no type {other}"));
                let place =
                    item.variants.iter().position(|variant| variant.is_default).expect("a default variant");
                format!("`\"{}\"`", self.names(&item)[place])
            }
        }
    }

    fn unit(&self, of: &str, field: &Field, core: &str) -> String {
        let number = [
            "f64",
            "[f64; 2]",
            "[f64; 3]",
            "[f64; 4]",
            "Vec<[f64; 2]>",
            "Vec<[f64; 3]>",
            "Vec<Vec<f64>>",
            "BTreeMap<String, f64>",
            "StepField",
        ];
        if !number.contains(&core) {
            return String::new();
        }
        let named = field.doc.split('(').skip(1).filter_map(|rest| rest.split(')').next());
        let unit = named.into_iter().find(|unit| UNITS.contains(unit));
        let unit = unit.unwrap_or_else(|| {
            panic!("the documentation of `{of}.{}` names no unit in parentheses: {}", field.name, field.doc)
        });
        if unit == "dimensionless" { "–".into() } else { unit.into() }
    }

    fn meaning(&self, field: &Field, core: &str) -> String {
        let mut meaning = links_out(&without_unit(&field.doc));
        let known = core.starts_with(|c: char| c.is_uppercase())
            && !core.contains('<')
            && !core.ends_with("Spec")
            && core != "StepField";
        let item = if known { self.item(core) } else { None };
        if let Some(item) = item.filter(|item| !item.variants.is_empty()) {
            for (name, variant) in self.names(&item).iter().zip(&item.variants) {
                let doc = links_out(variant.doc.trim_end_matches(" Default.")).replace(" (default)", "");
                let _ = write!(meaning, " `\"{name}\"`: {doc}");
            }
        }
        meaning
    }

    fn signals(&mut self) {
        let item = self.item("Signal").expect("the signals");
        let _ = write!(self.out, "## Signals\n\n{} `signal = \"constant\"`, or one of these:\n\n", item.doc);
        for (name, variant) in self.names(&item).iter().zip(&item.variants) {
            let keys: Vec<String> = (variant.fields.iter())
                .map(|field| match field.serde.contains("default") {
                    true => format!("`{}` {} (default 0)", field.name, field.doc.trim_end_matches('.')),
                    false => format!("`{}` {}", field.name, field.doc.trim_end_matches('.')),
                })
                .collect();
            if keys.is_empty() {
                continue;
            }
            let example: Vec<String> =
                variant.fields.iter().map(|field| format!("{} = …", field.name)).collect();
            let _ = writeln!(
                self.out,
                "- `{{ {name} = {{ {} }} }}`: {} {}.",
                example.join(", "),
                links_out(&variant.doc),
                keys.join("; ")
            );
        }
        self.out.push('\n');
    }

    fn registry(&mut self) {
        let registry = nonsmooth::registry();
        self.out.push_str(
            "## Laws\n\nNames for `laws` and `interfaces.law`, with their parameters; a program of one's own may know more.\n\n\
             | law | parameter | range | default | meaning |\n|---|---|---|---|---|\n",
        );
        for law in registry.laws() {
            for parameter in law.parameters {
                let default = parameter.default.map_or("–".into(), |value| format!("`{value}`"));
                let to =
                    if parameter.max.is_finite() { format!("{}]", parameter.max) } else { "∞)".into() };
                let _ = writeln!(
                    self.out,
                    "| `{}` | `{}` | [{}, {to} | {default} | {} |",
                    law.name, parameter.name, parameter.min, parameter.meaning
                );
            }
        }
        self.out
            .push_str("\n## Solvers\n\nNames for `solvers`.\n\n| solver | method | when |\n|---|---|---|\n");
        for solver in registry.solvers() {
            let mark = if solver.name == nonsmooth::solver::DEFAULT { " (default)" } else { "" };
            let _ = writeln!(self.out, "| `{}`{mark} | {} | {} |", solver.name, solver.title, solver.when);
        }
    }
}

/// The text without units in parentheses, which have a column of their own.
fn without_unit(doc: &str) -> String {
    UNITS.iter().fold(doc.to_string(), |doc, unit| doc.replace(&format!(" ({unit})"), ""))
}

/// Links to items of the code as plain words, and what would end a cell of a table escaped.
fn links_out(doc: &str) -> String {
    let mut out = String::new();
    let mut rest = doc;
    while let Some(start) = rest.find('[') {
        out.push_str(&rest[..start]);
        rest = &rest[start..];
        let Some(end) = rest.find(']') else { break };
        let (inside, after) = (&rest[1..end], &rest[end + 1..]);
        if inside.starts_with('`') {
            out.push_str(inside);
            rest = after;
        } else if let Some(target) = after.strip_prefix('(') {
            out.push_str(inside);
            rest = target.split_once(')').map_or("", |(_, after)| after);
        } else {
            out.push_str(&rest[..=end]);
            rest = after;
        }
    }
    out.push_str(rest);
    out.replace('|', "\\|")
}
