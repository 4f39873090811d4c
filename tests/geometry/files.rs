//! STL and OBJ files: what is read, and what is refused by name.

use nonsmooth::geometry::{Polyhedron, Surface, SurfaceError};
use proptest::prelude::*;

use crate::common::v;

/// Triangles of a box, outwards.
fn triangles() -> Vec<[nalgebra::Vector3<f64>; 3]> {
    let hull = Polyhedron::cuboid(v(0.5, 1.0, 1.5)).expect("a box");
    let mut out = Vec::new();
    for face in 0..6 {
        let at = |k: usize| hull.vertices()[hull.corners(face)[k] as usize];
        out.extend([[at(0), at(1), at(2)], [at(0), at(2), at(3)]]);
    }
    out
}

fn text(triangles: &[[nalgebra::Vector3<f64>; 3]]) -> String {
    let vertex = |x: &nalgebra::Vector3<f64>| format!("      vertex {} {:e} {}\n", x.x, x.y, x.z);
    let facet = |t: &[nalgebra::Vector3<f64>; 3]| {
        let corners: String = t.iter().map(vertex).collect();
        format!("  facet normal 0 0 0\n    outer loop\n{corners}    endloop\n  endfacet\n")
    };
    format!("solid box\n{}endsolid box\n", triangles.iter().map(facet).collect::<String>())
}

fn binary(triangles: &[[nalgebra::Vector3<f64>; 3]]) -> Vec<u8> {
    let mut out = vec![b's'; 80];
    out.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        out.extend([0; 12]);
        out.extend(t.iter().flatten().flat_map(|&c| (c as f32).to_le_bytes()));
        out.extend([0; 2]);
    }
    out
}

const OBJ: &str = "# a pyramid\no pyramid\nv 0 0 0 1.0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1 # tip\nvn 0 0 1\n\
                   f 4 3 2 1\nf 1/1 2/2 5/3\nf 2//1 3//1 5//1\nf -3 -2 -1\nf 4/1/1 1/1/1 5/1/1\n";

fn convex(bytes: &[u8]) -> Result<Polyhedron<f64>, SurfaceError> {
    Surface::from_stl(bytes)?.into_convex(Surface::<f64>::TOLERANCE)
}

#[test]
fn boxes_and_pyramids_are_read() {
    for bytes in [text(&triangles()).into_bytes(), binary(&triangles())] {
        let hull = convex(&bytes).expect("a box");
        assert_eq!((hull.vertices().len(), hull.edges().len(), hull.faces()), (8, 12, 6));
        assert!((hull.mass_properties(1.0).mass - 6.0).abs() <= 1e-14);
    }
    let surface = Surface::<f64>::from_obj(OBJ).expect("a pyramid").scaled(2.0);
    let hull = surface.into_convex(1e-9).expect("a pyramid");
    assert_eq!((hull.vertices().len(), hull.faces()), (5, 5));
    assert!((hull.mass_properties(1.0).mass - 8.0 / 3.0).abs() <= 1e-14);
}

#[test]
fn open_inverted_and_dented_surfaces_are_refused() {
    let open = &triangles()[1..];
    assert!(matches!(convex(text(open).as_bytes()), Err(SurfaceError::Open { .. })));
    let mut one_inverted = triangles();
    one_inverted[3].swap(0, 1);
    assert!(matches!(convex(text(&one_inverted).as_bytes()), Err(SurfaceError::Inconsistent { .. })));
    let mut all_inverted = triangles();
    all_inverted.iter_mut().for_each(|t| t.swap(0, 1));
    assert!(
        matches!(convex(&binary(&all_inverted)), Err(SurfaceError::Inverted { volume }) if (volume + 6.0).abs() < 1e-12)
    );
    // The tip pushed below the base: a dent, as seen from the other side.
    let dent = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 2 2 -1\nv 2 2 -4\n\
                f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 2 1 6\nf 3 2 6\nf 4 3 6\nf 1 4 6\n";
    let surface = Surface::<f64>::from_obj(dent).expect("a surface");
    assert!(matches!(surface.into_convex(1e-6), Err(SurfaceError::Dent { depth, .. }) if depth > 0.5));
    // All points on the hull, but a valley between the wrong diagonal of a bent square.
    let valley = "v 0 0 1\nv 1 0 0\nv 1 1 1\nv 0 1 0\nv 0.5 0.5 -3\n\
                  f 1 2 4\nf 2 3 4\nf 2 1 5\nf 3 2 5\nf 4 3 5\nf 1 4 5\n";
    let surface = Surface::<f64>::from_obj(valley).expect("a surface");
    assert!(matches!(surface.into_convex(1e-6), Err(SurfaceError::NotConvex { .. })));
    assert!(matches!(Surface::<f64>::from_obj("v 0 0 0\n"), Err(SurfaceError::Empty)));
}

#[test]
fn damaged_files_name_their_line() {
    let text = text(&triangles());
    let line = |text: &str| match Surface::<f64>::from_stl(text.as_bytes()) {
        Err(SurfaceError::Text { line, .. }) => line,
        other => panic!("{other:?}"),
    };
    assert_eq!(line(&text.replacen("vertex", "vortex", 1)), 4);
    assert_eq!(line(&text.replacen("-0.5", "nan", 1)), 4);
    assert_eq!(line(&text.replacen("endfacet\n", "\n", 1)), 15);
    assert_eq!(line("hello"), 1);
    let mut short = binary(&triangles());
    short.pop();
    short[0] = 0xff;
    assert!(matches!(
        Surface::<f64>::from_stl(&short),
        Err(SurfaceError::Length { triangles: 12, bytes: 683, .. })
    ));
    for (bad, at) in
        [("v 1 2\n", 1), ("v 0 0 0\nf 1 1\n", 2), ("v 0 0 0\nf 1 2 1\n", 2), ("v 0 0 0\nf 0 1 1\n", 2)]
    {
        assert!(
            matches!(Surface::<f64>::from_obj(bad), Err(SurfaceError::Text { line, .. }) if line == at),
            "{bad}"
        );
    }
}

proptest! {
    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..400), count in 0..8u32) {
        let _ = convex(&bytes);
        let mut bytes = bytes;
        bytes.resize(84 + 50 * count as usize, 7);
        bytes[80..84].copy_from_slice(&count.to_le_bytes());
        let _ = convex(&bytes);
        let _ = Surface::<f64>::from_obj(&String::from_utf8_lossy(&bytes));
    }
}
