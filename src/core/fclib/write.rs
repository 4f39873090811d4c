//! From a problem to a file.

use std::io::Write as _;
use std::path::Path;

use hdf5_pure::{
    AttrValue, CharacterSet, DatasetBuilder, Datatype, File, FileBuilder, GroupBuilder, LibVer, StringPadding,
};

use super::read::read_bytes;
use super::{Data, FclibError, Global, Local, Problem, Solution, SparseMatrix};
use crate::file::AtomicFile;

/// Shorter datasets are stored as they are: a chunk has its own cost.
const COMPRESSED_FROM: usize = 512;

/// How a file is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WriteOptions {
    /// gzip level (1–9) of datasets of 512 values and more; `None` stores everything plainly, in the format of HDF5 1.8.
    /// Default 6, which asks readers for HDF5 1.10.
    pub gzip: Option<u32>,
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self { gzip: Some(6) }
    }
}

/// Writes a problem with its guesses and its solution. An existing file is replaced only once the new one is whole.
///
/// Local matrices are written in compressed rows, global ones in triplets, the storages every FCLIB reader knows.
///
/// # Errors
/// [`Problem::check`], [`FclibError::Count`] beyond the int32 the layout counts with, [`FclibError::Io`].
pub fn write(path: impl AsRef<Path>, problem: &Problem, options: WriteOptions) -> Result<(), FclibError> {
    replace(path.as_ref(), &write_bytes(problem, options)?)
}

/// The bytes [`write`](write()) puts into the file.
///
/// # Errors
/// As [`write`](write()), but for the file.
pub fn write_bytes(problem: &Problem, options: WriteOptions) -> Result<Vec<u8>, FclibError> {
    problem.check()?;
    let mut writer = Writer { gzip: options.gzip.map(|level| level.clamp(1, 9)), compressed: false };
    let mut file = FileBuilder::new();
    let local = matches!(problem.data, Data::Local(_));
    let mut root = file.create_group(if local { "fclib_local" } else { "fclib_global" });
    writer.integers(root.create_dataset("spacedim"), &[problem.dimension as i32]);
    let mut vectors = root.create_group("vectors");
    writer.reals(vectors.create_dataset("mu"), &problem.friction);
    match &problem.data {
        Data::Local(Local { delassus, velocity, bilateral }) => {
            writer.matrix(&mut root, "W", delassus, false)?;
            writer.reals(vectors.create_dataset("q"), velocity);
            if let Some(bilateral) = bilateral {
                writer.matrix(&mut root, "V", &bilateral.directions, false)?;
                writer.matrix(&mut root, "R", &bilateral.compliance, false)?;
                writer.reals(vectors.create_dataset("s"), &bilateral.velocity);
            }
        }
        Data::Global(Global { mass, directions, force, velocity, bilateral }) => {
            writer.matrix(&mut root, "M", mass, true)?;
            writer.matrix(&mut root, "H", directions, true)?;
            writer.reals(vectors.create_dataset("f"), force);
            writer.reals(vectors.create_dataset("w"), velocity);
            if let Some(bilateral) = bilateral {
                writer.matrix(&mut root, "G", &bilateral.directions, true)?;
                writer.reals(vectors.create_dataset("b"), &bilateral.velocity);
            }
        }
    }
    root.add_group(vectors.finish());
    let mut info = root.create_group("info");
    info.set_attr("numberOfContacts", AttrValue::I32Array(vec![int32("mu", problem.contacts())?]));
    let texts = [
        ("title", &problem.info.title),
        ("description", &problem.info.description),
        ("math_info", &problem.info.math_info),
    ];
    for (name, text) in texts {
        if let Some(text) = text {
            write_text(info.create_dataset(name), text);
        }
    }
    root.add_group(info.finish());
    file.add_group(root.finish());

    if !problem.guesses.is_empty() {
        let mut guesses = file.create_group("guesses");
        let number = int32("guesses", problem.guesses.len())?;
        writer.integers(guesses.create_dataset("number_of_guesses"), &[number]);
        for (k, guess) in problem.guesses.iter().enumerate() {
            let mut group = guesses.create_group(&(k + 1).to_string());
            writer.solution(&mut group, guess);
            guesses.add_group(group.finish());
        }
        file.add_group(guesses.finish());
    }
    if let Some(solution) = &problem.solution {
        let mut group = file.create_group("solution");
        writer.solution(&mut group, solution);
        file.add_group(group.finish());
    }
    if !writer.compressed {
        file.with_libver_bounds(LibVer::Earliest, LibVer::V18);
    }
    file.finish().map_err(|e| failed("/", &e))
}

/// Puts a solution into a file that holds the problem it solves, in place of one it may already hold; the rest of the
/// file is left as it is, and the file is replaced only once the new one has been read back.
///
/// # Errors
/// Reading as [`read`](super::read()); [`FclibError::Length`] where the solution is not one of this problem;
/// [`FclibError::Io`].
pub fn write_solution(path: impl AsRef<Path>, solution: &Solution) -> Result<(), FclibError> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|source| FclibError::Io { path: path.into(), source })?;
    let mut problem = read_bytes(bytes.clone())?;
    let had_one = problem.solution.is_some();
    problem.solution = Some(solution.clone());
    problem.check()?;

    let bytes = insert(&bytes, solution, had_one).map_err(|e| failed("solution", &e))?;
    if read_bytes(bytes.clone())? != problem {
        let message = "the file did not read back as it was written".into();
        return Err(FclibError::Hdf5 { at: "solution".into(), message });
    }
    replace(path, &bytes)
}

/// The file `bytes` with the group `solution`, edited in a temporary copy.
fn insert(bytes: &[u8], solution: &Solution, replaces: bool) -> Result<Vec<u8>, hdf5_pure::Error> {
    let copy = tempfile::NamedTempFile::new()?;
    std::fs::write(copy.path(), bytes)?;
    let file = File::open_rw(copy.path())?;
    if replaces {
        file.root().delete("solution")?;
    }
    let mut writer = Writer { gzip: None, compressed: false };
    file.root().create_group_with("solution", |group| {
        for (name, values) in parts(solution) {
            group.create_dataset(name, |dataset| writer.reals(dataset, values));
        }
    })?;
    file.commit()?;
    file.close()?;
    Ok(std::fs::read(copy.path())?)
}

fn replace(path: &Path, bytes: &[u8]) -> Result<(), FclibError> {
    let write = || {
        let mut file = AtomicFile::create(path)?;
        file.write_all(bytes)?;
        file.commit()
    };
    write().map_err(|source| FclibError::Io { path: path.into(), source })
}

fn failed(at: &str, error: &hdf5_pure::Error) -> FclibError {
    FclibError::Hdf5 { at: at.into(), message: error.to_string() }
}

fn int32(dataset: &str, value: usize) -> Result<i32, FclibError> {
    let refused =
        || FclibError::Count { dataset: dataset.into(), value: i64::try_from(value).unwrap_or(i64::MAX) };
    i32::try_from(value).map_err(|_| refused())
}

/// The vectors of a solution under the names of the layout.
fn parts(solution: &Solution) -> impl Iterator<Item = (&'static str, &[f64])> {
    let optional = [("v", &solution.body_velocities), ("l", &solution.multipliers)];
    let given = [("u", &solution.velocities[..]), ("r", &solution.percussions[..])];
    optional.into_iter().filter_map(|(name, values)| Some((name, values.as_deref()?))).chain(given)
}

/// A null-terminated scalar string, as `H5LTmake_dataset_string` writes it.
fn write_text(dataset: &mut DatasetBuilder, text: &str) {
    let bytes: Vec<u8> = text.bytes().take_while(|&byte| byte != 0).chain([0]).collect();
    // Texts are bounded by the memory that holds them; the type's size field ends at 4 GiB.
    let size = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
    let charset = if text.is_ascii() { CharacterSet::Ascii } else { CharacterSet::Utf8 };
    let kind = Datatype::String { size, padding: StringPadding::NullTerminate, charset };
    dataset.with_raw_data(kind, bytes, 1).with_shape(&[]);
}

struct Writer {
    gzip: Option<u32>,
    compressed: bool,
}

impl Writer {
    fn pack(&mut self, dataset: &mut DatasetBuilder, length: usize) {
        if let (Some(level), true) = (self.gzip, length >= COMPRESSED_FROM) {
            dataset.with_chunks(&[length as u64]).with_deflate(level);
            self.compressed = true;
        }
    }

    fn reals(&mut self, dataset: &mut DatasetBuilder, values: &[f64]) {
        dataset.with_f64_data(values);
        self.pack(dataset, values.len());
    }

    fn integers(&mut self, dataset: &mut DatasetBuilder, values: &[i32]) {
        dataset.with_i32_data(values);
        self.pack(dataset, values.len());
    }

    fn matrix(
        &mut self,
        root: &mut GroupBuilder,
        name: &str,
        matrix: &SparseMatrix,
        triplets: bool,
    ) -> Result<(), FclibError> {
        let count = |value| int32(name, value);
        let (starts, columns, values) = matrix.parts();
        let stored = count(values.len())?;
        let mut group = root.create_group(name);
        let sizes = [
            ("m", count(matrix.rows())?),
            ("n", count(matrix.columns())?),
            ("nzmax", stored),
            ("nz", if triplets { stored } else { -2 }),
        ];
        sizes.iter().for_each(|&(name, value)| self.integers(group.create_dataset(name), &[value]));
        let columns: Vec<i32> = columns.iter().map(|&j| j as i32).collect();
        if triplets {
            let rows: Vec<i32> = matrix.entries().map(|(i, _, _)| i as i32).collect();
            self.integers(group.create_dataset("i"), &rows);
            self.integers(group.create_dataset("p"), &columns);
        } else {
            let starts: Vec<i32> = starts.iter().map(|&start| start as i32).collect();
            self.integers(group.create_dataset("p"), &starts);
            self.integers(group.create_dataset("i"), &columns);
        }
        self.reals(group.create_dataset("x"), values);
        root.add_group(group.finish());
        Ok(())
    }

    fn solution(&mut self, group: &mut GroupBuilder, solution: &Solution) {
        for (name, values) in parts(solution) {
            self.reals(group.create_dataset(name), values);
        }
    }
}
