//! Convex hulls: exact cases, degenerate input, and properties of random ones.

use nalgebra::Vector3;
use nonsmooth::geometry::{HullError, Polyhedron};
use proptest::prelude::*;

use crate::common::v;

/// Closed, convex, with faces that are plane and counterclockwise, and with all points inside.
fn check(hull: &Polyhedron<f64>, points: &[Vector3<f64>], tolerance: f64) {
    let (vertices, faces, edges) = (hull.vertices(), hull.faces(), hull.edges());
    assert_eq!(vertices.len() + faces, edges.len() + 2, "Euler's characteristic");
    assert!(vertices.iter().all(|x| points.contains(x)), "vertices are points given");
    for face in 0..faces {
        let (normal, offset) = hull.plane(face).expect("a face");
        assert!((normal.norm() - 1.0).abs() <= 4.0 * f64::EPSILON);
        for x in points {
            assert!(normal.dot(x) - offset <= tolerance, "{:e} outside", normal.dot(x) - offset);
        }
        let corners = hull.corners(face);
        assert!(corners.len() >= 3);
        for (k, &corner) in corners.iter().enumerate() {
            let (x, next) = (vertices[corner as usize], vertices[corners[(k + 1) % corners.len()] as usize]);
            assert!((normal.dot(&x) - offset).abs() <= tolerance);
            // All others are left of every side.
            for &other in corners {
                let left = normal.cross(&(next - x)).dot(&(vertices[other as usize] - x));
                assert!(left >= -tolerance);
            }
            let edge = &edges[hull.sides(face)[k] as usize];
            assert!(edge.faces.contains(&(face as u32)) && edge.vertices.contains(&corner));
        }
    }
    for vertex in 0..vertices.len() {
        assert_eq!(hull.faces_around(vertex).len(), hull.neighbours(vertex).len());
        assert!(hull.neighbours(vertex).len() >= 3);
    }
}

fn grid(n: usize) -> Vec<Vector3<f64>> {
    let at = |k: usize| k as f64 / (n - 1) as f64 - 0.5;
    (0..n * n * n).map(|i| v(at(i % n), at(i / n % n), at(i / n / n))).collect()
}

#[test]
fn a_grid_of_points_is_a_cube() {
    for n in [2, 3, 5] {
        let points = grid(n);
        let hull = Polyhedron::hull(&points).expect("a cube");
        check(&hull, &points, 1e-12);
        assert_eq!((hull.vertices().len(), hull.edges().len(), hull.faces()), (8, 12, 6));
        assert!((0..6).all(|face| hull.plane(face).expect("a face").1 == 0.5));
    }
}

#[test]
fn prisms_have_two_faces_of_all_corners() {
    for sides in [5, 6, 12, 64] {
        let hull = crate::common::prism(sides);
        let hull = hull.as_polyhedron().expect("a polyhedron");
        assert_eq!((hull.vertices().len(), hull.faces()), (2 * sides, sides + 2));
        assert_eq!((0..hull.faces()).filter(|&f| hull.corners(f).len() == sides).count(), 2);
        check(hull, hull.vertices(), 1e-12);
    }
}

#[test]
fn a_box_is_the_hull_of_its_corners() {
    let half = v(0.3, 0.5, 0.8);
    let made = Polyhedron::cuboid(half).expect("a box");
    check(&made, made.vertices(), 0.0);
    let hull = Polyhedron::hull(made.vertices()).expect("a box");
    let mut planes = [&made, &hull].map(|h| (0..6).map(|f| h.plane(f).expect("a face")).collect::<Vec<_>>());
    for planes in &mut planes {
        planes.sort_by(|a, b| (a.0.x, a.0.y, a.0.z).partial_cmp(&(b.0.x, b.0.y, b.0.z)).expect("finite"));
    }
    assert_eq!(planes[0], planes[1]);
}

#[test]
fn tiny_and_huge_hulls() {
    for scale in [1e-150, 1e-9, 1.0, 1e9, 1e150] {
        let points: Vec<_> = grid(3).into_iter().map(|x| x * scale).collect();
        let hull = Polyhedron::hull(&points).expect("a cube");
        assert_eq!((hull.vertices().len(), hull.faces()), (8, 6), "scale {scale:e}");
    }
}

#[test]
fn what_is_no_solid_is_refused() {
    let hull = |points: &[Vector3<f64>]| Polyhedron::hull(points);
    let x = v(0.1, 0.2, 0.3);
    assert!(matches!(hull(&[]), Err(HullError::TooFew { points: 0 })));
    assert!(matches!(hull(&[x; 3]), Err(HullError::TooFew { points: 3 })));
    assert!(matches!(hull(&[x; 9]), Err(HullError::Flat { .. })));
    let line: Vec<_> = (0..9).map(|k| x * f64::from(k)).collect();
    assert!(matches!(hull(&line), Err(HullError::Flat { .. })));
    let plane: Vec<_> = (0..25).map(|k| v(f64::from(k % 5), f64::from(k / 5), 0.1)).collect();
    assert!(matches!(hull(&plane), Err(HullError::Flat { .. })));
    let mut thin = plane.clone();
    thin.push(v(2.0, 2.0, 0.1 + 1e-10));
    assert!(
        matches!(hull(&thin), Err(HullError::Flat { thickness }) if thickness > 0.9e-10 && thickness < 1.1e-10)
    );
    assert!(matches!(hull(&[x, x, x, v(f64::NAN, 0.0, 0.0)]), Err(HullError::NotFinite { point: 3 })));
    assert!(matches!(Polyhedron::hull_within(&grid(2), 0.5), Err(HullError::Tolerance { .. })));
    assert!(matches!(Polyhedron::cuboid(v(1.0, 0.0, 1.0)), Err(HullError::Flat { .. })));
}

#[test]
fn hulls_in_single_precision() {
    let points: Vec<Vector3<f32>> = grid(4).iter().map(|x| x.cast()).collect();
    let hull = Polyhedron::hull(&points).expect("a cube");
    assert_eq!((hull.vertices().len(), hull.faces()), (8, 6));
}

proptest! {
    #[test]
    fn random_hulls_hold_their_points(points in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 4..80)) {
        let points: Vec<_> = points.into_iter().map(Vector3::from).collect();
        if let Ok(hull) = Polyhedron::hull(&points) {
            check(&hull, &points, 1e-8);
        }
    }

    /// Many points in few planes, exactly or with noise: the hard case.
    #[test]
    fn hulls_of_lattice_points(
        cells in prop::collection::vec(prop::array::uniform3(0..4i32), 4..60),
        noise in prop::sample::select(vec![0.0, 1e-16, 1e-12, 1e-10, 1e-9, 1e-7]),
        turn in crate::common::quaternion(),
        seed in prop::collection::vec(-1.0..1.0f64, 180),
    ) {
        let points: Vec<_> = cells.iter().enumerate().map(|(i, c)| {
            let shift = v(seed[3 * i], seed[3 * i + 1], seed[3 * i + 2]) * noise;
            turn * v(f64::from(c[0]), f64::from(c[1]), f64::from(c[2])) + shift
        }).collect();
        match Polyhedron::hull(&points) {
            Ok(hull) => check(&hull, &points, 1e-7 + 10.0 * noise),
            Err(error) => prop_assert!(matches!(error, HullError::Flat { .. }), "{}", error),
        }
    }
}
