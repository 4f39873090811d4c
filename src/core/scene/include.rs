//! Scene files that take others in: `include = "other.toml"`, or a list of files, at the head of a file.
//!
//! What a file says wins over what it takes in, and an earlier file of a list over a later one: single values, key by key in
//! tables. Lists of tables (bodies, obstacles, interfaces, …) are joined, in that order. A file that is reached by two ways is
//! taken in once.
//!
//! All files are parsed as parts of one text, each at a place of its own behind the others, so that every error, of the
//! grammar or of a value, leads back to the file, the line and the column it stands in.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue, Deserializer};

use super::SceneError;

/// Keys that name a file, of a mesh or of heights.
const FILES: [&str; 2] = ["file", "terrain"];

/// Files that stand in each other: deeper is a slip.
const DEEPEST: usize = 64;

/// Why a file cannot be taken into another.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum IncludeError {
    /// It cannot be read.
    #[error("cannot read {}: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: Arc<std::io::Error>,
    },
    /// It takes in, at last, the file that takes it in.
    #[error("files include each other in a circle: {}", chain_of(chain))]
    Circle {
        /// The files on the way, the first again at the end.
        chain: Vec<PathBuf>,
    },
    /// It stands in too many others.
    #[error("files are included more than {DEEPEST} deep")]
    Deep,
}

fn chain_of(chain: &[PathBuf]) -> String {
    chain.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(" → ")
}

/// A file, and the folder it stands in, seen from that of the first.
struct Source {
    path: PathBuf,
    folder: PathBuf,
    text: String,
}

/// A scene file with the files it takes in, the more important first.
pub(super) struct Document {
    sources: Vec<Source>,
}

/// What is known while the files are gathered.
struct Gathering {
    /// Folder of the first file.
    folder: PathBuf,
    /// Files on the way to the present one, and what tells them from others.
    chain: Vec<(PathBuf, PathBuf)>,
    known: BTreeSet<PathBuf>,
    sources: Vec<Source>,
}

/// The file behind a path, whatever links lead to it.
fn identity(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| path.into())
}

impl Gathering {
    fn visit(&mut self, source: Source) -> Result<(), SceneError> {
        let names = included(&source)?;
        let (path, folder, text) = (source.path.clone(), source.folder.clone(), source.text.clone());
        self.sources.push(source);
        for (name, at) in names {
            let refuse = |source| SceneError::include(&path, &text, at, source);
            let relative = folder.join(&name);
            let file = self.folder.join(&relative);
            let id = identity(&file);
            if let Some(start) = self.chain.iter().position(|(_, known)| *known == id) {
                let chain = self.chain[start..].iter().map(|(path, _)| path.clone()).chain([file]).collect();
                return Err(refuse(IncludeError::Circle { chain }));
            }
            if self.chain.len() > DEEPEST {
                return Err(refuse(IncludeError::Deep));
            }
            if !self.known.insert(id.clone()) {
                continue;
            }
            let read = std::fs::read_to_string(&file);
            let text = read
                .map_err(|source| refuse(IncludeError::Read { file: file.clone(), source: source.into() }))?;
            // A mark of the byte order may stand at the head of a text alone.
            let text = text.trim_start_matches('\u{feff}').to_string();
            let folder = relative.parent().map(Path::to_path_buf).unwrap_or_default();
            self.chain.push((file.clone(), id));
            self.visit(Source { path: file, folder, text })?;
            self.chain.pop();
        }
        Ok(())
    }
}

/// The files that a file takes in, and where it says so.
fn included(source: &Source) -> Result<Vec<(String, usize)>, SceneError> {
    let error = |error: toml::de::Error| SceneError::parse(&source.path, &source.text, &error);
    let table = DeTable::parse(&source.text).map_err(error)?;
    let Some(value) = table.get_ref().get("include") else { return Ok(Vec::new()) };
    let name = |value: &Spanned<DeValue<'_>>| match value.get_ref() {
        DeValue::String(name) => Ok((name.to_string(), value.span().start)),
        _ => {
            let message = "`include` is the name of a file, or a list of names".into();
            Err(SceneError::parse_at(&source.path, &source.text, value.span().start, message))
        }
    };
    match value.get_ref() {
        DeValue::Array(names) => names.iter().map(name).collect(),
        _ => Ok(vec![name(value)?]),
    }
}

impl Document {
    /// The file at `path` with this text, and what it takes in.
    pub(super) fn new(text: &str, path: &Path) -> Result<Self, SceneError> {
        let id = identity(path);
        let mut gathering = Gathering {
            folder: path.parent().map(Path::to_path_buf).unwrap_or_default(),
            chain: vec![(path.into(), id.clone())],
            known: BTreeSet::from([id]),
            sources: Vec::new(),
        };
        let first = Source { path: path.into(), folder: PathBuf::new(), text: text.into() };
        gathering.visit(first)?;
        Ok(Self { sources: gathering.sources })
    }

    /// Reads all files as one value.
    pub(super) fn read<V: DeserializeOwned>(&self) -> Result<V, SceneError> {
        let mut texts = Vec::new();
        let mut start = 0;
        for source in &self.sources {
            texts.push(" ".repeat(start) + &source.text);
            start += source.text.len();
        }
        let mut merged = None::<Spanned<DeTable<'_>>>;
        for (source, text) in self.sources.iter().zip(&texts) {
            let mut table = DeTable::parse(text).map_err(|error| self.error(&error))?;
            place_files(table.get_mut(), &source.folder);
            match &mut merged {
                None => merged = Some(table),
                Some(merged) => merge(merged.get_mut(), table.into_inner()),
            }
        }
        let mut merged = merged.unwrap_or_else(|| Spanned::new(0..0, DeTable::new()));
        let names = self.sources[1..].iter().map(|source| {
            let name = source.path.file_name().unwrap_or_default();
            source.folder.join(name).to_string_lossy().into_owned()
        });
        let text = |name: String| Spanned::new(0..0, DeValue::String(Cow::Owned(name)));
        let names: DeArray<'_> = names.map(text).collect();
        if merged.get_ref().contains_key("include") {
            merged.get_mut().insert(
                Spanned::new(0..0, Cow::Borrowed("include")),
                Spanned::new(0..0, DeValue::Array(names)),
            );
        }
        V::deserialize(Deserializer::from(merged)).map_err(|error| self.error(&error))
    }

    /// An error where it stands.
    fn error(&self, error: &toml::de::Error) -> SceneError {
        let mut at = error.span().map_or(0, |span| span.start);
        for source in &self.sources {
            if at < source.text.len() {
                return SceneError::parse_at(&source.path, &source.text, at, error.message().into());
            }
            at -= source.text.len();
        }
        // Behind the last file: at its end.
        let (path, text) = self.sources.last().map_or((Path::new(""), ""), |last| (&*last.path, &last.text));
        SceneError::parse_at(path, text, text.len(), error.message().into())
    }
}

/// Whether a list is one of tables, and so may be continued.
fn is_of_tables(list: &DeArray<'_>) -> bool {
    list.iter().all(|entry| matches!(entry.get_ref(), DeValue::Table(_)))
}

/// Adds to a table what it does not say itself.
fn merge<'i>(over: &mut DeTable<'i>, under: DeTable<'i>) {
    for (key, value) in under {
        match over.get_mut(&key) {
            None => {
                over.insert(key, value);
            }
            Some(known) => match (known.get_mut(), value.into_inner()) {
                (DeValue::Table(known), DeValue::Table(more)) => merge(known, more),
                (DeValue::Array(known), DeValue::Array(more))
                    if is_of_tables(known) && is_of_tables(&more) =>
                {
                    more.into_iter().for_each(|entry| known.push(entry));
                }
                _ => {}
            },
        }
    }
}

/// Makes the names of mesh files, which start from the folder of the file they stand in, start from that of the first file.
fn place_files(table: &mut DeTable<'_>, folder: &Path) {
    if folder.as_os_str().is_empty() {
        return;
    }
    let places: Vec<_> = table.iter().map(|(key, _)| key.get_ref().to_string()).collect();
    for key in places {
        let Some(value) = table.get_mut(key.as_str()) else { continue };
        match value.get_mut() {
            DeValue::String(name) if FILES.contains(&&*key) => {
                *name = Cow::Owned(folder.join(&**name).to_string_lossy().into_owned());
            }
            DeValue::Table(table) => place_files(table, folder),
            DeValue::Array(list) => list.iter_mut().for_each(|entry| {
                if let DeValue::Table(table) = entry.get_mut() {
                    place_files(table, folder);
                }
            }),
            _ => {}
        }
    }
}
