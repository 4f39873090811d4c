//! Shapes, poses and shorthands the tests share.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use nonsmooth::geometry::{Contact, NarrowPhase, Polyhedron, Pose, Shape};
use proptest::prelude::*;

pub(crate) fn v(x: f64, y: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, y, z)
}

/// Not turned, at (x, y, z).
pub(crate) fn at(x: f64, y: f64, z: f64) -> Pose<f64> {
    Pose::new(v(x, y, z), UnitQuaternion::identity())
}

/// At (x, y, z), turned by the rotation vector (a, b, c).
pub(crate) fn turned([x, y, z]: [f64; 3], [a, b, c]: [f64; 3]) -> Pose<f64> {
    Pose::new(v(x, y, z), UnitQuaternion::from_scaled_axis(v(a, b, c)))
}

/// A cube of unit edges.
pub(crate) fn cube() -> Shape<f64> {
    Shape::cuboid(v(0.5, 0.5, 0.5)).expect("a cube")
}

/// A prism over a regular polygon of `sides` corners on the unit circle, one high, centred.
pub(crate) fn prism(sides: usize) -> Shape<f64> {
    let corner = |k: usize, z: f64| {
        let angle = std::f64::consts::TAU * k as f64 / sides as f64;
        v(angle.cos(), angle.sin(), z)
    };
    let points: Vec<_> = (0..sides).flat_map(|k| [corner(k, -0.5), corner(k, 0.5)]).collect();
    Shape::polyhedron(Polyhedron::hull(&points).expect("a prism"))
}

pub(crate) fn contacts(
    first: (&Shape<f64>, &Pose<f64>),
    second: (&Shape<f64>, &Pose<f64>),
    reach: f64,
) -> Vec<Contact<f64>> {
    let mut out = Vec::new();
    NarrowPhase::new().contacts(first, second, reach, &mut out);
    for contact in &out {
        let [a, b] = contact.points(first.1, second.1);
        let scale = a.norm() + b.norm() + 1.0;
        assert!((contact.normal.norm() - 1.0).abs() <= 1e-14, "{contact:?}");
        assert!((contact.normal.dot(&(b - a)) - contact.gap).abs() <= 1e-13 * scale, "{contact:?}");
        assert!(contact.gap <= reach);
    }
    out
}

/// Identities, sorted, all different.
pub(crate) fn ids(contacts: &[Contact<f64>]) -> Vec<u64> {
    let mut ids: Vec<_> = contacts.iter().map(|contact| contact.meeting.id()).collect();
    ids.sort_unstable();
    assert!(ids.windows(2).all(|pair| pair[0] != pair[1]), "contacts share an identity: {contacts:?}");
    ids
}

pub(crate) fn quaternion() -> impl Strategy<Value = UnitQuaternion<f64>> {
    prop::array::uniform4(-1.0..1.0f64)
        .prop_filter("a length", |q| q.iter().map(|x| x * x).sum::<f64>() > 1e-3)
        .prop_map(|[w, x, y, z]| UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)))
}

pub(crate) fn pose(within: f64) -> impl Strategy<Value = Pose<f64>> {
    (prop::array::uniform3(-within..within), quaternion())
        .prop_map(|([x, y, z], turn)| Pose::new(v(x, y, z), turn))
}

/// Boxes and hulls of random points, of sizes around 1.
pub(crate) fn polyhedron() -> impl Strategy<Value = Shape<f64>> {
    let cuboid =
        prop::array::uniform3(0.2..1.0f64).prop_map(|[x, y, z]| Shape::cuboid(v(x, y, z)).expect("a box"));
    let points = prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 6..40);
    let hull = points.prop_filter_map("a solid", |points| {
        let points: Vec<_> = points.into_iter().map(Vector3::from).collect();
        Polyhedron::hull(&points).ok().map(Shape::polyhedron)
    });
    prop_oneof![cuboid, hull]
}

/// Any shape but a half-space.
pub(crate) fn shape() -> impl Strategy<Value = Shape<f64>> {
    let length = || 0.2..1.0f64;
    prop_oneof![
        polyhedron(),
        length().prop_map(|r| Shape::ball(r).expect("a ball")),
        (length(), length()).prop_map(|(r, l)| Shape::capsule(r, l).expect("a capsule")),
        (length(), length()).prop_map(|(r, h)| Shape::cylinder(r, h, 12).expect("a cylinder")),
        (length(), length()).prop_map(|(r, h)| Shape::cone(r, h, 12).expect("a cone")),
    ]
}
