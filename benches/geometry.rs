//! Cost of contacts of a pair of shapes, and of the broad phase: `cargo bench --bench geometry`.
//!
//! Goals: two polyhedra in 500 ns, two balls in 40 ns; the broad phase like N log N.

use std::hint::black_box;

use divan::Bencher;
use divan::counter::ItemsCount;
use nalgebra::{UnitQuaternion, Vector3};
use nonsmooth::geometry::{BroadPhase, NarrowPhase, Polyhedron, Pose, Shape};

fn main() {
    divan::main();
}

fn v(x: f64, y: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, y, z)
}

fn at(position: Vector3<f64>, turn: Vector3<f64>) -> Pose<f64> {
    Pose::new(position, UnitQuaternion::from_scaled_axis(turn))
}

fn cube() -> Shape<f64> {
    Shape::cuboid(v(0.5, 0.5, 0.5)).expect("a cube")
}

fn prism(sides: usize) -> Shape<f64> {
    let corner = |k: usize, z: f64| {
        let angle = std::f64::consts::TAU * k as f64 / sides as f64;
        v(angle.cos(), angle.sin(), z)
    };
    let points: Vec<_> = (0..sides).flat_map(|k| [corner(k, -0.5), corner(k, 0.5)]).collect();
    Shape::polyhedron(Polyhedron::hull(&points).expect("a prism"))
}

/// Points on a sphere, nearly evenly.
fn stone(vertices: usize) -> Shape<f64> {
    let points: Vec<_> = (0..vertices)
        .map(|k| {
            let (z, angle) = (1.0 - (2 * k + 1) as f64 / vertices as f64, k as f64 * 2.4);
            let r = (1.0 - z * z).sqrt();
            v(r * angle.cos(), r * angle.sin(), z)
        })
        .collect();
    Shape::polyhedron(Polyhedron::hull(&points).expect("a stone"))
}

fn capsule() -> Shape<f64> {
    Shape::capsule(0.25, 0.75).expect("a capsule")
}

fn ball() -> Shape<f64> {
    Shape::ball(0.5).expect("a ball")
}

/// Two shapes, and where the second is to the first.
type Case = (&'static str, Shape<f64>, Shape<f64>, Pose<f64>, usize);

/// With names and numbers of contacts.
fn pairs() -> Vec<Case> {
    let none = v(0.0, 0.0, 0.0);
    let eighth = std::f64::consts::FRAC_PI_4;
    let diamond = v(0.0, eighth, 0.0);
    vec![
        ("balls", ball(), ball(), at(v(0.0, 0.6, 0.8), none), 1),
        ("balls apart", ball(), ball(), at(v(0.0, 0.9, 1.2), none), 0),
        ("half-space and ball", Shape::half_space(), ball(), at(v(0.0, 0.0, 0.5), none), 1),
        ("half-space and cube", Shape::half_space(), cube(), at(v(0.0, 0.0, 0.5), none), 4),
        ("cube and ball", cube(), ball(), at(v(0.1, 0.2, 1.0), none), 1),
        ("cube and ball, edge", cube(), ball(), at(v(0.8, 0.2, 0.9), none), 1),
        ("capsules", capsule(), capsule(), at(v(0.5, 0.1, 0.1), diamond), 2),
        ("cube and capsule", cube(), capsule(), at(v(0.1, 0.1, 0.75), v(0.0, 2.0 * eighth, 0.0)), 2),
        ("cubes, equal", cube(), cube(), at(v(0.0, 0.0, 1.0), none), 4),
        ("cubes, offset", cube(), cube(), at(v(0.2, 0.3, 1.0), none), 4),
        ("cubes, yawed", cube(), cube(), at(v(0.2, 0.3, 1.0), v(0.0, 0.0, 0.3)), 4),
        ("cubes, yawed on top", cube(), cube(), at(v(0.0, 0.0, 1.0), v(0.0, 0.0, eighth)), 8),
        ("cubes, an edge", cube(), cube(), at(v(0.0, 0.0, 0.5 + 0.5f64.sqrt()), diamond), 2),
        ("cubes, near", cube(), cube(), at(v(0.0, 0.0, 1.2), v(0.1, 0.2, 0.3)), 0),
        ("cubes, apart", cube(), cube(), at(v(0.0, 0.0, 1.8), none), 0),
        ("prisms of 12", prism(12), prism(12), at(v(0.1, 0.0, 1.0), v(0.0, 0.0, 0.1)), 13),
        ("stones of 40", stone(40), stone(40), at(v(0.3, 0.4, 1.85), v(0.1, 0.2, 0.3)), 0),
    ]
}

#[divan::bench(args = pairs().iter().map(|pair| pair.0).collect::<Vec<_>>(), sample_size = 2000)]
fn pair(bencher: Bencher<'_, '_>, name: &str) {
    let all = pairs();
    let Some((_, a, b, second, expected)) = all.iter().find(|pair| pair.0 == name) else { return };
    let first = at(v(0.0, 0.0, 0.0), v(0.0, 0.0, 0.0));
    let (mut narrow, mut out) = (NarrowPhase::new(), Vec::new());
    narrow.contacts((a, &first), (b, second), 0.01, &mut out);
    if *expected > 0 && out.len() != *expected {
        println!("{name}: {} contacts", out.len());
    }
    bencher.bench_local(|| {
        out.clear();
        narrow.contacts(black_box((a, &first)), black_box((b, second)), 0.01, &mut out);
        black_box(&out);
    });
}

#[divan::bench(args = [1_000, 4_096, 15_625])]
fn broad(bencher: Bencher<'_, '_>, count: usize) {
    let side = (count as f64).cbrt().ceil() as usize;
    let noise = |k: usize| ((k * 7919) % 1000) as f64 * 1e-4;
    let place = |k: usize| {
        v(
            (k % side) as f64 + noise(k),
            (k / side % side) as f64 + noise(k + 1),
            (k / side / side) as f64 + noise(k + 2),
        )
    };
    let poses: Vec<_> = (0..count).map(|k| at(place(k), v(0.0, 0.0, 0.0))).collect();
    let ball = Shape::ball(0.52).expect("a ball");
    let boxes: Vec<_> = poses.iter().map(|pose| ball.bounds(pose, 0.0)).collect();
    let (mut broad, mut out) = (BroadPhase::new(), Vec::new());
    bencher.counter(ItemsCount::new(count)).bench_local(|| {
        out.clear();
        broad.pairs(black_box(&boxes), |_, _| true, &mut out);
        out.len()
    });
}
