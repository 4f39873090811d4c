//! From a file to its content.

use std::path::Path;

use super::sparse::Header;
use super::store::Store;
use super::{
    Data, FclibError, Global, GlobalBilateral, Info, Local, LocalBilateral, Problem, Solution, SparseMatrix,
};

/// Reads an FCLIB file, local or global; of a file that holds both, the local problem.
///
/// # Errors
/// Every [`FclibError`] that concerns reading; no input makes it panic.
pub fn read(path: impl AsRef<Path>) -> Result<Problem, FclibError> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|source| FclibError::Io { path: path.into(), source })?;
    read_bytes(bytes)
}

/// [`read`] from the bytes of a file.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(bytes: Vec<u8>) -> Result<Problem, FclibError> {
    let mut store = Store::new(bytes)?;
    let local = store.has_group("fclib_local")?;
    if !local && !store.has_group("fclib_global")? {
        return Err(FclibError::NotFclib);
    }
    let root = if local { "fclib_local" } else { "fclib_global" };
    let dimension = dimension(&mut store, root)?;
    let (data, sizes) = if local {
        read_local(&mut store, root, dimension)?
    } else {
        read_global(&mut store, root, dimension)?
    };
    let friction = store.reals(&format!("{root}/vectors/mu"), &[sizes.local / dimension])?;
    let info = Info {
        title: store.text(&format!("{root}/info/title"))?,
        description: store.text(&format!("{root}/info/description"))?,
        math_info: store.text(&format!("{root}/info/math_info"))?,
    };
    let guesses = read_guesses(&mut store, &sizes)?;
    let solution = match store.has_group("solution")? {
        true => Some(read_solution(&mut store, "solution", &sizes)?),
        false => None,
    };
    let problem = Problem { info, dimension, friction, data, guesses, solution };
    problem.check()?;
    Ok(problem)
}

fn dimension(store: &mut Store, root: &str) -> Result<usize, FclibError> {
    let dataset = format!("{root}/spacedim");
    match store.integer(&dataset)? {
        2 => Ok(2),
        3 => Ok(3),
        value => Err(FclibError::Dimension { dataset, value }),
    }
}

/// Lengths of the vectors of a solution.
struct Sizes {
    bodies: usize,
    local: usize,
    multipliers: usize,
}

fn square(store: &mut Store, path: &str) -> Result<Header, FclibError> {
    let header = Header::read(store, path)?;
    if header.rows == header.columns { Ok(header) } else { Err(header.refuse("a square matrix")) }
}

/// A matrix of `rows` rows, read only where its shape fits.
fn matrix(store: &mut Store, path: &str, rows: usize, columns: usize) -> Result<SparseMatrix, FclibError> {
    let header = Header::read(store, path)?;
    if (header.rows, header.columns) != (rows, columns) {
        return Err(header.refuse(format!("{rows} × {columns}")));
    }
    header.body(store)
}

fn contacts_of(header: &Header, size: usize, dimension: usize) -> Result<(), FclibError> {
    match size % dimension {
        0 => Ok(()),
        _ => Err(header.refuse(format!("a multiple of spacedim = {dimension}"))),
    }
}

fn read_local(store: &mut Store, root: &str, dimension: usize) -> Result<(Data, Sizes), FclibError> {
    let w = square(store, &format!("{root}/W"))?;
    contacts_of(&w, w.rows, dimension)?;
    let velocity = store.reals(&format!("{root}/vectors/q"), &[w.rows])?;
    let delassus = w.body(store)?;
    let has_r = store.has_group(&format!("{root}/R"))?;
    let has_v = store.has_group(&format!("{root}/V"))?;
    let bilateral = if has_r || has_v {
        let r = square(store, &format!("{root}/R"))?;
        let velocity = store.reals(&format!("{root}/vectors/s"), &[r.rows])?;
        let compliance = r.body(store)?;
        let directions = matrix(store, &format!("{root}/V"), w.rows, r.rows)?;
        Some(LocalBilateral { directions, compliance, velocity })
    } else {
        None
    };
    let multipliers = bilateral.as_ref().map_or(0, |b| b.velocity.len());
    let sizes = Sizes { bodies: 0, local: w.rows, multipliers };
    Ok((Data::Local(Local { delassus, velocity, bilateral }), sizes))
}

fn read_global(store: &mut Store, root: &str, dimension: usize) -> Result<(Data, Sizes), FclibError> {
    let m = square(store, &format!("{root}/M"))?;
    let force = store.reals(&format!("{root}/vectors/f"), &[m.rows])?;
    let mass = m.body(store)?;
    let h = Header::read(store, &format!("{root}/H"))?;
    if h.rows != m.rows {
        return Err(h.refuse(format!("{} rows, as M,", m.rows)));
    }
    contacts_of(&h, h.columns, dimension)?;
    let velocity = store.reals(&format!("{root}/vectors/w"), &[h.columns])?;
    let directions = h.body(store)?;
    let bilateral = if store.has_group(&format!("{root}/G"))? {
        let g = Header::read(store, &format!("{root}/G"))?;
        if g.rows != m.rows {
            return Err(g.refuse(format!("{} rows, as M,", m.rows)));
        }
        let velocity = store.reals(&format!("{root}/vectors/b"), &[g.columns])?;
        Some(GlobalBilateral { directions: g.body(store)?, velocity })
    } else {
        None
    };
    let multipliers = bilateral.as_ref().map_or(0, |b| b.velocity.len());
    let sizes = Sizes { bodies: m.rows, local: h.columns, multipliers };
    Ok((Data::Global(Global { mass, directions, force, velocity, bilateral }), sizes))
}

fn read_guesses(store: &mut Store, sizes: &Sizes) -> Result<Vec<Solution>, FclibError> {
    if !store.has_group("guesses")? {
        return Ok(Vec::new());
    }
    let number = store.count("guesses/number_of_guesses")?;
    // Every guess is a group that must be there, so a lie about their number ends with the first one missing.
    (1..=number).map(|guess| read_solution(store, &format!("guesses/{guess}"), sizes)).collect()
}

fn read_solution(store: &mut Store, root: &str, sizes: &Sizes) -> Result<Solution, FclibError> {
    let mut optional = |name: &str, length: usize| -> Result<Option<Vec<f64>>, FclibError> {
        let path = format!("{root}/{name}");
        let present = length > 0 && store.has_dataset(&path)?;
        if present { store.reals(&path, &[length]).map(Some) } else { Ok(None) }
    };
    let body_velocities = optional("v", sizes.bodies)?;
    let multipliers = optional("l", sizes.multipliers)?;
    let velocities = store.reals(&format!("{root}/u"), &[sizes.local])?;
    let percussions = store.reals(&format!("{root}/r"), &[sizes.local])?;
    Ok(Solution { percussions, velocities, body_velocities, multipliers })
}
