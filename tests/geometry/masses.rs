//! Mass, centre and inertia against closed forms; principal axes.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use nonsmooth::geometry::{
    Compound, InertiaError, MassProperties, Part, Polyhedron, Pose, Principal, Shape, ShapeError,
};
use proptest::prelude::*;

use crate::common::{at, quaternion, turned, v};

fn close(a: &Matrix3<f64>, b: &Matrix3<f64>, tolerance: f64) {
    assert!((a - b).amax() <= tolerance * b.amax(), "{a} is not {b}");
}

#[test]
fn a_box() {
    let (half, density) = (v(0.3, 0.5, 0.8), 7.0);
    let mass = density * 8.0 * 0.3 * 0.5 * 0.8;
    let squares = (half * 2.0).component_mul(&(half * 2.0));
    let moments = v(squares.y + squares.z, squares.x + squares.z, squares.x + squares.y) * (mass / 12.0);
    let exact = Matrix3::from_diagonal(&moments);
    let of_box = Shape::cuboid(half).expect("a box").mass_properties(density).expect("a mass");
    let hull = Polyhedron::cuboid(half).expect("a box").mass_properties(density);
    for found in [of_box, hull] {
        assert!((found.mass - mass).abs() <= 4.0 * f64::EPSILON * mass);
        assert!(found.centre.norm() <= 1e-16);
        close(&found.inertia, &exact, 1e-15);
    }
}

/// A right-angled tetrahedron with legs a, b, c along the axes: m = ρabc/6, centre (a, b, c)/4, products about the corner
/// ∫x² = m a²/10, ∫xy = m ab/20.
#[test]
fn a_tetrahedron() {
    let (a, b, c, density) = (1.2, 0.7, 2.0, 3.0);
    let shift = v(5.0, -3.0, 2.0);
    let points = [v(0.0, 0.0, 0.0), v(a, 0.0, 0.0), v(0.0, b, 0.0), v(0.0, 0.0, c)].map(|x| x + shift);
    let found = Polyhedron::hull(&points).expect("a tetrahedron").mass_properties(density);
    let mass = density * a * b * c / 6.0;
    let legs = v(a, b, c);
    let products =
        (legs * legs.transpose() + Matrix3::from_diagonal(&legs.component_mul(&legs))) * (mass / 20.0);
    let about_centre = products - legs * legs.transpose() * (mass / 16.0);
    let exact = Matrix3::identity() * about_centre.trace() - about_centre;
    assert!((found.mass - mass).abs() <= 1e-15 * mass);
    assert!((found.centre - shift - legs / 4.0).norm() <= 1e-14);
    close(&found.inertia, &exact, 1e-14);
}

/// Polyhedra of ever more facets come to the closed forms of rounds, with the square of the facet.
#[test]
fn rounds() {
    let shapes =
        |sides| [Shape::cylinder(0.7, 0.9, sides), Shape::cone(0.7, 1.3, sides)].map(|s| s.expect("a round"));
    let error = |sides: usize| -> [f64; 2] {
        shapes(sides).map(|shape| {
            let exact = shape.mass_properties(2.0).expect("a mass");
            let hull = shape.as_polyhedron().expect("facets").mass_properties(2.0);
            assert!(hull.centre.norm() <= 1e-14, "the origin is the centre");
            (exact.inertia - hull.inertia).amax() / exact.inertia.amax()
        })
    };
    for (coarse, fine) in error(100).into_iter().zip(error(200)) {
        assert!(fine < 1e-3 && f64::abs(coarse / fine - 4.0) < 0.02, "{coarse:e} → {fine:e}");
    }
}

/// A capsule against a sum of thin discs.
#[test]
fn a_capsule() {
    let (r, l) = (0.4, 0.7);
    let found = Shape::capsule(r, l).expect("a capsule").mass_properties(1.0).expect("a mass");
    let n = 200_000;
    let (mut mass, mut across, mut along) = (0.0, 0.0, 0.0);
    for k in 0..n {
        let dz = 2.0 * (r + l) / f64::from(n);
        let z = -(r + l) + (f64::from(k) + 0.5) * dz;
        let beyond = (z.abs() - l).max(0.0);
        let square = (r * r - beyond * beyond).max(0.0);
        let disc = std::f64::consts::PI * square * dz;
        mass += disc;
        across += disc * (square / 4.0 + z * z);
        along += disc * square / 2.0;
    }
    assert!((found.mass - mass).abs() <= 1e-8 * mass);
    close(&found.inertia, &Matrix3::from_diagonal(&v(across, across, along)), 1e-8);
}

#[test]
fn two_halves_are_one_box() {
    let half = Shape::cuboid(v(0.5, 0.4, 0.3)).expect("a box");
    let parts = [-0.5, 0.5].map(|x| Part { shape: half.clone(), pose: at(x, 0.0, 0.0) });
    let whole = Shape::cuboid(v(1.0, 0.4, 0.3)).expect("a box").mass_properties(2.0).expect("a mass");
    let found = Compound::new(parts.to_vec()).mass_properties(2.0).expect("a mass");
    assert!((found.mass - whole.mass).abs() <= 1e-15);
    close(&found.inertia, &whole.inertia, 1e-15);
    let shifted =
        parts.map(|part| Part { pose: turned([3.0, 1.0, -2.0], [0.1, 0.7, 0.4]).part(&part.pose), ..part });
    let (union, mass, principal, frame) =
        Compound::new(shifted.to_vec()).into_principal(2.0).expect("a body");
    assert!((mass - whole.mass).abs() <= 1e-14);
    assert!((frame.position() - v(3.0, 1.0, -2.0)).norm() <= 1e-14);
    let mut moments = [principal.moments.x, principal.moments.y, principal.moments.z];
    moments.sort_by(f64::total_cmp);
    let mut exact = [whole.inertia.m11, whole.inertia.m22, whole.inertia.m33];
    exact.sort_by(f64::total_cmp);
    assert!(moments.iter().zip(exact).all(|(a, b)| (a - b).abs() <= 1e-14));
    let again = union.mass_properties(2.0).expect("a mass");
    assert!(again.centre.norm() <= 1e-14);
    close(&again.inertia, &Matrix3::from_diagonal(&principal.moments), 1e-13);
}

#[test]
fn what_has_no_mass_is_refused() {
    assert!(matches!(Shape::<f64>::half_space().mass_properties(1.0), Err(ShapeError::NoVolume { .. })));
    assert!(matches!(Compound::<f64>::new(vec![]).mass_properties(1.0), Err(ShapeError::NoVolume { .. })));
    for density in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let ball = Shape::ball(1.0).expect("a ball");
        assert!(matches!(ball.mass_properties(density), Err(ShapeError::Density { .. })));
    }
    for length in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Shape::ball(length).is_err() && Shape::capsule(1.0, length).is_err());
        assert!(Shape::cuboid(v(1.0, length, 1.0)).is_err() && Shape::cone(1.0, length, 8).is_err());
        assert!(Shape::cylinder(length, 1.0, 8).is_err());
    }
    assert!(matches!(Shape::cylinder(1.0, 1.0, 2), Err(ShapeError::Facets { sides: 2, .. })));
}

#[test]
fn inertias_of_no_body_are_refused() {
    let diagonal = |a, b, c| Principal::of(&Matrix3::from_diagonal(&v(a, b, c)));
    assert!(matches!(diagonal(1.0, 2.0, 3.1), Err(InertiaError::Triangle { .. })));
    assert!(diagonal(1.0, 2.0, 3.0).is_ok(), "a flat body");
    assert!(matches!(diagonal(1.0, 0.0, 1.0), Err(InertiaError::NotPositive { .. })));
    assert!(matches!(diagonal(1.0, f64::NAN, 1.0), Err(InertiaError::NotFinite)));
    let mut lopsided = Matrix3::identity();
    lopsided[(0, 2)] = 0.1;
    assert!(matches!(Principal::of(&lopsided), Err(InertiaError::NotSymmetric { row: 0, column: 2, .. })));
    assert_eq!(diagonal(3.0, 2.0, 2.5).expect("a body").axes, UnitQuaternion::identity());
}

proptest! {
    #[test]
    fn principal_axes_make_it_diagonal(
        masses in prop::array::uniform3(0.01..1.0f64),
        turn in quaternion(),
    ) {
        // Sums of second moments keep the triangle inequality.
        let total: f64 = masses.iter().sum();
        let moments = Vector3::from(masses.map(|x| total - x));
        let r = turn.to_rotation_matrix();
        let inertia = r.matrix() * Matrix3::from_diagonal(&moments) * r.matrix().transpose();
        let inertia = (inertia + inertia.transpose()) * 0.5;
        let found = Principal::of(&inertia).expect("a body");
        let axes = found.axes.to_rotation_matrix();
        let again = axes.matrix() * Matrix3::from_diagonal(&found.moments) * axes.matrix().transpose();
        prop_assert!((again - inertia).amax() <= 1e-14);
    }

    #[test]
    fn masses_follow_the_body(shape in crate::common::shape(), pose in crate::common::pose(2.0)) {
        let MassProperties { mass, centre, inertia } = shape.mass_properties(1.5).expect("a mass");
        let placed = shape.mass_properties(1.5).expect("a mass").placed(&pose);
        prop_assert!((placed.mass - mass).abs() <= 1e-15 * mass);
        prop_assert!((placed.centre - pose.place(&centre)).norm() <= 1e-14);
        prop_assert!((placed.inertia.trace() - inertia.trace()).abs() <= 1e-14 * inertia.trace());
        prop_assert!(Principal::of(&((placed.inertia + placed.inertia.transpose()) * 0.5)).is_ok());
        let none = Pose::identity();
        prop_assert!((shape.mass_properties(1.5).expect("a mass").placed(&none).inertia - inertia).amax() == 0.0);
    }
}
