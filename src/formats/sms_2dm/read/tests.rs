//! Reading 2DM files of any origin, and refusing damaged ones.

use std::io::Write;

use super::*;
use crate::base::control::CancelToken;
use crate::formats::sms_2dm::FORMAT;
use crate::formats::{MeshReader, ReadError};
use crate::testing::{Mesh, mesh_in};

const TRIANGLE: &str = "MESH2D\nND 1 0 0 1.5\nND 2 1 0 -2e3\nND 3 0 1 0\nE3T 1 1 2 3 1\n";

fn read(bytes: &[u8]) -> Result<Mesh, String> {
    mesh_in(&FORMAT, bytes)
}

fn expected() -> Mesh {
    (vec![[0.0, 0.0, 1.5], [1.0, 0.0, -2e3], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])
}

#[test]
fn meshes_are_read_as_other_programs_have_them() {
    assert_eq!(read(TRIANGLE.as_bytes()), Ok(expected()));
    for text in [
        TRIANGLE.replace('\n', "\r\n"),
        TRIANGLE.trim_end().to_string(),
        // What SMS writes: elements first, wide columns, names, strings of nodes, boundary conditions, lines.
        "# by hand\n\nMESH2D\nMESHNAME \"a mesh\"\nNUM_MATERIALS_PER_ELEM 2\nE3T      1       1       2       3    1 -7.5\n\
         ND       1  0.00000000e+000 0.00000000e+000 1.50000000e+000\nND 2 1 0 -2000\nE2L 2 1 2\nND 3 0 1 +0\nNS 1 2 -3 1\n\
         BEGPARAMDEF\nGM \"Mesh\"\nENDPARAMDEF\nMAT 1 \"Material 01\"\n"
            .to_string(),
        // Nodes from another number on.
        "MESH2D\nND 0 0 0 1.5\nND 1 1 0 -2e3\nND 2 0 1 0\nE3T 0 0 1 2\n".to_string(),
        "MESH2D\nND 7 0 0 1.5\nND 8 1 0 -2e3\nND 9 0 1 0\nE3T 5 7 8 9\n".to_string(),
    ] {
        assert_eq!(read(text.as_bytes()), Ok(expected()), "{text}");
    }
}

#[test]
fn damage_is_named_with_its_line() {
    for (from, to, said) in [
        ("MESH2D\n", "", "line 1: expected MESH2D, found \"ND 1 0 0 1.5\""),
        ("MESH2D", "MESH3D", "line 1: expected MESH2D, found \"MESH3D\""),
        ("ND 2", "ND 4", "line 3: expected node 2, the number after the one before, found 4"),
        ("ND 3", "ND 2", "line 4: expected node 3, the number after the one before, found 2"),
        ("ND 3", "ND -3", "line 4: expected ND, the number of a node and three coordinates, found \"ND -3 0 1 0\""),
        ("ND 1", "ND 18446744073709551615", "line 2: expected ND, the number of a node"),
        (
            "ND 3 0 1 0",
            "ND 3 0 1",
            "line 4: expected ND, the number of a node and three coordinates, found \"ND 3 0 1\"",
        ),
        ("ND 3 0 1 0", "ND 3 0 1 0 0", "line 4: expected ND"),
        ("ND 3 0 1 0", "ND 3 0 1 zero", "line 4: expected ND"),
        ("ND 3 0 1 0", "ND", "line 4: expected ND"),
        ("1 2 3 1", "1 2 4 1", "line 5: expected nodes 1 to 3, found 4"),
        ("1 2 3 1", "0 2 3 1", "line 5: expected nodes 1 to 3, found 0"),
        (
            "1 2 3 1",
            "1 2",
            "line 5: expected E3T, the number of an element and three numbers of nodes, found \"E3T 1 1 2\"",
        ),
        ("1 2 3 1", "1 2 3 one", "line 5: expected E3T"),
        ("1 2 3 1", "1 2 -3 1", "line 5: expected E3T"),
        ("E3T 1 1 2 3 1", "E4Q 1 1 2 3 1 1", "line 5: expected a triangle (E3T), found an element \"E4Q\""),
        ("E3T", "E6T", "line 5: expected a triangle (E3T), found an element \"E6T\""),
    ] {
        let error = read(TRIANGLE.replacen(from, to, 1).as_bytes()).expect_err(to);
        assert!(error.contains(said), "{to}: {error}");
    }
    assert_eq!(read(b"MESH2D\n").unwrap_err(), "expected nodes (lines that begin with ND), found none");
    assert_eq!(read(b"").unwrap_err(), "expected nodes (lines that begin with ND), found none");
    let endless = [b"MESH2D\nND ", vec![b'1'; 2 << 20].as_slice()].concat();
    assert!(read(&endless).unwrap_err().contains("line 2: expected at most 1048576 bytes"));
    // Comments may be of any length.
    let comment = [b"# ", vec![b'x'; 3 << 20].as_slice(), b"\n", TRIANGLE.as_bytes()].concat();
    assert_eq!(read(&comment), Ok(expected()));
}

#[test]
fn what_terrabite_has_written_must_be_whole() {
    let whole = TRIANGLE.replace("2D\n", "2D\n# mesh of 3 nodes and 1 elements\n") + "# end of mesh\n";
    assert_eq!(read(whole.as_bytes()), Ok(expected()));
    for cut in 0..whole.len() {
        assert!(read(&whole.as_bytes()[..cut]).is_err(), "cut at {cut}");
    }
    let torn = |from: &str, to: &str| read(whole.replace(from, to).as_bytes()).unwrap_err();
    let end = "expected the line \"# end of mesh\" at the end, found the end of the file after line 6";
    assert_eq!(torn("# end of mesh\n", ""), end);
    assert_eq!(torn("ND 3 0 1 0\n", ""), "expected 3 nodes, as the second line says, found 2");
    assert_eq!(torn("E3T 1 1 2 3 1\n", ""), "expected 1 elements, as the second line says, found 0");
    // The same comment from somebody else promises nothing.
    assert!(
        read(whole.replace(" elements\n", " triangles\n# end\n").replace("# end of mesh\n", "").as_bytes()).is_ok()
    );
}

#[test]
fn a_file_that_changes_between_passes_is_an_error() {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(TRIANGLE.as_bytes()).unwrap();
    let mut mesh = Sms2dmReader::open(file.path(), &CancelToken::default()).unwrap();
    let mut pass = |text: &str| {
        std::fs::write(file.path(), text).unwrap();
        let mesh: &mut dyn MeshReader = &mut mesh;
        let vertices = mesh.for_each_vertex(|_, _| Ok::<(), ReadError>(())).map_err(|e| e.to_string());
        let faces = mesh.for_each_face(|_, _| Ok::<(), ReadError>(())).map_err(|e| e.to_string());
        [vertices, faces].map(|pass| pass.err().unwrap_or_default())
    };
    let [vertices, faces] = pass("MESH2D\nND 1 0 0 0\n");
    assert!(vertices.contains("expected 3 nodes, as when it was opened, found 1"), "{vertices}");
    assert!(faces.contains("expected 1 elements, as when it was opened, found 0"), "{faces}");
    let [vertices, faces] = pass(&format!("{TRIANGLE}ND 4 0 0 0\nE3T 2 1 2 3\n"));
    assert!(vertices.contains("found 4") && faces.contains("found 2"), "{vertices} {faces}");
    assert_eq!(pass(TRIANGLE), ["", ""]);
}
