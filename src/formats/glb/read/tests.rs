//! GLB files of other programs, and damaged ones.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::{GlbError, GlbReader};
use crate::base::CoordinateFrame;
use crate::base::channels::{Channel, Number};
use crate::formats::{MeshReader, ReadError, ReadOptions};

/// A file of two chunks.
fn glb(document: &Value, bin: &[u8]) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bin = bin.to_vec();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let word = |number: usize| (number as u32).to_le_bytes();
    let mut bytes = [b"glTF".as_slice(), &word(2), &word(28 + json.len() + bin.len())].concat();
    bytes.extend([&word(json.len()), b"JSON".as_slice(), &json].concat());
    bytes.extend([&word(bin.len()), b"BIN\0".as_slice(), &bin].concat());
    bytes
}

fn file(bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("tin.glb");
    std::fs::write(&path, bytes).expect("written");
    (folder, path)
}

/// What a reader hands on: vertices with their attributes, and faces.
type Read = (Vec<[f64; 3]>, Vec<Vec<f64>>, Vec<[u64; 3]>);

fn read_with(reader: &mut dyn MeshReader) -> Result<Read, ReadError> {
    let channels = reader.attributes().to_vec();
    let names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
    let (mut vertices, mut values, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    reader.for_each_face(|_, face| {
        faces.push(face);
        Ok::<(), ReadError>(())
    })?;
    reader.for_each_vertex_with(&names, |_, vertex, found| {
        vertices.push(vertex);
        values.push(found.to_vec());
        Ok::<(), ReadError>(())
    })?;
    assert_eq!((vertices.len() as u64, faces.len() as u64), (reader.vertex_count(), reader.face_count()));
    Ok((vertices, values, faces))
}

fn opened(bytes: &[u8]) -> Result<GlbReader, GlbError> {
    let (_folder, path) = file(bytes);
    GlbReader::open(&path, &ReadOptions::default())
}

fn read(bytes: &[u8]) -> Result<Read, ReadError> {
    read_with(&mut opened(bytes)?)
}

fn failure(bytes: &[u8]) -> String {
    read(bytes).expect_err("refused").to_string()
}

/// Two triangles of four vertices, not interleaved: positions, then 8-bit indices.
const POSITIONS: [[f32; 3]; 4] = [[0.0, 5.0, 0.0], [1.0, 6.0, 0.0], [1.0, 7.0, -1.0], [0.0, 8.0, -1.0]];

fn bin() -> Vec<u8> {
    let positions = POSITIONS.iter().flatten().flat_map(|v| v.to_le_bytes());
    positions.chain([0, 1, 2, 0, 2, 3]).collect()
}

fn square() -> Value {
    json!({
        "asset": {"version": "2.0", "generator": "by hand"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 6},
        ],
        "buffers": [{"byteLength": 54}],
    })
}

/// The square's document with one value in another's place.
fn with(pointer: &str, value: Value) -> Vec<u8> {
    let mut document = square();
    let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
    let parent = document.pointer_mut(parent).expect("a place in the document");
    match parent {
        Value::Array(list) => list[key.parse::<usize>().expect("a number")] = value,
        object => object[key] = value,
    }
    glb(&document, &bin())
}

const VERTICES: [[f64; 3]; 4] = [[0.0, 0.0, 5.0], [1.0, 0.0, 6.0], [1.0, 1.0, 7.0], [0.0, 1.0, 8.0]];
const FACES: [[u64; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

#[test]
fn z_is_up() {
    let mut reader = opened(&glb(&square(), &bin())).expect("opens");
    let (vertices, _, faces) = read_with(&mut reader).expect("a mesh");
    assert_eq!((vertices.as_slice(), faces.as_slice()), (&VERTICES[..], &FACES[..]));
    let frame = CoordinateFrame { single: true, ..CoordinateFrame::PLAIN };
    assert_eq!((reader.header().frame, reader.header().made_by.as_deref()), (frame, Some("by hand")));
}

#[test]
fn the_way_of_all_nodes_is_the_origin() {
    let mut reader = opened(&with("/nodes/0/translation", json!([500_000.12, 0, -5_200_000.77]))).expect("opens");
    assert_eq!(reader.header().frame.origin, (500_000.12, 5_200_000.77));
    assert_eq!(read_with(&mut reader).expect("a mesh").0, VERTICES);
    // A frame has no origin of heights.
    let mut reader = opened(&with("/nodes/0/translation", json!([10, 100, -20]))).expect("opens");
    assert_eq!(reader.header().frame, CoordinateFrame::PLAIN);
    let moved = VERTICES.map(|[x, y, z]| [x + 10.0, y + 20.0, z + 100.0]);
    assert_eq!(read_with(&mut reader).expect("a mesh").0, moved);
}

#[test]
fn nodes_transform_in_doubles_and_shared_places_are_joined() {
    let mut document = square();
    document["nodes"] = json!([
        {"children": [1, 2], "translation": [5e6, 0, 0]},
        {"mesh": 0},
        {"mesh": 0, "matrix": [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]},
    ]);
    let (vertices, _, faces) = read(&glb(&document, &bin())).expect("a mesh");
    let right = VERTICES.map(|[x, y, z]| [5e6 + x, y, z]);
    let left = [[5e6 - 1.0, 0.0, 6.0], [5e6 - 1.0, 1.0, 7.0]];
    assert_eq!(vertices, [&right[..], &left].concat());
    // The mirrored triangles go round the other way.
    assert_eq!(faces, [[0, 1, 2], [0, 2, 3], [0, 5, 4], [0, 3, 5]]);
}

#[test]
fn triangles_without_indices_share_vertices() {
    let corners = [0, 1, 2, 0, 2, 3].map(|i| POSITIONS[i]);
    let bin: Vec<u8> = corners.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    let mut document = square();
    document["meshes"][0]["primitives"][0] = json!({"attributes": {"POSITION": 0}, "mode": 4});
    document["accessors"][0]["count"] = json!(6);
    document["bufferViews"] = json!([{"buffer": 0, "byteLength": 72}]);
    document["buffers"][0]["byteLength"] = json!(72);
    let (vertices, _, faces) = read(&glb(&document, &bin)).expect("a mesh");
    assert_eq!((vertices.as_slice(), faces.as_slice()), (&VERTICES[..], &FACES[..]));
    document["accessors"][0]["count"] = json!(5);
    assert!(failure(&glb(&document, &bin)).contains("three corners for each triangle, found 5 corners"));
}

#[test]
fn attributes_of_other_programs() {
    let mut document = square();
    let mut bin = bin();
    bin.resize(56, 0);
    for value in 0..16u16 {
        bin.extend((value * 1000).to_le_bytes());
    }
    for value in 0..4u16 {
        bin.extend(f32::from(value).to_le_bytes());
    }
    let attributes = json!({"POSITION": 0, "COLOR_0": 2, "_TEMPERATURE": 3, "_x": 3, "_BAD NAME": 3, "TEXCOORD_0": 9});
    document["meshes"][0]["primitives"][0]["attributes"] = attributes;
    let accessors = document["accessors"].as_array_mut().expect("a list");
    accessors.push(json!({"bufferView": 2, "componentType": 5123, "normalized": true, "count": 4, "type": "VEC4"}));
    accessors.push(json!({"bufferView": 2, "byteOffset": 32, "componentType": 5126, "count": 4, "type": "SCALAR"}));
    let views = document["bufferViews"].as_array_mut().expect("a list");
    views.push(json!({"buffer": 0, "byteOffset": 56, "byteLength": 48}));
    document["buffers"][0]["byteLength"] = json!(104);
    let mut reader = opened(&glb(&document, &bin)).expect("opens");
    let names = ["red", "green", "blue", "TEMPERATURE"];
    let channels = names.map(|name| Channel { name: name.to_string(), number: Number::F32 });
    assert_eq!(reader.attributes(), channels);
    assert_eq!(read_with(&mut reader).expect("a mesh").1[2], [8000.0, 9000.0, 10_000.0, 2.0]);
}

#[test]
fn attributes_are_what_all_primitives_have() {
    let mut document = square();
    let mut bin = bin();
    bin.resize(56, 0);
    bin.extend([10, 20, 30, 40]);
    bin.extend([0.5f32, 1.5, 2.5, 3.5].iter().flat_map(|v| v.to_le_bytes()));
    document["meshes"][0]["primitives"] = json!([
        {"attributes": {"POSITION": 0, "_one": 2, "_both": 2, "_own": 3}, "indices": 1},
        {"attributes": {"POSITION": 0, "_both": 3}, "indices": 1},
    ]);
    let accessors = document["accessors"].as_array_mut().expect("a list");
    accessors.push(json!({"bufferView": 2, "componentType": 5121, "count": 4, "type": "SCALAR"}));
    accessors.push(json!({"bufferView": 3, "componentType": 5126, "count": 4, "type": "SCALAR"}));
    let views = document["bufferViews"].as_array_mut().expect("a list");
    views.push(json!({"buffer": 0, "byteOffset": 56, "byteLength": 4}));
    views.push(json!({"buffer": 0, "byteOffset": 60, "byteLength": 16}));
    document["buffers"][0]["byteLength"] = json!(76);
    let mut reader = opened(&glb(&document, &bin)).expect("opens");
    assert_eq!(reader.attributes(), [Channel { name: "both".to_string(), number: Number::F32 }]);
    let (vertices, values, faces) = read_with(&mut reader).expect("a mesh");
    // Those of the first vertex at a place.
    assert_eq!((vertices.as_slice(), values.len()), (&VERTICES[..], 4));
    assert_eq!((values[1][0], faces), (20.0, [FACES, FACES].concat()));
    document["accessors"][2]["count"] = json!(3);
    let error = failure(&glb(&document, &bin));
    assert!(error.contains("expected as many as there are positions, 4, found 3 of _both"), "{error}");
}

#[test]
fn facts_hold_as_long_as_nobody_turns_the_mesh() {
    let mut document = square();
    let facts = ["map crs EPSG:32633", "offset 500 600", "precision float"];
    document["asset"]["extras"] = json!({"terrabite": {"facts": facts}});
    document["nodes"][0]["translation"] = json!([500, 0, -600]);
    let reader = opened(&glb(&document, &bin())).expect("opens");
    let header = reader.header();
    assert_eq!((header.frame.origin, header.made_by.as_ref()), ((500.0, 600.0), None));
    assert_eq!(header.crs.definition.as_deref(), Some("EPSG:32633"));
    // gltfpack adds the origin to the positions.
    document["nodes"][0] = json!({"mesh": 0});
    let reader = opened(&glb(&document, &bin())).expect("opens");
    assert_eq!(reader.header().frame, CoordinateFrame { single: true, ..CoordinateFrame::PLAIN });
    // Half a turn around the middle, and the mesh is on the map.
    document["nodes"][0] = json!({"mesh": 0, "translation": [500, 0, -600], "rotation": [0, 1, 0, 0]});
    let mut reader = opened(&glb(&document, &bin())).expect("opens");
    assert_eq!(reader.header().frame, CoordinateFrame::PLAIN);
    assert_eq!(read_with(&mut reader).expect("a mesh").0[2], [499.0, 599.0, 7.0]);
}

#[test]
fn documents_without_scenes_show_all_nodes() {
    let mut document = square();
    document["scenes"] = json!([]);
    document["nodes"] = json!([{"mesh": 0}, {"children": [0]}]);
    assert_eq!(read(&glb(&document, &bin())).expect("a mesh").2, FACES);
    document["nodes"] = json!([]);
    assert_eq!(read(&glb(&document, &bin())).expect("nothing").2.len(), 0);
}

#[test]
fn what_is_not_read_is_named() {
    let draco = json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}});
    let cases = [
        (
            "/meshes/0/primitives/0/extensions",
            draco,
            "mesh 0, primitive 0: expected a mesh without the extension KHR_draco",
        ),
        ("/extensionsRequired", json!(["KHR_draco_mesh_compression"]), "extension KHR_draco_mesh_compression"),
        ("/extensionsRequired", json!(["EXT_mesh_gpu_instancing"]), "extension EXT_mesh_gpu_instancing"),
        ("/accessors/0/componentType", json!(5122), "extension KHR_mesh_quantization"),
        ("/accessors/0/sparse", json!({"count": 1}), "accessor 0: expected an accessor that is not sparse"),
        ("/meshes/0/primitives/0/mode", json!(1), "mesh 0, primitive 0: expected triangles (mode 4), found mode 1"),
        (
            "/buffers/0/uri",
            json!("tin.bin"),
            "buffer 0: expected its data in the BIN chunk of this file, found the address \"tin.bin\"",
        ),
        ("/nodes/0/skin", json!(0), "node 0: expected a mesh at rest"),
        ("/asset/version", json!("1.0"), "asset: expected version 2, found 1.0"),
    ];
    for (pointer, value, expected) in cases {
        let error = failure(&with(pointer, value));
        assert!(error.contains(expected), "{pointer}: {error}");
    }
    for looks in ["KHR_materials_unlit", "KHR_texture_transform", "KHR_mesh_quantization"] {
        read(&with("/extensionsRequired", json!([looks]))).expect("a mesh");
    }
}

#[test]
fn lying_documents_name_the_place() {
    let cases = [
        ("/scene", json!(1), "scene: expected one of 1 scenes, counted from 0, found number 1"),
        ("/scenes/0/nodes", json!([0, 0]), "node 0: expected a node that one other has"),
        ("/nodes/0/children", json!([0]), "node 0: expected a node that one other has"),
        ("/nodes/0/mesh", json!(9), "node 0: expected one of 1 meshes"),
        (
            "/nodes/0/matrix",
            json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "node 0: expected a matrix whose last row",
        ),
        ("/meshes/0/primitives/0/indices", json!(7), "mesh 0, primitive 0: expected one of 2 accessors"),
        ("/meshes/0/primitives/0/attributes", json!({}), "expected positions (POSITION), found none"),
        ("/accessors/0/bufferView", json!(5), "accessor 0: expected one of 2 bufferViews"),
        ("/accessors/0/bufferView", Value::Null, "accessor 0: expected a bufferView, found none"),
        (
            "/accessors/0/count",
            json!(5),
            "accessor 0: expected elements within the 48 bytes of bufferView 0, found 5 of 12",
        ),
        ("/accessors/0/count", json!(u64::MAX), "accessor 0: expected elements within"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "accessor 0: expected elements within"),
        ("/accessors/0/type", json!("MAT4"), "accessor 0: expected SCALAR or a vector, found MAT4"),
        ("/accessors/0/type", json!("VEC2"), "expected positions of three numbers, found 2"),
        ("/accessors/1/componentType", json!(5126), "accessor 1: expected elements within"),
        ("/accessors/1/componentType", json!(5120), "expected indices that are single numbers without a sign"),
        ("/accessors/1/componentType", json!(1), "accessor 1: expected a component type, found 1"),
        ("/accessors/1/count", json!(5), "expected three corners for each triangle, found 5 corners"),
        ("/bufferViews/0/byteLength", json!(55), "bufferView 0: expected bytes within the 54 of buffer 0"),
        ("/bufferViews/0/byteOffset", json!(u64::MAX), "bufferView 0: expected bytes within the 54 of buffer 0"),
        ("/bufferViews/0/byteStride", json!(4), "bufferView 0: expected elements 12 to 256 bytes apart, found 4"),
        ("/bufferViews/0/buffer", json!(1), "bufferView 0: expected one of 1 buffers"),
        ("/buffers/0/byteLength", json!(57), "buffer 0: expected at most 56 bytes, those of the BIN chunk, found 57"),
        ("/nodes", json!(7), "JSON chunk (from byte 20 on): invalid type"),
    ];
    for (pointer, value, expected) in cases {
        let error = failure(&with(pointer, value));
        assert!(error.contains("tin.glb: ") && error.contains(expected), "{pointer}: {error}");
    }
    let mut bin = bin();
    bin[50] = 4;
    let error = failure(&glb(&square(), &bin));
    assert!(error.ends_with("mesh 0, primitive 0, face 0: expected vertices 0 to below 4, found 4"), "{error}");
}

#[test]
fn damaged_containers_name_the_byte() {
    let whole = glb(&square(), &bin());
    let json = u32::from_le_bytes(whole[12..16].try_into().expect("four")) as usize;
    let broken = |at: usize, bytes: &[u8]| {
        let mut broken = whole.clone();
        broken[at..at + bytes.len()].copy_from_slice(bytes);
        failure(&broken)
    };
    let cases = [
        (broken(0, b"glTf"), "byte 0: expected glTF"),
        (broken(4, &[1]), "byte 4: expected version 2, found 1"),
        (broken(8, &[0; 4]), "expected 20 bytes"),
        (broken(11, &[1]), "the end of the file"),
        (broken(12, &[0xff; 4]), "byte 12: expected a chunk of at most"),
        (broken(16, b"BIN\0"), "byte 16: expected JSON, the first chunk, found \"BIN\\0\""),
        (broken(20, b"]"), "JSON chunk (from byte 20 on): expected value at line 1 column 1"),
        (broken(20 + json, &[0xff]), "expected a chunk of at most 56 bytes"),
        (broken(24 + json, b"BUN\0"), "buffer 0: expected its data in the BIN chunk, found none"),
        (failure(&whole[..whole.len() - 1]), "the end of the file"),
        (failure(&[]), "the end of the file after 0"),
    ];
    for (error, expected) in cases {
        assert!(error.contains(expected), "{expected}: {error}");
    }
    // What comes after the length that the file says is no part of it.
    read(&[whole.as_slice(), b"more"].concat()).expect("a mesh");
}

#[test]
fn a_file_that_changes_is_noticed() {
    let whole = glb(&square(), &bin());
    let (_folder, path) = file(&whole);
    let mut reader = GlbReader::open(&path, &ReadOptions::default()).expect("opens");
    read_with(&mut reader).expect("a mesh");
    std::fs::write(&path, &whole[..whole.len() - 2]).expect("shortened");
    let error = read_with(&mut reader).expect_err("changed").to_string();
    assert!(error.contains("has been changed"), "{error}");
}

/// The square, compressed: positions with a filter, and indices as a sequence.
fn packed() -> (Value, Vec<u8>) {
    let exponential = meshopt::encode_filter_exp(&POSITIONS, 15, meshopt::EncodeExpMode::Separate);
    let positions = meshopt::encode_vertex_buffer_level(&exponential, 2, Some(0)).expect("encoded");
    let indices = meshopt::encode_index_sequence(&[0, 1, 2, 0, 2, 3], 4).expect("encoded");
    let mut document = square();
    document["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    let view = |offset: usize, length: usize, stride: u64, count: u64, mode: &str, filter: &str| {
        json!({"buffer": 1, "byteLength": stride * count, "extensions": {"EXT_meshopt_compression": {
            "buffer": 0, "byteOffset": offset, "byteLength": length, "byteStride": stride, "count": count, "mode": mode,
            "filter": filter,
        }}})
    };
    document["accessors"][1]["componentType"] = json!(5123);
    document["bufferViews"] = json!([
        view(0, positions.len(), 12, 4, "ATTRIBUTES", "EXPONENTIAL"),
        view(positions.len(), indices.len(), 2, 6, "INDICES", "NONE"),
    ]);
    let bin = [positions, indices].concat();
    document["buffers"] = json!([
        {"byteLength": bin.len()},
        {"byteLength": 60, "extensions": {"EXT_meshopt_compression": {"fallback": true}}},
    ]);
    (document, bin)
}

#[test]
fn compressed_views_of_other_programs() {
    let (document, bin) = packed();
    let (vertices, _, faces) = read(&glb(&document, &bin)).expect("a mesh");
    assert_eq!((vertices.as_slice(), faces.as_slice()), (&VERTICES[..], &FACES[..]));
    let cases = [
        (
            "filter",
            json!("OCTAHEDRAL"),
            "expected a view compressed without a filter, or with EXPONENTIAL, found the filter OCT",
        ),
        ("mode", json!("SOMEHOW"), "expected the mode ATTRIBUTES, TRIANGLES or INDICES, and no filter, found SOMEHOW"),
        ("mode", json!("TRIANGLES"), "expected the mode"),
        ("byteStride", json!(260), "expected a byteStride that goes with the mode, found 260"),
        ("count", json!(3), "expected elements of 48 bytes in all, found 3 of 12 bytes"),
        ("count", json!(u64::MAX), "expected elements of 48 bytes in all"),
        ("byteOffset", json!(1), "compressed, from byte"),
        ("byteLength", json!(u64::MAX), "bufferView 0: expected bytes within"),
        ("buffer", json!(1), "buffer 1: expected its data in the BIN chunk, found none"),
    ];
    for (key, value, expected) in cases {
        let mut lying = document.clone();
        lying["bufferViews"][0]["extensions"]["EXT_meshopt_compression"][key] = value;
        let error = failure(&glb(&lying, &bin));
        assert!(error.contains(expected), "{key}: {error}");
    }
    let mut lying = document.clone();
    lying["bufferViews"][0]["byteLength"] = json!(1u64 << 40);
    lying["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["byteStride"] = json!(256);
    lying["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["count"] = json!(1u64 << 32);
    let error = failure(&glb(&lying, &bin));
    assert!(error.contains("expected a view of at most"), "{error}");
}
