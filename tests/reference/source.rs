//! The structs and enums of the sources, as far as a page about them needs.

use std::fs;
use std::path::Path;

/// A field of a struct, or of a variant.
#[derive(Debug, Clone)]
pub(crate) struct Field {
    pub(crate) name: String,
    pub(crate) kind: String,
    pub(crate) doc: String,
    pub(crate) serde: String,
}

/// A variant of an enum.
#[derive(Debug, Clone)]
pub(crate) struct Variant {
    pub(crate) name: String,
    pub(crate) doc: String,
    pub(crate) serde: String,
    pub(crate) is_default: bool,
    pub(crate) fields: Vec<Field>,
}

/// A struct (no variants) or an enum (no fields).
#[derive(Debug, Clone)]
pub(crate) struct Item {
    pub(crate) doc: String,
    pub(crate) serde: String,
    pub(crate) fields: Vec<Field>,
    pub(crate) variants: Vec<Variant>,
}

/// All text of the files named.
pub(crate) fn text(files: &[&str]) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read =
        |file: &&str| fs::read_to_string(root.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
    files.iter().map(read).collect::<Vec<_>>().join("\n")
}

/// Documentation and attributes gathered before what they belong to.
#[derive(Default, Clone)]
struct Head {
    doc: Vec<String>,
    attributes: String,
    /// Whether an attribute goes on in the next line.
    is_open: bool,
}

impl Head {
    /// Takes a line of documentation or of an attribute in; `false` for any other.
    fn takes(&mut self, line: &str) -> bool {
        if let Some(doc) = line.strip_prefix("///") {
            self.doc.push(doc.trim().into());
        } else if self.is_open || line.starts_with("#[") {
            self.attributes.push_str(line);
            self.is_open = !line.ends_with(']');
        } else {
            return false;
        }
        true
    }

    /// The documentation up to the first empty line, in one line.
    fn doc(&self) -> String {
        self.doc.iter().take_while(|line| !line.is_empty()).cloned().collect::<Vec<_>>().join(" ")
    }
}

/// The body of a function without arguments, as it stands in the text: `half` gives `0.5`.
pub(crate) fn value_of(text: &str, function: &str) -> String {
    let start = text.find(&format!("fn {function}()")).unwrap_or_else(|| panic!("no function {function}"));
    let body = &text[start..];
    let (open, close) = (body.find('{').expect("a body"), body.find("\n}").expect("an end"));
    body[open + 1..close].trim().to_string()
}

/// The struct or enum of a name.
pub(crate) fn item(text: &str, name: &str) -> Option<Item> {
    let mut head = Head::default();
    let mut lines = text.lines();
    let is_head = |line: &str, word: &str| {
        let rest = line.trim_start_matches("pub ").strip_prefix(word)?.trim_start();
        let rest = rest.strip_prefix(name)?;
        rest.starts_with([' ', '<', '{']).then_some(())
    };
    loop {
        let line = lines.next()?.trim_end();
        if is_head(line, "struct ").is_some() || is_head(line, "enum ").is_some() {
            let of_enum = line.contains("enum ");
            let body: Vec<&str> = lines.take_while(|line| *line != "}").collect();
            let (doc, serde) = (head.doc(), head.attributes);
            let (fields, variants) =
                if of_enum { (Vec::new(), variants(&body)) } else { (fields(&body, "    "), Vec::new()) };
            return Some(Item { doc, serde, fields, variants });
        }
        if !head.takes(line) {
            head = Head::default();
        }
    }
}

/// Fields at one depth of indentation.
fn fields(body: &[&str], indent: &str) -> Vec<Field> {
    let (mut head, mut found) = (Head::default(), Vec::new());
    for line in body {
        let Some(line) = line.strip_prefix(indent) else { continue };
        if head.takes(line) {
            continue;
        }
        if let Some((name, kind)) = line.trim_start_matches("pub ").trim_end_matches(',').split_once(": ") {
            let (doc, serde) = (head.doc(), head.attributes.clone());
            found.push(Field { name: name.into(), kind: kind.into(), doc, serde });
        }
        head = Head::default();
    }
    found
}

fn variants(body: &[&str]) -> Vec<Variant> {
    let (mut head, mut found) = (Head::default(), Vec::<Variant>::new());
    let mut inside: Option<Vec<&str>> = None;
    for line in body {
        let Some(own) = line.strip_prefix("    ") else { continue };
        if let Some(lines) = &mut inside {
            if own.starts_with('}') {
                let fields = fields(lines, "        ");
                found.last_mut().expect("an open variant").fields = fields;
                inside = None;
            } else {
                lines.push(line);
            }
            continue;
        }
        if head.takes(own) {
            continue;
        }
        let name = own.trim_end_matches([',', '{', ' ']).to_string();
        let is_default = head.attributes.contains("#[default]");
        let (doc, serde) = (head.doc(), head.attributes.clone());
        found.push(Variant { name, doc, serde, is_default, fields: Vec::new() });
        inside = own.ends_with('{').then(Vec::new);
        head = Head::default();
    }
    found
}

/// The value of `key = "…"` in an attribute.
pub(crate) fn attribute<'a>(serde: &'a str, key: &str) -> Option<&'a str> {
    let rest = &serde[serde.find(&format!("{key} = \""))? + key.len() + 4..];
    rest.split('"').next()
}

/// `PlaneStress` as serde writes it.
pub(crate) fn renamed(name: &str, rule: Option<&str>) -> String {
    match rule {
        Some("kebab-case") => {
            let mut out = String::new();
            for (i, c) in name.chars().enumerate() {
                if c.is_uppercase() && i > 0 {
                    out.push('-');
                }
                out.extend(c.to_lowercase());
            }
            out
        }
        Some("lowercase") => name.to_lowercase(),
        _ => name.into(),
    }
}
