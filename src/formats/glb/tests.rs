//! What is written, as bytes and as it is read again; compressed files against plain ones.

use std::path::{Path, PathBuf};

use proptest::prelude::*;
use serde_json::{Value, json};

use super::*;
use crate::base::CoordinateFrame;
use crate::base::channels::{Channel, Number};
use crate::base::staged::StagedFile;
use crate::formats::{
    Bounds, Compression, Contents, Header, ReadError, ReadOptions, Setup, Sink, SinkError, SinkOptions,
};
use crate::testing;

/// A mesh to be written.
#[derive(Debug, Clone, Default)]
struct Given {
    header: Header,
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u64; 3]>,
    attributes: Vec<(Channel, Vec<f64>)>,
    has_normals: bool,
}

const PACKED: SinkOptions = SinkOptions {
    ascii: false,
    base: None,
    compression: Some(Compression::Meshopt),
    ogr_driver: None,
    ogr_geometry: None,
};

fn channel(name: &str, number: Number) -> Channel {
    Channel { name: name.to_string(), number }
}

fn write(path: &Path, given: &Given, options: SinkOptions, batch: usize) -> Result<(), SinkError> {
    let staged = StagedFile::create(path, true, &[])?;
    let setup = Setup { header: given.header.clone(), loss: f64::INFINITY, options, ..Setup::default() };
    let mut sink: Box<dyn Sink> = Box::new(GlbSink::new(staged, setup));
    let attributes: Vec<Channel> = given.attributes.iter().map(|(channel, _)| channel.clone()).collect();
    let bounds = given.vertices.iter().fold(Bounds::EMPTY, |bounds, vertex| bounds.with(*vertex));
    sink.begin(&Contents {
        vertices: given.vertices.len() as u64,
        triangles: given.triangles.len() as u64,
        attributes: &attributes,
        has_normals: given.has_normals,
        bounds: (sink.needs().bounds && !given.vertices.is_empty()).then_some(bounds),
        ..Contents::default()
    })?;
    for (first, vertices) in (0..).step_by(batch).zip(given.vertices.chunks(batch)) {
        let values: Vec<&[f64]> = given.attributes.iter().map(|(_, v)| &v[first..first + vertices.len()]).collect();
        sink.vertices(vertices, &values)?;
    }
    given.triangles.chunks(batch).try_for_each(|triangles| sink.triangles(triangles, &[]))?;
    sink.finish()
}

fn file(given: &Given, options: SinkOptions) -> (tempfile::TempDir, PathBuf) {
    let folder = testing::folder();
    let path = folder.path().join("tin.glb");
    write(&path, given, options, 1000).expect("written");
    (folder, path)
}

/// The document and the BIN chunk; lengths and padding are as they should be.
fn chunks(path: &Path) -> (Value, Vec<u8>) {
    let bytes = std::fs::read(path).expect("a file");
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four")) as usize;
    assert_eq!((&bytes[..4], word(4), word(8), &bytes[16..20]), (&b"glTF"[..], 2, bytes.len(), &b"JSON"[..]));
    let json_end = 20 + word(12);
    let document = serde_json::from_slice(&bytes[20..json_end]).expect("JSON");
    if json_end == bytes.len() {
        return (document, Vec::new());
    }
    assert_eq!((json_end % 4, &bytes[json_end + 4..json_end + 8]), (0, &b"BIN\0"[..]));
    assert_eq!((json_end + 8 + word(json_end), bytes.len() % 4), (bytes.len(), 0));
    (document, bytes[json_end + 8..].to_vec())
}

/// Vertices with the values of their attributes, as bits, and triangles.
type Read = (Vec<Channel>, Vec<Vec<u64>>, Vec<[u64; 3]>);

fn read(path: &Path) -> Read {
    let mut reader = crate::formats::open(path, None, &ReadOptions::default()).expect("opens");
    let channels = reader.attributes().to_vec();
    let names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    reader
        .for_each_vertex_with(&names, |index, place, values| {
            assert_eq!(index, vertices.len() as u64);
            vertices.push(place.iter().chain(values).map(|v| v.to_bits()).collect());
            Ok::<(), ReadError>(())
        })
        .expect("vertices");
    reader
        .for_each_face(|_, face| {
            triangles.push(face);
            Ok::<(), ReadError>(())
        })
        .expect("faces");
    assert_eq!((vertices.len() as u64, triangles.len() as u64), (reader.vertex_count(), reader.face_count()));
    (channels, vertices, triangles)
}

/// Triangles as their corners, each from the least corner on, in order.
fn shapes((_, vertices, triangles): &Read) -> Vec<[Vec<u64>; 3]> {
    let shape = |triangle: &[u64; 3]| {
        let corners = triangle.map(|vertex| vertices[vertex as usize].clone());
        (0..3).map(|first| std::array::from_fn(|i| corners[(first + i) % 3].clone())).min().expect("three")
    };
    let mut shapes: Vec<[Vec<u64>; 3]> = triangles.iter().map(shape).collect();
    shapes.sort_unstable();
    shapes
}

fn triangle() -> Given {
    let frame = CoordinateFrame { origin: (500.0, 600.0), xy_scale: (2.0, 4.0), ..CoordinateFrame::PLAIN };
    Given {
        header: Header { made_by: Some("terrabite 1".to_string()), frame, ..Header::default() },
        vertices: vec![[500.0, 600.0, 7.0], [501.5, 600.0, -0.0], [500.0, 602.0, 0.25]],
        triangles: vec![[0, 1, 2]],
        ..Given::default()
    }
}

/// A grid of vertices of this many columns and rows, with a colour, a band and normals.
fn grid(columns: u64, rows: u64) -> Given {
    let at =
        |i: u64| [3e5 + 30.0 * (i % columns) as f64, 5e6 - 30.0 * (i / columns) as f64, 700.1 + (i * i % 911) as f64];
    let square = |i: u64| [[i, i + columns, i + columns + 1], [i, i + columns + 1, i + 1]];
    let inner = (0..columns * (rows - 1)).filter(|i| i % columns != columns - 1);
    let count = columns * rows;
    let byte = |factor: u64| (0..count).map(|i| (i * factor % 256) as f64).collect::<Vec<f64>>();
    let constant = |value: f64| vec![value; count as usize];
    let frame = CoordinateFrame { origin: (3e5, 5e6), ..CoordinateFrame::PLAIN };
    Given {
        header: Header { frame, ..Header::default() },
        vertices: (0..count).map(at).collect(),
        triangles: inner.flat_map(square).collect(),
        attributes: vec![
            (channel("green", Number::U8), byte(3)),
            (channel("band", Number::F32), (0..count).map(|i| i as f64 / 8.0).collect()),
            (channel("red", Number::U8), byte(5)),
            (channel("mask", Number::U8), byte(7)),
            (channel("blue", Number::U8), byte(11)),
            (channel("nx", Number::F32), constant(0.0)),
            (channel("ny", Number::F32), constant(f64::from(0.6f32))),
            (channel("nz", Number::F32), constant(f64::from(0.8f32))),
        ],
        has_normals: true,
    }
}

#[test]
fn a_plain_mesh_byte_for_byte() {
    let (_folder, path) = file(&triangle(), SinkOptions::default());
    let (document, bin) = chunks(&path);
    let facts = ["made by terrabite 1", "xy_scale 2 4", "offset 500 600", "precision float"];
    let expected = json!({
        "asset": {"version": "2.0", "generator": "terrabite 1", "extras": {"terrabite": {
            "offset": [500.0, 600.0], "xy_scale": [2.0, 4.0], "z_scale": 1.0, "facts": facts,
        }}},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [1000.0, 0.0, -2400.0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 1}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0.0, 0.0, -8.0], "max": [3.0, 7.0, 0.0]},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 36, "byteStride": 12, "target": 34962},
            {"buffer": 0, "byteOffset": 36, "byteLength": 6, "target": 34963},
        ],
        "buffers": [{"byteLength": 42}],
    });
    // Numbers with and without a sign of zero are the same in JSON.
    assert_eq!(document.to_string().replace("-0.0", "0.0"), expected.to_string());
    let positions: [f32; 9] = [0.0, 7.0, -0.0, 3.0, -0.0, -0.0, 0.0, 0.25, -8.0];
    let mut expected: Vec<u8> = positions.iter().flat_map(|v| v.to_le_bytes()).collect();
    expected.extend([0, 0, 1, 0, 2, 0, 0, 0]);
    assert_eq!(bin, expected);
}

#[test]
fn vertices_are_interleaved() {
    let (_folder, path) = file(&grid(2, 2), SinkOptions::default());
    let (document, bin) = chunks(&path);
    let attributes = json!({"POSITION": 0, "NORMAL": 1, "_band": 2, "COLOR_0": 3, "_mask": 4});
    assert_eq!(document["meshes"][0]["primitives"][0]["attributes"], attributes);
    assert_eq!(document["bufferViews"][0]["byteStride"], 36);
    let colour = json!({"bufferView": 0, "byteOffset": 28, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC4"});
    assert_eq!(document["accessors"][3], colour);
    // The second vertex: its normal, y up, its band, its colour, its mask.
    let normal: Vec<u8> = [0.0f32, 0.8, -0.6, 0.125].iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(bin[48..72], [normal, vec![5, 3, 11, 255, 7, 0, 0, 0]].concat());
}

#[test]
fn attributes_come_back_in_their_order() {
    let given = grid(5, 4);
    for options in [SinkOptions::default(), PACKED] {
        let (_folder, path) = file(&given, options);
        let (channels, vertices, _) = read(&path);
        let expected: Vec<Channel> = given.attributes.iter().map(|(channel, _)| channel.clone()).collect();
        assert_eq!(channels, expected);
        assert_eq!(vertices.len(), 20);
        if options == SinkOptions::default() {
            for (i, vertex) in vertices.iter().enumerate() {
                let expected: Vec<u64> = given.attributes.iter().map(|(_, values)| values[i].to_bits()).collect();
                assert_eq!(vertex[3..], expected);
            }
        }
    }
}

#[test]
fn numbers_of_vertices_take_two_bytes_where_they_can() {
    for (count, component) in [(65_535u64, 5123), (65_536, 5125)] {
        let given = Given {
            vertices: (0..count).map(|i| [i as f64, 0.0, 0.0]).collect(),
            triangles: vec![[0, 1, count - 1]],
            ..Given::default()
        };
        let (_folder, path) = file(&given, SinkOptions::default());
        assert_eq!(chunks(&path).0["accessors"][1]["componentType"], component);
        assert_eq!(read(&path).2, given.triangles);
    }
}

#[test]
fn a_mesh_without_triangles_is_a_node_without_a_mesh() {
    for vertices in [Vec::new(), triangle().vertices] {
        for options in [SinkOptions::default(), PACKED] {
            let given = Given { vertices: vertices.clone(), triangles: Vec::new(), ..triangle() };
            let (_folder, path) = file(&given, options);
            let (document, bin) = chunks(&path);
            assert_eq!((&document["nodes"], bin.len()), (&json!([{"translation": [1000.0, 0.0, -2400.0]}]), 0));
            assert!(document.get("buffers").is_none() && document.get("extensionsUsed").is_none(), "{document}");
            let (channels, vertices, triangles) = read(&path);
            assert_eq!((channels.len(), vertices.len(), triangles.len()), (0, 0, 0));
        }
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let folder = testing::folder();
    let path = folder.path().join("tin.glb");
    for options in [SinkOptions::default(), PACKED] {
        let refused = |given: &Given| write(&path, given, options, 10).expect_err("refused");
        let with = |attributes| Given { attributes, ..triangle() };
        let double = with(vec![(channel("band", Number::F64), vec![0.0; 3])]);
        assert!(matches!(refused(&double), SinkError::DoubleAttribute { name, .. } if name == "band"));
        let many =
            |count: usize| with((0..count).map(|i| (channel(&format!("b{i}"), Number::F32), vec![0.5; 3])).collect());
        assert!(matches!(refused(&many(61)), SinkError::Unfit { .. }));
        write(&path, &many(60), options, 10).expect("written");
        assert_eq!(read(&path).0.len(), 60);
        let mut far = triangle();
        far.vertices[1][0] = 1e300;
        let error = refused(&far);
        assert!(matches!(&error, SinkError::Unfit { expected, .. } if expected.contains("finite")), "{error}");
    }
    let setup = Setup { loss: 0.0, ..Setup::default() };
    let mut sink = GlbSink::new(StagedFile::create(&path, true, &[]).expect("staged"), setup);
    let contents = Contents { vertices: 1 << 27, triangles: 1 << 28, ..Contents::default() };
    let error = sink.begin(&contents).expect_err("refused").to_string();
    assert!(error.contains("at most 4294967295 bytes") && error.contains("4831838208"), "{error}");
}

#[test]
fn compressed_files_hold_the_same_triangles() {
    let given = grid(300, 290);
    let (_folder, plain) = file(&given, SinkOptions::default());
    let (folder, packed) = file(&given, PACKED);
    let (expected, found) = (read(&plain), read(&packed));
    assert_eq!((&found.0, found.1.len()), (&expected.0, expected.1.len()));
    assert!(shapes(&found) == shapes(&expected));
    let header = |path| crate::formats::open(path, None, &ReadOptions::default()).expect("opens").header().clone();
    assert_eq!(header(&packed), header(&plain));

    let (document, bin) = chunks(&packed);
    assert_eq!(document["extensionsRequired"], json!(["EXT_meshopt_compression"]));
    assert_eq!(document["buffers"][1]["extensions"]["EXT_meshopt_compression"]["fallback"], true);
    assert_eq!(document["meshes"][0]["primitives"].as_array().map(Vec::len), Some(2));
    let views = document["bufferViews"].as_array().expect("views");
    for (i, view) in views.iter().enumerate() {
        let packed = &view["extensions"]["EXT_meshopt_compression"];
        let number = |value: &Value| value.as_u64().unwrap_or(0);
        assert_eq!(number(&packed["count"]) * number(&packed["byteStride"]), number(&view["byteLength"]));
        // The version of each codec that the extension has: 0 of vertices, 1 of triangles.
        let first = bin[number(&packed["byteOffset"]) as usize];
        assert_eq!((first, view["buffer"].as_u64()), (if i % 2 == 0 { 0xa0 } else { 0xe1 }, Some(1)));
        assert!(i % 2 == 1 || number(&packed["count"]) <= 65_535);
    }
    assert!(bin.len() < 2_000_000, "{} bytes", bin.len());

    let bytes = std::fs::read(&packed).expect("a file");
    let again = folder.path().join("again.glb");
    for batch in [1, 70_000] {
        write(&again, &given, PACKED, batch).expect("written");
        assert!(std::fs::read(&again).expect("a file") == bytes, "batches of {batch}");
    }
}

proptest! {
    #![proptest_config(testing::cases(64, 1000))]

    /// Whatever triangles are: twice the same, or with a corner twice.
    #[test]
    fn any_triangles_are_compressed_without_loss(
        heights in proptest::collection::vec(-1e4f64..1e4, 3..60),
        corners in proptest::collection::vec(any::<[proptest::sample::Index; 3]>(), 1..100),
    ) {
        let given = Given {
            vertices: heights.iter().zip(0..).map(|(z, i)| [f64::from(i), f64::from(i % 7), f64::from(*z as f32)]).collect(),
            triangles: corners.iter().map(|t| t.map(|corner| corner.index(heights.len()) as u64)).collect(),
            ..Given::default()
        };
        let (_folder, plain) = file(&given, SinkOptions::default());
        let (_folder_2, packed) = file(&given, PACKED);
        prop_assert_eq!(shapes(&read(&packed)), shapes(&read(&plain)));
    }

    #[test]
    fn damage_of_compressed_files_is_no_panic(damage in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 1..5)) {
        let (_folder, path) = file(&grid(9, 9), PACKED);
        let mut bytes = std::fs::read(&path).expect("a file");
        for (at, byte) in damage {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        std::fs::write(&path, bytes).expect("damaged");
        let Ok(mut reader) = crate::formats::open(&path, None, &ReadOptions::default()) else { return Ok(()) };
        let count = reader.vertex_count();
        let _ = reader.for_each_vertex(|_, _| Ok::<(), ReadError>(()));
        let _ = reader.for_each_face(|_, face| {
            assert!(face.iter().all(|vertex| *vertex < count));
            Ok::<(), ReadError>(())
        });
    }
}

#[test]
fn torn_compressed_files_are_errors() {
    let (_folder, path) = file(&grid(9, 9), PACKED);
    let whole = std::fs::read(&path).expect("a file");
    for cut in (0..whole.len()).step_by(17).chain([whole.len() - 1]) {
        std::fs::write(&path, &whole[..cut]).expect("cut");
        assert!(crate::formats::open(&path, None, &ReadOptions::default()).is_err(), "{cut}");
    }
}
