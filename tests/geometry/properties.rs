//! Properties of contacts of random pairs.

use nalgebra::{UnitQuaternion, Vector3};
use nonsmooth::geometry::{Contact, Feature, Pose, Shape, frame, resolve};
use proptest::prelude::*;

use crate::common::{at, contacts, ids, polyhedron, pose, quaternion, shape, v};

/// Separation along one direction: the least n·x over b less the largest over a.
fn along(n: &Vector3<f64>, (a, at): (&Shape<f64>, &Pose<f64>), (b, bt): (&Shape<f64>, &Pose<f64>)) -> f64 {
    let heights = |shape: &Shape<f64>, pose: &Pose<f64>| {
        let hull = shape.as_polyhedron().expect("a polyhedron");
        hull.vertices().iter().map(|x| n.dot(&pose.place(x))).collect::<Vec<_>>()
    };
    heights(b, bt).into_iter().fold(f64::INFINITY, f64::min)
        - heights(a, at).into_iter().fold(-f64::INFINITY, f64::max)
}

/// The largest along all normals of faces and all products of edges, by brute force.
fn separation(first: (&Shape<f64>, &Pose<f64>), second: (&Shape<f64>, &Pose<f64>)) -> f64 {
    let hulls = [first, second].map(|(shape, pose)| (shape.as_polyhedron().expect("a polyhedron"), pose));
    let mut best = f64::NEG_INFINITY;
    for (sign, (hull, pose)) in [1.0, -1.0].into_iter().zip(hulls) {
        for face in 0..hull.faces() {
            let normal = pose.turn(hull.plane(face).expect("a face").0) * sign;
            best = f64::max(best, along(&normal, first, second));
        }
    }
    let edges = hulls.map(|(hull, pose)| {
        let ends = |e: &nonsmooth::geometry::Edge<f64>| e.vertices.map(|v| hull.vertices()[v as usize]);
        hull.edges().iter().map(|e| pose.turn(&(ends(e)[1] - ends(e)[0]))).collect::<Vec<_>>()
    });
    for u in &edges[0] {
        for w in &edges[1] {
            if let Some(n) = u.cross(w).try_normalize(1e-6) {
                best = best.max(along(&n, first, second)).max(along(&-n, first, second));
            }
        }
    }
    best
}

fn sorted(mut contacts: Vec<Contact<f64>>) -> Vec<Contact<f64>> {
    let key = |c: &Contact<f64>| (c.meeting.id(), c.meeting);
    contacts.sort_by_key(key);
    contacts
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]

    /// Overlap and separation agree with brute force, whatever the features.
    #[test]
    fn polyhedra_meet_where_they_overlap(a in polyhedron(), b in polyhedron(), p in pose(0.5), q in pose(1.5)) {
        let (first, second) = ((&a, &p), (&b, &q));
        let exact = separation(first, second);
        let found = contacts(first, second, 0.05);
        ids(&found);
        if exact > 0.05 + 1e-7 {
            prop_assert!(found.is_empty(), "{exact} {found:?}");
        }
        if exact < -1e-7 {
            // The least way out is among them, or what holds more than it does.
            prop_assert!(found.iter().any(|c| c.gap <= 1e-12), "{exact} {found:?}");
        }
        for c in &found {
            prop_assert!(c.gap >= along(&c.normal, first, second) - 1e-12, "no point is deeper than the shapes are");
            if exact > 0.0 {
                prop_assert!(c.gap >= -1e-12, "{exact} {c:?}");
            }
        }
    }

    #[test]
    fn order_does_not_matter(a in shape(), b in shape(), p in pose(0.5), q in pose(1.5)) {
        let found = sorted(contacts((&a, &p), (&b, &q), 0.3));
        let mirrored = sorted(contacts((&b, &q), (&a, &p), 0.3).into_iter().map(Contact::swapped).collect());
        prop_assert_eq!(found.len(), mirrored.len());
        for (x, y) in found.iter().zip(&mirrored) {
            prop_assert_eq!(x.meeting, y.meeting);
            prop_assert!((x.gap - y.gap).abs() <= 1e-12 && (x.normal - y.normal).norm() <= 1e-11, "{x:?} {y:?}");
        }
    }

    #[test]
    fn moving_both_moves_the_contacts(
        a in shape(), b in shape(), p in pose(0.5), q in pose(1.5), turn in quaternion(), shift in prop::array::uniform3(-100.0..100.0f64),
    ) {
        let moved = |pose: &Pose<f64>| Pose::new(turn * pose.position() + Vector3::from(shift), turn * pose.orientation());
        let found = sorted(contacts((&a, &p), (&b, &q), 0.3));
        let (s, t) = (moved(&p), moved(&q));
        let after = sorted(contacts((&a, &s), (&b, &t), 0.3));
        prop_assert_eq!(found.len(), after.len());
        for (x, y) in found.iter().zip(&after) {
            prop_assert_eq!(x.meeting, y.meeting);
            prop_assert!((x.gap - y.gap).abs() <= 1e-11);
            prop_assert!((turn * x.normal - y.normal).norm() <= 1e-10);
        }
    }

    /// The derivative of the gap along a motion of both bodies is that of the points along the normal.
    #[test]
    fn gaps_are_smooth(
        a in shape(), b in shape(), p in pose(0.5), q in pose(1.5), velocity in prop::array::uniform12(-1.0..1.0f64),
    ) {
        let [va, wa, vb, wb] = [0, 3, 6, 9].map(|k| v(velocity[k], velocity[k + 1], velocity[k + 2]));
        let h = 1e-5;
        let step = |pose: &Pose<f64>, v: Vector3<f64>, w: Vector3<f64>, t: f64| {
            Pose::new(pose.position() + v * t, UnitQuaternion::from_scaled_axis(w * t) * pose.orientation())
        };
        for c in contacts((&a, &p), (&b, &q), 0.3) {
            let by_face = matches!((c.meeting.first, c.meeting.second), (Feature::Edge(_), Feature::Edge(_)))
                && !matches!(c.meeting.carrier, nonsmooth::geometry::Carrier::Edges | nonsmooth::geometry::Carrier::Line);
            let skins = [&a, &b].map(|s| match s.kind() {
                nonsmooth::geometry::Kind::Ball { radius } | nonsmooth::geometry::Kind::Capsule { radius, .. } => *radius,
                _ => 0.0,
            });
            // Near-parallel edges, and points that nearly coincide, curve too much for this difference.
            if by_face || (c.gap + skins[0] + skins[1]).abs() < 0.05 {
                continue;
            }
            let at = |t: f64| resolve(&c.meeting, (&a, &step(&p, va, wa, t)), (&b, &step(&q, vb, wb, t)));
            let (Some(before), Some(now), Some(after)) = (at(-h), at(0.0), at(h)) else { panic!("it stays") };
            prop_assert!((now.gap - c.gap).abs() <= 1e-14 && (now.arms[0] - c.arms[0]).norm() <= 1e-13);
            let rate = (after.gap - before.gap) / (2.0 * h);
            let exact = c.normal.dot(&(vb + wb.cross(&c.arms[1]) - va - wa.cross(&c.arms[0])));
            prop_assert!((rate - exact).abs() <= 1e-6, "{rate} {exact} {c:?}");
        }
    }

    /// Gaps of a vertex over a face of two boxes in rational arithmetic.
    #[test]
    fn gaps_against_rationals(
        qa in prop::array::uniform4(-9..10i128), qb in prop::array::uniform4(-9..10i128), x in prop::array::uniform3(-40..41i128),
    ) {
        let norm = |q: [i128; 4]| q.iter().map(|c| c * c).sum::<i128>();
        prop_assume!(norm(qa) > 0 && norm(qb) > 0);
        // R |q|², in integers.
        let matrix = |[w, x, y, z]: [i128; 4]| [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ];
        let turn = |m: [[i128; 3]; 3], p: [i128; 3]| [0, 1, 2].map(|i| (0..3).map(|j| m[i][j] * p[j]).sum::<i128>());
        // Half extents and positions in 32nds.
        let (half_a, half_b) = ([20, 15, 25], [16, 31, 10]);
        let shape = |h: [i128; 3]| Shape::cuboid(Vector3::from(h.map(|c| c as f64 / 32.0))).expect("a box");
        let pose = |q: [i128; 4], x: [i128; 3]| Pose::from_parts(Vector3::from(x.map(|c| c as f64 / 32.0)), q.map(|c| c as f64)).expect("a pose");
        let (a, b, p, q) = (shape(half_a), shape(half_b), pose(qa, [0; 3]), pose(qb, x));
        for c in contacts((&a, &p), (&b, &q), 10.0) {
            let (Feature::Face(face), Feature::Vertex(vertex)) = (c.meeting.first, c.meeting.second) else { continue };
            let (axis, sign) = ((face / 2) as usize, if face % 2 == 1 { 1 } else { -1 });
            let mut normal = [0; 3];
            normal[axis] = sign;
            let n = turn(matrix(qa), normal);
            let corner = [0, 1, 2].map(|k| if vertex >> k & 1 == 1 { half_b[k] } else { -half_b[k] });
            let r = turn(matrix(qb), corner);
            // n·(x + R b) − h over |q_A|² |q_B|² 32.
            let (na, nb) = (norm(qa), norm(qb));
            let numerator: i128 = (0..3).map(|k| n[k] * (x[k] * nb + r[k])).sum::<i128>() - half_a[axis] * na * nb;
            let exact = numerator as f64 / (na * nb * 32) as f64;
            prop_assert!((c.gap - exact).abs() <= 16.0 * f64::EPSILON, "{} {exact}", c.gap);
        }
    }

    #[test]
    fn frames_are_rotations(turn in quaternion(), small in prop::array::uniform3(-1e-9..1e-9f64)) {
        for n in [turn * v(0.0, 0.0, 1.0), (v(-2.0, -3.0, -6.0) / 7.0 + Vector3::from(small)).normalize()] {
            let f = frame(&n);
            prop_assert!((f.transpose() * f - nalgebra::Matrix3::identity()).amax() <= 4e-15);
            prop_assert!((f.determinant() - 1.0).abs() <= 4e-15);
            prop_assert_eq!(f.column(0).into_owned(), n);
        }
    }

    /// A ball against a polyhedron: the plane through the point found has the polyhedron behind it.
    #[test]
    fn balls_find_the_nearest_point(hull in polyhedron(), p in pose(1.0), x in prop::array::uniform3(-2.0..2.0f64)) {
        let ball = Shape::ball(0.1).expect("a ball");
        let centre = Vector3::from(x);
        let found = contacts((&hull, &p), (&ball, &at(x[0], x[1], x[2])), 10.0);
        prop_assert_eq!(found.len(), 1);
        let distance = found[0].gap + 0.1;
        let hull = hull.as_polyhedron().expect("a polyhedron");
        let height = (0..hull.faces()).map(|f| {
            let (n, d) = hull.plane(f).expect("a face");
            n.dot(&p.turn_back(&(centre - p.position()))) - d
        }).fold(f64::NEG_INFINITY, f64::max);
        if height <= 0.0 {
            prop_assert!((distance - height).abs() <= 1e-13);
            return Ok(());
        }
        let [on_hull, _] = found[0].points(&p, &at(x[0], x[1], x[2]));
        // The plane through the point found, normal to the line, has the hull behind it: it is the nearest.
        for y in hull.vertices() {
            prop_assert!(found[0].normal.dot(&(p.place(y) - on_hull)) <= 1e-8);
        }
        prop_assert!(distance >= height - 1e-13);
    }
}
