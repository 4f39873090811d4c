//! Rigid bodies: their surfaces where they are, and the points where they touch.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use vtkio::model::{Attributes, CellType, Cells, UnstructuredGridPiece, VertexNumbers, Vtk};

use super::{array, grid};
use crate::observe::Frame;
use crate::scalar::{Scalar, to_f64};
use crate::system::Solid;

/// Speed of slip, as a share of that of the scene, below which a contact holds.
const HOLDS: f64 = 1e-6;

/// Endless planes are drawn in squares of this many times the least power of two beyond the size of the scene.
const FAR: f64 = 2.0;

type Point = Vector3<f64>;

/// Where a body is, and how it moves: pose, velocity (m/s) and spin (rad/s) along fixed axes.
#[derive(Clone, Copy)]
struct Motion {
    origin: Point,
    turn: UnitQuaternion<f64>,
    velocity: Point,
    spin: Point,
}

impl Motion {
    fn of<T: Scalar, const D: usize>(body: Option<usize>, frame: Frame<'_, T, D>) -> Self {
        let (system, state) = (frame.system, frame.state);
        let Some(body) = body else {
            let [origin, velocity, spin] = [Point::zeros(); 3];
            return Self { origin, turn: UnitQuaternion::identity(), velocity, spin };
        };
        let (origin, [w, i, j, k]) = system.body_pose(body, &state.q);
        let (velocity, spin) = system.body_velocity(body, &state.q, &state.v);
        // Poses are unit quaternions.
        let turn = UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k));
        Self { origin: origin.into(), turn, velocity: velocity.into(), spin: spin.into() }
    }

    fn place(&self, x: &[f64; 3]) -> Point {
        self.origin + self.turn * Point::from(*x)
    }

    fn velocity_at(&self, x: &[f64; 3]) -> Point {
        self.velocity + self.spin.cross(&(self.turn * Point::from(*x)))
    }
}

/// Middle and size of what moves.
fn extent<T: Scalar, const D: usize>(solids: &[Solid], frame: Frame<'_, T, D>) -> (Point, f64) {
    let (mut low, mut high) = (Point::repeat(f64::INFINITY), Point::repeat(f64::NEG_INFINITY));
    for solid in solids.iter().filter(|solid| !solid.endless && solid.body.is_some()) {
        let motion = Motion::of(solid.body, frame);
        for x in solid.surface.points.iter().map(|x| motion.place(x)) {
            for i in (0..3).filter(|&i| x[i].is_finite()) {
                (low[i], high[i]) = (low[i].min(x[i]), high[i].max(x[i]));
            }
        }
    }
    if !(0..3).all(|i| low[i] <= high[i]) {
        return (Point::zeros(), 1.0);
    }
    let size = (high - low).max();
    ((low + high) * 0.5, if size > 0.0 { size } else { 1.0 })
}

/// The points of a plane so large that the scene is on it. Sizes and places are those of a grid that frames have in common,
/// so that it seldom changes.
fn stretched(points: &[Point], (middle, size): (Point, f64)) -> Vec<Point> {
    let half = FAR * size.log2().ceil().clamp(-1000.0, 1000.0).exp2();
    let centre = points.iter().sum::<Point>() / points.len() as f64;
    // The edges from the first point are orthogonal.
    let edge = |to: usize| (points[to] - points[0]).try_normalize(0.0);
    let last = points.len().saturating_sub(1);
    let axes: Vec<Point> = [1, last].into_iter().take(last.min(2)).filter_map(edge).collect();
    let mut foot = centre;
    for axis in &axes {
        let along = ((middle - centre).dot(axis) / half).round() * half;
        foot += axis * along;
    }
    // One metre becomes two halves.
    points.iter().map(|x| foot + (x - centre) * (2.0 * half)).collect()
}

/// The surfaces of the shapes in the state of `frame`.
pub(super) fn surfaces<T: Scalar, const D: usize>(solids: &[Solid], frame: Frame<'_, T, D>) -> Vtk {
    let (mut points, mut velocities) = (Vec::<f32>::new(), Vec::<f32>::new());
    let (mut connectivity, mut offsets, mut types) = (Vec::<u64>::new(), Vec::<u64>::new(), Vec::new());
    let (mut bodies, mut shapes, mut spins) = (Vec::<i32>::new(), Vec::<i32>::new(), Vec::<f32>::new());
    let mut around = None;
    for (number, solid) in solids.iter().enumerate() {
        let (surface, motion) = (&solid.surface, Motion::of(solid.body, frame));
        let first = (points.len() / 3) as u64;
        let mut placed: Vec<Point> = surface.points.iter().map(|x| motion.place(x)).collect();
        if solid.endless {
            placed = stretched(&placed, *around.get_or_insert_with(|| extent(solids, frame)));
        }
        points.extend(placed.iter().flatten().map(|&x| x as f32));
        for velocity in surface.points.iter().map(|x| motion.velocity_at(x)) {
            velocities.extend(velocity.iter().map(|&x| x as f32));
        }
        let mut cell = |kind, corners: &[u32]| {
            connectivity.extend(corners.iter().map(|&corner| first + u64::from(corner)));
            offsets.push(connectivity.len() as u64);
            types.push(kind);
            bodies.push(solid.body.map_or(-1, |body| body as i32));
            shapes.push(number as i32);
            spins.extend(motion.spin.iter().map(|&x| x as f32));
        };
        for face in &surface.faces {
            let kind = match face.len() {
                3 => CellType::Triangle,
                4 => CellType::Quad,
                _ => CellType::Polygon,
            };
            cell(kind, face);
        }
        // Lines beside the faces of a round shape are for its page alone.
        if surface.faces.is_empty() {
            for line in &surface.lines {
                line.windows(2).for_each(|ends| cell(CellType::Line, ends));
            }
            if surface.lines.is_empty() {
                (0..surface.points.len() as u32).for_each(|point| cell(CellType::Vertex, &[point]));
            }
        }
    }
    let data = Attributes {
        point: vec![array("velocity", 3, velocities)],
        cell: vec![array("body", 1, bodies), array("shape", 1, shapes), array("spin", 3, spins)],
    };
    let cells = Cells { cell_verts: VertexNumbers::XML { connectivity, offsets }, types };
    grid("bodies", UnstructuredGridPiece { points: points.into(), cells, data })
}

/// The contacts of the last step that have a place.
pub(super) fn contacts<T: Scalar, const D: usize>(frame: Frame<'_, T, D>) -> Vtk {
    let (mut points, mut normals, mut percussions) =
        (Vec::<f64>::new(), Vec::<f64>::new(), Vec::<f64>::new());
    let (mut gaps, mut statuses, mut interfaces) = (Vec::<f64>::new(), Vec::<i32>::new(), Vec::<i32>::new());
    let speed = to_f64(frame.system.scales(&frame.state.q, &frame.state.v).speed);
    for contact in &frame.step.contacts {
        let Some(place) = frame.system.contact_place(contact.id, &frame.state.q) else { continue };
        let axes = place.axes.iter().zip(contact.percussion.iter());
        let percussion: Point = axes.map(|(&axis, &p)| Point::from(axis) * to_f64(p)).sum();
        let tangential = (1..D.min(3)).map(|k| to_f64(contact.percussion[k]));
        let friction = tangential.map(|p| p * p).sum::<f64>().sqrt();
        // The speed along which friction works, or where there is none that of the points.
        let slip = if friction > 0.0 {
            to_f64(contact.tangential_work).abs() / friction
        } else {
            (1..D.min(3)).map(|k| to_f64(contact.after[k]).powi(2)).sum::<f64>().sqrt()
        };
        points.extend(place.point);
        normals.extend(place.axes[0]);
        percussions.extend(percussion.iter());
        gaps.push(to_f64(contact.gap));
        statuses.push(match contact.percussion[0] > T::zero() {
            false => 0,
            true => 1 + i32::from(slip > HOLDS * speed),
        });
        interfaces.push(contact.interface as i32);
    }
    let count = gaps.len() as u64;
    let cells = Cells {
        cell_verts: VertexNumbers::XML { connectivity: (0..count).collect(), offsets: (1..=count).collect() },
        types: vec![CellType::Vertex; gaps.len()],
    };
    let data = Attributes {
        point: vec![
            array("gap", 1, gaps),
            array("percussion", 3, percussions),
            array("normal", 3, normals),
            array("status", 1, statuses),
            array("interface", 1, interfaces),
        ],
        cell: Vec::new(),
    };
    grid("contacts", UnstructuredGridPiece { points: points.into(), cells, data })
}
