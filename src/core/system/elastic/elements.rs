//! Element matrices: two-node bars and constant-strain triangles (T3).

use nalgebra::SMatrix;

use super::Material;
use crate::mesh::{Element, Mesh, Shape};
use crate::scalar::{Scalar, lit};

/// Coordinates of a node as scalars.
fn position<T: Scalar>(mesh: &Mesh, node: usize) -> [T; 2] {
    mesh.nodes()[node].position.map(lit)
}

/// Length, signed area or 1, as [`Mesh::measure`], in the arithmetic of the run.
pub(super) fn measure<T: Scalar>(mesh: &Mesh, element: &Element) -> T {
    match element.shape {
        Shape::Point(_) => T::one(),
        Shape::Segment([a, b]) => {
            let ([ax, ay], [bx, by]) = (position::<T>(mesh, a), position::<T>(mesh, b));
            nalgebra::ComplexField::hypot(bx - ax, by - ay)
        }
        Shape::Triangle(nodes) => {
            let [[ax, ay], [bx, by], [cx, cy]] = nodes.map(|node| position::<T>(mesh, node));
            lit::<T>(0.5) * ((bx - ax) * (cy - ay) - (cx - ax) * (by - ay))
        }
    }
}

/// Strain rows B of a triangle: ε = B u with ε = (ε_xx, ε_yy, 2ε_xy), u = (u_x, u_y) node by node.
fn strain_rows<T: Scalar>(mesh: &Mesh, nodes: [usize; 3], area: T) -> SMatrix<T, 3, 6> {
    let at = nodes.map(|node| position::<T>(mesh, node));
    let mut rows = SMatrix::zeros();
    let half = lit::<T>(0.5) / area;
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let (dx, dy) = ((at[j][1] - at[k][1]) * half, (at[k][0] - at[j][0]) * half);
        rows[(0, 2 * i)] = dx;
        rows[(1, 2 * i + 1)] = dy;
        rows[(2, 2 * i)] = dy;
        rows[(2, 2 * i + 1)] = dx;
    }
    rows
}

/// Calls `add(i, j, k_ij)` for the stiffness entries of an element of the body, in local degrees of freedom: the
/// components of its nodes, node by node.
pub(super) fn stiffness<T: Scalar>(
    mesh: &Mesh,
    element: &Element,
    material: &Material<T>,
    mut add: impl FnMut(usize, usize, T),
) {
    let size = measure::<T>(mesh, element);
    match element.shape {
        Shape::Point(_) => {}
        Shape::Segment(_) => {
            let k = material.young * material.section / size;
            [(0, 0, k), (1, 1, k), (0, 1, -k), (1, 0, -k)].into_iter().for_each(|(i, j, k)| add(i, j, k));
        }
        Shape::Triangle(nodes) => {
            let [d11, d12, d33] = material.plane_moduli();
            let zero = T::zero();
            let moduli = SMatrix::<T, 3, 3>::new(d11, d12, zero, d12, d11, zero, zero, zero, d33);
            let rows = strain_rows(mesh, nodes, size);
            let full = rows.transpose() * moduli * rows * (size * material.section);
            for i in 0..6 {
                for j in 0..6 {
                    // The mean of both triangles, so that rounding leaves the matrix symmetric.
                    add(i, j, lit::<T>(0.5) * (full[(i, j)] + full[(j, i)]));
                }
            }
        }
    }
}

/// Mass between nodes a and b of an element with `count` nodes and mass `total`: consistent.
pub(super) fn consistent_share<T: Scalar>(total: T, count: usize, same: bool) -> T {
    // ∫ N_a N_b = measure (1 + δ_ab)/(count (count + 1)) for linear shape functions.
    let weight = if same { 2.0 } else { 1.0 };
    total * lit::<T>(weight / (count * (count + 1)) as f64)
}

/// Stress of an element, (σ_xx, σ_yy, σ_xy), from the displacements of its nodes; bars have σ_xx alone.
pub(super) fn stress<T: Scalar>(
    mesh: &Mesh,
    element: &Element,
    material: &Material<T>,
    displacement: impl Fn(usize) -> [T; 2],
) -> [T; 3] {
    let zero = T::zero();
    match element.shape {
        Shape::Point(_) => [zero; 3],
        Shape::Segment([a, b]) => {
            let ([xa, _], [xb, _]) = (position::<T>(mesh, a), position::<T>(mesh, b));
            let strain = (displacement(b)[0] - displacement(a)[0]) / (xb - xa);
            [material.young * strain, zero, zero]
        }
        Shape::Triangle(nodes) => {
            let rows = strain_rows(mesh, nodes, measure::<T>(mesh, element));
            let u = nodes.map(&displacement);
            let u = SMatrix::<T, 6, 1>::from_fn(|i, _| u[i / 2][i % 2]);
            let strain = rows * u;
            let [d11, d12, d33] = material.plane_moduli();
            [d11 * strain[0] + d12 * strain[1], d12 * strain[0] + d11 * strain[1], d33 * strain[2]]
        }
    }
}
