//! Terrain: what slides and rolls over triangles of one plane does as on a half-space, and nothing trips over their sides.

#[path = "mechanics/scene_text.rs"]
mod scene_text;

use nalgebra::{UnitQuaternion, Vector3};
use nonsmooth::geometry::{Contact, NarrowPhase, Pose, Shape, Surface, SurfaceError, Terrain};
use nonsmooth::scene::SceneError;
use scene_text::scheme;

/// A body with a law on what `ground` says, stepped: configurations after every step.
fn follow(body: &str, ground: &str, steps: usize) -> Vec<Vec<f64>> {
    let text = format!(
        "title = \"terrain\"\nlaws = [\"newton\"]\ngravity = [0.3, 0.2, -9.81]\n[time]\nstep = 2e-3\nend = 4.0\n\
         [[bodies]]\nname = \"body\"\ndensity = 1000.0\n{body}\n{ground}\n\
         [[interfaces]]\nbetween = [\"body\", \"ground\"]\nparameters = {{ restitution = 0.0, friction = 0.3 }}\n"
    );
    let mut scheme = scheme(&text, 0).unwrap_or_else(|error| panic!("{error}"));
    let mut step = |_| {
        scheme.step().unwrap_or_else(|error| panic!("{error}"));
        scheme.state().q.clone()
    };
    (0..steps).map(&mut step).collect()
}

const HALF_SPACE: &str = "[[half_spaces]]\nname = \"ground\"\nnormal = [0.0, 0.0, 1.0]\n";

/// A flat height field of `n` by `n` cells of 0.037 m by 0.041 m around the origin.
fn flat(n: usize) -> String {
    let row = vec!["0.0"; n + 1].join(", ");
    let rows = vec![format!("[{row}]"); n + 1].join(", ");
    let origin = [-0.5 * 0.037 * n as f64 + 0.011, -0.5 * 0.041 * n as f64 + 0.017];
    format!(
        "[[obstacles]]\nname = \"ground\"\nshapes = [{{ heights = {{ rows = [{rows}], cell = [0.037, 0.041], origin = {origin:?} }} }}]\n"
    )
}

#[test]
fn what_moves_over_flat_triangles_moves_as_on_a_half_space() {
    let ball = "position = [0.0, 0.0, 0.1]\nvelocity = [1.5, 0.7, 0.0]\nspin = [3.0, 1.0, 4.0]\nshapes = [{ ball = 0.1 }]";
    let capsule = "position = [0.0, 0.0, 0.06]\norientation = [1.0, 1.0, 0.2, 0.0]\nvelocity = [1.0, 0.2, 0.0]\n\
                   spin = [0.0, 0.0, 2.0]\nshapes = [{ capsule = [0.05, 0.2] }]";
    let block = "position = [0.0, 0.0, 0.12]\norientation = [0.96, 0.0, 0.02, 0.28]\nvelocity = [1.5, 0.3, 0.0]\n\
                 spin = [0.0, 0.0, 5.0]\nshapes = [{ box = [0.3, 0.2, 0.2] }]";
    for (name, body, tolerance) in [("ball", ball, 0.0), ("capsule", capsule, 1e-9), ("box", block, 1e-9)] {
        let (plane, terrain) = (follow(body, HALF_SPACE, 500), follow(body, &flat(120), 500));
        let way = plane[499].iter().zip(&plane[0]).take(2).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(way > 0.1, "{name} crosses triangles: {way}");
        for (step, (a, b)) in plane.iter().zip(&terrain).enumerate() {
            let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart <= tolerance, "{name}, step {step}: {apart:e}");
        }
    }
}

fn meet(shape: &Shape<f64>, pose: &Pose<f64>, terrain: &Shape<f64>, reach: f64) -> Vec<Contact<f64>> {
    let mut out = Vec::new();
    NarrowPhase::new().contacts((terrain, &Pose::identity()), (shape, pose), reach, &mut out);
    out
}

fn at(x: f64, y: f64, z: f64) -> Pose<f64> {
    Pose::new(Vector3::new(x, y, z), UnitQuaternion::identity())
}

fn field(rows: &[&[f64]]) -> Shape<f64> {
    let rows: Vec<Vec<f64>> = rows.iter().map(|row| row.to_vec()).collect();
    Shape::terrain(Terrain::heights(&rows, [1.0, 1.0], [0.0, 0.0]).expect("a field"))
}

#[test]
fn ridges_valleys_and_borders_meet_a_ball_as_they_should() {
    let ball = Shape::ball(0.2).expect("a ball");
    let ridge = field(&[&[0.0, 1.0, 0.0], &[0.0, 1.0, 0.0], &[0.0, 1.0, 0.0]]);
    for y in [0.3, 1.0, 1.7] {
        let found = meet(&ball, &at(1.0, y, 1.25), &ridge, 0.1);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!((found[0].gap - 0.05).abs() < 1e-15 && (found[0].normal - Vector3::z()).norm() < 1e-15);
    }
    // Over a slope, the slope alone.
    let found = meet(&ball, &at(0.3, 0.7, 0.6), &ridge, 0.1);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!((found[0].gap - (0.3 / 2.0_f64.sqrt() - 0.2)).abs() < 1e-15, "{found:?}");
    // In a valley both slopes, as different contacts; the side at the bottom has none.
    let valley = field(&[&[1.0, 0.0, 1.0], &[1.0, 0.0, 1.0], &[1.0, 0.0, 1.0]]);
    let found = meet(&ball, &at(1.0, 0.9, 0.3), &valley, 0.1);
    assert_eq!(found.len(), 2, "{found:?}");
    assert_ne!(found[0].meeting.id(), found[1].meeting.id());
    let plain = field(&[&[0.0; 3], &[0.0; 3], &[0.0; 3]]);
    // Beyond the border the border, under the surface nothing, deeper than its radius nothing.
    let found = meet(&ball, &at(-0.1, 0.9, 0.1), &plain, 0.1);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!((found[0].gap - (0.02_f64.sqrt() - 0.2)).abs() < 1e-15);
    assert_eq!(meet(&ball, &at(0.7, 0.9, -0.1), &plain, 0.1).len(), 1);
    assert!(meet(&ball, &at(0.7, 0.9, -0.3), &plain, 0.1).is_empty());
}

/// The least distance of a point from a triangle (C. Ericson, Real-Time Collision Detection, 2005, 5.1.5, by cases).
fn distance(p: Vector3<f64>, [a, b, c]: [Vector3<f64>; 3]) -> f64 {
    let normal = (b - a).cross(&(c - a)).normalize();
    let corners = [a, b, c];
    let inside = (0..3).all(|k| {
        let (x, y) = (corners[k], corners[(k + 1) % 3]);
        (y - x).cross(&(p - x)).dot(&normal) >= 0.0
    });
    if inside {
        return normal.dot(&(p - a)).abs();
    }
    let to_side = |k: usize| {
        let (x, y) = (corners[k], corners[(k + 1) % 3]);
        let share = ((p - x).dot(&(y - x)) / (y - x).norm_squared()).clamp(0.0, 1.0);
        (p - x - (y - x) * share).norm()
    };
    (0..3).map(to_side).fold(f64::INFINITY, f64::min)
}

/// Numbers in [0, 1) that are as good as random.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1_u64 << 53) as f64
}

fn bumpy(n: usize, height: f64, state: &mut u64) -> Terrain<f64> {
    let rows: Vec<Vec<f64>> = (0..n).map(|_| (0..n).map(|_| height * random(state)).collect()).collect();
    Terrain::heights(&rows, [1.0, 1.0], [0.0, 0.0]).expect("a field")
}

#[test]
fn the_nearest_contact_of_a_ball_is_as_far_as_the_surface() {
    let mut state = 1;
    for _ in 0..200 {
        let terrain = bumpy(6, 1.0, &mut state);
        let triangles: Vec<[Vector3<f64>; 3]> =
            terrain.triangles().iter().map(|t| t.map(|v| terrain.points()[v as usize])).collect();
        let shape = Shape::terrain(terrain);
        let p = Vector3::new(5.0 * random(&mut state), 5.0 * random(&mut state), 0.8 + random(&mut state));
        // Above the surface.
        let above = triangles.iter().all(|[a, b, c]| {
            let normal = (b - a).cross(&(c - a));
            let over = |x: &Vector3<f64>, y: &Vector3<f64>| {
                (y.x - x.x) * (p.y - x.y) - (y.y - x.y) * (p.x - x.x) >= 0.0
            };
            !(over(a, b) && over(b, c) && over(c, a)) || normal.dot(&(p - a)) > 0.0
        });
        let real = triangles.iter().map(|&t| distance(p, t)).fold(f64::INFINITY, f64::min);
        if !above || real < 1e-3 {
            continue;
        }
        let ball = Shape::ball(0.5 * real).expect("a ball");
        let found = meet(&ball, &at(p.x, p.y, p.z), &shape, 3.0);
        let least = found.iter().map(|contact| contact.gap).fold(f64::INFINITY, f64::min);
        assert!((least - 0.5 * real).abs() < 1e-12, "{least} {real}: {found:?}");
    }
}

#[test]
fn bodies_come_to_rest_on_bumps() {
    let mut state = 3;
    let rows: Vec<Vec<f64>> = (0..21).map(|_| (0..21).map(|_| 0.03 * random(&mut state)).collect()).collect();
    let ground = format!(
        "[[obstacles]]\nname = \"ground\"\nshapes = [{{ heights = {{ rows = {rows:?}, cell = [0.1, 0.1], origin = [-1.0, -1.0] }} }}]\n"
    );
    let height = |x: f64, y: f64| {
        let (u, v) = ((x + 1.0) / 0.1, (y + 1.0) / 0.1);
        let (i, j) = (u.floor() as usize, v.floor() as usize);
        let (s, t) = (u - i as f64, v - j as f64);
        let z = |di: usize, dj: usize| rows[j + dj][i + di];
        // Cells are cut from their first corner to the opposite one.
        match s >= t {
            true => z(0, 0) + s * (z(1, 0) - z(0, 0)) + t * (z(1, 1) - z(1, 0)),
            false => z(0, 0) + t * (z(0, 1) - z(0, 0)) + s * (z(1, 1) - z(0, 1)),
        }
    };
    for body in [
        "position = [0.02, 0.03, 0.14]\norientation = [0.9, 0.2, 0.1, 0.3]\nshapes = [{ box = [0.3, 0.2, 0.1] }]",
        "position = [0.02, 0.03, 0.14]\norientation = [0.9, 0.2, 0.1, 0.3]\nshapes = [{ cylinder = [0.1, 0.1] }]",
        "position = [0.02, 0.03, 0.14]\norientation = [1.0, 1.1, 0.1, 0.3]\nshapes = [{ capsule = [0.05, 0.2] }]",
    ] {
        let states = follow(body, &ground, 1500);
        let (last, before) = (&states[1499], &states[1399]);
        let moved = last.iter().zip(before).take(3).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(last[2] > height(last[0], last[1]), "{body}: sank to {last:?}");
        // A capsule rolls.
        assert!(moved < 0.05 || body.contains("capsule"), "{body}: {moved} in 0.2 s");
        if !body.contains("box") {
            continue;
        }
        let pose =
            Pose::from_parts(Vector3::new(last[0], last[1], last[2]), [last[3], last[4], last[5], last[6]]);
        let pose = pose.expect("a pose");
        for corner in 0..8 {
            let side = |bit: usize, half: f64| if corner >> bit & 1 == 1 { half } else { -half };
            let x = pose.place(&Vector3::new(side(0, 0.15), side(1, 0.1), side(2, 0.05)));
            assert!(x.z - height(x.x, x.y) > -2e-4, "{body}: corner {corner} at {x}");
        }
        for (j, row) in rows.iter().enumerate() {
            for (i, z) in row.iter().enumerate() {
                let x = Vector3::new(0.1 * i as f64 - 1.0, 0.1 * j as f64 - 1.0, *z) - pose.position();
                let x = pose.turn_back(&x);
                let depth = (0.15 - x.x.abs()).min(0.1 - x.y.abs()).min(0.05 - x.z.abs());
                assert!(depth < 2e-4, "{body}: a corner of the terrain is {depth} inside");
            }
        }
    }
}

#[test]
fn what_is_no_terrain_is_refused_by_name() {
    let triangle = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
        let text = [a, b, c].map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
        Surface::<f64>::from_obj(&(text + "f 1 2 3\nf 2 1 3\nf 1 2 3\n"))
    };
    let twice = triangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).expect("a surface");
    assert!(matches!(Terrain::new(&twice), Err(SurfaceError::Inconsistent { .. })));
    let line = triangle([0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]).expect("a surface");
    assert!(matches!(Terrain::new(&line), Err(SurfaceError::Sliver { .. })));
    let heights = |rows: &str, cell: &str| {
        let text = format!(
            "title = \"t\"\nlaws = [\"newton\"]\ndimension = 3\n[time]\nstep = 1e-3\nend = 1.0\n\
             [[bodies]]\nname = \"b\"\nmass = 1.0\nposition = [0.0, 0.0, 1.0]\nshapes = [{{ ball = 0.1 }}]\n\
             [[obstacles]]\nname = \"g\"\nshapes = [{{ heights = {{ {rows} cell = {cell} }} }}]\n"
        );
        scheme(&text, 0).map(drop)
    };
    let told = |result: Result<(), SceneError>| result.expect_err("refused").to_string();
    assert!(told(heights("", "[1.0, 1.0]")).contains("either `rows` or a `file`"));
    assert!(told(heights("rows = [[0.0, 0.0]],", "[1.0, 1.0]")).contains("2 by 2"));
    assert!(told(heights("rows = [[0.0, 0.0], [1.0]],", "[1.0, 1.0]")).contains("row 2 has 1 heights"));
    assert!(told(heights("rows = [[0.0, 0.0], [1.0, 1.0]],", "[0.0, 1.0]")).contains("a cell is 0e0 m wide"));
    assert!(told(heights("rows = [[0.0, nan], [1.0, 1.0]],", "[1.0, 1.0]")).contains("not finite"));
    assert!(told(heights("file = \"none.csv\",", "[1.0, 1.0]")).contains("cannot read none.csv"));
    heights("rows = [[0.0, 0.1], [1.0, 1.0]],", "[1.0, 1.0]").expect("a field");
}
