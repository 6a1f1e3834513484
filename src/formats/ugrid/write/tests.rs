//! UGRID files byte for byte, and when they become CDF-5.

use super::*;
use crate::base::CoordinateFrame;
use crate::base::channels::Channel;
use crate::formats::{Crs, ReadError, ReadOptions};

const VERTICES: [[f64; 3]; 3] = [[0.5, -0.5, 1.25], [2.5, -0.5, -7.0], [0.5, -4.5, 1e-3]];

fn sink(folder: &tempfile::TempDir, header: Header) -> UgridSink {
    let staged = StagedFile::create(&folder.path().join("tin.nc"), false, &[]).expect("staged");
    UgridSink::new(staged, Setup { header, loss: f64::INFINITY, ..Setup::default() })
}

fn written(header: Header, attributes: &[Channel], values: &[&[f64]]) -> Vec<u8> {
    let folder = crate::testing::folder();
    let mut sink = sink(&folder, header);
    sink.begin(&Contents { vertices: 3, triangles: 1, attributes, ..Contents::default() }).expect("begun");
    sink.vertices(&VERTICES, values).expect("written");
    sink.triangles(&[[0, 2, 1]], &[]).expect("written");
    Box::new(sink).finish().expect("finished");
    std::fs::read(folder.path().join("tin.nc")).expect("a file")
}

fn on_the_map(unit: &str) -> Header {
    let text = |text: &str| Some(text.to_string());
    let crs = Crs { definition: text("EPSG:32633"), unit: text(unit), ..Crs::default() };
    Header { crs, made_by: text("terrabite 1"), source: text("dem.tif"), ..Header::default() }
}

fn contains(bytes: &[u8], text: &str) -> bool {
    bytes.windows(text.len()).any(|found| found == text.as_bytes())
}

#[test]
fn a_mesh_byte_for_byte_behind_its_head() {
    let red = Channel { name: "red".to_string(), number: Number::U8 };
    let bytes = written(on_the_map("metre"), &[red], &[&[0.0, 255.0, 7.0]]);
    assert!(bytes.starts_with(b"CDF\x02\0\0\0\0\0\0\0\x0a\0\0\0\x03\0\0\0\x0dmesh2d_nNodes\0\0\0\0\0\0\x03"));
    let mut expected = Vec::new();
    for i in 0..3 {
        VERTICES.iter().for_each(|vertex| expected.extend(vertex[i].to_be_bytes()));
    }
    expected.extend([0.0f32, 255.0, 7.0].map(f32::to_be_bytes).as_flattened());
    expected.extend([0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 1]);
    assert!(bytes.ends_with(&expected));
    let facts = "made by terrabite 1\nsource dem.tif\ncrs:EPSG:32633";
    for text in ["CF-1.8 UGRID-1.0", "TIN of dem.tif", facts, "mesh_topology", "projection_x_coordinate", "altitude"] {
        assert!(contains(&bytes, text), "{text}");
    }
    assert!(contains(&bytes, "EPSG_code") && contains(&bytes, "original_type"));
}

#[test]
fn degrees_are_longitudes() {
    let bytes = written(on_the_map("degree"), &[], &[]);
    assert!(contains(&bytes, "degrees_east") && contains(&bytes, "latitude_longitude"));
    let frame = CoordinateFrame { origin: (1.0, 2.0), xy_scale: (7e4, 1e5), ..CoordinateFrame::PLAIN };
    let bytes = written(Header { frame, ..on_the_map("degree") }, &[], &[]);
    assert!(!contains(&bytes, "degrees_east") && !contains(&bytes, "EPSG_code"));
    assert!(contains(&bytes, "projection_x_coordinate") && contains(&bytes, "map crs EPSG:32633"));
}

#[test]
fn single_precision_takes_half() {
    let frame = CoordinateFrame { single: true, ..CoordinateFrame::PLAIN };
    let bytes = written(Header { frame, ..Header::default() }, &[], &[]);
    let singles: Vec<u8> =
        (0..3).flat_map(|i| VERTICES.map(|vertex| (vertex[i] as f32).to_be_bytes())).flatten().collect();
    assert!(bytes[..bytes.len() - 12].ends_with(&singles));
}

#[test]
fn names_of_the_mesh_are_not_taken() {
    for (name, written) in
        [("red", "red"), ("mesh2d_node_x", "attribute_mesh2d_node_x"), ("attribute_a", "attribute_attribute_a")]
    {
        let channel = Channel { name: name.to_string(), number: Number::F32 };
        assert_eq!(words::attribute(&Header::default(), &channel, Type::Float).name, written);
    }
}

#[test]
fn what_is_too_large_for_cdf_2_is_cdf_5() {
    let folder = crate::testing::folder();
    let sink = sink(&folder, Header::default());
    let red = [Channel { name: "red".to_string(), number: Number::U8 }];
    let file =
        |vertices, triangles| sink.file(&Contents { vertices, triangles, attributes: &red, ..Contents::default() });
    let numbers = |file: &File| [file.variables[4].number, file.variables[5].number].to_vec();
    // Doubles of nodes, then faces of 12 bytes, reach 4 GiB.
    for (vertices, triangles, version) in [
        (3, 1, Version::Offset64),
        ((1 << 29) - 1, 1, Version::Offset64),
        (1 << 29, 1, Version::Data64),
        (3, 357_913_941, Version::Offset64),
        (3, 357_913_942, Version::Data64),
    ] {
        let file = file(vertices, triangles);
        assert_eq!(file.version, version, "{vertices} {triangles}");
        assert_eq!(numbers(&file), [Type::Float, Type::Int]);
    }
    let large = file(1 << 31, 1 << 33);
    assert_eq!(numbers(&large), [Type::Float, Type::Int64]);
    let (head, places) = large.head();
    assert!(head.starts_with(b"CDF\x05\0\0\0\0\0\0\0\0\0\0\0\x0a\0\0\0\0\0\0\0\x03"));
    assert_eq!(places[5], (head.len() as u64 + 4 + 28 * (1 << 31), 24 << 33));
}

/// A file of CDF-5 is large, so one is put together by hand.
#[test]
fn the_head_of_a_cdf_5_is_read() {
    let folder = crate::testing::folder();
    let header = Header { notes: vec!["by hand".to_string()], ..on_the_map("metre") };
    let red = [Channel { name: "red".to_string(), number: Number::U8 }];
    let contents = Contents { vertices: 3, triangles: 1, attributes: &red, ..Contents::default() };
    let (mut bytes, places) = sink(&folder, header.clone()).file_of(Version::Data64, &contents).head();
    assert_eq!(places[0].0, bytes.len() as u64);
    bytes.resize(bytes.len() + 8, 0);
    (0..3).for_each(|i| VERTICES.iter().for_each(|vertex| bytes.extend(vertex[i].to_be_bytes())));
    bytes.extend([1.0f32, 2.0, 255.0].map(f32::to_be_bytes).as_flattened());
    bytes.extend([0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 1]);
    let path = folder.path().join("tin.nc");
    std::fs::write(&path, bytes).expect("written");
    let mut mesh = crate::formats::open(&path, None, &ReadOptions::default()).expect("a mesh");
    assert_eq!((mesh.header().notes.clone(), mesh.attributes()), (header.notes, red.as_slice()));
    mesh.for_each_vertex_with(&["red"], |i, place, found| {
        assert_eq!((place, found), (VERTICES[i as usize], &[[1.0, 2.0, 255.0][i as usize]][..]));
        Ok::<(), ReadError>(())
    })
    .expect("vertices");
    mesh.for_each_face(|_, face| {
        assert_eq!(face, [0, 2, 1]);
        Ok::<(), ReadError>(())
    })
    .expect("faces");
}

#[test]
fn no_dimension_is_without_an_end() {
    let folder = crate::testing::folder();
    let refused = sink(&folder, Header::default()).begin(&Contents { vertices: 3, ..Contents::default() });
    assert!(
        refused
            .expect_err("refused")
            .to_string()
            .ends_with("expected vertices and triangles, found 3 vertices and 0 triangles")
    );
}
