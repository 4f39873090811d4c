//! An elastic body: its mesh with what moves at the nodes and what is stressed in the elements.

use vtkio::model::{Attributes, CellType, Cells, UnstructuredGridPiece, VertexNumbers, Vtk};

use super::{array, grid};
use crate::mesh::Shape;
use crate::observe::Frame;
use crate::scalar::{Scalar, to_f64};
use crate::system::Geometry;

/// The frame of a system with this mesh.
pub(super) fn piece<T: Scalar, const D: usize>(geometry: &Geometry<T>, frame: Frame<'_, T, D>) -> Vtk {
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
    grid(geometry.name(), UnstructuredGridPiece { points: points.into(), cells, data })
}
