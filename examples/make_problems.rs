//! Writes the problems of `tests/data`: `cargo run --example make_problems [FOLDER]`.

#[path = "../tests/problems/mod.rs"]
mod problems;

use std::path::PathBuf;

use nonsmooth::fclib::{FclibError, WriteOptions, write};

fn main() -> Result<(), FclibError> {
    let folder = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("tests/data"), PathBuf::from);
    std::fs::create_dir_all(&folder).map_err(|source| FclibError::Io { path: folder.clone(), source })?;
    for problems::Named { name, problem } in problems::all()? {
        let file = folder.join(format!("{name}.hdf5"));
        write(&file, &problem, WriteOptions::default())?;
        println!("{}: {} contacts, dimension {}", file.display(), problem.contacts(), problem.dimension);
    }
    Ok(())
}
