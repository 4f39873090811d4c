//! Time series for ParaView: a VTU file per frame and a PVD file that lists them.

mod bodies;
mod elastic;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use vtkio::model::{Attribute, ByteOrder, DataArray, DataSet, UnstructuredGridPiece, Version, Vtk};

use super::{Frame, ObserveError, Observer, RunInfo};
use crate::file::AtomicFile;
use crate::scalar::{Scalar, to_f64};
use crate::system::Solid;

/// Writes `name/name_<frame>.vtu` every so many steps, and `name.pvd` at the end.
///
/// Of an elastic body points carry displacement, velocity, the contact percussion of the last step (global components),
/// and the opening (the gap where the node may touch, NaN elsewhere); elements carry the stress (xx, yy, xy) and the von
/// Mises stress.
///
/// Of rigid bodies, in space or in the plane, the surfaces are drawn where the bodies are: points carry the velocity, cells
/// the number of the body (−1 for what is fixed), its spin, and the number of the shape. The names behind these numbers are
/// in a comment of the PVD file. A second series of the same frames, [`contacts`](Self::CONTACTS), has the points where the
/// last step met: gap, percussion and normal (global components), interface, and status, 0 without percussion, 1 where it
/// holds or rolls, 2 where it slides.
///
/// Other systems have no frames.
#[derive(Debug)]
pub struct VtkSeries {
    folder: PathBuf,
    name: String,
    every: usize,
    times: Vec<f64>,
    /// The shapes of rigid bodies, once they were asked for.
    solids: Option<Vec<Solid>>,
}

impl VtkSeries {
    /// What the name of the series of contacts has behind that of the bodies.
    pub const CONTACTS: &str = "_contacts";

    /// A series in `folder`, which must exist, with a frame every `every` steps beside the first.
    pub fn new(folder: &Path, name: &str, every: usize) -> Self {
        let (folder, name) = (folder.into(), name.into());
        Self { folder, name, every: every.max(1), times: Vec::new(), solids: None }
    }

    /// Goes on behind frames written before, at these times.
    #[must_use]
    pub fn resume(mut self, times: Vec<f64>) -> Self {
        self.times = times;
        self
    }

    /// Times of the frames.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    fn write<T: Scalar, const D: usize>(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        if let Some(geometry) = frame.system.geometry() {
            self.write_frame(&self.name, elastic::piece(geometry, frame))?;
        } else {
            let solids = self.solids.take().unwrap_or_else(|| frame.system.solids());
            if !solids.is_empty() {
                self.write_frame(&self.name, bodies::surfaces(&solids, frame))?;
                let contacts = format!("{}{}", self.name, Self::CONTACTS);
                self.write_frame(&contacts, bodies::contacts(frame))?;
            }
            let none = solids.is_empty();
            self.solids = Some(solids);
            if none {
                return Ok(());
            }
        }
        self.times.push(to_f64(frame.state.time));
        Ok(())
    }

    /// Writes the next frame of the series `name`.
    fn write_frame(&self, name: &str, frame: Vtk) -> Result<(), ObserveError> {
        let path = self.folder.join(file(name, self.times.len()));
        let mut bytes = Vec::new();
        frame.write_xml(&mut bytes).map_err(|error| ObserveError::new(&path, error))?;
        // The library leaves out that there is nothing, which readers want to be told.
        let text = String::from_utf8_lossy(&bytes);
        let text = text.replacen("<Piece>", "<Piece NumberOfPoints=\"0\" NumberOfCells=\"0\">", 1);
        let save = || -> std::io::Result<()> {
            std::fs::create_dir_all(path.parent().unwrap_or(&self.folder))?;
            let mut file = AtomicFile::create(&path)?;
            file.write_all(text.as_bytes())?;
            file.commit()
        };
        save().map_err(|error| ObserveError::new(&path, error))
    }

    /// Writes the list of the frames of the series `name`.
    fn write_list(&self, name: &str, solids: &[Solid]) -> Result<(), ObserveError> {
        let path = self.folder.join(format!("{name}.pvd"));
        let write = || -> std::io::Result<()> {
            let mut list = AtomicFile::create(&path)?;
            writeln!(
                list,
                "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>"
            )?;
            for (number, solid) in solids.iter().enumerate() {
                let body = solid.body.map_or("the ground".into(), |body| format!("body {body}"));
                // Two hyphens would end the comment.
                let shape = solid.name.replace("--", "- -");
                writeln!(list, "<!-- shape {number} of {body}: {shape} -->")?;
            }
            for (frame, time) in self.times.iter().enumerate() {
                writeln!(list, "<DataSet timestep=\"{time:e}\" file=\"{}\"/>", file(name, frame))?;
            }
            writeln!(list, "</Collection>\n</VTKFile>")?;
            list.commit()
        };
        write().map_err(|error| ObserveError::new(&path, error))
    }
}

/// The file of a frame, below the folder of results.
fn file(name: &str, frame: usize) -> String {
    format!("{name}/{name}_{frame:05}.vtu")
}

/// A named array of tuples.
fn array<N: num_traits::ToPrimitive + 'static>(name: &str, components: u32, data: Vec<N>) -> Attribute {
    Attribute::DataArray(DataArray::scalars(name, components).with_vec(data))
}

fn grid(title: &str, piece: UnstructuredGridPiece) -> Vtk {
    Vtk {
        version: Version::new_xml(1, 0),
        title: title.into(),
        byte_order: ByteOrder::LittleEndian,
        file_path: None,
        data: DataSet::inline(piece),
    }
}

impl<T: Scalar, const D: usize> Observer<T, D> for VtkSeries {
    fn begin(&mut self, _run: &RunInfo, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        self.write(frame)
    }

    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        if frame.state.index.is_multiple_of(self.every) { self.write(frame) } else { Ok(()) }
    }

    fn end(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        if self.times.is_empty() {
            return Ok(());
        }
        if frame.system.geometry().is_some() {
            return self.write_list(&self.name, &[]);
        }
        let solids = self.solids.take().unwrap_or_else(|| frame.system.solids());
        self.write_list(&self.name, &solids)?;
        self.write_list(&format!("{}{}", self.name, Self::CONTACTS), &[])
    }
}
