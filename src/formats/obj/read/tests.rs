//! Reading OBJ files of any origin, and refusing damaged ones.

use std::io::Write;

use super::{ObjError, ObjReader};
use crate::base::control::CancelToken;
use crate::formats::obj::FORMAT;
use crate::formats::{MeshReader, ReadError, TextError};
use crate::testing::{Mesh, mesh_in};

fn read(bytes: &[u8]) -> Result<Mesh, String> {
    mesh_in(&FORMAT, bytes)
}

const VERTICES: [[f64; 3]; 4] = [[0.0, 0.0, 1.5], [1.0, 0.0, -2e3], [0.0, 1.0, 7.0], [1.0, 1.0, 0.25]];

#[test]
fn what_other_programs_write() {
    let rich = "# Blender v4.5 OBJ File: 'a\\b\\'\nmtllib tin.mtl\r\no terrain\ng\nv 0 0 1.5\nv 1.0 +0.0 -2E3 0.5 .5 1.\n  vt 0 1\n\
                vn 0 0 1\n\nv 0 1 7 1.0\nusemtl rock\ns off\nf 1/1/1 2/1/1 3/1/1\nv\t1 1\t.25 \nf -3//1 \\\n -1//1 -2//1\n\
                f 2/1 4/1 3/1\nl 1 2\np 1\nfo 1 2 4";
    let (vertices, faces) = read(rich.as_bytes()).unwrap();
    assert_eq!(vertices, VERTICES);
    assert_eq!(faces, [[0, 1, 2], [1, 3, 2], [1, 3, 2], [0, 1, 3]]);
    assert_eq!(read(rich.replace('\n', "\r\n").as_bytes()), Ok((vertices, faces)));
}

/// Vertices may come after the faces that name them.
#[test]
fn faces_before_vertices() {
    assert_eq!(read(b"f 1 2 3\nv 0 0 1.5\nv 1 0 -2000\nv 0 1 7\n"), Ok((VERTICES[..3].to_vec(), vec![[0, 1, 2]])));
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\n# a comment\nv 0 1 0\nf 1 2 3\n";

#[test]
fn errors_name_the_line() {
    for (from, to, said) in [
        ("f 1 2 3", "f 1 2 4", "line 5: expected vertices 1 to 3, or -1 to -3 counted back, found 4"),
        ("f 1 2 3", "f 0 1 2", "line 5: expected vertices 1 to 3, or -1 to -3 counted back, found 0"),
        ("f 1 2 3", "f 1 2 -4", "found -4"),
        ("f 1 2 3", "f 1 2 -9223372036854775808", "found -9223372036854775808"),
        ("f 1 2 3", "f 1 2 99999999999999999999", "line 5: expected f and three numbers of vertices, found \"f 1 2 9"),
        ("f 1 2 3", "f 1 2", "line 5: expected a triangle, found 2 corners"),
        ("f 1 2 3", "f 1 2 3 1", "line 5: expected a triangle, found 4 corners"),
        ("f 1 2 3", "f \\\n 1 2", "line 5: expected a triangle"),
        ("f 1 2 3", "f 1 2 3/x", "line 5: expected f and three numbers"),
        ("f 1 2 3", "f 1 2 3/1/1/1", "line 5: expected f and three numbers"),
        ("f 1 2 3", "f 1 2 /3", "line 5: expected f and three numbers"),
        ("f 1 2 3", "surf 0 1 2", "line 5: expected a line of an OBJ mesh of triangles, found \"surf 0 1 2\""),
        ("v 0 1 0", "v 0 1", "line 4: expected v and three numbers, found \"v 0 1\""),
        ("v 0 1 0", "v 0 1 zero", "line 4: expected v and three numbers"),
        ("v 0 1 0", "v 0 1 0 red", "line 4: expected v and three numbers"),
        ("v 0 1 0", "v 1 2 3 4 5 6 7 8", "line 4: expected v and three numbers"),
        ("v 0 1 0", "\u{1}\u{2}", "line 4: expected a line of an OBJ mesh"),
    ] {
        let error = read(TRIANGLE.replace(from, to).as_bytes()).unwrap_err();
        assert!(error.contains(said), "{to}: {error}");
    }
    let endless = [b"v ", vec![b'1'; 2 << 20].as_slice()].concat();
    assert!(read(&endless).unwrap_err().contains("line 1: expected at most 1048576 bytes"));
    assert_eq!(read(b"").unwrap_err(), "expected vertices (lines that begin with v), found none");
    // Comments may be of any length.
    let comment = [b"# ", vec![b'x'; 3 << 20].as_slice(), b"\n", TRIANGLE.as_bytes()].concat();
    assert_eq!(read(&comment).map(|(vertices, _)| vertices.len()), Ok(3));
}

#[test]
fn what_terrabite_has_written_must_be_whole() {
    let whole = format!("# mesh of 3 vertices and 1 triangles\n{TRIANGLE}# end of mesh\n");
    assert!(read(whole.as_bytes()).is_ok());
    assert!(read(whole.replace('\n', "\r\n").as_bytes()).is_ok());
    let torn = |from: &str, to: &str| read(whole.replace(from, to).as_bytes()).unwrap_err();
    assert_eq!(
        torn("# end of mesh\n", ""),
        "expected the line \"# end of mesh\" at the end, found the end of the file after line 6"
    );
    assert!(torn("mesh\n", "mesh").contains("after line 7"));
    assert_eq!(torn("v 1 0 0\n", ""), "expected 3 vertices, as the first line says, found 2");
    assert_eq!(torn("f 1 2 3\n", ""), "expected 1 triangles, as the first line says, found 0");
    // The same comment from somebody else promises nothing.
    assert!(read(format!("# mesh of a horse\n{TRIANGLE}").as_bytes()).is_ok());
}

#[test]
fn a_file_that_changes_between_passes_is_an_error() {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(TRIANGLE.as_bytes()).unwrap();
    let mut mesh = ObjReader::open(file.path(), &CancelToken::default()).unwrap();
    let mut pass = |text: &str| {
        std::fs::write(file.path(), text).unwrap();
        let mesh: &mut dyn MeshReader = &mut mesh;
        let vertices = mesh.for_each_vertex(|_, _| Ok::<(), ReadError>(())).map_err(|e| e.to_string());
        let faces = mesh.for_each_face(|_, _| Ok::<(), ReadError>(())).map_err(|e| e.to_string());
        [vertices, faces].map(|pass| pass.err().unwrap_or_default())
    };
    let [vertices, faces] = pass(&TRIANGLE[..8]);
    assert!(vertices.contains("expected 3 vertices, as when it was opened, found 1"), "{vertices}");
    assert!(faces.contains("expected 1 faces, as when it was opened, found 0"), "{faces}");
    let [vertices, faces] = pass(&format!("{TRIANGLE}{TRIANGLE}"));
    assert!(vertices.contains("found 4") && faces.contains("found 2"), "{vertices} {faces}");
    assert_eq!(pass(TRIANGLE), ["", ""]);
    assert!(matches!(
        ObjReader::open("no/such/file".as_ref(), &CancelToken::default()),
        Err(ObjError::Text(TextError::Io { .. }))
    ));
}
