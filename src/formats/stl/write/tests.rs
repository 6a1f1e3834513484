//! STL files, and solids that are closed.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::path::Path;

use super::*;
use crate::formats::{Header, SinkOptions};

/// A triangle as it stands in a file.
type Record = [Corner; 3];

/// A lattice of vertices, and two triangles in each of its squares that is marked; the rows of `squares` go north.
struct Lattice {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u64; 3]>,
}

fn lattice(squares: &[&str]) -> Lattice {
    let (width, height) = (squares[0].len() as u64, squares.len() as u64);
    let row = width + 1;
    let vertex = |i: u64| {
        let (x, y) = ((i % row) as f64, (i / row) as f64);
        [500_000.25 + 10.0 * x, 5_200_000.5 + 10.0 * y, 100.0 + (x * 3.0 + y * 5.0) % 7.0]
    };
    let marked = |i: u64| squares[(i / width) as usize].as_bytes()[(i % width) as usize] == b'#';
    let square = |i: u64| {
        let corner = i / width * row + i % width;
        [[corner, corner + 1, corner + row + 1], [corner, corner + row + 1, corner + row]]
    };
    Lattice {
        vertices: (0..row * (height + 1)).map(vertex).collect(),
        triangles: (0..width * height).filter(|i| marked(*i)).flat_map(square).collect(),
    }
}

fn written(path: &Path, mesh: &Lattice, base: Option<Base>, batch: usize) -> Result<(), SinkError> {
    let frame = CoordinateFrame { origin: (500_000.0, 5_200_000.0), z_scale: 2.0, ..CoordinateFrame::PLAIN };
    let options = SinkOptions { base, ..SinkOptions::default() };
    let setup = Setup { header: Header { frame, ..Header::default() }, loss: 0.0, options, ..Setup::default() };
    let mut sink = StlSink::new(StagedFile::create(path, false, &[]).expect("staged"), setup);
    let bounds = mesh.vertices.iter().fold(Bounds::EMPTY, |bounds, vertex| bounds.with(*vertex));
    let (vertices, triangles) = (mesh.vertices.len() as u64, mesh.triangles.len() as u64);
    sink.begin(&Contents { vertices, triangles, bounds: Some(bounds), ..Contents::default() })?;
    sink.vertices(&mesh.vertices, &[])?;
    for triangles in mesh.triangles.chunks(batch) {
        let corners: Vec<_> = triangles.iter().map(|t| t.map(|v| mesh.vertices[v as usize])).collect();
        sink.triangles(triangles, &corners)?;
    }
    Box::new(sink).finish()
}

fn bytes(mesh: &Lattice, base: Option<Base>, batch: usize) -> Vec<u8> {
    let folder = crate::testing::folder();
    let path = folder.path().join("tin.stl");
    written(&path, mesh, base, batch).expect("written");
    std::fs::read(&path).expect("a file")
}

fn records(bytes: &[u8]) -> Vec<Record> {
    let count = u32::from_le_bytes(bytes[80..84].try_into().expect("a count"));
    assert_eq!(bytes.len(), 84 + 50 * count as usize);
    let number = |record: &[u8], i: usize| f32::from_le_bytes(record[4 * i..4 * i + 4].try_into().expect("a number"));
    let corner = |record: &[u8], i: usize| [0, 1, 2].map(|axis| number(record, 3 + 3 * i + axis));
    bytes[84..].chunks_exact(50).map(|record| [0, 1, 2].map(|i| corner(record, i))).collect()
}

/// Matches edges as they come, as admesh does: whatever edge waits with the same ends must go the other way. Returns
/// the volume.
fn volume_of_closed(records: &[Record]) -> f64 {
    let mut waiting = HashMap::new();
    let mut volume = 0.0;
    for corners in records {
        for side in 0..3 {
            let [from, to] = [corners[side], corners[(side + 1) % 3]].map(|corner| corner.map(f32::to_bits));
            assert_ne!(from, to, "{corners:?}");
            match waiting.remove(&(from.min(to), from.max(to))) {
                Some(is_upward) => assert_ne!(is_upward, from < to, "twice in one direction: {corners:?}"),
                None => assert!(waiting.insert((from.min(to), from.max(to)), from < to).is_none()),
            }
        }
        let [a, b, c] = corners.map(|corner| corner.map(f64::from));
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        volume += (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0;
    }
    assert!(waiting.is_empty(), "{waiting:?}");
    volume
}

#[test]
fn a_surface_byte_for_byte() {
    let found = bytes(&lattice(&["#"]), None, 1);
    let mut expected = b"terrabite STL; 5 f64: offset x y, scales".to_vec();
    for number in [500_000.0f64, 5_200_000.0, 1.0, 1.0, 2.0] {
        expected.extend(number.to_le_bytes());
    }
    expected.extend([2, 0, 0, 0]);
    let corners = [
        [0.25f32, 0.5, 200.0],
        [10.25, 0.5, 206.0],
        [10.25, 10.5, 202.0],
        [0.25, 0.5, 200.0],
        [10.25, 10.5, 202.0],
        [0.25, 10.5, 210.0],
    ];
    for triangle in corners.chunks(3) {
        let normal = normal([triangle[0], triangle[1], triangle[2]]);
        for number in normal.iter().chain(triangle.as_flattened()) {
            expected.extend(number.to_le_bytes());
        }
        expected.extend([0, 0]);
    }
    assert_eq!(found, expected);
}

#[test]
fn normals() {
    let flat = [[0.0, 0.0, 5.0], [2.0, 0.0, 5.0], [0.0, 3.0, 5.0]];
    assert_eq!(normal(flat).map(f32::to_bits), [0.0, 0.0, 1.0f32].map(f32::to_bits));
    assert_eq!(normal([[0.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]]), [1.0, 0.0, 0.0]);
    for none in [[[1.0; 3]; 3], [[0.0; 3], [1.0; 3], [2.0; 3]], [[0.0; 3], [f32::MAX; 3], [f32::INFINITY; 3]]] {
        assert_eq!(normal(none).map(f32::to_bits), [0; 3]);
    }
    let tiny = [[0.0; 3], [1e-44, 0.0, 0.0], [0.0, 1e-44, 0.0]];
    assert_eq!(normal(tiny), [0.0, 0.0, 1.0]);
}

#[test]
fn solids_are_closed_whatever_the_rim() {
    for (squares, rim) in [
        (&["#"][..], 4),
        // A hole with an island, and another part.
        (&["#######.##", "#.....#.##", "#.###.#...", "#.###.#.##", "#.....#.#.", "#######.##"], 0),
        // Parts that touch in one vertex; in two; holes that touch the outer rim and each other.
        (&["#.", ".#"], 8),
        (&[".#", "#."], 8),
        (&[".#.", "#.#", ".#."], 16),
        (&["#####", "#.#.#", "##.##", "#.#.#", "#####"], 20 + 20),
        (&["#.#.#", ".#.#.", "#.#.#"], 32),
    ] {
        let mesh = lattice(squares);
        let surface = records(&bytes(&mesh, None, 7));
        for (base, floor) in [(Base::Depth(2.5), 195.0), (Base::Height(50.0), 100.0)] {
            let solid = bytes(&mesh, Some(base), 7);
            let found = records(&solid);
            let (both, walls) = found.split_at(2 * surface.len());
            assert!(both.iter().step_by(2).eq(&surface));
            let floors = both.iter().skip(1).step_by(2).flatten();
            assert!(floors.map(|corner| f64::from(corner[2])).all(|z| z == floor));
            assert!(rim == 0 || walls.len() == 2 * rim, "{squares:?}: {}", walls.len());
            let text = format!("terrabite STL, {} on base; 5 f64", surface.len());
            assert!(solid.starts_with(text.as_bytes()));
            let above: f64 = surface.iter().map(|[a, b, c]| 50.0 * (f64::from(a[2] + b[2] + c[2]) / 3.0 - floor)).sum();
            let volume = volume_of_closed(&found);
            assert!((volume - above).abs() < 1e-6 * above, "{squares:?}: {volume}, {above}");
            // The same bytes, however triangles come.
            for batch in [1, 1000] {
                assert_eq!(bytes(&mesh, Some(base), batch), solid);
            }
        }
    }
}

/// More edges than are kept in memory.
#[test]
fn long_rims() {
    let rows = ["#.".repeat(50), ".#".repeat(50)];
    let squares: Vec<&str> = (0..60).map(|row| rows[row % 2].as_str()).collect();
    let mesh = lattice(&squares);
    let solid = bytes(&mesh, Some(Base::Depth(2.5)), 1);
    volume_of_closed(&records(&solid));
    assert!(bytes(&mesh, Some(Base::Depth(2.5)), 10_000) == solid);
}

#[test]
fn of_a_solid_the_surface_is_read() {
    let mesh = lattice(&["#####", "#.#.#", "##.##", "#.#.#", "#####"]);
    let folder = crate::testing::folder();
    let read = |name: &str, base: Option<Base>| {
        let path = folder.path().join(name);
        written(&path, &mesh, base, 7).expect("written");
        let mut reader = crate::formats::open(&path, None, &Default::default()).expect("a mesh");
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        let mut take_vertex = |_, vertex: [f64; 3], _: &[f64]| {
            vertices.push(vertex);
            ControlFlow::Continue(())
        };
        reader.vertices(&[], &mut take_vertex).expect("vertices");
        let mut take_face = |_, face| {
            faces.push(face);
            ControlFlow::Continue(())
        };
        reader.faces(&mut take_face).expect("faces");
        (reader.header().clone(), vertices, faces)
    };
    assert_eq!(read("solid.stl", Some(Base::Depth(1.0))), read("tin.stl", None));
}

#[test]
fn floors_are_below_the_surface() {
    let mesh = lattice(&["##"]);
    let folder = crate::testing::folder();
    let path = folder.path().join("tin.stl");
    for base in [Base::Height(100.0), Base::Height(101.5), Base::Height(f64::NAN), Base::Height(f64::NEG_INFINITY)] {
        let refused = written(&path, &mesh, Some(base), 1).expect_err("refused");
        let said = refused.to_string();
        let expected = "expected a floor below the lowest vertex, which is at 100, found one at ";
        assert!(matches!(refused, SinkError::Unfit { .. }) && said.contains(expected), "{said}");
    }
    for base in [Base::Depth(0.0), Base::Depth(-1.0), Base::Depth(f64::NAN), Base::Depth(1e-9)] {
        assert!(matches!(written(&path, &mesh, Some(base), 1), Err(SinkError::Unfit { .. })), "{base:?}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
    let nothing = Lattice { vertices: Vec::new(), triangles: Vec::new() };
    assert!(records(&bytes(&nothing, Some(Base::Height(3.0)), 1)).is_empty());
}

#[test]
fn solids_have_less_room() {
    let folder = crate::testing::folder();
    let staged = StagedFile::create(&folder.path().join("tin.stl"), false, &[]).expect("staged");
    let options = SinkOptions { base: Some(Base::Height(0.0)), ..SinkOptions::default() };
    let mut sink = StlSink::new(staged, Setup { options, ..Setup::default() });
    let refused = sink.begin(&Contents { vertices: 3, triangles: 1 << 31, ..Contents::default() });
    assert!(matches!(refused, Err(SinkError::TooLarge { found: 0x1_0000_0000, .. })), "{refused:?}");
}
