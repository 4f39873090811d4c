//! Triangulations of a rectangle.

use std::collections::BTreeMap;

use super::{Element, LARGEST, Mesh, MeshError, Node, Shape};

/// How a rectangle is triangulated.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "scene", derive(serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum Pattern {
    /// Nodes on a staggered lattice, nearly equilateral, triangulated by Delaunay (the library `spade`). Default.
    #[default]
    Quality,
    /// A grid of right triangles with alternating diagonals; needs no library, and grows without effort.
    Structured,
}

/// The rectangle [0, width] × [0, height] with edges of about `size`, and the groups `bottom`, `right`, `top`,
/// `left` (lines, equally spaced) and `body`.
///
/// # Errors
/// [`MeshError::OutOfRange`]; [`MeshError::Format`] for [`Pattern::Quality`] without the feature `mesher`.
pub fn rectangle(width: f64, height: f64, size: f64, pattern: Pattern) -> Result<Mesh, MeshError> {
    let values = [("the width", width), ("the height", height), ("the size of elements", size)];
    for (what, value) in values {
        if !(value.is_finite() && value > 0.0) {
            return Err(MeshError::OutOfRange { what, value, range: "finite and > 0" });
        }
    }
    let count = |length: f64| (length / size).round().max(1.0);
    let (nx, ny) = (count(width), count(height));
    // Written so that an overflow of the quotient fails as well.
    if !(nx * ny <= LARGEST as f64 / 4.0) {
        let (what, range) = ("the number of elements", "at most 10⁷: choose a larger size");
        return Err(MeshError::OutOfRange { what, value: 2.0 * nx * ny, range });
    }
    let (nx, ny) = (nx as usize, ny as usize);
    let (positions, triangles) = match pattern {
        Pattern::Structured => structured([width, height], [nx, ny]),
        Pattern::Quality => quality([width, height], [nx, ny])?,
    };
    assemble(positions, triangles, [width, height])
}

type Parts = (Vec<[f64; 2]>, Vec<[usize; 3]>);

/// The point `i` of `n` on a side of length `length`; both ends exactly.
fn on_side(i: usize, n: usize, length: f64) -> f64 {
    length * (i as f64 / n as f64)
}

fn structured([width, height]: [f64; 2], [nx, ny]: [usize; 2]) -> Parts {
    let row = nx + 1;
    let place = |i: usize| [on_side(i % row, nx, width), on_side(i / row, ny, height)];
    let positions = (0..row * (ny + 1)).map(place).collect();
    let cells = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
    let triangles = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [j * row + i, j * row + i + 1, (j + 1) * row + i + 1, (j + 1) * row + i];
        if (i + j).is_multiple_of(2) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    });
    (positions, triangles.collect())
}

/// Boundary nodes at equal spacing, inner nodes on a staggered lattice, Delaunay triangles.
#[cfg(feature = "mesher")]
fn quality([width, height]: [f64; 2], [nx, ny]: [usize; 2]) -> Result<Parts, MeshError> {
    use spade::{DelaunayTriangulation, Point2, Triangulation as _};

    let mut positions: Vec<[f64; 2]> = Vec::new();
    positions.extend((0..nx).map(|i| [on_side(i, nx, width), 0.0]));
    positions.extend((0..ny).map(|j| [width, on_side(j, ny, height)]));
    positions.extend((0..nx).map(|i| [on_side(nx - i, nx, width), height]));
    positions.extend((0..ny).map(|j| [0.0, on_side(ny - j, ny, height)]));
    let spacing = (width / nx as f64).min(height / ny as f64);
    // Rows of an equilateral lattice, stretched to fit the height.
    let rows = (height / (spacing * 0.75_f64.sqrt())).round().max(1.0);
    // A side much shorter than the size of the elements makes the lattice as fine as itself.
    let nodes = rows * (width / spacing);
    if !(nodes <= LARGEST as f64 / 4.0) {
        let (what, range) = ("the number of elements", "at most 10⁷: choose a size below the shorter side");
        return Err(MeshError::OutOfRange { what, value: 2.0 * nodes, range });
    }
    let rows = rows as usize;
    for row in 1..rows {
        let y = on_side(row, rows, height);
        let shift = if row % 2 == 1 { 0.5 } else { 0.0 };
        let columns = (width / spacing).round() as usize;
        for column in 0..=columns {
            let x = (column as f64 + shift) * width / columns as f64;
            // Nodes too near a side would make slivers with the nodes on it.
            if x > 0.45 * spacing && x < width - 0.45 * spacing {
                positions.push([x, y]);
            }
        }
    }
    let failed = |error: &dyn std::fmt::Display| MeshError::Format { line: 0, message: error.to_string() };
    let points = positions.iter().map(|&[x, y]| Point2::new(x, y)).collect();
    let mesh = DelaunayTriangulation::<Point2<f64>>::bulk_load_stable(points).map_err(|e| failed(&e))?;
    let order: Vec<[f64; 2]> = mesh.vertices().map(|v| [v.position().x, v.position().y]).collect();
    let triangles = mesh.inner_faces().map(|face| face.vertices().map(|v| v.index())).collect();
    Ok((order, triangles))
}

#[cfg(not(feature = "mesher"))]
fn quality(_: [f64; 2], _: [usize; 2]) -> Result<Parts, MeshError> {
    let message = "quality triangulations need the feature `mesher`; take the structured pattern".into();
    Err(MeshError::Format { line: 0, message })
}

fn assemble(
    positions: Vec<[f64; 2]>,
    triangles: Vec<[usize; 3]>,
    [width, height]: [f64; 2],
) -> Result<Mesh, MeshError> {
    let mut shapes: Vec<Shape> = triangles.into_iter().map(Shape::Triangle).collect();
    let mut groups = BTreeMap::from([("body".to_string(), (0..shapes.len()).collect::<Vec<_>>())]);
    // Along each side, counter-clockwise.
    let sides =
        [("bottom", 1, 0.0, 1.0), ("right", 0, width, 1.0), ("top", 1, height, -1.0), ("left", 0, 0.0, -1.0)];
    for (name, axis, value, direction) in sides {
        let mut on: Vec<usize> = (0..positions.len()).filter(|&i| positions[i][axis] == value).collect();
        let along = |i: usize| direction * positions[i][1 - axis];
        on.sort_by(|&a, &b| along(a).total_cmp(&along(b)));
        let first = shapes.len();
        shapes.extend(on.windows(2).map(|pair| Shape::Segment([pair[0], pair[1]])));
        groups.insert(name.to_string(), (first..shapes.len()).collect());
    }
    let tag = |i: usize| i as u64 + 1;
    let nodes = positions.iter().enumerate().map(|(i, &position)| Node { tag: tag(i), position }).collect();
    let elements = shapes.into_iter().enumerate().map(|(i, shape)| Element { tag: tag(i), shape }).collect();
    Mesh::new(nodes, elements, groups)
}
