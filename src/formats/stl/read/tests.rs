//! Reading STL files of any origin, and refusing damaged ones.

use super::*;
use crate::base::CoordinateFrame;
use crate::formats::{MeshReader, ReadError, ReadOptions};
use crate::testing::{Mesh, file, mesh, without_name};

fn opened(path: &std::path::Path) -> Result<StlReader, ReadError> {
    StlReader::open(path, &ReadOptions::default())
}

/// The mesh in these bytes, and the frame; or what is wrong.
fn read(bytes: &[u8]) -> Result<(Mesh, CoordinateFrame), String> {
    let file = file(bytes);
    let read = || {
        let mut reader = opened(file.path())?;
        Ok((mesh(&mut reader)?, reader.header().frame))
    };
    read().map_err(|error: ReadError| without_name(file.path(), &error.to_string()))
}

type Corner = [f32; 3];

fn binary(header: &[u8], triangles: &[[Corner; 3]]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, 0);
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([7; 12]);
        triangle.as_flattened().iter().for_each(|number| bytes.extend(number.to_le_bytes()));
        bytes.extend([1, 2]);
    }
    bytes
}

const SQUARE: [[Corner; 3]; 2] =
    [[[0.0, 0.0, 1.5], [1.0, 0.0, -2.0], [0.0, 1.0, 7.0]], [[1.0, 0.0, -2.0], [1.0, 1.0, 0.25], [-0.0, 1.0, 7.0]]];

fn square() -> Mesh {
    let vertices = vec![[0.0, 0.0, 1.5], [1.0, 0.0, -2.0], [0.0, 1.0, 7.0], [1.0, 1.0, 0.25]];
    (vertices, vec![[0, 1, 2], [1, 3, 2]])
}

#[test]
fn what_other_programs_write() {
    for header in [&b"Exported from Blender"[..], b"solid is what binary files should not begin with", b"", &[0xff; 80]]
    {
        let (found, frame) = read(&binary(header, &SQUARE)).unwrap();
        assert_eq!((found, frame), (square(), CoordinateFrame { single: true, ..CoordinateFrame::PLAIN }));
    }
    assert_eq!(read(&binary(b"", &[])).unwrap().0, (vec![], vec![]));
}

const TEXT: &str = "solid terrain of stone\n  facet normal 0 0 1\n    outer loop\n      vertex 0.0e+00 0 1.5\n      vertex 1 0 -2\n\
                    \x20     vertex 0 1 7.\n    endloop\n  endfacet\nendsolid terrain of stone\n\nSOLID\nFACET NORMAL 0 0 1\nOUTER LOOP\n\
                    VERTEX 1 0 -2\nVERTEX 1 1 .25\nVERTEX -0 +1 7\nENDLOOP\nENDFACET\nENDSOLID";

#[test]
fn text() {
    assert_eq!(read(TEXT.as_bytes()), Ok((square(), CoordinateFrame::PLAIN)));
    assert_eq!(read(TEXT.replace('\n', "\r\n\t").as_bytes()), Ok((square(), CoordinateFrame::PLAIN)));
    assert_eq!(read(b"solid\nendsolid").unwrap().0, (vec![], vec![]));
    for (from, to, said) in [
        ("vertex 1 0 -2", "vertex 1 0", "line 5: expected vertex and three numbers, found \"vertex 1 0\""),
        ("vertex 1 0 -2", "vertex 1 0 x", "line 5: expected vertex and three numbers"),
        ("vertex 1 0 -2", "vertex 1 0 2 3", "line 5: expected vertex and three numbers"),
        ("    endloop", "vertex 0 0 0", "line 7: expected endloop after three vertices"),
        ("    outer loop\n", "", "line 3: expected outer loop"),
        ("  endfacet\n", "", "line 8: expected endfacet, found \"endsolid terrain of stone\""),
        ("\nSOLID", "\nfacet", "line 11: expected solid and a name, found \"facet\""),
        ("facet normal 0 0 1", "colour 1", "line 2: expected facet or endsolid"),
        ("\nENDSOLID", "", "expected facet or endsolid, found the end of the file after line 18"),
        (
            "ENDLOOP\nENDFACET\nENDSOLID",
            "",
            "expected endloop after three vertices, found the end of the file after line 16",
        ),
    ] {
        let error = read(TEXT.replace(from, to).as_bytes()).unwrap_err();
        assert!(error.contains(said), "{to}: {error}");
    }
    let endless = [b"solid ", vec![b'x'; 1 << 20].as_slice()].concat();
    assert_eq!(read(&endless).unwrap_err(), "line 1: expected at most 65536 bytes, found more");
}

#[test]
fn lengths_must_be_right() {
    assert_eq!(read(b"").unwrap_err(), "expected a header of 84 bytes, found 0 bytes");
    let whole = binary(b"", &SQUARE);
    for length in [83, 84, 100, whole.len() - 1] {
        assert!(read(&whole[..length]).is_err(), "{length}");
    }
    let expected = "expected 184 bytes for 2 triangles, as many as bytes 80 to 83 say, found 185";
    assert_eq!(read(&[&whole[..], b"x"].concat()).unwrap_err(), expected);
    let mut huge = whole;
    huge[80..84].fill(0xff);
    assert!(read(&huge).unwrap_err().contains("for 4294967295 triangles"));
}

fn header(text: &str, numbers: [f64; 5]) -> Vec<u8> {
    let mut bytes = format!("{text:40}").into_bytes();
    numbers.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    bytes
}

const SURFACE: &str = "terrabite STL; 5 f64: offset x y, scales";

#[test]
fn headers_of_ours() {
    let frame = CoordinateFrame { origin: (-1e7, 0.1), xy_scale: (111e3, 1e-3), z_scale: 0.3048, single: true };
    let numbers = [-1e7, 0.1, 111e3, 1e-3, 0.3048];
    assert_eq!(read(&binary(&header(SURFACE, numbers), &SQUARE)), Ok((square(), frame)));
    for (at, value, said) in [
        (0, f64::NAN, "byte 40: expected an offset, which is finite, found NaN"),
        (1, f64::INFINITY, "byte 48: expected an offset"),
        (2, 0.0, "byte 56: expected a scale, which is above 0, found 0"),
        (4, -1.0, "byte 72: expected a scale"),
    ] {
        let mut numbers = numbers;
        numbers[at] = value;
        let error = read(&binary(&header(SURFACE, numbers), &SQUARE)).unwrap_err();
        assert!(error.contains(said), "{error}");
    }
    for text in ["terrabite STL", "terrabite STL, x on base; 5 f64", "terrabite STL, -1 on base; 5 f64"] {
        let error = read(&binary(&header(text, numbers), &SQUARE)).unwrap_err();
        assert_eq!(error, format!("byte 0: expected a header of terrabite's, found {text}"));
    }
    for count in [2, 0, u64::MAX] {
        let text = format!("terrabite STL, {count} on base; 5 f64");
        let text = &text[..text.len().min(40)];
        assert!(read(&binary(&header(text, numbers), &SQUARE)).is_err(), "{count}");
    }
}

/// A triangle with floor and walls.
fn solid() -> Vec<[Corner; 3]> {
    let top @ [a, b, c] = SQUARE[0];
    let [d, e, f] = top.map(|[x, y, _]| [x, y, -5.0]);
    let wall = |from, to, under_from, under_to| [[to, from, under_from], [to, under_from, under_to]];
    let walls = [wall(a, b, d, e), wall(b, c, e, f), wall(c, a, f, d)];
    [&[top, [d, f, e]], walls.as_flattened()].concat()
}

#[test]
fn solids_of_ours_are_closed() {
    let read = |triangles: &[[Corner; 3]]| {
        read(&binary(&header("terrabite STL, 1 on base; 5 f64", [0.0, 0.0, 1.0, 1.0, 1.0]), triangles))
    };
    let whole = solid();
    assert_eq!(read(&whole).unwrap().0, (square().0[..3].to_vec(), vec![[0, 1, 2]]));
    for missing in [2, 5] {
        let mut torn = whole.clone();
        torn.remove(missing);
        torn.remove(missing);
        let error = read(&torn).unwrap_err();
        assert!(
            error.contains("expected a closed solid, found the edge from [") && error.contains("triangle "),
            "{error}"
        );
    }
    let changed = |triangle: usize, corner: usize, axis: usize, value: f32| {
        let mut changed = whole.clone();
        changed[triangle][corner][axis] = value;
        read(&changed).unwrap_err()
    };
    assert!(
        changed(1, 1, 2, -4.0).contains("byte 134, triangle 1: expected the triangle before it, turned over and at -5")
    );
    assert!(changed(0, 0, 2, -5.0).contains("byte 134, triangle 1: expected a floor below the surface"));
    assert!(changed(0, 0, 2, f32::NAN).contains("expected a floor below the surface"));
    assert!(changed(4, 1, 0, 0.5).contains("byte 284, triangle 4: expected a wall, which is upright, found [[0.0"));
    assert!(changed(3, 2, 2, -6.0).contains("expected a closed solid"));
    let mut turned = whole.clone();
    turned[4].swap(0, 1);
    assert!(read(&turned).unwrap_err().contains("expected a closed solid"));
    // The same file without the header is a mesh of eight triangles.
    assert_eq!(super::tests::read(&binary(b"", &whole)).unwrap().0.1.len(), 8);
}

#[test]
fn a_file_that_changes_between_passes_is_an_error() {
    for bytes in [binary(b"", &SQUARE), TEXT.as_bytes().to_vec()] {
        let file = file(&bytes);
        let mut reader = opened(file.path()).unwrap();
        assert!(mesh(&mut reader).is_ok());
        let mut other = bytes.clone();
        let at = if bytes[0] == 0 { bytes.len() - 10 } else { TEXT.find("1.5").unwrap() };
        other[at] += 1;
        std::fs::write(file.path(), &other).unwrap();
        let said = mesh(&mut reader).unwrap_err().to_string();
        assert!(said.contains("expected the 2 triangles that it had when it was opened, found others"), "{said}");
        std::fs::write(file.path(), &bytes[..bytes.len() - 1]).unwrap();
        let reader: &mut dyn MeshReader = &mut reader;
        assert!(reader.for_each_face(|_, _| Ok::<(), ReadError>(())).is_err());
        assert!(reader.for_each_vertex(|_, _| Ok::<(), ReadError>(())).is_err());
    }
    assert!(matches!(opened("no/such/file".as_ref()), Err(ReadError::Io { .. })));
}

#[test]
fn recognised() {
    for (beginning, expected) in [
        (&b"terrabite STL; 5"[..], Recognised::Surely),
        (b"solid x", Recognised::Perhaps),
        (b" solid\r\n", Recognised::Perhaps),
        (b"solidarity", Recognised::No),
        (b"terrabite", Recognised::No),
        (b"", Recognised::No),
    ] {
        assert_eq!(recognise(beginning), expected);
    }
}
