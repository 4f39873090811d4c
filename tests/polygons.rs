//! Convex polygons: where they meet, with exact derivatives, and under the same name from step to step.

use nonsmooth::contact::{Candidate, ContactId};
use nonsmooth::linalg::BlockRows;
use nonsmooth::system::{
    Body, Contacts, GroupId, RigidBodies, RigidBodiesBuilder, SystemError, polygon_body,
};

type Scene = (RigidBodiesBuilder<f64>, GroupId);

fn scene() -> Scene {
    let mut builder = RigidBodies::builder();
    let group = builder.group();
    builder.interface(group, group).expect("the group exists");
    (builder, group)
}

fn add(scene: &mut Scene, vertices: &[[f64; 2]]) {
    let (builder, group) = scene;
    let body = builder.body("body", Body { mass: 1.0, inertia: 1.0 }).expect("positive");
    builder.polygon("polygon", body, vertices, *group).expect("convex");
}

fn add_disc(scene: &mut Scene, radius: f64) {
    let (builder, group) = scene;
    let body = builder.body("body", Body { mass: 1.0, inertia: 1.0 }).expect("positive");
    builder.disc("disc", body, [0.1, -0.2], radius, *group).expect("positive");
}

const SQUARE: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

fn candidates(system: &mut RigidBodies<f64>, q: &[f64], reach: f64) -> Vec<Candidate<f64>> {
    let mut out = Vec::new();
    Contacts::<f64, 2>::candidates(system, q, reach, &mut out);
    out.sort_by_key(|candidate| candidate.id);
    out
}

fn normal_row(system: &RigidBodies<f64>, id: ContactId, q: &[f64]) -> Vec<f64> {
    let mut rows = BlockRows::<f64, 2>::new();
    system.jacobian(id, q, &mut rows);
    let mut dense = vec![0.0; q.len()];
    rows.row(0).for_each(|(column, entry)| dense[column] += entry[0]);
    dense
}

#[test]
fn faces_on_each_other_meet_in_two_points_with_the_gap_between_the_faces() {
    let mut scene = scene();
    add(&mut scene, &SQUARE);
    add(&mut scene, &SQUARE);
    let mut system = scene.0.build().expect("two bodies");
    for (shift, gap) in [(0.0, 0.0), (0.3, 1e-3), (-1.2, -1e-3), (0.5, 0.0)] {
        let q = [0.0, 0.0, 0.0, shift, 2.0 + gap, 0.0];
        let found = candidates(&mut system, &q, 0.1);
        assert_eq!(found.len(), 2, "shift {shift}: {found:?}");
        for candidate in &found {
            assert!((candidate.gap - gap).abs() < 4.0 * f64::EPSILON, "{candidate:?}");
            let row = normal_row(&system, candidate.id, &q);
            assert!((row[1] + 1.0).abs() < 1e-15 || (row[1] - 1.0).abs() < 1e-15, "vertical: {row:?}");
        }
        // The two points are the ends of the overlap.
        let mut arms: Vec<f64> = found.iter().map(|c| normal_row(&system, c.id, &q)[2].abs()).collect();
        let mut ends = [f64::max(-1.0, shift - 1.0).abs(), f64::min(1.0, shift + 1.0).abs()];
        arms.sort_by(f64::total_cmp);
        ends.sort_by(f64::total_cmp);
        assert!(arms.iter().zip(&ends).all(|(a, b)| (a - b).abs() < 1e-14), "{arms:?}, {ends:?}");
    }
}

#[test]
fn the_normal_row_is_the_derivative_of_the_gap() {
    let hexagon: Vec<[f64; 2]> = (0..6)
        .map(|i| f64::from(i) * std::f64::consts::TAU / 6.0)
        .map(|a| [a.cos(), 0.7 * a.sin()])
        .collect();
    let mut scene = scene();
    add(&mut scene, &SQUARE);
    add(&mut scene, &hexagon);
    add_disc(&mut scene, 0.3);
    let mut system = scene.0.build().expect("three bodies");
    let mut seen = 0;
    for k in 0..400 {
        // A quasi-random walk over poses in which the three overlap or nearly touch.
        let unit = |i: u32| (f64::from(k * 9 + i + 1) * 0.754_877_666_246_692_7).fract();
        let mut q = vec![0.0; 9];
        for (i, x) in q.iter_mut().enumerate() {
            *x = (2.0 * unit(i as u32) - 1.0) * if i % 3 == 2 { 3.0 } else { 1.3 };
        }
        for candidate in candidates(&mut system, &q, 0.2) {
            let row = normal_row(&system, candidate.id, &q);
            for i in 0..9 {
                let step = 1e-6;
                let at = |system: &mut RigidBodies<f64>, shift: f64| {
                    let mut q = q.clone();
                    q[i] += shift;
                    let found = candidates(system, &q, 10.0);
                    found.iter().find(|c| c.id == candidate.id).map(|c| c.gap)
                };
                let (Some(plus), Some(minus)) = (at(&mut system, step), at(&mut system, -step)) else {
                    continue;
                };
                let slope = (plus - minus) / (2.0 * step);
                // Central differences: h² times third derivatives of order one, ε/h rounding.
                assert!((slope - row[i]).abs() < 1e-8, "{candidate:?}, column {i}: {slope} and {}", row[i]);
                seen += 1;
            }
        }
    }
    assert!(seen > 1000, "{seen} derivatives compared");
}

#[test]
fn a_contact_keeps_its_name_while_the_same_features_meet() {
    let mut scene = scene();
    add(&mut scene, &SQUARE);
    add(&mut scene, &[[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]);
    let mut system = scene.0.build().expect("two bodies");
    let names = |system: &mut RigidBodies<f64>, q: &[f64]| {
        candidates(system, q, 0.1).iter().map(|c| c.id).collect::<Vec<_>>()
    };
    let first = names(&mut system, &[0.0, 0.0, 0.0, -0.4, 1.5, 0.0]);
    for i in 0..80 {
        // The small one slides across the large one, trembling by rounding.
        let tremble = f64::from(i % 3 - 1) * 1e-15;
        let q = [0.0, 0.0, tremble, -0.4 + 0.01 * f64::from(i), 1.5 + tremble, -tremble];
        assert_eq!(names(&mut system, &q), first, "at step {i}");
    }
}

#[test]
fn a_disc_meets_the_face_or_the_corner_that_is_nearest() {
    let mut scene = scene();
    add(&mut scene, &SQUARE);
    let (builder, group) = &mut scene;
    let body = builder.body("disc", Body { mass: 1.0, inertia: 1.0 }).expect("positive");
    builder.disc("disc", body, [0.0, 0.0], 0.5, *group).expect("positive");
    let mut system = scene.0.build().expect("two bodies");
    let gap = |system: &mut RigidBodies<f64>, x: f64, y: f64| {
        let [found] =
            <[_; 1]>::try_from(candidates(system, &[0.0, 0.0, 0.0, x, y, 0.0], 9.0)).expect("one contact");
        found.gap
    };
    assert!((gap(&mut system, 0.3, 1.6) - 0.1).abs() < 1e-15);
    assert!((gap(&mut system, 4.0, 5.0) - 4.5).abs() < 1e-15);
    assert!((gap(&mut system, 0.9, 0.0) + 0.6).abs() < 1e-15, "inside: the nearest face");
}

#[test]
fn mass_and_inertia_of_a_homogeneous_polygon() {
    let (a, b) = (3.0_f64, 0.5);
    let rectangle = [[5.0, 7.0], [5.0 + a, 7.0], [5.0 + a, 7.0 + b], [5.0, 7.0 + b]];
    let (body, vertices, centre) = polygon_body(2.0, &rectangle).expect("a rectangle");
    assert!((body.mass - 2.0 * a * b).abs() < 1e-14);
    assert!((body.inertia - body.mass * (a * a + b * b) / 12.0).abs() < 1e-13);
    assert!((centre[0] - 6.5).abs() < 1e-14 && (centre[1] - 7.25).abs() < 1e-14);
    assert!((vertices[0][0] + 1.5).abs() < 1e-14 && (vertices[0][1] + 0.25).abs() < 1e-14);
}

#[test]
fn an_outline_that_is_no_convex_polygon_is_refused_with_its_vertex() {
    let star: Vec<[f64; 2]> =
        (0..5).map(|i| f64::from(2 * i) * std::f64::consts::TAU / 5.0).map(|a| [a.cos(), a.sin()]).collect();
    let clockwise: Vec<[f64; 2]> = SQUARE.iter().rev().copied().collect();
    let cases: Vec<(Vec<[f64; 2]>, &str)> = vec![
        (vec![], "number"),
        (SQUARE[..2].to_vec(), "number"),
        (clockwise, "clockwise"),
        (vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 1.0]], "straight"),
        (vec![[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]], "concave"),
        (vec![[0.0, 0.0], [1.0, 0.0], [1.0, f64::NAN]], "finite"),
        (star, "once"),
        (vec![[0.0, 0.0]; 2000], "number"),
    ];
    for (outline, why) in cases {
        let (mut builder, group) = scene();
        let body = builder.body("body", Body { mass: 1.0, inertia: 1.0 }).expect("positive");
        match builder.polygon("odd", body, &outline, group) {
            Err(SystemError::Polygon { reason, .. }) => assert!(reason.contains(why), "{reason}"),
            other => panic!("{outline:?}: {other:?}"),
        }
    }
}
