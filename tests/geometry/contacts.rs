//! Exact cases of contact between balls, capsules, boxes, polyhedra and half-spaces.

use nonsmooth::geometry::{Carrier, Contact, Feature, NarrowPhase, Polyhedron, Pose, Shape, frame, resolve};

use crate::common::{at, contacts, cube, ids, prism, turned, v};

const EPSILON: f64 = f64::EPSILON;

fn ball(r: f64) -> Shape<f64> {
    Shape::ball(r).expect("a ball")
}

fn capsule(r: f64, l: f64) -> Shape<f64> {
    Shape::capsule(r, l).expect("a capsule")
}

fn all_near(contacts: &[Contact<f64>], gap: f64, normal: nalgebra::Vector3<f64>, tolerance: f64) {
    for contact in contacts {
        assert!((contact.gap - gap).abs() <= tolerance, "gap {:e} is not {gap:e}", contact.gap);
        assert!((contact.normal - normal).norm() <= tolerance, "{}", contact.normal);
    }
}

#[test]
fn equal_cubes_face_to_face_touch_at_four_points() {
    let cube = cube();
    for gap in [0.0, 1e-9, -1e-9, 1e-3, -1e-3, 1e-6, -1e-13] {
        let found = contacts((&cube, &at(0.0, 0.0, 0.0)), (&cube, &at(0.0, 0.0, 1.0 + gap)), 0.01);
        assert_eq!(ids(&found).len(), 4);
        all_near(&found, gap, v(0.0, 0.0, 1.0), 1e-15);
    }
}

#[test]
fn identities_stand_rounding() {
    let cube = cube();
    let place = |noise: f64, k: i32| {
        let s = |i: i32| f64::from((k * 7919 + i * 104_729) % 17 - 8) / 8.0 * noise;
        turned([s(1), s(2), 1.0 + s(3)], [s(4), s(5), s(6)])
    };
    for shift in [[0.0, 0.0], [0.25, 0.0], [0.25, 0.375], [0.5, 0.5]] {
        let pose = |noise, k| {
            let pose = place(noise, k);
            Pose::new(pose.position() + v(shift[0], shift[1], 0.0), *pose.orientation())
        };
        let expected = ids(&contacts((&cube, &at(0.0, 0.0, 0.0)), (&cube, &pose(0.0, 0)), 0.01));
        assert_eq!(expected.len(), 4, "{shift:?}");
        for (noise, k) in
            [1e-16, 1e-14, 1e-12].into_iter().flat_map(|noise| (0..100).map(move |k| (noise, k)))
        {
            let found = contacts((&cube, &at(0.0, 0.0, 0.0)), (&cube, &pose(noise, k)), 0.01);
            assert_eq!(ids(&found), expected, "{shift:?} {noise:e}");
            all_near(&found, 0.0, v(0.0, 0.0, 1.0), 4.0 * noise + 4.0 * EPSILON);
        }
    }
}

#[test]
fn a_turned_cube_on_a_cube_touches_at_eight_points() {
    let cube = cube();
    let pose = turned([0.0, 0.0, 1.0], [0.0, 0.0, std::f64::consts::FRAC_PI_4]);
    let found = contacts((&cube, &at(0.0, 0.0, 0.0)), (&cube, &pose), 0.01);
    assert_eq!(ids(&found).len(), 8);
    all_near(&found, 0.0, v(0.0, 0.0, 1.0), 4.0 * EPSILON);
    let edges = |c: &&Contact<f64>| {
        matches!((c.meeting.first, c.meeting.second), (Feature::Edge(_), Feature::Edge(_)))
    };
    assert_eq!(found.iter().filter(edges).count(), 8);
}

#[test]
fn a_prism_stands_on_all_its_corners() {
    for sides in [6, 12] {
        let prism = prism(sides);
        let (ground, cube) = (Shape::half_space(), Shape::cuboid(v(2.0, 2.0, 0.5)).expect("a box"));
        let above = turned([0.0, 0.0, 0.5], [0.0, 0.0, 0.3]);
        let found = contacts((&ground, &at(0.0, 0.0, 0.0)), (&prism, &above), 0.01);
        assert_eq!(ids(&found).len(), sides);
        all_near(&found, 0.0, v(0.0, 0.0, 1.0), 4.0 * EPSILON);
        let found = contacts((&cube, &at(0.0, 0.0, -0.5)), (&prism, &above), 0.01);
        assert_eq!(ids(&found).len(), sides);
        all_near(&found, 0.0, v(0.0, 0.0, 1.0), 4.0 * EPSILON);
        // Another prism, turned: a corner of either inside, or crossings.
        let found = contacts((&prism, &at(0.0, 0.0, -0.5)), (&prism, &above), 0.01);
        assert_eq!(ids(&found).len(), 2 * sides);
    }
}

/// Two cubes, each turned by 45° onto an edge; the edges cross at a right angle.
#[test]
fn edges_that_cross_touch_at_one_point() {
    let (cube, eighth) = (cube(), std::f64::consts::FRAC_PI_4);
    for gap in [0.0, 1e-3, -1e-3] {
        for yaw in [0.0, 0.5, -1.0] {
            let lower = turned([0.0; 3], [eighth, 0.0, 0.0]);
            let roll = turned([0.0; 3], [0.0, eighth, 0.0]);
            let turn = turned([0.0; 3], [0.0, 0.0, yaw]);
            let upper = Pose::new(v(0.1, 0.05, 2.0f64.sqrt() + gap), turn.orientation() * roll.orientation());
            let found = contacts((&cube, &lower), (&cube, &upper), 0.01);
            assert_eq!(found.len(), 1);
            assert_eq!(found[0].meeting.carrier, Carrier::Edges);
            all_near(&found, gap, v(0.0, 0.0, 1.0), 4.0 * EPSILON);
        }
    }
}

#[test]
fn a_corner_over_a_face_touches_at_one_point() {
    let (cube, ground) = (cube(), Shape::cuboid(v(2.0, 2.0, 1.0)).expect("a box"));
    let tilt =
        nalgebra::UnitQuaternion::rotation_between(&v(1.0, 1.0, 1.0), &v(0.0, 0.0, -1.0)).expect("a turn");
    for gap in [0.0, 1e-3, -1e-2] {
        let pose = Pose::new(v(0.3, 0.2, 0.75f64.sqrt() + gap), tilt);
        let found = contacts((&ground, &at(0.0, 0.0, -1.0)), (&cube, &pose), 0.01);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].meeting.second, Feature::Vertex(7));
        assert!(matches!(found[0].meeting.carrier, Carrier::First(_)));
        all_near(&found, gap, v(0.0, 0.0, 1.0), 4.0 * EPSILON);
    }
}

#[test]
fn corner_to_corner_is_their_distance() {
    let cube = cube();
    let found = contacts((&cube, &at(0.0, 0.0, 0.0)), (&cube, &at(1.3, 1.4, 2.2)), 2.0);
    assert_eq!(found.len(), 1);
    let exact = v(0.3, 0.4, 1.2);
    all_near(&found, exact.norm(), exact / exact.norm(), 4.0 * EPSILON);
}

#[test]
fn far_apart_shapes_have_no_contact() {
    let shapes =
        [cube(), prism(6), ball(0.5), capsule(0.2, 0.5), Shape::cylinder(0.5, 0.5, 8).expect("a cylinder")];
    for a in &shapes {
        for b in &shapes {
            for [x, y, z] in [[3.0, 0.0, 0.0], [2.0, 2.0, 2.0], [0.0, 0.0, 1e9], [f64::NAN, 0.0, 0.0]] {
                assert!(contacts((a, &at(0.0, 0.0, 0.0)), (b, &at(x, y, z)), 0.1).is_empty());
            }
        }
    }
}

#[test]
fn balls() {
    let found = contacts((&ball(1.0), &at(1.0, 2.0, 3.0)), (&ball(0.5), &at(4.0, 6.0, 3.0)), 10.0);
    all_near(&found, 3.5, v(0.6, 0.8, 0.0), 8.0 * EPSILON);
    let [a, b] = found[0].points(&at(1.0, 2.0, 3.0), &at(4.0, 6.0, 3.0));
    assert!((a - v(1.6, 2.8, 3.0)).norm() <= 1e-15 && (b - v(3.7, 5.6, 3.0)).norm() <= 1e-15);
    // Concentric: a normal all the same.
    let found = contacts((&ball(1.0), &at(1.0, 2.0, 3.0)), (&ball(0.5), &at(1.0, 2.0, 3.0)), 0.0);
    assert!(found[0].gap == -1.5 && found[0].normal.norm() == 1.0);
    // Far from the origin the digits of the difference are kept.
    let found = contacts((&ball(0.5), &at(1e9, 0.0, 0.0)), (&ball(0.5), &at(1e9 + 1.0, 0.0, 0.0)), 0.0);
    assert_eq!(found[0].gap, 0.0);
}

#[test]
fn a_ball_on_a_box() {
    let cube = Shape::cuboid(v(1.0, 1.0, 1.0)).expect("a box");
    let r = 0.25;
    let cases = [
        ([0.3, 0.2, 1.5], 0.25, v(0.0, 0.0, 1.0), Feature::Face(5)),
        ([0.3, 1.3, 1.4], 0.25, v(0.0, 0.6, 0.8), Feature::Edge(0)),
        (
            [1.0 + 2.0 / 3.0, 1.0 + 1.0 / 3.0, 1.0 + 2.0 / 3.0],
            0.75,
            v(2.0, 1.0, 2.0) / 3.0,
            Feature::Vertex(7),
        ),
        // Inside, and over an edge to rounding.
        ([0.1, 0.9, 0.2], -0.35, v(0.0, 1.0, 0.0), Feature::Face(3)),
        ([0.1, 1.0 + 1e-16, 1.2], -0.05, v(0.0, 0.0, 1.0), Feature::Face(5)),
    ];
    for ([x, y, z], gap, normal, feature) in cases {
        let found = contacts((&cube, &at(0.0, 0.0, 0.0)), (&ball(r), &at(x, y, z)), 1.0);
        assert_eq!(found.len(), 1);
        all_near(&found, gap, normal, 8.0 * EPSILON);
        if !matches!(feature, Feature::Edge(_)) {
            assert_eq!(found[0].meeting.first, feature);
        }
    }
}

#[test]
fn capsules_on_faces_and_on_each_other() {
    let (lying, box_) = (capsule(0.25, 1.0), Shape::cuboid(v(0.5, 0.5, 0.5)).expect("a box"));
    let along_x = [0.0, std::f64::consts::FRAC_PI_2, 0.0];
    let over = |x: f64, z: f64| turned([x, 0.1, z], along_x);
    // Both sides of the face crossed; one end on it; standing; and on a half-space.
    for (x, count) in [(0.0, 2), (1.0, 2), (1.49, 2)] {
        let found = contacts((&box_, &at(0.0, 0.0, 0.0)), (&lying, &over(x, 0.75)), 0.01);
        assert_eq!(ids(&found).len(), count, "{found:?}");
        all_near(&found, 0.0, v(0.0, 0.0, 1.0), 8.0 * EPSILON);
    }
    let found = contacts((&box_, &at(0.0, 0.0, 0.0)), (&lying, &at(0.1, 0.1, 1.74)), 0.01);
    assert_eq!(found.len(), 1);
    all_near(&found, -0.01, v(0.0, 0.0, 1.0), 8.0 * EPSILON);
    let found = contacts((&Shape::half_space(), &at(0.0, 0.0, 0.0)), (&lying, &over(3.0, 0.25)), 0.01);
    assert_eq!(ids(&found).len(), 2);
    // Parallel, half over each other; crossed at a right angle; end to end.
    let found = contacts((&lying, &over(0.0, 0.0)), (&lying, &over(1.0, 0.5)), 0.01);
    assert_eq!(ids(&found).len(), 2);
    all_near(&found, 0.0, v(0.0, 0.0, 1.0), 8.0 * EPSILON);
    let found = contacts((&lying, &over(0.0, 0.0)), (&lying, &over(0.0, 0.5)), 0.01);
    assert_eq!(ids(&found).len(), 2);
    let crossed = turned([0.2, 0.3, 0.51], [std::f64::consts::FRAC_PI_2, 0.0, 0.0]);
    let found = contacts((&lying, &over(0.0, 0.0)), (&lying, &crossed), 0.1);
    assert_eq!(found.len(), 1);
    all_near(&found, 0.01, v(0.0, 0.0, 1.0), 8.0 * EPSILON);
    let found = contacts((&lying, &over(0.0, 0.0)), (&lying, &over(2.5, 0.0)), 0.01);
    assert_eq!(found.len(), 1);
    all_near(&found, 0.0, v(1.0, 0.0, 0.0), 8.0 * EPSILON);
    // Over the edge of a box, and its axis through the box.
    let found = contacts(
        (&box_, &at(0.0, 0.0, 0.0)),
        (&lying, &turned([0.8, 0.0, 0.9], [std::f64::consts::FRAC_PI_2, 0.0, 0.0])),
        0.26,
    );
    assert_eq!(ids(&found).len(), 2, "{found:?}");
    all_near(&found, 0.25, v(0.6, 0.0, 0.8), 8.0 * EPSILON);
    let found = contacts((&box_, &at(0.0, 0.0, 0.0)), (&lying, &over(0.0, 0.4)), 1.0);
    assert!(found.len() == 2);
    all_near(&found, -0.35, v(0.0, 0.0, 1.0), 8.0 * EPSILON);
}

#[test]
fn size_ratios_of_a_million() {
    for scale in [1e-6, 1e6] {
        let (small, large) = (cube(), Shape::cuboid(v(0.5, 0.5, 0.5) * scale).expect("a box"));
        let pose = at(0.01, 0.02, 0.5 + 0.5 * scale);
        let found = contacts((&small, &at(0.0, 0.0, 0.0)), (&large, &pose), 0.01 * f64::min(scale, 1.0));
        assert_eq!(ids(&found).len(), 4);
        all_near(&found, 0.0, v(0.0, 0.0, 1.0), EPSILON * f64::max(scale, 1.0));
    }
}

#[test]
fn features_that_do_not_exist_resolve_to_nothing() {
    let (cube, ball, none) = (cube(), ball(1.0), at(0.0, 0.0, 0.0));
    let found = contacts((&cube, &none), (&cube, &at(0.0, 0.0, 1.0)), 0.01);
    assert!(resolve(&found[0].meeting, (&ball, &none), (&ball, &none)).is_none());
    assert!(resolve(&found[0].meeting, (&Shape::half_space(), &none), (&cube, &none)).is_none());
    let found = resolve(&found[0].meeting, (&cube, &none), (&cube, &at(0.0, 0.1, 1.5))).expect("a contact");
    assert!((found.gap - 0.5).abs() <= EPSILON);
}

#[test]
fn a_flat_pyramid_touches_where_it_should() {
    // The face most against the normal does not hold the lowest vertex.
    let points =
        [v(0.0, 0.0, -0.1), v(3.0, 0.0, 0.2), v(-1.0, 2.0, 0.4), v(-1.0, -2.0, 0.4), v(0.0, 0.0, 0.5)];
    let pyramid = Shape::polyhedron(Polyhedron::hull(&points).expect("a pyramid"));
    let ground = Shape::cuboid(v(5.0, 5.0, 1.0)).expect("a box");
    let found = contacts((&ground, &at(0.0, 0.0, -1.0)), (&pyramid, &at(0.0, 0.0, 0.1)), 1e-3);
    assert_eq!(found.len(), 1);
    all_near(&found, 0.0, v(0.0, 0.0, 1.0), 4.0 * EPSILON);
}

#[test]
fn frames_turn_with_the_normal() {
    assert!(
        (frame(&v(0.0, 0.0, 1.0))
            - nalgebra::Matrix3::from_columns(&[v(0.0, 0.0, 1.0), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0)]))
        .amax()
            <= 2.0 * EPSILON
    );
    let mut narrow = NarrowPhase::<f32>::new();
    let (ball, pose) = (Shape::ball(1.0f32).expect("a ball"), Pose::identity());
    let mut out = Vec::new();
    narrow.contacts((&ball, &pose), (&Shape::half_space(), &pose), 0.0, &mut out);
    assert!(out[0].gap == -1.0 && out[0].normal.z == -1.0, "the half-space is the body here");
}
