//! Triangles of a hull joined to plane faces.

use nalgebra::Vector3;

use super::triangle::{Triangle, side};

const NONE: u32 = u32::MAX;

/// The vertices kept, and the faces as rings of places among them; `None` where a ring is no simple polygon.
///
/// Faces grow from the largest triangles: a neighbour joins where all its corners are within `tolerance` of the plane of the
/// first; for 0, where they are in it exactly.
pub(super) fn faces(
    points: &[Vector3<f64>],
    triangles: &[Triangle],
    tolerance: f64,
) -> Option<(Vec<u32>, Vec<Vec<u32>>)> {
    let area = |t: &Triangle| {
        let [a, b, c] = t.corners.map(|v| points[v as usize]);
        (b - a).cross(&(c - a))
    };
    let longest = |t: &Triangle| {
        let [a, b, c] = t.corners.map(|v| points[v as usize]);
        (b - a).norm().max((c - b).norm()).max((a - c).norm())
    };
    let mut largest_first: Vec<(f64, u32)> =
        triangles.iter().zip(0..).map(|(t, i)| (area(t).norm_squared(), i)).collect();
    largest_first.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
    let mut group = vec![NONE; triangles.len()];
    let (mut groups, mut stack) = (0, Vec::new());
    for &(_, seed) in &largest_first {
        if group[seed as usize] != NONE {
            continue;
        }
        let first = &triangles[seed as usize];
        let along = area(first);
        let normal = along / along.norm();
        let origin = points[first.corners[0] as usize];
        let joins = |t: &Triangle| {
            let near = |&v: &u32| match tolerance > 0.0 {
                true => normal.dot(&(points[v as usize] - origin)).abs() <= tolerance,
                false => side(points, first.corners, v) == 0.0,
            };
            // A sliver's own normal is noise, its corners are what counts; one across a thin solid looks the other way.
            t.corners.iter().all(near)
                && (area(t).dot(&normal) > 0.0 || area(t).norm() <= tolerance * longest(t))
        };
        group[seed as usize] = groups;
        stack.push(seed);
        while let Some(t) = stack.pop() {
            for other in triangles[t as usize].across {
                if group[other as usize] == NONE && joins(&triangles[other as usize]) {
                    group[other as usize] = groups;
                    stack.push(other);
                }
            }
        }
        groups += 1;
    }
    rings(points.len(), triangles, &group, groups)
}

/// The borders of the groups, of the vertices at which three of them or more meet.
fn rings(
    points: usize,
    triangles: &[Triangle],
    group: &[u32],
    groups: u32,
) -> Option<(Vec<u32>, Vec<Vec<u32>>)> {
    let mut meeting = vec![Vec::<u32>::new(); points];
    for (triangle, &g) in triangles.iter().zip(group) {
        for v in triangle.corners {
            let met = &mut meeting[v as usize];
            if !met.contains(&g) {
                met.push(g);
            }
        }
    }
    let kept: Vec<u32> = (0..points as u32).filter(|&v| meeting[v as usize].len() >= 3).collect();
    let mut place = vec![NONE; points];
    for (i, &v) in kept.iter().enumerate() {
        place[v as usize] = i as u32;
    }
    // Sides on a border, by group.
    let mut sides = vec![Vec::new(); groups as usize];
    for (t, triangle) in triangles.iter().enumerate() {
        for k in 0..3 {
            if group[triangle.across[k] as usize] != group[t] {
                sides[group[t] as usize].push((triangle.corners[k], triangle.corners[(k + 1) % 3]));
            }
        }
    }
    let mut faces = Vec::new();
    for mut sides in sides {
        sides.sort_unstable();
        if sides.is_empty() || sides.windows(2).any(|pair| pair[0].0 == pair[1].0) {
            return None;
        }
        let next = |v: u32| sides.binary_search_by_key(&v, |side| side.0).ok().map(|i| sides[i].1);
        let start = sides[0].0;
        let (mut ring, mut at, mut walked) = (Vec::new(), start, 0);
        loop {
            if place[at as usize] != NONE {
                ring.push(place[at as usize]);
            }
            at = next(at)?;
            walked += 1;
            if at == start {
                break;
            }
        }
        if walked != sides.len() || ring.len() < 3 {
            return None;
        }
        faces.push(ring);
    }
    Some((kept, faces))
}
