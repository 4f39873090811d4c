//! Meshes: formats, groups, and errors that name what is wrong.

mod wild_meshes;

use nonsmooth::mesh::{Mesh, MeshError, Pattern, rectangle};

const FOUR: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 1 \"the floor\"\n2 2 \"body\"\n\
    $EndPhysicalNames\n$Entities\n0 1 1 0\n1 0 0 0 1 0 0 1 1 0\n6 0 0 0 1 1 0 1 2 1 1\n$EndEntities\n$Nodes\n1 4 1 4\n\
    2 6 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n$EndNodes\n$Elements\n2 3 1 3\n1 1 1 1\n1 1 2\n2 6 2 2\n2 1 2 3\n\
    3 1 3 4\n$EndElements\n";

const TWO: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 1 \"the floor\"\n2 2 \"body\"\n\
    $EndPhysicalNames\n$Comments\nanything\n$EndComments\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n\
    $Elements\n3\n1 1 2 1 1 1 2\n2 2 2 2 6 1 2 3\n3 2 2 2 6 1 3 4\n$EndElements\n";

fn parse(text: &str) -> Result<Mesh, MeshError> {
    Mesh::parse(text.as_bytes())
}

/// [`TWO`] or [`FOUR`] in binary, in either order of bytes.
fn binary(four: bool, big: bool) -> Vec<u8> {
    let mut out = Vec::new();
    let int = |out: &mut Vec<u8>, x: i32| out.extend(if big { x.to_be_bytes() } else { x.to_le_bytes() });
    let size = |out: &mut Vec<u8>, x: u64| out.extend(if big { x.to_be_bytes() } else { x.to_le_bytes() });
    let real = |out: &mut Vec<u8>, x: f64| out.extend(if big { x.to_be_bytes() } else { x.to_le_bytes() });
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    out.extend(format!("$MeshFormat\n{} 1 8\n", if four { "4.1" } else { "2.2" }).bytes());
    int(&mut out, 1);
    out.extend(b"\n$EndMeshFormat\n$PhysicalNames\n2\n1 1 \"the floor\"\n2 2 \"body\"\n$EndPhysicalNames\n");
    if four {
        out.extend(b"$Entities\n");
        [0, 1, 1, 0].iter().for_each(|&n| size(&mut out, n));
        int(&mut out, 1);
        (0..6).for_each(|_| real(&mut out, 0.0));
        size(&mut out, 1);
        int(&mut out, 1);
        size(&mut out, 0);
        int(&mut out, 6);
        (0..6).for_each(|_| real(&mut out, 0.0));
        size(&mut out, 1);
        int(&mut out, 2);
        size(&mut out, 1);
        int(&mut out, 1);
        out.extend(b"\n$EndEntities\n$Nodes\n");
        [1, 4, 1, 4].iter().for_each(|&n| size(&mut out, n));
        [2, 6, 0].iter().for_each(|&n| int(&mut out, n));
        [4, 1, 2, 3, 4].iter().for_each(|&n| size(&mut out, n));
        corners.iter().for_each(|[x, y]| [*x, *y, 0.0].iter().for_each(|&x| real(&mut out, x)));
        out.extend(b"\n$EndNodes\n$Elements\n");
        [2, 3, 1, 3].iter().for_each(|&n| size(&mut out, n));
        [1, 1, 1].iter().for_each(|&n| int(&mut out, n));
        [1, 1, 1, 2].iter().for_each(|&n| size(&mut out, n));
        [2, 6, 2].iter().for_each(|&n| int(&mut out, n));
        [2, 2, 1, 2, 3, 3, 1, 3, 4].iter().for_each(|&n| size(&mut out, n));
    } else {
        out.extend(b"$Nodes\n4\n");
        for (i, [x, y]) in corners.iter().enumerate() {
            int(&mut out, i as i32 + 1);
            [*x, *y, 0.0].iter().for_each(|&x| real(&mut out, x));
        }
        out.extend(b"\n$EndNodes\n$Elements\n3\n");
        [1, 1, 2, 1, 1, 1, 1, 2].iter().for_each(|&n| int(&mut out, n));
        [2, 2, 2, 2, 2, 6, 1, 2, 3, 3, 2, 6, 1, 3, 4].iter().for_each(|&n| int(&mut out, n));
    }
    out.extend(b"\n$EndElements\n");
    out
}

#[test]
fn both_formats_say_the_same_in_text_and_in_binary() {
    let mesh = parse(FOUR).expect("format 4.1");
    assert_eq!((mesh.dimension(), mesh.nodes().len(), mesh.body().count()), (2, 4, 2));
    assert_eq!(mesh.group_nodes("the floor").expect("named"), [0, 1]);
    assert_eq!(parse(TWO).expect("format 2.2"), mesh);
    for four in [true, false] {
        for big in [true, false] {
            let read = Mesh::parse(&binary(four, big));
            assert_eq!(read.as_ref(), Ok(&mesh), "binary, format 4.1: {four}, big endian: {big}");
        }
    }
}

#[test]
fn faults_are_named() {
    let refuse = |text: String| parse(&text).expect_err("a fault").to_string();
    let degenerate = refuse(TWO.replace("2 2 2 2 6 1 2 3", "2 2 2 2 6 1 2 2"));
    assert!(degenerate.contains("element 2 (nodes [1, 2, 2]) is degenerate"), "{degenerate}");
    let absent = refuse(TWO.replace("3 2 2 2 6 1 3 4", "3 2 2 2 6 1 3 7"));
    assert!(absent.contains("element 3 names node 7"), "{absent}");
    let twice = refuse(TWO.replace("2 1 0 0", "1 1 0 0"));
    assert!(twice.contains("node 1 is defined twice"), "{twice}");
    let quad = refuse(TWO.replace("3 2 2 2 6 1 3 4", "3 3 2 2 6 1 2 3 4"));
    assert!(quad.contains("four-node quadrangle (Gmsh type 3; the first is element 3)"), "{quad}");
    let bent = refuse(TWO.replace("4 0 1 0", "4 0 1 0.5"));
    assert!(bent.contains("node 4") && bent.contains('z'), "{bent}");
    let infinite = refuse(TWO.replace("4 0 1 0", "4 inf 1 0"));
    assert!(infinite.contains("node 4: coordinate x is inf"), "{infinite}");
    let missing = parse(TWO).expect("sound").group_nodes("roof").expect_err("a fault").to_string();
    assert!(missing.contains("no group `roof` (known: body, curve 1, surface 6, the floor)"), "{missing}");
    let wrong = parse(TWO).expect("sound").group_elements("body", 1).expect_err("a fault").to_string();
    assert!(wrong.contains("group `body` has element 2 of dimension 2, 1 needed"), "{wrong}");
    let old = refuse(TWO.replace("2.2 0 8", "1.0 0 8"));
    assert!(old.contains("MSH format 1.0") && old.contains("line 2") || old.contains("line 3"), "{old}");
}

#[test]
fn damaged_files_are_errors_not_panics() {
    for whole in [FOUR.as_bytes().to_vec(), TWO.as_bytes().to_vec(), binary(true, false), binary(false, true)]
    {
        // Cut anywhere before the last section ends, and with any one byte replaced.
        for end in 0..whole.len().saturating_sub(14) {
            assert!(Mesh::parse(&whole[..end]).is_err(), "cut at {end}");
        }
        for at in 0..whole.len() {
            for byte in [b'0', b'9', b'-', b'\n', 0, 0xff] {
                let mut damaged = whole.clone();
                damaged[at] = byte;
                let _either = Mesh::parse(&damaged);
            }
        }
    }
    // A count that no memory would hold ends with the text.
    let lying = FOUR.replace("2 6 0 4\n", "2 6 0 18446744073709551615\n");
    assert!(parse(&lying).is_err());
}

/// Area of a mesh, and its smallest angle in degrees.
fn quality(mesh: &Mesh) -> (f64, f64) {
    let mut smallest = 180.0_f64;
    for element in mesh.body() {
        let at: Vec<[f64; 2]> =
            element.shape.nodes().iter().map(|&node| mesh.nodes()[node].position).collect();
        for i in 0..3 {
            let [a, b, c] = [at[i], at[(i + 1) % 3], at[(i + 2) % 3]];
            let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
            let angle = (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1]);
            smallest = smallest.min(angle.to_degrees());
        }
    }
    (mesh.body().map(|element| mesh.measure(element)).sum(), smallest)
}

#[test]
fn rectangles_are_filled_with_good_triangles() {
    let mut patterns = vec![(Pattern::Structured, 30.0)];
    if cfg!(feature = "mesher") {
        // Equilateral inside; where rows meet the sides at another spacing, above 20°.
        patterns.push((Pattern::Quality, 20.0));
    }
    for (pattern, angle) in patterns {
        for (width, height, size) in
            [(40.0, 25.0, 1.0), (3.0, 1.0, 0.37), (1.0, 7.0, 0.5), (1e-3, 2e-3, 1e-4)]
        {
            let mesh = rectangle(width, height, size, pattern).expect("a rectangle");
            let (area, smallest) = quality(&mesh);
            assert!((area / (width * height) - 1.0).abs() < 1e-12, "{pattern:?}: area {area}");
            assert!(smallest > angle, "{pattern:?} {width}×{height} at {size}: {smallest}°");
            let edges = mesh.group_elements("bottom", 1).expect("a side").len();
            assert_eq!(edges as f64, (width / size).round());
            assert_eq!(mesh.group_nodes("left").expect("a side").len() as f64, (height / size).round() + 1.0);
        }
    }
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9] {
        assert!(rectangle(1.0, 1.0, bad, Pattern::Structured).is_err() || bad == f64::INFINITY, "{bad}");
    }
}

#[test]
fn a_side_too_short_for_the_elements_is_refused() {
    let refused = rectangle(1e-308, 25.0, 8.0, Pattern::Quality);
    assert!(
        matches!(refused, Err(MeshError::OutOfRange { what: "the number of elements", .. })),
        "{refused:?}"
    );
}
