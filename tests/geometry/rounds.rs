//! Cylinders and cones.

use nonsmooth::geometry::{Feature, Shape};

use crate::common::{at, contacts, ids, turned, v};

#[test]
fn a_cylinder_on_a_half_space() {
    let (ground, drum) = (Shape::half_space(), Shape::cylinder(0.5, 1.0, 16).expect("a cylinder"));
    // Upright: all vertices of the lower rim, and none twice.
    let found = contacts((&ground, &at(0.0, 0.0, 0.0)), (&drum, &at(0.0, 0.0, 1.0)), 1e-3);
    assert_eq!(ids(&found).len(), 16);
    assert!(found.iter().all(|c| c.gap.abs() <= 1e-15));
    // On its side: both rims, wherever it has rolled to.
    for roll in [0.0, 0.1, 0.2] {
        let pose = turned([0.0; 3], [0.0, std::f64::consts::FRAC_PI_2, 0.0]);
        let spin = turned([0.0; 3], [0.0, 0.0, roll]);
        let pose = nonsmooth::geometry::Pose::new(v(0.0, 0.0, 0.5), pose.orientation() * spin.orientation());
        let found = contacts((&ground, &at(0.0, 0.0, 0.0)), (&drum, &pose), 1e-3);
        let rims: Vec<_> = found.iter().filter(|c| matches!(c.meeting.second, Feature::Rim(_))).collect();
        assert_eq!(rims.len(), 2);
        assert!(rims.iter().all(|c| c.gap.abs() <= 1e-15));
        assert!(found.iter().all(|c| c.gap >= -1e-15), "the vertices are inside");
        ids(&found);
    }
    // Tilted by α about its lower rim: the disc's lowest point is r sin α + h cos α below the centre.
    for alpha in [1e-6, 0.3, 1.2] {
        let height = 0.5 * f64::sin(alpha) + f64::cos(alpha);
        let found = contacts(
            (&ground, &at(0.0, 0.0, 0.0)),
            (&drum, &turned([0.0, 0.0, height], [alpha, 0.0, 0.0])),
            1e-9,
        );
        assert!(found.iter().any(|c| c.meeting.second == Feature::Rim(0) && c.gap.abs() <= 1e-15));
    }
}

#[test]
fn a_cone_on_a_half_space() {
    let (ground, cone) = (Shape::half_space(), Shape::cone(0.3, 0.4, 12).expect("a cone"));
    let upright = contacts((&ground, &at(0.0, 0.0, 0.0)), (&cone, &at(0.0, 0.0, 0.1)), 1e-3);
    assert_eq!(ids(&upright).len(), 12);
    let inverted = turned([0.0, 0.0, 0.3], [std::f64::consts::PI, 0.0, 0.0]);
    let found = contacts((&ground, &at(0.0, 0.0, 0.0)), (&cone, &inverted), 1e-3);
    assert_eq!(found.len(), 1);
    assert!(found[0].gap.abs() <= 1e-15);
    // On its mantle: the rim and the tip.
    let slope = f64::atan2(0.3, 0.4) + std::f64::consts::FRAC_PI_2;
    let height = 0.3 * slope.cos().abs();
    let found = contacts(
        (&ground, &at(0.0, 0.0, 0.0)),
        (&cone, &turned([0.0, 0.0, height], [slope, 0.0, 0.0])),
        1e-9,
    );
    assert!(found.iter().any(|c| matches!(c.meeting.second, Feature::Rim(0))), "{found:?}");
    assert!(found.iter().any(|c| matches!(c.meeting.second, Feature::Vertex(_))));
}

#[test]
fn a_ball_around_a_cylinder_and_a_cone() {
    let (drum, ball) =
        (Shape::cylinder(1.0, 2.0, 5).expect("a cylinder"), Shape::ball(0.25).expect("a ball"));
    let cases = [
        ([0.3, 0.4, 2.5], 0.25, v(0.0, 0.0, 1.0), Feature::Face(1)),
        ([0.0, 0.0, -2.5], 0.25, v(0.0, 0.0, -1.0), Feature::Face(0)),
        ([0.0, 1.5, 0.7], 0.25, v(0.0, 1.0, 0.0), Feature::Mantle(0)),
        ([1.3 * 0.6, 1.3 * 0.8, 2.4], 0.25, v(0.36, 0.48, 0.8), Feature::Rim(1)),
        ([0.0, 0.9, 0.7], -0.35, v(0.0, 1.0, 0.0), Feature::Mantle(0)),
        ([0.0, 0.0, 1.9], -0.35, v(0.0, 0.0, 1.0), Feature::Face(1)),
        ([0.0, 0.0, 0.0], -1.25, v(1.0, 0.0, 0.0), Feature::Mantle(0)),
    ];
    let spin = turned([3.0, -2.0, 1.0], [0.3, -0.7, 0.5]);
    for ([x, y, z], gap, normal, feature) in cases {
        let centre = spin.place(&v(x, y, z));
        let found = contacts((&drum, &spin), (&ball, &at(centre.x, centre.y, centre.z)), 1.0);
        assert_eq!(found.len(), 1);
        let found = found[0];
        assert_eq!(found.meeting.first, feature, "{found:?}");
        assert!((found.gap - gap).abs() <= 4e-15);
        assert!(found.normal.dot(&spin.turn(&normal)) >= 1.0 - 1e-14 || gap == -1.25);
    }
    let cone = Shape::cone(3.0, 4.0, 7).expect("a cone");
    // From the tip at z = 3 and from the middle of the mantle, whose normal is (4, 3)/5.
    let found = contacts((&cone, &at(0.0, 0.0, 0.0)), (&ball, &at(0.0, 0.0, 3.5)), 1.0);
    assert!((found[0].gap - 0.25).abs() <= 1e-15 && found[0].normal.z == 1.0);
    let found = contacts((&cone, &at(0.0, 0.0, 0.0)), (&ball, &at(1.5 + 0.8, 0.0, 1.0 + 0.6)), 1.0);
    assert!((found[0].gap - 0.75).abs() <= 1e-15 && (found[0].normal - v(0.8, 0.0, 0.6)).norm() <= 1e-15);
    assert_eq!(found[0].meeting.first, Feature::Mantle(0));
}

#[test]
fn cylinders_stack() {
    let drum = Shape::cylinder(0.5, 0.5, 24).expect("a cylinder");
    let found = contacts((&drum, &at(0.0, 0.0, 0.0)), (&drum, &at(0.0, 0.0, 1.0)), 1e-3);
    assert_eq!(ids(&found).len(), 24);
    let found =
        contacts((&drum, &at(0.0, 0.0, 0.0)), (&drum, &turned([0.1, 0.0, 1.0], [0.0, 0.0, 0.05])), 1e-3);
    assert!(found.len() >= 20 && found.iter().all(|c| c.gap.abs() <= 1e-15));
}
