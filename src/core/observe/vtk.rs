//! Time series of an elastic body for ParaView: a VTU file per frame and a PVD file that lists them.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataArray, DataSet, UnstructuredGridPiece, Version,
    VertexNumbers, Vtk,
};

use super::{Frame, ObserveError, Observer, RunInfo};
use crate::file::AtomicFile;
use crate::mesh::Shape;
use crate::scalar::{Scalar, to_f64};
use crate::system::Geometry;

/// Writes `name/name_<frame>.vtu` every so many steps, and `name.pvd` at the end.
///
/// Points carry displacement, velocity, the contact percussion of the last step (global components), and the
/// opening (the gap where the node may touch, NaN elsewhere); elements carry the stress (xx, yy, xy) and the von Mises
/// stress. Systems without a mesh have no frames.
#[derive(Debug)]
pub struct VtkSeries {
    folder: PathBuf,
    name: String,
    every: usize,
    times: Vec<f64>,
}

impl VtkSeries {
    /// A series in `folder`, which must exist, with a frame every `every` steps beside the first.
    pub fn new(folder: &Path, name: &str, every: usize) -> Self {
        Self { folder: folder.into(), name: name.into(), every: every.max(1), times: Vec::new() }
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

    fn file(&self, frame: usize) -> String {
        format!("{}/{}_{frame:05}.vtu", self.name, self.name)
    }

    fn write<T: Scalar, const D: usize>(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        let Some(geometry) = frame.system.geometry() else { return Ok(()) };
        let path = self.folder.join(self.file(self.times.len()));
        let mut bytes = Vec::new();
        piece(geometry, frame).write_xml(&mut bytes).map_err(|error| ObserveError::new(&path, error))?;
        let save = || -> std::io::Result<()> {
            std::fs::create_dir_all(path.parent().unwrap_or(&self.folder))?;
            let mut file = AtomicFile::create(&path)?;
            file.write_all(&bytes)?;
            file.commit()
        };
        save().map_err(|error| ObserveError::new(&path, error))?;
        self.times.push(to_f64(frame.state.time));
        Ok(())
    }

    fn write_list(&self) -> Result<(), ObserveError> {
        let path = self.folder.join(format!("{}.pvd", self.name));
        let write = || -> std::io::Result<()> {
            let mut file = AtomicFile::create(&path)?;
            writeln!(
                file,
                "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>"
            )?;
            for (frame, time) in self.times.iter().enumerate() {
                writeln!(file, "<DataSet timestep=\"{time:e}\" file=\"{}\"/>", self.file(frame))?;
            }
            writeln!(file, "</Collection>\n</VTKFile>")?;
            file.commit()
        };
        write().map_err(|error| ObserveError::new(&path, error))
    }
}

fn piece<T: Scalar, const D: usize>(geometry: &Geometry<T>, frame: Frame<'_, T, D>) -> Vtk {
    let (mesh, state) = (geometry.mesh(), frame.state);
    let nodes = mesh.nodes();
    let points: Vec<f64> = nodes.iter().flat_map(|node| [node.position[0], node.position[1], 0.0]).collect();
    let vectors = |x: &[T]| -> Vec<f64> {
        let at = |node| geometry.at_node(node, x);
        (0..nodes.len()).flat_map(|node| [to_f64(at(node)[0]), to_f64(at(node)[1]), 0.0]).collect()
    };
    let mut percussions = vec![0.0; 3 * nodes.len()];
    let mut rows = crate::linalg::BlockRows::<T, D>::new();
    let mut impulse = vec![T::zero(); state.q.len()];
    for (row, contact) in frame.step.contacts.iter().enumerate() {
        frame.system.jacobian(contact.id, &state.q, &mut rows);
        rows.add_transpose(row, &contact.percussion, &mut impulse);
    }
    percussions.copy_from_slice(&vectors(&impulse));
    let mut opening = vec![f64::NAN; nodes.len()];
    for (node, gap) in geometry.gaps(&state.q) {
        // Of several obstacles the nearest.
        opening[node] = opening[node].min(to_f64(gap));
    }
    let (mut connectivity, mut offsets, mut types) = (Vec::new(), Vec::new(), Vec::new());
    for element in mesh.body() {
        connectivity.extend(element.shape.nodes().iter().map(|&node| node as u64));
        offsets.push(connectivity.len() as u64);
        types.push(match element.shape {
            Shape::Point(_) => CellType::Vertex,
            Shape::Segment(_) => CellType::Line,
            Shape::Triangle(_) => CellType::Triangle,
        });
    }
    let stresses = geometry.stresses(&state.q);
    let stress: Vec<f64> = stresses.iter().flat_map(|(stress, _)| stress.map(to_f64)).collect();
    let mises: Vec<f64> = stresses.iter().map(|&(_, mises)| to_f64(mises)).collect();
    let array = |name: &str, components: u32, data: Vec<f64>| {
        Attribute::DataArray(DataArray::scalars(name, components).with_vec(data))
    };
    let data = Attributes {
        point: vec![
            array("displacement", 3, vectors(&state.q)),
            array("velocity", 3, vectors(&state.v)),
            array("percussion", 3, percussions),
            array("opening", 1, opening),
        ],
        cell: vec![array("stress", 3, stress), array("von Mises", 1, mises)],
    };
    let cells = Cells { cell_verts: VertexNumbers::XML { connectivity, offsets }, types };
    Vtk {
        version: Version::new_xml(1, 0),
        title: geometry.name().into(),
        byte_order: ByteOrder::LittleEndian,
        file_path: None,
        data: DataSet::inline(UnstructuredGridPiece { points: points.into(), cells, data }),
    }
}

impl<T: Scalar, const D: usize> Observer<T, D> for VtkSeries {
    fn begin(&mut self, _run: &RunInfo, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        self.write(frame)
    }

    fn step(&mut self, frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        if frame.state.index.is_multiple_of(self.every) { self.write(frame) } else { Ok(()) }
    }

    fn end(&mut self, _frame: Frame<'_, T, D>) -> Result<(), ObserveError> {
        if self.times.is_empty() { Ok(()) } else { self.write_list() }
    }
}
