//! Meshes as people bring them: other formats, other orders, leftovers, no names.

use nonsmooth::mesh::{Mesh, MeshError, MeshNote};

/// A unit square of two triangles in format 2.2; `{elements}` may be replaced.
fn square(version: &str, elements: &str) -> String {
    let count = elements.lines().count();
    format!(
        "$Comments\nwritten by hand\n$EndComments\n$MeshFormat\n{version} 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n\
         3 1 1 0\n4 0 1 0\n$EndNodes\n$Elements\n{count}\n{elements}$EndElements\n"
    )
}

const TRIANGLES: &str = "1 1 2 1 1 1 2\n2 2 2 2 6 1 2 3\n3 2 2 2 6 1 3 4\n";

fn parse(text: &str) -> Result<Mesh, MeshError> {
    Mesh::parse(text.as_bytes())
}

fn refused(text: &str) -> String {
    parse(text).expect_err("a fault").to_string()
}

fn area(mesh: &Mesh) -> f64 {
    mesh.body().map(|element| mesh.measure(element)).sum()
}

#[test]
fn names_of_groups_have_a_dimension_from_format_2_1_on() {
    let names = |version: &str, names: &str| {
        let section = format!("$EndMeshFormat\n$PhysicalNames\n2\n{names}$EndPhysicalNames");
        square(version, TRIANGLES).replace("$EndMeshFormat", &section)
    };
    for text in [
        names("2", "1 \"the floor\"\n2 \"body\"\n"),
        names("2.0", "1\t\"the floor\"\n2   \"body\"\n"),
        names("2.1", "1 1 \"the floor\"\n2 2 \"body\"\n"),
        names("2.2", "1  1\t\"the floor\"\n2 2 \"body\"\n"),
    ] {
        let mesh = parse(&text).expect("a format of Gmsh");
        assert_eq!(mesh.group_nodes("the floor"), Ok(vec![0, 1]), "{text}");
        assert_eq!(mesh.group_elements("body", 2).map(|body| body.len()), Ok(2), "{text}");
    }
}

/// The same square in format 4.0, as text or binary: entity before dimension, tags of four bytes beside coordinates.
fn format_4_0(binary: bool) -> Vec<u8> {
    let text = "$MeshFormat\n4 0 8\n$EndMeshFormat\n$Entities\n0 1 1 0\n1 0 0 0 1 0 0 1 1 0\n6 0 0 0 1 1 0 1 2 1 1\n\
        $EndEntities\n$Nodes\n1 4\n6 2 0 4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n$Elements\n2 3\n1 1 1 1\n\
        1 1 2\n6 2 2 2\n2 1 2 3\n3 1 3 4\n$EndElements\n";
    if !binary {
        return text.into();
    }
    let mut out = b"$MeshFormat\n4 1 8\n".to_vec();
    let ints = |out: &mut Vec<u8>, all: &[i32]| all.iter().for_each(|x| out.extend(x.to_le_bytes()));
    let sizes = |out: &mut Vec<u8>, all: &[u64]| all.iter().for_each(|x| out.extend(x.to_le_bytes()));
    let reals = |out: &mut Vec<u8>, all: &[f64]| all.iter().for_each(|x| out.extend(x.to_le_bytes()));
    ints(&mut out, &[1]);
    out.extend(b"\n$EndMeshFormat\n$Entities\n");
    sizes(&mut out, &[0, 1, 1, 0]);
    ints(&mut out, &[1]);
    reals(&mut out, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    sizes(&mut out, &[1]);
    ints(&mut out, &[1]);
    sizes(&mut out, &[0]);
    ints(&mut out, &[6]);
    reals(&mut out, &[0.0, 0.0, 0.0, 1.0, 1.0, 0.0]);
    sizes(&mut out, &[1]);
    ints(&mut out, &[2]);
    sizes(&mut out, &[1]);
    ints(&mut out, &[1]);
    out.extend(b"\n$EndEntities\n$Nodes\n");
    sizes(&mut out, &[1, 4]);
    ints(&mut out, &[6, 2, 0]);
    sizes(&mut out, &[4]);
    for (tag, [x, y]) in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].into_iter().enumerate() {
        ints(&mut out, &[tag as i32 + 1]);
        reals(&mut out, &[x, y, 0.0]);
    }
    out.extend(b"\n$EndNodes\n$Elements\n");
    sizes(&mut out, &[2, 3]);
    ints(&mut out, &[1, 1, 1]);
    sizes(&mut out, &[1]);
    ints(&mut out, &[1, 1, 2, 6, 2, 2]);
    sizes(&mut out, &[2]);
    ints(&mut out, &[2, 1, 2, 3, 3, 1, 3, 4]);
    out.extend(b"\n$EndElements\n");
    out
}

#[test]
fn format_4_0_says_what_format_2_2_says() {
    let mesh = parse(&square("2.2", TRIANGLES)).expect("format 2.2");
    for binary in [false, true] {
        let read = Mesh::parse(&format_4_0(binary));
        assert_eq!(read.as_ref(), Ok(&mesh), "binary: {binary}");
    }
}

#[test]
fn partitions_and_periodic_sections_change_nothing() {
    let whole = Mesh::parse(&format_4_0(false)).expect("whole");
    let text = String::from_utf8(format_4_0(false)).expect("text");
    // Surface 6 in the parts 7 and 8; the periodic section stands between the nodes and the elements.
    let parts = "$EndEntities\n$PartitionedEntities\n2\n0\n0 0 2 0\n7 2 6 1 1 0 0 0 1 1 0 1 2 1 1\n\
        8 2 6 1 2 0 0 0 1 1 0 1 2 1 1\n$EndPartitionedEntities\n";
    let periodic = "$EndNodes\n$Periodic\n1\n1 1 1\n2\n1 2\n4 3\n$EndPeriodic\n$Sorcery\n$notasection 1 2 3\n$EndSorcery\n";
    let text = text.replace("$EndEntities\n", parts).replace("$EndNodes\n", periodic).replace(
        "2 3\n1 1 1 1\n1 1 2\n6 2 2 2\n2 1 2 3\n3 1 3 4\n",
        "3 3\n1 1 1 1\n1 1 2\n7 2 2 1\n2 1 2 3\n8 2 2 1\n3 1 3 4\n",
    );
    assert_eq!(parse(&text), Ok(whole));
}

#[test]
fn nodes_with_their_place_on_an_entity_are_nodes() {
    let plain = square("2.2", TRIANGLES);
    let start = plain.find("$Nodes").expect("a section");
    let end = plain.find("$Elements").expect("a section");
    let nodes = "$ParametricNodes\n4\n1 0 0 0 0 1\n2 1 0 0 1 1 1.0\n3 1 1 0 2 6 1.0 1.0\n4 0 1 0 1 4 0.0\n$EndParametricNodes\n";
    let text = format!("{}{nodes}{}", &plain[..start], &plain[end..]);
    assert_eq!(parse(&text), parse(&plain));
}

#[test]
fn clockwise_triangles_are_turned_and_said_to_be() {
    let mesh = parse(&square("2.2", "2 2 2 2 6 1 3 2\n3 2 2 2 6 1 4 3\n")).expect("a clockwise mesh");
    assert!((area(&mesh) - 1.0).abs() < 1e-15);
    assert!(mesh.body().all(|element| mesh.measure(element) > 0.0));
    assert_eq!(mesh.notes(), [MeshNote::Turned { count: 2, element: 2 }]);
}

#[test]
fn a_doubled_element_is_refused_by_number() {
    let doubled = refused(&square("2.2", &format!("{TRIANGLES}4 2 2 2 6 2 3 1\n")));
    assert!(doubled.contains("element 4 is element 2 once more"), "{doubled}");
    let line = refused(&square("2.2", &format!("{TRIANGLES}4 1 2 1 1 2 1\n")));
    assert!(line.contains("element 4 is element 1 once more"), "{line}");
    // In two physical groups format 2 writes an element twice, which is one element all the same.
    let mesh = parse(&square("2.2", &format!("{TRIANGLES}4 2 2 5 6 1 2 3\n"))).expect("in two groups");
    assert!((area(&mesh) - 1.0).abs() < 1e-15);
    assert_eq!(mesh.group_nodes("2:5"), Ok(vec![0, 1, 2]));
}

#[test]
fn elements_that_fold_over_their_neighbours_are_refused() {
    let folded = refused(&square("2.2", "2 2 2 2 6 1 2 3\n3 2 2 2 6 1 2 4\n"));
    assert!(folded.contains("elements 2 and 3 overlap") && folded.contains("[1, 2]"), "{folded}");
}

#[test]
fn nodes_of_no_element_are_left_out_with_a_word() {
    let text = square("2.2", TRIANGLES)
        .replace("$Nodes\n4\n", "$Nodes\n5\n9 5 5 3\n")
        .replace("$Elements\n3\n", "$Elements\n4\n7 15 2 8 3 9\n");
    let mesh = parse(&text).expect("a mesh with a construction point");
    assert_eq!(mesh.nodes().len(), 4);
    assert_eq!(mesh.notes(), [MeshNote::LeftOut { count: 1, node: 9, position: [5.0, 5.0] }]);
    assert_eq!(mesh.group_nodes("the floor").ok(), None);
    assert_eq!(mesh.group_nodes("1:1"), Ok(vec![0, 1]));
    // The group of the point is there, and has nothing left.
    let empty = mesh.group_nodes("0:8").expect_err("empty").to_string();
    assert!(empty.contains("`0:8` has no element"), "{empty}");
}

#[test]
fn parts_that_nothing_connects_are_told() {
    let text = square("2.2", "1 2 2 1 1 1 2 3\n2 2 2 1 1 5 6 4\n")
        .replace("$Nodes\n4\n", "$Nodes\n6\n5 0 3 0\n6 1 3 0\n");
    let mesh = parse(&text).expect("two triangles");
    assert_eq!(mesh.notes().last(), Some(&MeshNote::Parts { count: 2 }));
}

#[test]
fn other_elements_are_refused_by_kind_and_count() {
    let quads = refused(&square("2.2", "1 1 2 1 1 1 2\n4 3 2 2 6 1 2 3 4\n5 3 2 2 6 1 2 3 4\n"));
    assert!(quads.contains("2 elements of the type four-node quadrangle"), "{quads}");
    assert!(quads.contains("the first is element 4") && quads.contains("RecombineAll"), "{quads}");
    let unknown = refused(&square("2.2", "1 77 2 1 1 1 2\n"));
    assert!(unknown.contains("element 1 has the Gmsh type 77"), "{unknown}");
    let first = refused("$NOD\n1\n1 0 0 0\n$ENDNOD\n");
    assert!(first.contains("MSH format 1 is not read; save it as format 2.2 or 4.1"), "{first}");
}

#[test]
fn a_mesh_without_groups_is_used_by_its_entities_and_by_where_its_boundary_is() {
    let mesh = parse(&square("2.2", "1 1 2 0 4 1 2\n2 2 2 0 6 1 2 3\n3 2 2 0 6 1 3 4\n")).expect("no groups");
    assert_eq!(mesh.group_names().collect::<Vec<_>>(), ["curve 4", "surface 6"]);
    assert_eq!(mesh.group_nodes("curve 4"), Ok(vec![0, 1]));
    for (selector, nodes) in [
        ("left", vec![0, 3]),
        ("right", vec![1, 2]),
        ("bottom", vec![0, 1]),
        ("top", vec![2, 3]),
        ("boundary", vec![0, 1, 2, 3]),
        ("x < 1e-6", vec![0, 3]),
        ("y>=1", vec![2, 3]),
        ("x = 1", vec![1, 2]),
        ("normal -y", vec![0, 1]),
        ("normal x", vec![1, 2]),
        ("boundary and normal + x", vec![1, 2]),
    ] {
        assert_eq!(mesh.group_nodes(selector), Ok(nodes), "{selector}");
        assert_eq!(mesh.group_elements(selector, 1).map(|edges| edges.iter().all(|e| e.tag >= 2)), Ok(true));
    }
    // The diagonal is no boundary: no edge lies at both its ends only.
    let nowhere = mesh.group_nodes("x < -1").expect_err("nothing there").to_string();
    assert!(nowhere.contains("`x < -1` has no element: the body reaches from (0, 0) to (1, 1)"), "{nowhere}");
    let unknown = mesh.group_nodes("roof").expect_err("unknown").to_string();
    assert!(unknown.contains("known: curve 4, surface 6") && unknown.contains("`normal -y`"), "{unknown}");
    let bar = Mesh::interval(2.0, 3).expect("a bar");
    assert_eq!(bar.group_nodes("x > 1"), Ok(vec![3]));
    assert_eq!(bar.group_nodes("normal -x"), Ok(vec![0]));
}

#[test]
fn groups_and_selections_take_new_names_once() {
    let mut mesh = parse(&square("2.2", TRIANGLES)).expect("sound");
    mesh.rename_groups([("1:1", "floor"), ("normal y", "lid"), ("curve 1", "first")]).expect("they exist");
    assert_eq!(mesh.group_nodes("floor"), Ok(vec![0, 1]));
    assert_eq!(mesh.group_nodes("lid"), Ok(vec![2, 3]));
    let taken = mesh.rename_groups([("left", "lid")]).expect_err("taken").to_string();
    assert!(taken.contains("a group `lid` already"), "{taken}");
    assert!(mesh.rename_groups([("cellar", "x")]).is_err());
}
